//! Between whom a contact is.

use std::fmt;

use palpate_world::Party;
use serde::Deserialize;
use serde::de::{Deserializer, Error, SeqAccess, Unexpected, Visitor};

/// Two names, each of which may be "*" for any; or "*" alone for any pair.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pair(pub [Party; 2]);

fn party(name: String) -> Party {
    match name.as_str() {
        "*" => Party::Any,
        _ => Party::Named(name),
    }
}

impl<'de> Deserialize<'de> for Pair {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct AnyOrTwo;

        impl<'de> Visitor<'de> for AnyOrTwo {
            type Value = Pair;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("two names [\"tool\", \"floor\"], or \"*\" for any pair")
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Pair, E> {
                match text {
                    "*" => Ok(Pair([Party::Any, Party::Any])),
                    _ => Err(Error::invalid_value(Unexpected::Str(text), &self)),
                }
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut names: A) -> Result<Pair, A::Error> {
                let mut next = |index| {
                    let name: Option<String> = names.next_element()?;
                    name.map(party)
                        .ok_or_else(|| Error::invalid_length(index, &self))
                };
                let pair = Pair([next(0)?, next(1)?]);
                match names.next_element::<String>()? {
                    None => Ok(pair),
                    Some(_) => Err(Error::invalid_length(3, &self)),
                }
            }
        }

        deserializer.deserialize_any(AnyOrTwo)
    }
}
