//! What the tables of a recording have in common: columns, and a receipt.

use super::{Recording, VERSION};

/// The columns of the ticks, in order. Numbers stand in the middle.
pub(super) const COLUMNS: [&str; 25] = [
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
    "placement_shift_m",
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

/// What made the ticks and what is not there of them, then the texts of the receipt under `receipt
/// NAME`.
pub(super) fn receipt(recording: &Recording) -> Vec<(String, String)> {
    let facts = [
        ("recording", recording.path().display().to_string()),
        ("recording_format", VERSION.to_string()),
        ("palpate_version", recording.receipt.palpate_version.clone()),
        ("complete", recording.is_complete().to_string()),
        ("finished", recording.finished.to_string()),
        ("ticks_lost", recording.lost().to_string()),
        ("events_lost", recording.lost_events().to_string()),
        ("damaged_parts", recording.damage.len().to_string()),
    ];
    let texts = recording.receipt.texts.iter();
    facts
        .map(|(key, value)| (key.to_owned(), value))
        .into_iter()
        .chain(texts.map(|(name, text)| (format!("receipt {name}"), text.clone())))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::tick::NUMBERS;
    use super::*;

    #[test]
    fn the_columns_are_the_fields_of_the_message() {
        let mut fields = vec!["sequence"];
        fields.extend(NUMBERS);
        fields.extend(["generation", "flags", "phase"]);
        assert_eq!(COLUMNS[..], fields);
    }
}
