//! Reads a parsed TOML table into types that implement serde's `Deserialize`.
//!
//! The `toml` crate can do this too. Its reader has a type for each of tables, lists, values and keys, and the compiler
//! copies the code of every type that is read for each of them. The reader here has one type for all. The playground is
//! a fifth smaller by that.

use std::fmt;
use std::ops::Range;

use serde::de::{
    self, DeserializeOwned, DeserializeSeed, Deserializer, EnumAccess, Expected, IntoDeserializer,
    MapAccess, SeqAccess, Unexpected, VariantAccess, Visitor,
};
use serde::forward_to_deserialize_any;
use serde_spanned::de::is_spanned;
use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

use super::fault::in_plain_words;
use super::recover::Fault;

/// Error in a table; its span is that of the innermost wrong value.
#[derive(Debug)]
pub(super) struct ReadError(Box<Wrong>);

#[derive(Debug)]
struct Wrong {
    message: String,
    span: Option<Range<usize>>,
    missing: Option<Missing>,
}

/// Missing item of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Missing {
    /// The key of this name.
    Key(&'static str),
    /// The one key by which something is chosen.
    Choice,
}

impl ReadError {
    /// Its bytes in the text.
    pub fn span(&self) -> Option<Range<usize>> {
        self.0.span.clone()
    }

    /// Returns the error message of serde.
    pub fn message(&self) -> &str {
        &self.0.message
    }

    /// Returns the missing item, if one is missing.
    pub fn missing(&self) -> Option<Missing> {
        self.0.missing
    }

    /// Returns its bytes, and its message without Rust's names of types.
    pub fn fault(&self) -> Fault {
        (self.span().unwrap_or(0..0), in_plain_words(self.message()))
    }

    fn at(mut self, span: &Range<usize>) -> Self {
        self.0.span.get_or_insert_with(|| span.clone());
        self
    }

    fn lacks(mut self, missing: Missing) -> Self {
        self.0.missing = Some(missing);
        self
    }
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message())
    }
}

impl std::error::Error for ReadError {}

impl de::Error for ReadError {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self(Box::new(Wrong {
            message: message.to_string(),
            span: None,
            missing: None,
        }))
    }

    fn missing_field(field: &'static str) -> Self {
        Self::custom(format_args!("missing field `{field}`")).lacks(Missing::Key(field))
    }
}

impl From<toml::de::Error> for ReadError {
    fn from(error: toml::de::Error) -> Self {
        Self(Box::new(Wrong {
            message: error.message().to_owned(),
            span: error.span(),
            missing: None,
        }))
    }
}

/// Reads the text of a file.
pub(super) fn from_text<T: DeserializeOwned>(source: &str) -> Result<T, ReadError> {
    from_table(&DeTable::parse(source)?)
}

/// Reads a table.
pub(super) fn from_table<T: DeserializeOwned>(
    table: &Spanned<DeTable<'_>>,
) -> Result<T, ReadError> {
    T::deserialize(Item {
        what: What::Table(table.get_ref()),
        span: table.span(),
    })
}

/// A value being read, with its span.
#[derive(Clone)]
struct Item<'t> {
    what: What<'t>,
    span: Range<usize>,
}

#[derive(Clone, Copy)]
enum What<'t> {
    Table(&'t DeTable<'t>),
    Value(&'t DeValue<'t>),
    /// The name of a key, or of a field that [`Spanned`] asks for.
    Name(&'t str),
    /// Start or end of a span that [`Spanned`] requests.
    Place(usize),
}

impl<'t> Item<'t> {
    fn value(value: &'t Spanned<DeValue<'t>>) -> Self {
        Self {
            what: What::Value(value.get_ref()),
            span: value.span(),
        }
    }

    fn name(name: &'t Spanned<DeString<'t>>) -> Self {
        Self {
            what: What::Name(name.get_ref()),
            span: name.span(),
        }
    }

    /// Reads what has named parts. A list of them, which serde would take as well, is refused; the code that reads it
    /// is thereby left out of the program.
    fn only_a_table<V: Visitor<'t>>(self, visitor: V) -> Result<V::Value, ReadError> {
        let read = match self.table() {
            Some(table) => visitor.visit_map(Entries::new(table)),
            None => Err(self.is_no_table(&visitor)),
        };
        read.map_err(|error| error.at(&self.span))
    }

    fn is_no_table(&self, expected: &dyn Expected) -> ReadError {
        let found = match self.what {
            What::Value(DeValue::Array(_)) => {
                return de::Error::invalid_type(Unexpected::Seq, &"a table");
            }
            What::Value(DeValue::String(text)) => Unexpected::Str(text),
            What::Value(DeValue::Boolean(value)) => Unexpected::Bool(*value),
            What::Value(value) => match number(value) {
                Some(Ok(Number::Signed(number))) => Unexpected::Signed(number),
                Some(Ok(Number::Unsigned(number))) => Unexpected::Unsigned(number),
                Some(Ok(Number::Float(number))) => Unexpected::Float(number),
                Some(Err(error)) => return error,
                None => Unexpected::Other("date"),
            },
            What::Name(name) => Unexpected::Str(name),
            What::Place(place) => Unexpected::Unsigned(place as u64),
            What::Table(_) => Unexpected::Map,
        };
        de::Error::invalid_type(found, expected)
    }

    fn table(&self) -> Option<&'t DeTable<'t>> {
        match self.what {
            What::Table(table) | What::Value(DeValue::Table(table)) => Some(table),
            _ => None,
        }
    }
}

