//! What a column of a row is, whatever file it stands in.

use std::borrow::Cow;

use super::cdr::{Reader, Writer};
use super::state::{Flags, Phase};
use super::{BodyTick, ContactTick, Row, Tick};

/// A column of a tick or of a contact. [`Tick::COLUMNS`] and [`ContactTick::COLUMNS`] have all of them: every
/// file, the live page and the documentation are made from these lists.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    /// Its name, with the unit at its end (`penetration_m`).
    pub name: &'static str,
    /// Its unit (`m`); `1` if it has none.
    pub unit: &'static str,
    /// What it is, and which sign it has.
    pub meaning: &'static str,
    /// Who is shown it.
    pub shown: Shown,
    /// What its values are.
    pub kind: Kind,
    pub(super) get: fn(&Row) -> Value,
    pub(super) set: fn(&mut Row, Value),
}

/// Who is shown a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// Tables, and the live page.
    Live,
    /// Tables.
    InTables,
    /// Tables of recordings in which not every tick has one contact.
    OfSeveralContacts,
}

/// What the values of a column are.
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
    /// A number, in the column's unit; NaN where there is none.
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
    /// The column of this name, with its unit; that of the tick where the contact has one of that name
    /// too.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        let contacts = Tick::COLUMNS.iter().chain(ContactTick::COLUMNS);
        let mut all = contacts.chain(BodyTick::COLUMNS);
        all.find(|column| column.name == name)
    }

    /// Its value in a row.
    #[must_use]
    pub fn value(&self, row: &Row) -> Value {
        (self.get)(row)
    }

    /// Whether the live page is sent it.
    #[must_use]
    pub const fn is_live(&self) -> bool {
        matches!(self.shown, Shown::Live)
    }

    /// Its name without the unit: `penetration` for `penetration_m`.
    #[must_use]
    pub fn short_name(&self) -> &'static str {
        self.name
            .strip_suffix(suffix(self.unit))
            .unwrap_or(self.name)
    }
}

/// What the name of a column with this unit ends with.
fn suffix(unit: &str) -> &'static str {
    match unit {
        "s" => "_s",
        "m" => "_m",
        "m/s" => "_m_per_s",
        "N" => "_n",
        "N m" => "_n_m",
        "J" => "_j",
        "rad/s" => "_rad_per_s",
        _ => "",
    }
}

impl Kind {
    /// What the type of a message calls it, in ROS 2.
    #[must_use]
    pub fn message_type(self) -> &'static str {
        match self {
            Self::Number => "float64",
            Self::Count => "uint64",
            Self::ShortCount | Self::Flags => "uint32",
            Self::Phase => "uint8",
        }
    }

    /// How many bytes of a message a value takes, after as many as bring it to a multiple of that.
    #[must_use]
    pub fn size(self) -> usize {
        match self {
            Self::Number | Self::Count => 8,
            Self::ShortCount | Self::Flags => 4,
            Self::Phase => 1,
        }
    }

    /// The next value of a message; none if it ends before, or has none of this kind there.
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
    /// As a table of text has what is no number: counts in digits, flags and phases by their names.
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

    /// As a number: flags by their bits, a phase by its number in a recording.
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

/// A field of a row: the values of one column, or of several by their place.
pub(super) trait Cells {
    const KIND: Kind;
    /// What stands for no value.
    const UNKNOWN: Self;

    fn get(&self, place: usize) -> Value;

    /// Takes a value of its kind; another changes nothing.
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
            let units = ["1", "s", "m", "m/s", "N", "N m", "J", "rad/s"];
            assert!(units.contains(&unit), "{name}");
            assert!(name.ends_with(suffix(unit)), "{name} in {unit}");
            assert_eq!(format!("{}{}", column.short_name(), suffix(unit)), name);
            // A number has a unit, but in a quaternion or a unit vector, and nothing else has one.
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

    /// Two columns that give or take the same quantity would show: each is set in a row in which no
    /// other has a value, and is found there, alone.
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
