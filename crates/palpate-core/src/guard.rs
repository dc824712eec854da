//! Passivity guard: a bound on the energy that a held force can give out before the next sample.
//!
//! A force is fixed before the user moves. A guarantee, in contrast to an estimate, must therefore limit the force
//! itself. Over one interval a force can give out as much as `|f| v T` at a device speed v, however it was computed:
//!
//! ```text
//! |f_i| T <= (balance_i + allowance)/v_max - impulse to come
//! balance_i = what was stored at the start + work of f_V + outside work + port work
//! impulse to come = sum over the commands before of |f| (time left to act) + lag |force now|
//! ```
//!
//! The balance is the energy that may still be given out. Earlier commands have claims on it: those in a delay, and the
//! force that still decays in an actuator with a lag. While the device stays below v_max and samples arrive within the
//! nominal period, the energy given out at the end of an interval with a held force never exceeds the stored energy,
//! the energy supplied by f_V and changes from outside, and the allowance.
//!
//! The guard uses the delay, lag and gain of [`Actuation`](crate::Actuation), without their deviations.
//!
//! # Energy given out unnoticed
//!
//! The balance has the port work of the mean force over the measured displacement. Two parts of the true work can
//! escape it; the guard deducts their largest value as `hidden`:
//!
//! - The quantum q of the sensor hides `|change of f| q/2`.
//! - With a lag or a fraction of a period of delay the force changes between two samples ([`Uneven`]). A device that
//!   reverses its motion in between takes up to `4 v_max course/T`, and no more than `v_max` times the integral of |f|
//!   in total.
//!
//! Both need a motion that matches the changes of the force, so `hidden` decreases by [`GuardParams::recovery`].
//!
//! # Bound by acceleration
//!
//! With a [`HandBound`], the last step of the device limits the next one. Let a_h bound the acceleration of the device
//! by everything except the rendered force, m its least mass, theta = 1/m, q the quantum of the sensor. The last
//! interval of length T1 had the mean velocity v (positive into the object) and the force f(s):
//!
//! ```text
//! -velocity now <= b = -v + q/T1 + a_h T1/2 + theta max(M, 0),  M = (1/T1) integral of s f(s)
//! forces on their way, impulse J, moment S:  claim = b J + a_h S + theta J^2/2
//! own force f:  theta T^2 f^2/2 + T (b + a_h t_f + theta J) f + claims <= balance + allowance - hidden
//! ```
//!
//! t_f is the centroid of the own impulse. Pulls have the mirrored bound. The largest f that satisfies one of the two
//! bounds is sent. A device that enters the object pays nothing.
//!
//! A force that changes between two samples then hides at most `a_h course - min(mean lead, 0)/m`.
//!
//! With [`HandBound::learns_mass`] the motion itself bounds the mass. Two steps with the mean velocities v1 and v2, their
//! middles h apart, and the impulse J between these middles, which a heavy device resists, show
//!
//! ```text
//! m >= J/(v1 - v2 + a_h h + q/T1 + q/T2),  or  m >= (J - F h)/(v1 - v2 + q/T1 + q/T2)  by the largest hand force F
//! ```
//!
//! for a push; pulls are mirrored. The largest of these is the least mass from then on, until a step exceeds the bound.

use crate::Scalar;
use crate::actuator::{Held, Impulse, Pending, Uneven};
use crate::parameter::{Parameter, ParameterError};

/// Mode of the bound on the energy given out.
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
pub enum Guard<S> {
    /// No bound.
    #[default]
    Off,
    /// Forces beyond the bound are held and reported in [`Limited::guard`](crate::Limited::guard).
    Report(GuardParams<S>),
    /// No force exceeds the bound.
    Limit(GuardParams<S>),
}

