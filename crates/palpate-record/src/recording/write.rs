//! Writing a recording into a file, as it happens.

use std::ffi::OsString;
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use palpate_files::atomic::WriteError;
use tempfile::TempPath;

use super::stream::Stream;
use super::{BodyTick, ContactTick, DeviceTick, Event, LoopCount, Receipt, Tick};

/// Flushed ticks reach the disk itself at least this often while they come.
const SYNC_EVERY: Duration = Duration::from_secs(2);

/// Writes a recording. Not for the thread that renders: every call may wait for the disk.
///
/// The file is called `NAME.part` until [`finish`](Self::finish). A writer that is dropped instead
/// leaves it so, with everything that was appended.
pub struct RecordingWriter {
    stream: Stream<BufWriter<File>>,
    /// A second handle, to ask for what the first has written to be on the disk.
    file: File,
    synced: Instant,
    path: PathBuf,
    part: PathBuf,
}

/// What is in a finished recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Summary {
    /// Number of ticks.
    pub ticks: u64,
    /// Number of events.
    pub events: u64,
    /// Size of the file `[bytes]`.
    pub bytes: u64,
}

impl RecordingWriter {
    /// Begins a recording; its receipt is on the disk when this returns.
    ///
    /// A recording cannot be made again, so nothing is overwritten: neither `path` nor what an
    /// earlier recording of that name left when it was cut off.
    ///
    /// # Errors
    /// `path` names no file; there is a file of that name, finished or not; a text of the receipt has a name that the
    /// format needs; what the system says. The error names the path.
    pub fn create(path: &Path, receipt: &Receipt) -> Result<Self, WriteError> {
        let part = part_of(path);
        let begin = || {
            refuse_what_is_there(path)?;
            let file = OpenOptions::new().write(true).create_new(true).open(&part);
            let file = file.map_err(|error| match error.kind() {
                io::ErrorKind::AlreadyExists => exists(format!(
                    "`{}` is what an earlier recording left when it was cut off, or one that is \
                     being made",
                    part.display()
                )),
                _ => error,
            })?;
            let stream = Stream::begin(BufWriter::new(file.try_clone()?), receipt)
                .and_then(|stream| file.sync_data().map(|()| stream));
            match stream {
                Ok(stream) => Ok((stream, file)),
                Err(error) => {
                    // Nothing was recorded in it.
                    let _ = std::fs::remove_file(&part);
                    Err(error)
                }
            }
        };
        let (stream, file) = begin().map_err(|source| WriteError::new(path, source))?;
        Ok(Self {
            stream,
            file,
            synced: Instant::now(),
            path: path.to_owned(),
            part,
        })
    }

    /// Where the recording is while it is not finished.
    #[must_use]
    pub fn part(&self) -> &Path {
        &self.part
    }

    /// Adds a tick and its contacts, as many as it has; they are kept in memory until the next
    /// [`flush`](Self::flush), or until a chunk is full. Contacts are numbered in the order in which they
    /// stand here; how many they are, and their flags, is written into the tick.
    ///
    /// # Errors
    /// Its number is not above that of the tick before; what the system says. After an error of the
    /// system nothing more can be added, and what was flushed before is readable.
    pub fn append(&mut self, tick: &Tick, contacts: &[ContactTick]) -> Result<(), WriteError> {
        self.append_with_bodies(tick, contacts, &[])
    }

    /// Adds a tick as [`append`](Self::append) does, with the bodies of the world that move.
    ///
    /// # Errors
    /// As [`append`](Self::append).
    pub fn append_with_bodies(
        &mut self,
        tick: &Tick,
        contacts: &[ContactTick],
        bodies: &[BodyTick],
    ) -> Result<(), WriteError> {
        self.append_with_devices(tick, contacts, bodies, &[])
    }

