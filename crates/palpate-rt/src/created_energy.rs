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
    /// Takes the books at a sample `[J]`. An interval over which the motors were off does not count.
    pub fn close(&mut self, booked: f64, is_refused: bool, was_off: bool) {
        if self.is_begun && !is_refused && !was_off {
            self.counted += booked - self.booked;
        }
        self.booked = booked;
        self.is_begun = !is_refused;
    }

    /// What it has come to be `[J]`.
    pub fn counted(&self) -> f64 {
        self.counted
    }

    /// The interval up to the next sample does not count.
    pub fn skip_interval(&mut self) {
        self.is_begun = false;
    }

    /// Goes on from `before`, where the books are now at `booked` `[J]`.
    pub fn go_on(&mut self, before: &Self, booked: f64) {
        *self = Self { booked, ..*before };
    }
}
