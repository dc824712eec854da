//! The axes of a device, and a value along each of them.

use std::fmt;

use palpate_world::{Shape, Tool, Vector};
use serde::Deserialize;
use serde::de::value::SeqAccessDeserializer;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};

/// One number for all axes, or one for each axis of a device, in the order in which it has them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PerAxis {
    All(f64),
    /// A value for each of this number of axes.
    Each(usize, Vector),
}

impl PerAxis {
    /// The numbers that were given.
    pub fn given(&self) -> &[f64] {
        match self {
            Self::All(value) => std::slice::from_ref(value),
            Self::Each(count, values) => &values[..*count],
        }
    }

    /// Returns the value along each axis, `otherwise` along axes that are not in `axes`. `None`: the number of values
    /// differs from the number of axes.
    pub fn along(&self, axes: [bool; 3], otherwise: f64) -> Option<Vector> {
        let count = axes.iter().filter(|has| **has).count();
        let mut given = match *self {
            Self::All(value) => [value; 3],
            Self::Each(given, values) if given == count => values,
            Self::Each(..) => return None,
        }
        .into_iter();
        Some(axes.map(|has| {
            let value = if has { given.next() } else { None };
            value.unwrap_or(otherwise)
        }))
    }
}

impl<'de> Deserialize<'de> for PerAxis {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OneOrEach;

        impl<'de> Visitor<'de> for OneOrEach {
            type Value = PerAxis;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(
                    "a number for all axes of the device, or one for each, such as [x, y, z]",
                )
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<PerAxis, E> {
                Ok(PerAxis::All(value))
            }

            fn visit_i64<E: Error>(self, value: i64) -> Result<PerAxis, E> {
                Ok(PerAxis::All(value as f64))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut values: A) -> Result<PerAxis, A::Error> {
                let mut vector = [0.0; 3];
                let mut count = 0;
                while let Some(value) = values.next_element::<f64>()? {
                    let place = vector.get_mut(count);
                    *place.ok_or_else(|| Error::invalid_length(count + 1, &self))? = value;
                    count += 1;
                }
                if count == 0 {
                    return Err(Error::invalid_length(0, &self));
                }
                Ok(PerAxis::Each(count, vector))
            }
        }

        deserializer.deserialize_any(OneOrEach)
    }
}

/// Axes of a device: world axes by name, in the order x, y, z, or directions of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DeviceAxes {
    /// Available axes.
    pub has: [bool; 3],
    /// Unit vectors at right angles; `None` for the world's axes.
    pub own: Option<[Vector; 3]>,
}

impl DeviceAxes {
    /// All axes of the world.
    pub const WORLD: Self = Self {
        has: [true; 3],
        own: None,
    };

    /// The axis y of the world.
    pub const Y: Self = Self {
        has: [false, true, false],
        own: None,
    };

    /// Returns the error of the vector `given` under `key` if it has a component along an axis that is missing, other
    /// than that of `held`.
    pub fn refused(&self, key: &str, given: Vector, held: Vector) -> Option<String> {
        let lacking = (0..3).filter(|&axis| !self.has[axis]);
        if let Some(own) = &self.own {
            let beyond = |axis: usize| {
                let parts = own[axis].iter().zip(given.iter().zip(held));
                parts
                    .map(|(of, (given, held))| of * (given - held))
                    .sum::<f64>()
            };
            let off = lacking.map(beyond).fold(0.0, |a: f64, b: f64| a.hypot(b));
            let size = given
                .iter()
                .chain(&held)
                .fold(0.0, |most: f64, part| most.max(part.abs()));
            return (off > MAX_BEYOND * size).then(|| {
                format!(
                    "{key} has a component of {off} along an axis that is not in the `axes` of the device: its \
                     mechanism blocks that axis; give components along its axes only"
                )
            });
        }
        let mut wrong = lacking.filter(|&axis| given[axis] != held[axis]);
        let axis = wrong.next()?;
        let name = ["x", "y", "z"][axis];
        let names = Tool {
            axes: self.has,
            ..Tool::new("", Shape::Sphere { radius: 0.0 })
        }
        .names_of_axes();
        Some(format!(
            "{key} is {} along {name}, but the `axes` of the device are {names} only: its mechanism blocks {name}; \
             write {} there",
            given[axis], held[axis]
        ))
    }
}

/// Largest component of a vector outside the axes of its device, relative to its largest component: decimal fractions
/// are rounded.
const MAX_BEYOND: f64 = 1e-6;

