//! Counters of the loop, at the end of its recording.

use std::time::Duration;

use mcap::records::Metadata;

use super::metadata::{CHECKSUM, checksum};

/// Name of the metadata record with the counters.
pub(super) const RECORD: &str = "palpate end";
const TICKS: &str = "ticks_made";
const EVENTS: &str = "events_made";
const MOTORS_OFF: &str = "motors_off_ticks";
const MOTORS_OFF_FOR: &str = "motors_off_s";
const LASTED: &str = "lasted_s";
const ENDING: &str = "ending";

/// Duration of a loop, and the part of it without a delivered force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LoopTime {
    /// Time from the first tick to the last command.
    pub lasted: Duration,
    /// Time for which a safety stop kept the motors off, or a supervisor or a watchdog process had removed the force
    /// of a stalled loop.
    pub motors_off: Duration,
}

/// Counters of a recorded loop. They do not pass through the ring buffer of the ticks, so they are exact also in a
/// recording that lacks ticks or events, including the last ones.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LoopCount {
    /// Ticks of the loop, from the recording's first on.
    pub ticks: u64,
    /// Events of the loop.
    pub events: u64,
    /// Ticks at whose end a safety stop kept the motors off.
    pub motors_off: u64,
    /// Duration of the loop, and the part of it without a delivered force; `None` if unknown, as in recordings of
    /// older versions and in recordings that start after their loop.
    pub time: Option<LoopTime>,
    /// Reason for the end of the loop, as text; `None` if the recording ended before its loop.
    pub ending: Option<String>,
}

impl LoopCount {
    /// Returns the metadata record.
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

    /// Reads the metadata record; `None` if it is invalid.
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

/// Returns the duration in seconds, to the nanosecond.
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

    /// The format of earlier versions.
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
