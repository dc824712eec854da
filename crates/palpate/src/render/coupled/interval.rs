//! One interval of coupled rendering: how device and object move against each other, and what that makes
//! of the object while the device feels another force.

use super::Coupled;
use crate::Scalar;
use crate::actuator::Held;
use crate::motion::{Displacement, ObjectMotion, Rule};
use crate::predict::{EstimatedMotion, Sway};
use crate::relative_motion::{Course, Drive, Relative};
use crate::render::method::Ended;
use crate::response::Response;

/// What the contact meets in the device's place.
///
/// The contact acts continuously, the held force does not, so what the contact has moved is not where
/// the device is. The relative motion is that of the avatar. By the end of the window that a command
/// governs both have the same velocity; where a window ends between two samples, they differ at each
/// sample.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Avatar<S> {
    /// By how much a wall stands off its place, so that the device has the avatar's penetration `[m]`:
    /// the avatar is as much behind the device. An object moves on from where it stands off.
    pub wall_offset: S,
    /// Its velocity less the device's `[m/s]`.
    pub speed: S,
    /// Stretch of its transmission: what the device's would be under the contact's force.
    pub sway: Sway<S>,
}

/// Time in which a wall in contact goes back to its place `[s]`. What is taken back while the force
/// changes is energy, so it takes much longer than a collision.
const WALL_RETURN: f64 = 0.2;
/// Most of its offset that a wall gives back in one interval: of a stiff one in a slow loop more would be
/// energy, too.
const WALL_RETURN_MOST: f64 = 0.03;
/// Bound of a wall's offset: this factor times the distance that the contact's impulse moves the device in one
/// interval. It limits the energy that an adversary who moves the device can get out of the wall.
const WALL_OFFSET_MOST: f64 = 16.0;

/// How one interval goes: what moves device and object against each other, and where it ends.
pub(super) struct Interval<S> {
    start: Relative<S>,
    drive: Drive<S>,
    /// Rate of the drive's acceleration `[m/s^3]`.
    ramp: S,
    pub course: Course<S>,
    /// Stretch of the avatar's transmission at its end.
    sway: Sway<S>,
    /// Whether the contact had its largest force for a part of it.
    pub is_saturated: bool,
    duration: S,
}

impl<S: Scalar> Coupled<S> {
    pub(super) fn interval(
        &self,
        motion: &ObjectMotion<S>,
        device: &EstimatedMotion<S>,
        start: Relative<S>,
        sway: Sway<S>,
        virtual_force: S,
        duration: S,
    ) -> Interval<S> {
        let drive = self.drive(motion, device, virtual_force);
        let mut is_saturated = false;
        let (course, sway) = match &self.flexure {
            None => {
                let (course, saturated) = self.saturation.over(&drive, start, duration);
                is_saturated = saturated;
                (course, sway)
            }
            Some(flexure) => flexure.over(&drive, device.mobility, start, sway, duration),
        };
        Interval {
            start,
            drive,
            ramp: S::ZERO,
            course,
            sway,
            is_saturated,
            duration,
        }
    }

    /// The same for an interval that is over, with the changes of the device's external acceleration
    /// under the force that was held, and how its end answers to what it started from.
    pub(super) fn interval_past(
        &self,
        motion: &ObjectMotion<S>,
        device: &EstimatedMotion<S>,
        start: Relative<S>,
        sway: Sway<S>,
        ended: &Ended<S>,
        certainty: S,
    ) -> (Interval<S>, Option<Response<S>>) {
        let drive = self.drive(motion, device, ended.start.virtual_force);
        let h = ended.elapsed;
        let mut is_saturated = false;
        let (mut course, response, sway) = match &self.flexure {
            None => {
                let (course, response, saturated) =
                    self.saturation.over_with_response(&drive, start, h);
                is_saturated = saturated;
                (course, response, sway)
            }
            Some(flexure) => {
                let mobility = device.mobility;
                flexure.over_with_response(&drive, mobility, start, sway, h)
            }
        };
        let mut ramp = S::ZERO;
        if let Some(response) = &response {
            ramp = device.ramp(ended.held.mean);
            let rate = certainty * device.damping_rate;
            let damped = damped(rate, device, &drive, start, &course, response, h);
            let faster = response.ramp[1] * ramp + damped.speed;
            course.end.penetration += response.ramp[0] * ramp + damped.penetration;
            course.end.speed += faster;
            if course.impulse > S::ZERO && drive.mobility > S::ZERO {
                let pushed = S::HALF * ramp * h * h + damped.pushed;
                course.impulse = (course.impulse + (pushed - faster) / drive.mobility).max(S::ZERO);
            }
        }
        let interval = Interval {
            start,
            drive,
            ramp,
            course,
            sway,
            is_saturated,
            duration: h,
        };
        (interval, response)
    }

    fn drive(
        &self,
        motion: &ObjectMotion<S>,
        device: &EstimatedMotion<S>,
        virtual_force: S,
    ) -> Drive<S> {
        Drive {
            stiffness: motion.stiffness(),
            mobility: device.mobility + self.object_mobility,
            acceleration: device.external - virtual_force * self.object_mobility,
        }
    }

