//! Metadata of a recording.

use std::collections::BTreeMap;

use crate::files::checksum::Checksum;
use mcap::records::Metadata;

use super::VERSION;

/// Name of the metadata record.
pub(super) const RECORD: &str = "palpate";
const FORMAT: &str = "recording_format";
const PROGRAM: &str = "palpate_version";
pub(super) const CHECKSUM: &str = "checksum";
/// Prefix of the entry of a file that the scene names; the name in the scene follows.
const FILE: &str = "file ";
/// Largest size of the metadata [bytes].
const LONGEST: usize = 16 << 20;

/// Metadata of a recording: the whole configuration as named texts.
///
/// The entry `scene` is the scene file of the run. A file that it names is the entry `file NAME`, with the name from
/// the scene. Other names are free: `device`, `safety`, `started`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordingMetadata {
    /// Version of palpate that wrote the recording.
    pub palpate_version: String,
    /// Configuration, by name.
    pub texts: BTreeMap<String, String>,
}

impl RecordingMetadata {
    /// Creates metadata without texts.
    #[must_use]
    pub fn new(palpate_version: &str) -> Self {
        Self {
            palpate_version: palpate_version.to_owned(),
            texts: BTreeMap::new(),
        }
    }

    /// Adds a text.
    #[must_use]
    pub fn with(mut self, name: &str, text: &str) -> Self {
        self.texts.insert(name.to_owned(), text.to_owned());
        self
    }

    /// Adds the text of a file that the scene calls `name`.
    #[must_use]
    pub fn with_file(self, name: &str, text: &str) -> Self {
        self.with(&format!("{FILE}{name}"), text)
    }

    /// Returns the text of a file that the scene calls `name`.
    #[must_use]
    pub fn file(&self, name: &str) -> Option<&str> {
        self.texts.get(&format!("{FILE}{name}")).map(String::as_str)
    }

    /// Returns the metadata record, or the reason why an entry is invalid.
    pub(super) fn to_metadata(&self) -> Result<Metadata, String> {
        for name in self.texts.keys() {
            if name.is_empty() || [FORMAT, PROGRAM, CHECKSUM].contains(&name.as_str()) {
                return Err(format!(
                    "the metadata cannot have an entry `{name}`; names must not be empty, {FORMAT}, \
                     {PROGRAM} or {CHECKSUM}"
                ));
            }
        }
        let mut entries = self.texts.clone();
        entries.insert(FORMAT.into(), VERSION.to_string());
        entries.insert(PROGRAM.into(), self.palpate_version.clone());
        let length: usize = entries
            .iter()
            .map(|(key, text)| key.len() + text.len())
            .sum();
        if length > LONGEST {
            return Err(format!(
                "the metadata has {length} bytes of text; at most {LONGEST} fit"
            ));
        }
        let checksum = checksum(&entries);
        entries.insert(CHECKSUM.into(), checksum);
        Ok(Metadata {
            name: RECORD.into(),
            metadata: entries,
        })
    }

    /// Reads the metadata record. Returns a description of the error if it is not one of a recording of this format.
    pub(super) fn from_metadata(record: Metadata) -> Result<Self, String> {
        let mut entries = record.metadata;
        let format = entries.get(FORMAT).filter(|_| record.name == RECORD);
        let Some(format) = format else {
            return Err("an MCAP file, but not a recording of palpate".into());
        };
        if *format != VERSION.to_string() {
            return Err(format!(
                "a recording of format {format}; this version of palpate reads format {VERSION}"
            ));
        }
        let claimed = entries.remove(CHECKSUM);
        if claimed != Some(checksum(&entries)) {
            return Err("the metadata at its start is damaged: its checksum does not match".into());
        }
        entries.remove(FORMAT);
        Ok(Self {
            palpate_version: entries.remove(PROGRAM).unwrap_or_default(),
            texts: entries,
        })
    }
}

/// Returns the checksum of all names and texts, each followed by its length, so that no character can move between
/// them unnoticed.
pub(super) fn checksum(entries: &BTreeMap<String, String>) -> String {
    let mut checksum = Checksum::new();
    for text in entries.iter().flat_map(|(key, text)| [key, text]) {
        checksum.add(text.as_bytes());
        checksum.add(&(text.len() as u64).to_le_bytes());
    }
    checksum.text()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let metadata = RecordingMetadata::new("0.1.0")
            .with("scene", "format = 2\n")
            .with_file("hand.csv", "t_s,position_m\n");
        let record = metadata.to_metadata().unwrap();
        assert_eq!(record.metadata["recording_format"], "2");
        assert_eq!(record.metadata["palpate_version"], "0.1.0");
        let read = RecordingMetadata::from_metadata(record).unwrap();
        assert_eq!(read, metadata);
        assert_eq!(read.file("hand.csv"), Some("t_s,position_m\n"));
        assert_eq!(read.file("scene"), None);
    }

    #[test]
    fn a_changed_text_or_name_is_noticed() {
        let record = RecordingMetadata::new("0.1.0")
            .with("ab", "c")
            .to_metadata()
            .unwrap();
        let damaged = |change: &dyn Fn(&mut BTreeMap<String, String>)| {
            let mut record = record.clone();
            change(&mut record.metadata);
            RecordingMetadata::from_metadata(record).unwrap_err()
        };
        let message = "the metadata at its start is damaged: its checksum does not match";
        assert_eq!(
            damaged(&|texts| texts.get_mut("ab").unwrap().push('d')),
            message
        );
        assert_eq!(damaged(&|texts| drop(texts.remove("ab"))), message);
        assert_eq!(damaged(&|texts| drop(texts.remove(CHECKSUM))), message);
        let moved = damaged(&|texts| {
            texts.remove("ab");
            texts.insert("a".into(), "bc".into());
        });
        assert_eq!(moved, message);
    }

    #[test]
    fn another_format_is_refused_by_its_number() {
        for format in ["1", "3"] {
            let mut record = RecordingMetadata::new("9.0.0").to_metadata().unwrap();
            record.metadata.insert(FORMAT.into(), format.into());
            assert_eq!(
                RecordingMetadata::from_metadata(record).unwrap_err(),
                format!("a recording of format {format}; this version of palpate reads format 2")
            );
        }
    }

    #[test]
    fn the_names_of_the_format_are_its_own() {
        for name in ["", FORMAT, PROGRAM, CHECKSUM] {
            let error = RecordingMetadata::new("0")
                .with(name, "x")
                .to_metadata()
                .unwrap_err();
            assert!(error.contains(&format!("`{name}`")), "{error}");
        }
        let long = "x".repeat(LONGEST);
        let error = RecordingMetadata::new("0")
            .with("scene", &long)
            .to_metadata()
            .unwrap_err();
        assert!(error.contains("at most 16777216 fit"), "{error}");
    }
}
