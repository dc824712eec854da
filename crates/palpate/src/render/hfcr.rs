//! HFCR, the paper's method: energy-consistent rendering of contact forces.

use super::method::{Ended, Method, MethodParams, Plan, Situation};
use crate::Scalar;
use crate::contact::{Contact, LoopParams, Mass};
use crate::motion::{Displacement, ObjectMotion, Rule, Start};
use crate::parameter::{ParameterError, not_negative, positive};
use crate::predict::{Observer, ObserverParams, Seen};

/// Device displacements shorter than this `[m]` are taken as 0 where the force divides by them.
const STANDSTILL: f64 = 1e-9;

/// Damping b of the leak dissipation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum LeakDissipation<S> {
    /// None.
    #[default]
    Off,
    /// A fixed b `[N s/m]`, not below 0.
    Damping(S),
    /// The least b that cancels the leak while (kappa) is small,
    /// `K^2 T^3 / (4 m) * M / (m + M)` with m the device's effective mass.
    ///
    /// It cancels leak, which is not the same as force error: on an undamped point mass it takes
    /// the mean-force error of the paper's first experiment from 14.7 % to 14.9 %, and that of
    /// the second from 102 % to 85 %.
    Auto {
        /// Effective mass m of the device `[kg]`, greater than 0.
        device_mass: S,
    },
}

/// How HFCR predicts where the device will be at the next sample, xi~.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: Scalar + serde::Serialize",
        deserialize = "S: Scalar + serde::Deserialize<'de>"
    ))
)]
pub enum Prediction<S> {
    /// At the velocity of its last step, as in the paper: `xi~ = 2 xi_i - xi_{i-1}`.
    #[default]
    ConstantVelocity,
    /// By an observer of its motion, at the acceleration it has now. There to be compared: what
    /// the force about to be held will do to the device is still left out.
    Observer {
        /// Effective mass of the device, within a factor of 2 `[kg]`.
        device_mass: Mass<S>,
        /// Quantum of the position sensor `[m]`, 0 if it is not known to have one.
        encoder_quantum: S,
    },
}

/// Parameters of HFCR: its three steps, independently on or off. The default has the first two
/// on and no dissipation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: Scalar + serde::Serialize",
        deserialize = "S: Scalar + serde::Deserialize<'de>"
    ))
)]
pub struct HfcrParams<S> {
    /// Modified contact force, Eq. (9), in place of the spring force K p_i.
    pub modified_force: bool,
    /// Contact begins and ends where it is predicted to within the interval, and not at samples.
    pub smooth_transition: bool,
    /// Damping that takes the remaining leak out, Eq. (11).
    pub leak_dissipation: LeakDissipation<S>,
    /// Where the device is taken to be at the next sample.
    pub prediction: Prediction<S>,
}

impl<S> Default for HfcrParams<S> {
    fn default() -> Self {
        Self {
            modified_force: true,
            smooth_transition: true,
            leak_dissipation: LeakDissipation::Off,
            prediction: Prediction::ConstantVelocity,
        }
    }
}

impl<S> HfcrParams<S> {
    /// Only the modified force: `hfcr-mod` of the program.
    pub fn modified_force_only() -> Self {
        Self {
            smooth_transition: false,
            ..Self::default()
        }
    }

    /// All three steps, with damping `b` `[N s/m]`.
    pub fn with_damping(b: S) -> Self {
        Self {
            leak_dissipation: LeakDissipation::Damping(b),
            ..Self::default()
        }
    }
}

/// HFCR: a held force whose work equals the change of the object's stored energy, if the device
/// moves on at constant velocity.
///
/// The stored energy carries the work of the virtual force, which the paper's Eq. (8) leaves out.
/// With it Eq. (9) has closed forms that need no division by the device's displacement.
#[derive(Clone, Copy, Debug)]
pub struct Hfcr<S> {
    modified_force: bool,
    smooth_transition: bool,
    damping: S,
    observer: Option<ObserverParams<S>>,
}

/// What HFCR remembers: nothing, unless an observer predicts.
#[derive(Clone, Copy, Debug, Default)]
pub struct HfcrMemory<S>(Option<Followed<S>>);

/// The device, as an observer follows it.
#[derive(Clone, Copy, Debug)]
struct Followed<S> {
    observer: Observer<S>,
    /// Force held over the last interval `[N]`.
    held_force: S,
    /// Mean velocity predicted for the interval in progress `[m/s]`.
    velocity: S,
}

impl<S: Scalar> Hfcr<S> {
    /// Damping b of the leak dissipation `[N s/m]`, as given or as computed from the device's
    /// mass.
    pub fn damping(&self) -> S {
        self.damping
    }
}

impl<S: Scalar> MethodParams<S> for HfcrParams<S> {
    type Method = Hfcr<S>;

