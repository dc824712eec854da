//! A flexible transmission between the motor, where the sensor is, and the rest of the device.

use crate::Scalar;
use crate::actuation::Transmission;
use crate::actuator::Held;
use crate::relative_motion::{Course, Drive, Relative};
use crate::response::Response;

/// A device of two masses with a spring between them.
///
/// The motor's side has the part 1 - phi of the mass m. With the centre of mass X, the stretch d of the
/// spring from where it rests, and the force f on the object, at the motor:
///
/// ```text
/// x = X - phi d,   X'' = a_u - theta f,   d'' = -omega^2 d - 2 zeta omega d' + theta f / (1 - phi)
/// ```
///
/// X moves as a rigid device does. So the observer and the books of an interval follow X, and only the
/// contact, which is at the motor, needs d. A slow force stretches the spring without moving it: d leaves
/// that part out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flexure<S> {
    /// omega^2 `[1/s^2]`.
    stiffness: S,
    /// 2 zeta omega `[1/s]`.
    damping: S,
    /// phi.
    fraction: S,
    /// 1 / (1 - phi).
    of_motor: S,
    /// Longest step `[s]`.
    longest_step: S,
}

/// How far the spring of a transmission is stretched.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sway<S> {
    /// d `[m]`.
    stretch: S,
    /// d' `[m/s]`.
    speed: S,
}

/// Longest step in radians of the resonance: the steps' error of its frequency is 1/24 of the square of
/// this, 0.3 %, less than a calibration's.
const LONGEST_ANGLE: f64 = 0.25;
/// Most steps in an interval: a resonance that is too fast for them is taken for the fastest that is not.
const MOST_STEPS: f64 = 16.0;

impl<S: Scalar> Flexure<S> {
    /// Of a transmission without faults.
    pub fn new(transmission: &Transmission<S>) -> Self {
        let Transmission {
            resonance,
            damping_ratio,
            flexible_mass_fraction: fraction,
        } = *transmission;
        let omega = S::from_f64(core::f64::consts::TAU) * resonance;
        Self {
            stiffness: omega * omega,
            damping: S::TWO * damping_ratio * omega,
            fraction,
            of_motor: S::ONE / (S::ONE - fraction),
            longest_step: S::from_f64(LONGEST_ANGLE) / omega,
        }
    }

    /// By how much the motor is behind the centre of mass `[m]`.
    #[inline]
    pub fn behind(&self, sway: &Sway<S>) -> S {
        self.fraction * sway.stretch
    }

    /// Number of steps over `h` `[s]`, and the duration of one `[s]`.
    fn steps(&self, h: S) -> (S, S) {
        let wanted = (h / self.longest_step).floor() + S::ONE;
        let steps = wanted.max(S::ONE).min(S::from_f64(MOST_STEPS));
        (steps, h / steps)
    }

    /// The first half of a step, and the second, of the spring's force on the stretch.
    #[inline]
    fn kick(&self, sway: &mut Sway<S>, half: S, is_second: bool) {
        let pushed = sway.speed - self.stiffness * sway.stretch * half;
        sway.speed = if is_second {
            pushed / (S::ONE + self.damping * half)
        } else {
            pushed - self.damping * sway.speed * half
        };
    }

    /// The stretch after `h` `[s]` of the force `held` on the object, on a device of 1/m = `mobility`.
    pub fn under(&self, sway: Sway<S>, mobility: S, held: &Held<S>, h: S) -> Sway<S> {
        let mut sway = sway;
        let (steps, step) = self.steps(h);
        let per_force = mobility * self.of_motor;
        // A straight line with the impulse and the moment of what was held.
        let slope = S::from_f64(-12.0) * held.lead / (h * h * h);
        let mut number = S::ZERO;
        while number < steps {
            self.kick(&mut sway, S::HALF * step, false);
            let middle = (number + S::HALF) * step - S::HALF * h;
            let force = held.mean + slope * middle;
            let moment = (S::HALF * force - slope * step * S::from_f64(1.0 / 12.0)) * step * step;
            sway.stretch += sway.speed * step + per_force * moment;
            sway.speed += per_force * force * step;
            self.kick(&mut sway, S::HALF * step, true);
            number += S::ONE;
        }
        sway
    }