/// Parameters of the guard.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: Scalar + serde::Serialize",
        deserialize = "S: Scalar + serde::Deserialize<'de>"
    ))
)]
pub struct GuardParams<S> {
    /// Largest device speed for which the bound holds, v_max `[m/s]`, greater than 0.
    pub largest_speed: S,
    /// Energy that may be given out beyond the balance, epsilon `[J]`, not below 0. With 0, a contact without stored
    /// energy could not begin to push.
    pub allowance: S,
    /// Quantum q of the position sensor `[m]`, not below 0.
    #[cfg_attr(feature = "serde", serde(default))]
    pub quantum: S,
    /// Power by which the energy that may have been given out unnoticed is forgiven `[W]`, not below 0. The guarantee
    /// of a force that changes between two samples, or of a sensor with a quantum, is the allowance plus this power
    /// times the time. With 0 the guard is strict and loses its allowance over many contacts.
    #[cfg_attr(feature = "serde", serde(default))]
    pub recovery: S,
    /// Bound on the acceleration of the device. `None`: the bound by speed only.
    #[cfg_attr(feature = "serde", serde(default))]
    pub hand: Option<HandBound<S>>,
}

/// Bound on the acceleration of the device by everything except the rendered force: the hand, friction, its weight.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: Scalar + serde::Serialize",
        deserialize = "S: Scalar + serde::Deserialize<'de>"
    ))
)]
pub struct HandBound<S> {
    /// Largest effect of the hand.
    pub limit: HandLimit<S>,
    /// Least mass of the device that the rendered force can find `[kg]`, greater than 0.
    pub least_mass: S,
    /// Whether the motion may raise the least mass. It requires a mass that is the same in every pose.
    #[cfg_attr(feature = "serde", serde(default))]
    pub learns_mass: bool,
}

/// Largest effect of everything except the rendered force on the device.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: Scalar + serde::Serialize",
        deserialize = "S: Scalar + serde::Deserialize<'de>"
    ))
)]
pub enum HandLimit<S> {
    /// Largest acceleration a_h `[m/s^2]`, greater than 0.
    Acceleration(S),
    /// Largest force `[N]`, greater than 0. a_h is this force over the least mass: 10 N on 0.125 kg are 80 m/s^2.
    Force(S),
}

impl<S: Scalar> HandBound<S> {
    /// Creates the bound of a hand that accelerates a device of at least `least_mass` `[kg]` by at most `acceleration`
    /// `[m/s^2]`.
    #[must_use]
    pub const fn from_acceleration(acceleration: S, least_mass: S) -> Self {
        Self {
            limit: HandLimit::Acceleration(acceleration),
            least_mass,
            learns_mass: false,
        }
    }

    /// Creates the bound of a hand that exerts at most `force` `[N]` on a device of at least `least_mass` `[kg]`.
    #[must_use]
    pub const fn from_force(force: S, least_mass: S) -> Self {
        Self {
            limit: HandLimit::Force(force),
            least_mass,
            learns_mass: false,
        }
    }

    /// Returns the bound whose least mass the motion may raise.
    #[must_use]
    pub const fn learning_mass(self) -> Self {
        Self {
            learns_mass: true,
            ..self
        }
    }

    /// Returns the largest acceleration a_h `[m/s^2]`.
    #[must_use]
    pub fn acceleration(&self) -> S {
        match self.limit {
            HandLimit::Acceleration(acceleration) => acceleration,
            HandLimit::Force(force) => force / self.least_mass,
        }
    }

    /// Returns the allowance that renders forces up to `force` `[N]` in periods of `period` `[s]` without a limit, for
    /// a sensor of this `quantum` `[m]` and an actuator without delay `[J]`.
    #[must_use]
    pub fn allowance_for(&self, force: S, period: S, quantum: S) -> S {
        let moved = self.acceleration() * period * period + quantum;
        force * moved + force * force * period * period / self.least_mass
    }

    fn faults(&self) -> [Option<ParameterError>; 2] {
        [
            match self.limit {
                HandLimit::Acceleration(most) => Parameter::GuardAcceleration.positive(most).err(),
                HandLimit::Force(most) => Parameter::GuardHandForce.positive(most).err(),
            },
            Parameter::GuardMass.positive(self.least_mass).err(),
        ]
    }
}

