//! The emulated device: three axes of the handle, three of its wrist, and the gripper, each a mass in a hand.

use std::collections::VecDeque;
use std::time::Duration;

use palpate_device::Vector;
use palpate_testbed::InvalidParameter;
use palpate_testbed::actuator::Actuator;
use palpate_testbed::device::DevicePlant as _;
use palpate_testbed::held_mass::HeldMass;

use super::EmulatorOptions;
use crate::emulator::inverse3::holding;
use crate::force_dimension::Kind;

/// Unit of the firmware's watchdog.
const WATCHDOG_UNIT: Duration = Duration::from_micros(125);
/// Window of the reported velocities.
const WINDOW: Duration = Duration::from_millis(20);
/// Moment of inertia of the wrist `[kg m^2]`, and the spring and damper of the hand on it.
const WRIST: (f64, f64, f64) = (2e-4, 0.5, 0.01);
/// Mass of the gripper's fingers `[kg]`, their opening in the hand `[m]`, and its spring and damper.
const GRIPPER: (f64, f64, f64, f64) = (0.05, 0.015, 200.0, 3.0);

/// Command of the motors: force, torque, and force of the gripper.
pub type Command = [f64; 7];

/// Faults that last until they are taken back.
#[derive(Clone, Copy, Debug, Default)]
pub struct Trouble {
    /// The cable is out.
    pub is_unplugged: bool,
    /// Number of next reads without a new sample.
    pub stale_reads: u32,
    /// A larger force along an axis saturates its motor `[N]`.
    pub saturates_above: Option<f64>,
    /// Positions are NaN.
    pub is_nan: bool,
}

#[derive(Debug)]
pub struct EmulatedDevice {
    pub kind: Kind,
    pub trouble: Trouble,
    pub status: [i32; 17],
    pub has_watchdog: bool,
    pub watchdog: u8,
    pub has_gravity_compensation: bool,
    pub is_open: bool,
    /// Whether the watchdog has taken a force off.
    pub was_cut: bool,
    pub limits: [f64; 2],
    mass: f64,
    axes: [HeldMass; 7],
    motors: [Actuator; 7],
    command: Command,
    commanded: Duration,
    moved_until: Option<Duration>,
    /// Positions of the last window, with their times.
    recent: VecDeque<(Duration, Vector)>,
}

impl EmulatedDevice {
    pub fn new(options: &EmulatorOptions) -> Result<Self, InvalidParameter> {
        let body = &options.body;
        let axis = |number: usize| {
            if number < 3 {
                return HeldMass::new(body.mass, body.hands[number].clone())?
                    .with_friction(body.friction, 0.0)?
                    .starting_at(body.start[number], 0.0);
            }
            let (inertia, stiffness, damping) = WRIST;
            let (mass, gap, spring, damper) = GRIPPER;
            match number {
                6 => HeldMass::new(mass, holding(gap, spring, damper))?.starting_at(gap, 0.0),
                _ => {
                    let angle = options.wrist[number - 3];
                    HeldMass::new(inertia, holding(angle, stiffness, damping))?
                        .starting_at(angle, 0.0)
                }
            }
        };
        let axes = [
            axis(0)?,
            axis(1)?,
            axis(2)?,
            axis(3)?,
            axis(4)?,
            axis(5)?,
            axis(6)?,
        ];
        let mut status = [0; 17];
        // Powered, connected and started; a wrist is there and calibrated.
        for entry in [0, 1, 2] {
            status[entry] = 1;
        }
        status[8] = i32::from(options.kind.has_wrist);
        status[12] = status[8];
        Ok(Self {
            kind: options.kind,
            trouble: Trouble::default(),
            status,
            has_watchdog: options.has_watchdog,
            watchdog: 0,
            has_gravity_compensation: false,
            is_open: false,
            was_cut: false,
            limits: [f64::INFINITY; 2],
            mass: body.mass,
            axes,
            motors: [Actuator::new(body.amplifier)?; 7],
            command: [0.0; 7],
            commanded: Duration::ZERO,
            moved_until: None,
            recent: VecDeque::new(),
        })
    }

