//! Validation of samples.

use palpate_core::Fault;

use crate::geometry::rigid::{Rotation, Vector3};
use crate::{Quaternion, Sample, Vector, WorldFault, WorldLoop};

/// Accepted and pending device positions and orientations.
#[derive(Clone, Debug)]
pub(crate) struct Tracking {
    /// Whether an interval is in progress, which the next sample ends.
    pub in_progress: bool,
    /// Positions of the last used sample `[m]`, if there was one.
    trusted: Vec<Vector>,
    /// Its orientations; the identity for a tool that does not turn.
    trusted_turn: Vec<Rotation>,
    is_trusted: bool,
    /// Positions of the last sample, if it was finite but not used.
    seen: Vec<Vector>,
    pub seen_turn: Vec<Rotation>,
    is_seen: bool,
    /// Angular velocities over the interval that ended with it `[rad/s]`, if both samples were finite.
    spin: Vec<Vector3>,
    turns: Vec<bool>,
    /// Time since the last used sample `[s]`.
    since: f64,
}

/// Relative tolerance within which a measured period is set to the nominal one: differences of decimal time stamps
/// are never exactly T.
const NOMINAL_WITHIN: f64 = 1e-6;

impl Tracking {
    /// Creates the state. `turns`: whether each tool turns.
    pub fn new(turns: &[bool]) -> Self {
        let tools = turns.len();
        let not_turned = vec![Rotation::identity(); tools];
        Self {
            in_progress: false,
            trusted: vec![[0.0; 3]; tools],
            trusted_turn: not_turned.clone(),
            is_trusted: false,
            seen: vec![[0.0; 3]; tools],
            seen_turn: not_turned,
            is_seen: false,
            spin: vec![Vector3::zeros(); tools],
            turns: turns.to_vec(),
            since: 0.0,
        }
    }

    /// Returns the time since the previous sample `[s]` if the sample is accepted. A jump in position is accepted if
    /// the next sample confirms it.
    pub fn believe(
        &mut self,
        sample: &Sample<'_>,
        loop_params: &WorldLoop,
    ) -> Result<f64, WorldFault> {
        let elapsed = self.elapsed(sample, loop_params);
        let duration = *elapsed.as_ref().unwrap_or(&loop_params.period);
        self.since += duration;
        let was_seen = self.is_seen;
        self.is_seen = false;
        self.check_values(sample)?;
        // A tool that does not turn keeps its initial orientation.
        let turn_of = |tool: usize| {
            let turned = unit(sample.orientations.get(tool)).filter(|_| self.turns[tool]);
            turned.unwrap_or_else(Rotation::identity)
        };
        let goes_too_fast = |from: &[Vector], time: f64| {
            let limit = loop_params.speed_limit?;
            let mut pairs = from.iter().zip(sample.positions);
            pairs.position(|(from, to)| {
                (Vector3::from(*to) - Vector3::from(*from)).norm() > limit * time
            })
        };
        let turns_too_fast = |from: &[Rotation], time: f64| {
            let limit = loop_params.turning_limit?;
            let mut each = from.iter().enumerate();
            each.position(|(tool, from)| from.angle_to(&turn_of(tool)) > limit * time)
        };
        let leaps = if self.is_trusted {
            goes_too_fast(&self.trusted, self.since)
                .or_else(|| turns_too_fast(&self.trusted_turn, self.since))
        } else {
            None
        };
        // A tool with a nearly constant angular velocity really rotates, at any speed.
        let kept_within = SPIN_KEPT_WITHIN * loop_params.turning_limit.unwrap_or(f64::INFINITY);
        let mut spins_on = true;
        for (tool, (spin, seen)) in self.spin.iter_mut().zip(&self.seen_turn).enumerate() {
            let now = (turn_of(tool) * seen.inverse()).scaled_axis() / duration;
            spins_on &= (now - *spin).norm() <= kept_within;
            *spin = now;
        }
        let confirmed = was_seen
            && goes_too_fast(&self.seen, duration).is_none()
            && (spins_on || turns_too_fast(&self.seen_turn, duration).is_none());
        self.remember(sample);
        let elapsed = elapsed.map_err(|fault| WorldFault { fault, tool: None })?;
        match leaps {
            Some(tool) if !confirmed => Err(WorldFault {
                fault: Fault::JumpTooFast,
                tool: Some(tool),
            }),
            _ => Ok(elapsed),
        }
    }

