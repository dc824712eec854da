//! Sensitivity of the end of an interval of relative motion to its start.
//!
//! The contact force is continuous at transitions, so the derivatives of the free and contact parts of an interval are
//! multiplied, and the instants of transition need no terms of their own.

use crate::Scalar;
use crate::relative_motion::{Drive, Relative, circular};

/// A part of an interval.
#[derive(Clone, Copy)]
pub(crate) enum Part<S> {
    /// Free, from this state for this time `[s]`.
    Free(Relative<S>, S),
    /// In contact, from this state for this time `[s]`.
    Pressed(Relative<S>, S),
    /// Many bounces, skipped together.
    Bounces,
}

/// Derivatives of an interval's end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Response<S> {
    /// Of the penetration: by the initial penetration and speed, by the acceleration a, and by the mobility mu.
    pub penetration: [S; 4],
    /// Of the speed, by the same quantities.
    pub speed: [S; 4],
    /// Of penetration and speed, by a constant rate of change of the acceleration `[m/s^3]` that is initially zero.
    pub ramp: [S; 2],
    /// Of penetration and speed, by a damping of the relative motion, p'' = ... - c p', at
    /// c = 0 `[1/s]`.
    pub damping: [S; 2],
    /// Duration so far `[s]`.
    duration: S,
}

/// Phases of the spring below this `[rad]` are too small to divide by its stiffness.
const SMALL_PHASE: f64 = 0.05;

impl<S: Scalar> Response<S> {
    /// Creates the response of an interval without duration.
    pub fn none_yet() -> Self {
        Self {
            penetration: [S::ONE, S::ZERO, S::ZERO, S::ZERO],
            speed: [S::ZERO, S::ONE, S::ZERO, S::ZERO],
            ramp: [S::ZERO; 2],
            damping: [S::ZERO; 2],
            duration: S::ZERO,
        }
    }

    /// Creates the response of an interval of `duration` `[s]` with these derivatives.
    pub fn new(
        penetration: [S; 4],
        speed: [S; 4],
        ramp: [S; 2],
        damping: [S; 2],
        duration: S,
    ) -> Self {
        Self {
            penetration,
            speed,
            ramp,
            damping,
            duration,
        }
    }

    /// Returns the response with one more part; `None` if whole bounces were skipped.
    #[inline]
    pub fn after(self, drive: &Drive<S>, part: Part<S>) -> Option<Self> {
        match part {
            Part::Free(at, h) => Some(self.after_flight(drive, at, h)),
            Part::Pressed(at, h) => Some(self.after_contact(drive, at, h)),
            Part::Bounces => None,
        }
    }

    fn after_flight(self, drive: &Drive<S>, at: Relative<S>, h: S) -> Self {
        let half = S::HALF * h * h;
        let sixth = half * h * S::from_f64(1.0 / 3.0);
        let (a, e) = (drive.acceleration, self.duration);
        let [ramp, damping] = [self.ramp, self.damping].map(|[p, v]| [p + h * v, v]);
        let mut next = Self {
            ramp: [ramp[0] + e * half + sixth, ramp[1] + e * h + half],
            damping: [
                damping[0] - at.speed * half - a * sixth,
                damping[1] - at.speed * h - a * half,
            ],
            duration: e + h,
            ..self
        };
        for (penetration, speed) in next.penetration.iter_mut().zip(self.speed) {
            *penetration += h * speed;
        }
        next.penetration[2] += S::HALF * h * h;
        next.speed[2] += h;
        next
    }