/// A number of TOML as serde takes it.
enum Number {
    Signed(i64),
    Unsigned(u64),
    Float(f64),
}

/// The number that a value is, if it is one.
fn number(value: &DeValue<'_>) -> Option<Result<Number, ReadError>> {
    let number = match value {
        DeValue::Integer(integer) => {
            let (digits, radix) = (integer.as_str(), integer.radix());
            let signed = i64::from_str_radix(digits, radix).map(Number::Signed);
            let unsigned = || u64::from_str_radix(digits, radix).map(Number::Unsigned);
            signed.or_else(|_| unsigned()).ok()
        }
        DeValue::Float(float) => {
            let digits = float.as_str();
            let parsed = digits.parse().ok();
            // An infinity is written as such; otherwise it is a number with too many digits before the point.
            parsed
                .filter(|number: &f64| {
                    number.is_finite() || !digits.contains(|c: char| c.is_ascii_digit())
                })
                .map(Number::Float)
        }
        _ => return None,
    };
    Some(number.ok_or_else(|| de::Error::custom("the number is too large to be read")))
}

impl<'t> Deserializer<'t> for Item<'t> {
    type Error = ReadError;

    fn deserialize_any<V: Visitor<'t>>(self, visitor: V) -> Result<V::Value, ReadError> {
        let span = self.span.clone();
        let read = if let Some(table) = self.table() {
            visitor.visit_map(Entries::new(table))
        } else {
            match self.what {
                What::Value(DeValue::Array(values)) => {
                    let mut items = Items(values.iter());
                    let read = visitor.visit_seq(&mut items);
                    // Reject a list with more items than are read; they would be lost silently.
                    match (read, items.0.len()) {
                        (Ok(_), left @ 1..) => {
                            let (all, read) = (values.len(), values.len() - left);
                            let expected = format!("an array of length {read}");
                            Err(de::Error::invalid_length(all, &expected.as_str()))
                        }
                        (read, _) => read,
                    }
                }
                What::Value(DeValue::String(text)) => visitor.visit_borrowed_str(text),
                What::Value(DeValue::Boolean(value)) => visitor.visit_bool(*value),
                What::Value(value) => match number(value) {
                    Some(Ok(Number::Signed(number))) => visitor.visit_i64(number),
                    Some(Ok(Number::Unsigned(number))) => visitor.visit_u64(number),
                    Some(Ok(Number::Float(number))) => visitor.visit_f64(number),
                    Some(Err(error)) => Err(error),
                    // A date or a time, which no file here has.
                    None => Err(de::Error::invalid_type(Unexpected::Other("date"), &visitor)),
                },
                What::Name(name) => visitor.visit_borrowed_str(name),
                What::Place(place) => visitor.visit_u64(place as u64),
                What::Table(_) => visitor.visit_unit(),
            }
        };
        read.map_err(|error| error.at(&span))
    }

    fn deserialize_option<V: Visitor<'t>>(self, visitor: V) -> Result<V::Value, ReadError> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'t>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_struct<V: Visitor<'t>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        match fields {
            // The span's start, its end, and the value.
            [start, end, value] if is_spanned(name) => {
                let span = self.span.clone();
                visitor.visit_map(Entries {
                    of_table: None,
                    beside: [
                        Some((start, What::Place(span.start))),
                        Some((end, What::Place(span.end))),
                        Some((value, self.what)),
                    ],
                    span,
                    next: None,
                })
            }
            _ => self.only_a_table(visitor),
        }
    }

    fn deserialize_map<V: Visitor<'t>>(self, visitor: V) -> Result<V::Value, ReadError> {
        self.only_a_table(visitor)
    }

    fn deserialize_enum<V: Visitor<'t>>(
        self,
        name: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        let span = self.span.clone();
        let variant = match (self.table(), self.what) {
            (Some(table), _) => {
                let mut entries = table.iter();
                match (entries.next(), entries.next()) {
                    (Some((name, content)), None) => Ok(Variant {
                        name: Item::name(name),
                        content: Some(Item::value(content)),
                    }),
                    (None, _) => {
                        let error: ReadError =
                            de::Error::custom("there is no key, and exactly one is expected");
                        Err(error.lacks(Missing::Choice))
                    }
                    _ => Err(de::Error::custom(
                        "there is more than one key, and exactly one is expected",
                    )),
                }
            }
            (None, What::Name(_) | What::Value(DeValue::String(_))) => Ok(Variant {
                name: self,
                content: None,
            }),
            (_, What::Value(DeValue::Array(_))) => {
                // The name of `RawShape`.
                let instead = if name == "shape" {
                    "; several shapes of a body are one mesh with a closed part for each, of a tool a mesh or spheres"
                } else {
                    ""
                };
                Err(de::Error::custom(format!(
                    "there is a list, and exactly one string or table is expected{instead}"
                )))
            }
            _ => Err(de::Error::custom("wanted string or table")),
        };
        variant
            .and_then(|variant| visitor.visit_enum(variant))
            .map_err(|error: ReadError| error.at(&span))
    }

    forward_to_deserialize_any! {
        <V: Visitor<'t>>
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct identifier ignored_any
    }
}

