//! The motor of an emulated drive, with its handle in a hand.

use std::time::{Duration, Instant};

use palpate_testbed::InvalidParameter;
use palpate_testbed::actuator::Actuator;
use palpate_testbed::device::DevicePlant as _;
use palpate_testbed::held_mass::HeldMass;

use super::Settings;

/// Time that the drive needs to start its motor.
const STARTS_IN: Duration = Duration::from_millis(2);
/// Damping of a motor whose watchdog does not switch it off `[N m s]`, and its largest torque `[N m]`.
const DAMPING: (f64, f64) = (0.02, 5.0);

/// State of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// The motor is off.
    Stopped,
    /// It is on from this time on.
    Starting(Instant),
    /// It holds the torque.
    Running,
    /// The watchdog has acted.
    TimedOut,
    /// A fault with its code.
    Failed(u8),
    /// Another mode.
    Other,
}

#[derive(Debug)]
pub struct Motor {
    axis: HeldMass,
    actuator: Actuator,
    travel: f64,
    torque: f64,
    pub mode: Mode,
    /// Time without a command after which the watchdog acts.
    pub watchdog: Option<Duration>,
    fed: Instant,
    /// Whether the watchdog damps the motor instead of switching it off.
    pub damps: bool,
    /// Turns that the encoder has lost.
    pub lost_turns: f64,
    pub was_cut: bool,
    moved_until: Option<Instant>,
}

impl Motor {
    pub fn new(settings: &Settings) -> Result<Self, InvalidParameter> {
        let axis = HeldMass::new(settings.mass, settings.hand.clone())?
            .with_friction(settings.friction, 0.0)?
            .starting_at(settings.start, 0.0)?;
        Ok(Self {
            axis,
            actuator: Actuator::new(settings.amplifier)?,
            travel: settings.travel,
            torque: 0.0,
            mode: Mode::Stopped,
            watchdog: None,
            fed: Instant::now(),
            damps: false,
            lost_turns: 0.0,
            was_cut: false,
            moved_until: None,
        })
    }

    /// Simulates up to `now`; the watchdog acts at its own time.
    pub fn move_on(&mut self, now: Instant) {
        let Some(from) = self.moved_until else { return };
        if let Mode::Starting(at) = self.mode
            && at <= now
        {
            self.mode = Mode::Running;
        }
        let is_on = matches!(self.mode, Mode::Running | Mode::Starting(_));
        let over = self.watchdog.map(|limit| self.fed + limit);
        let over = over.filter(|over| is_on && *over < now);
        if let Some(over) = over {
            self.hold(over.saturating_duration_since(from));
            self.was_cut |= self.torque != 0.0;
            self.torque = 0.0;
            self.mode = Mode::TimedOut;
        }
        let begun = over.map_or(from, |over| over.max(from));
        if self.mode == Mode::TimedOut && self.damps {
            let (damping, most) = DAMPING;
            let speed = self.axis.velocity() / self.travel * std::f64::consts::TAU;
            self.torque = (-damping * speed).clamp(-most, most);
        }
        self.hold(now.saturating_duration_since(begun));
        self.moved_until = Some(now.max(from));
    }

    fn hold(&mut self, duration: Duration) {
        let force = self.torque * std::f64::consts::TAU / self.travel;
        // The testbed expects the force on the object, which has the opposite sign.
        self.actuator
            .drive(&mut self.axis, -force, duration.as_secs_f64());
    }

    /// Feeds the watchdog. The handle moves from the first command on.
    pub fn feed(&mut self, now: Instant) {
        self.moved_until.get_or_insert(now);
        self.fed = now;
    }

    /// Switches the motor on.
    pub fn start(&mut self, now: Instant) {
        if self.mode == Mode::Stopped {
            self.mode = Mode::Starting(now + STARTS_IN);
        }
    }

    /// Switches the motor off, and clears a fault.
    pub fn stop(&mut self) {
        self.mode = Mode::Stopped;
        self.torque = 0.0;
    }

    /// Commands a torque `[N m]`, which a motor that is off does not hold.
    pub fn command(&mut self, torque: f64) {
        if self.mode == Mode::Running {
            self.torque = torque;
        }
    }

    pub fn fail(&mut self, code: u8) {
        self.mode = Mode::Failed(code);
        self.torque = 0.0;
    }

    pub fn leave_mode(&mut self) {
        self.mode = Mode::Other;
        self.torque = 0.0;
    }

    pub fn torque(&self) -> f64 {
        self.torque
    }

    pub fn position(&self) -> f64 {
        self.axis.position()
    }

    /// Returns position `[turns]` and velocity `[turns/s]` of the encoder.
    pub fn turns(&self) -> [f64; 2] {
        [
            self.axis.position() / self.travel + self.lost_turns,
            self.axis.velocity() / self.travel,
        ]
    }

    pub fn is_off(&self) -> bool {
        self.mode == Mode::Stopped
    }
}
