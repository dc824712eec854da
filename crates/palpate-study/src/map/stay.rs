//! Sustained contact: whether an object on a held device, or a pressed one, comes to rest.

use palpate_core::{AnyRenderer, ObjectState};
use palpate_testbed::measure::Sampler;
use palpate_testbed::sprung_mass::SprungMass;

use super::bounce::{Bounce, BounceError};
use crate::sim::ticks::{TickedDevice, TicksParams, Way};
use palpate_scene::method::{MethodName, Settings};
use palpate_scene::{Grip, Hand, Intention};

/// Largest standard deviation of the force of a contact at rest, relative to the pressing force.
pub const RESTS_BELOW: f64 = 0.1;

/// Force that presses a contact `[N]`.
pub const PRESSED_WITH: f64 = 3.0;

/// Force that presses a tapped contact, and the limit of its force, the default of a loop `[N]`. A blow is clipped by
/// it.
const TAPPED_WITH: f64 = 13.0;
const FORCE_LIMIT: f64 = 20.0;

/// Distances of a tapped device from its equilibrium `[m]`.
const TAPS: [f64; 3] = [2e-4, 5e-4, 1e-3];

/// Hands that hold the device, light and firm: mass `[kg]`, stiffness `[N/m]`, damping `[N s/m]`.
const HANDS: [(f64, f64, f64); 2] = [(0.05, 300.0, 3.0), (0.1, 400.0, 20.0)];

/// Gravity on the object `[m/s²]`.
const GRAVITY: f64 = 9.81;

/// Initial distance from the equilibrium, relative to the spring's deflection there. An ideal contact keeps or loses
/// the resulting oscillation: 7 % standard deviation.
const BEGINS_OFF: f64 = 0.1;

/// Simulated time of a contact `[s]`, with the minimum and maximum number of samples.
const FOLLOWED: f64 = 20.0;
const SAMPLES: (f64, f64) = (2000.0, 20_000.0);

/// Evaluated part of the samples, at the end.
const LOOKED_AT: f64 = 0.2;

/// Ratio of force to pressing force above which a contact has diverged.
const DIVERGED_ABOVE: f64 = 1000.0;

/// Ratio of mean force to pressing force below which a contact is lost. A flying object has no force, hence no
/// oscillation of it.
const LOST_BELOW: f64 = 0.5;

/// A hand that holds the device: mass `[kg]`, stiffness `[N/m]`, damping `[N s/m]`.
type HandOnDevice = (f64, f64, f64);

/// Steadiness of a contact: standard deviation of its force relative to the pressing force, in the worse hand.
/// Infinite if the contact is lost, or if the force exceeds a thousand times the pressing force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stay {
    /// Value of an object that rests on the device under its weight; none for a wall.
    pub resting: Option<f64>,
    /// Value of a pressed object or wall.
    pub pressed: f64,
}

impl Stay {
    /// Whether the object comes to rest, or is a wall.
    #[must_use]
    pub fn rests(&self) -> bool {
        self.resting.is_none_or(|swing| swing < RESTS_BELOW)
    }

    /// Whether the pressed contact is steady.
    #[must_use]
    pub fn is_steady_pressed(&self) -> bool {
        self.pressed < RESTS_BELOW
    }

    /// Returns the parameters of the evaluation besides the scene, as keys and texts of metadata.
    #[must_use]
    pub fn criterion() -> Vec<(&'static str, String)> {
        let hands = HANDS
            .map(|(mass, stiffness, damping)| format!("{mass} kg {stiffness} N/m {damping} N s/m"));
        vec![
            ("steady_below_swing", RESTS_BELOW.to_string()),
            ("resting_gravity_m_per_s2", GRAVITY.to_string()),
            ("pressed_with_n", PRESSED_WITH.to_string()),
            ("stay_hands", hands.join(", ")),
            ("stay_begins_off", BEGINS_OFF.to_string()),
            ("stay_followed_s", FOLLOWED.to_string()),
            ("stay_fewest_samples", SAMPLES.0.to_string()),
            ("stay_most_samples", SAMPLES.1.to_string()),
            ("stay_part_looked_at", LOOKED_AT.to_string()),
            ("stay_diverged_above", DIVERGED_ABOVE.to_string()),
            ("stay_lost_below", LOST_BELOW.to_string()),
        ]
    }
}

impl Bounce {
    /// Simulates the contact near its equilibrium in a light and in a firm hand. Returns its steadiness and the
    /// number of ticks.
    ///
    /// # Errors
    /// The bench or the method rejects a parameter.
    pub fn stay(&self, method: MethodName, settings: Settings) -> Result<(Stay, u64), BounceError> {
        let renderer = self.renderer(method, settings)?;
        let mut ticks = 0;
        let mut worse = |force: f64| {
            HANDS.into_iter().try_fold(0.0, |worst: f64, hand| {
                let off = -(1.0 + BEGINS_OFF) * force / self.stiffness;
                let swing = self.swing(&renderer, (force, off), hand, &mut ticks)?;
                Ok::<_, BounceError>(swing.max(worst))
            })
        };
        let resting = if self.is_wall() {
            None
        } else {
            Some(worse(GRAVITY * self.object_mass)?)
        };
        let pressed = worse(PRESSED_WITH)?;
        Ok((Stay { resting, pressed }, ticks))
    }

