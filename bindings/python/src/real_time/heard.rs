//! Ring buffer of ticks for Python, and forwarding of ticks to the recording.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::sleep;
use std::time::{Duration, Instant};

use palpate_record::recording::{ContactTick, Event, Flags, Row, Tick, columns};
use palpate_rt::{Listener, Message, Tap};

use crate::columns::Words;
use crate::recording::{body, device, word};

/// Largest capacity of a ring [ticks]: 4 minutes at 4 kHz, about 500 MB.
pub const LARGEST: usize = 1_000_000;
/// Largest number of events that wait for Python; a recording has all events.
const EVENTS_KEPT: usize = 1000;
/// Sleep time of the listener when the queue is empty.
const REST: Duration = Duration::from_millis(1);
/// Largest number of ticks taken before the ring is unlocked.
const AT_ONCE: usize = 4096;

/// Ticks for Python: one row per contact, one per body of a world, and one per device if there are several.
#[derive(Debug, Default)]
pub struct Rows {
    /// Rows of contacts, or of the tick alone if there is no contact.
    pub contacts: Words,
    /// Rows of bodies.
    pub bodies: Words,
    /// Rows of devices, for a loop with several.
    pub devices: Words,
}

/// Events, each with its tick number, time `[s]`, kind and text; and the number of dropped events.
pub type Events = (Vec<(u64, f64, String, String)>, u64);

/// Newest ticks and events that Python has not read.
#[derive(Debug)]
pub struct Heard {
    ring: Mutex<Ring>,
    news: Condvar,
    most: usize,
}

#[derive(Debug, Default)]
struct Ring {
    rows: VecDeque<Rows>,
    /// Ticks in the ring that newer ones replaced.
    overwritten: u64,
    events: VecDeque<Event>,
    events_gone: u64,
    last: Option<(Instant, Tick)>,
    /// Number of ticks of the loop, and of those received here.
    made: u64,
    came: u64,
    closed: bool,
}

/// State of the ring.
pub struct Standing {
    /// Number of ticks of the loop.
    pub ticks: u64,
    /// Number of dropped ticks, which no read returns.
    pub lost: u64,
    /// Time since the last tick was received `[s]`; `None` before the first.
    pub silent: Option<f64>,
    /// Whether a safety stop disabled the motors at the end of the last tick.
    pub stopped: bool,
}

impl Heard {
    /// Creates a ring for `most` ticks.
    pub fn new(most: usize) -> Self {
        Self {
            ring: Mutex::default(),
            news: Condvar::new(),
            most,
        }
    }

