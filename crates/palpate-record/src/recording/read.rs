//! Reading a recording: whatever there is of it.

use std::fs::File;
use std::io::{self, BufReader, Read, Take};
use std::path::{Path, PathBuf};
use std::vec;

use thiserror::Error;

use super::walk::{Refused, Step, Walk};
use super::{BodyTick, ContactTick, DeviceTick, Event, Gap, LoopCount, Receipt, Row, Tick};

/// Why a recording could not be read.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// The bytes could not be had.
    #[error("{file}: cannot be read: {source}")]
    Unreadable {
        /// The path the caller gave.
        file: String,
        /// What the system said.
        source: io::Error,
    },
    /// The file is no recording, or none that this version reads.
    #[error("{file}: {fault}")]
    Invalid {
        /// The path the caller gave.
        file: String,
        /// What is wrong.
        fault: String,
    },
}

/// Kind of the event that says that the loop has ended, at its last tick.
const ENDED: &str = "ended";

/// Something that was recorded.
// A tick is most of what comes.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    /// A tick of the loop, with all its contacts in their order, the bodies of a world that move, and the devices of a
    /// loop that has several: none where it has one.
    Tick(Tick, Vec<ContactTick>, Vec<BodyTick>, Vec<DeviceTick>),
    /// Something that happened at one.
    Event(Event),
}

/// A recording, as far as it is there. It has been read once from start to end, so what is missing
/// is known before anything is made of the rest.
#[derive(Debug)]
pub struct Recording {
    /// What made it.
    pub receipt: Receipt,
    /// Version of its format.
    pub format: u32,
    /// Number of ticks that are there.
    pub ticks: u64,
    /// Number of events.
    pub events: u64,
    /// The first tick.
    pub first: Option<Tick>,
    /// The last tick.
    pub last: Option<Tick>,
    /// Highest generation of parameters of any tick.
    pub generation: u32,
    /// Whether each of the ticks has one contact, as a loop that touches one thing writes it.
    pub has_one_contact_each: bool,
    /// Whether ticks have bodies, as a loop that renders a world writes them.
    pub has_bodies: bool,
    /// How many devices the loop has.
    pub devices: usize,
    /// Whether it was finished, and its end is there.
    pub finished: bool,
    /// How it ends if it is not finished, in words.
    pub tail: Option<String>,
    /// What within it is not what was written, in words; none of that is believed.
    pub damage: Vec<String>,
    /// Ticks that are not there, told from the numbers of those that are, and from what the loop
    /// counted.
    pub missing: Vec<Gap>,
    /// What the loop itself counted; `None` where it was cut off, or recorded by
    /// an older version.
    pub counted: Option<LoopCount>,
    /// Ticks and events of a last chunk that is cut off: they are read, and no checksum covers them.
    pub unchecked: u64,
    /// Size of the file `[bytes]`.
    pub bytes: u64,
    /// The tick that the event of the loop's end names.
    ended: Option<u64>,
    path: PathBuf,
    /// Bytes in which entries are looked for.
    length: u64,
}

impl Recording {
    /// Reads the recording at `path`, finished or not: one that was cut off, and one that is being
    /// written, as far as it has been flushed.
    ///
    /// # Errors
    /// The file cannot be read; it is not a recording, its receipt is torn or damaged, or it is of
    /// another format.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let named = |error| in_file(path, error);
        let source = File::open(path).map_err(|error| named(error.into()))?;
        palpate_files::inputs::note(path);
        let bytes = source.metadata().map_err(|error| named(error.into()))?;
        let mut walk = Walk::begin(BufReader::new(source)).map_err(named)?;
        let mut recording = Self {
            receipt: Receipt::new(""),
            format: 0,
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
                        "cut off within its last chunk, of which {} ticks and events are read that \
                         no checksum covers",
                        entries.len()
                    ));
                    torn = size;
                    break;
                }
            }
        }
        (recording.format, recording.receipt) = walk.receipt().map_err(named)?;
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

    /// Number of ticks that the loop made; `None` where the recording does not say.
    #[must_use]
    pub fn ticks_made(&self) -> Option<u64> {
        let counted = self.counted.as_ref().map(|count| count.ticks);
        counted.or(self.ended.map(|last| last.saturating_add(1)))
    }

    /// Number of ticks that were and are not there. Where [`ticks_made`](Self::ticks_made) is `None`,
    /// those that were lost after the last one are not among them.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.missing
            .iter()
            .fold(0, |sum, gap| sum.saturating_add(gap.count))
    }

    /// Number of events that were and are not there, as far as the recording says.
    #[must_use]
    pub fn lost_events(&self) -> u64 {
        let made = self.counted.as_ref().map_or(0, |count| count.events);
        made.saturating_sub(self.events)
    }

    /// Whether it was finished, everything in it is as it was written, and nothing is known to be
    /// missing. Where [`ticks_made`](Self::ticks_made) is `None`, ticks may be missing at its end all
    /// the same.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.finished
            && self.damage.is_empty()
            && self.missing.is_empty()
            && self.lost_events() == 0
    }

    /// Whether it is whole and holds as many ticks as the loop itself counted.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.is_whole() && self.ticks_made() == Some(self.ticks)
    }

    /// The loop cannot have made less than there is.
    fn check_count(&mut self) {
        let Some(counted) = &self.counted else {
            return;
        };
        let held = self.last.map_or(0, |last| last.sequence.saturating_add(1));
        if held > counted.ticks || self.events > counted.events {
            self.damage.push(format!(
                "the count of the loop: {} ticks and {} events, but there are ticks up to number {} \
                 and {} events",
                counted.ticks,
                counted.events,
                held.saturating_sub(1),
                self.events
            ));
        }
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Ticks and events, in the order in which they were written.
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

    /// The rows of all ticks, in the order in which they were written: one for each contact, and a
    /// single one whose contact is unknown where a tick has none.
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

/// What is in a recording, one after the other; chunk by chunk, so that one of any length can be
/// read.
pub struct Entries {
    path: PathBuf,
    /// Until the end, or an error.
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
            // An end of the walk is an end once what it gave has been handed on.
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

/// The rows of a recording, one after the other.
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
                    self.of_tick = Row::of(tick, &contacts).collect::<Vec<_>>().into_iter();
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
