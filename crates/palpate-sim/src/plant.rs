//! The device of a scene and the hand that holds it, as the bench moves them.

use palpate_testbed::InvalidParameter;
use palpate_testbed::device::{Device, PointMass};
use palpate_testbed::hand::{Hand, IntendedPath, Intention, Sinusoid};
use palpate_testbed::held_mass::HeldMass;

use crate::scene::{Scene, Wave};

/// Device and hand of a scene, on the canonical side.
#[derive(Clone, Debug)]
pub(crate) enum Plant {
    /// Without friction, under a constant force: its ideal is known in closed form.
    Free(PointMass),
    /// With friction, a limit of its motor, or a hand of its own.
    Held(Box<HeldMass>),
}

impl Plant {
    /// The plant of a scene that has been checked; `sign` mirrors it to the canonical side.
    pub fn of(scene: &Scene, sign: f64) -> Result<Self, InvalidParameter> {
        let device = &scene.device;
        let (position, velocity) = (sign * device.position, sign * device.velocity);
        if is_free(scene) && device.largest_force.is_none() {
            return PointMass::new(device.mass, sign * scene.user_force)?
                .starting_at(position, velocity)
                .map(Self::Free);
        }
        let wave = |wave: Wave| Sinusoid {
            amplitude: sign * wave.amplitude,
            frequency_hz: wave.frequency_hz,
            phase: 0.0,
        };
        let (force, tremor) = (sign * scene.user_force, scene.tremor.map(wave));
        let hand = match scene.grip {
            None => Hand::ConstantForce { force, tremor },
            Some(grip) => Hand::Impedance {
                mass: grip.mass,
                stiffness: grip.stiffness,
                damping: grip.damping,
                intention: Intention {
                    path: match grip.swing {
                        None => IntendedPath::Constant(sign * grip.position),
                        Some(swing) => IntendedPath::Sinusoid {
                            centre: sign * grip.position,
                            swing: wave(swing),
                        },
                    },
                    tremor: None,
                },
                force,
                tremor,
            },
        };
        HeldMass::new(device.mass, hand)?
            .with_friction(device.viscous_friction, device.coulomb_friction)?
            .with_largest_force(device.largest_force.unwrap_or(f64::INFINITY))?
            .starting_at(position, velocity)
            .map(|held| Self::Held(Box::new(held)))
    }

    /// Force on the object that the motor really holds when it is to hold `force` `[N]`.
    pub fn given_force(&self, force: f64) -> f64 {
        match self {
            Self::Free(_) => force,
            Self::Held(held) => held.given_force(force),
        }
    }
}

/// Whether the scene's ideal is known in closed form. A motor's limit is no part of the ideal.
pub(crate) fn is_free(scene: &Scene) -> bool {
    scene.device.viscous_friction == 0.0
        && scene.device.coulomb_friction == 0.0
        && scene.grip.is_none()
        && scene.tremor.is_none()
}

impl Device for Plant {
    fn position(&self) -> f64 {
        match self {
            Self::Free(device) => device.position(),
            Self::Held(device) => device.position(),
        }
    }

    fn velocity(&self) -> f64 {
        match self {
            Self::Free(device) => device.velocity(),
            Self::Held(device) => device.velocity(),
        }
    }

    fn advance(&mut self, force_on_object: f64, duration: f64) -> f64 {
        match self {
            Self::Free(device) => device.advance(force_on_object, duration),
            Self::Held(device) => device.advance(force_on_object, duration),
        }
    }

    fn stored_energy(&self) -> f64 {
        match self {
            Self::Free(device) => device.stored_energy(),
            Self::Held(device) => device.stored_energy(),
        }
    }
}
