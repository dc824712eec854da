//! Columns of a row, independent of the file format.

use std::borrow::Cow;

use super::cdr::{Reader, Writer};
use super::state::{Flags, Phase};
use super::{BodyTick, ContactTick, Row, Tick};

/// A column of a tick or of a contact. [`Tick::COLUMNS`] and [`ContactTick::COLUMNS`] list all of them. Every file,
/// the live page and the documentation are generated from these lists.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    /// Name, ending with the unit (`penetration_m`).
    pub name: &'static str,
    /// Unit (`m`); `1` for a pure number.
    pub unit: &'static str,
    /// Meaning and sign.
    pub meaning: &'static str,
    /// Outputs with this column.
    pub shown: Shown,
    /// Kind of its values.
    pub kind: Kind,
    pub(super) get: fn(&Row) -> Value,
    pub(super) set: fn(&mut Row, Value),
}

/// Outputs with a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// Tables and the live page.
    Live,
    /// Tables.
    InTables,
    /// Tables of recordings in which some ticks do not have exactly one contact.
    OfSeveralContacts,
}

/// Kind of the values of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Numbers.
    Number,
    /// Counts of 64 bits.
    Count,
    /// Counts of 32 bits.
    ShortCount,
    /// Sets of flags.
    Flags,
    /// Phases.
    Phase,
}

/// A value of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A number in the column's unit; NaN: missing.
    Number(f64),
    /// A count.
    Count(u64),
    /// A count of 32 bits.
    ShortCount(u32),
    /// A set of flags.
    Flags(Flags),
    /// A phase.
    Phase(Phase),
}

impl Column {
    /// Returns the column of this name, including the unit. If tick and contact both have one, returns that of the
    /// tick.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        let contacts = Tick::COLUMNS.iter().chain(ContactTick::COLUMNS);
        let mut all = contacts.chain(BodyTick::COLUMNS);
        all.find(|column| column.name == name)
    }

    /// Returns its value in a row.
    #[must_use]
    pub fn value(&self, row: &Row) -> Value {
        (self.get)(row)
    }

    /// Returns whether the live page shows it.
    #[must_use]
    pub const fn is_live(&self) -> bool {
        matches!(self.shown, Shown::Live)
    }

    /// Returns its name without the unit: `penetration` for `penetration_m`.
    #[must_use]
    pub fn short_name(&self) -> &'static str {
        self.name
            .strip_suffix(suffix(self.unit))
            .unwrap_or(self.name)
    }
}

/// Returns the end of the name of a column with this unit.
fn suffix(unit: &str) -> &'static str {
    match unit {
        "s" => "_s",
        "m" => "_m",
        "m/s" => "_m_per_s",
        "N" => "_n",
        "N/s" => "_n_per_s",
        "N m" => "_n_m",
        "J" => "_j",
        "rad/s" => "_rad_per_s",
        _ => "",
    }
}

impl Kind {
    /// Returns the name of the type in ROS 2.
    #[must_use]
    pub fn message_type(self) -> &'static str {
        match self {
            Self::Number => "float64",
            Self::Count => "uint64",
            Self::ShortCount | Self::Flags => "uint32",
            Self::Phase => "uint8",
        }
    }

    /// Returns the size of a value in a message, which is also its alignment `[bytes]`.
    #[must_use]
    pub fn size(self) -> usize {
        match self {
            Self::Number | Self::Count => 8,
            Self::ShortCount | Self::Flags => 4,
            Self::Phase => 1,
        }
    }

    /// Reads the next value of a message; `None` if the message ends before or has an invalid value.
    pub(super) fn decode(self, bytes: &mut Reader<'_>) -> Option<Value> {
        Some(match self {
            Self::Number => Value::Number(f64::from_bits(bytes.u64()?)),
            Self::Count => Value::Count(bytes.u64()?),
            Self::ShortCount => Value::ShortCount(bytes.u32()?),
            Self::Flags => Value::Flags(Flags(bytes.u32()?)),
            Self::Phase => Value::Phase(*Phase::ALL.get(usize::from(bytes.u8()?))?),
        })
    }
}

