//! Emulated device: a point mass on three axes in a hand, in real time.

use std::time::{Duration, Instant};

use palpate_device::Vector;
use palpate_testbed::InvalidParameter;
use palpate_testbed::actuator::{Actuator, ActuatorParams};
use palpate_testbed::device::DevicePlant as _;
use palpate_testbed::hand::{Hand, Intention};
use palpate_testbed::held_mass::HeldMass;

use crate::inverse3::Status;

/// Parameters of an emulated device: the same point mass along each axis, each with its own hand.
#[derive(Clone, Debug)]
pub struct Body {
    /// Mass `[kg]`.
    pub mass: f64,
    /// Viscous friction `[N s/m]`.
    pub friction: f64,
    /// Resting position before the first client connects `[m]`.
    pub start: Vector,
    /// The hand along x, y and z.
    pub hands: [Hand; 3],
    /// Gain and lag of the amplifiers, for the force along each axis.
    pub amplifier: ActuatorParams,
}

/// Returns a hand that holds the device at a position `[m]` with a spring `[N/m]` and a damper `[N s/m]`.
#[must_use]
pub fn holding(place: f64, stiffness: f64, damping: f64) -> Hand {
    Hand::Impedance {
        mass: 0.0,
        stiffness,
        damping,
        intention: Intention::constant(place),
        force: 0.0,
        tremor: None,
    }
}

impl Default for Body {
    /// 0.2 kg, in a hand of 100 N/m that holds it at its start position, the origin. The mass is an assumption: the
    /// manufacturer does not publish the effective mass of the arms. The amplifiers are ideal.
    fn default() -> Self {
        Self {
            mass: 0.2,
            friction: 0.5,
            start: [0.0; 3],
            hands: [0.0; 3].map(|place| holding(place, 100.0, 5.0)),
            amplifier: ActuatorParams::default(),
        }
    }
}

/// An emulated device.
#[derive(Debug)]
pub(super) struct EmulatedDevice {
    pub id: String,
    /// Whether the device is in frames and in the list of devices; otherwise it is unplugged.
    pub present: bool,
    pub status: Status,
    at_start: [HeldMass; 3],
    axes: [HeldMass; 3],
    amplifier: Actuator,
    motors: [Actuator; 3],
    force: Vector,
    commanded: Option<Instant>,
    moved_until: Option<Instant>,
    idle_after: Duration,
}

impl EmulatedDevice {
    pub fn new(id: String, body: &Body, idle_after: Duration) -> Result<Self, InvalidParameter> {
        let axis = |index: usize| {
            HeldMass::new(body.mass, body.hands[index].clone())?
                .with_friction(body.friction, 0.0)?
                .starting_at(body.start[index], 0.0)
        };
        let axes = [axis(0)?, axis(1)?, axis(2)?];
        let amplifier = Actuator::new(body.amplifier)?;
        Ok(Self {
            id,
            present: true,
            status: Status {
                calibrated: Some(true),
                in_use: Some(false),
                power_supply: Some(true),
                ready: Some(true),
                started: Some(true),
            },
            at_start: axes.clone(),
            axes,
            amplifier,
            motors: [amplifier; 3],
            force: [0.0; 3],
            commanded: None,
            moved_until: None,
            idle_after,
        })
    }

    /// Returns to the initial state, because no client is connected.
    pub fn rest(&mut self) {
        self.axes = self.at_start.clone();
        self.motors = [self.amplifier; 3];
        self.moved_until = None;
    }

    /// Applies `force` `[N]` from `now` on, until the next command or until commands stop.
    pub fn command(&mut self, force: Vector, now: Instant) {
        self.move_on(now);
        self.force = force;
        self.commanded = Some(now);
    }

    /// Simulates up to `now`; the motors idle some time after the last command.
    pub fn move_on(&mut self, now: Instant) {
        let from = *self.moved_until.get_or_insert(now);
        let idle = self.commanded.map(|commanded| commanded + self.idle_after);
        if let Some(idle) = idle.filter(|idle| *idle <= now) {
            self.hold(idle.saturating_duration_since(from));
            self.force = [0.0; 3];
            self.commanded = None;
            self.hold(now.saturating_duration_since(idle.max(from)));
        } else {
            self.hold(now.saturating_duration_since(from));
        }
        self.moved_until = Some(now.max(from));
    }

    fn hold(&mut self, duration: Duration) {
        for ((axis, motor), force) in self.axes.iter_mut().zip(&mut self.motors).zip(self.force) {
            // The testbed expects the force on the object, which has the opposite sign.
            motor.drive(axis, -force, duration.as_secs_f64());
        }
    }

    /// Returns whether a force is commanded, including zero.
    pub fn is_commanded(&self) -> bool {
        self.commanded.is_some()
    }

    /// Returns the commanded force of the motors `[N]`.
    pub fn force(&self) -> Vector {
        self.force
    }

    pub fn position(&self) -> Vector {
        [0, 1, 2].map(|axis| self.axes[axis].position())
    }

    pub fn velocity(&self) -> Vector {
        [0, 1, 2].map(|axis| self.axes[axis].velocity())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn in_nobodys_hand() -> EmulatedDevice {
        let body = Body {
            mass: 0.5,
            friction: 0.0,
            start: [0.01, 0.0, 0.0],
            hands: [0.0; 3].map(Hand::pushing),
            amplifier: ActuatorParams::default(),
        };
        EmulatedDevice::new("a".into(), &body, Duration::from_millis(20)).unwrap()
    }

    #[test]
    fn a_force_moves_it_until_commands_stop() {
        let mut device = in_nobodys_hand();
        let start = Instant::now();
        let ms = |time| start + Duration::from_millis(time);
        device.command([1.0, 0.0, -2.0], start);
        device.move_on(ms(10));
        // F t²/2m, with F/m = 2 and -4 m/s²
        let [x, y, z] = device.position();
        assert!((x - 0.0101).abs() < 1e-12 && y == 0.0 && (z + 2e-4).abs() < 1e-12);
        assert_eq!(device.force(), [1.0, 0.0, -2.0]);
        // Idle from 20 ms on: it keeps its velocity of 40 mm/s.
        device.move_on(ms(70));
        assert_eq!(device.force(), [0.0; 3]);
        assert!(!device.is_commanded());
        let [x, ..] = device.position();
        assert!((x - (0.01 + 4e-4 + 0.04 * 0.05)).abs() < 1e-12, "{x}");
        assert!((device.velocity()[0] - 0.04).abs() < 1e-12);
    }

    #[test]
    fn it_waits_at_its_start_for_the_next_client() {
        let mut device = in_nobodys_hand();
        let start = Instant::now();
        device.command([1.0; 3], start);
        device.move_on(start + Duration::from_secs(1));
        device.rest();
        assert_eq!(device.position(), [0.01, 0.0, 0.0]);
        device.move_on(start + Duration::from_secs(100));
        assert_eq!(device.position(), [0.01, 0.0, 0.0]);
    }
}
