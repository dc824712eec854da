//! Coupled rendering: device and object are predicted together, and the mean of the contact force
//! between them is held.

use super::method::{Ended, Method, MethodParams, Plan, Situation};
use crate::Scalar;
use crate::contact::{Contact, LoopParams, Mass};
use crate::motion::{Displacement, ObjectMotion, Rule};
use crate::parameter::ParameterError;
use crate::predict::{Motion, Observer, ObserverParams, Seen};
use crate::relative_motion::{Course, Drive, Relative};

/// Parameters of coupled rendering.
///
/// The two steps are there to be compared; both are on by default.
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
pub struct CoupledParams<S> {
    /// Effective mass of the device at its end-point, within a factor of 2 `[kg]`. The hand's
    /// share is learned. [`Mass::Infinite`] is a device that no force moves: a recorded motion.
    pub device_mass: Mass<S>,
    /// Quantum of the position sensor `[m]`, 0 if it is not known to have one.
    #[cfg_attr(feature = "serde", serde(default))]
    pub encoder_quantum: S,
    /// Whether the object is placed so that device and object move against each other as
    /// predicted. Without it the object keeps to its own momentum.
    #[cfg_attr(feature = "serde", serde(default = "on"))]
    pub placement: bool,
    /// Whether the interval that a sample ends is predicted anew with what the sample tells.
    #[cfg_attr(feature = "serde", serde(default = "on"))]
    pub correction: bool,
}

#[cfg(feature = "serde")]
fn on() -> bool {
    true
}

impl<S: Scalar> CoupledParams<S> {
    /// Coupled rendering on a device of about `device_mass` `[kg]` (infinite: one that no force
    /// moves), with a position sensor of no known quantum.
    pub fn new(device_mass: S) -> Self {
        Self {
            device_mass: if device_mass == S::INFINITY {
                Mass::Infinite
            } else {
                Mass::Finite(device_mass)
            },
            encoder_quantum: S::ZERO,
            placement: true,
            correction: true,
        }
    }

    /// The same with a position sensor of `encoder_quantum` `[m]`.
    #[must_use]
    pub fn with_encoder_quantum(self, encoder_quantum: S) -> Self {
        Self {
            encoder_quantum,
            ..self
        }
    }
}

/// Coupled rendering.
///
/// A held force moves the device to another place than the force it stands for would have, and the
/// device's own prediction has to know that force. So an observer estimates what else pushes the
/// device, and how heavy it is; the relative motion of device and object over the coming interval
/// follows in closed form, with any number of transitions; its mean contact force is held; and the
/// object is placed so that the *relative* motion comes out as predicted although the force is
/// held. With the device's mass and external acceleration known exactly, the rendered force is the
/// interval mean of the ideal one: no held force can be nearer.
#[derive(Clone, Copy, Debug)]
pub struct Coupled<S> {
    observer: ObserverParams<S>,
    object_mobility: S,
    placement: bool,
    correction: bool,
}

/// What coupled rendering remembers.
#[derive(Clone, Copy, Debug, Default)]
pub struct CoupledMemory<S> {
    observer: Option<Observer<S>>,
    /// Impulse that contact has had by what is known now, less the impulse of the forces that stood
    /// for it `[N s]`. A wall takes any momentum, so it is owed nothing.
    debt: S,
    /// Durations of the last intervals, the newest last `[s]`.
    periods: [Option<S>; 3],
    /// By how much a wall stands off its place `[m]`.
    wall_offset: S,
    /// Shift of the object by placement over the last interval `[m]`.
    shift: S,
}

impl<S: Scalar> CoupledMemory<S> {
    /// How long the next interval will be `[s]`: the median of the last three, so that a loop that
    /// has become slower is planned for after two samples, and a single late one changes nothing.
    fn likely_period(&self, nominal: S) -> S {
        let [a, b, c] = self.periods.map(|period| period.unwrap_or(nominal));
        a.min(b).max(a.max(b).min(c))
    }

    /// Effective mass of the device with the hand that holds it, as far as it has been learned
    /// `[kg]`: infinite for one that no force moves, none before the first sample.
    pub fn device_mass(&self) -> Option<S> {
        let observer = self.observer.as_ref()?;
        Some(S::ONE / observer.motion.mobility)
    }
}

