//! Closed-form relative motion of device and object, including transitions of contact.
//!
//! Device and object under constant external forces, coupled only by the contact spring, have the relative motion
//!
//! ```text
//! p'' = a - omega^2 p h(p),   omega^2 = K mu,   mu = 1/m + 1/M,   a = a_u - f_V/M
//! ```
//!
//! with p the penetration, a_u the acceleration of the device by everything except the contact, and h the unit step:
//! parabolas when free, harmonics in contact. The testbed deliberately solves the same equation for its reference
//! solution with separate code.

use crate::Scalar;
use crate::response::{Part, Response};

/// Penetration and its rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Relative<S> {
    /// p `[m]`, positive in contact.
    pub penetration: S,
    /// p' `[m/s]`.
    pub speed: S,
}

/// Parameters of the relative motion of device and object over an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drive<S> {
    /// Contact stiffness K `[N/m]`.
    pub stiffness: S,
    /// mu = 1/m + 1/M `[1/kg]`; 0 if neither device nor object yields to the contact force.
    pub mobility: S,
    /// a `[m/s^2]`, positive into contact.
    pub acceleration: S,
}

/// Result of the relative motion over an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Course<S> {
    /// At the interval's end.
    pub end: Relative<S>,
    /// Integral of the contact force over the interval `[N s]`.
    pub impulse: S,
    /// First instant at which contact began or ended `[s]`.
    pub first_transition: Option<S>,
}

/// Maximum number of transitions followed one by one. Before and after the whole periods that are skipped together
/// there are at most two each, and rounding may add one to either.
const MAX_TRANSITIONS: usize = 6;

/// Phases of the spring below this `[rad]` are too small to use its period for the instant of release. The parabola is
/// then accurate to the square of the phase.
const ALMOST_NO_SPRING: f64 = 1e-3;

impl<S: Scalar> Drive<S> {
    /// Returns the motion from `start` over `duration` `[s]`, with any number of transitions in bounded work. A spring
    /// that is only touched is not in contact.
    pub fn over(&self, start: Relative<S>, duration: S) -> Course<S> {
        self.follow(start, duration, |_| {})
    }

    /// Returns the motion with the sensitivity of its end to its start; `None` if bounces were skipped together.
    pub fn over_with_response(
        &self,
        start: Relative<S>,
        duration: S,
    ) -> (Course<S>, Option<Response<S>>) {
        self.over_with_response_after(start, duration, Response::none_yet())
    }

    /// Returns the motion after a part with `response`, and the response of both.
    pub fn over_with_response_after(
        &self,
        start: Relative<S>,
        duration: S,
        response: Response<S>,
    ) -> (Course<S>, Option<Response<S>>) {
        let mut response = Some(response);
        let course = self.follow(start, duration, |part| {
            response = response.and_then(|so_far| so_far.after(self, part));
        });
        (course, response)
    }

    /// Follows the motion part by part.
    #[inline]
    fn follow(
        &self,
        start: Relative<S>,
        duration: S,
        mut passed: impl FnMut(Part<S>),
    ) -> Course<S> {
        let a = self.acceleration;
        let omega = (self.stiffness * self.mobility).sqrt();
        let mut at = start;
        let mut left = duration;
        let mut impulse = S::ZERO;
        let mut first_transition = None;
        let mut bounces_skipped = false;
        for _ in 0..MAX_TRANSITIONS {
            if self.is_free(at) {
                let Some((after, speed)) = self.entry(at).filter(|(after, _)| *after < left) else {
                    passed(Part::Free(at, left));
                    return Course {
                        end: self.fly(at, left),
                        impulse,
                        first_transition,
                    };
                };
                passed(Part::Free(at, after));
                first_transition = first_transition.or(Some(after));
                left -= after;
                at = Relative {
                    penetration: S::ZERO,
                    speed,
                };
            } else {
                if at.penetration == S::ZERO && a > S::ZERO && !bounces_skipped {
                    bounces_skipped = true;
                    if let Some(skipped) = self.whole_bounces(at.speed, omega, left) {
                        passed(Part::Bounces);
                        impulse += a * skipped / self.mobility;
                        left -= skipped;
                    }
                }
                let released = self.release(at, omega, left);
                match released {
                    None => {
                        passed(Part::Pressed(at, left));
                        let arc = self.press(at, omega, left);
                        return Course {
                            end: arc.end,
                            impulse: impulse + arc.impulse,
                            first_transition,
                        };
                    }
                    Some((after, speed)) => {
                        passed(Part::Pressed(at, after));
                        impulse += if omega * after < S::HALF {
                            self.press(at, omega, after).impulse
                        } else {
                            (a * after + (at.speed - speed)) / self.mobility
                        };
                        first_transition = first_transition.or(Some(after));
                        left -= after;
                        at = Relative {
                            penetration: S::ZERO,
                            speed,
                        };
                    }
                }
            }
        }
        // Only rounding can lead here, with next to nothing left.
        Course {
            end: self.fly(at, left),
            impulse,
            first_transition,
        }
    }

