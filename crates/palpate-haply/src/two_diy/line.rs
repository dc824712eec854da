//! The way to the board, shared by the loop, its supervisor and a thread that waits in their place.
//!
//! A packet that is cut in two by another one makes the board misread both, and it keeps the torque
//! that it had. So there is one place from which bytes go out: whoever has it completes what was
//! begun before anything else. Nobody waits for it: `try_lock` is an exchange of a number, and who
//! does not get it goes away. No force is different: it must go out. If it cannot at once, it is
//! *wanted*, and a thread beside the loop sends it at the first moment at which the port takes it.
//!
//! A guardian, another process, writes to the same port when this one has been silent for too long.
//! What it writes may come between two parts of a packet of this side. So whoever finds that the
//! guardian has written drops the rest of a packet, and first sends one that a board understands in
//! the middle of any other.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, TryLockError};
use std::thread::{Builder, JoinHandle, Thread};
use std::time::{Duration, Instant};

use palpate_rt::guardian::{Guardian, Unguarded};

use super::layout::Layout;
use super::packet::{SETUP_LENGTH, STATE_LENGTH, release, state};
use super::serial::{Gone, Serial};

/// How long the waiting thread waits at a time, so that it can be ended.
const WAIT: Duration = Duration::from_millis(20);

/// How long no force that is wanted is tried for when the line is closed.
const LAST_TRY: Duration = Duration::from_secs(2);

/// Why nothing was sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unsent {
    /// Somebody else is sending no force right now.
    Busy,
    /// The port takes no bytes.
    Full,
    /// The port is gone.
    Gone,
    /// There is no guardian any more, and so no torque goes out.
    Unguarded(Unguarded),
}

impl From<Gone> for Unsent {
    fn from(Gone: Gone) -> Self {
        Self::Gone
    }
}

/// What is on its way out.
#[derive(Debug)]
struct Outgoing {
    layout: Layout,
    /// Torques of the last STATE that was begun `[N m]`.
    held: [f32; 2],
    /// A packet of which a part has gone out.
    begun: [u8; SETUP_LENGTH],
    /// The rest of it.
    rest: std::ops::Range<usize>,
    /// Whether that packet is a STATE, which is answered.
    is_answered: bool,
    guardian: Option<Guardian>,
    /// Whether the guardian has been told that a torque may be on.
    is_armed: bool,
}

#[derive(Debug)]
struct Shared {
    serial: Serial,
    outgoing: Mutex<Outgoing>,
    /// How often no force was wished for, and how many of these wishes are met. Counted, so that a
    /// wish that comes while one is being met is another one, and none ever looks met before it is.
    wished: AtomicU64,
    met: AtomicU64,
    /// STATE packets that went out whole: each is answered once.
    requests: AtomicU64,
    /// How often no force was sent because it was wanted.
    cuts: AtomicU64,
    /// How often a guardian has sent no force.
    guardian_cuts: AtomicU64,
    /// How the guardian that there was got lost.
    unguarded: OnceLock<Unguarded>,
    closing: AtomicBool,
}

/// The loop's end of the line.
#[derive(Debug)]
pub struct Line {
    shared: Arc<Shared>,
    waiting: Option<JoinHandle<()>>,
}

/// The supervisor's end.
#[derive(Clone, Debug)]
pub struct Cutter {
    shared: Arc<Shared>,
    waiting: Option<Thread>,
}

impl Line {
    pub fn new(serial: Serial, layout: Layout) -> std::io::Result<Self> {
        let shared = Arc::new(Shared {
            serial,
            outgoing: Mutex::new(Outgoing {
                layout,
                held: [0.0; 2],
                begun: [0; SETUP_LENGTH],
                rest: 0..0,
                is_answered: false,
                guardian: None,
                is_armed: false,
            }),
            wished: AtomicU64::new(0),
            met: AtomicU64::new(0),
            requests: AtomicU64::new(0),
            cuts: AtomicU64::new(0),
            guardian_cuts: AtomicU64::new(0),
            unguarded: OnceLock::new(),
            closing: AtomicBool::new(false),
        });
        let theirs = Arc::clone(&shared);
        let waiting = Builder::new()
            .name("palpate 2diy".to_owned())
            .spawn(move || theirs.send_what_is_wanted())?;
        Ok(Self {
            shared,
            waiting: Some(waiting),
        })
    }

