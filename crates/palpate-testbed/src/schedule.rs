//! Sample instants of an imperfect loop, and arrival of its commands at the motor.
//!
//! A loop has a grid of instants, one nominal period apart. A sample is taken near its grid
//! instant (jitter) or not at all (dropped); for a while the grid may be a coarser or finer one
//! (rate collapse). The command computed from a sample reaches the motor a delay later, and is held
//! until the next one does.
//!
//! Runs are reproducible: the random numbers are those of SplitMix64, with separate generators for sample jitter, drops
//! and command jitter, so none affects the others. Normal jitter uses the platform's logarithm and cosine, whose last
//! bit may differ between platforms; the rest is the same everywhere.

mod parameter;

pub use parameter::ScheduleParameter;

use crate::InvalidParameter;
use crate::error::{finite, positive};
use crate::hold::DelayedHold;
use crate::random::SplitMix64;

/// Longest delay in seconds, in periods: that of whole samples.
const LONGEST_DELAY: f64 = DelayedHold::LONGEST_DELAY as f64;

/// Seed offset between the generators of drops and of jitter.
const DROP_STREAM: u64 = 0x6A09_E667_F3BC_C909; // fractional digits of √2

/// Seed offset between the generator of command jitter and the others.
const COMMAND_STREAM: u64 = 0xBB67_AE85_84CA_A73B; // fractional digits of √3

/// Deviation of a sample from its grid instant. Deviations do not accumulate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Jitter {
    /// On the instant.
    #[default]
    None,
    /// Uniformly distributed on ± `bound`.
    Uniform {
        /// `[s]`
        bound: f64,
    },
    /// Normally distributed with mean 0; values outside ± `bound` are redrawn.
    Normal {
        /// Standard deviation of the distribution before it is bounded `[s]`.
        deviation: f64,
        /// `[s]`
        bound: f64,
    },
}

impl Jitter {
    fn bound(self) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Uniform { bound } | Self::Normal { bound, .. } => bound,
        }
    }
}

/// Samples that are not taken.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Dropped {
    /// None.
    #[default]
    None,
    /// Each with this probability, whatever became of the others.
    Probability(f64),
    /// Samples with these grid indices, from 1, in increasing order.
    Listed(Vec<u64>),
}

/// A stretch of time in which the grid has another period.
///
/// An instant of the grid from `from` on and before `until` is followed by the next after `period`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateCollapse {
    /// `[s]`
    pub from: f64,
    /// `[s]`
    pub until: f64,
    /// `[s]`
    pub period: f64,
}

/// Time from a sample to the start of its command: a number of grid periods at the sample, plus seconds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ActuationDelay {
    /// Whole periods.
    pub samples: u32,
    /// Fraction of a period, 0 ≤ fraction < 1: the time to compute.
    pub fraction: f64,
    /// Seconds, whatever the period `[s]`.
    pub seconds: f64,
    /// Largest additional delay of a command `[s]`; each is drawn uniformly from 0.
    pub jitter: f64,
}

/// Parameters of a [`Schedule`].
#[derive(Debug, Clone, PartialEq)]
pub struct ScheduleParams {
    /// Nominal period of the grid `[s]`, which begins at 0.
    pub period: f64,
    /// Jitter of the sample instants.
    pub jitter: Jitter,
    /// Samples not taken.
    pub dropped: Dropped,
    /// A stretch with another period.
    pub collapse: Option<RateCollapse>,
    /// Delay from sample to motor.
    pub delay: ActuationDelay,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl ScheduleParams {
    /// A perfect loop with a `period` `[s]`.
    #[must_use]
    pub fn perfect(period: f64) -> Self {
        Self {
            period,
            jitter: Jitter::None,
            dropped: Dropped::None,
            collapse: None,
            delay: ActuationDelay::default(),
            seed: 0,
        }
    }
}

/// One sample that is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tick {
    /// Index on the grid, counted from 0; it skips the dropped samples.
    pub index: u64,
    /// Time of the measurement `[s]`.
    pub sample_time: f64,
    /// Arrival of the command from this sample at the motor `[s]`.
    ///
    /// At least `sample_time`, and at least the arrival of the previous tick's command: a command that would overtake
    /// an earlier one waits for it and replaces it at once.
    pub hold_from: f64,
}

/// The ticks of a loop, without end.
///
/// Between two `hold_from` the motor holds the command of the earlier one, and before the first
/// one no force. The first sample, that of index 0, is taken at time 0 whatever the jitter and the
/// drops: a loop begins with it.
#[derive(Debug, Clone, PartialEq)]
pub struct Schedule {
    params: ScheduleParams,
    next_index: u64,
    /// The grid counts from here, so that instants are products and not sums of rounded periods.
    origin: (u64, f64),
    grid_period: f64,
    last_hold: f64,
    jitter_numbers: SplitMix64,
    drop_numbers: SplitMix64,
    command_numbers: SplitMix64,
}

