//! Emulated motor drives, moteus and ODrive: protocol, motor and hand, behind a pseudo-terminal or a Unix socket.
//!
//! The motor moves a mass in a hand, in real time from the first line on. A drive takes its torque off by its own watchdog.
//! Driver and emulator share no code.

mod moteus;
mod motor;
mod odrive;
mod timed_fault;

use std::fmt;
use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use palpate_testbed::actuator::ActuatorParams;
use palpate_testbed::hand::Hand;

use crate::emulator::inverse3::holding;
use crate::emulator::port::{Port, PortSettings};
use motor::Motor;
pub use timed_fault::{NoTimedFault, TimedFault};

/// Makers of drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Maker {
    /// moteus behind a CAN adapter.
    Moteus,
    /// ODrive 3.x.
    Odrive,
}

/// Settings of an emulator.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Maker.
    pub maker: Maker,
    /// Number of the drive, or of its axis.
    pub number: u8,
    /// Travel of the handle for a turn `[m]`.
    pub travel: f64,
    /// Moved mass at the handle, with the rotor's share `[kg]`.
    pub mass: f64,
    /// Viscous friction at the handle `[N s/m]`.
    pub friction: f64,
    /// Position of the handle at the start `[m]`.
    pub start: f64,
    /// The hand.
    pub hand: Hand,
    /// Gain and lag of the torque.
    pub amplifier: ActuatorParams,
    /// The port.
    pub port: PortSettings,
}

impl Settings {
    /// Returns the settings of a handle of 0.1 kg on a pulley with a radius of 0.02 m, at rest in a hand, behind a
    /// pseudo-terminal. The number is the maker's usual one.
    #[must_use]
    pub fn new(maker: Maker) -> Self {
        Self {
            maker,
            number: match maker {
                Maker::Moteus => 1,
                Maker::Odrive => 0,
            },
            travel: std::f64::consts::TAU * 0.02,
            mass: 0.1,
            friction: 0.5,
            start: 0.0,
            hand: holding(0.0, 100.0, 5.0),
            amplifier: ActuatorParams::default(),
            port: PortSettings::Terminal { link: None },
        }
    }
}

/// Injected fault.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Fault {
    /// For this time, lines are lost in both directions.
    Silence(Duration),
    /// The drive leaves its mode without an error, until it is stopped.
    Mode,
    /// The drive fails with this code, until it is stopped or cleared.
    Code(u8),
    /// The encoder loses this number of turns.
    Jump(f64),
    /// The next answer loses its second half and its end.
    TornLine,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Silence(time) => write!(f, "lines are lost for {} s", time.as_secs_f64()),
            Self::Mode => f.write_str("the drive leaves its mode"),
            Self::Code(code) => write!(f, "the drive fails with code {code}"),
            Self::Jump(turns) => write!(f, "the encoder loses {turns} turns"),
            Self::TornLine => f.write_str("the next answer is torn"),
        }
    }
}

/// Protocol of an emulated drive.
trait Firmware: Send {
    /// Takes a line, and returns the answers, each with its end.
    fn line(&mut self, line: &str, motor: &mut Motor, now: Instant) -> Vec<String>;
}

struct State {
    motor: Motor,
    silent_until: Option<Instant>,
    tears: bool,
    /// Number of received lines.
    lines: u64,
    path: PathBuf,
}

/// A running emulator; dropping it ends it.
pub struct Emulator {
    state: Arc<Mutex<State>>,
    ending: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl fmt::Debug for Emulator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Emulator")
            .field("path", &self.path())
            .finish_non_exhaustive()
    }
}

fn lock(state: &Mutex<State>) -> MutexGuard<'_, State> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Emulator {
    /// Starts an emulator.
    ///
    /// # Errors
    /// A parameter is out of range, or the system provides no port or no thread.
    pub fn start(settings: &Settings) -> io::Result<Self> {
        let motor = Motor::new(settings).map_err(io::Error::other)?;
        let port = Port::open(&settings.port)?;
        let state = Arc::new(Mutex::new(State {
            motor,
            silent_until: None,
            tears: false,
            lines: 0,
            path: port.path().to_owned(),
        }));
        let firmware: Box<dyn Firmware> = match settings.maker {
            Maker::Moteus => Box::new(moteus::Moteus::new(settings.number)),
            Maker::Odrive => Box::new(odrive::Odrive::new(settings.number)),
        };
        let ending = Arc::new(AtomicBool::new(false));
        let (theirs, ends) = (Arc::clone(&state), Arc::clone(&ending));
        let thread = std::thread::Builder::new()
            .name("emulated drive".to_owned())
            .spawn(move || run(&theirs, port, firmware, &ends))?;
        Ok(Self {
            state,
            ending,
            thread: Some(thread),
        })
    }

    /// Returns the path of the port.
    #[must_use]
    pub fn path(&self) -> PathBuf {
        lock(&self.state).path.clone()
    }

    /// Injects a fault.
    pub fn inject(&self, fault: Fault) {
        let mut state = lock(&self.state);
        let now = Instant::now();
        match fault {
            Fault::Silence(time) => state.silent_until = Some(now + time),
            Fault::Mode => state.motor.leave_mode(),
            Fault::Code(code) => state.motor.fail(code),
            Fault::Jump(turns) => state.motor.lost_turns += turns,
            Fault::TornLine => state.tears = true,
        }
    }

    /// Returns the torque that the motor holds now `[N m]`.
    #[must_use]
    pub fn torque(&self) -> f64 {
        let mut state = lock(&self.state);
        state.motor.move_on(Instant::now());
        state.motor.torque()
    }

    /// Returns the true position of the handle `[m]`.
    #[must_use]
    pub fn position(&self) -> f64 {
        lock(&self.state).motor.position()
    }

    /// Returns whether the watchdog has taken a torque off.
    #[must_use]
    pub fn was_cut(&self) -> bool {
        lock(&self.state).motor.was_cut
    }

    /// Returns whether the motor is switched off.
    #[must_use]
    pub fn is_off(&self) -> bool {
        lock(&self.state).motor.is_off()
    }

    /// Returns the number of received lines.
    #[must_use]
    pub fn lines(&self) -> u64 {
        lock(&self.state).lines
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

/// Maximum sleep time of the thread.
const REST: Duration = Duration::from_micros(500);
/// Silence after which another driver may open the port.
const QUIET: Duration = Duration::from_millis(100);

fn run(state: &Mutex<State>, mut port: Port, mut firmware: Box<dyn Firmware>, ending: &AtomicBool) {
    let mut came: Vec<u8> = Vec::new();
    let mut active = Instant::now();
    while !ending.load(Ordering::Acquire) {
        port.wait(REST);
        let before = came.len();
        port.read(&mut came);
        let now = Instant::now();
        if came.len() > before {
            active = now;
        } else if active.elapsed() > QUIET {
            port.let_in();
            active = now;
        }
        let mut state = lock(state);
        state.motor.move_on(now);
        let is_silent = state.silent_until.is_some_and(|until| now < until);
        while let Some(end) = came.iter().position(|byte| *byte == b'\n') {
            let line: Vec<u8> = came.drain(..=end).collect();
            if is_silent {
                continue;
            }
            state.lines += 1;
            let line = String::from_utf8_lossy(&line);
            for mut answer in firmware.line(line.trim(), &mut state.motor, now) {
                if answer.len() > 10 && std::mem::take(&mut state.tears) {
                    answer.truncate(answer.len() / 2);
                }
                port.write(answer.as_bytes());
            }
        }
    }
}