    pub fn serial(&self) -> &Serial {
        &self.shared.serial
    }

    pub fn cutter(&self) -> Cutter {
        Cutter {
            shared: Arc::clone(&self.shared),
            waiting: self.waiting.as_ref().map(|thread| thread.thread().clone()),
        }
    }

    /// STATE packets that went out.
    pub fn requests(&self) -> u64 {
        self.shared.requests.load(Ordering::Acquire)
    }

    /// How often no force was begun to be sent because it was wanted.
    pub fn cuts(&self) -> u64 {
        self.shared.cuts.load(Ordering::Acquire)
    }

    /// From now on `guardian` hears of every torque before it goes out. No torque may be on.
    pub fn guard(&self, guardian: Guardian) {
        self.shared.locked().guardian = Some(guardian);
    }

    /// Ends the guardian: the board is known to hold no torque, or cannot be told any more. Waits until
    /// it is gone.
    pub fn dismiss_guardian(&self) {
        // Not waited for with the line in hand.
        let guardian = self.shared.locked().guardian.take();
        if let Some(guardian) = guardian {
            guardian.dismiss();
        }
    }

    /// Finds out what the guardian has done.
    pub fn listen_to_guardian(&self) {
        // Nothing but that: what is wanted goes out with the next packet, and before it.
        if let Ok(mut outgoing) = self.shared.try_locked() {
            let _ = self.shared.heed_guardian(&mut outgoing);
        }
    }

    /// How often a guardian has sent no force.
    pub fn guardian_cuts(&self) -> u64 {
        self.shared.guardian_cuts.load(Ordering::Acquire)
    }

    /// How the guardian that there was got lost, if it did.
    pub fn unguarded(&self) -> Option<Unguarded> {
        self.shared.unguarded.get().copied()
    }

    /// Asks for the angles, repeating the torques that are held: none, if somebody has cut them.
    pub fn ask(&self) -> Result<(), Unsent> {
        self.shared.with_outgoing(|shared, outgoing| {
            let held = outgoing.held;
            shared.send_state(outgoing, held)
        })
    }

    /// Commands torques `[N m]`. What [`cuts`](Self::cuts) was then: as long as it is that, nobody
    /// has sent no force after these torques.
    pub fn command(&self, torques: [f32; 2]) -> Result<u64, Unsent> {
        self.shared.with_outgoing(|shared, outgoing| {
            shared.send_state(outgoing, torques)?;
            // Here, where nobody else can send: the cut that was waiting has gone out before.
            Ok(shared.cuts.load(Ordering::Acquire))
        })
    }

    /// Sends a packet that is not answered, with another layout from then on; waits up to `limit`.
    /// Not for the loop.
    pub fn send(&self, packet: &[u8], limit: Duration) -> Result<(), Unsent> {
        self.patiently(limit, || {
            self.shared
                .with_outgoing(|shared, outgoing| shared.begin(outgoing, packet, false))
        })
    }

    /// Commands torques, and waits for room up to `limit`. Not for the loop.
    pub fn command_patiently(&self, torques: [f32; 2], limit: Duration) -> Result<(), Unsent> {
        self.patiently(limit, || self.command(torques).map(|_| ()))
    }

    fn patiently(
        &self,
        limit: Duration,
        mut send: impl FnMut() -> Result<(), Unsent>,
    ) -> Result<(), Unsent> {
        let begun = Instant::now();
        loop {
            let sent = send();
            if matches!(sent, Ok(()) | Err(Unsent::Gone)) || begun.elapsed() >= limit {
                return sent;
            }
            if sent == Err(Unsent::Full) {
                self.shared.serial.wait_writable(Duration::from_millis(1));
            } else {
                std::thread::sleep(Duration::from_micros(100));
            }
        }
    }
}

