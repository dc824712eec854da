//! A drive as a device with one axis.

use std::f64::consts::TAU;
use std::time::{Duration, Instant};

use palpate_device::clock::Clock;
use palpate_device::{
    Capabilities, Connection, Device, DeviceError, DeviceErrorKind, Pose, Wrench,
};

use super::axis::{Axis, Condition, Heard};
use super::wire::{Unsent, Wire};
use crate::prepared::on_axes;

/// An answer that is missing for longer than this is lost.
const LOST_AFTER: Duration = Duration::from_millis(50);
/// The drive is reported as gone after this time without an answer and this number of failed reads.
const GONE_AFTER: Duration = Duration::from_secs(1);
const GONE_AFTER_READS: u32 = 20;
/// Limits of the speed of the handle `[m/s]` and of the drive `[turns/s]`, of which the larger one holds.
const LARGEST_SPEED: f64 = 10.0;
const LARGEST_RATE: f64 = 20.0;
/// Longest time at that speed. Later a hand moves at this part of it.
const LONGEST_DASH: Duration = Duration::from_millis(10);
const HAND: f64 = 0.2;
/// Tolerance of a position `[turns]`.
const SLACK: f64 = 0.01;
/// Time in which the drive starts after its watchdog has acted.
const STARTS_WITHIN: Duration = Duration::from_millis(500);
/// Time to send the last command.
const LAST_TRY: Duration = Duration::from_millis(200);

/// A motor drive: one axis, along which the handle travels.
///
/// [`read`](Device::read) asks for the position, repeats the held torque, and waits for the answer of this request;
/// [`write`](Device::write) commands a torque. When this is dropped, the last command switches the motor off. If the loop
/// stalls, this program is killed or stopped, or the cable is out, the drive takes its torque off by its own watchdog.
pub struct Drive<A: Axis, C: Clock> {
    pub(super) clock: C,
    pub(super) capabilities: Capabilities,
    pub(super) axis: A,
    pub(super) wire: Wire,
    /// Travel for a turn `[m]`.
    pub(super) travel: f64,
    /// Position at which the coordinate is 0 `[turns]`.
    pub(super) zero: f64,
    pub(super) patience: Duration,
    pub(super) round_trip: Duration,
    /// Last commanded torque `[N m]`.
    pub(super) torque: f32,
    /// Time since which the drive holds no commanded torques.
    pub(super) unready_since: Option<Instant>,
    pub(super) was_cut: bool,
    pub(super) has_jumped: bool,
    /// Last position `[turns]`, with its time.
    pub(super) position: f64,
    pub(super) positioned: Instant,
    pub(super) asked: Instant,
    pub(super) unanswered: u32,
    /// Time of the last answer, and the number of failed reads since.
    pub(super) heard: Instant,
    pub(super) failures: u32,
    pub(super) connection: Connection,
    /// First lasting failure.
    pub(super) reason: Option<DeviceError>,
    pub(super) tell: Box<dyn Fn(String) + Send>,
}

impl<A: Axis, C: Clock> std::fmt::Debug for Drive<A, C> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Drive")
            .field("capabilities", &self.capabilities)
            .field("torque", &self.torque)
            .finish_non_exhaustive()
    }
}

const GONE: DeviceError = DeviceError {
    kind: DeviceErrorKind::Disconnected,
    what: "the serial port is gone; the drive's watchdog takes its torque off",
};
const SILENT: DeviceError = DeviceError {
    kind: DeviceErrorKind::Disconnected,
    what: "the drive has not answered for a second; its watchdog takes its torque off",
};
const FULL: DeviceError = DeviceError {
    kind: DeviceErrorKind::Interrupted,
    what: "the serial port accepts no bytes; the drive's watchdog takes its torque off",
};

impl<A: Axis, C: Clock> Drive<A, C> {
    /// Returns the time without a command after which the drive takes its torque off.
    #[must_use]
    pub fn watchdog(&self) -> Duration {
        self.axis.watchdog()
    }

    /// Returns the time from a request to its answer at the opening. A loop needs a longer period.
    #[must_use]
    pub fn round_trip(&self) -> Duration {
        self.round_trip
    }

    /// Returns the last position `[turns]`.
    #[must_use]
    pub fn turns(&self) -> f64 {
        self.position
    }

    fn refused(&mut self, what: &'static str) -> DeviceError {
        let error = DeviceError::new(DeviceErrorKind::Refused, what);
        self.reason.get_or_insert(error);
        error
    }

    /// Returns the error for a missing sample.
    fn missing(&mut self, what: &'static str) -> DeviceError {
        self.failures = self.failures.saturating_add(1);
        if self.heard.elapsed() < GONE_AFTER || self.failures < GONE_AFTER_READS {
            return DeviceError::new(DeviceErrorKind::NothingNew, what);
        }
        self.reason.get_or_insert(SILENT);
        SILENT
    }

    fn unsent(&mut self, unsent: Unsent) -> DeviceError {
        match unsent {
            Unsent::Full => {
                self.connection.untaken += 1;
                FULL
            }
            Unsent::Gone => {
                self.reason.get_or_insert(GONE);
                GONE
            }
        }
    }