    /// Simulates up to `now`. The firmware takes the force off when its watchdog is over.
    pub fn move_on(&mut self, now: Duration) {
        let from = *self.moved_until.get_or_insert(now);
        if self.watchdog > 0 && self.status[5] != 0 {
            let over = self.commanded + WATCHDOG_UNIT * u32::from(self.watchdog);
            if over < now {
                self.hold(over.saturating_sub(from));
                self.was_cut |= self.command != [0.0; 7];
                self.disable();
                self.status[14] = 1;
                self.hold(now.saturating_sub(over.max(from)));
                self.moved_until = Some(now.max(from));
                return;
            }
        }
        self.hold(now.saturating_sub(from));
        self.moved_until = Some(now.max(from));
    }

    fn hold(&mut self, duration: Duration) {
        for ((axis, motor), force) in self.axes.iter_mut().zip(&mut self.motors).zip(self.command) {
            // The testbed expects the force on the object, which has the opposite sign.
            motor.drive(axis, -force, duration.as_secs_f64());
        }
    }

    /// Applies a command from `now` on, and returns the result of the call.
    pub fn command(&mut self, asked: Command, now: Duration) -> i32 {
        self.move_on(now);
        self.commanded = now;
        if self.status[5] == 0 {
            return 0;
        }
        let mut held = asked;
        let mut result = 0;
        if let Some(most) = self.trouble.saturates_above {
            for force in held.iter_mut().take(3) {
                if force.abs() > most {
                    *force = force.clamp(-most, most);
                    result = 2;
                }
            }
        }
        if self.kind.largest_torque.is_none() {
            held[3..6].fill(0.0);
        }
        if self.kind.largest_grip.is_none() {
            held[6] = 0.0;
        }
        self.command = held;
        result
    }

    pub fn enable(&mut self, on: bool, now: Duration) {
        if on {
            self.status[5] = 1;
            self.commanded = now;
        } else {
            self.disable();
        }
    }

    /// Takes the force off.
    pub fn disable(&mut self) {
        self.command = [0.0; 7];
        self.status[5] = 0;
    }

    pub fn held(&self) -> Command {
        self.command
    }

    pub fn position(&self) -> Vector {
        if self.trouble.is_nan {
            return [f64::NAN; 3];
        }
        [0, 1, 2].map(|axis| self.axes[axis].position())
    }

    /// Returns the angles of the wrist about x, y and z, applied in this order from the handle `[rad]`.
    pub fn wrist(&self) -> Vector {
        [3, 4, 5].map(|axis| self.axes[axis].position())
    }

    pub fn wrist_velocity(&self) -> Vector {
        [3, 4, 5].map(|axis| self.axes[axis].velocity())
    }

    pub fn gap(&self) -> f64 {
        self.axes[6].position()
    }

    /// Returns the mean velocity over the window before `now`, and keeps the present position for later.
    pub fn velocity(&mut self, now: Duration) -> Vector {
        let position = self.position();
        self.recent.push_back((now, position));
        while self
            .recent
            .get(1)
            .is_some_and(|(time, _)| now.saturating_sub(*time) >= WINDOW)
        {
            self.recent.pop_front();
        }
        let (time, there) = self.recent[0];
        let span = now.saturating_sub(time).as_secs_f64();
        if span <= 0.0 {
            return [0.0; 3];
        }
        [0, 1, 2].map(|axis| (position[axis] - there[axis]) / span)
    }

    /// Returns the matrix of inertia: that of the emulated axes, which is the same at all poses.
    pub fn inertia(&self) -> [f64; 36] {
        let mut matrix = [0.0; 36];
        for axis in 0..6 {
            matrix[7 * axis] = if axis < 3 { self.mass } else { WRIST.0 };
        }
        matrix
    }
}
