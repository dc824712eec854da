//! Closed-form motion of the virtual object over one interval of the loop.
//!
//! All quantities are relative to the interval's start: the object's displacement and final velocity follow from the
//! penetration, so a distant origin costs no precision. Device and object are in canonical coordinates
//! ([`Side::Positive`](crate::Side)).

use crate::Scalar;
use crate::contact::{Contact, Mass};
use crate::transition::{entry_instant, release_instant};

/// Position and velocity of the virtual object.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct ObjectState<S> {
    /// Position of the object's surface eta `[m]`.
    pub position: S,
    /// Velocity eta' `[m/s]`; 0 for a wall.
    pub velocity: S,
}

impl<S: Scalar> ObjectState<S> {
    /// Creates an object at rest at `position` `[m]`.
    pub fn at_rest(position: S) -> Self {
        Self {
            position,
            velocity: S::ZERO,
        }
    }
}

/// Motion rule of the object within an interval. The device is held at its sampled position, except for an entry, which
/// specifies the position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule<S> {
    /// Free flight throughout, Eq. (4).
    Free,
    /// Contact throughout, Eq. (6a).
    Contact,
    /// Free flight, and contact from an instant on.
    Enters {
        /// The instant, after the interval's start `[s]`.
        after: S,
        /// Position at which the device is held afterwards, relative to its sampled position `[m]`.
        held_at: S,
    },
    /// Contact, and free flight from this instant on `[s]`.
    Leaves(S),
}

/// Initial state of an interval for the object's motion.
#[derive(Clone, Copy, Debug)]
pub struct Start<S> {
    /// Penetration p `[m]`.
    pub penetration: S,
    /// Velocity of the object eta' `[m/s]`.
    pub object_velocity: S,
    /// Device velocity v, the backward difference of its samples `[m/s]`.
    pub device_velocity: S,
    /// Virtual force on the object f_V `[N]`.
    pub virtual_force: S,
}

/// Displacement of the object in an interval.
#[derive(Clone, Copy, Debug)]
pub struct Displacement<S> {
    /// Displacement since the interval's start `[m]`.
    pub by: S,
    /// Velocity at its end `[m/s]`.
    pub velocity: S,
}

/// Response of the object on the contact spring over a fixed duration: the paper's A(T) and b(T)
/// of Eq. (6a), as factors of the distance to equilibrium and of the velocity.
#[derive(Clone, Copy, Debug)]
struct Spring<S> {
    /// Displacement per distance to equilibrium: `1 - cos(Omega h)` undamped.
    versine: S,
    /// Displacement per velocity `[s]`: `sin(Omega h) / Omega` undamped.
    sine_over_omega: S,
    /// Velocity per distance to equilibrium `[1/s]`: `Omega sin(Omega h)` undamped.
    omega_sine: S,
    /// Velocity per velocity: `cos(Omega h)` undamped.
    cosine: S,
}

impl<S: Scalar> Spring<S> {
    /// Returns the response after `h` `[s]` at the natural frequency `omega` `[rad/s]` and the decay rate `gamma` =
    /// B/(2M) `[1/s]`; both are 0 for a wall.
    fn after(h: S, omega: S, gamma: S) -> Self {
        if gamma == S::ZERO {
            return Self::undamped(h, omega);
        }
        // y'' + 2 gamma y' + omega^2 y = 0. `c` and `s` are the even and the odd solution, both including the decay: an
        // over-damped cosh alone would overflow.
        let split = (omega - gamma) * (omega + gamma);
        let (c, s) = if split > S::ZERO {
            let damped = split.sqrt();
            let (sin, cos) = (damped * h).sin_cos();
            let decay = (-gamma * h).exp();
            (decay * cos, decay * sin / damped)
        } else if split < S::ZERO {
            let sigma = (-split).sqrt();
            let slow = (-(omega * omega / (gamma + sigma)) * h).exp();
            let fast = (-(S::TWO * sigma * h)).exp_m1();
            (
                slow * (S::ONE + S::HALF * fast),
                -slow * fast / (S::TWO * sigma),
            )
        } else {
            let decay = (-gamma * h).exp();
            (decay, decay * h)
        };
        Self {
            versine: S::ONE - (c + gamma * s),
            sine_over_omega: s,
            omega_sine: omega * omega * s,
            cosine: c - gamma * s,
        }
    }

    #[inline]
    fn undamped(h: S, omega: S) -> Self {
        if omega == S::ZERO {
            return Self {
                versine: S::ZERO,
                sine_over_omega: h,
                omega_sine: S::ZERO,
                cosine: S::ONE,
            };
        }
        // Half the angle, so that 1 - cos keeps its precision for small displacements.
        let (sin, cos) = (S::HALF * omega * h).sin_cos();
        let versine = S::TWO * sin * sin;
        let sine = S::TWO * sin * cos;
        Self {
            versine,
            sine_over_omega: sine / omega,
            omega_sine: omega * sine,
            cosine: S::ONE - versine,
        }
    }

    #[inline]
    fn displace(&self, to_equilibrium: S, velocity: S) -> Displacement<S> {
        Displacement {
            by: to_equilibrium * self.versine + velocity * self.sine_over_omega,
            velocity: to_equilibrium * self.omega_sine + velocity * self.cosine,
        }
    }
}

