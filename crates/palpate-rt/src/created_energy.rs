//! Created energy over the intervals that count.

/// Energy that held forces have created, without the intervals that begin or end at a refused sample, or at the first one.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct CreatedEnergy {
    /// The renderer's books at the last sample `[J]`.
    booked: f64,
    counted: f64,
    /// Whether the last sample was used, so that the next interval counts.
    is_begun: bool,
}

impl CreatedEnergy {
    /// Takes the renderer's created energy at a sample `[J]`. An interval with the motors off does not count.
    pub fn close(&mut self, booked: f64, is_refused: bool, was_off: bool) {
        if self.is_begun && !is_refused && !was_off {
            self.counted += booked - self.booked;
        }
        self.booked = booked;
        self.is_begun = !is_refused;
    }

    /// Energy created up to the last sample `[J]`.
    pub fn counted(&self) -> f64 {
        self.counted
    }

    /// The interval up to the next sample does not count.
    pub fn skip_interval(&mut self) {
        self.is_begun = false;
    }

    /// Continues from `before`, where the renderer counts `booked` `[J]` of created energy.
    pub fn go_on(&mut self, before: &Self, booked: f64) {
        *self = Self { booked, ..*before };
    }
}
