//! Writer of a recording to a file while the loop runs.

use std::ffi::OsString;
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::files::atomic::WriteError;
use tempfile::TempPath;

use super::stream::Stream;
use super::{BodyTick, ContactTick, DeviceTick, Event, LoopCount, RecordingMetadata, Tick};

/// Maximum time between synchronisations to disk while ticks are flushed.
const SYNC_EVERY: Duration = Duration::from_secs(2);

/// Writer of a recording. Do not use it in the rendering thread: every call may wait for the disk.
///
/// The file is called `NAME.part` until [`finish`](Self::finish). Dropping the writer keeps this name and all
/// appended data.
pub struct RecordingWriter {
    stream: Stream<BufWriter<File>>,
    /// Second handle, used to synchronise the data of the first one to disk.
    file: File,
    synced: Instant,
    path: PathBuf,
    part: PathBuf,
}

/// Summary of a finished recording.
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
    /// Starts a recording; its metadata are on disk on return.
    ///
    /// A recording cannot be repeated, so nothing is overwritten: neither `path` nor the truncated file of an earlier
    /// recording of that name.
    ///
    /// # Errors
    /// `path` names no file; a file of that name exists, finished or not; a metadata entry has a reserved name; an
    /// error of the system. The error names the path.
    pub fn create(path: &Path, metadata: &RecordingMetadata) -> Result<Self, WriteError> {
        let part = part_of(path);
        let begin = || {
            refuse_what_is_there(path)?;
            let file = OpenOptions::new().write(true).create_new(true).open(&part);
            let file = file.map_err(|error| match error.kind() {
                io::ErrorKind::AlreadyExists => exists(format!(
                    "`{}` is an unfinished recording, interrupted or still running",
                    part.display()
                )),
                _ => error,
            })?;
            let stream = Stream::begin(BufWriter::new(file.try_clone()?), metadata)
                .and_then(|stream| file.sync_data().map(|()| stream));
            match stream {
                Ok(stream) => Ok((stream, file)),
                Err(error) => {
                    // Remove the empty recording.
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

    /// Returns the path of the unfinished recording.
    #[must_use]
    pub fn part(&self) -> &Path {
        &self.part
    }

    /// Appends a tick and its contacts, in any number. They stay in memory until the next [`flush`](Self::flush), or
    /// until a chunk is full. The writer numbers the contacts in the given order and writes their number and their
    /// flags into the tick.
    ///
    /// # Errors
    /// The tick's number is not above that of the previous tick; an error of the system. After an error of the system
    /// nothing more can be appended, and flushed data are readable.
    pub fn append(&mut self, tick: &Tick, contacts: &[ContactTick]) -> Result<(), WriteError> {
        self.append_with_bodies(tick, contacts, &[])
    }

    /// Appends a tick as [`append`](Self::append) does, with the moving bodies of the world.
    ///
    /// # Errors
    /// Those of [`append`](Self::append).
    pub fn append_with_bodies(
        &mut self,
        tick: &Tick,
        contacts: &[ContactTick],
        bodies: &[BodyTick],
    ) -> Result<(), WriteError> {
        self.append_with_devices(tick, contacts, bodies, &[])
    }

    /// Appends a tick as [`append_with_bodies`](Self::append_with_bodies) does, with each device of a loop with
    /// several devices, in their order. The writer sets their indices and their number. The list is empty for a
    /// single device.
    ///
    /// # Errors
    /// Those of [`append`](Self::append).
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

    /// Appends an event in the same way as [`append`](Self::append).
    ///
    /// # Errors
    /// A text longer than a mebibyte; an error of the system.
    pub fn event(&mut self, event: &Event) -> Result<(), WriteError> {
        let outcome = self.stream.event(event);
        outcome.map_err(|source| self.failed(source))
    }

    /// Passes all data to the system, so they survive the end of this program. They survive a crash of the machine
    /// once they are on disk, where they are synchronised at least every two seconds of flushing.
    ///
    /// # Errors
    /// An error of the system, such as a full disk.
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

    /// Writes the counters of the loop, as the last item before [`finish`](Self::finish). A recording without them is
    /// readable, but ticks missing at its end cannot be detected.
    ///
    /// # Errors
    /// An error of the system.
    pub fn count(&mut self, count: &LoopCount) -> Result<(), WriteError> {
        let outcome = self.stream.count(count);
        outcome.map_err(|source| self.failed(source))
    }

    /// Completes the recording and renames it to its final name.
    ///
    /// # Errors
    /// An error of the system, or a file of the final name that has appeared since. The recording is then still
    /// called `NAME.part`.
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
            // Some systems cannot rename an open file.
            drop(file);
            let part = TempPath::try_from_path(&part)?;
            part.persist_noclobber(&path).map_err(|failed| {
                // Otherwise the file would be removed.
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

/// Returns the name of an unfinished recording.
pub(super) fn part_of(path: &Path) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(".part");
    PathBuf::from(name)
}

/// Checks that the name is free and that the directory accepts the unfinished file.
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
            "it is not a regular file; a recording is a file in a folder and grows there under its name \
             with `.part` appended",
        )),
    }
}

fn exists(what: String) -> io::Error {
    io::Error::new(
        io::ErrorKind::AlreadyExists,
        format!("{what}; a recording overwrites no file, so name another or move it away"),
    )
}