impl Value {
    /// Returns a value that is not a number as text: counts in digits, flags and phases by their names.
    #[must_use]
    pub fn text(self) -> Cow<'static, str> {
        match self {
            Self::Number(number) => number.to_string().into(),
            Self::Count(count) => count.to_string().into(),
            Self::ShortCount(count) => count.to_string().into(),
            Self::Flags(flags) => flags.names().into(),
            Self::Phase(phase) => phase.name().into(),
        }
    }

    /// Returns the value as a number: flags by their bits, a phase by its number in a recording.
    #[must_use]
    pub fn number(self) -> f64 {
        match self {
            Self::Number(number) => number,
            Self::Count(count) => count as f64,
            Self::ShortCount(count) => f64::from(count),
            Self::Flags(flags) => f64::from(flags.0),
            Self::Phase(phase) => f64::from(phase.number()),
        }
    }

    pub(super) fn encode(self, out: &mut Writer<'_>) {
        match self {
            Self::Number(number) => out.u64(number.to_bits()),
            Self::Count(count) => out.u64(count),
            Self::ShortCount(count) => out.u32(count),
            Self::Flags(flags) => out.u32(flags.0),
            Self::Phase(phase) => out.u8(phase.number()),
        }
    }
}

/// A field of a row: the values of one column, or of several by their index.
pub(super) trait Cells {
    const KIND: Kind;
    /// Value that means unknown.
    const UNKNOWN: Self;

    fn get(&self, place: usize) -> Value;

    /// Sets a value of the field's kind; a value of another kind changes nothing.
    fn set(&mut self, place: usize, value: Value);
}

macro_rules! cells {
    ($($type:ty: $kind:ident, $unknown:expr;)+) => {$(
        impl Cells for $type {
            const KIND: Kind = Kind::$kind;
            const UNKNOWN: Self = $unknown;

            fn get(&self, _: usize) -> Value {
                Value::$kind(*self)
            }

            fn set(&mut self, _: usize, value: Value) {
                if let Value::$kind(value) = value {
                    *self = value;
                }
            }
        }
    )+};
}

cells! {
    f64: Number, f64::NAN;
    u64: Count, 0;
    u32: ShortCount, 0;
    Flags: Flags, Flags(0);
    Phase: Phase, Phase::Free;
}

impl<const N: usize> Cells for [f64; N] {
    const KIND: Kind = Kind::Number;
    const UNKNOWN: Self = [f64::NAN; N];

    fn get(&self, place: usize) -> Value {
        self[place].get(0)
    }

    fn set(&mut self, place: usize, value: Value) {
        self[place].set(0, value);
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    fn all() -> Vec<&'static Column> {
        let contacts = Tick::COLUMNS.iter().chain(ContactTick::COLUMNS);
        contacts.chain(BodyTick::COLUMNS).collect()
    }

    #[test]
    fn the_name_of_a_column_ends_with_its_unit() {
        for column in all() {
            let Column { name, unit, .. } = *column;
            let units = ["1", "s", "m", "m/s", "N", "N/s", "N m", "J", "rad/s"];
            assert!(units.contains(&unit), "{name}");
            assert!(name.ends_with(suffix(unit)), "{name} in {unit}");
            assert_eq!(format!("{}{}", column.short_name(), suffix(unit)), name);
            // A number has a unit, except in a quaternion or a unit vector, and other kinds have none.
            let is_pure = name.contains("_orientation_") || name.starts_with("contact_normal_");
            assert_eq!(
                unit == "1",
                column.kind != Kind::Number || is_pure,
                "{name}"
            );
        }
        for columns in [Tick::COLUMNS, ContactTick::COLUMNS, BodyTick::COLUMNS] {
            let names: BTreeSet<&str> = columns.iter().map(|column| column.name).collect();
            assert_eq!(names.len(), columns.len());
        }
    }

    /// Detects two columns that access the same quantity: each column is set alone in an empty row, and no other may
    /// then have a value.
    #[test]
    fn each_column_gives_what_it_took_and_nothing_else() {
        let all = all();
        for (at, column) in all.iter().enumerate() {
            let value = match column.kind {
                Kind::Number => Value::Number(0.5),
                Kind::Count => Value::Count(1 << 40),
                Kind::ShortCount => Value::ShortCount(7),
                Kind::Flags => Value::Flags(Flags::FAULT),
                Kind::Phase => Value::Phase(Phase::Leaves),
            };
            let mut row = Row::default();
            (column.set)(&mut row, value);
            for (other, name) in all.iter().enumerate().map(|(at, c)| (at, c.name)) {
                let found = all[other].value(&row);
                let empty = all[other].value(&Row::default());
                let expected = if other == at { value } else { empty };
                assert_eq!(found, expected, "{name} after {}", column.name);
            }
        }
    }
}