    /// The relative motion of object and centre of mass over `h` `[s]`, from `start`, where the contact is
    /// at the motor: `rigid` is what moves them against each other, `mobility` the device's 1/m. With the
    /// stretch at its end.
    pub fn over(
        &self,
        rigid: &Drive<S>,
        mobility: S,
        start: Relative<S>,
        sway: Sway<S>,
        h: S,
    ) -> (Course<S>, Sway<S>) {
        let mut motion = Swaying::new(self, rigid, mobility, start, sway);
        let (steps, step) = self.steps(h);
        let mut number = S::ZERO;
        while number < steps {
            self.kick(&mut motion.sway, S::HALF * step, false);
            let course = motion.drive.over(motion.at_motor(), step);
            motion.take(&course, step, number * step);
            self.kick(&mut motion.sway, S::HALF * step, true);
            number += S::ONE;
        }
        (motion.course, motion.sway)
    }

    /// The same, with how its end answers to what it starts from, as
    /// [`Drive::over_with_response`] says of a rigid device: by the stretch it starts from none is asked.
    pub fn over_with_response(
        &self,
        rigid: &Drive<S>,
        mobility: S,
        start: Relative<S>,
        sway: Sway<S>,
        h: S,
    ) -> (Course<S>, Option<Response<S>>, Sway<S>) {
        let mut motion = Swaying::new(self, rigid, mobility, start, sway);
        let mut changes = Some(Changes::none_yet());
        let (steps, step) = self.steps(h);
        let half = S::HALF * step;
        let mut number = S::ZERO;
        while number < steps {
            let began = number * step;
            self.kick(&mut motion.sway, half, false);
            changes = changes.map(|it| it.kicked(self, &motion, half, began, false));
            let (course, response) = motion.drive.over_with_response(motion.at_motor(), step);
            changes = match (changes, &response) {
                (Some(changes), Some(response)) => {
                    Some(changes.after(self, &motion, &course, response, step))
                }
                _ => None,
            };
            motion.take(&course, step, began);
            self.kick(&mut motion.sway, half, true);
            changes = changes.map(|it| it.kicked(self, &motion, half, began + step, true));
            number += S::ONE;
        }
        let response = changes.map(|it| it.response(h));
        (motion.course, response, motion.sway)
    }
}

/// Centre of mass, object and stretch in motion.
struct Swaying<S> {
    fraction: S,
    /// What moves object and centre of mass against each other, and object and motor.
    rigid: Drive<S>,
    drive: Drive<S>,
    /// What a newton does to the stretch `[1/kg]`.
    per_force: S,
    /// Of the centre of mass.
    course: Course<S>,
    sway: Sway<S>,
}

impl<S: Scalar> Swaying<S> {
    fn new(
        flexure: &Flexure<S>,
        rigid: &Drive<S>,
        mobility: S,
        start: Relative<S>,
        sway: Sway<S>,
    ) -> Self {
        let per_force = mobility * flexure.of_motor;
        Self {
            fraction: flexure.fraction,
            rigid: *rigid,
            drive: Drive {
                mobility: rigid.mobility + flexure.fraction * per_force,
                ..*rigid
            },
            per_force,
            course: Course {
                end: start,
                impulse: S::ZERO,
                first_transition: None,
            },
            sway,
        }
    }

    fn at_motor(&self) -> Relative<S> {
        Relative {
            penetration: self.course.end.penetration - self.fraction * self.sway.stretch,
            speed: self.course.end.speed - self.fraction * self.sway.speed,
        }
    }

    /// Integral of (h - s) f(s) over a step that goes as `course` says, from here.
    fn moment(&self, course: &Course<S>, h: S) -> S {
        if self.drive.mobility > S::ZERO {
            let at = self.at_motor();
            let flown = at.penetration + (at.speed + S::HALF * self.drive.acceleration * h) * h;
            (flown - course.end.penetration) / self.drive.mobility
        } else {
            S::ZERO
        }
    }

    /// A step that goes as `course` says, which began `before` after the interval `[s]`.
    fn take(&mut self, course: &Course<S>, h: S, before: S) {
        let (moment, impulse) = (self.moment(course, h), course.impulse);
        let (a, mobility) = (self.rigid.acceleration, self.rigid.mobility);
        let end = &mut self.course.end;
        end.penetration += (end.speed + S::HALF * a * h) * h - mobility * moment;
        end.speed += a * h - mobility * impulse;
        self.sway.stretch += self.sway.speed * h + self.per_force * moment;
        self.sway.speed += self.per_force * impulse;
        self.course.impulse += impulse;
        let transition = course.first_transition.map(|after| before + after);
        self.course.first_transition = self.course.first_transition.or(transition);
    }
}

