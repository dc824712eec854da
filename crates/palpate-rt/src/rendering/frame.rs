//! Frame of a device in a world.

use std::fmt;

use palpate_device::Vector;

/// Frame of a device in a world: the world axis and the direction of each device axis, and a point of the device's
/// frame with its position in the world.
///
/// ```text
///      world z
///        |                 A device in the plane, upright before its user: its x is the world's x,
///        |   device y      its y is the world's z. Along the world's y the tool stays where it
///        |     ^           begins, and the device gives no force.
///        |     |
///        |     o---> device x
///        +----------------- world x
/// ```
///
/// Along world axes without a device axis the tool keeps its position, and the force along them reaches no motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldFrame {
    origin: Vector,
    place: Vector,
    axes: [Option<WorldAxis>; 3],
}

/// An axis of the world with a direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WorldAxis {
    /// 0 for x, 1 for y, 2 for z.
    pub axis: usize,
    /// Whether the device's axis points in the opposite direction.
    pub is_reversed: bool,
}

/// Returns the name of an axis of the world.
fn name(axis: usize) -> &'static str {
    ["x", "y", "z"].get(axis).copied().unwrap_or_default()
}

/// Reason for rejecting a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FrameError {
    /// An invalid axis.
    #[error("axis {0} of the world; allowed: 0 for x, 1 for y, 2 for z")]
    NoAxis(usize),
    /// Two axes of the device are assigned to one axis of the world.
    #[error("two axes of the device are the same axis of the world, {}", name(*.0))]
    Twice(usize),
    /// A position that is not finite.
    #[error("a position of the frame is not finite")]
    NotFinite,
}

impl WorldFrame {
    /// Returns the identity: axes and positions of the device are those of the world.
    #[must_use]
    pub fn the_same() -> Self {
        Self {
            origin: [0.0; 3],
            place: [0.0; 3],
            axes: [0, 1, 2].map(|axis| Some(WorldAxis::along(axis))),
        }
    }

    /// Creates a frame. `axes` assigns an axis of the world to each axis of the device. `origin` in the device's
    /// frame `[m]` coincides with `place` in the world `[m]`. Along world axes that are not assigned the tool stays
    /// at `place`.
    ///
    /// # Errors
    /// An invalid or repeated axis; a position that is not finite.
    pub fn new(
        axes: [Option<WorldAxis>; 3],
        origin: Vector,
        place: Vector,
    ) -> Result<Self, FrameError> {
        let mut is_taken = [false; 3];
        for WorldAxis { axis, .. } in axes.into_iter().flatten() {
            let taken = is_taken.get_mut(axis).ok_or(FrameError::NoAxis(axis))?;
            if std::mem::replace(taken, true) {
                return Err(FrameError::Twice(axis));
            }
        }
        if !origin.iter().chain(&place).all(|x| x.is_finite()) {
            return Err(FrameError::NotFinite);
        }
        Ok(Self {
            origin,
            place,
            axes,
        })
    }

    /// Parses the text form of a frame from a recording's metadata; `None` for other text.
    #[must_use]
    pub fn read(text: &str) -> Option<Self> {
        let list = |key: &str| {
            let mut lines = text.lines().filter_map(|line| line.split_once(" = "));
            let (_, value) = lines.find(|(name, _)| *name == key)?;
            let inner = value.strip_prefix('[')?.strip_suffix(']')?;
            let parts = inner.split(", ").filter(|part| !part.is_empty());
            Some(parts.map(str::to_owned).collect::<Vec<_>>())
        };
        let mut axes = [None; 3];
        for (own, written) in axes.iter_mut().zip(list("axes")?) {
            let written = written.trim_matches('"');
            let letter = written.strip_prefix('-').unwrap_or(written);
            let along = WorldAxis::along((0..3).find(|axis| name(*axis) == letter)?);
            *own = Some(if letter == written {
                along
            } else {
                along.reversed()
            });
        }
        let vector = |key| -> Option<Vector> {
            let numbers: Option<Vec<f64>> = list(key)?.iter().map(|x| x.parse().ok()).collect();
            numbers?.try_into().ok()
        };
        Self::new(axes, vector("device_place_m")?, vector("world_place_m")?).ok()
    }

    /// Returns whether the axes of the device are those of the world, in their order and direction.
    #[must_use]
    pub fn is_aligned(&self) -> bool {
        self.axes == Self::the_same().axes
    }

