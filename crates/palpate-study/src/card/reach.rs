//! Renderable contacts on the device of a report: a coarse map with its properties.

use std::time::Instant;

use palpate_scene::Model;
use palpate_scene::method::MethodName;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use serde::Serialize;

use super::device::DeviceCard;
use crate::advise::{FAITHFUL_PERCENT, Reach};
use crate::map::{
    Bounce, BounceDevice, BounceError, Class, Limit, MapParams, PHASES, Plant, default_settings,
};

/// Range of kappa or Kc in which a limit is searched, and steps per decade.
const SEARCHED: (f64, f64) = (1e-3, 10.0);
const PER_DECADE: i32 = 4;

/// Halvings of the last step, on a logarithmic scale, for the wall and for the object in the table.
const HALVINGS: u32 = 3;

/// Object masses relative to the device's, and their number per decade.
const MASSES: (f64, f64) = (0.01, 100.0);
const MASSES_PER_DECADE: i32 = 1;

/// Renderable contacts on a device.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ReachCard {
    /// Mass of the simulated device `[kg]`.
    pub device_mass_kg: f64,
    /// Period of its loop `[s]`.
    pub period_s: f64,
    /// Delay of its loop `[s]`.
    pub delay_s: f64,
    /// Lag of its motor `[s]`.
    pub lag_s: f64,
    /// Standard deviation of the delay in the renderer's model `[s]`.
    pub delay_deviation_s: f64,
    /// Standard deviation of the lag in the renderer's model `[s]`.
    pub lag_deviation_s: f64,
    /// Viscous friction `[N s/m]`.
    pub viscous_friction_n_s_per_m: f64,
    /// Quantum of its position sensor `[m]`.
    pub sensor_quantum_m: f64,
    /// Keys of unknown properties, assumed to be 0.
    pub assumed: Vec<&'static str>,
    /// First and last tried kappa or Kc.
    pub searched: [f64; 2],
    /// Ratio of successive search steps: the resolution of the limits over the object's mass.
    pub step: f64,
    /// Ratio for the stiffest wall and the lightest object, whose last step is halved.
    pub finest_step: f64,
    /// Number of start heights of each bounce.
    pub start_heights: usize,
    /// Number of simulated contacts, each from all start heights by one method.
    pub contacts: usize,
    /// Computing time `[s]`.
    pub computed_in_s: f64,
    /// Maximum mean-force error E and maximum hold bound of a good contact `[%]`.
    pub good_below_percent: f64,
    /// Object masses of the limits `[kg]`.
    pub object_masses_kg: Vec<f64>,
    /// Stiffness for the search of the lightest object `[N/m]`.
    pub stiffness_n_per_m: f64,
    /// One entry for each method.
    pub methods: Vec<MethodReachCard>,
}

/// Limits of a method. Stable: no bounce gains more than 1 % of energy from any start height. Good: stable, with
/// small E and hold bound, and steady at rest and pressed in a hand.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MethodReachCard {
    /// The method.
    pub method: &'static str,
    /// Maximum stiffness of a stable wall `[N/m]`.
    pub stable_wall_n_per_m: Reach,
    /// Maximum stiffness of a good wall `[N/m]`.
    pub good_wall_n_per_m: Reach,
    /// Minimum mass of a stable object at the requested stiffness `[kg]`.
    pub stable_object_kg: Reach,
    /// Minimum mass of a good object at that stiffness `[kg]`.
    pub good_object_kg: Reach,
    /// Maximum stiffness of a stable contact, per object mass `[N/m]`.
    pub stable_n_per_m: Vec<Reach>,
    /// Maximum stiffness of a good contact, per object mass `[N/m]`.
    pub good_n_per_m: Vec<Reach>,
}

/// Contacts from the easiest to the hardest. `of` returns the searched quantity and the contact of a hardness.
struct Line<'a> {
    hardness: &'a [f64],
    of: &'a (dyn Fn(f64) -> (f64, Bounce) + Sync),
    halvings: u32,
}

/// The hardest stable and the hardest good contact of a line.
struct Limits {
    stable: Reach,
    good: Reach,
    contacts: usize,
}

impl ReachCard {
    /// Returns the number of lines of contacts of a method: the wall, the object, then the masses of the figure.
    pub(super) fn lines() -> usize {
        2 + steps(MASSES, MASSES_PER_DECADE).len()
    }

