//! The thread that writes down what a loop tells.

use std::io;
use std::path::Path;
use std::sync::{Arc, OnceLock};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use palpate_files::atomic::WriteError;
use palpate_record::recording::{
    ContactTick, DeviceTick, Event, LoopCount, LoopTime, Receipt, RecordingWriter, Row, Summary,
    Tick,
};

use crate::note::Ending;
use crate::tap::{Counted, Listener, Tap, Told, tap, tap_if_there_is_memory};

/// Everything up to this long ago survives whatever ends the program.
const FLUSH_EVERY: Duration = Duration::from_millis(250);
/// How long the writer rests when it has written everything.
const REST: Duration = Duration::from_millis(2);
/// Events that are kept in memory; a recording has all of them.
const EVENTS_KEPT: usize = 1000;

/// Listens to a loop on a thread of its own, and writes a recording of it if it is to. The loop never
/// waits for it: what finds no room is lost, counted, and missing from the recording by its number.
/// Where the system refuses to write, it goes on listening, and [`failure`](Self::failure) says why at
/// once: it may be long until the loop ends.
#[derive(Debug)]
pub struct Recorder {
    thread: JoinHandle<(Account, Option<WriteError>)>,
    failure: Arc<OnceLock<String>>,
}

/// What a loop has told.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Account {
    /// What the recording holds, if one was written to its end.
    pub recording: Option<Summary>,
    /// Ticks that the loop made.
    pub ticks_made: u64,
    /// Ticks that came here.
    pub ticks: u64,
    /// Events that the loop told.
    pub events_made: u64,
    /// Ticks at whose end a trip of the safety kept the motors off, whether or not they came here.
    pub motors_off: u64,
    /// The first events, up to a thousand.
    pub events: Vec<Event>,
    /// How many events there were.
    pub all_events: u64,
    /// Strongest force that was sent `[N]`.
    pub peak_force: f64,
    /// Deepest penetration `[m]`.
    pub deepest: f64,
    /// The most energy that held forces had created up to any tick, while the motors were on `[J]`; at least 0.
    pub most_created: f64,
    /// The last tick, with its first contact.
    pub last: Option<Row>,
}

impl Account {
    /// Ticks that found no room on their way here.
    #[must_use]
    pub fn lost_ticks(&self) -> u64 {
        self.ticks_made.saturating_sub(self.ticks)
    }

    /// Events that found no room on their way here.
    #[must_use]
    pub fn lost_events(&self) -> u64 {
        self.events_made.saturating_sub(self.all_events)
    }

    /// Takes down what the loop itself counted.
    pub fn counted(&mut self, counted: &Counted) {
        self.ticks_made = counted.ticks;
        self.events_made = counted.notes;
        self.motors_off = counted.motors_off;
    }

    /// Takes down a tick and its contacts.
    pub fn tick(&mut self, tick: &Tick, contacts: &[ContactTick]) {
        self.ticks += 1;
        self.most_created = self.most_created.max(tick.created_energy);
        for contact in contacts {
            self.peak_force = self.peak_force.max(contact.force_on_device.abs());
            self.deepest = self.deepest.max(contact.penetration);
        }
        if tick.bodies > 0 {
            // A contact of a world does not say what of its force the device feels.
            self.peak_force = self.peak_force.max(length(tick.delivered_force));
        }
        self.last = Row::of(*tick, contacts).next();
    }

    /// Takes down the devices of a tick of a loop that has several.
    pub fn devices(&mut self, devices: &[DeviceTick]) {
        for device in devices {
            self.peak_force = self.peak_force.max(length(device.delivered_force));
        }
    }

    /// Takes down something that happened.
    pub fn event(&mut self, event: Event) {
        self.all_events += 1;
        if self.events.len() < EVENTS_KEPT {
            self.events.push(event);
        }
    }
}

impl Recorder {
    /// Ticks of one contact that may wait for the disk, where nobody says otherwise: 16 s at 4 kHz.
    pub const ROOM: usize = 1 << 16;

    /// Begins a recording at `path` and gives the tap for its loop. It ends when the loop closes the
    /// tap.
    ///
    /// # Errors
    /// A file is there already, or cannot be written; the system gives no thread.
    pub fn begin(path: &Path, receipt: &Receipt) -> Result<(Tap, Self), WriteError> {
        Self::begin_with_room(path, receipt, Self::ROOM)
    }