impl<S: Scalar> Guard<S> {
    /// Returns the parameters outside their range.
    pub(crate) fn faults(&self) -> impl Iterator<Item = ParameterError> + use<S> {
        let params = self.params();
        let hand = params.and_then(|params| params.hand);
        let of_params = params.map_or([None; 4], |params| {
            [
                Parameter::GuardSpeed.positive(params.largest_speed).err(),
                Parameter::GuardAllowance
                    .not_negative(params.allowance)
                    .err(),
                Parameter::GuardQuantum.not_negative(params.quantum).err(),
                Parameter::GuardRecovery.not_negative(params.recovery).err(),
            ]
        });
        let of_hand = hand.map_or([None; 2], |hand| hand.faults());
        of_params.into_iter().chain(of_hand).flatten()
    }

    /// Returns the parameters, unless there is no guard.
    #[inline]
    pub(crate) fn params(&self) -> Option<&GuardParams<S>> {
        match self {
            Self::Off => None,
            Self::Report(params) | Self::Limit(params) => Some(params),
        }
    }

    /// Returns whether the bound is enforced.
    #[inline]
    pub(crate) fn limits(&self) -> bool {
        matches!(self, Self::Limit(_))
    }
}

/// State of the guard besides the energy ledger.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GuardMemory<S> {
    /// The last interval; `None` after a lost sample or an acceleration beyond the bound.
    last: Option<LastStep<S>>,
    /// Whether the last interval may be used for the bound by acceleration.
    is_within: bool,
    /// Least mass that the motion has shown `[kg]`; 0: none.
    shown: S,
    /// Mean force over the last interval `[N]`.
    held: S,
    /// Energy that may have been given out unnoticed `[J]`.
    hidden: S,
    /// Largest energy that forces gave out in intervals without a position at their end `[J]`.
    unseen: S,
}

/// Motion of the device over an interval.
#[derive(Clone, Copy, Debug)]
struct LastStep<S> {
    elapsed: S,
    /// Mean velocity `[m/s]`.
    velocity: S,
    /// Impulse of the force, weighted by the time since the interval's beginning, over its duration `[N s]`.
    late: S,
    /// The rest of the impulse `[N s]`.
    early: S,
}

impl<S: Scalar> GuardMemory<S> {
    pub fn new() -> Self {
        Self {
            last: None,
            is_within: false,
            shown: S::ZERO,
            held: S::ZERO,
            hidden: S::ZERO,
            unseen: S::ZERO,
        }
    }

    /// Returns whether the device accelerated beyond the bound in the last interval.
    #[inline]
    pub fn is_exceeded(&self) -> bool {
        self.last.is_some() && !self.is_within
    }

    /// Ends an interval of `elapsed` `[s]`, in which the device `moved` `[m]` under the force `held`.
    #[inline(never)]
    pub fn pass(
        &mut self,
        params: &GuardParams<S>,
        held: &Held<S>,
        uneven: &Uneven<S>,
        moved: S,
        elapsed: S,
    ) {
        let by_speed = params.hidden_by_speed(held.mean, uneven, moved, elapsed);
        let by_course = match &params.hand {
            None => by_speed,
            Some(hand) => {
                let now = LastStep::of(held, moved, elapsed);
                let before = self.last.replace(now);
                let hand = hand.of_at_least(self.shown);
                self.is_within = !before.is_some_and(|last| hand.is_exceeded(params, &last, &now));
                self.shown = match before {
                    Some(last) if self.is_within && hand.learns_mass => {
                        self.shown.max(hand.shown_mass(params, &last, &now))
                    }
                    // The device may be lighter than its motion has shown.
                    Some(_) if !self.is_within => S::ZERO,
                    _ => self.shown,
                };
                if self.is_within {
                    hand.hidden(held, uneven).min(by_speed)
                } else {
                    by_speed
                }
            }
        };
        let by_quantum = S::HALF * params.quantum * (held.mean - self.held).abs();
        self.held = held.mean;
        let hidden = self.hidden - params.recovery * elapsed;
        self.hidden = hidden.max(S::ZERO) + by_course + by_quantum;
    }

    /// Ends an interval without a position at its end, in which a force with these bounds acted.
    #[cold]
    pub fn lose(&mut self, params: &GuardParams<S>, uneven: &Uneven<S>) {
        self.last = None;
        self.is_within = false;
        self.unseen += params.largest_speed * uneven.size;
        self.hidden += S::HALF * params.quantum * self.held.abs();
        self.held = S::ZERO;
    }

