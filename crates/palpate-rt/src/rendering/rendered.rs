//! The rendered contact, with parameter changes from another thread.

use palpate_core::{Ledger, Output, Running, Sample};

use super::{Change, Rendering};

/// A contact in the loop: the running rendering and its pending changes.
#[derive(Debug)]
pub struct Rendered {
    changes: triple_buffer::Output<Change>,
    running: Running<f64>,
    generation: u32,
}

impl Rendered {
    pub(crate) fn new(running: Running<f64>, changes: triple_buffer::Output<Change>) -> Self {
        Self {
            changes,
            running,
            generation: 0,
        }
    }

    /// Returns the number of the parameters in force.
    #[must_use]
    pub fn generation(&self) -> u32 {
        self.generation
    }

    /// Returns the rendering after the current change is complete.
    #[must_use]
    pub fn rendering(&self) -> &Rendering {
        self.running.rendering()
    }

    /// Returns the energy ledger up to the last sample.
    #[must_use]
    pub fn ledger(&self) -> &Ledger<f64> {
        self.running.ledger()
    }

    /// Returns the estimated actuation delay minus its model value `[s]`; 0 if the method does not estimate it.
    #[must_use]
    pub fn learned_lateness(&self) -> f64 {
        self.running.learned_lateness()
    }

    /// Applies a pending change and returns its number.
    pub fn take_change(&mut self) -> Option<u32> {
        if !self.changes.update() {
            return None;
        }
        let change = *self.changes.output_buffer();
        self.running.take(change.change);
        self.generation = change.generation;
        Some(self.generation)
    }

    /// Reports the force on the object that was sent for the last output `[N]`.
    pub fn report_sent(&mut self, force_on_object: f64) {
        self.running.report_sent(force_on_object);
    }

    /// Reports the line on the object that was sent for the last output: its mean `[N]` and its slope `[N/s]`.
    pub fn report_sent_line(&mut self, mean: f64, slope: f64) {
        self.running.report_sent_line(mean, slope);
    }

    /// Reports the force on the object held since the last sample, or its mean `[N]`.
    pub fn report_held(&mut self, force_on_object: f64) {
        self.running.report_held(force_on_object);
    }

    /// Renders one tick. The virtual force of the sample adds to that of the rendering. After a change, the force on
    /// the device `[N]` changes over from the previous rendering.
    pub fn step(&mut self, sample: Sample<f64>) -> Output<f64> {
        self.running.step(sample)
    }
}