    fn check(
        self,
        contact: &Contact<S>,
        loop_params: &LoopParams<S>,
    ) -> Result<Self::Method, ParameterError> {
        let damping = match self.leak_dissipation {
            LeakDissipation::Off => S::ZERO,
            LeakDissipation::Damping(b) => not_negative("damping", "N s/m", b)?,
            LeakDissipation::Auto { device_mass } => {
                positive("device_mass", "kg", device_mass)?;
                let (k, t) = (contact.stiffness, loop_params.period);
                let wall = k * k * t * t * t / (S::from_f64(4.0) * device_mass);
                let damping = match contact.object_mass {
                    Mass::Infinite => wall,
                    Mass::Finite(mass) => wall * mass / (device_mass + mass),
                };
                not_negative("derived damping", "N s/m", damping)?
            }
        };
        Ok(Hfcr {
            modified_force: self.modified_force,
            smooth_transition: self.smooth_transition,
            damping,
            observer: match self.prediction {
                Prediction::ConstantVelocity => None,
                Prediction::Observer {
                    device_mass,
                    encoder_quantum,
                } => Some(ObserverParams::new(device_mass, encoder_quantum)?),
            },
        })
    }
}

impl<S: Scalar> Method<S> for Hfcr<S> {
    type Memory = HfcrMemory<S>;

    #[inline]
    fn conclude(
        &self,
        motion: &ObjectMotion<S>,
        ended: &Ended<S>,
        memory: &mut HfcrMemory<S>,
    ) -> Displacement<S> {
        let (Some(params), Some(followed)) = (&self.observer, &mut memory.0) else {
            return ended.as_planned(motion);
        };
        followed.observer.see(
            params,
            &Seen {
                moved: ended.device_moved,
                elapsed: ended.elapsed,
                held_force: ended.held_force,
            },
        );
        followed.held_force = ended.held_force;
        let start = Start {
            device_velocity: followed.velocity,
            ..ended.start
        };
        Ended { start, ..*ended }.as_planned(motion)
    }

    #[inline]
    fn plan(
        &self,
        motion: &ObjectMotion<S>,
        now: &Situation<'_, S>,
        memory: &mut HfcrMemory<S>,
    ) -> Plan<S> {
        let mut start = now.start;
        if let Some(params) = &self.observer {
            let followed = memory.0.get_or_insert_with(|| Followed {
                observer: Observer::new(params),
                held_force: S::ZERO,
                velocity: S::ZERO,
            });
            let device = followed.observer.motion;
            let (travel, _) = device.under(followed.held_force, motion.period());
            start.device_velocity = (device.offset + travel) / motion.period();
            followed.velocity = start.device_velocity;
        }
        let start = &start;
        let period = motion.period();
        let k = motion.stiffness();
        let p = start.penetration;
        // d = xi~ - xi_i with the paper's prediction xi~ = 2 xi_i - xi_{i-1}.
        let d = start.device_velocity * period;

        // Modified force, rule, displacement, and the part of the interval spent in contact.
        let (modified, rule, moved, share) = if now.in_contact() {
            let pressed = motion.press(start);
            if p + d - pressed.by > S::ZERO {
                let force = k * (p + S::HALF * d - pressed.by);
                (force, Rule::Contact, pressed, S::ONE)
            } else if self.smooth_transition {
                let after = motion.release(start);
                let rule = Rule::Leaves(after);
                let share = after / period;
                let force = -S::HALF * k * d * share * share;
                (force, rule, motion.advance(rule, start, period), share)
            } else {
                // Predicted out: the device takes back all that the held spring still stores.
                let left = p - pressed.by;
                let force = if d.abs() < S::from_f64(STANDSTILL) {
                    k * left.max(S::ZERO)
                } else {
                    -S::HALF * k * left * (left / d)
                };
                (force, Rule::Contact, pressed, S::ONE)
            }
        } else {
            match motion.entry(start).filter(|_| self.smooth_transition) {
                None => {
                    let flown = motion.fly(start, period);
                    (S::ZERO, Rule::Free, flown, S::ZERO)
                }
                Some(after) => {
                    let rule = Rule::Enters(after);
                    let moved = motion.advance(rule, start, period);
                    let waiting = after / period;
                    let share = S::ONE - waiting;
                    // Mean of where the device touches and where it is predicted to end.
                    let device = S::HALF * d * (S::ONE + waiting);
                    (share * k * (p + device - moved.by), rule, moved, share)
                }
            }
        };
        let elastic = if self.modified_force {
            modified
        } else {
            now.spring_force(motion)
        };
        // Eq. (11).
        let dissipating = share * self.damping * (start.device_velocity - start.object_velocity);
        Plan {
            force: elastic + dissipating,
            rule,
            moved,
        }
    }
}
