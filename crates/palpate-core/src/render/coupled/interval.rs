//! One interval of coupled rendering: the relative motion of device and object, and the resulting motion of the object
//! while the device feels the held force.

use super::Coupled;
use crate::Scalar;
use crate::actuator::Held;
use crate::motion::{Displacement, ObjectMotion, Rule};
use crate::relative_motion::{Course, Drive, Relative};
use crate::render::method::Ended;
use crate::render::predict::{EstimatedMotion, Sway};
use crate::response::Response;

/// Proxy of the device in the contact. CHAI3D's proxy is constrained to the surface; this one is not.
///
/// The contact acts continuously and the held force does not, so the position that results from the contact force is
/// not that of the device. The relative motion is that of the proxy. At the end of the window that a command governs,
/// proxy and device have the same velocity. If a window ends between two samples, the velocities differ at each sample.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ProxyState<S> {
    /// Offset of a wall from its true position, which gives the device the proxy's penetration `[m]`: the proxy is
    /// behind the device by the same distance. An object has no separate offset; it moves from its shifted position.
    pub wall_offset: S,
    /// Velocity of the proxy minus that of the device `[m/s]`.
    pub speed: S,
    /// Stretch of the proxy's transmission: that of the device under the contact force.
    pub sway: Sway<S>,
    /// Whether the contact had its largest force since a wall was last at its place.
    pub was_limited: bool,
    /// Whether tracking began inside a wall and the device has not yet felt the whole force.
    pub comes_in: bool,
}

impl<S: Scalar> ProxyState<S> {
    /// Takes an `interval` that has ended: its force is whole if nothing has reduced it.
    pub fn learn_whether_whole(&mut self, ended: &Ended<S>, interval: &Interval<S>) {
        let intended = ended.intended_force;
        let is_whole = intended > S::ZERO && ended.held.mean >= S::from_f64(WHOLE_FROM) * intended;
        self.comes_in &= !is_whole && interval.course.impulse > S::ZERO;
    }
}

/// Part of the intended force from which it counts as whole.
const WHOLE_FROM: f64 = 0.999;

/// Time constant of a wall in contact for the return to its true position `[s]`. A return while the force changes
/// generates energy, so it is much slower than a collision.
const WALL_RETURN: f64 = 0.2;
/// Largest part of the offset that a wall returns in one interval: with a stiff wall in a slow loop, a larger part
/// would also generate energy.
const WALL_RETURN_MOST: f64 = 0.03;
/// Bound of a wall's offset: this factor times the distance that the contact's impulse moves the device in one
/// interval. It limits the energy that an adversary who moves the device can extract from the wall.
const WALL_OFFSET_MOST: f64 = 16.0;

/// Part of the residual impulse that the next force corrects. A correction of the whole residual turns the noise of one
/// estimate into a force of the opposite sign in the next interval. On random plants a half has the smallest error,
/// with and without delay.
const REPAID: f64 = 0.5;

/// A wall's proxy may be faster than the device. The next force corrects that difference with an impulse of at most
/// kappa times this factor times the contact's impulse, and never more than the contact's impulse. Without this bound,
/// an adversary who moves the device extracts more energy from a wall. With a larger factor, a soft wall with an
/// unmodelled delay alternates between two forces; with a smaller one, the oscillation of a stiff wall persists.
const REPAID_BY_WALLS: f64 = 0.3;

/// Motion over one interval: the drive of the relative motion, and its course.
pub(super) struct Interval<S> {
    pub start: Relative<S>,
    pub(super) drive: Drive<S>,
    /// Rate of the drive's acceleration `[m/s^3]`.
    ramp: S,
    pub course: Course<S>,
    /// Stretch of the proxy's transmission at the end.
    sway: Sway<S>,
    /// Whether the contact had its largest force in a part of the interval.
    pub is_saturated: bool,
    /// Duration `[s]`.
    pub duration: S,
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

    /// Returns the sensitivity of the end of an interval to its start; `None` if whole bounces were skipped.
    pub(super) fn response(
        &self,
        interval: &Interval<S>,
        device: &EstimatedMotion<S>,
        sway: Sway<S>,
    ) -> Option<Response<S>> {
        let Interval {
            drive,
            start,
            duration,
            ..
        } = interval;
        match &self.flexure {
            None => {
                let (_, response, _) = self.saturation.over_with_response(drive, *start, *duration);
                response
            }
            Some(flexure) => {
                let mobility = device.mobility;
                let (_, response, _) =
                    flexure.over_with_response(drive, mobility, *start, sway, *duration);
                response
            }
        }
    }

    /// Computes the motion over an interval that has ended, with the changes of the device's external acceleration
    /// under the held force, and the sensitivity of its end to its start.
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

    /// Computes the motion of the object in the interval while the device feels the force `held`, the resulting shift
    /// of the object, and the proxy at the end.
    pub(super) fn object_moved(
        &self,
        interval: &Interval<S>,
        device: &EstimatedMotion<S>,
        object_velocity: S,
        virtual_force: S,
        held: &Held<S>,
        proxy: &ProxyState<S>,
    ) -> Moved<S> {
        let Interval {
            start,
            drive,
            ramp,
            course,
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
            return self.wall_moved(interval, device, proxy, placed, speed);
        }
        // Motion by the object's own momentum.
        let own = (object_velocity + S::HALF * alpha * h) * h + moment_times(self.object_mobility);
        let by = if self.placement { placed } else { own };
        Moved {
            object: Displacement { by, velocity },
            shift: by - own,
            proxy: ProxyState {
                speed,
                sway: interval.sway,
                ..ProxyState::default()
            },
        }
    }