/// Derivatives of a motion by what it starts from: by penetration, speed, acceleration and mobility, and by
/// a ramp and a damping as in [`Response`].
#[derive(Clone, Copy)]
struct Changes<S>([Change<S>; 6]);

/// One of them.
#[derive(Clone, Copy)]
struct Change<S> {
    penetration: S,
    speed: S,
    stretch: S,
    stretching: S,
}

const BY_ACCELERATION: usize = 2;
const BY_MOBILITY: usize = 3;
const BY_RAMP: usize = 4;
const BY_DAMPING: usize = 5;

impl<S: Scalar> Changes<S> {
    fn none_yet() -> Self {
        let none = Change {
            penetration: S::ZERO,
            speed: S::ZERO,
            stretch: S::ZERO,
            stretching: S::ZERO,
        };
        let mut changes = [none; 6];
        changes[0].penetration = S::ONE;
        changes[1].speed = S::ONE;
        Self(changes)
    }

    /// Half a step of the spring's force, of the ramp, and of the damping, `at` so long after the beginning.
    fn kicked(
        mut self,
        flexure: &Flexure<S>,
        motion: &Swaying<S>,
        half: S,
        at: S,
        is_second: bool,
    ) -> Self {
        for change in &mut self.0 {
            let mut sway = Sway {
                stretch: change.stretch,
                speed: change.stretching,
            };
            flexure.kick(&mut sway, half, is_second);
            change.stretching = sway.speed;
        }
        self.0[BY_RAMP].speed += half * at;
        self.0[BY_DAMPING].speed -= half * motion.course.end.speed;
        self
    }

    /// Over a step from `motion` that goes as `course` and its `response` say.
    fn after(
        mut self,
        flexure: &Flexure<S>,
        motion: &Swaying<S>,
        course: &Course<S>,
        response: &Response<S>,
        h: S,
    ) -> Self {
        let (fraction, of_motor) = (flexure.fraction, flexure.of_motor);
        let (mobility, moment) = (motion.drive.mobility, motion.moment(course, h));
        for (by, change) in self.0.iter_mut().enumerate() {
            let acceleration = if by == BY_ACCELERATION { S::ONE } else { S::ZERO };
            let (rigid, at_motor) = if by == BY_MOBILITY {
                (S::ONE, of_motor)
            } else {
                (S::ZERO, S::ZERO)
            };
            let from = [
                change.penetration - fraction * change.stretch,
                change.speed - fraction * change.stretching,
                acceleration,
                at_motor,
            ];
            let sum = |row: &[S; 4]| {
                let mut sum = S::ZERO;
                for (entry, by) in row.iter().zip(from) {
                    sum += *entry * by;
                }
                sum
            };
            let (end, faster) = (sum(&response.penetration), sum(&response.speed));
            let (mut impulse, mut of_moment) = (S::ZERO, S::ZERO);
            if mobility > S::ZERO {
                let flown = from[0] + (from[1] + S::HALF * acceleration * h) * h;
                impulse = (acceleration * h + from[1] - faster - at_motor * course.impulse) / mobility;
                of_moment = (flown - end - at_motor * moment) / mobility;
            }
            let own = motion.rigid.mobility;
            change.penetration += (change.speed + S::HALF * acceleration * h) * h
                - own * of_moment
                - rigid * moment;
            change.speed += acceleration * h - own * impulse - rigid * course.impulse;
            change.stretch +=
                change.stretching * h + motion.per_force * of_moment + at_motor * moment;
            change.stretching += motion.per_force * impulse + at_motor * course.impulse;
        }
        self
    }

    fn response(&self, duration: S) -> Response<S> {
        let [a, b, c, d, ramp, damping] = self.0;
        Response::of(
            [a, b, c, d].map(|change| change.penetration),
            [a, b, c, d].map(|change| change.speed),
            [ramp.penetration, ramp.speed],
            [damping.penetration, damping.speed],
            duration,
        )
    }
}
