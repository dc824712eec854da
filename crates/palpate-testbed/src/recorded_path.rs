//! A recorded device motion, to be followed whatever the force.

use thiserror::Error;

use crate::InvalidParameter;
use crate::error::positive;

/// A difference of two times `[s]` without what their rounding has left behind the nanoseconds.
#[must_use]
pub fn to_nanoseconds(difference: f64) -> f64 {
    (difference * 1e9).round() / 1e9
}

/// Tolerance for an instant to equal a recorded one, in recording steps: time stamps are decimal.
const SAME_INSTANT: f64 = 1e-6;

/// Most samples a resampling may make.
const MAX_SAMPLES: f64 = 1e8;

/// Reason why times and positions do not form a path.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum PathError {
    /// Fewer than two samples.
    #[error("a path needs at least two samples, not {samples}")]
    TooShort {
        /// Number of samples given.
        samples: usize,
    },
    /// Not as many positions as times.
    #[error("{times} times but {positions} positions")]
    UnequalLengths {
        /// Number of times given.
        times: usize,
        /// Number of positions given.
        positions: usize,
    },
    /// A time is not finite.
    #[error("time {value} s at index {index} is not finite")]
    TimeNotFinite {
        /// Index of the sample.
        index: usize,
        /// The time `[s]`.
        value: f64,
    },
    /// A time is not after the one before it.
    #[error("time {value} s at index {index} is not after {previous} s")]
    TimeNotIncreasing {
        /// Index of the sample.
        index: usize,
        /// The time `[s]`.
        value: f64,
        /// The time before it `[s]`.
        previous: f64,
    },
    /// A position is not finite.
    #[error("position {value} m at index {index} is not finite")]
    PositionNotFinite {
        /// Index of the sample.
        index: usize,
        /// The position `[m]`.
        value: f64,
    },
}

/// A device path: recorded positions, and straight lines in time between them.
///
/// Outside the recording the device rests at its first or last position.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedPath {
    times: Vec<f64>,
    positions: Vec<f64>,
}

impl RecordedPath {
    /// A path through `positions` `[m]` at `times` `[s]`.
    ///
    /// # Errors
    ///
    /// The slices differ in length or hold fewer than two samples, a number is not finite, or a
    /// time is not after the one before it. The error says at which index.
    pub fn new(times: &[f64], positions: &[f64]) -> Result<Self, PathError> {
        if times.len() != positions.len() {
            return Err(PathError::UnequalLengths {
                times: times.len(),
                positions: positions.len(),
            });
        }
        if times.len() < 2 {
            return Err(PathError::TooShort {
                samples: times.len(),
            });
        }
        for (index, (&time, &position)) in times.iter().zip(positions).enumerate() {
            if !time.is_finite() {
                return Err(PathError::TimeNotFinite { index, value: time });
            }
            if !position.is_finite() {
                return Err(PathError::PositionNotFinite {
                    index,
                    value: position,
                });
            }
            if index > 0 && time <= times[index - 1] {
                return Err(PathError::TimeNotIncreasing {
                    index,
                    value: time,
                    previous: times[index - 1],
                });
            }
        }
        Ok(Self {
            times: times.to_vec(),
            positions: positions.to_vec(),
        })
    }

    /// Returns the same path with every position negated.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        Self {
            times: self.times.clone(),
            positions: self.positions.iter().map(|position| -position).collect(),
        }
    }

    /// Time of the first sample `[s]`.
    #[must_use]
    pub fn start(&self) -> f64 {
        self.times[0]
    }

    /// Time of the last sample `[s]`.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.times[self.times.len() - 1]
    }

    /// Position `[m]` at a time `[s]`.
    #[must_use]
    pub fn position(&self, time: f64) -> f64 {
        if time <= self.start() {
            return self.positions[0];
        }
        if time >= self.end() {
            return self.positions[self.positions.len() - 1];
        }
        let piece = self.piece(time);
        self.positions[piece] + self.slope(piece) * (time - self.times[piece])
    }

    /// Velocity `[m/s]` at a time `[s]`: the slope of the line that begins there or runs through it,
    /// and at the end of the recording that of the last line.
    #[must_use]
    pub fn velocity(&self, time: f64) -> f64 {
        if time < self.start() || time > self.end() {
            0.0
        } else {
            self.slope(self.piece(time))
        }
    }

    /// Returns the number of whole periods `[s]` of the recording. A last period may end a millionth of a recording
    /// step after it.
    ///
    /// # Errors
    ///
    /// `period` is not finite and positive, or there are more than 10⁸ of them.
    pub fn whole_periods(&self, period: f64) -> Result<usize, InvalidParameter> {
        positive("period", period, "finite and above 0 s")?;
        let last_step = self.end() - self.times[self.times.len() - 2];
        let periods =
            ((self.end() - self.start() + SAME_INSTANT * last_step.min(period)) / period).floor();
        InvalidParameter::unless(
            periods < MAX_SAMPLES,
            "period",
            period,
            "long enough for at most 1e8 periods in the recording",
        )?;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "checked to be a whole number from 0 to 1e8"
        )]
        Ok(periods as usize)
    }

    /// Returns positions `[m]` at start + i T for every whole period T `[s]` of the recording.
    ///
    /// If an instant equals a recorded one within a millionth of a recording step, the recorded position is returned
    /// bit for bit. A period that is a whole multiple of a uniform recording step therefore decimates. Other instants
    /// are interpolated.
    ///
    /// # Errors
    ///
    /// Those of [`whole_periods`](Self::whole_periods).
    pub fn resample(&self, period: f64) -> Result<Vec<f64>, InvalidParameter> {
        let periods = self.whole_periods(period)?;
        Ok((0..=periods)
            .map(|i| self.recorded_or_between(self.start() + i as f64 * period))
            .collect())
    }

    /// Times of the samples `[s]`.
    #[must_use]
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Positions of the samples `[m]`.
    #[must_use]
    pub fn positions(&self) -> &[f64] {
        &self.positions
    }

    /// Slope `[m/s]` of a piece, counted from 0.
    pub(crate) fn slope(&self, piece: usize) -> f64 {
        (self.positions[piece + 1] - self.positions[piece])
            / (self.times[piece + 1] - self.times[piece])
    }

    fn recorded_or_between(&self, time: f64) -> f64 {
        let piece = self.piece(time);
        let (left, right) = (self.times[piece], self.times[piece + 1]);
        let tolerance = SAME_INSTANT * (right - left);
        if (time - left).abs() <= tolerance {
            self.positions[piece]
        } else if (time - right).abs() <= tolerance {
            self.positions[piece + 1]
        } else {
            self.position(time)
        }
    }

    /// The piece that begins at or before `time`; the first or last one outside the recording.
    fn piece(&self, time: f64) -> usize {
        self.times
            .partition_point(|&recorded| recorded <= time)
            .clamp(1, self.times.len() - 1)
            - 1
    }
}