    /// Returns the largest push and the largest pull `[N]` over one `period` `[s]`, as delivered forces.
    #[inline(never)]
    pub fn bounds(
        &self,
        params: &GuardParams<S>,
        balance: S,
        pending: &Pending<S>,
        period: S,
    ) -> [S; 2] {
        let hidden = self.hidden + S::HALF * params.quantum * self.held.abs();
        let free = balance + params.allowance - self.unseen - hidden;
        let by_speed = params.force_by_speed(free, pending, period);
        match (&params.hand, &self.last) {
            (Some(hand), Some(last)) if self.is_within => {
                let hand = hand.of_at_least(self.shown);
                let by_acceleration = params.by_acceleration(&hand, last, free, pending, period);
                by_acceleration.map(|bound| not_negative(bound.max(by_speed)))
            }
            _ => [not_negative(by_speed); 2],
        }
    }
}

impl<S: Scalar> LastStep<S> {
    /// Creates the step of a device that `moved` `[m]` in `elapsed` `[s]` under the force `held`.
    fn of(held: &Held<S>, moved: S, elapsed: S) -> Self {
        let half = S::HALF * held.mean * elapsed;
        Self {
            elapsed,
            velocity: moved / elapsed,
            late: half - held.lead / elapsed,
            early: half + held.lead / elapsed,
        }
    }
}

/// Returns a change of the velocity, with the rounding of positions and times.
fn with_rounding<S: Scalar>(change: S) -> S {
    change * S::from_f64(1.0 + 1e-9) + S::from_f64(1e-12)
}

/// Returns the bound, or 0 if it is negative or NaN.
fn not_negative<S: Scalar>(bound: S) -> S {
    if bound >= S::ZERO { bound } else { S::ZERO }
}

impl<S: Scalar> GuardParams<S> {
    /// Creates the bound by the largest speed `[m/s]` with an allowance `[J]`, for a sensor without a quantum, strict.
    #[must_use]
    pub const fn by_speed(largest_speed: S, allowance: S) -> Self {
        Self {
            largest_speed,
            allowance,
            quantum: S::ZERO,
            recovery: S::ZERO,
            hand: None,
        }
    }

    /// Returns the largest energy that a force with this `mean` `[N]` and these bounds gave out beyond its port work
    /// `[J]`, while the device `moved` `[m]` in `elapsed` `[s]`.
    fn hidden_by_speed(&self, mean: S, uneven: &Uneven<S>, moved: S, elapsed: S) -> S {
        let by_course = S::from_f64(4.0) * self.largest_speed * uneven.course / elapsed;
        let size = uneven.size.max(mean.abs() * elapsed);
        let most = self.largest_speed * size + mean * moved + mean.abs() * self.quantum;
        by_course.min(most.max(S::ZERO))
    }

    /// Returns the largest error of the difference of two mean velocities by the quantum `[m/s]`.
    fn noise(&self, before: &LastStep<S>, now: &LastStep<S>) -> S {
        self.quantum / before.elapsed + self.quantum / now.elapsed
    }

    /// Returns the largest force by the largest speed of the device, from a `free` energy `[J]`.
    fn force_by_speed(&self, free: S, pending: &Pending<S>, period: S) -> S {
        let claims = pending.push.impulse + pending.pull.impulse;
        (free / self.largest_speed - claims) / period
    }

    /// Returns the largest push and pull by the largest acceleration of the device, from a `free` energy `[J]`.
    fn by_acceleration(
        &self,
        hand: &HandBound<S>,
        last: &LastStep<S>,
        free: S,
        pending: &Pending<S>,
        period: S,
    ) -> [S; 2] {
        let [push, pull] = [
            hand.against(last.velocity, last.late, last.elapsed, self.quantum),
            hand.against(-last.velocity, -last.late, last.elapsed, self.quantum),
        ];
        let [push_claim, pull_claim] = [
            hand.claim(push, &pending.push),
            hand.claim(pull, &pending.pull),
        ];
        let by_speed = self.largest_speed * (pending.push.impulse + pending.pull.impulse);
        let bound = |against: S, impulse: S, own: S, other: S| {
            // The own force and the earlier ones by acceleration, or the earlier ones by speed.
            let level = (free - other.max(S::ZERO)).max(own);
            let room = (level - own).max(free - by_speed).max(S::ZERO);
            let root = hand.largest_force(against, impulse, room, pending, period);
            // The own force by speed, and the earlier ones by acceleration.
            let crossed = if pending.overlaps {
                impulse * period / hand.least_mass
            } else {
                S::ZERO
            };
            let rest = free - own.max(S::ZERO) - other.max(S::ZERO);
            root.max(rest / (self.largest_speed * period + crossed))
        };
        [
            bound(push, pending.push.impulse, push_claim, pull_claim),
            bound(pull, pending.pull.impulse, pull_claim, push_claim),
        ]
    }
}

