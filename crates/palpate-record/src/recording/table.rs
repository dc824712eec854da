//! Columns of tables and their order.

use std::sync::LazyLock;

use super::{Column, ContactTick, Shown, Tick};

/// First columns of every table, in order: those of a tick and of its contact that a reader looks for first.
const FIRST: [&str; 25] = [
    "sequence",
    "t_s",
    "lateness_s",
    "period_s",
    "device_axis_1_m",
    "device_axis_2_m",
    "device_axis_3_m",
    "device_position_m",
    "object_position_m",
    "object_velocity_m_per_s",
    "penetration_m",
    "proxy_shift_m",
    "force_on_object_n",
    "force_on_device_n",
    "stored_energy_j",
    "port_work_j",
    "virtual_force_work_j",
    "outside_work_j",
    "leak_original_j",
    "leak_held_j",
    "tick_duration_s",
    "device_round_trip_s",
    "generation",
    "flags",
    "phase",
];

/// Returns all columns of a [`Row`](super::Row), in the order of tables and the live page: the main columns from
/// `sequence` to `phase`, then the other columns of the tick and of the contact.
#[must_use]
pub fn columns() -> &'static [&'static Column] {
    static COLUMNS: LazyLock<Vec<&'static Column>> = LazyLock::new(|| {
        let first = FIRST.iter().filter_map(|name| Column::named(name));
        let is_later = |column: &&Column| !FIRST.contains(&column.name);
        let later = Tick::COLUMNS.iter().chain(ContactTick::COLUMNS);
        first.chain(later.filter(is_later)).collect()
    });
    &COLUMNS
}

/// Returns the columns of a row that a table of a recording contains.
pub(super) fn table(has_one_contact_each: bool) -> Vec<&'static Column> {
    let is_there = |column: &&&'static Column| match column.shown {
        _ if FIRST.contains(&column.name) => true,
        Shown::Live | Shown::InTables => true,
        Shown::OfSeveralContacts => !has_one_contact_each,
    };
    columns().iter().filter(is_there).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_of_one_contact_lacks_some_columns_and_one_of_several_contacts_has_all() {
        let names = |columns: Vec<&Column>| {
            let names = columns.iter().map(|column| column.name);
            names.collect::<Vec<_>>()
        };
        let one = names(table(true));
        assert_eq!(one[..25], FIRST);
        assert!(one.contains(&"delivered_torque_3_n_m") && !one.contains(&"contact"));
        let several = names(table(false));
        for name in ["contacts", "contact", "contact_flags"] {
            assert!(several.contains(&name), "{name}");
        }
        // Every column occurs once in the list, except the number of the tick, which both parts have.
        assert_eq!(
            several.len() + 1,
            Tick::COLUMNS.len() + ContactTick::COLUMNS.len()
        );
    }
}
