//! Devices that are led along a recorded motion, whatever pushes them.

use super::contact::WorldError;
use super::hand::{Drivetrain, WorldHand};
use super::run::Run;
use super::scene::{Vector, WorldScene, unit_length};
use super::turning::{TurningHand, rotation_vector, turned_by};
use super::vector::Vec3;
use crate::InvalidParameter;
use crate::recorded_path::RecordedPath;

/// Mass of a device that no force moves `[kg]`, and moments of inertia of one that no torque turns `[kg m²]`.
const UNMOVED: f64 = 1e15;
/// An orientation `[w, x, y, z]`.
type Quaternion = [f64; 4];

/// A motion of all devices of a scene: straight lines between points in time, and rotations about one axis at one rate.
#[derive(Debug, Clone, PartialEq)]
pub struct LedPath {
    times: Vec<f64>,
    positions: Vec<Vec<Vector>>,
    /// Empty where no orientation is known.
    orientations: Vec<Vec<Quaternion>>,
}

impl LedPath {
    /// The motion through `positions[point][device]` `[m]` at `times` `[s]`, from t = 0.
    ///
    /// # Errors
    ///
    /// Fewer than two points, times that do not begin at 0 or do not increase, numbers that are not finite, or points
    /// with other numbers of devices.
    pub fn new(
        times: Vec<f64>,
        positions: Vec<Vec<Vector>>,
    ) -> Result<Self, InvalidParameter<String>> {
        let unless = |fits: bool, name: &str, value: f64, allowed| {
            InvalidParameter::unless(fits, name.to_owned(), value, allowed)
        };
        let points = times.len();
        unless(
            points >= 2 && positions.len() == points,
            "path.points",
            points as f64,
            "at least 2, with a position for each time",
        )?;
        unless(
            times[0] == 0.0,
            "path.times[0]",
            times[0],
            "0 s, the start of the scene",
        )?;
        for pair in times.windows(2) {
            let increases = pair[1].is_finite() && pair[1] > pair[0];
            unless(
                increases,
                "path.times",
                pair[1],
                "finite and in increasing order",
            )?;
        }
        for places in &positions {
            let same = places.len() == positions[0].len();
            unless(
                same,
                "path.positions",
                places.len() as f64,
                "one for each device",
            )?;
            for place in places.iter().flatten() {
                unless(place.is_finite(), "path.positions", *place, "finite")?;
            }
        }
        Ok(Self {
            times,
            positions,
            orientations: Vec::new(),
        })
    }

    /// Adds the orientations `orientations[point][device]` of devices that turn, unit quaternions `[w, x, y, z]`.
    /// Between points each device takes the shorter rotation.
    ///
    /// # Errors
    ///
    /// The numbers of points or devices differ from the positions, or a quaternion does not have length 1.
    pub fn turned(
        self,
        orientations: Vec<Vec<Quaternion>>,
    ) -> Result<Self, InvalidParameter<String>> {
        let devices = self.devices();
        let fits = orientations.len() == self.times.len()
            && orientations.iter().all(|each| each.len() == devices);
        InvalidParameter::unless(
            fits,
            "path.orientations".to_owned(),
            orientations.len() as f64,
            "one for each point and device",
        )?;
        for orientation in orientations.iter().flatten() {
            unit_length("path.orientations", orientation)?;
        }
        Ok(Self {
            orientations,
            ..self
        })
    }

    /// Returns whether the path has orientations.
    #[must_use]
    pub fn turns(&self) -> bool {
        !self.orientations.is_empty()
    }

    /// Returns the orientation of each device at a time `[s]`; empty if unknown.
    #[must_use]
    pub fn orientations_at(&self, time: f64) -> Vec<Quaternion> {
        if !self.turns() {
            return Vec::new();
        }
        let (segment, _) = self.segment(time);
        let share = self.share(segment, time);
        let ends = self.orientations[segment]
            .iter()
            .zip(&self.orientations[segment + 1]);
        ends.map(|(&from, &to)| turned_by(rotation_vector(from, to) * share, from))
            .collect()
    }

    /// The part of a line that is behind it at a time `[s]`.
    fn share(&self, segment: usize, time: f64) -> f64 {
        let [from, to] = [self.times[segment], self.times[segment + 1]];
        ((time - from) / (to - from)).clamp(0.0, 1.0)
    }