    /// As [`begin`](Self::begin), where so many ticks of one contact may wait for the disk: each takes about 1 KiB.
    ///
    /// # Errors
    /// The system has no memory for so many, whose kind is [`io::ErrorKind::OutOfMemory`], or gives no thread; a file is there
    /// already, or cannot be written. No file is left then.
    pub fn begin_with_room(
        path: &Path,
        receipt: &Receipt,
        room: usize,
    ) -> Result<(Tap, Self), WriteError> {
        let failed = |source| WriteError::new(path, source);
        let ends = tap_if_there_is_memory(room).map_err(failed)?;
        let writer = RecordingWriter::create(path, receipt)?;
        let part = writer.part().to_owned();
        Self::on_thread(Some(writer), ends).map_err(|source| {
            // Nothing was recorded in it.
            let _ = std::fs::remove_file(part);
            failed(source)
        })
    }

    /// Listens only.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn without_file() -> io::Result<(Tap, Self)> {
        Self::on_thread(None, tap(Self::ROOM))
    }

    /// Whether it writes no more: its tap was closed, or the system refused to write, and
    /// [`finish`](Self::finish) says why.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.failure().is_some() || self.thread.is_finished()
    }

    /// What the system said when it refused to write, as soon as it has.
    #[must_use]
    pub fn failure(&self) -> Option<&str> {
        self.failure.get().map(String::as_str)
    }

    fn on_thread(
        writer: Option<RecordingWriter>,
        (tap, mut listener): (Tap, Listener),
    ) -> io::Result<(Tap, Self)> {
        let failure = Arc::new(OnceLock::new());
        let told = Arc::clone(&failure);
        let thread = Builder::new()
            .name("palpate recorder".to_owned())
            .spawn(move || {
                let mut account = Account::default();
                let mut writing = Writing {
                    writer,
                    failed: None,
                    told,
                };
                write_down(&mut listener, &mut writing, &mut account);
                // Closed before the last was taken: it is all there.
                let counted = listener.counted();
                account.counted(&counted);
                writing.write(|writer| writer.count(&count(&counted)));
                account.recording = writing.finish();
                (account, writing.failed)
            })?;
        Ok((tap, Self { thread, failure }))
    }

    /// Waits until everything is written. The loop has to close its tap first: it does when it ends
    /// on its thread, and when it is dropped. What the loop has told, and why that could not be
    /// written, if it could not; what was flushed before stays readable.
    ///
    /// # Panics
    /// The recorder's thread panicked.
    #[must_use]
    pub fn finish(self) -> (Account, Option<WriteError>) {
        match self.thread.join() {
            Ok(ended) => ended,
            Err(payload) => std::panic::resume_unwind(payload),
        }
    }
}

/// The file, until the system refuses to write it.
struct Writing {
    writer: Option<RecordingWriter>,
    failed: Option<WriteError>,
    told: Arc<OnceLock<String>>,
}

impl Writing {
    fn write(&mut self, write: impl FnOnce(&mut RecordingWriter) -> Result<(), WriteError>) {
        if let Some(writer) = &mut self.writer
            && let Err(error) = write(writer)
        {
            self.fail(error);
        }
    }

    fn finish(&mut self) -> Option<Summary> {
        match self.writer.take()?.finish() {
            Ok(summary) => Some(summary),
            Err(error) => {
                self.fail(error);
                None
            }
        }
    }

    fn fail(&mut self, error: WriteError) {
        self.writer = None;
        // It fails once.
        let _ = self.told.set(error.to_string());
        self.failed = Some(error);
    }
}

fn length(vector: [f64; 3]) -> f64 {
    let square: f64 = vector.iter().map(|x| x * x).sum();
    square.sqrt()
}

/// What was counted, as the recording has it.
fn count(counted: &Counted) -> LoopCount {
    LoopCount {
        ticks: counted.ticks,
        events: counted.notes,
        motors_off: counted.motors_off,
        time: Some(counted.time).filter(|time| *time != LoopTime::default()),
        ending: counted.ending.map(Ending::text).map(str::to_owned),
    }
}

fn write_down(listener: &mut Listener, writing: &mut Writing, account: &mut Account) {
    let mut flushed = Instant::now();
    loop {
        // Asked first: what was told before the loop went is then still to come.
        let is_last = listener.is_closed();
        let mut rested = true;
        // No more than a part of the room at a time: the flush must come, whoever tells how fast.
        for _ in 0..Recorder::ROOM / 16 {
            let Some(told) = listener.next() else {
                break;
            };
            rested = false;
            match told {
                Told::Tick(tick, contacts, bodies, devices) => {
                    account.tick(&tick, &contacts);
                    account.devices(&devices);
                    writing.write(|writer| {
                        writer.append_with_devices(&tick, &contacts, &bodies, &devices)
                    });
                }
                Told::Note(noted) => {
                    let event = noted.event_of(listener.device_names());
                    writing.write(|writer| writer.event(&event));
                    account.event(event);
                }
            }
        }
        if flushed.elapsed() >= FLUSH_EVERY {
            writing.write(RecordingWriter::flush);
            flushed = Instant::now();
        }
        if is_last && rested {
            return;
        }
        if rested {
            std::thread::sleep(REST);
        }
    }
}
