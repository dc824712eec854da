//! Which samples are believed.

use palpate::Fault;

use crate::rigid::Vector3;
use crate::{Sample, WorldFault, WorldLoop};

/// What is known of the devices' positions.
#[derive(Clone, Debug)]
pub(crate) struct Tracking {
    /// Whether an interval is in progress, which the next sample ends.
    pub in_progress: bool,
    /// Positions of the last sample that was used `[m]`, if one was.
    trusted: Vec<Vector3>,
    is_trusted: bool,
    /// Positions of the last sample, if it was not used but finite.
    seen: Vec<Vector3>,
    is_seen: bool,
    /// Time since the last sample that was used `[s]`.
    since: f64,
}

/// A measured period this close to the nominal one, relatively, is the nominal one: differences of decimal time
/// stamps are never exactly T.
const NOMINAL_WITHIN: f64 = 1e-6;

impl Tracking {
    pub fn new(tools: usize) -> Self {
        Self {
            in_progress: false,
            trusted: vec![Vector3::zeros(); tools],
            is_trusted: false,
            seen: vec![Vector3::zeros(); tools],
            is_seen: false,
            since: 0.0,
        }
    }

    /// Time since the previous sample `[s]`, if the sample is believed. A position that leaps is believed when the
    /// next sample confirms it.
    pub fn believe(&mut self, sample: &Sample<'_>, in_loop: &WorldLoop) -> Result<f64, WorldFault> {
        let elapsed = self.elapsed(sample, in_loop);
        let duration = *elapsed.as_ref().unwrap_or(&in_loop.period);
        self.since += duration;
        let was_seen = self.is_seen;
        self.is_seen = false;
        for tool in 0..self.trusted.len() {
            let finite = sample.positions.get(tool).is_some_and(|position| {
                let square: f64 = position.iter().map(|x| x * x).sum();
                square.is_finite()
            });
            if !finite {
                return Err(WorldFault {
                    fault: Fault::PositionNotFinite,
                    tool: Some(tool),
                });
            }
        }
        let fast = |from: &[Vector3], time: f64| {
            let limit = in_loop.speed_limit?;
            let mut pairs = from.iter().zip(sample.positions);
            pairs.position(|(from, to)| (Vector3::from(*to) - from).norm() > limit * time)
        };
        let leaps = if self.is_trusted {
            fast(&self.trusted, self.since)
        } else {
            None
        };
        let confirmed = was_seen && fast(&self.seen, duration).is_none();
        for (seen, position) in self.seen.iter_mut().zip(sample.positions) {
            *seen = Vector3::from(*position);
        }
        self.is_seen = true;
        let elapsed = elapsed.map_err(|fault| WorldFault { fault, tool: None })?;
        match leaps {
            Some(tool) if !confirmed => Err(WorldFault {
                fault: Fault::JumpTooFast,
                tool: Some(tool),
            }),
            _ => Ok(elapsed),
        }
    }

    /// The last sample is used.
    pub fn trust(&mut self) {
        self.trusted.copy_from_slice(&self.seen);
        self.is_trusted = true;
        self.since = 0.0;
        self.in_progress = true;
    }

    fn elapsed(&self, sample: &Sample<'_>, in_loop: &WorldLoop) -> Result<f64, Fault> {
        let Some(elapsed) = sample.elapsed else {
            return Ok(in_loop.period);
        };
        if !(elapsed > 0.0 && elapsed.is_finite()) {
            return Err(Fault::ElapsedNotPositive);
        }
        if elapsed > in_loop.bridged_gap() {
            return Err(Fault::GapTooLong);
        }
        if (elapsed / in_loop.period - 1.0).abs() < NOMINAL_WITHIN {
            Ok(in_loop.period)
        } else {
            Ok(elapsed)
        }
    }
}