    /// Computes the same for a wall: its offset after the interval, if placement would displace it by `placed` `[m]`
    /// and the proxy is faster than the device by `speed` `[m/s]`.
    #[inline(always)]
    fn wall_moved(
        &self,
        interval: &Interval<S>,
        device: &EstimatedMotion<S>,
        proxy: &ProxyState<S>,
        placed: S,
        speed: S,
    ) -> Moved<S> {
        let Interval {
            course,
            sway,
            duration: h,
            ..
        } = interval;
        let h = *h;
        let back = (h / S::from_f64(WALL_RETURN)).min(S::from_f64(WALL_RETURN_MOST));
        if proxy.comes_in {
            // A soft start or a delay withholds the force that would move the device. A wall that followed the proxy
            // would come to a device at rest, which would never feel it.
            return Moved::wall(
                proxy.wall_offset,
                ProxyState {
                    wall_offset: (S::ONE - back) * proxy.wall_offset,
                    speed: S::ZERO,
                    sway: *sway,
                    ..*proxy
                },
            );
        }
        let gives_way = self.placement && device.mobility > S::ZERO;
        let was_limited = interval.is_saturated || proxy.was_limited;
        let wall_offset = if course.impulse > S::ZERO && gives_way {
            let most = S::from_f64(WALL_OFFSET_MOST) * device.mobility * course.impulse * h;
            let most = most.max(proxy.wall_offset.abs());
            (S::ONE - back) * (proxy.wall_offset + placed).within(most)
        } else if was_limited && proxy.wall_offset < S::ZERO {
            // A wall that goes back at once is farther away from the device: the hand's work over this distance is
            // generated energy. Without a limit it averages out over the collisions; with one, a device in a hand
            // that presses can keep bouncing at one phase of the samples.
            (S::ONE - back) * proxy.wall_offset
        } else {
            // The offset is kept while the wall stays free.
            let apart = self.flexure.map_or(S::ZERO, |it| it.behind(sway));
            (proxy.wall_offset + course.end.penetration - apart)
                .max(S::ZERO)
                .min(proxy.wall_offset.max(S::ZERO))
        };
        Moved::wall(
            proxy.wall_offset,
            ProxyState {
                wall_offset,
                speed,
                sway: *sway,
                was_limited: was_limited && wall_offset != S::ZERO,
                comes_in: false,
            },
        )
    }
}

/// Motion of the object in an interval.
pub(super) struct Moved<S> {
    pub object: Displacement<S>,
    /// Shift of the object by placement `[m]`.
    pub shift: S,
    pub proxy: ProxyState<S>,
}

impl<S: Scalar> Moved<S> {
    /// Returns the motion of a wall from its offset `before` `[m]` to that of `proxy`.
    #[inline(always)]
    fn wall(before: S, proxy: ProxyState<S>) -> Self {
        let by = proxy.wall_offset - before;
        Self {
            object: Displacement {
                by,
                velocity: S::ZERO,
            },
            shift: by,
            proxy,
        }
    }
}

/// Effect of damping on an interval of relative motion.
struct Damped<S> {
    /// Change of the penetration at the interval's end `[m]`.
    penetration: S,
    /// Change of its rate `[m/s]`.
    speed: S,
    /// Integral of the acceleration by the damping `[m/s]`.
    pushed: S,
}

/// Computes the effect of damping in hand and device on the relative motion, beyond the ramp under the held force. The
/// velocity of the ideal device follows the variations of the contact force. Its deviation from a straight line is the
/// device's share of the deviation of p':
///
/// ```text
/// p'' = ... - c (p' - p'_line),    c = lambda theta / (theta + 1/M)
/// ```
///
/// to first order in c, which is limited to below 2/h, where the oscillation vanishes after one interval. No other term
/// removes energy from the oscillation of an object that lies on the device: the held force is its mean and hardly
/// transmits it to the device. `damping_rate`: the certain part of lambda.
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
    // A negative estimate would feed the oscillation.
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

/// Returns the impulse by which the force of the next interval corrects past errors `[N s]`: for an object a part of
/// `residual` `[N s]`, and for a wall the impulse that removes the speed of its proxy, within a bound.
#[inline(always)]
pub(super) fn repaid<S: Scalar>(
    motion: &ObjectMotion<S>,
    device: &EstimatedMotion<S>,
    proxy: &ProxyState<S>,
    interval: &Interval<S>,
    residual: S,
) -> S {
    if !motion.is_wall() {
        S::from_f64(REPAID) * residual
    } else if device.mobility > S::ZERO {
        let period = interval.duration;
        let kappa = motion.stiffness() * device.mobility * period * period;
        let most = (S::from_f64(REPAID_BY_WALLS) * kappa).min(S::ONE) * interval.course.impulse;
        (S::ZERO - proxy.speed / device.mobility).within(most)
    } else {
        S::ZERO
    }
}

/// Returns the rule of an interval in the form shared by all methods. `device_velocity` `[m/s]`, that of the device's
/// last step, determines the position of an entry.
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