impl<S: Scalar> HandBound<S> {
    /// Returns the largest energy that a `held` force with these bounds gave out beyond its port work `[J]`.
    fn hidden(&self, held: &Held<S>, uneven: &Uneven<S>) -> S {
        self.acceleration() * uneven.course
            + (-(held.mean * held.lead)).max(S::ZERO) / self.least_mass
    }

    /// Returns whether two intervals show an acceleration beyond the bound, for any mass from the least one up.
    fn is_exceeded(
        &self,
        params: &GuardParams<S>,
        before: &LastStep<S>,
        now: &LastStep<S>,
    ) -> bool {
        let by_hand = S::HALF * self.acceleration() * (before.elapsed + now.elapsed);
        let most = with_rounding(by_hand + params.noise(before, now));
        let gained = now.velocity - before.velocity;
        let by_hand = gained + (before.late + now.early) / self.least_mass;
        gained.min(by_hand) > most || gained.max(by_hand) < -most
    }

    /// Returns the bound for a device of at least this mass `[kg]`.
    fn of_at_least(&self, mass: S) -> Self {
        Self {
            least_mass: self.least_mass.max(mass),
            ..*self
        }
    }

    /// Returns the least mass that two intervals within the bound show `[kg]`; 0 if they show none.
    fn shown_mass(&self, params: &GuardParams<S>, before: &LastStep<S>, now: &LastStep<S>) -> S {
        let half = S::HALF * (before.elapsed + now.elapsed);
        let noise = params.noise(before, now);
        let impulse = before.late + now.early;
        let slowed = before.velocity - now.velocity;
        let slowed = if impulse < S::ZERO { -slowed } else { slowed };
        let (impulse, by_hand) = match self.limit {
            HandLimit::Acceleration(most) => (impulse.abs(), most * half),
            HandLimit::Force(most) => (impulse.abs() - most * half, S::ZERO),
        };
        let lost = slowed + with_rounding(by_hand + noise);
        // A small impulse shows the rounding of the velocities.
        let least = S::from_f64(0.1) * (self.acceleration() * half + noise) * self.least_mass;
        if impulse > least && lost > S::ZERO {
            S::from_f64(0.999) * impulse / lost
        } else {
            S::ZERO
        }
    }

    /// Returns the largest velocity against a force now `[m/s]`: b, from the mean velocity with the force and the
    /// weighted impulse `late` of the last interval.
    fn against(&self, velocity: S, late: S, elapsed: S, quantum: S) -> S {
        quantum / elapsed + S::HALF * self.acceleration() * elapsed - velocity
            + late.max(S::ZERO) / self.least_mass
    }

    /// Returns the largest energy that forces on their way give out `[J]`.
    fn claim(&self, against: S, on_way: &Impulse<S>) -> S {
        let Impulse { impulse, moment } = *on_way;
        against * impulse
            + self.acceleration() * moment
            + S::HALF * impulse * impulse / self.least_mass
    }

    /// Returns the largest own force `[N]` that gives out at most `room` `[J]` in addition to an earlier `impulse` of
    /// its sign.
    fn largest_force(&self, against: S, impulse: S, room: S, pending: &Pending<S>, period: S) -> S {
        let square = S::HALF * period * period / self.least_mass;
        let speed = against + self.acceleration() * pending.own_at + impulse / self.least_mass;
        let linear = period * speed;
        let root = (linear * linear + S::from_f64(4.0) * square * room).sqrt();
        if linear > S::ZERO {
            S::TWO * room / (linear + root)
        } else {
            (root - linear) / (S::TWO * square)
        }
    }
}
