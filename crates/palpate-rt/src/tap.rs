//! From the loop's thread to whoever writes down what it does, without ever waiting.

use std::io;
use std::iter;
use std::sync::Arc;
use std::time::Duration;

use palpate_record::recording::{BodyTick, ContactTick, DeviceTick, Flags, LoopTime, Tick};

use crate::note::{Ending, Note, Noted};
use crate::tally::{Counts, Tally};

/// What a loop tells.
// A tick is most of what comes.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug)]
pub enum Told {
    /// A tick, with all its contacts, the bodies of a world that move, and the devices of a loop that has several: none
    /// where it has one.
    Tick(Tick, Vec<ContactTick>, Vec<BodyTick>, Vec<DeviceTick>),
    /// Something that happened at one.
    Note(Noted),
}

/// What finds room on the way, or does not. A tick comes behind its devices, if it has several, and is followed by its
/// contacts and its bodies: they find room together, or none of them does.
// A box would be an allocation in the loop.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Copy, Debug)]
enum Passed {
    Tick(Tick),
    Contact(ContactTick),
    Body(BodyTick),
    Device(DeviceTick),
    Note(Noted),
}

/// What a loop has counted of what it told. It comes by another way than the ticks, so nothing of it is
/// lost where they find no room.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counted {
    /// Ticks that it made.
    pub ticks: u64,
    /// Notes that it told.
    pub notes: u64,
    /// Ticks and notes that found no room.
    pub lost: u64,
    /// Ticks at whose end a trip of the safety kept the motors off.
    pub motors_off: u64,
    /// How long the loop ran, and for how much of that no force was delivered; zero where nobody said.
    pub time: LoopTime,
    /// Why the loop ended; `None` while it runs, or where nobody said.
    pub ending: Option<Ending>,
}

impl From<Counts> for Counted {
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

/// The loop's end: it drops what finds no room, and counts it.
#[derive(Debug)]
pub struct Tap {
    out: rtrb::Producer<Passed>,
    tally: Arc<Tally>,
    names: Names,
    waits: bool,
}

/// The listener's end: what was told and has not been listened to. It never waits; its end may be
/// followed by more.
#[derive(Debug)]
pub struct Listener {
    incoming: rtrb::Consumer<Passed>,
    tally: Arc<Tally>,
    names: Names,
}

/// A tap with room for `capacity` ticks of one contact that have not been listened to. A note, each
/// further contact, each body and each of several devices take half of the room of such a tick; a tick with more of them than fit into all
/// of the room is always lost.
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

/// A tap as [`tap`] makes it, where the system may not have memory for so much.
///
/// # Errors
/// It has not: [`io::ErrorKind::OutOfMemory`].
pub(crate) fn tap_if_there_is_memory(capacity: usize) -> io::Result<(Tap, Listener)> {
    let items = capacity.saturating_mul(2);
    // A ring takes its memory without asking, and a program without memory ends.
    let mut memory = Vec::<Passed>::new();
    let is_there = memory.try_reserve_exact(items).is_ok();
    // A compiler may leave out memory that nobody looks at.
    std::hint::black_box(memory.as_mut_ptr());
    drop(memory);
    if !is_there {
        let bytes = items.saturating_mul(size_of::<Passed>());
        return Err(io::Error::new(
            io::ErrorKind::OutOfMemory,
            format!(
                "room for {capacity} ticks takes {bytes} bytes, and the system has no memory for that"
            ),
        ));
    }
    Ok(tap(capacity))
}

impl Tap {
    /// Tells a tick and its contacts. Its number says how many ticks have been made; where there is no room
    /// for it and all its contacts, the whole tick is lost.
    pub fn tick(&mut self, tick: &Tick, contacts: &[ContactTick]) {
        self.tick_with_bodies(tick, contacts, &[]);
    }

    /// Tells a tick as [`tick`](Self::tick) does, with the bodies of the world that move.
    pub fn tick_with_bodies(&mut self, tick: &Tick, contacts: &[ContactTick], bodies: &[BodyTick]) {
        self.tick_with_devices(tick, contacts, bodies, &[]);
    }