/// Part of the impulse owed that the next force makes up for. All of it would pass on the noise of
/// one estimate as a force of the other sign in the next; on random plants a half has the least
/// error, with and without delay.
const REPAID: f64 = 0.5;

/// What is left of a wall's offset after one interval in contact. With more of it a pressed wall of
/// kappa = 4 swings by more: 2.3 % of the mean force with a half, 3.5 % with 0.8.
const WALL_OFFSET_KEPT: f64 = 0.5;

impl<S: Scalar> MethodParams<S> for CoupledParams<S> {
    type Method = Coupled<S>;

    fn check(
        self,
        contact: &Contact<S>,
        _: &LoopParams<S>,
    ) -> Result<Self::Method, ParameterError> {
        Ok(Coupled {
            observer: ObserverParams::new(self.device_mass, self.encoder_quantum)?,
            object_mobility: match contact.object_mass {
                Mass::Finite(mass) => S::ONE / mass,
                Mass::Infinite => S::ZERO,
            },
            placement: self.placement,
            correction: self.correction,
        })
    }
}

/// How one interval goes: what moves device and object against each other, and where it ends.
struct Interval<S> {
    start: Relative<S>,
    drive: Drive<S>,
    course: Course<S>,
    duration: S,
}

impl<S: Scalar> Coupled<S> {
    fn interval(
        &self,
        motion: &ObjectMotion<S>,
        device: &Motion<S>,
        start: Relative<S>,
        virtual_force: S,
        duration: S,
    ) -> Interval<S> {
        let drive = Drive {
            stiffness: motion.stiffness(),
            mobility: device.mobility + self.object_mobility,
            acceleration: device.external - virtual_force * self.object_mobility,
        };
        Interval {
            start,
            drive,
            course: drive.over(start, duration),
            duration,
        }
    }

    /// What the interval does to the object while the motor holds what was `intended` `[N]`, how
    /// far placement shifts it by that, and the wall's new offset.
    fn object_moved(
        &self,
        interval: &Interval<S>,
        device: &Motion<S>,
        object_velocity: S,
        virtual_force: S,
        intended: S,
        wall_offset: S,
    ) -> (Displacement<S>, S, S) {
        let Interval {
            start,
            drive,
            course,
            duration: h,
        } = interval;
        let h = *h;
        // Integral of (h - s) f(s), from the relative motion itself.
        let flown = start.penetration + (start.speed + S::HALF * drive.acceleration * h) * h;
        let lost = flown - course.end.penetration;
        let moment_times = |mobility: S| {
            if drive.mobility > S::ZERO {
                lost * (mobility / drive.mobility)
            } else {
                S::ZERO
            }
        };
        let shift = moment_times(device.mobility) - S::HALF * h * device.mobility * course.impulse;
        let (travel, gained) = device.under(intended, h);
        let placed = start.penetration - course.end.penetration + travel;
        if self.object_mobility == S::ZERO {
            let gives_way = self.placement && device.mobility > S::ZERO;
            let offset = if course.impulse > S::ZERO && gives_way {
                S::from_f64(WALL_OFFSET_KEPT) * (wall_offset + placed)
            } else {
                S::ZERO
            };
            let moved = Displacement {
                by: offset - wall_offset,
                velocity: S::ZERO,
            };
            return (moved, moved.by, offset);
        }
        let moved = if self.placement {
            Displacement {
                by: placed,
                velocity: device.velocity + gained - course.end.speed,
            }
        } else {
            let alpha = virtual_force * self.object_mobility;
            Displacement {
                by: (object_velocity + S::HALF * alpha * h) * h
                    + moment_times(self.object_mobility),
                velocity: object_velocity + alpha * h + self.object_mobility * course.impulse,
            }
        };
        (moved, if self.placement { shift } else { S::ZERO }, S::ZERO)
    }
}

impl<S: Scalar> Method<S> for Coupled<S> {
    type Memory = CoupledMemory<S>;