/// The object's motion for one contact and one period: A(T) and b(T) are computed once, and only transitions and
/// measured periods need new ones.
#[derive(Clone, Copy, Debug)]
pub struct ObjectMotion<S> {
    stiffness: S,
    /// M `[kg]`, 0 for a wall: a wall's kinetic energy is in no balance.
    inertia: S,
    /// 1/M `[1/kg]`, 0 for a wall.
    mobility: S,
    /// sqrt(K/M) `[rad/s]`.
    omega: S,
    /// Damping B in the contact's motion `[N s/m]`; non-zero for the virtual damper only.
    damping: S,
    period: S,
    nominal: Spring<S>,
}

impl<S: Scalar> ObjectMotion<S> {
    pub(crate) fn new(contact: &Contact<S>, damping: S, period: S) -> Self {
        let (inertia, mobility) = match contact.object_mass {
            Mass::Finite(mass) => (mass, S::ONE / mass),
            Mass::Infinite => (S::ZERO, S::ZERO),
        };
        let omega = (contact.stiffness * mobility).sqrt();
        Self {
            stiffness: contact.stiffness,
            inertia,
            mobility,
            omega,
            damping,
            period,
            nominal: Spring::after(period, omega, S::HALF * damping * mobility),
        }
    }

    /// Returns the contact stiffness K `[N/m]`.
    #[inline]
    pub fn stiffness(&self) -> S {
        self.stiffness
    }

    /// Returns the nominal period T `[s]`.
    #[inline]
    pub fn period(&self) -> S {
        self.period
    }

    /// Returns 1/M `[1/kg]`, 0 for a wall.
    #[inline]
    pub fn mobility(&self) -> S {
        self.mobility
    }

    /// Returns whether the object is a wall, which never moves.
    #[inline]
    pub fn is_wall(&self) -> bool {
        self.mobility == S::ZERO
    }

    /// Returns the kinetic energy of the object plus the elastic energy of the contact `[J]`.
    #[inline]
    pub fn stored_energy(&self, penetration: S, object_velocity: S) -> S {
        let pressed = penetration.max(S::ZERO);
        S::HALF
            * (self.inertia * object_velocity * object_velocity
                + self.stiffness * pressed * pressed)
    }

    /// Returns the free flight over `h` `[s]`, Eq. (4).
    #[inline]
    pub fn fly(&self, start: &Start<S>, h: S) -> Displacement<S> {
        let acceleration = start.virtual_force * self.mobility;
        Displacement {
            by: (start.object_velocity + S::HALF * acceleration * h) * h,
            velocity: start.object_velocity + acceleration * h,
        }
    }

    /// Returns the distance from the object to its equilibrium on the held spring, zeta - eta `[m]`.
    #[inline]
    fn distance_to_rest(&self, start: &Start<S>) -> S {
        start.penetration
            + (start.virtual_force + self.damping * start.device_velocity) / self.stiffness
    }

    /// Returns the motion in contact over one nominal period with the device held, Eq. (6a).
    #[inline]
    pub fn press(&self, start: &Start<S>) -> Displacement<S> {
        self.nominal
            .displace(self.distance_to_rest(start), start.object_velocity)
    }

    fn press_for(&self, start: &Start<S>, h: S) -> Displacement<S> {
        Spring::after(h, self.omega, S::HALF * self.damping * self.mobility)
            .displace(self.distance_to_rest(start), start.object_velocity)
    }

    /// Returns the object's motion over `h` `[s]` by a `rule` that was chosen at the interval's start.
    ///
    /// A rule specifies instants and not the period, so it is valid for any `h`: in a sample before the transition, the
    /// transition has not yet happened.
    pub fn advance(&self, rule: Rule<S>, start: &Start<S>, h: S) -> Displacement<S> {
        match rule {
            Rule::Free => self.fly(start, h),
            Rule::Contact => self.press_for(start, h),
            Rule::Enters { after, .. } if after >= h => self.fly(start, h),
            Rule::Leaves(after) if after >= h => self.press_for(start, h),
            Rule::Enters { after, held_at } => {
                let first = self.fly(start, after);
                let touch = Start {
                    penetration: start.penetration + held_at - first.by,
                    object_velocity: first.velocity,
                    ..*start
                };
                let second = self.press_for(&touch, h - after);
                Displacement {
                    by: first.by + second.by,
                    velocity: second.velocity,
                }
            }
            Rule::Leaves(after) => {
                let first = self.press_for(start, after);
                let apart = Start {
                    object_velocity: first.velocity,
                    ..*start
                };
                let second = self.fly(&apart, h - after);
                Displacement {
                    by: first.by + second.by,
                    velocity: second.velocity,
                }
            }
        }
    }

    /// Returns the instant within the period `[s]` at which a device at constant velocity meets a free object; `None`
    /// if the penetration predicted for the period's end is not positive.
    #[inline]
    pub fn entry(&self, start: &Start<S>) -> Option<S> {
        let flown = self.fly(start, self.period);
        let predicted = start.penetration + start.device_velocity * self.period - flown.by;
        if predicted > S::ZERO {
            Some(entry_instant(
                start.penetration,
                start.device_velocity - start.object_velocity,
                -S::HALF * start.virtual_force * self.mobility,
                self.period,
            ))
        } else {
            None
        }
    }

    /// Returns the instant within the period `[s]` at which an object on the held spring first separates from the
    /// device, which moves at constant velocity. Call it if the penetration predicted for the period's end is not
    /// positive.
    pub fn release(&self, start: &Start<S>) -> S {
        release_instant(
            start.penetration,
            start.device_velocity,
            self.distance_to_rest(start),
            start.object_velocity,
            self.omega,
            self.period,
        )
    }
}