impl Line {
    /// Sends no force if it is wanted, for as long as anybody can be expected to wait.
    fn send_what_is_left(&self) {
        let begun = Instant::now();
        while self.shared.is_wanted() && begun.elapsed() < LAST_TRY {
            let sent = self
                .shared
                .with_outgoing(|shared, outgoing| shared.send_wanted(outgoing));
            match sent {
                Ok(()) => {}
                Err(Unsent::Full) => self.shared.serial.wait_writable(WAIT),
                Err(Unsent::Busy) => std::thread::sleep(Duration::from_micros(100)),
                Err(Unsent::Gone | Unsent::Unguarded(_)) => return,
            }
        }
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        self.send_what_is_left();
        self.shared.closing.store(true, Ordering::Release);
        if let Some(waiting) = self.waiting.take() {
            waiting.thread().unpark();
            let _ = waiting.join();
        }
        // One that was not dismissed tries on. Here, for a supervisor may hold on to the rest.
        let guardian = self.shared.locked().guardian.take();
        drop(guardian);
    }
}

impl Cutter {
    /// Sends no force at the first moment possible, and returns at once.
    pub fn cut(&self) {
        self.shared.wished.fetch_add(1, Ordering::AcqRel);
        let sent = self
            .shared
            .with_outgoing(|shared, outgoing| shared.send_wanted(outgoing));
        if sent.is_err()
            && let Some(thread) = &self.waiting
        {
            thread.unpark();
        }
    }
}

#[cfg(test)]
impl Cutter {
    /// As a cut that has got no farther yet.
    pub fn want(&self) {
        self.shared.wished.fetch_add(1, Ordering::AcqRel);
    }

    /// Whether a cut has not gone out yet.
    pub fn is_wanted(&self) -> bool {
        self.shared.is_wanted()
    }

    /// As somebody who is sending.
    pub fn hold(&self) -> impl Sized + '_ {
        self.shared.outgoing.lock().unwrap()
    }
}

impl Shared {
    /// Does something with what goes out, unless somebody else does. What is wanted goes first.
    fn with_outgoing<T>(
        &self,
        send: impl FnOnce(&Self, &mut Outgoing) -> Result<T, Unsent>,
    ) -> Result<T, Unsent> {
        let mut outgoing = self.try_locked()?;
        self.heed_guardian(&mut outgoing)?;
        self.send_wanted(&mut outgoing)?;
        send(self, &mut outgoing)
    }

