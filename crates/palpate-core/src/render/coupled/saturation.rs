//! Contact with a limited force: a spring up to the force limit, and that force beyond it.
//!
//! ```text
//! p'' = a - mu min(K p, L)
//! ```
//!
//! A device that is pressed in against a limited force has stored less energy than `K p^2/2`, and receives less energy
//! back. The prediction must therefore include the limit. Beyond `L/K` the motion is a parabola.

use crate::Scalar;
use crate::relative_motion::{Course, Drive, Relative};
use crate::response::{Part, Response};

/// The limit of a contact's force.
#[derive(Clone, Copy, Debug)]
pub(super) struct Saturation<S> {
    /// Largest force L `[N]`; infinite without a limit.
    pub force: S,
    /// Penetration at which the spring has this force `[m]`.
    pub penetration: S,
}

/// Maximum number of changes between spring and largest force in an interval. Afterwards the motion continues with the
/// spring.
const MAX_CHANGES: usize = 4;

/// Continuation of the motion.
enum Next<S> {
    /// With the spring to the end.
    Spring,
    /// With the spring until its force is the largest one, after this time `[s]`.
    Saturates(S),
    /// With the largest force, for this time `[s]`.
    Saturated(S),
}

impl<S: Scalar> Saturation<S> {
    /// Returns the motion, and whether the force was the largest one for a part of it.
    #[inline]
    pub fn over(&self, drive: &Drive<S>, start: Relative<S>, duration: S) -> (Course<S>, bool) {
        if self.is_out_of_reach(drive, start, duration) {
            (drive.over(start, duration), false)
        } else {
            let (course, _, is_saturated) = self.follow(drive, start, duration);
            (course, is_saturated)
        }
    }

    /// Returns the motion with its response.
    #[inline]
    pub fn over_with_response(
        &self,
        drive: &Drive<S>,
        start: Relative<S>,
        duration: S,
    ) -> (Course<S>, Option<Response<S>>, bool) {
        if self.is_out_of_reach(drive, start, duration) {
            let (course, response) = drive.over_with_response(start, duration);
            (course, response, false)
        } else {
            self.follow(drive, start, duration)
        }
    }

    fn is_out_of_reach(&self, drive: &Drive<S>, start: Relative<S>, duration: S) -> bool {
        let pushed = drive.acceleration.max(S::ZERO) * duration;
        let way = (start.speed.max(S::ZERO) + S::HALF * pushed) * duration;
        start.penetration + way <= self.penetration
    }

    // Not inlined: most intervals stay below the limit.
    #[inline(never)]
    fn follow(
        &self,
        drive: &Drive<S>,
        start: Relative<S>,
        duration: S,
    ) -> (Course<S>, Option<Response<S>>, bool) {
        let mut response = Some(Response::none_yet());
        let mut sum = Course {
            end: start,
            impulse: S::ZERO,
            first_transition: None,
        };
        let mut left = duration;
        let mut is_saturated = start.penetration > self.penetration;
        let mut was_saturated = is_saturated;
        for _ in 0..MAX_CHANGES {
            let (h, course) = match self.next(drive, sum.end, left, is_saturated) {
                Next::Spring => break,
                Next::Saturates(h) => {
                    let course = self.spring(drive, sum.end, h, &mut response);
                    (h, course)
                }
                Next::Saturated(h) => (h, self.saturated(drive, sum.end, h, &mut response)),
            };
            sum = joined(&sum, course, duration - left);
            left -= h;
            was_saturated = true;
            is_saturated = !is_saturated;
            if left <= S::ZERO {
                return (sum, response, was_saturated);
            }
        }
        let course = self.spring(drive, sum.end, left, &mut response);
        (
            joined(&sum, course, duration - left),
            response,
            was_saturated,
        )
    }

    fn spring(
        &self,
        drive: &Drive<S>,
        at: Relative<S>,
        h: S,
        response: &mut Option<Response<S>>,
    ) -> Course<S> {
        match response.take() {
            None => drive.over(at, h),
            Some(so_far) => {
                let (course, after) = drive.over_with_response_after(at, h, so_far);
                *response = after;
                course
            }
        }
    }

    fn saturated(
        &self,
        drive: &Drive<S>,
        at: Relative<S>,
        h: S,
        response: &mut Option<Response<S>>,
    ) -> Course<S> {
        let pushed = Drive {
            acceleration: self.acceleration(drive),
            ..*drive
        };
        *response = response.take().and_then(|so_far| {
            let mut after = so_far.after(&pushed, Part::Free(at, h))?;
            after.penetration[3] -= S::HALF * self.force * h * h;
            after.speed[3] -= self.force * h;
            Some(after)
        });
        Course {
            end: Relative {
                penetration: at.penetration + (at.speed + S::HALF * pushed.acceleration * h) * h,
                speed: at.speed + pushed.acceleration * h,
            },
            impulse: self.force * h,
            first_transition: None,
        }
    }

    /// Returns the acceleration of the relative motion with the largest force `[m/s^2]`.
    fn acceleration(&self, drive: &Drive<S>) -> S {
        drive.acceleration - drive.mobility * self.force
    }

    fn next(&self, drive: &Drive<S>, at: Relative<S>, left: S, is_saturated: bool) -> Next<S> {
        if is_saturated {
            let until = rises(
                self.penetration - at.penetration,
                S::ZERO - at.speed,
                S::ZERO - self.acceleration(drive),
            );
            return Next::Saturated(until.map_or(left, |until| until.min(left)));
        }
        let mut free = S::ZERO;
        let mut from = at;
        if at.penetration < S::ZERO {
            let Some(until) = rises(at.penetration, at.speed, drive.acceleration) else {
                return Next::Spring;
            };
            free = until;
            from = Relative {
                penetration: S::ZERO,
                speed: at.speed + drive.acceleration * until,
            };
        }
        let omega = (drive.stiffness * drive.mobility).sqrt();
        if from.speed <= S::ZERO || omega <= S::ZERO {
            return Next::Spring;
        }
        // p = centre + x cos(omega t) + v/omega sin(omega t) reaches the limit for the first time.
        let centre = drive.acceleration / (omega * omega);
        let (x, y) = (from.penetration - centre, from.speed / omega);
        let aim = self.penetration - centre;
        let square = x * x + y * y - aim * aim;
        if square < S::ZERO {
            return Next::Spring;
        }
        // tan(omega t/2) of the smaller root, without cancellation.
        let divisor = y + square.sqrt();
        let until = free + ((aim - x) / divisor).atan2(S::ONE) * S::from_f64(2.0) / omega;
        if until < left && until >= S::ZERO {
            Next::Saturates(until)
        } else {
            Next::Spring
        }
    }
}

/// Returns the time at which `from + speed t + acceleration t^2/2`, with `from` not above 0, rises through 0.
fn rises<S: Scalar>(from: S, speed: S, acceleration: S) -> Option<S> {
    let square = speed * speed - (from + from) * acceleration;
    if square < S::ZERO {
        return None;
    }
    // The form without cancellation.
    let (above, below) = if speed < S::ZERO {
        (square.sqrt() - speed, acceleration)
    } else {
        (S::ZERO - (from + from), speed + square.sqrt())
    };
    (below > S::ZERO).then(|| above / below)
}

fn joined<S: Scalar>(before: &Course<S>, course: Course<S>, at: S) -> Course<S> {
    let transition = course.first_transition.map(|after| at + after);
    Course {
        impulse: before.impulse + course.impulse,
        first_transition: before.first_transition.or(transition),
        ..course
    }
}