    /// Takes all received lines, and returns the answer to the last request if `asked` in this read.
    fn listen(&mut self, asked: bool) -> Result<Option<(f64, Condition)>, DeviceError> {
        let (axis, connection, unanswered) =
            (&mut self.axis, &mut self.connection, &mut self.unanswered);
        let mut answer = None;
        let heard = self.wire.lines(|line| match axis.hear(line) {
            Heard::Part => {}
            Heard::State(state) => {
                *unanswered = 0;
                if asked {
                    answer = Some((state.position, state.condition));
                } else {
                    connection.late += 1;
                }
            }
            Heard::Late => connection.late += 1,
            Heard::Unreadable => connection.unreadable += 1,
        });
        heard.map_err(|_| self.unsent(Unsent::Gone))?;
        Ok(answer)
    }

    /// Asks for the state, and waits for its answer.
    fn ask(&mut self) -> Result<(f64, Condition), DeviceError> {
        self.listen(false)?;
        if self.unanswered >= A::MOST_UNANSWERED {
            if self.asked.elapsed() < LOST_AFTER {
                return Err(self.missing("an answer of the drive is missing"));
            }
            self.connection.lost += u64::from(self.unanswered);
            self.unanswered = 0;
        }
        let (axis, torque) = (&mut self.axis, self.torque);
        let sent = self.wire.send(|text| axis.ask(torque, text));
        sent.map_err(|unsent| self.unsent(unsent))?;
        self.asked = Instant::now();
        self.unanswered += 1;
        loop {
            if let Some(answer) = self.listen(true)? {
                self.heard = Instant::now();
                self.failures = 0;
                return Ok(answer);
            }
            let left = self.patience.saturating_sub(self.asked.elapsed());
            if left.is_zero() {
                return Err(self.missing("the drive did not answer in time"));
            }
            self.wire.wait(left);
        }
    }

    /// Rejects a position after an implausible jump, and all later ones: the encoder has lost its count.
    fn accept(&mut self, position: f64) -> Result<(), DeviceError> {
        if !position.is_finite() {
            self.connection.unreadable += 1;
            let what = "the drive returns a position that is no number";
            return Err(DeviceError::new(DeviceErrorKind::Interrupted, what));
        }
        let now = Instant::now();
        let since = now - self.positioned;
        let moving = since.min(LONGEST_DASH).as_secs_f64() + HAND * since.as_secs_f64();
        let rate = (LARGEST_SPEED / self.travel.abs()).max(LARGEST_RATE);
        self.has_jumped |= (position - self.position).abs() > rate * moving + SLACK;
        if self.has_jumped {
            return Err(self.refused(
                "the position has jumped: the encoder has lost its count; check it, and open the drive again",
            ));
        }
        self.position = position;
        self.positioned = now;
        Ok(())
    }

    /// Acts on the condition of the drive. Its position is valid while it starts.
    fn obey(&mut self, condition: Condition) -> Result<(), DeviceError> {
        if condition == Condition::Ready {
            self.unready_since = None;
            return Ok(());
        }
        let since = *self.unready_since.get_or_insert_with(Instant::now);
        if condition == Condition::TimedOut {
            self.was_cut |= self.torque != 0.0;
            let axis = &mut self.axis;
            let sent = self.wire.send(|text| axis.resume(text));
            sent.map_err(|unsent| self.unsent(unsent))?;
        }
        self.torque = 0.0;
        if let Condition::Failed(what) = condition {
            return Err(self.refused(what));
        }
        if since.elapsed() > STARTS_WITHIN {
            let what = "the drive does not start";
            return Err(DeviceError::new(DeviceErrorKind::Interrupted, what));
        }
        Ok(())
    }
}

impl<A: Axis, C: Clock> Device for Drive<A, C> {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        let (position, condition) = self.ask()?;
        let time = self.clock.now();
        self.obey(condition)?;
        self.accept(position)?;
        self.connection.samples += 1;
        let along = (position - self.zero) * self.travel;
        Ok(Pose::at([along, 0.0, 0.0], time))
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        let lever = self.travel / TAU;
        let [along, ..] = on_axes(&self.capabilities, wrench).force;
        #[allow(
            clippy::cast_possible_truncation,
            reason = "the wire has 32 bits, and the force is limited"
        )]
        let torque = if self.unready_since.is_none() && !self.has_jumped {
            (along * lever) as f32
        } else {
            0.0
        };
        self.connection.untaken += u64::from(torque == 0.0 && along != 0.0);
        self.torque = torque;
        let axis = &mut self.axis;
        let sent = self.wire.send(|text| axis.command(torque, text));
        if let Err(unsent) = sent {
            self.torque = 0.0;
            return Err(self.unsent(unsent));
        }
        if !wrench.is_finite() {
            let what = "the force of the command is no number";
            return Err(DeviceError::new(DeviceErrorKind::Refused, what));
        }
        Ok(Wrench::of_force([f64::from(torque) / lever, 0.0, 0.0]))
    }

    fn was_cut(&mut self) -> bool {
        std::mem::take(&mut self.was_cut)
    }

    fn connection(&self) -> Option<Connection> {
        Some(self.connection)
    }
}

impl<A: Axis, C: Clock> Drop for Drive<A, C> {
    fn drop(&mut self) {
        let axis = &mut self.axis;
        let _ = self.wire.flush(LAST_TRY);
        let _ = self.wire.send(|text| axis.stop(text));
        let stopped = self.wire.flush(LAST_TRY);
        let name = &self.capabilities.name;
        if let Some(reason) = self.reason {
            (self.tell)(format!("{name}: {reason}"));
        } else if stopped.is_err() {
            (self.tell)(format!(
                "warning: {name} did not take the last command, which switches its motor off; its watchdog does so"
            ));
        }
    }
}
