//! Last steps of a sampled position, and velocity estimates from them.
//!
//! Positions are differences between samples, so a distant origin costs no precision. Each step has its own duration,
//! so samples need not be evenly spaced.

use crate::Scalar;

/// Largest number of steps in an adaptive window.
pub const LONGEST_WINDOW: usize = 16;

#[expect(clippy::cast_possible_truncation, reason = "16")]
const ROOM: u8 = LONGEST_WINDOW as u8;

/// Relative tolerance of the longest window: sums of decimal periods are never exact.
const LONGER_BY: f64 = 1e-6;

/// Change from one sample to the next.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Step<S> {
    /// Change of the position `[m]`.
    pub moved: S,
    /// Time between the samples `[s]`, above 0.
    pub elapsed: S,
}

/// Last steps, at most [`LONGEST_WINDOW`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Steps<S> {
    ring: [Step<S>; LONGEST_WINDOW],
    /// Index of the newest step.
    newest: u8,
    count: u8,
}

/// Parabola through the last three samples, at the last of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parabola<S> {
    /// Velocity `[m/s]`.
    pub velocity: S,
    /// Half of the acceleration `[m/s^2]`.
    pub half_acceleration: S,
}

impl<S: Scalar> Steps<S> {
    pub fn none() -> Self {
        Self {
            ring: [Step::default(); LONGEST_WINDOW],
            newest: 0,
            count: 0,
        }
    }

    /// Adds the step that a sample ends; replaces the oldest one if the buffer is full.
    pub fn push(&mut self, step: Step<S>) {
        self.newest = (self.newest + 1) % ROOM;
        self.ring[usize::from(self.newest)] = step;
        self.count = (self.count + 1).min(ROOM);
    }

    /// Iterates from the newest step backwards.
    fn back(&self) -> impl Iterator<Item = &Step<S>> {
        let place = |age| usize::from((self.newest + ROOM - age) % ROOM);
        (0..self.count).map(move |age| &self.ring[place(age)])
    }

    /// Returns the velocity by end-fit first-order adaptive windowing `[m/s]`; `None` without a step.
    ///
    /// It is that of the straight line from the last sample to an earlier one, the earliest whose line passes every
    /// sample in between within `noise_bound` `[m]`. The search starts with one step, and ends with the first window
    /// that fails or is longer than `longest` `[s]`. The line from the last sample passes one that is older by t and
    /// lies back by x if its slope is in `[(x - bound)/t, (x + bound)/t]`. The slopes allowed by all samples form an
    /// interval, so the search takes one pass. The last step alone is always used.
    ///
    /// Source: Janabi-Sharifi, Hayward and Chen, "Discrete-time adaptive windowing for velocity
    /// estimation", IEEE Trans. Control Systems Technology 8(6), 2000, the end-fit variant.
    pub fn adaptive_window(&self, noise_bound: S, longest: S) -> Option<S> {
        let longest = longest * S::from_f64(1.0 + LONGER_BY);
        let (mut back, mut time) = (S::ZERO, S::ZERO);
        let (mut least, mut most) = (-S::INFINITY, S::INFINITY);
        let mut velocity = None;
        for step in self.back() {
            back += step.moved;
            time += step.elapsed;
            let slope = back / time;
            if velocity.is_some() && (time > longest || slope < least || slope > most) {
                break;
            }
            velocity = Some(slope);
            least = least.max((back - noise_bound) / time);
            most = most.min((back + noise_bound) / time);
        }
        velocity
    }

