//! The thread that writes down what a loop tells.

use std::path::{Path, PathBuf};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use palpate_io::atomic::WriteError;
use palpate_io::recording::{Receipt, RecordingWriter, Summary};

use crate::tap::{Listener, Tap, Told, tap};

/// Everything up to this long ago survives whatever ends the program.
const FLUSH_EVERY: Duration = Duration::from_millis(250);
/// How long the writer rests when it has written everything.
const REST: Duration = Duration::from_millis(2);
/// Things that may wait for the disk: 16 s at 4 kHz.
const ROOM: usize = 1 << 16;

/// A recording in progress, on a thread of its own. The loop never waits for it: what finds no room
/// is lost, counted, and missing from the recording by its number.
#[derive(Debug)]
pub struct Recorder {
    thread: JoinHandle<Result<Recorded, WriteError>>,
    path: PathBuf,
}

/// What was recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recorded {
    /// What the file holds.
    pub summary: Summary,
    /// Ticks and events that found no room on their way here.
    pub lost: u64,
}

impl Recorder {
    /// Begins a recording at `path` and gives the tap for its loop. It ends when the loop does.
    ///
    /// # Errors
    /// A file is there already, or cannot be written.
    pub fn begin(path: &Path, receipt: &Receipt) -> Result<(Tap, Self), WriteError> {
        let mut writer = RecordingWriter::create(path, receipt)?;
        let (tap, mut listener) = tap(ROOM);
        let thread = Builder::new()
            .name("palpate recorder".to_owned())
            .spawn(move || {
                write_down(&mut listener, &mut writer)?;
                Ok(Recorded {
                    summary: writer.finish()?,
                    lost: listener.lost(),
                })
            })
            .map_err(|source| WriteError::new(path, source))?;
        let path = path.to_owned();
        Ok((tap, Self { thread, path }))
    }

    /// Waits until everything is written. Drop the loop first: it is what ends the recording.
    ///
    /// # Errors
    /// What the system said while writing. What was flushed before stays readable.
    ///
    /// # Panics
    /// The recorder's thread panicked.
    pub fn finish(self) -> Result<Recorded, WriteError> {
        match self.thread.join() {
            Ok(recorded) => recorded,
            Err(_) => panic!("the recorder of {} panicked", self.path.display()),
        }
    }
}

fn write_down(listener: &mut Listener, writer: &mut RecordingWriter) -> Result<(), WriteError> {
    let mut flushed = Instant::now();
    loop {
        // Asked first: what was told before the loop went is then still to come.
        let is_last = listener.is_abandoned();
        let mut rested = true;
        for told in listener.by_ref() {
            rested = false;
            match told {
                Told::Tick(tick) => writer.append(&tick)?,
                Told::Note(noted) => writer.event(&noted.event())?,
            }
        }
        if flushed.elapsed() >= FLUSH_EVERY {
            writer.flush()?;
            flushed = Instant::now();
        }
        if is_last {
            return Ok(());
        }
        if rested {
            std::thread::sleep(REST);
        }
    }
}
