//! A value along each axis.

use std::fmt;

use palpate_world::Vector;
use serde::Deserialize;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};

/// Three numbers, or one for all axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PerAxis(pub Vector);

impl<'de> Deserialize<'de> for PerAxis {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OneOrThree;

        impl<'de> Visitor<'de> for OneOrThree {
            type Value = PerAxis;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number for all axes, or three numbers [x, y, z]")
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<PerAxis, E> {
                Ok(PerAxis([value; 3]))
            }

            fn visit_i64<E: Error>(self, value: i64) -> Result<PerAxis, E> {
                Ok(PerAxis([value as f64; 3]))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut values: A) -> Result<PerAxis, A::Error> {
                let mut vector = [0.0; 3];
                for (index, axis) in vector.iter_mut().enumerate() {
                    let next = values.next_element()?;
                    *axis = next.ok_or_else(|| Error::invalid_length(index, &self))?;
                }
                match values.next_element::<f64>()? {
                    None => Ok(PerAxis(vector)),
                    Some(_) => Err(Error::invalid_length(4, &self)),
                }
            }
        }

        deserializer.deserialize_any(OneOrThree)
    }
}