    /// What goes out, unless somebody else has it.
    fn try_locked(&self) -> Result<MutexGuard<'_, Outgoing>, Unsent> {
        match self.outgoing.try_lock() {
            Ok(outgoing) => Ok(outgoing),
            // Whoever panicked while it sent has left a packet and its rest, as everybody does.
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => Err(Unsent::Busy),
        }
    }

    /// What goes out, for whoever may wait.
    fn locked(&self) -> MutexGuard<'_, Outgoing> {
        self.outgoing.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes in what the guardian has done. Where it has sent no force the board is told so once more,
    /// from wherever it is: a packet of ours may have been cut in two. Where it is gone no force is
    /// wanted.
    fn heed_guardian(&self, outgoing: &mut Outgoing) -> Result<(), Unsent> {
        let Some(guardian) = &outgoing.guardian else {
            return Ok(());
        };
        match guardian.has_cut() {
            Ok(false) => Ok(()),
            Ok(true) => {
                outgoing.rest = 0..0;
                outgoing.is_answered = false;
                outgoing.held = [0.0; 2];
                self.cuts.fetch_add(1, Ordering::AcqRel);
                self.guardian_cuts.fetch_add(1, Ordering::AcqRel);
                let packet = release(&outgoing.layout);
                self.begin(outgoing, &packet, true)
            }
            Err(how) => {
                self.lose_guardian(outgoing, how);
                Ok(())
            }
        }
    }

    fn lose_guardian(&self, outgoing: &mut Outgoing, how: Unguarded) {
        // Dropped where somebody may wait for it. Whoever is here has what goes out, and is alone.
        if self.unguarded.set(how).is_ok() {
            self.wished.fetch_add(1, Ordering::AcqRel);
        }
        outgoing.is_armed = false;
    }

    /// Tells the guardian of torques that are about to go out.
    fn announce(&self, outgoing: &mut Outgoing) -> Result<(), Unsent> {
        if let Some(how) = self.unguarded.get() {
            return Err(Unsent::Unguarded(*how));
        }
        let Some(guardian) = &outgoing.guardian else {
            return Ok(());
        };
        if let Err(how) = guardian.force() {
            self.lose_guardian(outgoing, how);
            return Err(Unsent::Unguarded(how));
        }
        outgoing.is_armed = true;
        Ok(())
    }

    /// Tells the guardian that no torque is on, if it may think otherwise.
    fn stand_down(&self, outgoing: &mut Outgoing) {
        if let Some(guardian) = outgoing.guardian.as_ref().filter(|_| outgoing.is_armed) {
            if let Err(how) = guardian.none() {
                self.lose_guardian(outgoing, how);
            }
            outgoing.is_armed = false;
        }
    }

    fn send_wanted(&self, outgoing: &mut Outgoing) -> Result<(), Unsent> {
        let wished = self.wished.load(Ordering::Acquire);
        if wished != self.met.load(Ordering::Acquire) {
            self.cuts.fetch_add(1, Ordering::AcqRel);
            self.send_state(outgoing, [0.0; 2])?;
            self.met.store(wished, Ordering::Release);
        }
        Ok(())
    }

    /// Whether no force is to be sent, and has not been.
    fn is_wanted(&self) -> bool {
        self.wished.load(Ordering::Acquire) != self.met.load(Ordering::Acquire)
    }

    fn send_state(&self, outgoing: &mut Outgoing, torques: [f32; 2]) -> Result<(), Unsent> {
        let packet: [u8; STATE_LENGTH] = state(&outgoing.layout, torques);
        self.complete(outgoing)?;
        let is_none = torques == [0.0; 2];
        if !is_none {
            self.announce(outgoing)?;
        }
        outgoing.held = torques;
        self.begin(outgoing, &packet, true)?;
        if is_none {
            self.stand_down(outgoing);
        }
        Ok(())
    }

    /// Sends a packet in one piece, if the port takes it in one; completes what was begun before.
    fn begin(&self, outgoing: &mut Outgoing, packet: &[u8], answered: bool) -> Result<(), Unsent> {
        self.complete(outgoing)?;
        let written = self.serial.write(packet)?;
        if written == 0 {
            return Err(Unsent::Full);
        }
        for (place, byte) in outgoing.begun.iter_mut().zip(packet) {
            *place = *byte;
        }
        outgoing.is_answered = answered;
        outgoing.rest = written..packet.len();
        self.complete(outgoing)
    }

    fn complete(&self, outgoing: &mut Outgoing) -> Result<(), Unsent> {
        let rest = outgoing.begun.get(outgoing.rest.clone()).unwrap_or(&[]);
        if !rest.is_empty() {
            outgoing.rest.start += self.serial.write(rest)?;
            if !outgoing.rest.is_empty() {
                return Err(Unsent::Full);
            }
        }
        if std::mem::take(&mut outgoing.is_answered) {
            self.requests.fetch_add(1, Ordering::AcqRel);
        }
        Ok(())
    }

    /// The thread that waits where nobody else may.
    fn send_what_is_wanted(&self) {
        while !self.closing.load(Ordering::Acquire) {
            if !self.is_wanted() {
                std::thread::park();
                continue;
            }
            let sent = self.with_outgoing(|shared, outgoing| shared.send_wanted(outgoing));
            match sent {
                Ok(()) => {}
                Err(Unsent::Full) => self.serial.wait_writable(WAIT),
                Err(Unsent::Busy) => std::thread::sleep(Duration::from_micros(100)),
                // Nobody is there to hear it; no force needs no guardian.
                Err(Unsent::Gone | Unsent::Unguarded(_)) => std::thread::sleep(WAIT),
            }
        }
    }
}

#[cfg(test)]
#[path = "line_tests.rs"]
mod tests;
