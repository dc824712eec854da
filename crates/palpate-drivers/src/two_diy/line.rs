//! Transmission to the board, shared by the loop, its supervisor and a sender thread that may block.
//!
//! A packet that is interrupted by another one makes the board misread both, and the board keeps its previous torque.
//! All bytes therefore go through one mutex; its holder first completes a partly sent packet. Callers use `try_lock`
//! and return if it is taken. A zero-torque command must not be lost: if it cannot be sent at once, it becomes
//! *pending*, and a thread beside the loop sends it as soon as the port accepts it.
//!
//! The watchdog process writes to the same port if this process has been silent for too long. Its bytes may fall
//! between two parts of a packet of this process. After such a write, the driver discards the rest of its packet and
//! first sends one that a board accepts in the middle of any other.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, TryLockError};
use std::thread::{Builder, JoinHandle, Thread};
use std::time::{Duration, Instant};

use palpate_rt::watchdog::{Unguarded, Watchdog};

use super::layout::Layout;
use super::packet::{SETUP_LENGTH, STATE_LENGTH, release, state};
use crate::serial::{Gone, Serial};

/// Wait interval of the sender thread; bounds the time until it ends.
const WAIT: Duration = Duration::from_millis(20);

/// Time limit for sending a pending zero-torque command when the line is closed.
const LAST_TRY: Duration = Duration::from_secs(2);

/// Reason for not sending.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unsent {
    /// Another thread is sending, usually a zero-torque command.
    Busy,
    /// The port accepts no bytes.
    Full,
    /// The port is gone.
    Gone,
    /// The watchdog process is lost, so torques are not sent.
    Unguarded(Unguarded),
}

impl From<Gone> for Unsent {
    fn from(Gone: Gone) -> Self {
        Self::Gone
    }
}

/// State of the outgoing data.
#[derive(Debug)]
struct Outgoing {
    layout: Layout,
    /// Torques of the last STATE of which sending began `[N m]`.
    held: [f32; 2],
    /// A partly sent packet.
    begun: [u8; SETUP_LENGTH],
    /// Its unsent range.
    rest: std::ops::Range<usize>,
    /// Whether that packet is a STATE, which the board answers.
    is_answered: bool,
    watchdog: Option<Watchdog>,
    /// Whether the watchdog process was notified that a torque may be on.
    is_armed: bool,
}

#[derive(Debug)]
struct Shared {
    serial: Serial,
    outgoing: Mutex<Outgoing>,
    /// Number of zero-torque requests, and how many of them are fulfilled. Counters rather than a flag: a request that
    /// arrives while an earlier one is being fulfilled stays pending.
    wished: AtomicU64,
    met: AtomicU64,
    /// STATE packets that were sent completely; the board answers each once.
    requests: AtomicU64,
    /// Number of zero-torque commands sent because one was pending.
    cuts: AtomicU64,
    /// Number of zero-torque commands by the watchdog process.
    watchdog_cuts: AtomicU64,
    /// Reason for the loss of the watchdog process.
    unguarded: OnceLock<Unguarded>,
    closing: AtomicBool,
}

/// The loop's handle of the line.
#[derive(Debug)]
pub struct Line {
    shared: Arc<Shared>,
    waiting: Option<JoinHandle<()>>,
}

/// The supervisor's handle of the line.
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
                watchdog: None,
                is_armed: false,
            }),
            wished: AtomicU64::new(0),
            met: AtomicU64::new(0),
            requests: AtomicU64::new(0),
            cuts: AtomicU64::new(0),
            watchdog_cuts: AtomicU64::new(0),
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

    /// Returns the number of STATE packets sent.
    pub fn requests(&self) -> u64 {
        self.shared.requests.load(Ordering::Acquire)
    }

    /// Returns how often sending a pending zero-torque command began.
    pub fn cuts(&self) -> u64 {
        self.shared.cuts.load(Ordering::Acquire)
    }

    /// Installs a watchdog process, which is notified before each torque is sent. The torque must be zero.
    pub fn guard(&self, watchdog: Watchdog) {
        self.shared.locked().watchdog = Some(watchdog);
    }

    /// Ends the watchdog process, because the board holds zero torque or is unreachable. Waits until the process has
    /// ended.
    pub fn dismiss_watchdog(&self) {
        // Release the mutex before waiting.
        let watchdog = self.shared.locked().watchdog.take();
        if let Some(watchdog) = watchdog {
            watchdog.dismiss();
        }
    }

    /// Checks whether the watchdog process has cut the torque.
    pub fn listen_to_watchdog(&self) {
        // A pending zero-torque command is sent by the next packet or the sender thread.
        if let Ok(mut outgoing) = self.shared.try_locked() {
            let _ = self.shared.heed_watchdog(&mut outgoing);
        }
    }

    /// Returns the number of zero-torque commands by the watchdog process.
    pub fn watchdog_cuts(&self) -> u64 {
        self.shared.watchdog_cuts.load(Ordering::Acquire)
    }

    /// Returns the reason for the loss of the watchdog process, if it is lost.
    pub fn unguarded(&self) -> Option<Unguarded> {
        self.shared.unguarded.get().copied()
    }

    /// Requests the angles. The packet repeats the held torques, or zero after a cut.
    pub fn ask(&self) -> Result<(), Unsent> {
        self.shared.with_outgoing(|shared, outgoing| {
            let held = outgoing.held;
            shared.send_state(outgoing, held)
        })
    }

    /// Commands torques `[N m]` and returns the current [`cuts`](Self::cuts). While that counter keeps this value, no
    /// zero-torque command has followed these torques.
    pub fn command(&self, torques: [f32; 2]) -> Result<u64, Unsent> {
        self.shared.with_outgoing(|shared, outgoing| {
            shared.send_state(outgoing, torques)?;
            // Read under the lock: a pending zero-torque command has been sent before.
            Ok(shared.cuts.load(Ordering::Acquire))
        })
    }

    /// Sends a packet that the board does not answer, and waits up to `limit`. Not for use in the loop.
    pub fn send(&self, packet: &[u8], limit: Duration) -> Result<(), Unsent> {
        self.patiently(limit, || {
            self.shared
                .with_outgoing(|shared, outgoing| shared.begin(outgoing, packet, false))
        })
    }

    /// Commands torques, and waits for the port up to `limit`. Not for use in the loop.
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
    /// Sends a pending zero-torque command, for at most `LAST_TRY`.
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
        // An undismissed watchdog process keeps trying. Drop it here, because a supervisor may keep `shared` alive.
        let watchdog = self.shared.locked().watchdog.take();
        drop(watchdog);
    }
}