    /// Computes the limits with the properties of `device`; `None` if its mass or its period is unknown. Calls `done`
    /// after each line of each method.
    pub(super) fn new(
        device: &DeviceCard,
        deviations: &Model,
        stiffness: f64,
        methods: &[MethodName],
        done: impl Fn() + Sync,
    ) -> Result<Option<Self>, BounceError> {
        let begun = Instant::now();
        let Some(properties) = Properties::of(device) else {
            return Ok(None);
        };
        let masses: Vec<f64> = steps(MASSES, MASSES_PER_DECADE)
            .iter()
            .map(|share| share * properties.mass)
            .collect();
        let bounce = properties.bounce(deviations, stiffness);
        let found = search_limits(&bounce, &masses, methods, done)?;
        let methods = method_cards(methods, &found);
        let step = 10.0_f64.powf(1.0 / f64::from(PER_DECADE));
        Ok(Some(Self {
            device_mass_kg: properties.mass,
            period_s: properties.period,
            delay_s: properties.delay,
            lag_s: properties.lag,
            delay_deviation_s: deviations.delay_deviation.unwrap_or(0.0),
            lag_deviation_s: deviations.lag_deviation.unwrap_or(0.0),
            viscous_friction_n_s_per_m: properties.viscous,
            sensor_quantum_m: properties.quantum,
            assumed: properties.assumed,
            searched: [SEARCHED.0, SEARCHED.1],
            step,
            finest_step: step.powf(0.5_f64.powi(HALVINGS.cast_signed())),
            start_heights: PHASES,
            contacts: found.iter().map(|limits| limits.contacts).sum(),
            good_below_percent: FAITHFUL_PERCENT,
            object_masses_kg: masses,
            stiffness_n_per_m: stiffness,
            methods,
            computed_in_s: begun.elapsed().as_secs_f64(),
        }))
    }
}

/// Properties of a device that the limits depend on.
pub(super) struct Properties {
    /// Mass of the device `[kg]`.
    pub(super) mass: f64,
    /// Period of its loop `[s]`.
    pub(super) period: f64,
    /// Delay of its loop `[s]`.
    delay: f64,
    /// Lag of its motor `[s]`.
    lag: f64,
    /// Viscous friction `[N s/m]`.
    viscous: f64,
    /// Quantum of its position sensor `[m]`.
    quantum: f64,
    /// Keys of unknown properties, assumed to be 0.
    assumed: Vec<&'static str>,
}

impl Properties {
    /// Returns the properties of `device`; `None` if its mass or its period is unknown.
    pub(super) fn of(device: &DeviceCard) -> Option<Self> {
        let (Some(mass), Some(period)) = (device.value("device_mass_kg"), device.value("period_s"))
        else {
            return None;
        };
        let mut assumed = Vec::new();
        let mut known = |key: &'static str| {
            device.value(key).unwrap_or_else(|| {
                assumed.push(key);
                0.0
            })
        };
        // The renderer divides every command by the modelled gain, so the limits do not depend on it.
        let (delay, lag) = (known("delay_s"), known("lag_s"));
        let viscous = known("viscous_friction_n_s_per_m");
        let quantum = known("sensor_quantum_m");
        Some(Self {
            mass,
            period,
            delay,
            lag,
            viscous,
            quantum,
            assumed,
        })
    }

    /// Returns the bounce of a wall of `stiffness` `[N/m]` on the device.
    pub(super) fn bounce(&self, deviations: &Model, stiffness: f64) -> Bounce {
        let map = MapParams::default();
        Bounce {
            device: BounceDevice {
                mass: self.mass,
                viscous_friction: self.viscous,
                coulomb_friction: 0.0,
                encoder_quantum: self.quantum,
                model_mass: 1.0,
            },
            stiffness,
            object_mass: f64::INFINITY,
            forces: map.forces,
            gap: map.gap,
            period: self.period,
            model_period: 1.0,
            delay: self.delay / self.period,
            lag: self.lag,
            model: *deviations,
        }
    }
}