    /// Simulates a contact that a hand taps, and presses on, so that the limit of the force clips the blow. Returns the
    /// standard deviation of the force relative to the pressing force, in the worse hand, as [`Stay`] has it.
    ///
    /// # Errors
    /// The bench or the method rejects a parameter.
    pub fn tapped(&self, method: MethodName, settings: Settings) -> Result<f64, BounceError> {
        let renderer = self.limited_renderer(method, settings, Some(FORCE_LIMIT))?;
        let mut ticks = 0;
        let taps = HANDS
            .into_iter()
            .flat_map(|hand| TAPS.map(|tap| (hand, tap)));
        taps.into_iter().try_fold(0.0, |worst: f64, (hand, tap)| {
            let tapped = (TAPPED_WITH, tap - TAPPED_WITH / self.stiffness);
            let swing = self.swing(&renderer, tapped, hand, &mut ticks)?;
            Ok(swing.max(worst))
        })
    }

    /// Returns the standard deviation of the force relative to `force` `[N]`, which presses device and object
    /// together from a distance `[m]`.
    fn swing(
        &self,
        renderer: &AnyRenderer<f64>,
        (force, from): (f64, f64),
        hand: HandOnDevice,
        ticks: &mut u64,
    ) -> Result<f64, BounceError> {
        let device = &self.device;
        if device.coulomb_friction == 0.0 {
            let (mass, stiffness, damping) = hand;
            // It takes a tenth of the time of the general device.
            let sprung = SprungMass::new(
                device.mass + mass,
                stiffness,
                device.viscous_friction + damping,
                force,
            )?;
            return self.swing_of(sprung.into(), renderer, (force, from), ticks);
        }
        self.swing_of(self.general(force, hand)?, renderer, (force, from), ticks)
    }

    /// Returns the device in a hand, with dry friction.
    fn general(
        &self,
        force: f64,
        (mass, stiffness, damping): HandOnDevice,
    ) -> Result<TickedDevice, BounceError> {
        let mut scene = self.scene(0.0, 1);
        if let Some(device) = scene.device.point_mass_mut() {
            device.hand = Hand {
                grip: Some(Grip {
                    mass,
                    stiffness,
                    damping,
                    intention: Intention::at(0.0),
                }),
                ..Hand::pushing(force)
            };
        }
        Ok(TickedDevice::new(&scene)?)
    }

    /// Returns the standard deviation on a device in its hand.
    fn swing_of(
        &self,
        device: TickedDevice,
        renderer: &AnyRenderer<f64>,
        (force, from): (f64, f64),
        ticks: &mut u64,
    ) -> Result<f64, BounceError> {
        let quantum = self.device.encoder_quantum;
        let params = TicksParams {
            renderer,
            object: ObjectState::at_rest(from),
            virtual_force: if self.is_wall() { 0.0 } else { -force },
            sampler: if quantum > 0.0 {
                Sampler::quantum(quantum)?
            } else {
                Sampler::Ideal
            },
            way: Way::new(self.delay, self.lag)?,
            period: self.period,
        };
        let mut in_progress = params.on(device)?;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "2000 to 20 000"
        )]
        let samples = (FOLLOWED / self.period).clamp(SAMPLES.0, SAMPLES.1) as usize;
        let first = (1.0 - LOOKED_AT) * samples as f64;
        let mut swing = SwingMeter::new(force);
        for i in 0..samples {
            let tick = in_progress.tick();
            *ticks += 1;
            swing.hold(tick.held, i as f64 >= first);
            if tick.output.fault.is_some() {
                swing.give_up();
            }
            if swing.has_diverged() {
                break;
            }
        }
        Ok(swing.swing())
    }
}

/// Accumulates the force statistics of a contact without storing samples.
#[derive(Clone, Copy, Debug)]
struct SwingMeter {
    /// Force that presses the contact `[N]`.
    force: f64,
    /// The first evaluated force `[N]`. Deviations are relative to it, so a constant force has deviation 0 without
    /// round-off.
    first: f64,
    sum: f64,
    square: f64,
    count: f64,
    diverged: bool,
}

impl SwingMeter {
    fn new(force: f64) -> Self {
        Self {
            force,
            first: 0.0,
            sum: 0.0,
            square: 0.0,
            count: 0.0,
            diverged: false,
        }
    }

    /// Adds the force `[N]` held from a sample on; `counts` marks evaluated samples.
    #[inline]
    fn hold(&mut self, held: f64, counts: bool) {
        // The comparison is false for NaN, which also counts as diverged.
        let bounded = held.abs() <= DIVERGED_ABOVE * self.force;
        self.diverged |= !bounded;
        if counts {
            if self.count == 0.0 {
                self.first = held;
            }
            let off = held - self.first;
            self.sum += off;
            self.square += off * off;
            self.count += 1.0;
        }
    }

    /// Marks the loop as diverged for a reason other than its force.
    fn give_up(&mut self) {
        self.diverged = true;
    }

