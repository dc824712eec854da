//! The device of a scene and the hand that holds it, as the bench moves them.

use std::sync::Arc;

use palpate_testbed::InvalidParameter;
use palpate_testbed::device::{DevicePlant, PointMass};
use palpate_testbed::drivetrain::{Drivetrain, DrivetrainParams};
use palpate_testbed::hand::{Hand, IntendedPath, Intention, Sinusoid};
use palpate_testbed::held_mass::HeldMass;
use palpate_testbed::measure::Sampler;
use palpate_testbed::pantograph::Pantograph;

use palpate_scene::{self as scene, PantographDevice, PointMassDevice, Scene, Wave};
use palpate_testbed::recorded_hand::HeldByRecording;

use crate::sim::own_device::Seen;

/// Device and hand of a scene, on the canonical side.
#[derive(Clone, Debug)]
pub(crate) enum Plant {
    /// Without friction, under a constant force: its ideal is known in closed form.
    Free(PointMass),
    /// With friction, a limit of its motor, or a hand with its own dynamics.
    Held {
        /// The mass; its own motor has no limit.
        device: Box<HeldMass>,
        /// Largest force that is sent to the motor `[N]`.
        largest_force: f64,
    },
    /// With a flexible transmission or cogging.
    Drivetrain {
        /// The mechanism in its hand.
        device: Box<Drivetrain>,
        /// Largest force that is sent to the motor `[N]`.
        largest_force: f64,
    },
    /// In a recorded hand.
    Recorded(Box<HeldByRecording>),
    /// A linkage; positions count from its home.
    Linkage {
        /// The mechanism.
        device: Box<Pantograph>,
        /// y in the home pose `[m]`.
        home: f64,
    },
    /// A device of the caller's own.
    Own(Seen),
}

impl Plant {
    /// The plant of a scene that has been checked; `sign` mirrors it to the canonical side.
    pub fn of(scene: &Scene, sign: f64) -> Result<Self, InvalidParameter> {
        match &scene.device {
            scene::SceneDevice::PointMass(device) => Self::of_point_mass(device, sign),
            scene::SceneDevice::Pantograph(device) => Self::of_pantograph(device, false),
            scene::SceneDevice::Recorded { hand, .. } => {
                HeldByRecording::new(Arc::clone(hand), sign)
                    .map(|device| Self::Recorded(Box::new(device)))
            }
        }
    }

    /// `ideal`: without the limits of its motors and without the safety box.
    fn of_pantograph(device: &PantographDevice, ideal: bool) -> Result<Self, InvalidParameter> {
        let pushed = (device.force, device.force_at);
        let moved = device.linkage.device(device.position, pushed, ideal)?;
        Ok(Self::Linkage {
            device: Box::new(moved),
            home: device.linkage.home()?[1],
        })
    }

    fn of_point_mass(device: &PointMassDevice, sign: f64) -> Result<Self, InvalidParameter> {
        let (position, velocity) = (sign * device.position, sign * device.velocity);
        if has_closed_form(device) && device.largest_force.is_none() {
            return PointMass::new(device.mass, sign * device.hand.force)?
                .starting_at(position, velocity)
                .map(Self::Free);
        }
        let hand = held_by(&device.hand, sign);
        let largest_force = device.largest_force.unwrap_or(f64::INFINITY);
        if !device.is_rigid() {
            let params = DrivetrainParams {
                mass: device.mass,
                viscous_friction: device.viscous_friction,
                coulomb_friction: device.coulomb_friction,
                transmission: device.transmission,
                // Odd in the motor's position, hence unchanged by a mirror.
                cogging: device.cogging,
            };
            let mut moved = Drivetrain::new(params, hand)?.starting_at(position, velocity)?;
            if let Some(release) = device.hand.release {
                moved = moved.released_at(release)?;
            }
            return Ok(Self::Drivetrain {
                device: Box::new(moved),
                largest_force,
            });
        }
        let held = HeldMass::new(device.mass, hand)?
            .with_friction(device.viscous_friction, device.coulomb_friction)?;
        let held = match device.hand.release {
            Some(release) => held.released_at(release)?,
            None => held,
        };
        Ok(Self::Held {
            device: Box::new(held.starting_at(position, velocity)?),
            largest_force,
        })
    }

    /// Force on the object that is sent to the motor when it is to hold `force` `[N]`.
    pub fn given_force(&self, force: f64) -> f64 {
        match self {
            // A linkage's motors give torques; what they give at the end-point varies over the
            // interval. Once the safety box has switched them off, it is nothing.
            Self::Linkage { device, .. } if device.is_disconnected() => 0.0,
            Self::Free(_) | Self::Recorded(_) | Self::Linkage { .. } | Self::Own(_) => force,
            Self::Held { largest_force, .. } | Self::Drivetrain { largest_force, .. } => {
                force.clamp(-largest_force, *largest_force)
            }
        }
    }

    /// Returns the same plant without the limits of its motors and its safety box, for computing the ideal.
    pub fn without_motor_limits(&self, scene: &Scene, sign: f64) -> Result<Self, InvalidParameter> {
        match &scene.device {
            _ if matches!(self, Self::Own(_)) => Ok(self.clone()),
            scene::SceneDevice::Pantograph(device) => Self::of_pantograph(device, true),
            scene::SceneDevice::PointMass(device) => {
                let unlimited = PointMassDevice {
                    largest_force: None,
                    ..device.clone()
                };
                Self::of_point_mass(&unlimited, sign)
            }
            scene::SceneDevice::Recorded { .. } => Ok(self.clone()),
        }
    }

