//! A running excitation and its result: positions and forces, sample by sample.

use crate::calibrate::{Excitation, ExcitationError, ExcitationParams, Known, Phase};

/// Maximum relative deviation of the mean sampling time from the period. The relative error of the mass is twice as
/// large.
const MAX_DRIFT: f64 = 0.002;
/// Maximum standard deviation of the sampling time relative to the period. At 0.1 the errors of delay and lag are
/// five of their standard deviations, at 0.05 one.
const MAX_JITTER: f64 = 0.05;

/// An excitation and its samples so far.
#[derive(Clone, Debug)]
pub struct ExcitedMotion {
    excitation: Excitation,
    /// Positions `[m]`.
    pub positions: Vec<f64>,
    /// Force on the device after each position `[N]`.
    pub forces: Vec<f64>,
    /// Times of the samples `[s]`, if the device or the stream provides them.
    pub times: Vec<f64>,
    missed: usize,
}

impl ExcitedMotion {
    /// Creates an excitation without samples, with capacity for all.
    ///
    /// # Errors
    /// A parameter is out of range.
    pub fn new(params: ExcitationParams) -> Result<Self, ExcitationError> {
        let excitation = Excitation::new(params)?;
        let room = excitation.length();
        Ok(Self {
            excitation,
            positions: Vec::with_capacity(room),
            forces: Vec::with_capacity(room),
            times: Vec::with_capacity(room),
            missed: 0,
        })
    }

    /// Adds the sample of `position` `[m]` and returns the force on the device from then on `[N]`.
    pub fn take(&mut self, time: Option<f64>, position: f64) -> f64 {
        let force = self.excitation.next(position);
        self.positions.push(position);
        self.forces.push(force);
        self.times.extend(time);
        force
    }

    /// Adds a period without a sample, in which the device kept the last force.
    pub fn miss(&mut self) {
        self.excitation.miss();
        self.missed += 1;
        self.positions.push(f64::NAN);
        self.forces.push(self.forces.last().copied().unwrap_or(0.0));
    }

    /// Counts the last sample as missing: the loop stalled, so the time of its force is unknown.
    pub fn lose_last(&mut self) {
        self.missed += 1;
    }

    /// Replaces the force of the last sample by the force actually sent `[N]`.
    pub fn really_sent(&mut self, force: f64) {
        if let Some(last) = self.forces.last_mut() {
            *last = force;
        }
    }

    /// Returns the number of missing samples.
    #[must_use]
    pub fn missed(&self) -> usize {
        self.missed
    }