/// Searches the limits of every line of every method, in this order: the wall, the object at the stiffness of `bounce`,
/// then the object masses `[kg]`. Calls `done` after each line.
fn search_limits(
    bounce: &Bounce,
    masses: &[f64],
    methods: &[MethodName],
    done: impl Fn() + Sync,
) -> Result<Vec<Limits>, BounceError> {
    let bounce = *bounce;
    let (mass, period) = (bounce.device.mass, bounce.period);
    let per_kappa = mass / (period * period);
    let heaviest = bounce.stiffness * period * period;
    let searched = steps(SEARCHED, PER_DECADE);
    let stiffer = |object_mass: f64| {
        move |kappa: f64| {
            let stiffness = kappa * per_kappa;
            let bounce = Bounce {
                stiffness,
                object_mass,
                ..bounce
            };
            (stiffness, bounce)
        }
    };
    let lighter = |object_kappa: f64| {
        let object_mass = heaviest / object_kappa;
        let bounce = Bounce {
            object_mass,
            ..bounce
        };
        (object_mass, bounce)
    };
    let tasks: Vec<(MethodName, usize)> = methods
        .iter()
        .flat_map(|method| (0..ReachCard::lines()).map(|line| (*method, line)))
        .collect();
    tasks
        .into_par_iter()
        .map(|(method, line)| {
            let object_mass = line.checked_sub(2).map_or(f64::INFINITY, |at| masses[at]);
            let stiffer = stiffer(object_mass);
            let line = Line {
                hardness: &searched,
                of: if line == 1 { &lighter } else { &stiffer },
                halvings: if line < 2 { HALVINGS } else { 0 },
            };
            let limits = line.limits(|bounce, ask_good| evaluate(bounce, method, ask_good));
            done();
            limits
        })
        .collect()
}

/// Returns the limits of each method from those of all lines.
fn method_cards(methods: &[MethodName], found: &[Limits]) -> Vec<MethodReachCard> {
    let of_methods = found.chunks(ReachCard::lines());
    let of_methods = methods.iter().zip(of_methods).map(|(method, of)| {
        let all = |limit: fn(&Limits) -> Reach| of[2..].iter().map(limit).collect();
        MethodReachCard {
            method: method.name(),
            stable_wall_n_per_m: of[0].stable,
            good_wall_n_per_m: of[0].good,
            stable_object_kg: of[1].stable,
            good_object_kg: of[1].good,
            stable_n_per_m: all(|limits| limits.stable),
            good_n_per_m: all(|limits| limits.good),
        }
    });
    of_methods.collect()
}

/// Returns logarithmically spaced values from the first to the last.
fn steps((first, last): (f64, f64), per_decade: i32) -> Vec<f64> {
    #[expect(clippy::cast_possible_truncation, reason = "a few decades")]
    let decades = (last / first).log10().round() as i32;
    (0..=decades * per_decade)
        .map(|step| first * 10.0_f64.powf(f64::from(step) / f64::from(per_decade)))
        .collect()
}

/// Evaluation of a method on a contact.
#[derive(Clone, Copy)]
struct Evaluated {
    is_stable: bool,
    is_good: bool,
}

/// Evaluates `method` on a bounce, and whether it is good only if `ask_good`. Returns `None` if the bounce is too
/// long for a simulation.
fn evaluate(
    bounce: &Bounce,
    method: MethodName,
    ask_good: bool,
) -> Result<Option<Evaluated>, BounceError> {
    let settings = default_settings(method);
    let entry = match bounce.evaluate(Plant::Damped, &[(method, settings)]) {
        Ok((entries, _)) => entries[0],
        Err(BounceError::TooLong(_)) => return Ok(None),
        Err(error) => return Err(error),
    };
    let is_stable = entry.class() == Class::Stable;
    let is_near = is_stable
        && entry.error.worst < FAITHFUL_PERCENT
        && entry.hold_bound.median < FAITHFUL_PERCENT;
    let is_good = ask_good && is_near && {
        let (stay, _) = bounce.stay(method, settings)?;
        stay.rests() && stay.is_steady_pressed()
    };
    Ok(Some(Evaluated { is_stable, is_good }))
}