    /// Returns whether the motion continues in free flight; a spring that is only touched is not in contact.
    #[inline]
    fn is_free(&self, at: Relative<S>) -> bool {
        let a = self.acceleration;
        at.penetration < S::ZERO
            || (at.penetration == S::ZERO
                && (at.speed < S::ZERO || (at.speed == S::ZERO && a <= S::ZERO)))
    }

    /// Returns the duration of the whole bounces within `left` `[s]` that begin at `speed` `[m/s]`, if any.
    #[inline]
    fn whole_bounces(&self, speed: S, omega: S, left: S) -> Option<S> {
        // Pushed together, the motion repeats: contact, flight, contact. A whole period preserves the relative
        // momentum, so its impulse is that of a.
        let period = self.contact_time(speed, omega) + S::TWO * speed / self.acceleration;
        let whole = (left / period).floor();
        (period > S::ZERO && whole >= S::ONE && whole.is_finite())
            .then(|| (whole * period).min(left))
    }

    fn fly(&self, at: Relative<S>, h: S) -> Relative<S> {
        let a = self.acceleration;
        Relative {
            penetration: at.penetration + (at.speed + S::HALF * a * h) * h,
            speed: at.speed + a * h,
        }
    }

    /// Contact over `h` `[s]`, for any penetration.
    fn press(&self, at: Relative<S>, omega: S, h: S) -> Course<S> {
        let [sine, versine, excess] = circular(omega, h);
        let pull = self.acceleration - omega * omega * at.penetration;
        Course {
            end: Relative {
                penetration: at.penetration + at.speed * sine + pull * versine,
                speed: at.speed * (S::ONE - omega * omega * versine) + pull * sine,
            },
            impulse: self.stiffness * (at.penetration * h + at.speed * versine + pull * excess),
            first_transition: None,
        }
    }

    /// Returns the time and speed at which a free object is met; `None` if it is not met, or only touched.
    fn entry(&self, at: Relative<S>) -> Option<(S, S)> {
        let (p, v, a) = (at.penetration, at.speed, self.acceleration);
        let square = v * v - S::TWO * a * p;
        if square <= S::ZERO {
            return None;
        }
        let root = square.sqrt();
        let after = if v > S::ZERO {
            -S::TWO * p / (v + root)
        } else if a > S::ZERO {
            (root - v) / a
        } else {
            return None;
        };
        Some((after, root))
    }

    /// Returns the duration of a contact that begins at `speed` `[m/s]`.
    fn contact_time(&self, speed: S, omega: S) -> S {
        // tan(omega t / 2) = - omega v / a
        S::TWO * (omega * speed).atan2(-self.acceleration) / omega
    }

    /// Returns the time at which contact ends within `left` `[s]`, and the rate at that time.
    fn release(&self, at: Relative<S>, omega: S, left: S) -> Option<(S, S)> {
        let (p, v, a) = (at.penetration, at.speed, self.acceleration);
        // Remaining energy of the relative motion at p = 0.
        let square = v * v + p * (omega * omega * p - S::TWO * a);
        if square <= S::ZERO {
            return None;
        }
        let root = square.sqrt();
        let after = if omega * left < S::from_f64(ALMOST_NO_SPRING) {
            // p + v s + a s^2 / 2 falls through 0, then corrected for the spring.
            let rough = if v >= S::ZERO && a >= S::ZERO {
                return None;
            } else if v <= S::ZERO {
                let square = v * v - S::TWO * a * p;
                if square <= S::ZERO {
                    return None;
                }
                S::TWO * p / (square.sqrt() - v)
            } else {
                (v + (v * v - S::TWO * a * p).max(S::ZERO).sqrt()) / -a
            };
            let mut after = rough.min(left);
            for _ in 0..2 {
                let near = self.press(at, omega, after).end;
                if near.speed < S::ZERO {
                    after = (after - near.penetration / near.speed).max(S::ZERO);
                }
            }
            if rough > left + left {
                return None;
            }
            after
        } else {
            // p = a/omega^2 + R cos(omega s - phi), falling through 0.
            let phi = (omega * v).atan2(omega * omega * p - a);
            let fall = (omega * root).atan2(-a);
            ((phi + fall) / omega).max(S::ZERO)
        };
        (after < left).then_some((after, -root))
    }
}

