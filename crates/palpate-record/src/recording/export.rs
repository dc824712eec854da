//! What the tables of a recording have in common: columns, and a receipt.

use super::{COLUMNS, Recording, VERSION};

/// The names of the columns of the ticks.
pub(super) fn names() -> Vec<&'static str> {
    COLUMNS.iter().map(|column| column.name).collect()
}

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
