//! Axes of the world by their names, and a value along each axis of a device.

use std::fmt;

use palpate_world::Vector;
use serde::Deserialize;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};

/// One number for all axes, or one for each axis of a device, in the order x, y, z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PerAxis {
    All(f64),
    /// So many of these.
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

    /// The value along each axis of the world, `otherwise` along those that are not among `axes`. `None`: there are more or fewer
    /// numbers than axes.
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

/// The axes of a device by their names, in the order x, y, z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NamedAxes(pub [bool; 3]);

impl<'de> Deserialize<'de> for NamedAxes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        const ALLOWED: &str =
            "one to three of \"x\", \"y\" and \"z\", in this order, such as [\"x\", \"y\"]";
        let names = Vec::<String>::deserialize(deserializer)?;
        let mut axes = [false; 3];
        let mut next = 0;
        for name in &names {
            let axis = (0..3).find(|&axis| ["x", "y", "z"][axis] == name);
            let axis = axis.filter(|&axis| axis >= next);
            let axis =
                axis.ok_or_else(|| Error::custom(format!("{names:?}, expected {ALLOWED}")))?;
            axes[axis] = true;
            next = axis + 1;
        }
        if names.is_empty() {
            return Err(Error::custom(format!("no axis, expected {ALLOWED}")));
        }
        Ok(Self(axes))
    }
}
