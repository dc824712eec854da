//! From a sample to the command that it leads to.

/// How long a command of a loop takes to come into force, counted from its sample: said in periods or in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Delay {
    /// Periods of the loop, whatever they are.
    Periods {
        /// Whole samples.
        samples: usize,
        /// A part of a period on top, from 0 to below 1.
        fraction: f64,
    },
    /// A time `[s]`.
    Seconds(f64),
}

impl Default for Delay {
    fn default() -> Self {
        Self::NONE
    }
}

impl Delay {
    /// A command is in force as soon as its sample is taken.
    pub const NONE: Self = Self::samples(0);

    /// Whole samples.
    #[must_use]
    pub const fn samples(samples: usize) -> Self {
        Self::Periods {
            samples,
            fraction: 0.0,
        }
    }

    /// Whole samples of it; none of a time.
    #[must_use]
    pub fn whole_samples(self) -> usize {
        match self {
            Self::Periods { samples, .. } => samples,
            Self::Seconds(_) => 0,
        }
    }

    /// The part of a period on top of whole samples; none of a time.
    #[must_use]
    pub fn fraction(self) -> f64 {
        match self {
            Self::Periods { fraction, .. } => fraction,
            Self::Seconds(_) => 0.0,
        }
    }

    /// The time that is said in seconds `[s]`; none of periods.
    #[must_use]
    pub fn seconds(self) -> f64 {
        match self {
            Self::Periods { .. } => 0.0,
            Self::Seconds(seconds) => seconds,
        }
    }

    /// Whether it is a number of whole samples, and no more.
    #[must_use]
    pub fn is_whole(self) -> bool {
        self.fraction() == 0.0 && self.seconds() == 0.0
    }
}