impl Schedule {
    /// A schedule from checked parameters.
    ///
    /// # Errors
    ///
    /// A period is not finite and positive, the collapse does not end after it begins, the jitter
    /// is negative or reaches half of the shortest period (samples would change places), the
    /// probability is not in `[0, 1)`, listed indices do not rise or begin with 0, the delay's fraction is
    /// not in `[0, 1)`, or its seconds or the jitter of commands are not from 0 to 1024 periods.
    pub fn new(params: ScheduleParams) -> Result<Self, InvalidParameter<ScheduleParameter>> {
        use ScheduleParameter as Of;
        let mut shortest = positive(Of::Period, params.period, "finite and above 0 s")?;
        if let Some(collapse) = params.collapse {
            positive(Of::CollapsePeriod, collapse.period, "finite and above 0 s")?;
            finite(Of::CollapseFrom, collapse.from, "finite [s]")?;
            InvalidParameter::unless(
                collapse.until > collapse.from,
                Of::CollapseUntil,
                collapse.until,
                "after the collapse begins [s]",
            )?;
            shortest = shortest.min(collapse.period);
        }
        let bound = params.jitter.bound();
        InvalidParameter::unless(
            (0.0..0.5 * shortest).contains(&bound),
            Of::JitterBound,
            bound,
            "from 0 s to below half of the shortest period",
        )?;
        if let Jitter::Normal { deviation, .. } = params.jitter {
            positive(Of::JitterDeviation, deviation, "finite and above 0 s")?;
        }
        match &params.dropped {
            Dropped::None => {}
            Dropped::Probability(probability) => {
                InvalidParameter::unless(
                    (0.0..1.0).contains(probability),
                    Of::Dropped,
                    *probability,
                    "a probability from 0 to below 1",
                )?;
            }
            Dropped::Listed(indices) => {
                InvalidParameter::unless(
                    indices.first() != Some(&0),
                    Of::Dropped,
                    0.0,
                    "indices from 1 on: a loop begins with sample 0",
                )?;
                if let Some(pair) = indices.windows(2).find(|pair| pair[1] <= pair[0]) {
                    InvalidParameter::unless(
                        false,
                        Of::Dropped,
                        pair[1] as f64,
                        "indices in rising order",
                    )?;
                }
            }
        }
        InvalidParameter::unless(
            (0.0..1.0).contains(&params.delay.fraction),
            Of::DelayFraction,
            params.delay.fraction,
            "from 0 to below 1 period",
        )?;
        for (name, seconds) in [
            (Of::DelaySeconds, params.delay.seconds),
            (Of::CommandJitter, params.delay.jitter),
        ] {
            InvalidParameter::unless(
                (0.0..=LONGEST_DELAY * params.period).contains(&seconds),
                name,
                seconds,
                "from 0 s to 1024 periods",
            )?;
        }
        Ok(Self {
            next_index: 0,
            origin: (0, 0.0),
            grid_period: Self::period_at(&params, 0.0),
            last_hold: 0.0,
            jitter_numbers: SplitMix64::new(params.seed),
            drop_numbers: SplitMix64::new(params.seed ^ DROP_STREAM),
            command_numbers: SplitMix64::new(params.seed ^ COMMAND_STREAM),
            params,
        })
    }

    fn period_at(params: &ScheduleParams, time: f64) -> f64 {
        match params.collapse {
            Some(collapse) if collapse.from <= time && time < collapse.until => collapse.period,
            _ => params.period,
        }
    }

    /// The next instant of the grid `[s]` and the period `[s]` that follows it.
    fn next_instant(&mut self) -> (u64, f64, f64) {
        let index = self.next_index;
        self.next_index += 1;
        let (first, start) = self.origin;
        let instant = start + (index - first) as f64 * self.grid_period;
        let period = Self::period_at(&self.params, instant);
        if period != self.grid_period {
            self.origin = (index, instant);
            self.grid_period = period;
        }
        (index, instant, period)
    }

    fn jitter(&mut self) -> f64 {
        match self.params.jitter {
            Jitter::None => 0.0,
            Jitter::Uniform { bound } => bound * (2.0 * self.jitter_numbers.unit() - 1.0),
            Jitter::Normal { deviation, bound } => {
                // After this many rejected draws the distribution is far wider than its bound, and flat inside it.
                for _ in 0..64 {
                    let normal = deviation * self.jitter_numbers.normal();
                    if normal.abs() <= bound {
                        return normal;
                    }
                }
                bound * (2.0 * self.jitter_numbers.unit() - 1.0)
            }
        }
    }

    /// `[s]`
    fn command_jitter(&mut self) -> f64 {
        let bound = self.params.delay.jitter;
        if bound > 0.0 {
            bound * self.command_numbers.unit()
        } else {
            0.0
        }
    }

    fn drops(&mut self, index: u64) -> bool {
        match &self.params.dropped {
            Dropped::None => false,
            Dropped::Probability(probability) => self.drop_numbers.unit() < *probability,
            Dropped::Listed(indices) => indices.binary_search(&index).is_ok(),
        }
    }
}

impl Iterator for Schedule {
    type Item = Tick;

    fn next(&mut self) -> Option<Tick> {
        loop {
            let (index, instant, period) = self.next_instant();
            let late = self.jitter();
            let dropped = self.drops(index);
            let sample_time = if index == 0 {
                instant
            } else if dropped {
                continue;
            } else {
                instant + late
            };
            let delay = f64::from(self.params.delay.samples) + self.params.delay.fraction;
            let later = self.params.delay.seconds + self.command_jitter();
            let hold_from = (sample_time + delay * period + later).max(self.last_hold);
            self.last_hold = hold_from;
            return Some(Tick {
                index,
                sample_time,
                hold_from,
            });
        }
    }
}

#[cfg(test)]
#[allow(clippy::print_stdout)] // what was measured
mod tests;
