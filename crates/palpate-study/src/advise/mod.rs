//! Advice: can this device render a contact, and by which method?

mod question;
mod text;

pub use question::Question;
pub use text::too_coarse;

use crate::map::{Bounce, BounceError, Class, Entry, Limit, Plant, Stay, bounds, default_settings};
use crate::tune::tunable;
use palpate_scene::Delay;
use palpate_scene::method::{MethodName, SettingKey, Settings};
use rayon::prelude::*;
use serde::Serialize;

/// Name and version of the JSON report.
const FORMAT: &str = "palpate advise 2";

/// Largest mean-force error of a faithful rendering, E `[%]`.
pub const FAITHFUL_PERCENT: f64 = 20.0;

/// A method with the settings of the trial, and its damping if the trial sets one.
type Trial = (MethodName, Settings, Option<f64>);

/// Number of dampings tried for each method with a damping.
const TRIED: usize = 24;

/// Advice on a device, and on a contact if one is requested.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Advice {
    /// Name and version of this JSON.
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    pub format: &'static str,
    /// The device.
    pub device: DeviceReport,
    /// Requested contact; none if only limits are requested.
    pub contact: Option<ContactReport>,
    /// The answer.
    pub verdict: Verdict,
    /// One entry for each method.
    pub methods: Vec<MethodAdvice>,
    /// Classical bounds of walls.
    pub bounds: Bounds,
    /// Files that were written.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
}

/// The device of the advice, and the bounce on it.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct DeviceReport {
    /// Effective mass `[kg]`.
    pub mass_kg: f64,
    /// Period of the loop `[s]`.
    pub period_s: f64,
    /// Viscous friction `[N s/m]`.
    pub viscous_friction_n_s_per_m: f64,
    /// Coulomb friction `[N]`.
    pub coulomb_friction_n: f64,
    /// Quantum of the position sensor `[m]`.
    pub encoder_quantum_m: f64,
    /// Delay of the loop in whole samples.
    pub delay_samples: usize,
    /// Fraction of a period by which the delay is longer; omitted if 0.
    #[serde(skip_serializing_if = "is_zero")]
    pub delay_fraction: f64,
    /// Time constant of the actuator's lag `[s]`; omitted if 0.
    #[serde(skip_serializing_if = "is_zero")]
    pub lag_s: f64,
    /// Standard deviation of the delay in the renderer's model `[s]`; omitted if 0.
    #[serde(skip_serializing_if = "is_zero")]
    pub delay_deviation_s: f64,
    /// Standard deviation of the lag in the renderer's model `[s]`; omitted if 0.
    #[serde(skip_serializing_if = "is_zero")]
    pub lag_deviation_s: f64,
    /// Standard deviation of the gain in the renderer's model, relative to the gain; omitted if 0.
    #[serde(skip_serializing_if = "is_zero")]
    pub gain_deviation: f64,
    /// Standard deviation of the sensor noise in the renderer's model `[m]`; omitted if 0.
    #[serde(skip_serializing_if = "is_zero")]
    pub sensor_noise_m: f64,
    /// Maximum contact stiffness that the first resonance allows `[N/m]`; omitted if no resonance is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffest_by_resonance_n_per_m: Option<f64>,
    /// Object mass M of the limit search `[kg]`; none for a wall.
    pub object_mass_kg: Option<f64>,
    /// Gap from which the object falls `[m]`.
    pub gap_m: f64,
    /// Number of start heights.
    pub start_heights: usize,
}

/// The requested contact.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ContactReport {
    /// Stiffness of the contact `[N/m]`.
    pub stiffness_n_per_m: f64,
    /// K T²/m.
    pub kappa: f64,
    /// Kc = K T²/M; 0 for a wall.
    pub object_kappa: f64,
    /// Change of the spring force per encoder count.
    pub force_per_count_n: f64,
    /// Zero-order-hold bound: minimum FRE of any held force, median over the start heights `[%]`.
    pub hold_bound_percent: f64,
}

