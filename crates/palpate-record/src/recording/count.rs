//! What the loop itself counted, at the end of its recording.

use std::time::Duration;

use mcap::records::Metadata;

use super::receipt::{CHECKSUM, checksum};

/// Name of the metadata record that holds the count.
pub(super) const RECORD: &str = "palpate end";
const TICKS: &str = "ticks_made";
const EVENTS: &str = "events_made";
const MOTORS_OFF: &str = "motors_off_ticks";
const MOTORS_OFF_FOR: &str = "motors_off_s";
const LASTED: &str = "lasted_s";
const ENDING: &str = "ending";

/// How long a loop ran, and for how much of that no force was delivered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LoopTime {
    /// From the first tick to the last command.
    pub lasted: Duration,
    /// For so long a trip of the safety kept the motors off, or a supervisor or a guardian had taken
    /// the force off a loop that stood still.
    pub motors_off: Duration,
}

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
    /// How long the loop ran, and for how much of that no force was delivered; `None` where nobody said,
    /// as in recordings of older versions and in those that begin after their loop.
    pub time: Option<LoopTime>,
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
        if let Some(time) = &self.time {
            entries.insert(LASTED.into(), seconds(time.lasted));
            entries.insert(MOTORS_OFF_FOR.into(), seconds(time.motors_off));
        }
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
        let duration = |name| Duration::try_from_secs_f64(entries.get(name)?.parse().ok()?).ok();
        Some(Self {
            ticks: count(TICKS)?,
            events: count(EVENTS)?,
            motors_off: count(MOTORS_OFF)?,
            time: duration(LASTED)
                .zip(duration(MOTORS_OFF_FOR))
                .map(|(lasted, motors_off)| LoopTime { lasted, motors_off }),
            ending: entries.get(ENDING).cloned(),
        })
    }
}

/// In seconds, to the nanosecond.
fn seconds(duration: Duration) -> String {
    format!("{}.{:09}", duration.as_secs(), duration.subsec_nanos())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count() -> LoopCount {
        LoopCount {
            ticks: 86_416,
            events: 3,
            motors_off: 12,
            time: Some(LoopTime {
                lasted: Duration::new(86_400, 7),
                motors_off: Duration::from_nanos(3_000_000_001),
            }),
            ending: Some("it was asked to stop".into()),
        }
    }

    #[test]
    fn what_is_written_is_read() {
        for count in [count(), LoopCount::default()] {
            assert_eq!(LoopCount::from_metadata(count.to_metadata()), Some(count));
        }
    }

    /// As versions before this one wrote it.
    #[test]
    fn a_count_without_times_is_read() {
        let before = LoopCount {
            time: None,
            ..count()
        };
        let record = before.to_metadata();
        assert!(!record.metadata.contains_key(LASTED), "{record:?}");
        assert_eq!(LoopCount::from_metadata(record), Some(before));
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
