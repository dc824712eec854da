//! Reading a recording: whatever there is of it.

use std::fs::File;
use std::io::{self, BufReader, Read, Take};
use std::path::{Path, PathBuf};
use std::vec;

use thiserror::Error;

use super::walk::{Refused, Step, Walk};
use super::{Event, Gap, Receipt, Tick};

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

/// Something that was recorded.
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    /// A tick of the loop.
    Tick(Tick),
    /// Something that happened at one.
    Event(Event),
}

/// A recording, as far as it is there. It has been read once from start to end, so what is missing
/// is known before anything is made of the rest.
#[derive(Debug)]
pub struct Recording {
    /// What made it.
    pub receipt: Receipt,
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
    /// Whether it was finished, and its end is there.
    pub complete: bool,
    /// How it ends if it is not complete, in words.
    pub tail: Option<String>,
    /// What within it is not what was written, in words; none of that is believed.
    pub damage: Vec<String>,
    /// Ticks that are not there, told from the numbers of those that are.
    pub missing: Vec<Gap>,
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
        let (mut walk, receipt) = Walk::begin(BufReader::new(source)).map_err(named)?;
        let mut recording = Self {
            receipt,
            ticks: 0,
            events: 0,
            first: None,
            last: None,
            generation: 0,
            complete: false,
            tail: None,
            damage: Vec::new(),
            missing: Vec::new(),
            path: path.to_owned(),
            length: 0,
        };
        loop {
            match walk.next().map_err(|error| named(error.into()))? {
                Step::Chunk(entries) => entries.iter().for_each(|entry| recording.count(entry)),
                Step::Damaged(words) => recording.damage.push(words),
                Step::Complete => {
                    recording.complete = true;
                    break;
                }
                Step::Tail(words) => {
                    recording.tail = Some(words);
                    break;
                }
            }
        }
        recording.length = walk.passed();
        recording.missing = walk.loss().gaps();
        Ok(recording)
    }

    /// Number of ticks that were and are not there, as far as can be known: a tick that was lost
    /// after the last one leaves no trace, unless an event names it.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.missing
            .iter()
            .fold(0, |sum, gap| sum.saturating_add(gap.count))
    }

    /// Whether it was finished and everything in it is there and as it was written.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.complete && self.damage.is_empty() && self.missing.is_empty()
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
        let (walk, _) = Walk::begin(source).map_err(named)?;
        Ok(Entries {
            path: self.path.clone(),
            walk: Some(walk),
            chunk: Vec::new().into_iter(),
        })
    }

    fn count(&mut self, entry: &Entry) {
        match entry {
            Entry::Event(_) => self.events += 1,
            Entry::Tick(tick) => {
                self.ticks += 1;
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
            match self.walk.as_mut()?.next() {
                Ok(Step::Chunk(entries)) => self.chunk = entries.into_iter(),
                Ok(Step::Damaged(_)) => {}
                Ok(Step::Complete | Step::Tail(_)) => self.walk = None,
                Err(error) => {
                    self.walk = None;
                    return Some(Err(in_file(&self.path, error.into())));
                }
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