/// The verdict and the method that it is based on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case", tag = "answer")]
pub enum Verdict {
    /// Stable and faithful, steady at rest and pressed, with a sufficiently low hold bound.
    Yes {
        /// The method.
        method: &'static str,
        /// Its damping or cap `[N s/m]`; none if the method chooses it or has none.
        damping_n_s_per_m: Option<f64>,
    },
    /// Bounces stably, but oscillates at rest or pressed.
    Swings {
        /// The method.
        method: &'static str,
        /// Its damping or cap `[N s/m]`; none if the method chooses it or has none.
        damping_n_s_per_m: Option<f64>,
        /// Whether it oscillates at rest on the device.
        resting: bool,
        /// Whether it oscillates when pressed.
        pressed: bool,
    },
    /// As good as a held force can be, but far from the ideal at this rate.
    HoldTooCoarse {
        /// The method.
        method: &'static str,
        /// Its damping or cap `[N s/m]`; none if the method chooses it or has none.
        damping_n_s_per_m: Option<f64>,
    },
    /// Stable, but with a large error.
    StableOnly {
        /// The method.
        method: &'static str,
        /// Its damping or cap `[N s/m]`; none if the method chooses it or has none.
        damping_n_s_per_m: Option<f64>,
    },
    /// Stiffer than the device's first resonance allows; the trials do not model the resonance.
    TooFlexible {
        /// Maximum contact stiffness of the device `[N/m]`.
        stiffest_n_per_m: f64,
    },
    /// No method is stable.
    No {
        /// The method.
        method: &'static str,
        /// Growth of the energy per collision from the worst start height; none if it diverged.
        growth: Option<f64>,
    },
    /// No contact was requested.
    NotAsked,
}

/// Results of a method on the device.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MethodAdvice {
    /// Name of the method.
    pub method: &'static str,
    /// Result with the default settings of the method.
    pub by_itself: Option<Evaluated>,
    /// Result with the best of the tried dampings.
    pub tuned: Option<Evaluated>,
    /// Maximum stiffness of a stable contact `[N/m]`.
    pub stiffest_n_per_m: Reach,
    /// Minimum mass of a stable object `[kg]`; none if no contact was requested.
    pub lightest_kg: Option<Reach>,
}

/// Evaluation of a method on the requested contact.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct Evaluated {
    /// The damping B, b or cap that was set; none if the method chose it.
    pub damping_n_s_per_m: Option<f64>,
    /// `stable`, `growing` or `diverged`.
    pub class: &'static str,
    /// Median and worst over the start heights; none if a loop diverged.
    pub growth: [Option<f64>; 2],
    /// Mean-force error E, median and worst over the start heights `[%]`.
    pub error_percent: [Option<f64>; 2],
    /// Standard deviation of the force at rest, relative to the weight. None for a wall, for a diverged loop, and for
    /// bounces that gain energy, whose rest is not simulated.
    pub resting_swing: Option<f64>,
    /// Standard deviation of the pressed force, relative to the pressing force: the larger one of a contact under 3 N,
    /// and of one that is tapped with 13 N from 0.2, 0.5 and 1 mm under a force limit of 20 N.
    pub pressed_swing: Option<f64>,
    /// Sustained contacts.
    #[serde(skip)]
    stay: Option<Stay>,
    /// Sort key of evaluations.
    #[serde(skip)]
    rank: (Class, f64),
}

/// A limit of a method.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Reach {
    /// None if not even the easiest contact is stable.
    pub value: Option<f64>,
    /// Whether all tried contacts are stable, so that the limit is beyond the search range.
    pub or_beyond: bool,
}