    /// Returns the end of the path `[s]`.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.times[self.times.len() - 1]
    }

    /// Number of devices.
    #[must_use]
    pub fn devices(&self) -> usize {
        self.positions[0].len()
    }

    /// Returns the position of each device at a time `[s]`; before and after the path that of its ends `[m]`.
    #[must_use]
    pub fn at(&self, time: f64) -> Vec<Vector> {
        let (segment, _) = self.segment(time);
        let share = self.share(segment, time);
        let ends = self.positions[segment]
            .iter()
            .zip(&self.positions[segment + 1]);
        ends.map(|(from, to)| {
            std::array::from_fn(|axis| from[axis] + share * (to[axis] - from[axis]))
        })
        .collect()
    }

    /// Returns the times of its points `[s]`.
    #[must_use]
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Returns the positions of the devices at its points: `[point][device]` `[m]`.
    #[must_use]
    pub fn positions(&self) -> &[Vec<Vector>] {
        &self.positions
    }

    /// Returns the position of the first device at a time `[m]`, its velocity after that time `[m/s]`, and the end of
    /// the present line `[s]`, infinite from the last point on.
    pub(super) fn line_from(&self, time: f64) -> (Vector, Vector, f64) {
        let here = self.at(time)[0];
        if time >= self.end() {
            return (here, [0.0; 3], f64::INFINITY);
        }
        let (segment, end) = self.segment(time);
        let [from, to] = [segment, segment + 1].map(|point| self.positions[point][0]);
        let duration = end - self.times[segment];
        let velocity = std::array::from_fn(|axis| (to[axis] - from[axis]) / duration);
        (here, velocity, end)
    }

    /// Returns the path of the first device along an axis; `own` gives the coordinate of a position on it `[m]`.
    pub(super) fn along(
        &self,
        own: impl Fn(Vector) -> f64,
    ) -> Result<RecordedPath, InvalidParameter> {
        let places: Vec<f64> = self.positions.iter().map(|places| own(places[0])).collect();
        RecordedPath::new(&self.times, &places).map_err(|_| InvalidParameter {
            name: "hand.path",
            value: self.end(),
            allowed: "finite, in increasing order of times",
        })
    }

    /// Number of the line on which it is at a time `[s]`, and where that ends `[s]`.
    fn segment(&self, time: f64) -> (usize, f64) {
        let after = self.times.partition_point(|knot| *knot <= time);
        let segment = after.clamp(1, self.times.len() - 1) - 1;
        (segment, self.times[segment + 1])
    }

    /// The scene with devices that no force moves, where the path begins.
    #[must_use]
    pub fn unmoved(&self, scene: &WorldScene) -> WorldScene {
        let mut scene = scene.clone();
        for (device, position) in scene.devices.iter_mut().zip(&self.positions[0]) {
            // No motor acts along an axis that a device lacks, so no force is evaluated there.
            for mass in device.mass.iter_mut().filter(|mass| mass.is_finite()) {
                *mass = UNMOVED;
            }
            device.mass_table = None;
            device.hand = WorldHand::default();
            device.drivetrain = Drivetrain::default();
            device.position = *position;
            device.velocity = [0.0; 3];
            device.quantum = [0.0; 3];
        }
        let orientations = self.orientations.first().into_iter().flatten();
        for (device, orientation) in scene.devices.iter_mut().zip(orientations) {
            if let Some(turning) = &mut device.turning {
                turning.inertia = [UNMOVED; 3];
                turning.orientation = *orientation;
                turning.angular_velocity = [0.0; 3];
                turning.hand = TurningHand::none();
                turning.quantum = 0.0;
            }
        }
        scene
    }

    /// Moves a run of [`unmoved`](Self::unmoved) on to `end` `[s]`, with its devices on the path.
    pub(super) fn follow(&self, run: &mut Run, end: f64) -> Result<(), WorldError> {
        while run.time < end {
            let (segment, until) = self.segment(run.time);
            let duration = self.times[segment + 1] - self.times[segment];
            let here = self.at(run.time);
            let ends = self.positions[segment]
                .iter()
                .zip(&self.positions[segment + 1]);
            for (device, ((from, to), here)) in ends.zip(here).enumerate() {
                let velocity = std::array::from_fn(|axis| (to[axis] - from[axis]) / duration);
                run.lead(device, here, velocity);
            }
            for (device, here) in self.orientations_at(run.time).into_iter().enumerate() {
                let [from, to] = [segment, segment + 1].map(|it| self.orientations[it][device]);
                let turning: Vec3 = rotation_vector(from, to) * (1.0 / duration);
                run.lead_turning(device, here, turning);
            }
            run.settle_anew();
            // Past the last point of the path the run continues to the end.
            let next = if until > run.time {
                until.min(end)
            } else {
                end
            };
            run.advance(next)?;
        }
        Ok(())
    }
}
