//! Columns and metadata common to the tables of a recording.

use super::table::table;
use super::{Column, Recording, VERSION};

/// Returns the columns of the rows.
pub(super) fn columns(recording: &Recording) -> Vec<&'static Column> {
    table(recording.has_one_contact_each && !recording.has_bodies)
}

/// Returns the names of columns.
pub(super) fn names(columns: &[&'static Column]) -> Vec<&'static str> {
    columns.iter().map(|column| column.name).collect()
}

/// Returns the facts about the ticks and the missing data, then the metadata texts under `metadata NAME`.
pub(super) fn metadata(recording: &Recording) -> Vec<(String, String)> {
    let facts = [
        ("recording", recording.path().display().to_string()),
        ("recording_format", VERSION.to_string()),
        (
            "palpate_version",
            recording.metadata.palpate_version.clone(),
        ),
        ("complete", recording.is_complete().to_string()),
        ("finished", recording.finished.to_string()),
        ("ticks_lost", recording.lost().to_string()),
        ("events_lost", recording.lost_events().to_string()),
        ("damaged_parts", recording.damage.len().to_string()),
    ];
    let texts = recording.metadata.texts.iter();
    facts
        .map(|(key, value)| (key.to_owned(), value))
        .into_iter()
        .chain(texts.map(|(name, text)| (format!("metadata {name}"), text.clone())))
        .collect()
}