    fn ring(&self) -> MutexGuard<'_, Ring> {
        self.ring.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes all rows, after waiting up to `wait` for the first one or the end.
    pub fn take(&self, wait: Duration) -> Rows {
        let mut ring = self.ring();
        if ring.rows.is_empty() && !ring.closed && wait > Duration::ZERO {
            let nothing = |ring: &mut Ring| ring.rows.is_empty() && !ring.closed;
            let waited = self.news.wait_timeout_while(ring, wait, nothing);
            ring = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        let rows = std::mem::take(&mut ring.rows);
        drop(ring);
        let mut taken = Rows::default();
        for row in rows {
            taken.contacts.extend(row.contacts);
            taken.bodies.extend(row.bodies);
            taken.devices.extend(row.devices);
        }
        taken
    }

    /// Returns the waiting events and the number of events dropped since the last call.
    pub fn events(&self) -> Events {
        let mut ring = self.ring();
        let gone = std::mem::take(&mut ring.events_gone);
        let events = std::mem::take(&mut ring.events).into_iter();
        let messages = events.map(|event| (event.sequence, event.time, event.kind, event.text));
        (messages.collect(), gone)
    }

    /// Returns the state of the ring.
    pub fn now(&self) -> Standing {
        let ring = self.ring();
        Standing {
            ticks: ring.made,
            lost: ring.overwritten + ring.made.saturating_sub(ring.came),
            silent: ring.last.map(|(at, _)| at.elapsed().as_secs_f64()),
            stopped: ring
                .last
                .is_some_and(|(_, tick)| tick.flags.has(Flags::SAFETY_STOPPED)),
        }
    }

    /// Whether the ring is closed.
    pub fn is_closed(&self) -> bool {
        self.ring().closed
    }

    /// Closes the ring: no more ticks follow.
    pub fn close(&self) {
        self.ring().closed = true;
        self.news.notify_all();
    }

    fn hear(&self, news: &mut News) {
        let mut ring = self.ring();
        ring.came += news.rows.len() as u64;
        if let Some(last) = news.last.take() {
            ring.last = Some((Instant::now(), last));
        }
        for row in news.rows.drain(..) {
            if ring.rows.len() >= self.most {
                ring.rows.pop_front();
                ring.overwritten += 1;
            }
            ring.rows.push_back(row);
        }
        for event in news.events.drain(..) {
            if ring.events.len() >= EVENTS_KEPT {
                ring.events.pop_front();
                ring.events_gone += 1;
            }
            ring.events.push_back(event);
        }
        // Ticks in transit are not lost.
        ring.made = ring.came + news.lost;
        drop(ring);
        self.news.notify_all();
    }
}

/// Ticks and events received since the last update of the ring.
#[derive(Default)]
struct News {
    rows: Vec<Rows>,
    events: Vec<Event>,
    last: Option<Tick>,
    /// Number of earlier ticks that were dropped on the way.
    lost: u64,
}

/// Listens until the loop has ended: fills the ring and forwards ticks to the recording.
pub fn listen(mut listener: Listener, mut recording: Option<Tap>, heard: &Heard) {
    let mut news = News::default();
    let mut came = 0;
    let mut are_named = false;
    loop {
        // Check before draining: messages sent before the loop closed are still in the queue.
        let is_last = listener.is_closed();
        let mut rested = true;
        for _ in 0..AT_ONCE {
            let Some(messages) = listener.next() else {
                break;
            };
            rested = false;
            // The loop sends the device names before the first tick.
            if let Some(recording) = recording.as_ref().filter(|_| !are_named) {
                recording.name_devices(listener.device_names().to_vec());
                are_named = true;
            }
            match messages {
                Message::Tick(tick, contacts, bodies, devices) => {
                    came += 1;
                    news.lost = tick.sequence + 1 - came;
                    news.last = Some(tick);
                    if let Some(recording) = &mut recording {
                        recording.tick_with_devices(&tick, &contacts, &bodies, &devices);
                    }
                    // Number the contacts as a recording does.
                    let numbered = (0..).zip(contacts);
                    let contacts = numbered.map(|(contact, own)| ContactTick { contact, ..own });
                    let contacts: Vec<_> = contacts.collect();
                    let rows = Row::new(tick, &contacts);
                    let words = rows.flat_map(|row| {
                        let values = columns().iter();
                        values.map(move |column| word(column.value(&row)))
                    });
                    news.rows.push(Rows {
                        contacts: words.collect(),
                        bodies: bodies.iter().flat_map(body).collect(),
                        devices: devices.iter().flat_map(device).collect(),
                    });
                }
                Message::Note(noted) => {
                    if let Some(recording) = &mut recording {
                        recording.note(&noted);
                    }
                    let event = noted.event_of(listener.device_names());
                    news.events.push(event);
                }
            }
        }
        let is_over = is_last && rested;
        let counted = listener.counted();
        if is_over {
            news.lost = counted.ticks.saturating_sub(came);
        }
        if !rested || is_over {
            heard.hear(&mut news);
        }
        if is_over {
            heard.close();
            if let Some(mut recording) = recording.take() {
                recording.ran(counted.time);
                recording.count(&counted);
                if let Some(ending) = counted.ending {
                    recording.end(ending);
                }
            }
            return;
        }
        if rested {
            sleep(REST);
        }
    }
}
