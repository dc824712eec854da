//! Motion of the object against a device that continues at the velocity of its last step.

use crate::Scalar;
use crate::motion::{Displacement, ObjectMotion, Rule, Start};
use crate::relative_motion::{Drive, Relative};

/// Motion of the object under the contact spring and f_V over an interval, with the device at constant velocity.
pub(super) struct Extrapolated<S> {
    /// Displacement of the object.
    pub moved: Displacement<S>,
    /// Integral of the contact force `[N s]`.
    pub impulse: S,
    /// First transition of the contact, as a rule of the two-mode object.
    pub rule: Rule<S>,
}

impl<S: Scalar> Extrapolated<S> {
    /// Returns the motion from `start` over `duration` `[s]`, with any number of transitions.
    pub fn over(motion: &ObjectMotion<S>, start: &Start<S>, duration: S) -> Self {
        let from = Relative {
            penetration: start.penetration,
            speed: start.device_velocity - start.object_velocity,
        };
        let drive = Drive {
            stiffness: motion.stiffness(),
            mobility: motion.mobility(),
            acceleration: S::ZERO - start.virtual_force * motion.mobility(),
        };
        let course = drive.over(from, duration);
        // Without a force, the difference of penetrations adds rounding to the flight. A wall flies nowhere.
        let moved = if motion.is_wall() || course.impulse == S::ZERO {
            motion.fly(start, duration)
        } else {
            let travel = start.device_velocity * duration;
            Displacement {
                by: travel - (course.end.penetration - start.penetration),
                velocity: start.device_velocity - course.end.speed,
            }
        };
        let rule = match course.first_transition {
            None if course.impulse > S::ZERO => Rule::Contact,
            None => Rule::Free,
            Some(after) if start.penetration > S::ZERO => Rule::Leaves(after),
            Some(after) => Rule::Enters {
                after,
                held_at: start.device_velocity * after,
            },
        };
        Self {
            moved,
            impulse: course.impulse,
            rule,
        }
    }
}