/// Returns `sin(w h)/w`, `(1 - cos(w h))/w^2` and `(w h - sin(w h))/w^3`, also for w = 0: the response of a spring to a
/// velocity, an acceleration and a jerk.
pub(crate) fn circular<S: Scalar>(omega: S, h: S) -> [S; 3] {
    let angle = omega * h;
    if angle < S::from_f64(0.3) {
        // Terms up to the angle's eighth power: 1e-17 of the first.
        let square = angle * angle;
        let series = |d: [f64; 4]| {
            let [b, c, d, e] = d.map(S::from_f64);
            S::ONE
                - square * b * (S::ONE - square * c * (S::ONE - square * d * (S::ONE - square * e)))
        };
        return [
            h * series([1.0 / 6.0, 1.0 / 20.0, 1.0 / 42.0, 1.0 / 72.0]),
            S::HALF * h * h * series([1.0 / 12.0, 1.0 / 30.0, 1.0 / 56.0, 1.0 / 90.0]),
            S::from_f64(1.0 / 6.0)
                * h
                * h
                * h
                * series([1.0 / 20.0, 1.0 / 42.0, 1.0 / 72.0, 1.0 / 110.0]),
        ];
    }
    let (half_sine, half_cosine) = (S::HALF * angle).sin_cos();
    let sine = S::TWO * half_sine * half_cosine / omega;
    let half = half_sine / omega;
    [sine, S::TWO * half * half, (h - sine) / (omega * omega)]
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Random(u64);

    impl Random {
        fn uniform(&mut self) -> f64 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        }
        fn log(&mut self, from: f64, to: f64) -> f64 {
            from * (to / from).powf(self.uniform())
        }
    }

    /// Many short intervals, each with at most one significant transition.
    fn in_steps(drive: &Drive<f64>, start: Relative<f64>, h: f64, steps: u32) -> Course<f64> {
        let mut course = Course {
            end: start,
            impulse: 0.0,
            first_transition: None,
        };
        for _ in 0..steps {
            let next = drive.over(course.end, h / f64::from(steps));
            course = Course {
                impulse: course.impulse + next.impulse,
                ..next
            };
        }
        course
    }

    /// Fourth-order steps of the equation of motion itself, without the closed form.
    fn by_runge_kutta(drive: &Drive<f64>, start: Relative<f64>, h: f64, steps: u32) -> Course<f64> {
        let pull = |p: f64| drive.acceleration - drive.stiffness * drive.mobility * p.max(0.0);
        let dt = h / f64::from(steps);
        let (mut p, mut v, mut impulse) = (start.penetration, start.speed, 0.0);
        for _ in 0..steps {
            let (k1, l1) = (v, pull(p));
            let (k2, l2) = (v + 0.5 * dt * l1, pull(p + 0.5 * dt * k1));
            let (k3, l3) = (v + 0.5 * dt * l2, pull(p + 0.5 * dt * k2));
            let (k4, l4) = (v + dt * l3, pull(p + dt * k3));
            let force = |p: f64| drive.stiffness * p.max(0.0);
            let half = p + 0.5 * dt * k2;
            let next = p + dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            impulse += dt / 6.0 * (force(p) + 4.0 * force(half) + force(next));
            p = next;
            v += dt / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
        }
        Course {
            end: Relative {
                penetration: p,
                speed: v,
            },
            impulse,
            first_transition: None,
        }
    }

    #[test]
    fn it_solves_the_equation_of_motion() {
        let mut random = Random(3);
        let mut bounced = 0;
        for _ in 0..300 {
            let h = 0.01;
            let drive = Drive {
                stiffness: random.log(10.0, 3e5),
                mobility: random.log(1.0, 30.0),
                acceleration: 80.0 * (random.uniform() - 0.4),
            };
            let start = Relative {
                penetration: 2e-3 * (random.uniform() - 0.5),
                speed: 0.6 * (random.uniform() - 0.4),
            };
            let exact = drive.over(start, h);
            let fine = by_runge_kutta(&drive, start, h, 40_000);
            let omega = (drive.stiffness * drive.mobility).sqrt();
            bounced += u32::from(exact.first_transition.is_some());
            let scale =
                start.speed.abs() + drive.acceleration.abs() * h + omega * start.penetration.abs();
            assert!(
                (exact.end.speed - fine.end.speed).abs() < 2e-5 * scale
                    && (exact.end.penetration - fine.end.penetration).abs() < 2e-5 * scale * h
                    && (exact.impulse - fine.impulse).abs() * drive.mobility < 2e-5 * scale,
                "{drive:?} {start:?}: {exact:?}, fine steps {fine:?}"
            );
        }
        assert!(bounced > 100, "{bounced}");
    }

    #[test]
    fn momentum_is_the_impulse_whatever_happens() {
        let mut random = Random(5);
        for _ in 0..20_000 {
            let h = random.log(2e-4, 0.05);
            let drive = Drive {
                stiffness: random.log(1.0, 1e8),
                mobility: random.log(1e-3, 100.0),
                acceleration: 100.0 * (random.uniform() - 0.3),
            };
            let start = Relative {
                penetration: 1e-2 * (random.uniform() - 0.6),
                speed: 2.0 * (random.uniform() - 0.5),
            };
            let course = drive.over(start, h);
            let gained = course.end.speed - start.speed;
            let omega = (drive.stiffness * drive.mobility).sqrt();
            let scale = start.speed.abs()
                + course.end.speed.abs()
                + drive.acceleration.abs() * h
                + omega * start.penetration.abs();
            let unpaid = drive.acceleration * h - drive.mobility * course.impulse - gained;
            assert!(
                unpaid.abs() < 1e-11 * scale,
                "{drive:?} {start:?} over {h}: {course:?}, off by {unpaid}"
            );
        }
    }

    #[test]
    fn energy_of_the_relative_motion_stays() {
        let mut random = Random(9);
        for _ in 0..20_000 {
            let h = random.log(2e-4, 0.05);
            let drive = Drive {
                stiffness: random.log(1.0, 1e8),
                mobility: random.log(1e-3, 100.0),
                acceleration: 100.0 * (random.uniform() - 0.3),
            };
            let start = Relative {
                penetration: 1e-2 * (random.uniform() - 0.6),
                speed: 2.0 * (random.uniform() - 0.5),
            };
            let energy = |at: Relative<f64>| {
                let pressed = at.penetration.max(0.0);
                0.5 * at.speed * at.speed
                    + 0.5 * drive.stiffness * drive.mobility * pressed * pressed
                    - drive.acceleration * at.penetration
            };
            let end = drive.over(start, h).end;
            let scale = energy(start).abs()
                + drive.acceleration.abs() * (start.penetration.abs() + end.penetration.abs())
                + end.speed * end.speed;
            assert!(
                (energy(end) - energy(start)).abs() < 1e-10 * scale,
                "{drive:?} {start:?} over {h}: {end:?}"
            );
        }
    }

    #[test]
    fn many_bounces_at_once_are_the_bounces_one_by_one() {
        // 50 Hz and 1e7 N/m: about two hundred bounces in an interval.
        let drive = Drive {
            stiffness: 1e7,
            mobility: 20.0,
            acceleration: 30.0,
        };
        let start = Relative {
            penetration: -1e-5,
            speed: 2e-3,
        };
        let at_once = drive.over(start, 0.02);
        let one_by_one = in_steps(&drive, start, 0.02, 5_000);
        assert!((at_once.impulse - one_by_one.impulse).abs() < 1e-9 * at_once.impulse);
        assert!((at_once.end.speed - one_by_one.end.speed).abs() < 1e-6 * 0.03);
        assert!((at_once.end.penetration - one_by_one.end.penetration).abs() < 1e-9);
    }

    #[test]
    fn touching_is_no_contact_and_nothing_need_move() {
        let drive = Drive {
            stiffness: 100.0,
            mobility: 10.0,
            acceleration: -2.0,
        };
        // Thrown up to just reach the object: v^2 = 2 |a| |p|.
        let thrown = Relative {
            penetration: -0.25,
            speed: 1.0,
        };
        let touched = drive.over(thrown, 1.0);
        assert_eq!(touched.impulse, 0.0);
        assert_eq!(touched.first_transition, None);
        // Neither device nor object yields: a ramp into the spring.
        let driven = Drive {
            mobility: 0.0,
            acceleration: 0.0,
            ..drive
        };
        let ramp = Relative {
            penetration: -0.01,
            speed: 1.0,
        };
        let pressed = driven.over(ramp, 0.03);
        assert!((pressed.end.penetration - 0.02).abs() < 1e-15);
        assert!((pressed.impulse - 100.0 * 0.5 * 0.02 * 0.02).abs() < 1e-14);
        // And out again.
        let out = driven.over(
            Relative {
                penetration: 0.01,
                speed: -1.0,
            },
            0.03,
        );
        assert_eq!(out.end.speed, -1.0);
        assert!((out.impulse - 100.0 * 0.5 * 0.01 * 0.01).abs() < 1e-15);
        assert!((out.first_transition.unwrap() - 0.01).abs() < 1e-15);
        // Resting on the spring.
        let resting = Drive {
            acceleration: 5.0,
            ..drive
        };
        let rest = resting.over(
            Relative {
                penetration: 5.0 / 1000.0,
                speed: 0.0,
            },
            0.5,
        );
        assert!((rest.impulse - 0.25).abs() < 1e-12 && rest.end.speed.abs() < 1e-12);
        // Placed on it with zero speed: a full oscillation that just returns.
        let dropped = resting.over(
            Relative {
                penetration: 0.0,
                speed: 0.0,
            },
            10.0,
        );
        assert!((dropped.impulse - 5.0).abs() < 0.1, "{dropped:?}");
    }

    #[test]
    fn almost_no_spring_is_solved_as_well() {
        let mut random = Random(17);
        for _ in 0..2000 {
            let drive = Drive {
                stiffness: random.log(1e-6, 1.0),
                mobility: random.log(1e-3, 10.0),
                acceleration: 40.0 * (random.uniform() - 0.6),
            };
            let start = Relative {
                penetration: 1e-3 * random.uniform(),
                speed: 0.3 * (random.uniform() - 0.5),
            };
            let once = drive.over(start, 0.004);
            let fine = in_steps(&drive, start, 0.004, 64);
            assert!((once.end.penetration - fine.end.penetration).abs() < 1e-13);
            assert!((once.end.speed - fine.end.speed).abs() < 1e-12);
            assert!(
                (once.impulse - fine.impulse).abs() < 1e-12 * drive.stiffness * 1e-3,
                "{drive:?} {start:?} {once:?} {fine:?}"
            );
        }
    }

    #[test]
    fn single_precision_follows_double() {
        let mut random = Random(23);
        let mut worst = 0.0_f64;
        for _ in 0..5000 {
            let drive = Drive {
                stiffness: random.log(10.0, 1e4),
                mobility: random.log(2.0, 40.0),
                acceleration: 30.0 * (random.uniform() - 0.3),
            };
            let start = Relative {
                penetration: 2e-3 * (random.uniform() - 0.5),
                speed: 0.6 * (random.uniform() - 0.4),
            };
            #[allow(clippy::cast_possible_truncation)]
            let narrow = |x: f64| x as f32;
            let double = drive.over(start, 0.005);
            let single = Drive {
                stiffness: narrow(drive.stiffness),
                mobility: narrow(drive.mobility),
                acceleration: narrow(drive.acceleration),
            }
            .over(
                Relative {
                    penetration: narrow(start.penetration),
                    speed: narrow(start.speed),
                },
                0.005,
            );
            let omega = (drive.stiffness * drive.mobility).sqrt();
            let scale = start.speed.abs()
                + drive.acceleration.abs() * 0.005
                + omega * start.penetration.abs();
            let off = (f64::from(single.impulse) - double.impulse).abs() * drive.mobility / scale;
            worst = worst.max(off);
        }
        assert!(worst < 2e-5, "{worst:e}");
    }
}