impl<'t> IntoDeserializer<'t, ReadError> for Item<'t> {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

/// The entries of a table, or what [`Spanned`] asks for.
struct Entries<'t> {
    of_table: Option<toml::map::Iter<'t, Spanned<DeString<'t>>, Spanned<DeValue<'t>>>>,
    beside: [Option<(&'static str, What<'t>)>; 3],
    span: Range<usize>,
    /// The value of the key that was read last.
    next: Option<Item<'t>>,
}

impl<'t> Entries<'t> {
    fn new(table: &'t DeTable<'t>) -> Self {
        Self {
            of_table: Some(table.iter()),
            beside: [None; 3],
            span: 0..0,
            next: None,
        }
    }

    /// The next key; its value is kept.
    fn step(&mut self) -> Option<Item<'t>> {
        let (name, value) = if let Some(entries) = &mut self.of_table {
            let (name, value) = entries.next()?;
            (Item::name(name), Item::value(value))
        } else {
            let (name, what) = self.beside.iter_mut().find_map(Option::take)?;
            let at = |what| Item {
                what,
                span: self.span.clone(),
            };
            (at(What::Name(name)), at(what))
        };
        self.next = Some(value);
        Some(name)
    }
}

impl<'t> MapAccess<'t> for Entries<'t> {
    type Error = ReadError;

    fn next_key_seed<K: DeserializeSeed<'t>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, ReadError> {
        let Some(name) = self.step() else {
            return Ok(None);
        };
        let span = name.span.clone();
        let key = seed.deserialize(name).map_err(|error| error.at(&span))?;
        Ok(Some(key))
    }

    fn next_value_seed<V: DeserializeSeed<'t>>(&mut self, seed: V) -> Result<V::Value, ReadError> {
        match self.next.take() {
            Some(value) => {
                let span = value.span.clone();
                seed.deserialize(value).map_err(|error| error.at(&span))
            }
            None => Err(de::Error::custom("a value was read without its key")),
        }
    }
}

struct Items<'t>(std::slice::Iter<'t, Spanned<DeValue<'t>>>);

impl<'t> SeqAccess<'t> for &mut Items<'t> {
    type Error = ReadError;

    fn next_element_seed<T: DeserializeSeed<'t>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, ReadError> {
        let next = self.0.next();
        next.map(|item| seed.deserialize(Item::value(item)))
            .transpose()
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.0.len())
    }
}

/// A name, or a table of one key: the name of a variant and its content.
struct Variant<'t> {
    name: Item<'t>,
    content: Option<Item<'t>>,
}

impl<'t> EnumAccess<'t> for Variant<'t> {
    type Error = ReadError;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'t>>(self, seed: V) -> Result<(V::Value, Self), ReadError> {
        let span = self.name.span.clone();
        let variant = seed.deserialize(self.name.clone());
        variant
            .map(|variant| (variant, self))
            .map_err(|error| error.at(&span))
    }
}

impl<'t> Variant<'t> {
    fn content(self, expected: &str) -> Result<Item<'t>, ReadError> {
        self.content
            .ok_or_else(|| de::Error::invalid_type(Unexpected::UnitVariant, &expected))
    }
}

impl<'t> VariantAccess<'t> for Variant<'t> {
    type Error = ReadError;

    fn unit_variant(self) -> Result<(), ReadError> {
        match self.content {
            Some(content) if content.table().is_none_or(|table| !table.is_empty()) => {
                let error: ReadError = de::Error::custom("expected empty table");
                Err(error.at(&content.span))
            }
            _ => Ok(()),
        }
    }

    fn newtype_variant_seed<T: DeserializeSeed<'t>>(self, seed: T) -> Result<T::Value, ReadError> {
        seed.deserialize(self.content("newtype variant")?)
    }

    fn tuple_variant<V: Visitor<'t>>(self, _: usize, visitor: V) -> Result<V::Value, ReadError> {
        self.content("tuple variant")?.deserialize_any(visitor)
    }

    fn struct_variant<V: Visitor<'t>>(
        self,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ReadError> {
        self.content("struct variant")?.only_a_table(visitor)
    }
}

#[cfg(test)]
mod tests;
