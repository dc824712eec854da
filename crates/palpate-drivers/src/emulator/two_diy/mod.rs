//! Emulated 2DIY: board, arm and hand, behind a pseudo-terminal or a Unix socket.
//!
//! The board emulates the real firmware byte by byte, and holds its last torque as the real one does. The arm is the
//! testbed's pantograph with the geometry of the generation (its masses and friction are estimates, see `devices/`),
//! moved in real time. Driver and emulator share only the wiring tables.

mod arm;
mod firmware;
mod motor;
mod stepped;
mod timed_fault;

use std::collections::VecDeque;
use std::fmt;
use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

pub use arm::{Hand, Wiring};
pub use firmware::Did;
pub use stepped::SteppedTwoDiy;
pub use timed_fault::{FaultKind, NoTimedFault, TimedFault};

use crate::emulator::port::{Port, PortSettings, Usb};
use crate::two_diy::packet::REPLY_LENGTH;
use crate::two_diy::{Board, Generation};
use arm::Arm;
use firmware::{Firmware, Wire};
use palpate_testbed::actuator::ActuatorParams;

/// Settings of an emulator.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The arm.
    pub generation: Generation,
    /// The board.
    pub board: Board,
    /// Whether single late bytes read as 0xFF, as on the real boards; otherwise the board waits for them.
    pub strict: bool,
    /// Wiring of the motors.
    pub wiring: Wiring,
    /// Force on the handle.
    pub hand: Hand,
    /// Whether the hand grips the handle only after the device is opened, and returns the arm to the start pose when
    /// the cable is pulled, as a user does who knows the calibration pose.
    pub hand_waits: bool,
    /// Initial arm angles `[degrees]`; `None`: the generation's start pose.
    pub angles: Option<[f64; 2]>,
    /// Transmission times.
    pub usb: Usb,
    /// Gain and lag of the amplifiers, for the torque of each motor.
    pub amplifier: ActuatorParams,
    /// Port that a driver opens.
    pub port: PortSettings,
}

impl Settings {
    /// Creates settings for a generation on a board, as sold, without a hand or delays, and with ideal motors.
    #[must_use]
    pub fn new(generation: Generation, board: Board) -> Self {
        Self {
            generation,
            board,
            strict: true,
            wiring: Wiring::default(),
            hand: Hand::None,
            hand_waits: false,
            angles: None,
            usb: Usb::default(),
            amplifier: ActuatorParams::default(),
            port: PortSettings::Terminal { link: None },
        }
    }

    /// Returns the arm in its initial state.
    fn arm(&self) -> Result<Arm, String> {
        let layout = self.generation.layout();
        let sold = layout.joints.map(|joint| f64::from(joint.start));
        let mut arm = Arm::new(
            self.generation,
            self.board,
            self.wiring,
            self.hand,
            self.amplifier,
            self.angles.unwrap_or(sold),
        )?;
        if self.hand_waits {
            arm.wait();
        }
        Ok(arm)
    }
}

/// Injected fault.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Fault {
    /// The board stalls: it reads nothing and holds its torque.
    Stall(Duration),
    /// The cable is pulled for this time, and the board has no power meanwhile.
    Unplug(Duration),
    /// These bytes precede the next answer.
    Garbage(Vec<u8>),
    /// Half of the next answer is lost.
    HalfAnswer,
    /// The next answer is lost.
    NoAnswer,
    /// The next answer, and all after it, are delayed by this time.
    LateAnswer(Duration),
    /// The next answer is sent twice.
    TwoAnswers,
    /// The next answer has another device id.
    OtherId,
    /// The next answer contains a NaN angle.
    NotANumber,
    /// The encoders lose counts of this angle `[degrees]`.
    Slip(f64),
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stall(lasts) => write!(f, "the board stalls for {} s", lasts.as_secs_f64()),
            Self::Unplug(lasts) => {
                write!(f, "the cable is unplugged for {} s", lasts.as_secs_f64())
            }
            Self::Garbage(bytes) => {
                write!(f, "{} invalid bytes precede the next answer", bytes.len())
            }
            Self::HalfAnswer => f.write_str("half of the next answer is lost"),
            Self::NoAnswer => f.write_str("the next answer is lost"),
            Self::LateAnswer(by) => write!(f, "the next answer is late by {} s", by.as_secs_f64()),
            Self::TwoAnswers => f.write_str("the next answer is sent twice"),
            Self::OtherId => f.write_str("the next answer has another device id"),
            Self::NotANumber => f.write_str("the next answer contains a NaN angle"),
            Self::Slip(degrees) => write!(f, "the encoders slip by {degrees} degrees"),
        }
    }
}