    /// Returns whether an axis of the device is assigned to this axis of the world.
    #[must_use]
    pub fn has(&self, axis: usize) -> bool {
        self.axes.iter().flatten().any(|own| own.axis == axis)
    }

    /// Converts a `position` of the device `[m]` to the world.
    #[must_use]
    pub fn in_world(&self, position: Vector) -> Vector {
        let mut place = self.place;
        for ((axis, x), origin) in self.axes.iter().zip(position).zip(self.origin) {
            if let Some(along) = axis
                && let Some(there) = place.get_mut(along.axis)
            {
                *there += along.sign() * (x - origin);
            }
        }
        place
    }

    /// Converts a force of the world `[N]` to the device's axes. Components without a device axis are dropped.
    #[must_use]
    pub fn on_device(&self, force: Vector) -> Vector {
        self.axes.map(|axis| {
            let part = axis.and_then(|along| Some(along.sign() * force.get(along.axis)?));
            part.unwrap_or(0.0)
        })
    }

    /// Converts a force of the device `[N]` to the world's axes.
    #[must_use]
    pub fn of_device(&self, force: Vector) -> Vector {
        let mut in_world = [0.0; 3];
        for (axis, x) in self.axes.iter().zip(force) {
            if let Some(along) = axis
                && let Some(there) = in_world.get_mut(along.axis)
            {
                *there = along.sign() * x;
            }
        }
        in_world
    }
}

impl fmt::Display for WorldFrame {
    /// Writes lines of `key = value` in TOML syntax with the unit in the key.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let written = |along: &WorldAxis| {
            let sign = if along.is_reversed { "-" } else { "" };
            format!("\"{sign}{}\"", name(along.axis))
        };
        let axes: Vec<String> = self.axes.iter().flatten().map(written).collect();
        let vector = |[x, y, z]: Vector| format!("[{x}, {y}, {z}]");
        writeln!(f, "axes = [{}]", axes.join(", "))?;
        writeln!(f, "device_place_m = {}", vector(self.origin))?;
        writeln!(f, "world_place_m = {}", vector(self.place))
    }
}

impl WorldAxis {
    /// Creates an axis of the world in its own direction: 0 for x, 1 for y, 2 for z.
    #[must_use]
    pub fn along(axis: usize) -> Self {
        Self {
            axis,
            is_reversed: false,
        }
    }

    /// Reverses the direction of the axis.
    #[must_use]
    pub fn reversed(self) -> Self {
        Self {
            is_reversed: !self.is_reversed,
            ..self
        }
    }

    fn sign(self) -> f64 {
        if self.is_reversed { -1.0 } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_upright_in_the_plane_has_no_force_along_the_third_axis() {
        let axes = [
            Some(WorldAxis::along(0).reversed()),
            Some(WorldAxis::along(2)),
            None,
        ];
        let frame = WorldFrame::new(axes, [0.0, 0.15, 9.0], [0.5, 0.25, 1.0]).unwrap();
        assert_eq!(WorldFrame::read(&frame.to_string()), Some(frame));
        assert_eq!(WorldFrame::read("axes = [\"x\", \"w\"]\n"), None);
        assert_eq!(frame.in_world([0.0, 0.15, 7.0]), [0.5, 0.25, 1.0]);
        assert_eq!(frame.in_world([0.125, 0.65, 7.0]), [0.375, 0.25, 1.5]);
        assert_eq!(frame.on_device([1.0, 2.0, 3.0]), [-1.0, 3.0, 0.0]);
        assert_eq!(frame.of_device([-1.0, 3.0, 5.0]), [1.0, 0.0, 3.0]);
        assert!(frame.has(0) && !frame.has(1) && frame.has(2));
        let same = WorldFrame::the_same();
        assert_eq!(same.in_world([1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
        assert_eq!(same.on_device([1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
    }

    #[test]
    fn a_frame_that_cannot_be_says_why() {
        let along = |axis| Some(WorldAxis::along(axis));
        let refused = |axes, place| WorldFrame::new(axes, [0.0; 3], place).unwrap_err();
        let twice = refused([along(1), along(1), None], [0.0; 3]);
        assert_eq!(
            twice.to_string(),
            "two axes of the device are the same axis of the world, y"
        );
        assert_eq!(
            refused([along(3), None, None], [0.0; 3]),
            FrameError::NoAxis(3)
        );
        let nan = refused([along(0), None, None], [0.0, f64::NAN, 0.0]);
        assert_eq!(nan, FrameError::NotFinite);
    }
}
