//! One axis of a device in its hand, under a force that is held: exact for any duration.

use super::scene::{InvalidScene, Vector, WorldDevice};
use super::vector::Vec3;
use crate::InvalidParameter;
use crate::device::DevicePlant;
use crate::hand::Sinusoid;
use crate::held_mass::HeldMass;
use crate::sprung_mass::SprungMass;

/// One axis of a device: it moves, or the device lacks it and stays.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum HeldAxis {
    Moves(Box<SwungMass>),
    /// With friction, or in a hand with an intention.
    Held(Box<HeldMass>),
    /// At this position `[m]`.
    Stays(f64),
}

impl HeldAxis {
    /// Axis `axis` of a checked device, whose name in messages is `name`.
    pub fn new(device: &WorldDevice, axis: usize, name: &str) -> Result<Self, InvalidScene> {
        if !device.moves_along(axis) {
            return Ok(Self::Stays(device.own(Vec3(device.position)).0[axis]));
        }
        if device.hand.is_still() && !device.has_friction() {
            return SwungMass::new(device, axis, name).map(|mass| Self::Moves(Box::new(mass)));
        }
        let held = device.held_along(axis);
        let held = held.map_err(|invalid| InvalidParameter {
            name: format!("{name}.{}", invalid.name),
            value: invalid.value,
            allowed: invalid.allowed,
        })?;
        Ok(Self::Held(Box::new(held)))
    }

    /// Whether the device lacks this axis.
    pub fn stays(&self) -> bool {
        matches!(self, Self::Stays(_))
    }
}

impl DevicePlant for HeldAxis {
    fn position(&self) -> f64 {
        match self {
            Self::Moves(mass) => mass.position(),
            Self::Held(mass) => mass.position(),
            Self::Stays(position) => *position,
        }
    }

    fn velocity(&self) -> f64 {
        match self {
            Self::Moves(mass) => mass.velocity(),
            Self::Held(mass) => mass.velocity(),
            Self::Stays(_) => 0.0,
        }
    }

    fn advance(&mut self, force_on_object: f64, duration: f64) -> f64 {
        match self {
            Self::Moves(mass) => mass.advance(force_on_object, duration),
            Self::Held(mass) => mass.advance(force_on_object, duration),
            Self::Stays(_) => 0.0,
        }
    }

    fn stored_energy(&self) -> f64 {
        match self {
            Self::Moves(mass) => mass.stored_energy(),
            Self::Held(mass) => mass.stored_energy(),
            Self::Stays(_) => 0.0,
        }
    }
}

/// m x″ = F − k (x − x_rest) − b x′ + Σ tremor − f, for a force f on the object.
///
/// The tremors alone would swing the mass by a sum of sines, which is known in closed form; what is left moves
/// as a [`SprungMass`].
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SwungMass {
    rest: f64,
    left: SprungMass,
    swings: Vec<Sinusoid>,
    time: f64,
    mass: f64,
    stiffness: f64,
    force: f64,
}

/// A tremor whose swing without damping would be larger than its force over this share of k + m ω² is refused.
const NEAREST_RESONANCE: f64 = 1e-6;

impl SwungMass {
    fn new(device: &WorldDevice, axis: usize, name: &str) -> Result<Self, InvalidScene> {
        let hand = &device.hand;
        let mass = device.mass[axis];
        let mut swings = Vec::new();
        for tremor in &hand.tremor[axis] {
            let rate = std::f64::consts::TAU * tremor.frequency_hz;
            let inertia = mass * rate * rate;
            let (real, imaginary) = (hand.stiffness - inertia, hand.damping * rate);
            let resistance = real.hypot(imaginary);
            InvalidParameter::unless(
                resistance > NEAREST_RESONANCE * (hand.stiffness + inertia),
                format!("{name}.hand.tremor"),
                tremor.frequency_hz,
                "a frequency [Hz] that is not the resonance of an undamped hand",
            )?;
            swings.push(Sinusoid {
                amplitude: tremor.amplitude / resistance,
                phase: tremor.phase - imaginary.atan2(real),
                ..*tremor
            });
        }
        let swing: f64 = swings.iter().map(|swing| swing.value(0.0)).sum();
        let slope: f64 = swings.iter().map(|swing| swing.slope(0.0)).sum();
        let of_device = |invalid: InvalidParameter| InvalidParameter {
            name: format!("{name}.{}", invalid.name),
            value: invalid.value,
            allowed: invalid.allowed,
        };
        let own = |vector: Vector| device.own(Vec3(vector)).0[axis];
        let (force, rest) = (own(hand.force), own(hand.rest));
        let left = SprungMass::new(mass, hand.stiffness, hand.damping, force)
            .and_then(|left| {
                left.starting_at(
                    own(device.position) - rest - swing,
                    own(device.velocity) - slope,
                )
            })
            .map_err(of_device)?;
        Ok(Self {
            rest,
            left,
            swings,
            time: 0.0,
            mass,
            stiffness: hand.stiffness,
            force,
        })
    }

    fn swing(&self) -> f64 {
        self.swings.iter().map(|swing| swing.value(self.time)).sum()
    }
}

impl DevicePlant for SwungMass {
    fn position(&self) -> f64 {
        self.rest + self.left.position() + self.swing()
    }

    fn velocity(&self) -> f64 {
        let slope: f64 = self.swings.iter().map(|swing| swing.slope(self.time)).sum();
        self.left.velocity() + slope
    }

    fn advance(&mut self, force_on_object: f64, duration: f64) -> f64 {
        let before = self.swing();
        let work = self.left.advance(force_on_object, duration);
        self.time += duration;
        work + force_on_object * (self.swing() - before)
    }

    /// m x′²/2 + k (x − x_rest)²/2 − F x `[J]`; damping and tremor change it, too.
    fn stored_energy(&self) -> f64 {
        let stretched = self.position() - self.rest;
        0.5 * self.mass * self.velocity().powi(2) + 0.5 * self.stiffness * stretched * stretched
            - self.force * self.position()
    }
}
