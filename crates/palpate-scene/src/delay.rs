//! Delay from a sample to its command.

/// Delay from a sample until its command takes effect, in periods or in seconds.
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

    /// A number of periods. One this close to a whole number is whole: quotients of decimal times are never exact.
    #[must_use]
    pub fn of_periods(periods: f64) -> Self {
        const WHOLE_WITHIN: f64 = 1e-5;
        let periods = periods.max(0.0);
        let whole = (periods + WHOLE_WITHIN).floor();
        let rest = periods - whole;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number of 0 or above; one too large for any loop is refused there"
        )]
        let samples = whole as usize;
        Self::Periods {
            samples,
            fraction: if rest > WHOLE_WITHIN { rest } else { 0.0 },
        }
    }

    /// Returns a delay of `seconds` `[s]` in a loop of `period` `[s]` that the renderer's model contains entirely:
    /// whole samples if it is a whole number of periods, or a time. A fraction of a period would be unmodelled.
    #[must_use]
    pub fn from_seconds(seconds: f64, period: f64) -> Self {
        let delay = Self::of_periods(seconds / period);
        if delay.is_whole() {
            delay
        } else {
            Self::Seconds(seconds)
        }
    }

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

    /// Returns this delay without a fraction of a period on top of whole samples.
    #[must_use]
    pub fn without_fraction(self) -> Self {
        match self {
            Self::Periods { samples, .. } => Self::samples(samples),
            Self::Seconds(_) => self,
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

    /// Returns a delay that is given in seconds `[s]`; 0 for one in periods.
    #[must_use]
    pub fn seconds(self) -> f64 {
        match self {
            Self::Periods { .. } => 0.0,
            Self::Seconds(seconds) => seconds,
        }
    }

    /// Returns the time of it in a loop of `period` `[s]` `[s]`.
    #[must_use]
    pub fn time(self, period: f64) -> f64 {
        match self {
            Self::Periods { samples, fraction } => (samples as f64 + fraction) * period,
            Self::Seconds(seconds) => seconds,
        }
    }

    /// Whether it is a number of whole samples, and no more.
    #[must_use]
    pub fn is_whole(self) -> bool {
        self.fraction() == 0.0 && self.seconds() == 0.0
    }
}
