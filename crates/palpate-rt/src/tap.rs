//! Non-blocking transfer of ticks and events from the loop's thread to a listener.

use std::io;
use std::iter;
use std::sync::Arc;
use std::time::Duration;

use palpate_record::recording::{BodyTick, ContactTick, DeviceTick, Flags, LoopTime, Tick};

use crate::note::{Ending, LoopEvent, Note};
use crate::tally::{Counts, Tally};

/// Message of a loop.
// Most messages are ticks, so the size difference of the variants wastes little memory.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug)]
pub enum Message {
    /// A tick with all its contacts, the moving bodies of a world, and the devices of a loop with several devices
    /// (empty for a single device).
    Tick(Tick, Vec<ContactTick>, Vec<BodyTick>, Vec<DeviceTick>),
    /// An event.
    Note(LoopEvent),
}

/// Item of the ring buffer. A tick follows its devices, if there are several, and precedes its contacts and its
/// bodies. Either all of them are written, or none.
// Boxing would allocate in the loop.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Copy, Debug)]
enum Passed {
    Tick(Tick),
    Contact(ContactTick),
    Body(BodyTick),
    Device(DeviceTick),
    Note(LoopEvent),
}

/// Counters of a loop. They are atomics outside the ring buffer, so they stay exact when ticks are dropped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Number of ticks.
    pub ticks: u64,
    /// Number of events.
    pub notes: u64,
    /// Ticks and events dropped because the ring buffer was full.
    pub lost: u64,
    /// Ticks at whose end a safety stop kept the motors off.
    pub motors_off: u64,
    /// Duration of the loop, and the part of it without a delivered force; zero if unknown.
    pub time: LoopTime,
    /// Reason for the end of the loop; `None` while it runs, or if unknown.
    pub ending: Option<Ending>,
}

impl From<Counts> for Counters {
    fn from(counts: Counts) -> Self {
        Self {
            ticks: counts.ticks,
            notes: counts.notes,
            lost: counts.lost,
            motors_off: counts.motors_off,
            time: LoopTime {
                lasted: counts.lasted,
                motors_off: counts.motors_off_for,
            },
            ending: Ending::of_number(counts.ending),
        }
    }
}

/// The loop's end: it drops and counts items that do not fit into the ring buffer.
#[derive(Debug)]
pub struct Tap {
    out: rtrb::Producer<Passed>,
    tally: Arc<Tally>,
    names: Names,
    waits: bool,
}

/// The listener's end: an iterator over the messages not yet received. It never blocks; after `None` more messages
/// may follow.
#[derive(Debug)]
pub struct Listener {
    incoming: rtrb::Consumer<Passed>,
    tally: Arc<Tally>,
    names: Names,
}

/// Creates a tap with a capacity of `capacity` unread ticks of one contact. An event, each further contact, each body
/// and each of several devices take half the memory of such a tick. A tick that exceeds the whole capacity is always
/// lost.
#[must_use]
pub fn tap(capacity: usize) -> (Tap, Listener) {
    let (out, incoming) = rtrb::RingBuffer::new(2 * capacity);
    let tally = Arc::new(Tally::new());
    let names = Names::default();
    let tap = Tap {
        out,
        tally: Arc::clone(&tally),
        names: Arc::clone(&names),
        waits: false,
    };
    let listener = Listener {
        incoming,
        tally,
        names,
    };
    (tap, listener)
}

/// Creates a tap as [`tap`] does, after checking that the system has enough memory.
///
/// # Errors
/// Not enough memory: [`io::ErrorKind::OutOfMemory`].
pub(crate) fn tap_if_there_is_memory(capacity: usize) -> io::Result<(Tap, Listener)> {
    let items = capacity.saturating_mul(2);
    // The ring allocates infallibly: without memory it would abort the program.
    let mut memory = Vec::<Passed>::new();
    let is_there = memory.try_reserve_exact(items).is_ok();
    // Prevents the compiler from removing the unused allocation.
    std::hint::black_box(memory.as_mut_ptr());
    drop(memory);
    if !is_there {
        let bytes = items.saturating_mul(size_of::<Passed>());
        return Err(io::Error::new(
            io::ErrorKind::OutOfMemory,
            format!(
                "a buffer for {capacity} ticks needs {bytes} bytes, which the system cannot allocate"
            ),
        ));
    }
    Ok(tap(capacity))
}

impl Tap {
    /// Sends a tick and its contacts. The tick's number gives the number of ticks made. If the tick and all its
    /// contacts do not fit, the whole tick is lost.
    pub fn tick(&mut self, tick: &Tick, contacts: &[ContactTick]) {
        self.tick_with_bodies(tick, contacts, &[]);
    }

