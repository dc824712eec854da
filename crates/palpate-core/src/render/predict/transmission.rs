//! Flexible transmission between the motor, which carries the sensor, and the rest of the device.

use crate::Scalar;
use crate::actuation::Transmission;
use crate::actuator::Held;
use crate::relative_motion::{Course, Drive, Relative};
use crate::response::Response;

/// A device of two masses with a spring between them.
///
/// The motor's side has the fraction 1 - phi of the mass m. With the centre of mass X, the stretch d of the spring from
/// rest, and the force f on the object, at the motor:
///
/// ```text
/// x = X - phi d,   X'' = a_u - theta f,   d'' = -omega^2 d - 2 zeta omega d' + theta f / (1 - phi)
/// ```
///
/// X moves as a rigid device does. Observer and interval prediction therefore use X, and only the contact, which acts
/// at the motor, needs d. A slow force stretches the spring quasi-statically: d excludes that part.
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

/// Stretch of the spring of a transmission.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sway<S> {
    /// d `[m]`.
    stretch: S,
    /// d' `[m/s]`.
    speed: S,
}

/// Longest step in radians of the resonance: the relative error of its frequency is 1/24 of the square of this, 0.3 %,
/// less than that of a calibration.
const LONGEST_ANGLE: f64 = 0.25;
/// Maximum number of steps in an interval: a faster resonance is replaced by the fastest that they resolve.
const MAX_STEPS: f64 = 16.0;

impl<S: Scalar> Flexure<S> {
    /// Creates the model of a valid transmission.
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

    /// Returns the distance of the motor behind the centre of mass `[m]`.
    #[inline]
    pub fn behind(&self, sway: &Sway<S>) -> S {
        self.fraction * sway.stretch
    }

    /// Returns the number of steps over `h` `[s]`, and the duration of one `[s]`.
    fn steps(&self, h: S) -> (S, S) {
        let wanted = (h / self.longest_step).floor() + S::ONE;
        let steps = wanted.max(S::ONE).min(S::from_f64(MAX_STEPS));
        (steps, h / steps)
    }

    /// Applies the spring's force to the stretch in the first or second half of a step.
    #[inline]
    fn kick(&self, sway: &mut Sway<S>, half: S, is_second: bool) {
        let pushed = sway.speed - self.stiffness * sway.stretch * half;
        sway.speed = if is_second {
            pushed / (S::ONE + self.damping * half)
        } else {
            pushed - self.damping * sway.speed * half
        };
    }