/// One axis of a device, as read from a file.
enum Axis {
    /// Name of a world axis.
    Named(String),
    /// Direction of any length above 0.
    Along(Vector),
}

impl<'de> Deserialize<'de> for Axis {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NameOrDirection;

        impl<'de> Visitor<'de> for NameOrDirection {
            type Value = Axis;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("\"x\", \"y\" or \"z\", or a direction, such as [0.8, 0.6, 0.0]")
            }

            fn visit_str<E: Error>(self, name: &str) -> Result<Axis, E> {
                Ok(Axis::Named(name.to_owned()))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, values: A) -> Result<Axis, A::Error> {
                Vector::deserialize(SeqAccessDeserializer::new(values)).map(Axis::Along)
            }
        }

        deserializer.deserialize_any(NameOrDirection)
    }
}

impl<'de> Deserialize<'de> for DeviceAxes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        const ALLOWED: &str = "one to three of \"x\", \"y\" and \"z\", in this order, such as [\"x\", \"y\"], or one to three \
                               directions at right angles, such as [[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0]]";
        let wrong = |what: String| D::Error::custom(format!("{what}, expected {ALLOWED}"));
        let (mut names, mut directions) = (Vec::new(), Vec::new());
        for axis in Vec::<Axis>::deserialize(deserializer)? {
            match axis {
                Axis::Named(name) => names.push(name),
                Axis::Along(direction) => directions.push(direction),
            }
        }
        match (names.len(), directions.len()) {
            (0, 0) => Err(wrong("no axis".into())),
            (_, 0) => Ok(Self {
                has: named(&names).map_err(wrong)?,
                own: None,
            }),
            (0, count @ 1..=3) => Ok(Self {
                has: [0, 1, 2].map(|axis| axis < count),
                own: Some(at_right_angles(&directions).map_err(wrong)?),
            }),
            (0, count) => Err(wrong(format!("{count} directions"))),
            _ => Err(wrong("names and directions".into())),
        }
    }
}

/// Returns the named axes of the world, in the order x, y, z.
fn named(names: &[String]) -> Result<[bool; 3], String> {
    let (mut has, mut next) = ([false; 3], 0);
    for name in names {
        let axis = ["x", "y", "z"].iter().position(|axis| axis == name);
        let axis = axis.filter(|&axis| axis >= next);
        let axis = axis.ok_or_else(|| format!("{names:?}"))?;
        has[axis] = true;
        next = axis + 1;
    }
    Ok(has)
}

/// Tolerance on the cosine of perpendicular directions.
const OFF_RIGHT_ANGLES: f64 = 1e-6;

/// Unit vectors at right angles along these one to three directions, and along others where there are less.
fn at_right_angles(directions: &[Vector]) -> Result<[Vector; 3], String> {
    let dot = |a: &Vector, b: &Vector| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let unit = |vector: &Vector| {
        // Normalise by the largest component, as the numbers may be as large as a file allows.
        let largest = vector
            .iter()
            .fold(0.0_f64, |most, part| most.max(part.abs()));
        let vector = vector.map(|part| part / largest);
        let length = dot(&vector, &vector).sqrt();
        (length.is_finite() && length > 0.0).then(|| vector.map(|part| part / length))
    };
    let mut found: Vec<Vector> = Vec::with_capacity(3);
    // Fill the missing axes with any directions perpendicular to the given ones.
    let others = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for (number, direction) in directions.iter().chain(&others).enumerate() {
        if found.len() == 3 {
            break;
        }
        let is_given = number < directions.len();
        let Some(mut axis) = unit(direction) else {
            return Err(format!("{direction:?} has no direction"));
        };
        for before in &found {
            let cosine = dot(&axis, before);
            if is_given && cosine.abs() > OFF_RIGHT_ANGLES {
                let angle = cosine.clamp(-1.0, 1.0).acos().to_degrees();
                return Err(format!(
                    "{direction:?} is at {angle:.4} degrees to another axis"
                ));
            }
            for (part, before) in axis.iter_mut().zip(before) {
                *part -= cosine * before;
            }
        }
        let left = dot(&axis, &axis).sqrt();
        // At least one of three perpendicular directions is this far from any plane.
        if is_given || left > 0.5 {
            found.push(axis.map(|part| part / left));
        }
    }
    found
        .try_into()
        .map_err(|found: Vec<Vector>| format!("{} directions", found.len()))
}
