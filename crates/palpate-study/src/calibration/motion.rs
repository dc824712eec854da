//! An excitation under way, and what came of it: positions and forces, sample by sample.

use palpate_calibrate::{Excitation, ExcitationError, ExcitationParams, Known, Phase};

/// How far the mean time between samples may be from the period, over the period: a mass is wrong by twice that.
const MOST_DRIFT: f64 = 0.002;
/// Largest standard deviation of the time between samples over the period: at 0.1 delay and lag are wrong by five of
/// their deviations, at 0.05 by one.
const MOST_JITTER: f64 = 0.05;

/// An excitation and its samples so far.
#[derive(Clone, Debug)]
pub struct ExcitedMotion {
    excitation: Excitation,
    /// Positions `[m]`.
    pub positions: Vec<f64>,
    /// The force that each position was answered with `[N]`.
    pub forces: Vec<f64>,
    /// Times of the samples `[s]`, where the device or the stream has them.
    pub times: Vec<f64>,
    missed: usize,
}

impl ExcitedMotion {
    /// No samples yet, with room for all.
    ///
    /// # Errors
    /// A parameter out of its range.
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

    /// The force `[N]` on the device from the sample of `position` `[m]` on.
    pub fn take(&mut self, time: Option<f64>, position: f64) -> f64 {
        let force = self.excitation.next(position);
        self.positions.push(position);
        self.forces.push(force);
        self.times.extend(time);
        force
    }

    /// A period without a sample, over which the device kept the last force.
    pub fn miss(&mut self) {
        self.excitation.miss();
        self.missed += 1;
        self.positions.push(f64::NAN);
        self.forces.push(self.forces.last().copied().unwrap_or(0.0));
    }

    /// Counts the last sample as missing: the loop stood still, and nobody knows when the force went.
    pub fn lose_last(&mut self) {
        self.missed += 1;
    }

    /// Says that the last sample was answered by another force than it asked for `[N]`.
    pub fn really_sent(&mut self, force: f64) {
        if let Some(last) = self.forces.last_mut() {
            *last = force;
        }
    }

    /// Samples that are missing.
    #[must_use]
    pub fn missed(&self) -> usize {
        self.missed
    }

    /// Puts positions on straight lines where samples are missing.
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

    /// Standard deviation of the time between samples `[s]`, where each sample has a time.
    #[must_use]
    pub fn sample_jitter(&self) -> Option<Known> {
        if self.times.len() < 100 || self.times.len() != self.positions.len() {
            return None;
        }
        let count = (self.times.len() - 1) as f64;
        let between = || self.times.windows(2).map(|pair| pair[1] - pair[0]);
        let mean = between().sum::<f64>() / count;
        let squares: f64 = between().map(|step| (step - mean).powi(2)).sum();
        let deviation = (squares / count).sqrt();
        let by = "times of the samples";
        Some(Known::found(
            deviation,
            deviation / (2.0 * count).sqrt(),
            by,
        ))
    }

    /// Why samples with times did not come in the even periods that a fit takes for granted, if they did not.
    #[must_use]
    pub fn uneven_pace(&self) -> Option<String> {
        let jitter = self.sample_jitter()?.value;
        let period = self.excitation.params().period;
        let count = (self.times.len() - 1) as f64;
        let mean = (self.times.last()? - self.times.first()?) / count;
        if (mean / period - 1.0).abs() > MOST_DRIFT {
            return Some(format!(
                "the samples came every {:.4} ms and --period says {:.4} ms, where {:.1} % apart are allowed: the mass would \
                 be wrong by twice that; run the loop at its period, or give --period {mean:.4e}",
                mean * 1e3,
                period * 1e3,
                MOST_DRIFT * 1e2
            ));
        }
        (jitter > MOST_JITTER * period).then(|| {
            format!(
                "the times between samples vary by {:.0} % of the period (standard deviation), where {:.0} % are allowed: \
                 run the loop more evenly",
                jitter / period * 1e2,
                MOST_JITTER * 1e2
            )
        })
    }

    /// Where the excitation is.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.excitation.phase()
    }

    /// The samples at which there is a force.
    #[must_use]
    pub fn excited(&self) -> std::ops::Range<usize> {
        self.excitation.excited()
    }

    /// Samples of the whole.
    #[must_use]
    pub fn length(&self) -> usize {
        self.excitation.length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples at the times that `time` gives them.
    fn at_times(time: impl Fn(f64) -> f64) -> ExcitedMotion {
        let mut motion = ExcitedMotion::new(ExcitationParams::new(0.001)).unwrap();
        for number in 0..1000 {
            motion.take(Some(time(f64::from(number))), 0.0);
        }
        motion
    }

    #[test]
    fn samples_that_do_not_come_in_even_periods_are_told() {
        assert_eq!(at_times(|n| 0.001 * n).uneven_pace(), None);
        // A sine of 40 us: its steps vary by 25 us.
        assert_eq!(at_times(|n| 0.001 * n + 4e-5 * n.sin()).uneven_pace(), None);
        let slow = at_times(|n| 0.00101 * n).uneven_pace().unwrap();
        assert!(
            slow.contains("every 1.0100 ms and --period says 1.0000 ms"),
            "{slow}"
        );
        let uneven = at_times(|n| 0.001 * n + 2e-4 * n.sin())
            .uneven_pace()
            .unwrap();
        assert!(
            uneven.contains("vary by 14 %") && uneven.contains("5 % are allowed"),
            "{uneven}"
        );
    }
}
