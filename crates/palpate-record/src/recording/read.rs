//! Reader of complete and incomplete recordings.

use std::fs::File;
use std::io::{self, BufReader, Read, Take};
use std::path::{Path, PathBuf};
use std::vec;

use thiserror::Error;

use super::walk::{Refused, Step, Walk};
use super::{
    BodyTick, ContactTick, DeviceTick, Event, Gap, LoopCount, RecordingMetadata, Row, Tick,
};

/// Reason why a recording could not be read.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// The bytes cannot be read.
    #[error("{file}: cannot be read: {source}")]
    Unreadable {
        /// Path given by the caller.
        file: String,
        /// Error of the system.
        source: io::Error,
    },
    /// The file is not a recording, or not in a format that this version reads.
    #[error("{file}: {fault}")]
    Invalid {
        /// Path given by the caller.
        file: String,
        /// Description of the error.
        fault: String,
    },
}

/// Kind of the event at the end of a loop, at its last tick.
const ENDED: &str = "ended";

/// An item of a recording.
// Most entries are ticks, so the size difference of the variants wastes little memory.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    /// A tick of the loop, with all its contacts in their order, the moving bodies of a world, and the devices of a
    /// loop with several devices (empty for a single device).
    Tick(Tick, Vec<ContactTick>, Vec<BodyTick>, Vec<DeviceTick>),
    /// An event.
    Event(Event),
}

/// An opened recording, complete or not. Opening reads it once from start to end, so missing data are known before
/// the rest is used.
#[derive(Debug)]
pub struct Recording {
    /// Metadata of the recording.
    pub metadata: RecordingMetadata,
    /// Number of recorded ticks.
    pub ticks: u64,
    /// Number of events.
    pub events: u64,
    /// The first tick.
    pub first: Option<Tick>,
    /// The last tick.
    pub last: Option<Tick>,
    /// Highest generation of parameters of any tick.
    pub generation: u32,
    /// Whether each tick has exactly one contact, as in a loop with a single contact.
    pub has_one_contact_each: bool,
    /// Whether ticks have bodies, as in a loop that renders a world.
    pub has_bodies: bool,
    /// Number of devices of the loop.
    pub devices: usize,
    /// Whether the recording was finished and its end is present.
    pub finished: bool,
    /// Description of the end of an unfinished recording.
    pub tail: Option<String>,
    /// Descriptions of damaged parts, which are ignored.
    pub damage: Vec<String>,
    /// Missing ticks, derived from the numbers of the recorded ones and from the counters of the loop.
    pub missing: Vec<Gap>,
    /// Counters of the loop; `None` if the recording is truncated or of an older version.
    pub counted: Option<LoopCount>,
    /// Ticks and events of a truncated last chunk: they are read, and no checksum covers them.
    pub unchecked: u64,
    /// Size of the file `[bytes]`.
    pub bytes: u64,
    /// Tick of the event at the loop's end.
    ended: Option<u64>,
    path: PathBuf,
    /// Bytes of the file that contain entries.
    length: u64,
}