    fn conclude(
        &self,
        motion: &ObjectMotion<S>,
        ended: &Ended<S>,
        memory: &mut CoupledMemory<S>,
    ) -> Displacement<S> {
        let Some(observer) = &mut memory.observer else {
            return ended.as_planned(motion);
        };
        let before = observer.motion;
        let smoothed = observer.see(
            &self.observer,
            &Seen {
                moved: ended.device_moved,
                elapsed: ended.elapsed,
                held_force: ended.held_force,
            },
        );
        let device = if self.correction { smoothed } else { before };
        let start = &ended.start;
        let interval = self.interval(
            motion,
            &device,
            Relative {
                penetration: start.penetration + device.offset,
                speed: device.velocity - start.object_velocity,
            },
            start.virtual_force,
            ended.elapsed,
        );
        let (moved, shift, wall_offset) = self.object_moved(
            &interval,
            &device,
            start.object_velocity,
            start.virtual_force,
            ended.intended_force,
            memory.wall_offset,
        );
        if !motion.is_wall() {
            memory.debt += interval.course.impulse - ended.intended_force * ended.elapsed;
        }
        memory.periods = [memory.periods[1], memory.periods[2], Some(ended.elapsed)];
        memory.shift = shift;
        memory.wall_offset = wall_offset;
        moved
    }

    fn plan(
        &self,
        motion: &ObjectMotion<S>,
        now: &Situation<'_, S>,
        memory: &mut CoupledMemory<S>,
    ) -> Plan<S> {
        let period = memory.likely_period(motion.period());
        let observer = memory
            .observer
            .get_or_insert_with(|| Observer::new(&self.observer));
        let mut device = observer.motion;
        let virtual_force = now.start.virtual_force;
        let mut object_velocity = now.start.object_velocity;
        let mut wall_offset = memory.wall_offset;
        let mut relative = Relative {
            penetration: now.start.penetration + device.offset,
            speed: device.velocity - object_velocity,
        };
        let mut first = None;
        let mut owed = memory.debt;
        for on_its_way in now.on_their_way {
            let interval = self.interval(motion, &device, relative, virtual_force, period);
            let (moved, _, offset) = self.object_moved(
                &interval,
                &device,
                object_velocity,
                virtual_force,
                on_its_way.intended,
                wall_offset,
            );
            if !motion.is_wall() {
                owed += interval.course.impulse - on_its_way.intended * period;
            }
            let (travel, gained) = device.under(on_its_way.commanded, period);
            first = first.or(Some((moved, rule(&interval))));
            relative.penetration += travel - moved.by;
            device.velocity += gained;
            object_velocity = moved.velocity;
            wall_offset = offset;
            relative.speed = device.velocity - object_velocity;
        }
        let interval = self.interval(motion, &device, relative, virtual_force, period);
        let owed = S::from_f64(REPAID) * owed;
        let mut force = (interval.course.impulse + owed) / period;
        if force < S::ZERO {
            force = S::ZERO;
            if interval.course.impulse == S::ZERO {
                // Device and object are apart: what was pushed too much is not pulled back.
                memory.debt = S::ZERO;
            }
        }
        let (moved, rule) = first.unwrap_or_else(|| {
            let (moved, _, _) = self.object_moved(
                &interval,
                &device,
                object_velocity,
                virtual_force,
                force,
                wall_offset,
            );
            (moved, rule(&interval))
        });
        Plan { force, rule, moved }
    }

    fn begin_anew(&self, memory: &mut CoupledMemory<S>, device_known: bool, object_known: bool) {
        let observer = memory.observer.filter(|_| device_known);
        *memory = CoupledMemory {
            observer,
            // A wall that waited for a sample still has to go back to its place.
            wall_offset: if object_known {
                memory.wall_offset
            } else {
                S::ZERO
            },
            ..CoupledMemory::default()
        };
    }

    #[inline]
    fn placement_shift(&self, memory: &CoupledMemory<S>) -> S {
        memory.shift
    }
}

/// What an interval holds, in the words that every method shares.
fn rule<S: Scalar>(interval: &Interval<S>) -> Rule<S> {
    let pressed = interval.start.penetration > S::ZERO;
    match interval.course.first_transition {
        None if interval.course.impulse > S::ZERO => Rule::Contact,
        None => Rule::Free,
        Some(after) if pressed => Rule::Leaves(after),
        Some(after) => Rule::Enters(after),
    }
}
