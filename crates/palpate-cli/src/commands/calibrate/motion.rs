//! An excitation under way, and what came of it: positions and forces, sample by sample.

use palpate_calibrate::{Excitation, ExcitationError, ExcitationParams, Phase};

/// An excitation and its samples so far.
pub struct Motion {
    excitation: Excitation,
    /// Positions `[m]`.
    pub positions: Vec<f64>,
    /// The force that each position was answered with `[N]`.
    pub forces: Vec<f64>,
    /// Times of the samples `[s]`, where the device or the stream has them.
    pub times: Vec<f64>,
}

impl Motion {
    /// No samples yet, with room for all.
    pub fn new(params: ExcitationParams) -> Result<Self, ExcitationError> {
        let excitation = Excitation::new(params)?;
        let room = excitation.length();
        Ok(Self {
            excitation,
            positions: Vec::with_capacity(room),
            forces: Vec::with_capacity(room),
            times: Vec::with_capacity(room),
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

    /// Where the excitation is.
    pub fn phase(&self) -> Phase {
        self.excitation.phase()
    }

    /// The samples at which there is a force.
    pub fn excited(&self) -> std::ops::Range<usize> {
        self.excitation.excited()
    }

    /// Samples of the whole.
    pub fn length(&self) -> usize {
        self.excitation.length()
    }
}
