//! Opening of a drive.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use palpate_device::clock::Clock;
use palpate_device::{Capabilities, Connection};
use rustix::io::Errno;

use super::axis::{Axis, Condition, Heard};
use super::device::Drive;
use super::wire::{PortGone, Wire};

/// Time limit for the drive to be ready.
const READY_WITHIN: Duration = Duration::from_secs(2);
/// Shortest and longest time of the watchdog.
pub const SHORTEST_WATCHDOG: Duration = Duration::from_millis(2);
const LONGEST_WATCHDOG: Duration = Duration::from_secs(1);

/// Port, mechanism and times of a drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Serial port.
    pub port: PathBuf,
    /// Travel of the handle for a turn of the drive `[m]`: 2 pi times the radius of a pulley or lever, the pitch of a
    /// screw, or 2 pi for a coordinate in radians with a torque in place of the force. Negative: opposite direction.
    pub travel: f64,
    /// Position of the drive at which the coordinate is 0 `[turns]`.
    pub zero: f64,
    /// Largest torque `[N m]`.
    pub largest_torque: f64,
    /// Longest time to wait for an answer in a tick.
    pub patience: Duration,
    /// Time without a command after which the drive takes its torque off.
    pub silence: Duration,
}

impl Options {
    /// Returns the options for a pulley or lever of this radius `[m]`.
    #[must_use]
    pub fn new(port: &Path, radius: f64, largest_torque: f64, period: Duration) -> Self {
        Self {
            port: port.to_owned(),
            travel: std::f64::consts::TAU * radius,
            zero: 0.0,
            largest_torque,
            patience: (period / 2).min(Duration::from_millis(20)),
            silence: 4 * period,
        }
    }

    /// Returns the travel per angle of the drive `[m/rad]`.
    pub(super) fn lever(&self) -> f64 {
        self.travel / std::f64::consts::TAU
    }
}

/// Reason why a drive cannot be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpenError {
    /// A setting is out of range.
    #[error("{what} is {value}; allowed: {allowed}")]
    Setting {
        /// The setting.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Its range.
        allowed: &'static str,
    },
    /// The port cannot be opened.
    #[error("{}: {error}", .port.display())]
    Port {
        /// The port.
        port: PathBuf,
        /// Error of the system.
        error: Errno,
    },
    /// The port is gone.
    #[error("the serial port is gone")]
    Gone,
    /// Nothing answers.
    #[error("{0} does not answer: check its power, its number and its wires")]
    Silent(String),
    /// It is not prepared for a loop.
    #[error("{name} {why}")]
    NotReady {
        /// The drive.
        name: String,
        /// Reason.
        why: String,
    },
}

impl From<PortGone> for OpenError {
    fn from(PortGone: PortGone) -> Self {
        Self::Gone
    }
}

fn within(
    what: &'static str,
    value: f64,
    is_fine: bool,
    allowed: &'static str,
) -> Result<(), OpenError> {
    if is_fine {
        return Ok(());
    }
    Err(OpenError::Setting {
        what,
        value,
        allowed,
    })
}

impl<A: Axis, C: Clock> Drive<A, C> {
    /// Opens a drive, sets its watchdog and waits until it is ready, with zero torque. `tell` receives a message at the
    /// end if the drive failed.
    ///
    /// # Errors
    /// A setting is out of range, the port cannot be opened, or the drive does not answer or is not ready.
    pub fn open(
        mut axis: A,
        options: &Options,
        clock: C,
        tell: impl Fn(String) + Send + 'static,
    ) -> Result<Self, OpenError> {
        let (travel, torque) = (options.travel, options.largest_torque);
        let is_travel = (1e-5..=10.0).contains(&travel.abs());
        within(
            "the travel per turn",
            travel,
            is_travel,
            "0.00001 to 10 [m], or its negative",
        )?;
        let (zero, allowed) = (options.zero, "-1000000 to 1000000 [turns]");
        within("the zero", zero, zero.abs() <= 1e6, allowed)?;
        let is_torque = (1e-4..=100.0).contains(&torque);
        within(
            "the largest torque",
            torque,
            is_torque,
            "0.0001 to 100 [N m]",
        )?;
        let silence = options.silence.as_secs_f64();
        let is_silence = (SHORTEST_WATCHDOG..=LONGEST_WATCHDOG).contains(&options.silence);
        within("the watchdog's time", silence, is_silence, "0.002 to 1 [s]")?;
        let mut wire = Wire::open(&options.port).map_err(|error| OpenError::Port {
            port: options.port.clone(),
            error,
        })?;
        #[allow(clippy::cast_possible_truncation, reason = "checked above")]
        let largest = torque as f32;
        let prepared = axis.prepare(&mut wire, largest, options.silence);
        let ready = prepared.and_then(|()| when_ready(&mut axis, &mut wire));
        let (position, round_trip) = match ready {
            Ok(found) => found,
            Err(error) => {
                let _ = wire.exchange(|text| axis.stop(text), Duration::ZERO, |_| Some(()));
                return Err(error);
            }
        };
        let capabilities = Capabilities {
            largest_force: Some(torque / options.lever().abs()),
            ..Capabilities::unknown(&axis.name(), 1)
        };
        let now = Instant::now();
        Ok(Self {
            clock,
            capabilities,
            axis,
            wire,
            travel,
            zero: options.zero,
            patience: options.patience,
            round_trip,
            torque: 0.0,
            unready_since: None,
            was_cut: false,
            has_jumped: false,
            position,
            positioned: now,
            asked: now,
            unanswered: 0,
            heard: now,
            failures: 0,
            connection: Connection::default(),
            reason: None,
            tell: Box::new(tell),
        })
    }
}

/// Asks until the drive is ready. Returns its position `[turns]` and the time from the last request to its answer.
fn when_ready<A: Axis>(axis: &mut A, wire: &mut Wire) -> Result<(f64, Duration), OpenError> {
    let begun = Instant::now();
    let mut last = None;
    while begun.elapsed() < READY_WITHIN {
        let mut question = super::text::Text::default();
        if last == Some(Condition::TimedOut) {
            axis.resume(&mut question);
        }
        axis.ask(0.0, &mut question);
        let asked = Instant::now();
        let answer = wire.exchange(
            |text| *text = question,
            Duration::from_millis(100),
            |line| match axis.hear(line) {
                Heard::State(state) => Some(state),
                _ => None,
            },
        )?;
        let Some(state) = answer else { continue };
        if state.condition == Condition::Ready && state.position.is_finite() {
            return Ok((state.position, asked.elapsed()));
        }
        last = Some(state.condition);
        if matches!(last, Some(Condition::Failed(_))) {
            break;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    let name = axis.name();
    let why = match last {
        None => return Err(OpenError::Silent(name)),
        Some(Condition::Failed(why)) => why,
        Some(Condition::Ready) => "gives no position",
        Some(Condition::Starting | Condition::TimedOut) => "does not start",
    };
    Err(OpenError::NotReady {
        name,
        why: why.to_owned(),
    })
}