impl Recording {
    /// Opens the recording at `path`, finished or not: also a truncated one, and one that is being written, as far as
    /// it has been flushed.
    ///
    /// # Errors
    /// The file cannot be read; it is not a recording; its metadata are incomplete or damaged; it is in another
    /// format.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let named = |error| in_file(path, error);
        let source = File::open(path).map_err(|error| named(error.into()))?;
        crate::files::inputs::note(path);
        let bytes = source.metadata().map_err(|error| named(error.into()))?;
        let mut walk = Walk::begin(BufReader::new(source)).map_err(named)?;
        let mut recording = Self {
            metadata: RecordingMetadata::new(""),
            ticks: 0,
            events: 0,
            first: None,
            last: None,
            generation: 0,
            has_one_contact_each: true,
            has_bodies: false,
            devices: 1,
            finished: false,
            tail: None,
            damage: Vec::new(),
            missing: Vec::new(),
            counted: None,
            unchecked: 0,
            bytes: bytes.len(),
            ended: None,
            path: path.to_owned(),
            length: 0,
        };
        let mut torn = 0;
        loop {
            match walk.next().map_err(named)? {
                Step::Chunk(entries) => entries.iter().for_each(|entry| recording.count(entry)),
                Step::Damaged(words) => recording.damage.push(words),
                Step::Complete => {
                    recording.finished = true;
                    break;
                }
                Step::Tail(words) => {
                    recording.tail = Some(words);
                    break;
                }
                Step::TornChunk { entries, size } => {
                    entries.iter().for_each(|entry| recording.count(entry));
                    recording.unchecked = entries.len() as u64;
                    recording.tail = Some(format!(
                        "cut off within its last chunk; {} ticks and events of it are read without a \
                         checksum",
                        entries.len()
                    ));
                    torn = size;
                    break;
                }
            }
        }
        recording.metadata = walk.metadata().map_err(named)?;
        recording.counted = walk.count();
        recording.length = walk.passed() + torn;
        let mut loss = walk.loss();
        if let Some(last) = recording.ticks_made().and_then(|made| made.checked_sub(1)) {
            loss.named(last);
        }
        recording.missing = loss.gaps();
        recording.check_count();
        Ok(recording)
    }

    /// Returns the number of ticks of the loop; `None` if unknown.
    #[must_use]
    pub fn ticks_made(&self) -> Option<u64> {
        let counted = self.counted.as_ref().map(|count| count.ticks);
        counted.or(self.ended.map(|last| last.saturating_add(1)))
    }

    /// Returns the number of missing ticks. If [`ticks_made`](Self::ticks_made) is `None`, it excludes ticks lost
    /// after the last recorded one.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.missing
            .iter()
            .fold(0, |sum, gap| sum.saturating_add(gap.count))
    }

    /// Returns the number of missing events, as far as known.
    #[must_use]
    pub fn lost_events(&self) -> u64 {
        let made = self.counted.as_ref().map_or(0, |count| count.events);
        made.saturating_sub(self.events)
    }

    /// Returns whether the recording is finished and undamaged, without known missing data. If
    /// [`ticks_made`](Self::ticks_made) is `None`, ticks may still be missing at its end.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.finished
            && self.damage.is_empty()
            && self.missing.is_empty()
            && self.lost_events() == 0
    }

    /// Returns whether the recording is whole and contains as many ticks as the loop counted.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.is_whole() && self.ticks_made() == Some(self.ticks)
    }

    /// Checks that the loop did not count fewer ticks than are recorded.
    fn check_count(&mut self) {
        let Some(counted) = &self.counted else {
            return;
        };
        let held = self.last.map_or(0, |last| last.sequence.saturating_add(1));
        if held > counted.ticks || self.events > counted.events {
            self.damage.push(format!(
                "the counters of the loop: {} ticks and {} events, but there are ticks up to number {} \
                 and {} events",
                counted.ticks,
                counted.events,
                held.saturating_sub(1),
                self.events
            ));
        }
    }

    /// Returns the path of the file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns an iterator over ticks and events in the order of writing.
    ///
    /// # Errors
    /// The file cannot be opened any more.
    pub fn entries(&self) -> Result<Entries, RecordingError> {
        let named = |error| in_file(&self.path, error);
        let source = File::open(&self.path).map_err(|error| named(error.into()))?;
        let source = BufReader::new(source).take(self.length);
        let walk = Walk::begin(source).map_err(named)?;
        Ok(Entries {
            path: self.path.clone(),
            walk: Some(walk),
            chunk: Vec::new().into_iter(),
        })
    }

    /// Returns an iterator over the rows of all ticks in the order of writing: one for each contact, and one with an
    /// unknown contact if a tick has none.
    ///
    /// # Errors
    /// The file cannot be opened any more.
    pub fn rows(&self) -> Result<Rows, RecordingError> {
        Ok(Rows {
            entries: self.entries()?,
            of_tick: Vec::new().into_iter(),
        })
    }

    fn count(&mut self, entry: &Entry) {
        match entry {
            Entry::Event(event) => {
                self.events += 1;
                if event.kind == ENDED {
                    self.ended = Some(event.sequence);
                }
            }
            Entry::Tick(tick, contacts, bodies, devices) => {
                self.ticks += 1;
                self.has_bodies |= !bodies.is_empty();
                self.devices = self.devices.max(devices.len());
                self.has_one_contact_each &= contacts.len() == 1;
                self.first = self.first.or(Some(*tick));
                self.last = Some(*tick);
                self.generation = self.generation.max(tick.generation);
            }
        }
    }
}

/// Iterator over the entries of a recording. It reads chunk by chunk, so the length of the recording is unlimited.
pub struct Entries {
    path: PathBuf,
    /// `None` after the end or an error.
    walk: Option<Walk<Take<BufReader<File>>>>,
    chunk: vec::IntoIter<Entry>,
}

impl Iterator for Entries {
    type Item = Result<Entry, RecordingError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(entry) = self.chunk.next() {
                return Some(Ok(entry));
            }
            // Return all entries of a step before the end.
            match self.walk.as_mut()?.next() {
                Ok(Step::Chunk(entries)) => self.chunk = entries.into_iter(),
                Ok(Step::TornChunk { entries, .. }) => {
                    self.chunk = entries.into_iter();
                    self.walk = None;
                }
                Ok(Step::Damaged(_)) => {}
                Ok(Step::Complete | Step::Tail(_)) => self.walk = None,
                Err(error) => {
                    self.walk = None;
                    return Some(Err(in_file(&self.path, error)));
                }
            }
        }
    }
}

/// Iterator over the rows of a recording.
pub struct Rows {
    entries: Entries,
    of_tick: vec::IntoIter<Row>,
}

impl Iterator for Rows {
    type Item = Result<Row, RecordingError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(row) = self.of_tick.next() {
                return Some(Ok(row));
            }
            match self.entries.next()? {
                Ok(Entry::Tick(tick, contacts, ..)) => {
                    self.of_tick = Row::new(tick, &contacts).collect::<Vec<_>>().into_iter();
                }
                Ok(Entry::Event(_)) => {}
                Err(error) => return Some(Err(error)),
            }
        }
    }
}

fn in_file(path: &Path, error: Refused) -> RecordingError {
    let file = path.display().to_string();
    match error {
        Refused::Unreadable(source) => RecordingError::Unreadable { file, source },
        Refused::Invalid(fault) => RecordingError::Invalid { file, fault },
    }
}
