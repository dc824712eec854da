//! How the end of an interval of relative motion answers to what the interval starts from.
//!
//! Contact begins and ends without a step of its force, so the parts of an interval, free and in
//! contact, answer one after the other: their derivatives are multiplied, and the instants of
//! transition need no terms of their own.

use crate::Scalar;
use crate::relative_motion::{Drive, Relative, circular};

/// A part of an interval.
#[derive(Clone, Copy)]
pub(crate) enum Part<S> {
    /// Free for so long `[s]`.
    Free(S),
    /// In contact, from this state on for so long `[s]`.
    Pressed(Relative<S>, S),
    /// Many bounces, taken at once.
    Bounces,
}

/// Derivatives of an interval's end. Each row is by the penetration and the speed at its start, by
/// the acceleration a, and by the mobility mu.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Response<S> {
    /// Of the penetration.
    pub penetration: [S; 4],
    /// Of the speed.
    pub speed: [S; 4],
}

/// Phases of the spring below this `[rad]` are too small to divide by its stiffness.
const SMALL_PHASE: f64 = 0.05;

impl<S: Scalar> Response<S> {
    /// Of an interval without duration.
    pub fn none_yet() -> Self {
        Self {
            penetration: [S::ONE, S::ZERO, S::ZERO, S::ZERO],
            speed: [S::ZERO, S::ONE, S::ZERO, S::ZERO],
        }
    }

    /// With one more part; none if that has no derivatives worth the name.
    #[inline]
    pub fn after(self, drive: &Drive<S>, part: Part<S>) -> Option<Self> {
        match part {
            Part::Free(h) => Some(self.after_flight(h)),
            Part::Pressed(at, h) => Some(self.after_contact(drive, at, h)),
            Part::Bounces => None,
        }
    }

    fn after_flight(self, h: S) -> Self {
        let mut next = self;
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
        let mut next = self;
        for i in 0..4 {
            let (p, v) = (self.penetration[i], self.speed[i]);
            next.penetration[i] = cosine * p + sine * v;
            next.speed[i] = cosine * v - square * sine * p;
        }
        next.penetration[2] += versine;
        next.speed[2] += sine;
        // By omega^2 first: of sin(w h)/w and (1 - cos(w h))/w^2.
        let of_sine = S::HALF * (excess - h * versine);
        let of_versine = if omega * h < S::from_f64(SMALL_PHASE) {
            h * h * h * h * S::from_f64(-1.0 / 24.0)
        } else {
            (S::HALF * h * sine - versine) / square
        };
        let pull = drive.acceleration - square * at.penetration;
        next.penetration[3] +=
            drive.stiffness * (at.speed * of_sine + pull * of_versine - at.penetration * versine);
        next.speed[3] += drive.stiffness
            * (pull * of_sine - S::HALF * h * at.speed * sine - at.penetration * sine);
        next
    }

    /// What a steady change of the acceleration over the interval, from nothing at its start, does
    /// to penetration and speed at its end, for each m/s^3 and with the interval's duration `h`
    /// `[s]`. Exact for a free interval.
    pub fn under_ramp(self, h: S) -> [S; 2] {
        [
            self.penetration[2] * h * S::from_f64(1.0 / 3.0),
            self.speed[2] * h * S::HALF,
        ]
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
}