    /// Returns the stretch after `h` `[s]` of the force `held` on the object, on a device of 1/m = `mobility`.
    pub fn under(&self, sway: Sway<S>, mobility: S, held: &Held<S>, h: S) -> Sway<S> {
        let mut sway = sway;
        let (steps, step) = self.steps(h);
        let per_force = mobility * self.of_motor;
        // A linear force with the impulse and moment of the held one.
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

    /// Computes the relative motion of object and centre of mass over `h` `[s]` from `start`, with the contact at the
    /// motor, and the stretch at the end. `rigid` is the drive of the relative motion, `mobility` the device's 1/m.
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

    /// Computes the same motion with the sensitivity of its end to its start, as [`Drive::over_with_response`] does for
    /// a rigid device. The sensitivity to the initial stretch is omitted.
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
    /// Drives of the relative motion of object and centre of mass, and of object and motor.
    rigid: Drive<S>,
    drive: Drive<S>,
    /// Acceleration of the stretch per newton `[1/kg]`.
    per_force: S,
    /// Course of the centre of mass.
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

    /// Returns the integral of (h - s) f(s) over a step with the given `course`.
    fn moment(&self, course: &Course<S>, h: S) -> S {
        if self.drive.mobility > S::ZERO {
            let at = self.at_motor();
            let flown = at.penetration + (at.speed + S::HALF * self.drive.acceleration * h) * h;
            (flown - course.end.penetration) / self.drive.mobility
        } else {
            S::ZERO
        }
    }

    /// Adds a step with the given `course`, which began `before` `[s]` after the interval.
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

/// Derivatives of a motion by its start: by penetration, speed, acceleration and mobility, and by a ramp and a damping
/// as in [`Response`].
#[derive(Clone, Copy)]
struct Changes<S>([Change<S>; 6]);

/// One of the derivatives.
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

    /// Applies half a step of the spring's force, of the ramp, and of the damping, `at` after the beginning.
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

    /// Advances the derivatives over a step from `motion` with the given `course` and `response`.
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
            let acceleration = if by == BY_ACCELERATION {
                S::ONE
            } else {
                S::ZERO
            };
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
                impulse =
                    (acceleration * h + from[1] - faster - at_motor * course.impulse) / mobility;
                of_moment = (flown - end - at_motor * moment) / mobility;
            }
            let own = motion.rigid.mobility;
            change.penetration +=
                (change.speed + S::HALF * acceleration * h) * h - own * of_moment - rigid * moment;
            change.speed += acceleration * h - own * impulse - rigid * course.impulse;
            change.stretch +=
                change.stretching * h + motion.per_force * of_moment + at_motor * moment;
            change.stretching += motion.per_force * impulse + at_motor * course.impulse;
        }
        self
    }

    fn response(&self, duration: S) -> Response<S> {
        let [a, b, c, d, ramp, damping] = self.0;
        Response::new(
            [a, b, c, d].map(|change| change.penetration),
            [a, b, c, d].map(|change| change.speed),
            [ramp.penetration, ramp.speed],
            [damping.penetration, damping.speed],
            duration,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A device of two masses and an object, integrated in short steps.
    struct TwoMasses {
        transmission: Transmission<f64>,
        mobility: f64,
        contact: Drive<f64>,
    }

    impl TwoMasses {
        /// Returns penetration and speed at the centre of mass, stretch and its rate, and the impulse of the contact or
        /// of `held`, after `h`. Motor, end and object each have their own equation, in steps of fourth order.
        fn after(
            &self,
            start: Relative<f64>,
            sway: Sway<f64>,
            held: Option<&Held<f64>>,
            h: f64,
        ) -> [f64; 5] {
            let Transmission {
                resonance,
                damping_ratio,
                flexible_mass_fraction: share,
            } = self.transmission;
            let mass = 1.0 / self.mobility;
            let (motor, end) = ((1.0 - share) * mass, share * mass);
            let reduced = motor * end / mass;
            let rate = core::f64::consts::TAU * resonance;
            let (stiffness, damping) =
                (reduced * rate * rate, 2.0 * damping_ratio * reduced * rate);
            let give = self.contact.mobility - self.mobility;
            let slope = held.map_or(0.0, |held| -12.0 * held.lead / (h * h * h));
            // Positions relative to the object's motion by its own forces; external forces are shared by mass.
            let slopes = |t: f64, [x, y, z, u, v, w, _]: [f64; 7]| {
                let spring = stiffness * (y - x) + damping * (v - u);
                let f = held.map_or_else(
                    || self.contact.stiffness * (x - z).max(0.0),
                    |held| held.mean + slope * (t - 0.5 * h),
                );
                let a = self.contact.acceleration;
                [
                    u,
                    v,
                    w,
                    (spring - f) / motor + a,
                    a - spring / end,
                    give * f,
                    f,
                ]
            };
            let motor_at = start.penetration - share * sway.stretch;
            let motor_speed = start.speed - share * sway.speed;
            let mut at = [
                motor_at,
                motor_at + sway.stretch,
                0.0,
                motor_speed,
                motor_speed + sway.speed,
                0.0,
                0.0,
            ];
            let steps = 4000;
            let dt = h / f64::from(steps);
            let plus =
                |at: [f64; 7], by: [f64; 7], dt: f64| core::array::from_fn(|i| at[i] + dt * by[i]);
            for i in 0..steps {
                let t = f64::from(i) * dt;
                let a = slopes(t, at);
                let b = slopes(t + 0.5 * dt, plus(at, a, 0.5 * dt));
                let c = slopes(t + 0.5 * dt, plus(at, b, 0.5 * dt));
                let d = slopes(t + dt, plus(at, c, dt));
                at = core::array::from_fn(|k| {
                    at[k] + dt / 6.0 * (a[k] + 2.0 * (b[k] + c[k]) + d[k])
                });
            }
            let [x, y, z, u, v, w, impulse] = at;
            let [of_motor, of_end] = [1.0 - share, share];
            [
                of_motor * x + of_end * y - z,
                of_motor * u + of_end * v - w,
                y - x,
                v - u,
                impulse,
            ]
        }
    }

    fn cases() -> impl Iterator<Item = (TwoMasses, Relative<f64>, Sway<f64>, f64)> {
        (0..200).map(|i| {
            let u = |k: u32| f64::from((i * 7919 + k * 104_729) % 1000) / 1000.0;
            let mobility = 2.0 + 10.0 * u(1);
            let contact = Drive {
                stiffness: 10f64.powf(2.5 + 1.5 * u(2)),
                mobility: mobility + 30.0 * u(3),
                acceleration: 20.0 * (u(4) - 0.3),
            };
            let transmission = Transmission {
                resonance: 80.0 + 150.0 * u(5),
                damping_ratio: 0.1 * u(6),
                flexible_mass_fraction: 0.2 + 0.6 * u(7),
            };
            let start = Relative {
                penetration: 1e-3 * (u(8) - 0.5),
                speed: 0.8 * (u(9) - 0.4),
            };
            let sway = Sway {
                stretch: 2e-4 * (u(10) - 0.5),
                speed: 0.2 * (u(11) - 0.5),
            };
            let case = TwoMasses {
                transmission,
                mobility,
                contact,
            };
            (case, start, sway, 1e-3)
        })
    }

    #[test]
    fn an_interval_is_that_of_two_masses_and_an_object() {
        let (mut touched, mut worst) = (0, 0.0_f64);
        for (case, start, sway, h) in cases() {
            let flexure = Flexure::new(&case.transmission);
            let (course, end) = flexure.over(&case.contact, case.mobility, start, sway, h);
            let exact = case.after(start, sway, None, h);
            touched += u32::from(exact[4] > 0.0);
            let swing = flexure.stiffness.sqrt() * sway.stretch.abs();
            let largest = start.speed.abs() + sway.speed.abs() + swing + 0.02;
            let off = [
                (course.end.penetration - exact[0]) / h,
                course.end.speed - exact[1],
                (end.stretch - exact[2]) / h,
                end.speed - exact[3],
                (course.impulse - exact[4]) * case.contact.mobility,
            ];
            for by in off {
                worst = worst.max(by.abs() / largest);
            }
        }
        assert!(worst < 5e-3, "{worst}");
        assert!(touched > 60, "{touched}");
    }

    #[test]
    fn a_held_force_stretches_the_spring_as_two_masses_say() {
        for (case, _, sway, h) in cases() {
            let flexure = Flexure::new(&case.transmission);
            let held = Held {
                lead: 3e-8,
                ..Held::constant(1.3)
            };
            let still = Relative {
                penetration: 0.0,
                speed: 0.0,
            };
            let exact = case.after(still, sway, Some(&held), h);
            let end = flexure.under(sway, case.mobility, &held, h);
            let pushed = case.mobility * flexure.of_motor * held.mean * h;
            let swing = flexure.stiffness.sqrt() * sway.stretch.abs();
            let largest = sway.speed.abs() + swing + pushed;
            let off = [(end.stretch - exact[2]) / h, end.speed - exact[3]];
            assert!(off.iter().all(|by| by.abs() < 6e-3 * largest), "{off:?}");
        }
    }

    #[test]
    fn derivatives_are_differences_of_neighbours() {
        for (case, start, sway, h) in cases() {
            let flexure = Flexure::new(&case.transmission);
            let end = |start: Relative<f64>, acceleration: f64, mobility: f64| {
                let contact = Drive {
                    acceleration,
                    mobility: case.contact.mobility - case.mobility + mobility,
                    ..case.contact
                };
                flexure.over_with_response(&contact, mobility, start, sway, h)
            };
            let (a, mobility) = (case.contact.acceleration, case.mobility);
            let (course, response, _) = end(start, a, mobility);
            let (plain, _) = flexure.over(&case.contact, mobility, start, sway, h);
            assert_eq!(course.end, plain.end);
            let response = response.unwrap();
            for (k, step) in [1e-9, 1e-6, 1e-4, 1e-5].into_iter().enumerate() {
                let beside = |by: f64| {
                    let mut at = [start.penetration, start.speed, a, mobility];
                    at[k] += by;
                    let start = Relative {
                        penetration: at[0],
                        speed: at[1],
                    };
                    end(start, at[2], at[3]).0.end
                };
                let (more, less) = (beside(step), beside(-step));
                let of_penetration = (more.penetration - less.penetration) / (2.0 * step);
                let of_speed = (more.speed - less.speed) / (2.0 * step);
                let scale = [1.0, h, h * h, start.speed.abs() * h + 1e-3][k];
                assert!(
                    (response.penetration[k] - of_penetration).abs() < 2e-3 * scale
                        && (response.speed[k] - of_speed).abs() < 2e-3 * scale / h,
                    "by {k}: {response:?}, differences {of_penetration} {of_speed}"
                );
            }
        }
    }

    /// With all mass on the motor's side the spring moves negligible mass.
    #[test]
    fn a_transmission_with_nothing_beyond_it_is_rigid() {
        for (case, start, _, h) in cases() {
            let rigid = Transmission {
                flexible_mass_fraction: 0.0,
                ..case.transmission
            };
            let flexure = Flexure::new(&rigid);
            let (course, _) = flexure.over(&case.contact, case.mobility, start, Sway::default(), h);
            let exact = case.contact.over(start, h);
            assert!((course.end.penetration - exact.end.penetration).abs() < 1e-12);
            assert!((course.end.speed - exact.end.speed).abs() < 1e-9);
            assert!((course.impulse - exact.impulse).abs() < 1e-9);
        }
    }
}