    /// Sends a tick as [`tick`](Self::tick) does, with the moving bodies of the world.
    pub fn tick_with_bodies(&mut self, tick: &Tick, contacts: &[ContactTick], bodies: &[BodyTick]) {
        self.tick_with_devices(tick, contacts, bodies, &[]);
    }

    /// Sends a tick as [`tick_with_bodies`](Self::tick_with_bodies) does, with each device of a loop with several
    /// devices.
    pub fn tick_with_devices(
        &mut self,
        tick: &Tick,
        contacts: &[ContactTick],
        bodies: &[BodyTick],
        devices: &[DeviceTick],
    ) {
        self.tally.made(tick.sequence.saturating_add(1));
        if tick.flags.has(Flags::SAFETY_STOPPED) {
            self.tally.was_off();
        }
        let passed = Passed::Tick(Tick {
            contacts: u32::try_from(contacts.len()).unwrap_or(u32::MAX),
            bodies: u32::try_from(bodies.len()).unwrap_or(u32::MAX),
            ..*tick
        });
        let count = devices.len() + 1 + contacts.len() + bodies.len();
        let contacts = contacts.iter().copied().map(Passed::Contact);
        let bodies = bodies.iter().copied().map(Passed::Body);
        let devices = devices.iter().copied().map(Passed::Device);
        let of_tick = iter::once(passed).chain(contacts).chain(bodies);
        self.push(count, devices.chain(of_tick));
    }

    /// Sets the names of the devices of a loop with several devices, in their order, once before the first tick. A
    /// loop calls it itself. A program that forwards the messages of a loop calls it with [`Listener::device_names`].
    pub fn name_devices(&self, names: Vec<String>) {
        // The first names stay.
        let _ = self.names.set(names);
    }

    /// Sets the duration of the loop and the part of it without a delivered force.
    pub fn ran(&mut self, time: LoopTime) {
        self.tally.ran(time.lasted, time.motors_off);
    }

    /// Sends an event.
    pub fn note(&mut self, noted: &LoopEvent) {
        self.tally.noted();
        self.push(1, iter::once(Passed::Note(*noted)));
    }

    /// Sets the numbers of ticks, events and ticks with the motors off, and the times, if not all of them were sent
    /// here. The number of dropped items is unchanged.
    pub fn count(&mut self, counted: &Counters) {
        self.tally.set(&Counts {
            ticks: counted.ticks,
            notes: counted.notes,
            motors_off: counted.motors_off,
            lasted: counted.time.lasted,
            motors_off_for: counted.time.motors_off,
            ..Counts::default()
        });
    }

    /// Returns the current counters.
    #[must_use]
    pub fn counted(&self) -> Counters {
        self.tally.counts().into()
    }

    /// Closes the tap with the reason for the end of the loop. Dropping the tap closes it without a reason.
    pub fn end(self, ending: Ending) {
        self.tally.ended(ending.number());
    }

    /// Returns how many ticks and events were dropped.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.tally.counts().lost
    }

    /// Makes the tap wait for free capacity instead of dropping items, for a loop that runs as fast as possible on a
    /// clock that stops meanwhile. Do not use it for a loop with a motor.
    #[must_use]
    pub fn waiting(mut self) -> Self {
        self.waits = true;
        self
    }

    #[expect(
        clippy::disallowed_methods,
        reason = "yields only on a simulated clock, which does not advance meanwhile"
    )]
    fn push(&mut self, count: usize, passed: impl Iterator<Item = Passed>) {
        let can_fit = count <= self.out.buffer().capacity();
        while self.waits && can_fit && self.out.slots() < count && !self.tally.is_deaf() {
            std::thread::yield_now();
        }
        match self.out.write_chunk_uninit(count) {
            // The listener sees all of them at once.
            Ok(room) => {
                room.fill_from_iter(passed);
            }
            Err(_) => self.tally.dropped(),
        }
    }
}

/// Names of several devices, once set.
#[expect(
    clippy::disallowed_types,
    reason = "the loop writes it before its first tick; its listener reads it"
)]
type Names = Arc<std::sync::OnceLock<Vec<String>>>;

/// Sends messages of a loop, if it has a tap, with the number of the tick and the time since its start.
#[derive(Debug, Default)]
pub(crate) struct Teller {
    pub tap: Option<Tap>,
    /// Number of the tick.
    pub sequence: u64,
    /// Start time of the loop.
    pub started: Duration,
}

impl Teller {
    /// Sends an event at `now`, with its device if the loop has several.
    pub fn note(&mut self, now: Duration, device: Option<u32>, note: Note) {
        if let Some(tap) = &mut self.tap {
            tap.note(&LoopEvent {
                sequence: self.sequence,
                time: now.saturating_sub(self.started).as_secs_f64(),
                device,
                note,
            });
        }
    }
}