/// Classical bounds of the wall stiffness on the device.
#[derive(Debug, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct Bounds {
    /// Colgate and Schenkel: K < 2 b/T without virtual damping `[N/m]`.
    pub colgate_schenkel_n_per_m: f64,
    /// Gil et al., with a delay; a lag is added to the delay `[N/m]`.
    pub gil_n_per_m: f64,
    /// Abbott and Okamura, with Coulomb friction and an encoder `[N/m]`.
    pub abbott_okamura_n_per_m: f64,
    /// Undamped device with the best virtual damper.
    pub undamped_wall_n_per_m: f64,
    /// The damping of that virtual damper `[N s/m]`.
    pub undamped_wall_damping_n_s_per_m: f64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl Advice {
    /// Adds a written file.
    pub fn wrote(&mut self, path: &std::path::Path) {
        self.files.push(path.display().to_string());
    }

    /// Sets the maximum contact stiffness that the device's first resonance allows `[N/m]`. The trials assume a rigid
    /// device, so a stiffer contact cannot get a positive verdict.
    pub fn bounded_by_a_resonance(&mut self, stiffest: f64) {
        self.device.stiffest_by_resonance_n_per_m = Some(stiffest);
        let is_beyond = |contact: &ContactReport| contact.stiffness_n_per_m > stiffest;
        if self.contact.as_ref().is_some_and(is_beyond)
            && !matches!(self.verdict, Verdict::No { .. })
        {
            self.verdict = Verdict::TooFlexible {
                stiffest_n_per_m: stiffest,
            };
        }
    }

    /// Computes the limits of `methods` on the device of `bounce`, and their results at its stiffness if `asked`, on
    /// all processors. Calls `done` after each method.
    pub fn on(
        bounce: &Bounce,
        asked: bool,
        methods: &[MethodName],
        done: impl Fn() + Sync,
    ) -> Result<Self, BounceError> {
        let device = &bounce.device;
        let (m, t) = (device.mass, bounce.period);
        let delay = Delay::of_periods(bounce.delay);
        let mut advice = Self {
            format: FORMAT,
            device: DeviceReport {
                mass_kg: m,
                period_s: t,
                viscous_friction_n_s_per_m: device.viscous_friction,
                coulomb_friction_n: device.coulomb_friction,
                encoder_quantum_m: device.encoder_quantum,
                delay_samples: delay.whole_samples(),
                delay_fraction: delay.fraction(),
                lag_s: bounce.lag,
                delay_deviation_s: bounce.model.delay_deviation.unwrap_or(0.0),
                lag_deviation_s: bounce.model.lag_deviation.unwrap_or(0.0),
                gain_deviation: bounce.model.gain_deviation.unwrap_or(0.0),
                sensor_noise_m: bounce.model.sensor_noise.unwrap_or(0.0),
                stiffest_by_resonance_n_per_m: None,
                object_mass_kg: Some(bounce.object_mass).filter(|mass| mass.is_finite()),
                gap_m: bounce.gap,
                start_heights: crate::map::PHASES,
            },
            contact: None,
            verdict: Verdict::NotAsked,
            methods: Vec::new(),
            bounds: Bounds::new(bounce),
            files: Vec::new(),
        };
        let limits = |method: &MethodName| -> Result<MethodAdvice, BounceError> {
            let settings = default_settings(*method);
            let (stiffest, lightest) = rayon::join(
                || bounce.stiffest(*method, settings),
                || asked.then(|| bounce.lightest(*method, settings)),
            );
            done();
            Ok(MethodAdvice {
                method: method.name(),
                by_itself: None,
                tuned: None,
                stiffest_n_per_m: stiffest?.into(),
                lightest_kg: lightest.transpose()?.map(Reach::from),
            })
        };
        advice.methods = methods.par_iter().map(limits).collect::<Result<_, _>>()?;
        if asked {
            advice.evaluate(bounce, methods)?;
        }
        Ok(advice)
    }

    /// Evaluates the requested contact.
    fn evaluate(&mut self, bounce: &Bounce, methods: &[MethodName]) -> Result<(), BounceError> {
        let impedance = bounce.stiffness * bounce.period;
        let mut trials: Vec<Trial> = Vec::new();
        for method in methods {
            trials.push((*method, default_settings(*method), None));
            for (settings, damping) in dampings(*method, impedance) {
                trials.push((*method, settings, Some(damping)));
            }
        }
        let settings: Vec<_> = trials.iter().map(|(m, s, _)| (*m, *s)).collect();
        let (entries, _) = bounce.evaluate(Plant::Damped, &settings)?;
        let reference = |((method, settings, damping), entry): (&Trial, &Entry)| {
            // Bounces that gain energy rule a method out, so its contact at rest is not simulated.
            let stay = match entry.class() {
                Class::Stable => {
                    let (stay, _) = bounce.stay(*method, *settings)?;
                    let tapped = bounce.tapped(*method, *settings)?;
                    Some(Stay {
                        pressed: stay.pressed.max(tapped),
                        ..stay
                    })
                }
                Class::Growing | Class::Diverged => None,
            };
            Ok((*method, Evaluated::new(entry, *damping, stay)))
        };
        let trials = trials.par_iter().zip(&entries).map(reference);
        let evaluated: Vec<(MethodName, Evaluated)> = trials.collect::<Result<_, BounceError>>()?;
        for advice in &mut self.methods {
            let of_method = evaluated.iter().filter(|(m, _)| m.name() == advice.method);
            let (tuned, by_itself): (Vec<Evaluated>, Vec<Evaluated>) = of_method
                .map(|(_, evaluated)| *evaluated)
                .partition(|evaluated| evaluated.damping_n_s_per_m.is_some());
            advice.by_itself = by_itself.first().copied();
            advice.tuned =
                best(tuned.iter().map(|evaluated| (advice.method, *evaluated))).map(|b| b.1);
        }
        let (period, floor) = (bounce.period, entries[0].hold_bound.median);
        self.contact = Some(ContactReport {
            stiffness_n_per_m: bounce.stiffness,
            kappa: bounce.stiffness * period * period / bounce.device.mass,
            object_kappa: bounce.stiffness * period * period / bounce.object_mass,
            force_per_count_n: bounce.stiffness * bounce.device.encoder_quantum,
            hold_bound_percent: floor,
        });
        if let Some((method, found)) = recommended(evaluated.iter().map(|(m, j)| (m.name(), *j))) {
            let damping_n_s_per_m = found.damping_n_s_per_m;
            let stable = found.rank.0 == Class::Stable;
            self.verdict = match found.stay {
                Some(stay) if stable && !found.is_steady() => Verdict::Swings {
                    method,
                    damping_n_s_per_m,
                    resting: !stay.rests(),
                    pressed: !stay.is_steady_pressed(),
                },
                _ if found.is_faithful() && floor >= FAITHFUL_PERCENT => Verdict::HoldTooCoarse {
                    method,
                    damping_n_s_per_m,
                },
                _ if found.is_faithful() => Verdict::Yes {
                    method,
                    damping_n_s_per_m,
                },
                _ if stable => Verdict::StableOnly {
                    method,
                    damping_n_s_per_m,
                },
                _ => Verdict::No {
                    method,
                    growth: found.growth[1],
                },
            };
        }
        Ok(())
    }

    /// Returns the evaluation that the verdict is based on.
    #[must_use]
    pub fn chosen(&self) -> Option<(&'static str, Evaluated)> {
        recommended(self.evaluated())
    }

    /// Returns the evaluation nearest to the ideal, if it is not the chosen one.
    #[must_use]
    pub fn nearer(&self) -> Option<(&'static str, Evaluated)> {
        let (_, chosen) = self.chosen()?;
        best(self.evaluated())
            .filter(|(_, evaluated)| evaluated.is_faithful() && evaluated.rank.1 < chosen.rank.1)
    }

    fn evaluated(&self) -> impl Iterator<Item = (&'static str, Evaluated)> + Clone {
        self.methods.iter().flat_map(|advice| {
            let evaluated = advice.by_itself.iter().chain(&advice.tuned);
            evaluated.map(|evaluated| (advice.method, *evaluated))
        })
    }
}