impl Line<'_> {
    /// Returns the last contact before the first unstable one, and before the first that is not good. Contacts at the
    /// easy end without a result are skipped.
    fn limits<E>(
        &self,
        evaluate: impl Fn(&Bounce, bool) -> Result<Option<Evaluated>, E>,
    ) -> Result<Limits, E> {
        let mut contacts = 0;
        let mut ask = |hardness: f64, ask_good: bool| {
            contacts += 1;
            evaluate(&(self.of)(hardness).1, ask_good)
        };
        let (mut stable, mut good) = (Search::default(), Search::default());
        for hardness in self.hardness {
            let Some(evaluated) = ask(*hardness, good.is_open())? else {
                continue;
            };
            good.next(*hardness, evaluated.is_good);
            stable.next(*hardness, evaluated.is_stable);
            if !stable.is_open() {
                break;
            }
        }
        for _ in 0..self.halvings {
            if let Some(middle) = stable.middle() {
                let evaluated = ask(middle, false)?;
                stable.halve(
                    middle,
                    evaluated.is_some_and(|evaluated| evaluated.is_stable),
                );
            }
            if let Some(middle) = good.middle() {
                let evaluated = ask(middle, true)?;
                good.halve(middle, evaluated.is_some_and(|evaluated| evaluated.is_good));
            }
        }
        let limit = |search: &Search| search.limit(|hardness| (self.of)(hardness).0);
        Ok(Limits {
            stable: limit(&stable),
            good: limit(&good),
            contacts,
        })
    }
}

/// Search for the limit of a property, starting at the easy end.
#[derive(Default)]
struct Search {
    last: Option<f64>,
    fails: Option<f64>,
}

impl Search {
    fn is_open(&self) -> bool {
        self.fails.is_none()
    }

    fn next(&mut self, hardness: f64, is: bool) {
        match (self.is_open(), is) {
            (true, true) => self.last = Some(hardness),
            (true, false) => self.fails = Some(hardness),
            (false, _) => {}
        }
    }

    fn middle(&self) -> Option<f64> {
        Some((self.last? * self.fails?).sqrt())
    }

    fn halve(&mut self, middle: f64, is: bool) {
        if is {
            self.last = Some(middle);
        } else {
            self.fails = Some(middle);
        }
    }

    fn limit(&self, of: impl Fn(f64) -> f64) -> Reach {
        let limit = match (self.last, self.fails) {
            (None, _) => Limit::None,
            (Some(last), Some(_)) => Limit::At(of(last)),
            (Some(last), None) => Limit::Beyond(of(last)),
        };
        limit.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    fn bounce() -> Bounce {
        let params = MapParams::default();
        params.cell(0).bounce
    }

    /// Returns the limits of a line whose contacts are `stable` and `good` up to these values, and unknown below
    /// `known`.
    fn found(known: f64, stable: f64, good: f64, halvings: u32) -> [(Option<f64>, bool); 2] {
        let of = |hardness: f64| {
            let bounce = Bounce {
                stiffness: hardness,
                ..bounce()
            };
            (10.0 * hardness, bounce)
        };
        let line = Line {
            hardness: &[1.0, 2.0, 4.0, 8.0],
            of: &of,
            halvings,
        };
        let limits = line.limits(|bounce, ask_good| {
            let evaluated = Evaluated {
                is_stable: bounce.stiffness <= stable,
                is_good: ask_good && bounce.stiffness <= good,
            };
            Ok::<_, Infallible>((bounce.stiffness >= known).then_some(evaluated))
        });
        let Ok(limits) = limits;
        [limits.stable, limits.good].map(|limit| (limit.value, limit.or_beyond))
    }

    #[test]
    fn a_limit_is_the_last_before_the_first_that_fails() {
        assert_eq!(
            found(0.0, 5.0, 3.0, 0),
            [(Some(40.0), false), (Some(20.0), false)]
        );
        assert_eq!(found(0.0, 9.0, 0.5, 0), [(Some(80.0), true), (None, false)]);
        assert_eq!(found(1.5, 2.5, 2.5, 0), [(Some(20.0), false); 2]);
        assert_eq!(found(0.0, 0.5, 0.5, 3), [(None, false); 2]);
    }

    #[test]
    fn halvings_close_in_on_the_end() {
        for edge in [2.1, 3.0, 3.9] {
            let [(stable, _), (good, _)] = found(0.0, 10.0 * edge, edge, 6);
            assert_eq!(stable, Some(80.0));
            let good = good.unwrap() / 10.0;
            assert!(good <= edge && edge < 1.02 * good, "{edge}: {good}");
        }
    }

    #[test]
    fn steps_reach_from_end_to_end() {
        let steps = steps((1e-3, 10.0), 4);
        assert_eq!(steps.len(), 17);
        assert!((steps[16] - 10.0).abs() < 1e-9);
    }
}
