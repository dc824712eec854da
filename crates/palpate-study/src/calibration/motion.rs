//! An excitation under way, and what came of it: positions and forces, sample by sample.

use palpate_calibrate::{Excitation, ExcitationError, ExcitationParams, Known, Phase};

/// An excitation and its samples so far.
#[derive(Clone, Debug)]
pub struct Motion {
    excitation: Excitation,
    /// Positions `[m]`.
    pub positions: Vec<f64>,
    /// The force that each position was answered with `[N]`.
    pub forces: Vec<f64>,
    /// Times of the samples `[s]`, where the device or the stream has them.
    pub times: Vec<f64>,
    missed: usize,
}

impl Motion {
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