/// Action of the board with its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Time.
    pub at: Instant,
    /// Action.
    pub did: Did,
    /// Torques that the motors hold afterwards, by joint `[N m]`.
    pub torques: [f64; 2],
}

/// Number of stored actions; the oldest are dropped.
const REMEMBERED: usize = 200_000;

#[derive(Debug)]
struct State {
    arm: Arm,
    faults: VecDeque<Fault>,
    seen: VecDeque<Seen>,
    path: PathBuf,
}

/// A running emulator; dropping it ends it.
#[derive(Debug)]
pub struct Emulator {
    state: Arc<Mutex<State>>,
    ending: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Emulator {
    /// Starts an emulator.
    ///
    /// # Errors
    /// The system provides no terminal or no thread, the arm cannot have these angles, or the amplifier parameters are
    /// invalid.
    pub fn start(settings: &Settings) -> io::Result<Self> {
        let arm = settings.arm().map_err(io::Error::other)?;
        let port = Port::open(&settings.port)?;
        let state = Arc::new(Mutex::new(State {
            arm,
            faults: VecDeque::new(),
            seen: VecDeque::new(),
            path: port.path().to_owned(),
        }));
        let ending = Arc::new(AtomicBool::new(false));
        let mut running = Running {
            state: Arc::clone(&state),
            settings: settings.clone(),
            port: Some(port),
            began: Instant::now(),
            at: Duration::ZERO,
            travelling: VecDeque::new(),
            incoming: VecDeque::new(),
            outgoing: VecDeque::new(),
            active: Instant::now(),
        };
        let ends = Arc::clone(&ending);
        let thread = std::thread::Builder::new()
            .name("emulated 2diy".to_owned())
            .spawn(move || running.run(&ends))?;
        Ok(Self {
            state,
            ending,
            thread: Some(thread),
        })
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the path of the port; it changes after an unplug, unless the port has a link.
    #[must_use]
    pub fn path(&self) -> PathBuf {
        self.state().path.clone()
    }

    /// Injects a fault.
    pub fn inject_faults(&self, fault: Fault) {
        self.state().faults.push_back(fault);
    }

    /// Returns whether every injected fault has begun.
    #[must_use]
    pub fn has_injected_fault(&self) -> bool {
        self.state().faults.is_empty()
    }

    /// Sets another hand.
    pub fn take_in_hand(&self, hand: Hand) {
        self.state().arm.hand = hand;
    }

    /// Returns the recorded actions of the board.
    #[must_use]
    pub fn seen(&self) -> Vec<Seen> {
        self.state().seen.iter().copied().collect()
    }

    /// Returns the torques that the motors hold, by joint `[N m]`.
    #[must_use]
    pub fn torques(&self) -> [f64; 2] {
        self.state().arm.torques()
    }

    /// Returns the true angles of the joints `[degrees]`.
    #[must_use]
    pub fn angles(&self) -> [f64; 2] {
        self.state().arm.angles()
    }

    /// Returns the true position of the end-point `[m]`.
    #[must_use]
    pub fn position(&self) -> [f64; 2] {
        self.state().arm.position()
    }

    /// Returns the effective mass of the arm in its current pose along the unit vector `direction` `[kg]`.
    #[must_use]
    pub fn effective_mass(&self, direction: [f64; 2]) -> f64 {
        self.state().arm.effective_mass(direction)
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        self.ending.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// The emulator's thread.
struct Running {
    state: Arc<Mutex<State>>,
    settings: Settings,
    port: Option<Port>,
    began: Instant,
    /// Time of the board's current action since the start. A delayed thread handles overdue events late, but with their
    /// own times, so the delay does not affect the arm.
    at: Duration,
    /// Bytes in transit to the board, with their arrival times.
    travelling: VecDeque<(Duration, Vec<u8>)>,
    incoming: VecDeque<u8>,
    /// Answers in transit, with their arrival times.
    outgoing: VecDeque<(Duration, Vec<u8>)>,
    /// Time of the last byte.
    active: Instant,
}

/// Maximum sleep time of the thread.
const REST: Duration = Duration::from_micros(500);
/// Timeout of the Arduino's `readBytes`.
const PATIENCE: Duration = Duration::from_secs(1);

impl Running {
    fn locked<T>(&self, look: impl FnOnce(&mut State) -> T) -> T {
        look(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn run(&mut self, ending: &AtomicBool) {
        let mut firmware = Firmware::new(self.settings.board, self.settings.strict);
        let mut still_until = Instant::now();
        let mut unplugged_until = None;
        while !ending.load(Ordering::Acquire) {
            let now = Instant::now();
            self.pass();
            match self.next_board_fault() {
                Some(Fault::Stall(duration)) => still_until = now + duration,
                Some(Fault::Unplug(duration)) => {
                    self.port = None;
                    self.travelling.clear();
                    self.incoming.clear();
                    self.outgoing.clear();
                    firmware = Firmware::new(self.settings.board, self.settings.strict);
                    let hand_waits = self.settings.hand_waits;
                    self.locked(|state| {
                        state.arm.lose_power();
                        if hand_waits {
                            state.arm.wait();
                        }
                    });
                    unplugged_until = Some(now + duration);
                }
                Some(Fault::Slip(degrees)) => {
                    self.locked(|state| state.arm.slipped += degrees / 360.0);
                }
                _ => {}
            }
            if unplugged_until.is_some_and(|until| now >= until)
                && let Ok(port) = Port::open(&self.settings.port)
            {
                unplugged_until = None;
                self.locked(|state| state.path = port.path().to_owned());
                self.port = Some(port);
            }
            if self.port.is_none() || now < still_until {
                // Bytes that arrive meanwhile stay unread.
                self.pass_to(self.began.elapsed());
                std::thread::sleep(REST);
                continue;
            }
            self.deliver();
            self.fill(self.rest());
            // A board that has just been opened has a whole packet to read; others may follow.
            for _ in 0..64 {
                let mut arm = Remote(Arc::clone(&self.state));
                let Some(did) = firmware.turn(self, &mut arm) else {
                    break;
                };
                let at = Instant::now();
                self.locked(|state| {
                    if state.seen.len() == REMEMBERED {
                        state.seen.pop_front();
                    }
                    if matches!(did, Did::Commanded(1..)) {
                        state.arm.opened();
                    }
                    let torques = state.arm.torques();
                    state.seen.push_back(Seen { at, did, torques });
                });
            }
        }
    }

    /// Returns the next fault if it concerns the board and not an answer.
    fn next_board_fault(&self) -> Option<Fault> {
        self.locked(|state| {
            let is_boards = |fault: &&Fault| {
                matches!(fault, Fault::Stall(_) | Fault::Unplug(_) | Fault::Slip(_))
            };
            state.faults.front().filter(is_boards)?;
            state.faults.pop_front()
        })
    }

    /// Advances the time to now, or to the next arrival of bytes.
    fn pass(&mut self) {
        let now = self.began.elapsed();
        let next = self.travelling.front().map_or(now, |(due, _)| *due);
        self.pass_to(now.min(next));
    }

    fn pass_to(&mut self, time: Duration) {
        self.at = self.at.max(time);
        let at = self.at;
        self.locked(|state| state.arm.move_to(at));
    }

    /// Returns the time until the next event, at most [`REST`].
    fn rest(&self) -> Duration {
        let due = |queue: &VecDeque<(Duration, Vec<u8>)>| queue.front().map(|(due, _)| *due);
        let next = due(&self.travelling)
            .into_iter()
            .chain(due(&self.outgoing))
            .min();
        next.map_or(REST, |due| {
            due.saturating_sub(self.began.elapsed()).min(REST)
        })
    }

    /// Reads the received bytes, waiting for them up to `limit`.
    fn fill(&mut self, limit: Duration) {
        let Some(port) = &mut self.port else { return };
        if self.incoming.is_empty() {
            port.wait(limit);
        }
        let mut came = Vec::new();
        port.read(&mut came);
        if !came.is_empty() {
            self.active = Instant::now();
            let due = self.settings.usb.arrival(self.began.elapsed());
            self.travelling.push_back((due, came));
        } else if self.active.elapsed() > Duration::from_millis(100) {
            port.let_in();
            self.active = Instant::now();
        }
        self.pass();
        let arrives = self
            .travelling
            .front()
            .is_some_and(|(due, _)| *due <= self.at);
        if self.incoming.is_empty()
            && arrives
            && let Some((_, bytes)) = self.travelling.pop_front()
        {
            self.incoming.extend(bytes);
        }
    }

    /// Sends due answers.
    fn deliver(&mut self) {
        let now = self.began.elapsed();
        while self.outgoing.front().is_some_and(|(due, _)| *due <= now) {
            if let (Some((_, bytes)), Some(port)) = (self.outgoing.pop_front(), &mut self.port) {
                port.write(&bytes);
            }
        }
    }
}

impl Wire for Running {
    fn byte_now(&mut self) -> Option<u8> {
        if self.incoming.is_empty() {
            self.fill(Duration::ZERO);
        }
        self.incoming.pop_front()
    }

    fn byte_soon(&mut self) -> Option<u8> {
        let begun = Instant::now();
        while self.incoming.is_empty() && begun.elapsed() < PATIENCE {
            self.fill(self.rest());
            self.deliver();
        }
        self.incoming.pop_front()
    }

    fn send(&mut self, bytes: &[u8]) {
        let mut answer = bytes.to_vec();
        let mut due = self.settings.usb.arrival(self.at);
        // Answer faults apply to complete answers.
        let fault = (bytes.len() == REPLY_LENGTH)
            .then(|| self.locked(|state| state.faults.pop_front()))
            .flatten();
        match fault {
            Some(Fault::Garbage(mut garbage)) => {
                garbage.extend(&answer);
                answer = garbage;
            }
            Some(Fault::HalfAnswer) => answer.truncate(REPLY_LENGTH / 2),
            Some(Fault::NoAnswer) => return,
            Some(Fault::LateAnswer(by)) => due += by,
            Some(Fault::TwoAnswers) => answer.extend(bytes),
            Some(Fault::OtherId) => answer[0] = answer[0].wrapping_add(1),
            Some(Fault::NotANumber) => answer[1..5].fill(0xFF),
            Some(other) => self.locked(|state| state.faults.push_front(other)),
            None => {}
        }
        // The line preserves the order.
        if let Some((before, _)) = self.outgoing.back() {
            due = due.max(*before);
        }
        self.outgoing.push_back((due, answer));
        self.deliver();
    }
}

/// The arm, behind the lock that observers also use.
struct Remote(Arc<Mutex<State>>);

impl firmware::Ports for Remote {
    fn drive(&mut self, port: u8, level: bool, duty: f64) {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        state.arm.drive(port, level, duty);
    }

    fn revolutions(&mut self, port: u8) -> f64 {
        let mut state = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        state.arm.revolutions(port)
    }
}
