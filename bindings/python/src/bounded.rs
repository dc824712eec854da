//! A world with the limits of `palpate pipe` and the result of its last sample, for `World` and `Worlds`.

use std::ops::Index;

use palpate_device::Wrench;
use palpate_rt::BoundedWorld;
use palpate_rt::safety::Bounded;
use palpate_world::{
    BodyState, Effort, IDENTITY, Limited, Quaternion, Sample, Vector, WorldError, WorldFault,
};

/// A world at a sample.
#[derive(Clone)]
pub struct Now {
    pub bounded: BoundedWorld,
    pub last: Option<Answer>,
}

/// Result of a sample.
#[derive(Clone)]
pub struct Answer {
    pub wrenches: Vec<Wrench>,
    pub slopes: Vec<Vector>,
    limited: Limited,
    bounded: Bounded,
    pub effort: Effort,
    pub fault: Option<WorldFault>,
}

impl Answer {
    /// Returns the names of the active limits of renderer and safety layer.
    pub fn limits(&self) -> Vec<&'static str> {
        names(self.limited, self.bounded)
    }
}

/// Positions and orientations of the devices of a world at a sample.
#[derive(Default)]
pub struct Poses {
    positions: Vec<Vector>,
    orientations: Vec<Quaternion>,
}

impl Poses {
    /// Takes a row for each device: three coordinates, or a pose of seven, as `width` says.
    pub fn take<R: Index<usize, Output = f64>>(
        &mut self,
        rows: impl Iterator<Item = R>,
        width: usize,
    ) {
        self.positions.clear();
        self.orientations.clear();
        for row in rows {
            self.positions.push([row[0], row[1], row[2]]);
            self.orientations.push(match width {
                3 => IDENTITY,
                _ => [row[3], row[4], row[5], row[6]],
            });
        }
    }
}

impl Now {
    /// Creates the state without a sample.
    pub fn new(bounded: BoundedWorld) -> Self {
        Self {
            bounded,
            last: None,
        }
    }

    /// Executes one tick and returns the result.
    pub fn step(&mut self, poses: &Poses, elapsed: Option<f64>) -> &Answer {
        let sample = Sample {
            elapsed,
            ..Sample::at(&poses.positions).turned(&poses.orientations)
        };
        let held = self.bounded.step(&sample);
        // The vectors are allocated at the first sample alone.
        let (mut wrenches, mut slopes) = match self.last.take() {
            Some(last) => (last.wrenches, last.slopes),
            None => (Vec::new(), Vec::new()),
        };
        wrenches.clear();
        wrenches.extend_from_slice(held.wrenches);
        slopes.clear();
        slopes.extend_from_slice(held.slopes);
        self.last.insert(Answer {
            wrenches,
            slopes,
            limited: held.limited,
            bounded: held.bounded,
            effort: held.effort,
            fault: held.fault,
        })
    }

    /// Resets the state: bodies at their start, no sample, an empty energy ledger.
    pub fn reset(&mut self) {
        self.bounded.restart();
        self.last = None;
    }

    /// Returns the state of a body after a move.
    pub fn moved(&self, body: usize, given: &Placed) -> Result<BodyState, WorldError> {
        let now = self.bounded.state().bodies()[body];
        let to = BodyState {
            position: given.position.unwrap_or(now.position),
            orientation: given.orientation.unwrap_or(now.orientation),
            velocity: given.velocity.unwrap_or(now.velocity),
            angular_velocity: given.angular_velocity.unwrap_or(now.angular_velocity),
        };
        self.bounded.renderer().can_place(body, &to)?;
        Ok(to)
    }
}

/// New position, orientation and velocities of a body; None: unchanged.
#[derive(Clone, Copy, Default)]
pub struct Placed {
    pub position: Option<Vector>,
    pub orientation: Option<Quaternion>,
    pub velocity: Option<Vector>,
    pub angular_velocity: Option<Vector>,
}

/// Returns the names of the active limits of a renderer and its safety layer.
pub fn names(limited: Limited, bounded: Bounded) -> Vec<&'static str> {
    let acted = [
        (limited.force || bounded.force, "force"),
        (limited.torque, "torque"),
        (limited.offset, "offset"),
        (limited.guard, "guard"),
        (limited.beyond_guard, "beyond-guard"),
        (bounded.soft_start, "soft-start"),
        (bounded.stopped, "safety-stop"),
    ];
    let names = acted.into_iter();
    names
        .filter_map(|(acted, name)| acted.then_some(name))
        .collect()
}