/// Returns coupled rendering with its defaults if it is faithful, because it needs no tuning and is also valid away
/// from this scene. Otherwise returns the best method.
fn recommended(
    evaluated: impl Iterator<Item = (&'static str, Evaluated)> + Clone,
) -> Option<(&'static str, Evaluated)> {
    let coupled = MethodName::Coupled.name();
    let mut by_itself = evaluated.clone().filter(|(method, _)| *method == coupled);
    by_itself
        .find(|(_, evaluated)| evaluated.is_faithful())
        .or_else(|| best(evaluated))
}

/// Returns the most stable evaluation; ties go to one that is steady at rest and pressed, then to the lowest error
/// from the worst start height.
fn best(
    evaluated: impl Iterator<Item = (&'static str, Evaluated)>,
) -> Option<(&'static str, Evaluated)> {
    evaluated.min_by(|(_, a), (_, b)| {
        (a.rank.0.cmp(&b.rank.0))
            .then(b.is_steady().cmp(&a.is_steady()))
            .then(a.rank.1.total_cmp(&b.rank.1))
    })
}

/// Returns the dampings to try, up to values known to be too large.
fn dampings(method: MethodName, impedance: f64) -> Vec<(Settings, f64)> {
    let Some(setting) = tunable(method) else {
        return Vec::new();
    };
    let (most, first) = match (setting.key, method) {
        (SettingKey::DAMPING_CAP, _) => (8.0 * impedance, 1),
        (_, MethodName::VirtualDamper) => (2.0 * impedance, 1),
        _ => (impedance, 0),
    };
    (first..=TRIED)
        .map(|step| {
            // The spacing is finer at small values.
            let share = step as f64 / TRIED as f64;
            let value = most * share * share;
            (Settings::default().with(setting.key, value), value)
        })
        .collect()
}

impl Evaluated {
    fn new(entry: &Entry, damping: Option<f64>, stay: Option<Stay>) -> Self {
        let finite = |value: f64| Some(value).filter(|value| value.is_finite());
        let class = entry.class();
        Self {
            damping_n_s_per_m: damping,
            class: match class {
                Class::Stable => "stable",
                Class::Growing => "growing",
                Class::Diverged => "diverged",
            },
            growth: [finite(entry.growth.median), finite(entry.growth.worst)],
            error_percent: [finite(entry.error.median), finite(entry.error.worst)],
            resting_swing: stay.and_then(|stay| stay.resting).and_then(finite),
            pressed_swing: stay.and_then(|stay| finite(stay.pressed)),
            stay,
            rank: (class, entry.error.worst),
        }
    }
}

impl Evaluated {
    /// Whether it is stable with a small error from every start height, and steady.
    fn is_faithful(&self) -> bool {
        self.rank.0 == Class::Stable && self.rank.1 < FAITHFUL_PERCENT && self.is_steady()
    }

    /// Whether the contact comes to rest on the device and when pressed.
    fn is_steady(&self) -> bool {
        self.stay
            .is_some_and(|stay| stay.rests() && stay.is_steady_pressed())
    }
}

impl From<Limit> for Reach {
    fn from(limit: Limit) -> Self {
        let (value, or_beyond) = match limit {
            Limit::None => (None, false),
            Limit::At(value) => (Some(value), false),
            Limit::Beyond(value) => (Some(value), true),
        };
        Self { value, or_beyond }
    }
}

impl Bounds {
    fn new(bounce: &Bounce) -> Self {
        let device = &bounce.device;
        let (m, t) = (device.mass, bounce.period);
        let per_kappa = m / (t * t);
        let damping = device.viscous_friction * t / m;
        Self {
            colgate_schenkel_n_per_m: per_kappa * bounds::colgate_schenkel(damping, 0.0),
            gil_n_per_m: per_kappa
                * bounds::gil(damping, 0.0, bounce.delay + bounce.lag / bounce.period),
            abbott_okamura_n_per_m: bounds::abbott_okamura(
                device.viscous_friction,
                device.coulomb_friction,
                t,
                device.encoder_quantum,
            ),
            undamped_wall_n_per_m: per_kappa * bounds::stiffest_undamped_wall(),
            undamped_wall_damping_n_s_per_m: bounds::best_undamped_damping() * m / t,
        }
    }
}