    fn has_diverged(&self) -> bool {
        self.diverged
    }

    /// Returns the standard deviation relative to the pressing force.
    fn swing(&self) -> f64 {
        let off = self.sum / self.count;
        // Without evaluated samples this is also false.
        let stays = self.first + off >= LOST_BELOW * self.force;
        if self.diverged || !stays {
            return f64::INFINITY;
        }
        (self.square / self.count - off * off).max(0.0).sqrt() / self.force
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{MapParams, default_settings};

    fn swing_of(forces: impl IntoIterator<Item = f64>) -> f64 {
        let mut meter = SwingMeter::new(2.0);
        // Forces before the evaluated part must be bounded and have no other effect.
        meter.hold(-1999.0, false);
        for force in forces {
            meter.hold(force, true);
        }
        meter.swing()
    }

    #[test]
    fn a_swing_is_the_standard_deviation_over_what_presses() {
        assert_eq!(swing_of([2.0, 2.0, 2.0]), 0.0);
        assert!((swing_of([1.0, 3.0, 1.0, 3.0]) - 0.5).abs() < 1e-15);
        // A constant force taken by the hand's spring does not oscillate.
        assert_eq!(swing_of([2.2, 2.2]), 0.0);
        let turn = |i: i32| 2.0 + 0.02 * (f64::from(i) * std::f64::consts::TAU / 100.0).sin();
        let swing = swing_of((0..500).map(turn));
        assert!((swing - 0.01 / 2.0_f64.sqrt()).abs() < 1e-12, "{swing}");
    }

    #[test]
    fn a_contact_that_is_lost_does_not_rest() {
        assert_eq!(swing_of([0.0, 0.0, 0.0]), f64::INFINITY);
        assert_eq!(swing_of([0.9, 0.9]), f64::INFINITY);
        assert_eq!(swing_of([]), f64::INFINITY);
        let stay = Stay {
            resting: Some(f64::INFINITY),
            pressed: f64::INFINITY,
        };
        assert!(!stay.rests() && !stay.is_steady_pressed());
    }

    #[test]
    fn a_force_without_bounds_is_not_forgotten() {
        for wrong in [2001.0, -2001.0, f64::NAN, f64::INFINITY] {
            let mut meter = SwingMeter::new(2.0);
            meter.hold(wrong, false);
            assert!(meter.has_diverged());
            meter.hold(2.0, true);
            assert_eq!(meter.swing(), f64::INFINITY, "{wrong}");
        }
    }

    #[test]
    fn the_fast_device_swings_as_the_general_one() {
        let params = MapParams {
            cells: 5,
            ..MapParams::default()
        };
        // kappa = Kc = 0.1; a wall of kappa 0.1; kappa = 1 on an object of the device's mass.
        for index in [15, 12, 22] {
            let bounce = params.cell(index).bounce;
            for method in [MethodName::HfcrModSt, MethodName::VirtualDamper] {
                let renderer = bounce.renderer(method, default_settings(method)).unwrap();
                for hand in HANDS {
                    let mut ticks = 0;
                    let pressed = (3.0, -3.3 / bounce.stiffness);
                    let fast = bounce.swing(&renderer, pressed, hand, &mut ticks).unwrap();
                    let general = bounce.general(3.0, hand).unwrap();
                    let general = bounce
                        .swing_of(general, &renderer, pressed, &mut ticks)
                        .unwrap();
                    assert_eq!(ticks, 4000);
                    assert!(
                        (fast - general).abs() < 1e-9 || fast.min(general) > 0.5,
                        "{index}, {method}: {fast} {general}"
                    );
                }
            }
        }
    }

    /// A blow on a clipped wall of kappa 1 ends, and one on a light object finds a swing that the mere pressure does
    /// not.
    #[test]
    fn a_tap_shows_what_pressing_does_not() {
        let (mass, period) = (0.2, 1e-3);
        let on = |kappa: f64, object_mass: f64| {
            let of_map = MapParams::default().cell(0).bounce;
            Bounce {
                device: crate::map::BounceDevice {
                    mass,
                    viscous_friction: 0.0,
                    ..of_map.device
                },
                stiffness: kappa * mass / (period * period),
                object_mass,
                period,
                ..of_map
            }
        };
        let swings = |bounce: Bounce, method| {
            let settings = default_settings(method);
            let pressed = bounce.stay(method, settings).unwrap().0.pressed;
            (pressed, bounce.tapped(method, settings).unwrap())
        };
        let (pressed, tapped) = swings(on(1.0, f64::INFINITY), MethodName::Coupled);
        assert!(pressed < 1e-3 && tapped < 1e-3, "{pressed} {tapped}");
        // 70 N/m in a hand of 400 N/m: the hand does not take the force of a soft wall.
        let (pressed, tapped) = swings(on(3.5e-4, f64::INFINITY), MethodName::Coupled);
        assert!(pressed < 1e-3 && tapped < 1e-3, "{pressed} {tapped}");
        let (pressed, tapped) = swings(on(3.0, 0.05), MethodName::Hfcr);
        assert!(pressed < 0.01 && tapped > 0.5, "{pressed} {tapped}");
    }
}