    /// Rejects positions that are not finite or overflow, and orientations that are not of length 1.
    #[inline]
    fn check_values(&self, sample: &Sample<'_>) -> Result<(), WorldFault> {
        for tool in 0..self.trusted.len() {
            let position = sample.positions.get(tool);
            let fault = match position {
                Some(position) if position.iter().all(|x| x.is_finite()) => {
                    // Distances overflow for values beyond 1e154.
                    let square: f64 = position.iter().map(|x| x * x).sum();
                    (!square.is_finite()).then_some(Fault::Overflow)
                }
                _ => Some(Fault::PositionNotFinite),
            };
            if let Some(fault) = fault {
                return Err(WorldFault {
                    fault,
                    tool: Some(tool),
                });
            }
        }
        for (tool, turns) in self.turns.iter().enumerate() {
            if *turns && unit(sample.orientations.get(tool)).is_none() {
                return Err(WorldFault {
                    fault: Fault::OrientationNotUnit,
                    tool: Some(tool),
                });
            }
        }
        Ok(())
    }

    /// Stores the positions and orientations of a sample as the last ones seen.
    #[inline]
    fn remember(&mut self, sample: &Sample<'_>) {
        let turns = &self.turns;
        for (tool, seen) in self.seen_turn.iter_mut().enumerate() {
            let turned = unit(sample.orientations.get(tool)).filter(|_| turns[tool]);
            *seen = turned.unwrap_or_else(Rotation::identity);
        }
        for (seen, position) in self.seen.iter_mut().zip(sample.positions) {
            *seen = *position;
        }
        self.is_seen = true;
    }

    /// Copies the state of `other`, which has the same tools. It does not allocate.
    pub fn copy_from(&mut self, other: &Self) {
        self.in_progress = other.in_progress;
        self.trusted.copy_from_slice(&other.trusted);
        self.trusted_turn.copy_from_slice(&other.trusted_turn);
        self.is_trusted = other.is_trusted;
        self.seen.copy_from_slice(&other.seen);
        self.seen_turn.copy_from_slice(&other.seen_turn);
        self.is_seen = other.is_seen;
        self.spin.copy_from_slice(&other.spin);
        self.since = other.since;
    }

    /// Takes the positions of the last used sample `[m]`, to be [put back](Self::put_trusted).
    pub fn take_trusted(&mut self) -> Vec<Vector> {
        std::mem::take(&mut self.trusted)
    }

    pub fn put_trusted(&mut self, positions: Vec<Vector>) {
        self.trusted = positions;
    }

    /// Returns the displacement `[m]` and rotation `[rad]` of a tool between the last used sample and the accepted
    /// one.
    pub fn moved(&self, tool: usize) -> [Vector3; 2] {
        let turn = self.seen_turn[tool] * self.trusted_turn[tool].inverse();
        [
            Vector3::from(self.seen[tool]) - Vector3::from(self.trusted[tool]),
            turn.scaled_axis(),
        ]
    }

    /// Marks the last sample as used.
    pub fn trust(&mut self) {
        self.trusted.copy_from_slice(&self.seen);
        self.trusted_turn.copy_from_slice(&self.seen_turn);
        self.is_trusted = true;
        self.since = 0.0;
        self.in_progress = true;
    }

    fn elapsed(&self, sample: &Sample<'_>, loop_params: &WorldLoop) -> Result<f64, Fault> {
        let Some(elapsed) = sample.elapsed else {
            return Ok(loop_params.period);
        };
        if !(elapsed > 0.0 && elapsed.is_finite()) {
            return Err(Fault::ElapsedNotPositive);
        }
        if elapsed > loop_params.bridged_gap() {
            return Err(Fault::GapTooLong);
        }
        if (elapsed / loop_params.period - 1.0).abs() < NOMINAL_WITHIN {
            Ok(loop_params.period)
        } else {
            Ok(elapsed)
        }
    }
}

/// Maximum change of an angular velocity between samples that counts as constant, relative to the limit.
const SPIN_KEPT_WITHIN: f64 = 0.5;

/// Allowed deviation of a quaternion's length from 1.
const LENGTH_TOLERANCE: f64 = 1e-3;

/// Normalises a quaternion of approximate length 1 to a rotation.
fn unit(orientation: Option<&Quaternion>) -> Option<Rotation> {
    let [w, x, y, z] = *orientation?;
    let quaternion = nalgebra::Quaternion::new(w, x, y, z);
    let is_unit = (quaternion.norm() - 1.0).abs() <= LENGTH_TOLERANCE;
    is_unit.then(|| Rotation::new_normalize(quaternion))
}