    /// What the interval does to the object while the device feels what is `held`, how far placement
    /// shifts it by that, and the avatar at its end.
    pub(super) fn object_moved(
        &self,
        interval: &Interval<S>,
        device: &EstimatedMotion<S>,
        object_velocity: S,
        virtual_force: S,
        held: &Held<S>,
        avatar: &Avatar<S>,
    ) -> Moved<S> {
        let Interval {
            start,
            drive,
            ramp,
            course,
            sway,
            duration: h,
            ..
        } = interval;
        let h = *h;
        // Integral of (h - s) f(s), from the relative motion itself.
        let pushed = drive.acceleration + *ramp * h * S::from_f64(1.0 / 3.0);
        let flown = start.penetration + (start.speed + S::HALF * pushed * h) * h;
        let lost = flown - course.end.penetration;
        let moment_times = |mobility: S| {
            if drive.mobility > S::ZERO {
                lost * (mobility / drive.mobility)
            } else {
                S::ZERO
            }
        };
        let (travel, gained) = device.under(held, h);
        let placed = start.penetration - course.end.penetration + travel;
        let alpha = virtual_force * self.object_mobility;
        let velocity = object_velocity + alpha * h + self.object_mobility * course.impulse;
        let speed = if self.placement {
            course.end.speed + velocity - (device.velocity + gained)
        } else {
            S::ZERO
        };
        if self.object_mobility == S::ZERO {
            let gives_way = self.placement && device.mobility > S::ZERO;
            let wall_offset = if course.impulse > S::ZERO && gives_way {
                let back = (h / S::from_f64(WALL_RETURN)).min(S::from_f64(WALL_RETURN_MOST));
                let most = S::from_f64(WALL_OFFSET_MOST) * device.mobility * course.impulse * h;
                let most = most.max(avatar.wall_offset.abs());
                (S::ONE - back) * (avatar.wall_offset + placed).within(most)
            } else {
                // As far as it stays free.
                let apart = self.flexure.map_or(S::ZERO, |it| it.behind(sway));
                (avatar.wall_offset + course.end.penetration - apart)
                    .max(S::ZERO)
                    .min(avatar.wall_offset.max(S::ZERO))
            };
            let by = wall_offset - avatar.wall_offset;
            return Moved {
                object: Displacement {
                    by,
                    velocity: S::ZERO,
                },
                shift: by,
                avatar: Avatar {
                    wall_offset,
                    speed,
                    sway: *sway,
                },
            };
        }
        // By its own momentum.
        let own = (object_velocity + S::HALF * alpha * h) * h + moment_times(self.object_mobility);
        let by = if self.placement { placed } else { own };
        Moved {
            object: Displacement { by, velocity },
            shift: by - own,
            avatar: Avatar {
                speed,
                sway: *sway,
                ..Avatar::default()
            },
        }
    }
}

/// What an interval does to the object.
pub(super) struct Moved<S> {
    pub object: Displacement<S>,
    /// How far placement shifts it `[m]`.
    pub shift: S,
    pub avatar: Avatar<S>,
}

/// What a damping does to an interval of relative motion.
struct Damped<S> {
    /// Change of the penetration at the interval's end `[m]`.
    penetration: S,
    /// Change of its rate `[m/s]`.
    speed: S,
    /// Integral of the acceleration by the damping `[m/s]`.
    pushed: S,
}

/// What the damping of hand and device does to the relative motion beyond the ramp under the force that
/// is held. The ideal device's velocity follows the contact force as it comes and goes; what it deviates
/// from a straight line is the device's share of how p' does,
///
/// ```text
/// p'' = ... - c (p' - p'_line),    c = lambda theta / (theta + 1/M)
/// ```
///
/// to the first order of c, kept below 2/h, where the oscillation is gone after one interval. Nothing
/// else takes energy from the oscillation of an object that lies on the device: the held force, its
/// mean, shows the device next to nothing of it. `damping_rate`: lambda, as far as it is certain.
fn damped<S: Scalar>(
    damping_rate: S,
    device: &EstimatedMotion<S>,
    drive: &Drive<S>,
    start: Relative<S>,
    course: &Course<S>,
    response: &Response<S>,
    h: S,
) -> Damped<S> {
    let none = Damped {
        penetration: S::ZERO,
        speed: S::ZERO,
        pushed: S::ZERO,
    };
    // An estimate below zero would feed the oscillation.
    if course.impulse <= S::ZERO || drive.mobility <= S::ZERO || damping_rate <= S::ZERO {
        return none;
    }
    let rate = damping_rate * (device.mobility / drive.mobility);
    let c = rate / (S::ONE + S::HALF * rate * h);
    let Relative { penetration, speed } = start;
    let slope = (course.end.speed - speed) / h;
    let travelled = course.end.penetration - penetration;
    let by =
        |damping: S, acceleration: S, ramp: S| c * (damping + speed * acceleration + slope * ramp);
    Damped {
        penetration: by(
            response.damping[0],
            response.penetration[2],
            response.ramp[0],
        ),
        speed: by(response.damping[1], response.speed[2], response.ramp[1]),
        pushed: c * ((speed + S::HALF * slope * h) * h - travelled),
    }
}

/// What an interval holds, in the words that every method shares: `device_velocity` `[m/s]`, that of the
/// device's last step, says where an entry takes place.
pub(super) fn rule<S: Scalar>(interval: &Interval<S>, device_velocity: S) -> Rule<S> {
    let pressed = interval.start.penetration > S::ZERO;
    match interval.course.first_transition {
        None if interval.course.impulse > S::ZERO => Rule::Contact,
        None => Rule::Free,
        Some(after) if pressed => Rule::Leaves(after),
        Some(after) => Rule::Enters {
            after,
            held_at: device_velocity * after,
        },
    }
}