    /// Returns the parabola through the last three samples, or the straight line after a single step; `None` without a
    /// step.
    pub fn parabola(&self) -> Option<Parabola<S>> {
        let mut steps = self.back();
        let late = steps.next()?;
        let slope = late.moved / late.elapsed;
        let Some(early) = steps.next() else {
            return Some(Parabola {
                velocity: slope,
                half_acceleration: S::ZERO,
            });
        };
        let half_acceleration =
            (slope - early.moved / early.elapsed) / (late.elapsed + early.elapsed);
        Some(Parabola {
            velocity: slope + half_acceleration * late.elapsed,
            half_acceleration,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 0.001;

    /// Returns the steps of samples at `times` `[s]` of a motion.
    fn along(times: impl IntoIterator<Item = f64>, position: impl Fn(f64) -> f64) -> Steps<f64> {
        let mut steps = Steps::none();
        let mut times = times.into_iter();
        let mut last = times.next().unwrap();
        for time in times {
            steps.push(Step {
                moved: position(time) - position(last),
                elapsed: time - last,
            });
            last = time;
        }
        steps
    }

    /// Returns the steps of samples at equal intervals.
    fn evenly(samples: u32, position: impl Fn(f64) -> f64) -> Steps<f64> {
        along((0..samples).map(|i| f64::from(i) * PERIOD), position)
    }

    fn quantised(position: f64, quantum: f64) -> f64 {
        (position / quantum).round() * quantum
    }

    fn uneven(samples: u32) -> impl Iterator<Item = f64> {
        (0..samples).map(|i| PERIOD * (f64::from(i) + 0.3 * f64::from(i % 3)))
    }

    #[test]
    fn without_a_step_nothing_is_known() {
        let none = Steps::<f64>::none();
        assert_eq!(none.adaptive_window(1.0, 1.0), None);
        assert!(none.parabola().is_none());
    }

    #[test]
    fn a_ramp_has_its_velocity_whatever_the_bound_the_window_and_the_spacing() {
        let ramp = |t: f64| 3.0 + 0.25 * t;
        for steps in [evenly(2, ramp), evenly(40, ramp), along(uneven(40), ramp)] {
            for bound in [0.0, 1e-6, 1e-3] {
                for longest in [PERIOD, 5.0 * PERIOD, 1.0] {
                    let velocity = steps.adaptive_window(bound, longest).unwrap();
                    assert!((velocity - 0.25).abs() < 1e-11, "{velocity}");
                }
            }
            let parabola = steps.parabola().unwrap();
            assert!((parabola.velocity - 0.25).abs() < 1e-11);
            assert!(parabola.half_acceleration.abs() < 1e-8);
        }
    }

    /// The error of a line between two samples within half a quantum of the truth is at most a quantum over the
    /// window's duration, and such a line passes all samples between within a quantum. A bound of one quantum therefore
    /// always gives a quantised ramp the whole window.
    #[test]
    fn a_quantised_ramp_has_the_whole_window_and_an_error_of_a_quantum_over_it() {
        let quantum = 1e-5;
        for velocity in [0.0, 1.7e-4, 0.003, 0.0123, -0.4] {
            for samples in 3..60 {
                let steps = evenly(samples, |t| quantised(0.0004 + velocity * t, quantum));
                let window = f64::from(samples - 1).min(LONGEST_WINDOW as f64);
                let found = steps.adaptive_window(quantum, 1.0).unwrap();
                let whole: f64 = steps.back().map(|step| step.moved).sum();
                assert!(
                    (found - whole / (window * PERIOD)).abs() < 1e-9,
                    "whole window"
                );
                let error = (found - velocity).abs();
                assert!(error <= quantum / (window * PERIOD) + 1e-9, "{error}");
            }
        }
        // The last step alone has an error of up to a quantum over a period, sixteen times as much.
        let steps = evenly(60, |t| quantised(0.003 * t, quantum));
        let last_step = steps.adaptive_window(0.0, 1.0).unwrap();
        let window = steps.adaptive_window(quantum, 1.0).unwrap();
        assert!((last_step - 0.003).abs() > 5.0 * (window - 0.003).abs());
    }

    #[test]
    fn a_step_in_velocity_shortens_the_window_to_what_came_after_it() {
        for speed in [0.2, -0.2] {
            // At rest for 20 samples, then 0.2 m/s either way.
            let corner = |t: f64| speed * (t - 20.0 * PERIOD).max(0.0);
            for after in 1..12_u32 {
                // A line to a sample before the corner misses it by more than the bound, a twentieth of the device's
                // motion in a period.
                let steps = evenly(21 + after, corner);
                let velocity = steps.adaptive_window(1e-5, 1.0).unwrap();
                assert!((velocity - speed).abs() < 1e-11, "{after}: {velocity}");
            }
            // With a bound that hides the corner the window keeps its length.
            let velocity = evenly(22, corner).adaptive_window(1e-3, 1.0).unwrap();
            let whole = speed / LONGEST_WINDOW as f64;
            assert!((velocity - whole).abs() < 1e-11, "{velocity}");
        }
    }

    #[test]
    fn the_window_is_no_longer_than_allowed() {
        // Within the bound throughout, so that only the length can end the window.
        let curve = |t: f64| 0.5 * 2.0 * t * t;
        for length in 1..=LONGEST_WINDOW {
            let longest = length as f64 * PERIOD;
            let velocity = evenly(40, curve).adaptive_window(1.0, longest).unwrap();
            let expected = 2.0 * (39.0 * PERIOD - 0.5 * longest);
            assert!((velocity - expected).abs() < 1e-11, "{length}: {velocity}");
        }
    }

    #[test]
    fn a_parabola_is_exact_however_the_samples_are_spaced() {
        let curve = |t: f64| 0.1 - 0.4 * t + 7.0 * t * t;
        for count in [3, 4, 30] {
            let times: Vec<f64> = uneven(count).collect();
            let end = times[times.len() - 1];
            let parabola = along(times, curve).parabola().unwrap();
            assert!((parabola.velocity - (14.0 * end - 0.4)).abs() < 1e-10);
            assert!((parabola.half_acceleration - 7.0).abs() < 1e-7);
        }
    }

    #[test]
    fn the_end_fit_looks_at_every_sample_between() {
        // The chord over n steps of a parabola has an error of a T^2 j (n - j)/2 at its sample j: largest in the
        // middle, 16 um for 8 steps and 20 um for 9, and less than the bound at its ends.
        for acceleration in [2.0, -2.0] {
            let steps = evenly(40, |t| 0.5 * acceleration * t * t);
            let velocity = steps.adaptive_window(1.8e-5, 1.0).unwrap();
            let expected = acceleration * PERIOD * (39.0 - 0.5 * 8.0);
            assert!(
                (velocity - expected).abs() < 1e-11,
                "{velocity}, not {expected}"
            );
        }
    }
}