    /// Interpolates the positions of missing samples linearly.
    pub fn fill(&mut self) {
        let known: Vec<usize> = (0..self.positions.len())
            .filter(|&i| self.positions[i].is_finite())
            .collect();
        for pair in known.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let (x, step) = (
                self.positions[from],
                (self.positions[to] - self.positions[from]) / (to - from) as f64,
            );
            for i in from + 1..to {
                self.positions[i] = x + step * (i - from) as f64;
            }
        }
        if let (Some(&first), Some(&last)) = (known.first(), known.last()) {
            let (before, after) = (self.positions[first], self.positions[last]);
            self.positions[..first].fill(before);
            self.positions[last..].fill(after);
        }
    }

    /// Returns the standard deviation of the sampling time `[s]`, if each sample has a time.
    #[must_use]
    pub fn sample_jitter(&self) -> Option<Known> {
        if self.times.len() < 100 || self.times.len() != self.positions.len() {
            return None;
        }
        let count = (self.times.len() - 1) as f64;
        let between = || self.times.windows(2).map(|pair| pair[1] - pair[0]);
        let mean = between().sum::<f64>() / count;
        let squares: f64 = between().map(|step| (step - mean).powi(2)).sum();
        let mut deviation = (squares / count).sqrt();
        // Differences of even times vary by the rounding of the times.
        let latest = self
            .times
            .iter()
            .fold(0.0_f64, |most, time| most.max(time.abs()));
        if deviation <= 4.0 * f64::EPSILON * latest {
            deviation = 0.0;
        }
        let by = "times of the samples";
        Some(Known::found(
            deviation,
            deviation / (2.0 * count).sqrt(),
            by,
        ))
    }

    /// Returns why timed samples are not evenly spaced, as a fit requires; `None` if they are.
    #[must_use]
    pub fn uneven_pace(&self) -> Option<String> {
        let jitter = self.sample_jitter()?.value;
        let period = self.excitation.params().period;
        let count = (self.times.len() - 1) as f64;
        let mean = (self.times.last()? - self.times.first()?) / count;
        if (mean / period - 1.0).abs() > MAX_DRIFT {
            return Some(format!(
                "the mean sample period is {:.4} ms, but --period is {:.4} ms (allowed difference: {:.1} %): the mass \
                 would be wrong by twice the difference; run the loop at its period, or pass --period {mean:.4e}",
                mean * 1e3,
                period * 1e3,
                MAX_DRIFT * 1e2
            ));
        }
        (jitter > MAX_JITTER * period).then(|| {
            format!(
                "the times between samples vary by {:.0} % of the period (standard deviation; allowed: {:.0} %): run \
                 the loop more evenly",
                jitter / period * 1e2,
                MAX_JITTER * 1e2
            )
        })
    }

    /// Returns what the loop did to the samples, which is a possible cause of a fit that fails: missing samples and
    /// uneven times; `None` without either.
    #[must_use]
    pub fn loop_fault(&self) -> Option<String> {
        let missing = (self.missed > 0).then(|| {
            format!(
                "{} of {} samples are missing",
                self.missed,
                self.positions.len()
            )
        });
        let faults: Vec<String> = missing.into_iter().chain(self.uneven_pace()).collect();
        (!faults.is_empty()).then(|| faults.join("; "))
    }

    /// Returns the phase of the excitation.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.excitation.phase()
    }

    /// Returns the range of samples with a force.
    #[must_use]
    pub fn excited(&self) -> std::ops::Range<usize> {
        self.excitation.excited()
    }

    /// Returns the number of all samples.
    #[must_use]
    pub fn length(&self) -> usize {
        self.excitation.length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns samples at the times that `time` returns.
    fn at_times(time: impl Fn(f64) -> f64) -> ExcitedMotion {
        let mut motion = ExcitedMotion::new(ExcitationParams::new(0.001)).unwrap();
        for number in 0..1000 {
            motion.take(Some(time(f64::from(number))), 0.0);
        }
        motion
    }

    #[test]
    fn rounding_of_even_times_is_no_jitter() {
        let deviation = |motion: &ExcitedMotion| {
            let jitter = motion.sample_jitter().unwrap();
            (jitter.value, jitter.standard_deviation)
        };
        for period in [0.001, 0.0003, 1.0 / 3.0] {
            for start in [0.0, -7.0, 1e4] {
                let even = at_times(|n| start + period * n);
                assert_eq!(deviation(&even), (0.0, Some(0.0)), "{period} {start}");
            }
        }
        let (value, _) = deviation(&at_times(|n| 0.001 * n + 1e-9 * n.sin()));
        assert!((5e-10..2e-9).contains(&value), "{value}");
    }

    #[test]
    fn wrong_or_uneven_sample_periods_are_reported() {
        assert_eq!(at_times(|n| 0.001 * n).uneven_pace(), None);
        // A sine of 40 us amplitude: its steps vary by 25 us.
        assert_eq!(at_times(|n| 0.001 * n + 4e-5 * n.sin()).uneven_pace(), None);
        let slow = at_times(|n| 0.00101 * n).uneven_pace().unwrap();
        assert!(
            slow.contains("is 1.0100 ms, but --period is 1.0000 ms"),
            "{slow}"
        );
        let uneven = at_times(|n| 0.001 * n + 2e-4 * n.sin())
            .uneven_pace()
            .unwrap();
        assert!(
            uneven.contains("vary by 14 %") && uneven.contains("allowed: 5 %"),
            "{uneven}"
        );
    }
}