    /// Tells a tick as [`tick_with_bodies`](Self::tick_with_bodies) does, with each device of a loop that has several.
    pub fn tick_with_devices(
        &mut self,
        tick: &Tick,
        contacts: &[ContactTick],
        bodies: &[BodyTick],
        devices: &[DeviceTick],
    ) {
        self.tally.made(tick.sequence.saturating_add(1));
        if tick.flags.has(Flags::SAFETY_TRIPPED) {
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

    /// Tells the names of the devices of a loop that has several, in their order; for before its first tick, and once. A loop
    /// does it by itself; whoever passes on what a loop has told does it with [`Listener::device_names`].
    pub fn name_devices(&self, names: Vec<String>) {
        // The first ones stay.
        let _ = self.names.set(names);
    }

    /// Tells how long the loop ran so far, and for how much of that no force was delivered.
    pub fn ran(&mut self, time: LoopTime) {
        self.tally.ran(time.lasted, time.motors_off);
    }

    /// Tells something that happened.
    pub fn note(&mut self, noted: &Noted) {
        self.tally.noted();
        self.push(1, iter::once(Passed::Note(*noted)));
    }

    /// Says how many ticks and notes there were, how many ticks ended with the motors off, and for how
    /// long, where not all of them were told here. What found no room is counted as it was.
    pub fn count(&mut self, counted: &Counted) {
        self.tally.set(&Counts {
            ticks: counted.ticks,
            notes: counted.notes,
            motors_off: counted.motors_off,
            lasted: counted.time.lasted,
            motors_off_for: counted.time.motors_off,
            ..Counts::default()
        });
    }

    /// What was counted so far.
    #[must_use]
    pub fn counted(&self) -> Counted {
        self.tally.counts().into()
    }

    /// Nothing more comes, since the loop has ended. A tap that is dropped says that nothing more
    /// comes, but not why.
    pub fn end(self, ending: Ending) {
        self.tally.ended(ending.number());
    }

    /// How many ticks and notes found no room.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.tally.counts().lost
    }

    /// The same tap, waiting for room instead of losing anything: for a loop that runs as fast as it
    /// can, on a clock that stands still meanwhile. Never for one with a motor.
    #[must_use]
    pub fn waiting(mut self) -> Self {
        self.waits = true;
        self
    }

    #[expect(
        clippy::disallowed_methods,
        reason = "yields only where the clock stands still meanwhile"
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

/// The names of several devices, once they are told.
#[expect(
    clippy::disallowed_types,
    reason = "the loop writes it before its first tick; its listener reads it"
)]
type Names = Arc<std::sync::OnceLock<Vec<String>>>;

/// Tells what a loop does, if somebody listens, with the number of its tick and the time since its start.
#[derive(Debug, Default)]
pub(crate) struct Teller {
    pub tap: Option<Tap>,
    /// Number of the tick.
    pub sequence: u64,
    /// When the loop began.
    pub started: Duration,
}

impl Teller {
    /// Tells something that happened at `now`; of one device where the loop has several.
    pub fn note(&mut self, now: Duration, device: Option<u32>, note: Note) {
        if let Some(tap) = &mut self.tap {
            tap.note(&Noted {
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
    /// How many ticks and notes found no room. A recording shows by its numbers which ticks they were.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.tally.counts().lost
    }

    /// What the loop has counted so far; all of it once [`is_closed`](Self::is_closed) was true.
    #[must_use]
    pub fn counted(&self) -> Counted {
        self.tally.counts().into()
    }

    /// The names of the devices of a loop that has several, in their order; none where it has one.
    #[must_use]
    pub fn device_names(&self) -> &[String] {
        self.names.get().map_or(&[], Vec::as_slice)
    }

    /// Whether nothing more will be told; what was may still be here. Asked before the last item is
    /// taken, it says that there is no other.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.tally.is_closed()
    }
}

impl Iterator for Listener {
    type Item = Told;

    fn next(&mut self) -> Option<Told> {
        let mut devices = Vec::new();
        loop {
            match self.incoming.pop().ok()? {
                Passed::Note(noted) => return Some(Told::Note(noted)),
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
                    return Some(Told::Tick(tick, contacts, bodies.collect(), devices));
                }
                Passed::Device(device) => devices.push(device),
                // They stand behind their tick, which has taken them.
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

    /// Number of the tick, and the penetrations of its contacts.
    fn told(listener: &mut Listener) -> Vec<(u64, Vec<f64>)> {
        listener
            .map(|told| match told {
                Told::Tick(tick, contacts, _, _) => {
                    assert_eq!(tick.contacts as usize, contacts.len());
                    let depths = contacts.iter().map(|contact| contact.penetration);
                    (tick.sequence, depths.collect())
                }
                Told::Note(noted) => panic!("{noted:?}"),
            })
            .collect()
    }

    #[test]
    fn a_tick_finds_room_with_all_its_contacts_or_not_at_all() {
        // Room for a tick with three contacts, a tick with one, and one thing more.
        let (mut tap, mut listener) = tap(4);
        tap.tick(&tick(0), &contacts(3));
        tap.tick(&tick(1), &contacts(1));
        tap.tick(&tick(2), &contacts(2));
        assert_eq!((tap.lost(), tap.counted().ticks), (1, 3));
        tap.tick(&tick(3), &contacts(0));
        tap.tick(&tick(4), &contacts(1));
        assert_eq!(tap.lost(), 2);
        let expected = [(0, vec![0.0, 1.0, 2.0]), (1, vec![0.0]), (3, vec![])];
        assert_eq!(told(&mut listener), expected);
        // There is room again, and now the ring begins anew within a tick.
        tap.tick(&tick(5), &contacts(3));
        assert_eq!(told(&mut listener), [(5, vec![0.0, 1.0, 2.0])]);
        // Each of several devices takes its room too, and comes with its tick.
        let device = DeviceTick {
            devices: 2,
            ..DeviceTick::default()
        };
        tap.tick_with_devices(&tick(8), &contacts(6), &[], &[device; 2]);
        tap.tick_with_devices(&tick(9), &contacts(5), &[], &[device; 2]);
        let Some(Told::Tick(told_of, of_contacts, _, devices)) = listener.next() else {
            panic!("there was room for the second");
        };
        assert_eq!(
            (told_of.sequence, of_contacts.len(), devices.len()),
            (9, 5, 2)
        );
        assert_eq!((tap.lost(), listener.next().is_none()), (3, true));
        // More contacts than there is room for are lost, whoever listens.
        let mut tap = tap.waiting();
        tap.tick(&tick(6), &contacts(8));
        assert_eq!((tap.lost(), told(&mut listener)), (4, vec![]));
    }
}