    fn after_contact(self, drive: &Drive<S>, at: Relative<S>, h: S) -> Self {
        let square = drive.stiffness * drive.mobility;
        let omega = square.sqrt();
        let [sine, versine, excess] = circular(omega, h);
        let cosine = S::ONE - square * versine;
        let pull = drive.acceleration - square * at.penetration;
        let e = self.duration;
        let turned = |p: S, v: S| [cosine * p + sine * v, cosine * v - square * sine * p];
        let [ramp, damping] = [self.ramp, self.damping].map(|[p, v]| turned(p, v));
        // The oscillation about the equilibrium decays with exp(-c h/2) and keeps its phase.
        let end_speed = at.speed * cosine + pull * sine;
        let mut next = Self {
            ramp: [ramp[0] + e * versine + excess, ramp[1] + e * sine + versine],
            damping: [
                damping[0] + S::HALF * (pull * (excess - h * versine) - h * at.speed * sine),
                damping[1] - S::HALF * (at.speed * sine + h * end_speed),
            ],
            duration: e + h,
            ..self
        };
        for i in 0..4 {
            [next.penetration[i], next.speed[i]] = turned(self.penetration[i], self.speed[i]);
        }
        next.penetration[2] += versine;
        next.speed[2] += sine;
        // Derivatives of sin(w h)/w and (1 - cos(w h))/w^2 by omega^2.
        let of_sine = S::HALF * (excess - h * versine);
        let of_versine = if omega * h < S::from_f64(SMALL_PHASE) {
            h * h * h * h * S::from_f64(-1.0 / 24.0)
        } else {
            (S::HALF * h * sine - versine) / square
        };
        next.penetration[3] +=
            drive.stiffness * (at.speed * of_sine + pull * of_versine - at.penetration * versine);
        next.speed[3] += drive.stiffness
            * (pull * of_sine - S::HALF * h * at.speed * sine - at.penetration * sine);
        next
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_differences_of_neighbours() {
        let mut transitions = 0;
        for i in 0..400 {
            let u = |k: u32| f64::from((i * 7919 + k * 104_729) % 1000) / 1000.0;
            let h = 0.005;
            let drive = Drive {
                stiffness: 10f64.powf(0.5 + 4.5 * u(1)),
                mobility: 2.0 + 20.0 * u(2),
                acceleration: 60.0 * (u(3) - 0.4),
            };
            let start = Relative {
                penetration: 2e-3 * (u(4) - 0.5),
                speed: 0.6 * (u(5) - 0.4),
            };
            let (course, response) = drive.over_with_response(start, h);
            assert_eq!(course.end, drive.over(start, h).end);
            let Some(response) = response else { continue };
            transitions += u32::from(course.first_transition.is_some());
            for (k, step) in [1e-9, 1e-6, 1e-4, 1e-5].into_iter().enumerate() {
                let end = |sign: f64| {
                    let mut by = [0.0; 4];
                    by[k] = sign * step;
                    let drive = Drive {
                        acceleration: drive.acceleration + by[2],
                        mobility: drive.mobility + by[3],
                        ..drive
                    };
                    let start = Relative {
                        penetration: start.penetration + by[0],
                        speed: start.speed + by[1],
                    };
                    drive.over(start, h).end
                };
                let (more, less) = (end(1.0), end(-1.0));
                let of_penetration = (more.penetration - less.penetration) / (2.0 * step);
                let of_speed = (more.speed - less.speed) / (2.0 * step);
                let omega = (drive.stiffness * drive.mobility).sqrt().max(1.0 / h);
                let scale = [1.0, 1.0 / omega, h * h, start.speed.abs() * h + 1e-3][k];
                assert!(
                    (response.penetration[k] - of_penetration).abs() < 1e-3 * scale
                        && (response.speed[k] - of_speed).abs() < 1e-3 * scale * omega,
                    "{drive:?} {start:?}, by {k}: {response:?}, differences {of_penetration} {of_speed}"
                );
            }
        }
        assert!(transitions > 50, "{transitions}");
    }

    /// Penetration and speed by fourth-order steps, with an additional ramp and damping.
    fn by_runge_kutta(drive: &Drive<f64>, start: Relative<f64>, h: f64, by: [f64; 2]) -> [f64; 2] {
        let [ramp, damping] = by;
        let pull = |t: f64, p: f64, v: f64| {
            drive.acceleration + ramp * t
                - damping * v
                - drive.stiffness * drive.mobility * p.max(0.0)
        };
        let steps = 4000;
        let dt = h / f64::from(steps);
        let (mut p, mut v) = (start.penetration, start.speed);
        for i in 0..steps {
            let t = f64::from(i) * dt;
            let half = 0.5 * dt;
            let (k1, l1) = (v, pull(t, p, v));
            let (k2, l2) = (v + half * l1, pull(t + half, p + half * k1, v + half * l1));
            let (k3, l3) = (v + half * l2, pull(t + half, p + half * k2, v + half * l2));
            let (k4, l4) = (v + dt * l3, pull(t + dt, p + dt * k3, v + dt * l3));
            p += dt / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
            v += dt / 6.0 * (l1 + 2.0 * (l2 + l3) + l4);
        }
        [p, v]
    }

    #[test]
    fn a_ramp_and_a_damping_are_answered_in_phase_however_stiff_the_spring() {
        let mut stiff = 0;
        for i in 0..120 {
            let u = |k: u32| f64::from((i * 6563 + k * 104_729) % 1000) / 1000.0;
            let h = 0.01;
            let drive = Drive {
                stiffness: 10f64.powf(0.5 + 4.5 * u(1)),
                mobility: 2.0 + 20.0 * u(2),
                acceleration: 40.0 * u(3),
            };
            let omega = (drive.stiffness * drive.mobility).sqrt();
            let start = Relative {
                penetration: drive.acceleration / (omega * omega) * 2.0 * u(4),
                speed: 0.2 * (u(5) - 0.5),
            };
            let (_, Some(response)) = drive.over_with_response(start, h) else {
                continue;
            };
            // Beyond half a turn in an interval the derivatives change their signs.
            stiff += u32::from(omega * h > 3.2);
            let scale = start.speed.abs() + drive.acceleration * h.min(1.0 / omega);
            for (found, by, size) in [
                (response.ramp, [1e-3, 0.0], h * h.min(1.0 / omega)),
                (response.damping, [0.0, 1e-4], h * scale),
            ] {
                let more = by_runge_kutta(&drive, start, h, by);
                let less = by_runge_kutta(&drive, start, h, by.map(|by| -by));
                let width = 2.0 * (by[0] + by[1]);
                let slope = [0, 1].map(|k| (more[k] - less[k]) / width);
                let reach = h.min(1.0 / omega);
                assert!(
                    (found[0] - slope[0]).abs() < 5e-3 * size * reach
                        && (found[1] - slope[1]).abs() < 5e-3 * size,
                    "{drive:?} {start:?}, by {by:?}: {found:?}, steps {slope:?}"
                );
            }
        }
        assert!(stiff > 20, "{stiff}");
    }
}