impl Cutter {
    /// Commands zero torque as soon as possible, and returns immediately.
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
    /// Requests zero torque without sending it.
    pub fn want(&self) {
        self.shared.wished.fetch_add(1, Ordering::AcqRel);
    }

    /// Returns whether a cut is pending.
    pub fn is_wanted(&self) -> bool {
        self.shared.is_wanted()
    }

    /// Holds the lock, as a sending thread does.
    pub fn hold(&self) -> impl Sized + '_ {
        self.shared.outgoing.lock().unwrap()
    }
}

impl Shared {
    /// Runs `send` on the outgoing state, unless another thread holds it. A pending zero-torque command is sent first.
    fn with_outgoing<T>(
        &self,
        send: impl FnOnce(&Self, &mut Outgoing) -> Result<T, Unsent>,
    ) -> Result<T, Unsent> {
        let mut outgoing = self.try_locked()?;
        self.heed_watchdog(&mut outgoing)?;
        self.send_wanted(&mut outgoing)?;
        send(self, &mut outgoing)
    }

    /// Locks the outgoing state without waiting.
    fn try_locked(&self) -> Result<MutexGuard<'_, Outgoing>, Unsent> {
        match self.outgoing.try_lock() {
            Ok(outgoing) => Ok(outgoing),
            // A thread that panicked while sending leaves a packet and its rest, as every partial write does.
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => Err(Unsent::Busy),
        }
    }

    /// Locks the outgoing state. For callers that may wait.
    fn locked(&self) -> MutexGuard<'_, Outgoing> {
        self.outgoing.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Applies the actions of the watchdog process. After a cut, the driver sends zero torque again with a packet that
    /// the board accepts in any state, because one of its own packets may have been interrupted. If the watchdog
    /// process is lost, it requests zero torque.
    fn heed_watchdog(&self, outgoing: &mut Outgoing) -> Result<(), Unsent> {
        let Some(watchdog) = &outgoing.watchdog else {
            return Ok(());
        };
        match watchdog.has_cut() {
            Ok(false) => Ok(()),
            Ok(true) => {
                outgoing.rest = 0..0;
                outgoing.is_answered = false;
                outgoing.held = [0.0; 2];
                self.cuts.fetch_add(1, Ordering::AcqRel);
                self.watchdog_cuts.fetch_add(1, Ordering::AcqRel);
                let packet = release(&outgoing.layout);
                self.begin(outgoing, &packet, true)
            }
            Err(how) => {
                self.lose_watchdog(outgoing, how);
                Ok(())
            }
        }
    }

    fn lose_watchdog(&self, outgoing: &mut Outgoing, how: Unguarded) {
        // It is dropped later, by a thread that may wait. The caller holds the lock, so there is no race.
        if self.unguarded.set(how).is_ok() {
            self.wished.fetch_add(1, Ordering::AcqRel);
        }
        outgoing.is_armed = false;
    }

    /// Notifies the watchdog process before torques are sent.
    fn announce(&self, outgoing: &mut Outgoing) -> Result<(), Unsent> {
        if let Some(how) = self.unguarded.get() {
            return Err(Unsent::Unguarded(*how));
        }
        let Some(watchdog) = &outgoing.watchdog else {
            return Ok(());
        };
        if let Err(how) = watchdog.force() {
            self.lose_watchdog(outgoing, how);
            return Err(Unsent::Unguarded(how));
        }
        outgoing.is_armed = true;
        Ok(())
    }

    /// Notifies the watchdog process that the torque is zero, unless it already knows.
    fn stand_down(&self, outgoing: &mut Outgoing) {
        if let Some(watchdog) = outgoing.watchdog.as_ref().filter(|_| outgoing.is_armed) {
            if let Err(how) = watchdog.none() {
                self.lose_watchdog(outgoing, how);
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

    /// Returns whether a zero-torque command is pending.
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

    /// Completes the packet begun before and sends this one, in one write if the port accepts it.
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

    /// Body of the sender thread, which may wait for the port.
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
                // The port is gone; a zero-torque command does not need the watchdog process.
                Err(Unsent::Gone | Unsent::Unguarded(_)) => std::thread::sleep(WAIT),
            }
        }
    }
}

#[cfg(test)]
#[path = "line_tests.rs"]
mod tests;
