//! What the loop itself counted, at the end of its recording.

use mcap::records::Metadata;

use super::receipt::{CHECKSUM, checksum};

/// Name of the metadata record that holds the count.
pub(super) const RECORD: &str = "palpate end";
const TICKS: &str = "ticks_made";
const EVENTS: &str = "events_made";
const MOTORS_OFF: &str = "motors_off_ticks";
const ENDING: &str = "ending";

/// What a loop counted while it was recorded. It comes to the recording by another way than the ticks,
/// so a recording that has lost ticks or events, the last ones too, has the number of them all the
/// same.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LoopCount {
    /// Ticks that the loop made, from the recording's first on.
    pub ticks: u64,
    /// Events that the loop told.
    pub events: u64,
    /// Ticks at whose end a trip of the safety kept the motors off.
    pub motors_off: u64,
    /// Why the loop ended, in words; `None` if the recording ended before its loop.
    pub ending: Option<String>,
}

impl LoopCount {
    /// The metadata record.
    pub(super) fn to_metadata(&self) -> Metadata {
        let mut entries: std::collections::BTreeMap<String, String> = [
            (TICKS, self.ticks),
            (EVENTS, self.events),
            (MOTORS_OFF, self.motors_off),
        ]
        .map(|(name, count)| (name.to_owned(), count.to_string()))
        .into();
        if let Some(ending) = &self.ending {
            entries.insert(ENDING.into(), ending.clone());
        }
        let checksum = checksum(&entries);
        entries.insert(CHECKSUM.into(), checksum);
        Metadata {
            name: RECORD.into(),
            metadata: entries,
        }
    }

    /// Reads the metadata record; `None` if it is not what was written.
    pub(super) fn from_metadata(record: Metadata) -> Option<Self> {
        let mut entries = record.metadata;
        let claimed = entries.remove(CHECKSUM);
        if claimed != Some(checksum(&entries)) {
            return None;
        }
        let count = |name| entries.get(name)?.parse().ok();
        Some(Self {
            ticks: count(TICKS)?,
            events: count(EVENTS)?,
            motors_off: count(MOTORS_OFF)?,
            ending: entries.get(ENDING).cloned(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count() -> LoopCount {
        LoopCount {
            ticks: 86_416,
            events: 3,
            motors_off: 12,
            ending: Some("it was asked to stop".into()),
        }
    }

    #[test]
    fn what_is_written_is_read() {
        for count in [count(), LoopCount::default()] {
            assert_eq!(LoopCount::from_metadata(count.to_metadata()), Some(count));
        }
    }

    #[test]
    fn a_changed_count_is_noticed() {
        let mut record = count().to_metadata();
        record.metadata.insert(TICKS.into(), "86417".into());
        assert_eq!(LoopCount::from_metadata(record), None);
        let mut record = count().to_metadata();
        record.metadata.remove(CHECKSUM);
        assert_eq!(LoopCount::from_metadata(record), None);
    }

    #[test]
    fn what_a_later_version_adds_is_passed_over() {
        let mut record = count().to_metadata();
        record.metadata.remove(CHECKSUM);
        record.metadata.insert("more".into(), "1".into());
        let sum = checksum(&record.metadata);
        record.metadata.insert(CHECKSUM.into(), sum);
        assert_eq!(LoopCount::from_metadata(record), Some(count()));
    }
}