impl Drop for Tap {
    fn drop(&mut self) {
        self.tally.close();
    }
}

impl Listener {
    /// Returns how many ticks and events were dropped. The tick numbers of a recording show which ones.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.tally.counts().lost
    }

    /// Returns the current counters; they are final if [`is_closed`](Self::is_closed) returned true before.
    #[must_use]
    pub fn counted(&self) -> Counters {
        self.tally.counts().into()
    }

    /// Returns the names of the devices of a loop with several devices, in their order; empty for a single device.
    #[must_use]
    pub fn device_names(&self) -> &[String] {
        self.names.get().map_or(&[], Vec::as_slice)
    }

    /// Returns whether the tap is closed; unread messages may remain. If it returned true before an unsuccessful
    /// read, no more messages follow.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.tally.is_closed()
    }
}

impl Iterator for Listener {
    type Item = Message;

    fn next(&mut self) -> Option<Message> {
        let mut devices = Vec::new();
        loop {
            match self.incoming.pop().ok()? {
                Passed::Note(noted) => return Some(Message::Note(noted)),
                Passed::Tick(tick) => {
                    let contacts = (0..tick.contacts).map_while(|_| match self.incoming.pop() {
                        Ok(Passed::Contact(contact)) => Some(contact),
                        _ => None,
                    });
                    let contacts = contacts.collect();
                    let bodies = (0..tick.bodies).map_while(|_| match self.incoming.pop() {
                        Ok(Passed::Body(body)) => Some(body),
                        _ => None,
                    });
                    return Some(Message::Tick(tick, contacts, bodies.collect(), devices));
                }
                Passed::Device(device) => devices.push(device),
                // Unreachable: the tick before them has taken them.
                Passed::Contact(_) | Passed::Body(_) => {}
            }
        }
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        self.tally.turn_deaf();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tick(sequence: u64) -> Tick {
        Tick {
            sequence,
            ..Tick::default()
        }
    }

    fn contacts(number: u32) -> Vec<ContactTick> {
        let contact = |penetration| ContactTick {
            penetration,
            ..ContactTick::default()
        };
        (0..number).map(|at| contact(f64::from(at))).collect()
    }

    /// Returns the number of each tick and the penetrations of its contacts.
    fn messages(listener: &mut Listener) -> Vec<(u64, Vec<f64>)> {
        listener
            .map(|messages| match messages {
                Message::Tick(tick, contacts, _, _) => {
                    assert_eq!(tick.contacts as usize, contacts.len());
                    let depths = contacts.iter().map(|contact| contact.penetration);
                    (tick.sequence, depths.collect())
                }
                Message::Note(noted) => panic!("{noted:?}"),
            })
            .collect()
    }

    #[test]
    fn a_tick_finds_room_with_all_its_contacts_or_not_at_all() {
        // Capacity for a tick with three contacts, a tick with one, and one more item.
        let (mut tap, mut listener) = tap(4);
        tap.tick(&tick(0), &contacts(3));
        tap.tick(&tick(1), &contacts(1));
        tap.tick(&tick(2), &contacts(2));
        assert_eq!((tap.lost(), tap.counted().ticks), (1, 3));
        tap.tick(&tick(3), &contacts(0));
        tap.tick(&tick(4), &contacts(1));
        assert_eq!(tap.lost(), 2);
        let expected = [(0, vec![0.0, 1.0, 2.0]), (1, vec![0.0]), (3, vec![])];
        assert_eq!(messages(&mut listener), expected);
        // There is free capacity, and the ring now wraps around within a tick.
        tap.tick(&tick(5), &contacts(3));
        assert_eq!(messages(&mut listener), [(5, vec![0.0, 1.0, 2.0])]);
        // Each of several devices needs capacity too, and arrives with its tick.
        let device = DeviceTick {
            devices: 2,
            ..DeviceTick::default()
        };
        tap.tick_with_devices(&tick(8), &contacts(6), &[], &[device; 2]);
        tap.tick_with_devices(&tick(9), &contacts(5), &[], &[device; 2]);
        let Some(Message::Tick(model_of, of_contacts, _, devices)) = listener.next() else {
            panic!("there was room for the second");
        };
        assert_eq!(
            (model_of.sequence, of_contacts.len(), devices.len()),
            (9, 5, 2)
        );
        assert_eq!((tap.lost(), listener.next().is_none()), (3, true));
        // More contacts than the capacity are lost also by a waiting tap.
        let mut tap = tap.waiting();
        tap.tick(&tick(6), &contacts(8));
        assert_eq!((tap.lost(), messages(&mut listener)), (4, vec![]));
    }
}