    /// Adds a tick as [`append_with_bodies`](Self::append_with_bodies) does, with each device of a loop that has
    /// several, in their order: their numbers and how many they are is written into them. A loop with one device has
    /// none here.
    ///
    /// # Errors
    /// As [`append`](Self::append).
    pub fn append_with_devices(
        &mut self,
        tick: &Tick,
        contacts: &[ContactTick],
        bodies: &[BodyTick],
        devices: &[DeviceTick],
    ) -> Result<(), WriteError> {
        let outcome = self.stream.append(tick, contacts, bodies, devices);
        outcome.map_err(|source| self.failed(source))
    }

    /// Adds an event, as [`append`](Self::append) does a tick.
    ///
    /// # Errors
    /// Its texts are longer than a mebibyte; what the system says.
    pub fn event(&mut self, event: &Event) -> Result<(), WriteError> {
        let outcome = self.stream.event(event);
        outcome.map_err(|source| self.failed(source))
    }

    /// Hands everything to the system: it outlives this program, whatever ends it. To outlive the
    /// machine it must be on the disk, where it is brought at least every two seconds of flushing.
    ///
    /// # Errors
    /// What the system says: a full disk, above all.
    pub fn flush(&mut self) -> Result<(), WriteError> {
        let outcome = self.stream.flush().and_then(|()| {
            if self.synced.elapsed() < SYNC_EVERY {
                return Ok(());
            }
            self.synced = Instant::now();
            self.file.sync_data()
        });
        outcome.map_err(|source| self.failed(source))
    }

    /// Writes what the loop itself counted, as the last thing before [`finish`](Self::finish). A
    /// recording without it is read, but nobody can say whether ticks are missing at its end.
    ///
    /// # Errors
    /// What the system says.
    pub fn count(&mut self, count: &LoopCount) -> Result<(), WriteError> {
        let outcome = self.stream.count(count);
        outcome.map_err(|source| self.failed(source))
    }

    /// Ends the recording and gives it its name.
    ///
    /// # Errors
    /// What the system says; the recording is then still called `NAME.part`, and so it is where a
    /// file of its name has appeared since.
    pub fn finish(self) -> Result<Summary, WriteError> {
        let Self {
            stream,
            file,
            path,
            part,
            ..
        } = self;
        let (ticks, events) = (stream.ticks, stream.events);
        let complete = || {
            let out = stream.finish()?;
            out.into_inner().map_err(io::IntoInnerError::into_error)?;
            file.sync_all()?;
            let bytes = file.metadata()?.len();
            // Some systems do not rename what is open.
            drop(file);
            let part = TempPath::try_from_path(&part)?;
            part.persist_noclobber(&path).map_err(|failed| {
                // Else it would be removed.
                let _ = failed.path.keep();
                match failed.error.kind() {
                    io::ErrorKind::AlreadyExists => {
                        exists("a file of that name has appeared".into())
                    }
                    _ => failed.error,
                }
            })?;
            Ok(Summary {
                ticks,
                events,
                bytes,
            })
        };
        complete().map_err(|source| WriteError::new(&path, source))
    }

    fn failed(&self, source: io::Error) -> WriteError {
        WriteError::new(&self.part, source)
    }
}

/// What a recording is called while it is not finished.
pub(super) fn part_of(path: &Path) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(".part");
    PathBuf::from(name)
}

/// A recording needs a name that is free, in a folder in which it can grow under another one.
fn refuse_what_is_there(path: &Path) -> io::Result<()> {
    let names_a_directory = path.to_string_lossy().ends_with(std::path::is_separator);
    if names_a_directory || path.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    if path.file_name().is_none() {
        let words = "the path names no file";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, words));
    }
    match path.symlink_metadata() {
        Err(_) => Ok(()),
        Ok(found) if found.is_file() || found.is_symlink() => {
            Err(exists("there is a file of that name".into()))
        }
        Ok(_) => Err(io::Error::other(
            "it is no regular file; a recording is a file in a folder, where it grows under the name \
             with `.part` behind it",
        )),
    }
}

fn exists(what: String) -> io::Error {
    io::Error::new(
        io::ErrorKind::AlreadyExists,
        format!("{what}; a recording overwrites nothing, so name another or move it away"),
    )
}
