//! Replay of a recorded motion.

use std::time::Duration;

use super::{Capabilities, Device, DeviceError, DeviceErrorKind, Pose, Vector, Wrench};
use crate::clock::Clock;

/// A position-driven device: it follows recorded positions and ignores forces. Between two samples it interpolates
/// linearly; after the last one it is disconnected.
#[derive(Clone, Debug)]
pub struct ReplayDevice<C> {
    clock: C,
    capabilities: Capabilities,
    samples: Vec<(Duration, Vector)>,
    /// Time of the first sample.
    first: Duration,
    passed: usize,
    started: Option<Duration>,
}

impl<C: Clock> ReplayDevice<C> {
    /// Creates a replay of `samples`: times since the first sample, strictly increasing, and positions `[m]`.
    ///
    /// # Errors
    /// Fewer than two samples, a time that does not increase, or a position that is not finite; the error names the
    /// sample.
    pub fn new(
        clock: C,
        axes: usize,
        samples: Vec<(Duration, Vector)>,
    ) -> Result<Self, ReplayError> {
        let [(first, _), _, ..] = *samples.as_slice() else {
            return Err(ReplayError::TooShort(samples.len()));
        };
        let mut pairs = samples.iter().zip(samples.iter().skip(1));
        if let Some(index) = pairs.position(|(before, after)| after.0 <= before.0) {
            return Err(ReplayError::TimeNotIncreasing(index + 1));
        }
        if let Some(index) = samples
            .iter()
            .position(|(_, at)| at.iter().any(|x| !x.is_finite()))
        {
            return Err(ReplayError::PositionNotFinite(index));
        }
        Ok(Self {
            clock,
            capabilities: Capabilities::unknown("replay", axes),
            samples,
            first,
            passed: 0,
            started: None,
        })
    }
}

/// Reason why a recording cannot be replayed. Samples count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// Fewer than two samples.
    #[error("{0} samples; a replay needs two or more")]
    TooShort(usize),
    /// A time is equal to or less than the previous one.
    #[error("the time of sample {0} is not after that of the sample before")]
    TimeNotIncreasing(usize),
    /// A position is NaN or infinite.
    #[error("the position of sample {0} is not a finite number")]
    PositionNotFinite(usize),
}

impl<C: Clock> Device for ReplayDevice<C> {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        let time = self.clock.now();
        let started = *self.started.get_or_insert(time);
        let at = self.first + (time - started);
        // Amortised cost: the index passes each sample once.
        while self
            .samples
            .get(self.passed + 1)
            .is_some_and(|next| next.0 <= at)
        {
            self.passed += 1;
        }
        let ended = DeviceError::new(DeviceErrorKind::Disconnected, "the recording has ended");
        let (before, from) = *self.samples.get(self.passed).ok_or(ended)?;
        let mut position = from;
        match self.samples.get(self.passed + 1) {
            Some((after, to)) => {
                let part = (at - before).as_secs_f64() / (*after - before).as_secs_f64();
                for (x, to) in position.iter_mut().zip(to) {
                    *x += part * (to - *x);
                }
            }
            None if at == before => {}
            None => return Err(ended),
        }
        Ok(Pose::at(position, time))
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        Ok(wrench)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::SteppedClock;

    #[test]
    fn it_is_where_it_was_and_on_the_line_between() {
        let clock = SteppedClock::new();
        let ms = Duration::from_millis;
        let samples = vec![
            (ms(100), [0.0; 3]),
            (ms(110), [1.0, 0.0, 0.0]),
            (ms(130), [2.0, 4.0, 0.0]),
        ];
        let mut device = ReplayDevice::new(clock.clone(), 3, samples).unwrap();
        clock.advance(ms(7));
        assert_eq!(device.read().unwrap().position, [0.0; 3]);
        clock.advance(ms(5));
        assert_eq!(device.read().unwrap().position, [0.5, 0.0, 0.0]);
        clock.advance(ms(10));
        assert_eq!(device.read().unwrap().position, [1.25, 1.0, 0.0]);
        clock.advance(ms(15));
        assert_eq!(device.read().unwrap().position, [2.0, 4.0, 0.0]);
        clock.advance(ms(1));
        let error = device.read().unwrap_err();
        assert_eq!(error.kind, DeviceErrorKind::Disconnected);
    }

    #[test]
    fn what_cannot_be_replayed_is_named() {
        let new = |samples| ReplayDevice::new(SteppedClock::new(), 1, samples).unwrap_err();
        let ms = Duration::from_millis;
        assert_eq!(new(vec![(ms(0), [0.0; 3])]), ReplayError::TooShort(1));
        assert_eq!(
            new(vec![(ms(0), [0.0; 3]), (ms(0), [0.0; 3])]),
            ReplayError::TimeNotIncreasing(1)
        );
        assert_eq!(
            new(vec![(ms(0), [0.0; 3]), (ms(1), [f64::NAN, 0.0, 0.0])]),
            ReplayError::PositionNotFinite(1)
        );
    }
}
