//! The contact as it is rendered, tick by tick, with the changes that come in from another thread.

use palpate::{Ledger, Output, Running, Sample};

use super::{Change, Rendering};

/// A contact in the loop: what runs, and the changes that come in.
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

    /// Number of the parameters in force.
    #[must_use]
    pub fn generation(&self) -> u32 {
        self.generation
    }

    /// What is rendered once a change that has come in is through.
    #[must_use]
    pub fn rendering(&self) -> &Rendering {
        self.running.rendering()
    }

    /// Books up to the last sample.
    #[must_use]
    pub fn ledger(&self) -> &Ledger<f64> {
        self.running.ledger()
    }

    /// By how much later than told the commands begin, by what the method has learned so far `[s]`; 0 where it
    /// learns nothing of it.
    #[must_use]
    pub fn learned_lateness(&self) -> f64 {
        self.running.learned_lateness()
    }

    /// Takes a change, if one has come in. Its number.
    pub fn take_change(&mut self) -> Option<u32> {
        if !self.changes.update() {
            return None;
        }
        let change = *self.changes.output_buffer();
        self.running.take(change.change);
        self.generation = change.generation;
        Some(self.generation)
    }

    /// Tells the renderer the force on the object that was sent for its last output `[N]`.
    pub fn report_sent(&mut self, force_on_object: f64) {
        self.running.report_sent(force_on_object);
    }

    /// Tells the renderer the force on the object that was held since the last sample, or its mean
    /// `[N]`.
    pub fn report_held(&mut self, force_on_object: f64) {
        self.running.report_held(force_on_object);
    }

    /// One tick, at `position` `[m]`, `elapsed` `[s]` after the last; the force on the device `[N]`
    /// passes over from what was rendered before.
    pub fn step(&mut self, position: f64, elapsed: Option<f64>) -> Output<f64> {
        self.running.step(Sample {
            elapsed,
            ..Sample::at(position)
        })
    }
}
