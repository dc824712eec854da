//! The exact ideal contact of an object with a device that follows a recorded path.
//!
//! This is the reference solution of an open-loop replay: the recorded hand does not feel the force. Between two
//! recorded samples the device moves on a straight line. Relative to it the object moves under a constant acceleration
//! and, in contact, its spring. That is the [relative motion](crate::relative_motion) with mobility 1/M, whose rate
//! jumps by the change of slope at every sample, so the events inside a piece are again in closed form.

use crate::InvalidParameter;
use crate::arc::Arc;
use crate::error::finite;
use crate::grid::Grid;
use crate::ideal::{object_mass, object_velocity};
use crate::profile::{ForceProfile, Snapshot};
use crate::recorded_path::RecordedPath;
use crate::relative_motion::{RelativeMotion, RelativeState};

/// An object before a device that is moved by its recorded path alone.
///
/// See the [crate's page](crate) for frame and signs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrivenScene {
    /// Contact stiffness K `[N/m]`, finite and above 0.
    pub stiffness: f64,
    /// Object mass M `[kg]`, above 0; infinite for a wall.
    pub object_mass: f64,
    /// Constant force f_V on the object `[N]`; it has no effect on a wall.
    pub virtual_force: f64,
    /// Object position when the path starts `[m]`.
    pub object_position: f64,
    /// Object velocity when the path starts `[m/s]`; 0 for a wall.
    pub object_velocity: f64,
}

/// The ideal contact of a [`DrivenScene`] along a [`RecordedPath`], from its start to its end.
#[derive(Debug, Clone, PartialEq)]
pub struct DrivenIdeal {
    scene: DrivenScene,
    path: RecordedPath,
    arcs: Vec<Arc>,
}

impl DrivenIdeal {
    /// Solves the object's motion along the whole path.
    ///
    /// # Errors
    ///
    /// A field of `scene` is outside the range in its description, or the path lasts more than 10⁷
    /// half oscillations of the contact.
    pub fn new(scene: DrivenScene, path: RecordedPath) -> Result<Self, InvalidParameter> {
        Self::pushed(scene, path, &[])
    }

    /// Solves the motion of an object with an `added` force `[N]` from each sample of the path until the next, in
    /// addition to f_V; an empty list: 0.
    ///
    /// # Errors
    ///
    /// Those of [`new`](Self::new); an added force is not finite, or their number is not that of the samples.
    pub fn pushed(
        scene: DrivenScene,
        path: RecordedPath,
        added: &[f64],
    ) -> Result<Self, InvalidParameter> {
        InvalidParameter::unless(
            added.is_empty() || added.len() == path.times().len(),
            "number of added forces",
            added.len() as f64,
            "that of the samples",
        )?;
        for &force in added {
            finite("added force", force, "finite [N]")?;
        }
        object_mass(scene.object_mass)?;
        object_velocity(scene.object_velocity, scene.object_mass)?;
        finite("virtual_force", scene.virtual_force, "finite [N]")?;
        finite("object_position", scene.object_position, "finite [m]")?;
        let motion = |added: f64| {
            RelativeMotion::new(
                scene.stiffness,
                1.0 / scene.object_mass,
                -(scene.virtual_force + added) / scene.object_mass,
            )
        };
        motion(0.0)?.affords(path.end() - path.start())?;
        let arcs = arcs_along(&path, &scene, |piece| {
            motion(added.get(piece).copied().unwrap_or(0.0))
        })?;
        Ok(Self { scene, path, arcs })
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &DrivenScene {
        &self.scene
    }

    /// The path.
    #[must_use]
    pub fn path(&self) -> &RecordedPath {
        &self.path
    }

    /// The ideal force over `intervals` periods `[s]` from the start of the path.
    ///
    /// # Errors
    ///
    /// `period` is not finite and positive, or the path does not last `intervals` periods.
    pub fn profile(&self, period: f64, intervals: usize) -> Result<ForceProfile, InvalidParameter> {
        InvalidParameter::unless(
            intervals <= self.path.whole_periods(period)?,
            "intervals",
            intervals as f64,
            "at most the whole periods of the path",
        )?;
        Ok(ForceProfile::from_arcs(
            &self.arcs,
            Grid::even(self.path.start(), period, intervals),
        ))
    }

    /// The ideal force over a `grid` of any intervals.
    ///
    /// # Errors
    ///
    /// The grid begins before the path does, or ends after it.
    pub fn profile_on(&self, grid: Grid) -> Result<ForceProfile, InvalidParameter> {
        for (name, time) in [("grid start", grid.start()), ("grid end", grid.end())] {
            InvalidParameter::unless(
                (self.path.start()..=self.path.end()).contains(&time),
                name,
                time,
                "within the path",
            )?;
        }
        Ok(ForceProfile::from_arcs(&self.arcs, grid))
    }

    /// Device, object and force at a time `[s]` of the path; before its start or after its end,
    /// those at its start or end.
    #[must_use]
    pub fn at(&self, time: f64) -> Snapshot {
        // `max` first: it turns a NaN into the start.
        let time = time.max(self.path.start()).min(self.path.end());
        let index = self
            .arcs
            .partition_point(|arc| arc.end <= time)
            .min(self.arcs.len() - 1);
        let arc = &self.arcs[index];
        let state = arc.state(time);
        let device_position = self.path.position(time);
        let device_velocity = self.path.velocity(time);
        let (object_position, object_velocity) = if self.scene.object_mass.is_finite() {
            let slope = self.path.velocity(0.5 * (arc.start + arc.end));
            (device_position - state.penetration, slope - state.velocity)
        } else {
            (self.scene.object_position, 0.0)
        };
        Snapshot {
            time,
            device_position,
            device_velocity,
            object_position,
            object_velocity,
            force_on_object: arc.force(time),
        }
    }
}

/// Solves piece by piece; only the rate of penetration jumps from one piece to the next.
fn arcs_along(
    path: &RecordedPath,
    scene: &DrivenScene,
    motion: impl Fn(usize) -> Result<RelativeMotion, InvalidParameter>,
) -> Result<Vec<Arc>, InvalidParameter> {
    let mut arcs = Vec::with_capacity(path.times().len());
    let mut slope = path.slope(0);
    let mut state = RelativeState {
        penetration: path.positions()[0] - scene.object_position,
        velocity: slope - scene.object_velocity,
    };
    for (piece, ends) in path.times().windows(2).enumerate() {
        state.velocity += path.slope(piece) - slope;
        slope = path.slope(piece);
        // Solved in the piece's own time, where even a late and short piece has all its digits.
        let duration = ends[1] - ends[0];
        let of_piece = motion(piece)?.arcs(state, 0.0, duration)?;
        arcs.extend(of_piece.iter().map(|arc| arc.delayed(ends[0])));
        if let (Some(last), Some(delayed)) = (of_piece.last(), arcs.last_mut()) {
            state = last.state(duration);
            delayed.end = ends[1];
        }
    }
    Ok(arcs)
}