    /// Returns whether a linkage is stuck in a pose from which its motor angles do not determine the subsequent motion.
    pub fn is_jammed(&self) -> bool {
        matches!(self, Self::Linkage { device, .. } if device.is_jammed())
    }

    /// Whether a linkage was seen outside its safety box, which has switched its motors off.
    pub fn has_left_box(&self) -> bool {
        matches!(self, Self::Linkage { device, .. } if device.is_disconnected())
    }

    /// Position as the loop's sensor reports it, with its `noise` `[m]`. A linkage's encoders have none.
    pub fn measured(&self, sampler: &Sampler, noise: f64) -> f64 {
        match self {
            Self::Linkage { device, home } => {
                device
                    .measured_pose()
                    .map_or_else(|| device.position(), |pose| pose.position[1])
                    - home
            }
            _ => sampler.sample(noisy(self.position(), noise)),
        }
    }
}

/// `position` with `noise` on it; without any to the last bit.
pub(crate) fn noisy(position: f64, noise: f64) -> f64 {
    if noise == 0.0 {
        position
    } else {
        position + noise
    }
}

/// The hand of a point mass, on the canonical side.
fn held_by(hand: &scene::Hand, sign: f64) -> Hand {
    let wave = |wave: Wave| Sinusoid {
        amplitude: sign * wave.amplitude,
        frequency_hz: wave.frequency_hz,
        phase: 0.0,
    };
    let (force, tremor) = (sign * hand.force, hand.tremor.map(wave));
    let Some(grip) = &hand.grip else {
        return Hand::ConstantForce { force, tremor };
    };
    let path = match &grip.intention {
        scene::Intention::Recorded(path) if sign < 0.0 => {
            IntendedPath::Recorded(Arc::new(path.mirrored()))
        }
        scene::Intention::Recorded(path) => IntendedPath::Recorded(Arc::clone(path)),
        scene::Intention::Place {
            position,
            swing: None,
        } => IntendedPath::Constant(sign * position),
        scene::Intention::Place {
            position,
            swing: Some(swing),
        } => IntendedPath::Sinusoid {
            centre: sign * position,
            swing: wave(*swing),
        },
    };
    Hand::Impedance {
        mass: grip.mass,
        stiffness: grip.stiffness,
        damping: grip.damping,
        intention: Intention { path, tremor: None },
        force,
        tremor,
    }
}

/// Returns whether the scene's ideal is known in closed form. The ideal has no motor limit.
pub(crate) fn is_free(scene: &Scene) -> bool {
    scene.device.point_mass().is_some_and(has_closed_form)
}

/// Whether the motion of a point mass in its hand is known in closed form but for its motor's limit.
fn has_closed_form(device: &PointMassDevice) -> bool {
    device.is_rigid()
        && device.viscous_friction == 0.0
        && device.coulomb_friction == 0.0
        && device.hand.grip.is_none()
        && device.hand.tremor.is_none()
        && device.hand.release.is_none()
}

impl DevicePlant for Plant {
    fn position(&self) -> f64 {
        match self {
            Self::Free(device) => device.position(),
            Self::Held { device, .. } => device.position(),
            Self::Drivetrain { device, .. } => device.position(),
            Self::Recorded(device) => device.position(),
            Self::Own(device) => device.position(),
            Self::Linkage { device, home } => device.position() - home,
        }
    }

    fn velocity(&self) -> f64 {
        match self {
            Self::Free(device) => device.velocity(),
            Self::Held { device, .. } => device.velocity(),
            Self::Drivetrain { device, .. } => device.velocity(),
            Self::Recorded(device) => device.velocity(),
            Self::Own(device) => device.velocity(),
            Self::Linkage { device, .. } => device.velocity(),
        }
    }

    fn advance(&mut self, force_on_object: f64, duration: f64) -> f64 {
        match self {
            Self::Free(device) => device.advance(force_on_object, duration),
            Self::Held { device, .. } => device.advance(force_on_object, duration),
            Self::Drivetrain { device, .. } => device.advance(force_on_object, duration),
            Self::Recorded(device) => device.advance(force_on_object, duration),
            Self::Own(device) => device.advance(force_on_object, duration),
            Self::Linkage { device, .. } => device.advance(force_on_object, duration),
        }
    }

    fn sample(&mut self, period: f64) {
        match self {
            Self::Linkage { device, .. } => device.sample(period),
            Self::Own(device) => device.sample(period),
            Self::Free(_) | Self::Held { .. } | Self::Drivetrain { .. } | Self::Recorded(_) => {}
        }
    }

    fn stored_energy(&self) -> f64 {
        match self {
            Self::Free(device) => device.stored_energy(),
            Self::Held { device, .. } => device.stored_energy(),
            Self::Drivetrain { device, .. } => device.stored_energy(),
            Self::Recorded(device) => device.stored_energy(),
            Self::Own(device) => device.stored_energy(),
            Self::Linkage { device, .. } => device.stored_energy(),
        }
    }
}
