//! Rows of a recording, and the macro that defines them together with their columns.

use super::{BodyTick, ContactTick, DeviceTick, Tick};

/// A line of a table: a tick and one of its contacts.
///
/// A loop with one contact has one row per tick. Columns that the [`Tick`] and the [`ContactTick`] have in common,
/// such as the number of the tick, are those of the tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Row {
    /// The tick.
    pub tick: Tick,
    /// The contact.
    pub contact: ContactTick,
    /// A body, in the table of bodies; unknown in the table of ticks and contacts.
    pub body: BodyTick,
    /// A device, in the table of devices; unknown in the table of ticks and contacts.
    pub device: DeviceTick,
}

impl Row {
    /// A row without known values: NaN for each number, zero counts, no flags.
    pub const UNKNOWN: Self = Self {
        tick: Tick::UNKNOWN,
        contact: ContactTick::UNKNOWN,
        body: BodyTick::UNKNOWN,
        device: DeviceTick::UNKNOWN,
    };

    /// Returns the rows of a tick: one for each contact, or one with an unknown contact if there is none.
    pub fn new(tick: Tick, contacts: &[ContactTick]) -> impl Iterator<Item = Self> {
        let none = contacts.is_empty().then_some(ContactTick::UNKNOWN);
        let contacts = contacts.iter().copied().chain(none);
        contacts.map(move |contact| Self {
            tick,
            contact,
            ..Self::UNKNOWN
        })
    }
}

/// Defines a part of a row and the list of its columns.
///
/// A line contains a field and its type, the unit, the outputs with the column (`live`: tables and the live page,
/// `table`: tables, `several`: tables of several contacts), the meaning with its sign, and the name of the column. A
/// field of several columns gives each its index.
macro_rules! part_of_row {
    (
        $(#[$about:meta])*
        $part:ident as $place_in_row:ident;
        $(
            $field:ident: $type:ty, $unit:literal, $shown:ident, $meaning:literal,
            $( $name:literal $(@ $place:literal)? ),+;
        )+
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct $part {$(
            #[doc = concat!($("`", $name, "`: ",)+ $meaning, " `[", $unit, "]`.")]
            pub $field: $type,
        )+}

        impl $part {
            /// A part without known values: NaN for each number, zero counts, no flags.
            pub const UNKNOWN: Self = Self {
                $($field: <$type as $crate::recording::column::Cells>::UNKNOWN,)+
            };

            /// Columns in the order of the messages.
            pub const COLUMNS: &[$crate::recording::Column] = &[$($(
                $crate::recording::Column {
                    name: $name,
                    unit: $unit,
                    meaning: $meaning,
                    shown: part_of_row!(@shown $shown),
                    kind: <$type as $crate::recording::column::Cells>::KIND,
                    get: |row| {
                        let cells = &row.$place_in_row.$field;
                        $crate::recording::column::Cells::get(cells, part_of_row!(@place $($place)?))
                    },
                    set: |row, value| {
                        let cells = &mut row.$place_in_row.$field;
                        $crate::recording::column::Cells::set(
                            cells,
                            part_of_row!(@place $($place)?),
                            value,
                        );
                    },
                },
            )+)+];
        }
    };
    (@shown live) => { $crate::recording::Shown::Live };
    (@shown table) => { $crate::recording::Shown::InTables };
    (@shown several) => { $crate::recording::Shown::OfSeveralContacts };
    (@place) => { 0 };
    (@place $place:literal) => { $place };
}

pub(super) use part_of_row;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tick_has_a_row_for_each_contact_and_one_without() {
        let tick = Tick {
            sequence: 4,
            ..Tick::default()
        };
        let contact = |number| ContactTick {
            contact: number,
            ..ContactTick::default()
        };
        let rows: Vec<Row> = Row::new(tick, &[contact(0), contact(1)]).collect();
        let numbers = rows
            .iter()
            .map(|row| (row.tick.sequence, row.contact.contact));
        assert!(numbers.eq([(4, 0), (4, 1)]));
        let rows: Vec<Row> = Row::new(tick, &[]).collect();
        assert_eq!(rows.len(), 1);
        assert!(rows[0].tick.sequence == 4 && rows[0].contact.penetration.is_nan());
    }
}
