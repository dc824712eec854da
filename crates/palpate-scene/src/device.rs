//! The device of a scene, with the hand that moves it. Each kind has what belongs to it and nothing else.

use std::sync::Arc;

use palpate_testbed::drivetrain::{Cogging, Transmission};
use palpate_testbed::recorded_hand::RecordedHand;

use super::hand::{Grip, Hand, Wave};
use super::linkage::{HandForceAt, Linkage};

/// A device and the hand that moves it.
#[derive(Clone, Debug, PartialEq)]
pub enum SceneDevice {
    /// A point mass in a hand.
    PointMass(PointMassDevice),
    /// A pantograph that a constant force pushes.
    Pantograph(PantographDevice),
    /// A point mass in a recorded hand; no scene file has one. It is without friction, and starts where and as
    /// fast as the recording does.
    Recorded {
        /// The hand, whose model has the mass of the device.
        hand: Arc<RecordedHand>,
        /// Quantum of the position sensor `[m]`; 0 for an ideal one.
        encoder_quantum: f64,
        /// Whether the loop samples at the recorded instants, with or without a position, instead of every period.
        /// [`Timing`](crate::Timing) then contains only a delay in seconds.
        at_its_instants: bool,
    },
}

/// A point mass in a hand.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointMassDevice {
    /// Mass `[kg]`.
    pub mass: f64,
    /// Position at the start `[m]`.
    pub position: f64,
    /// Velocity at the start `[m/s]`.
    pub velocity: f64,
    /// Quantum of the position sensor `[m]`; 0 for an ideal one.
    pub encoder_quantum: f64,
    /// Viscous friction `[N s/m]`.
    pub viscous_friction: f64,
    /// Coulomb friction `[N]`.
    pub coulomb_friction: f64,
    /// Largest force of the motor `[N]`; a larger one is sent only in part.
    pub largest_force: Option<f64>,
    /// Flexible transmission between the motor, where the sensor is, and the end-point, where the hand
    /// is; none where they are one rigid body.
    pub transmission: Option<Transmission>,
    /// Cogging of the motor.
    pub cogging: Option<Cogging>,
    /// Standard deviation of the sensor's white noise, before quantisation `[m]`; the model value is in
    /// [`Model`](crate::Model).
    pub noise: f64,
    /// The hand that holds it.
    pub hand: Hand,
}

impl PointMassDevice {
    /// Whether motor and end-point are one rigid body, and the motor does not cog.
    #[must_use]
    pub fn is_rigid(&self) -> bool {
        self.transmission.is_none() && self.cogging.is_none()
    }
}

/// A pantograph at rest, which a hand pushes along the contact. Friction, motors, encoders and the safety box are
/// those of its linkage.
#[derive(Clone, Debug, PartialEq)]
pub struct PantographDevice {
    /// The linkage.
    pub linkage: Linkage,
    /// Position at the start, along y from home `[m]`.
    pub position: f64,
    /// Equivalent mass of the linkage for the renderer and reports `[kg]`: by default its effective mass along the
    /// contact at the start.
    pub mass: f64,
    /// Model value of the position quantum along the contact `[m]`. The linkage measures by the encoders of its joints.
    pub encoder_quantum: f64,
    /// Constant force f_u of the hand `[N]`.
    pub force: f64,
    /// Point of action of that force.
    pub force_at: HandForceAt,
}

impl SceneDevice {
    /// Returns the mass along the contact `[kg]`; for a pantograph, its equivalent mass.
    #[must_use]
    pub fn mass(&self) -> f64 {
        match self {
            Self::PointMass(device) => device.mass,
            Self::Pantograph(device) => device.mass,
            Self::Recorded { hand, .. } => hand.model().device_mass,
        }
    }

    /// Position along the contact at the start `[m]`.
    #[must_use]
    pub fn position(&self) -> f64 {
        match self {
            Self::PointMass(device) => device.position,
            Self::Pantograph(device) => device.position,
            Self::Recorded { hand, .. } => hand.motion(0.0).0,
        }
    }

    /// Velocity along the contact at the start `[m/s]`.
    #[must_use]
    pub fn velocity(&self) -> f64 {
        match self {
            Self::PointMass(device) => device.velocity,
            Self::Pantograph(_) => 0.0,
            Self::Recorded { hand, .. } => hand.motion(0.0).1,
        }
    }

    /// Quantum of the position along the contact `[m]`; 0 for an ideal sensor, or where a linkage states none.
    #[must_use]
    pub fn encoder_quantum(&self) -> f64 {
        match self {
            Self::PointMass(device) => device.encoder_quantum,
            Self::Pantograph(device) => device.encoder_quantum,
            Self::Recorded {
                encoder_quantum, ..
            } => *encoder_quantum,
        }
    }

    /// The mass along the contact `[kg]`, to change it; `None` in a recorded hand, whose model has it.
    pub fn mass_mut(&mut self) -> Option<&mut f64> {
        match self {
            Self::PointMass(device) => Some(&mut device.mass),
            Self::Pantograph(device) => Some(&mut device.mass),
            Self::Recorded { .. } => None,
        }
    }

    /// The quantum of the position along the contact `[m]`, to change it.
    pub fn encoder_quantum_mut(&mut self) -> &mut f64 {
        match self {
            Self::PointMass(device) => &mut device.encoder_quantum,
            Self::Pantograph(device) => &mut device.encoder_quantum,
            Self::Recorded {
                encoder_quantum, ..
            } => encoder_quantum,
        }
    }

    /// Standard deviation of the sensor's white noise `[m]`; only a point mass in a hand has any.
    #[must_use]
    pub fn noise(&self) -> f64 {
        self.point_mass().map_or(0.0, |device| device.noise)
    }

    /// Viscous friction of a point mass in a hand `[N s/m]`; 0 for any other device.
    #[must_use]
    pub fn viscous_friction(&self) -> f64 {
        self.point_mass()
            .map_or(0.0, |device| device.viscous_friction)
    }

    /// Coulomb friction of a point mass in a hand `[N]`; 0 for any other device.
    #[must_use]
    pub fn coulomb_friction(&self) -> f64 {
        self.point_mass()
            .map_or(0.0, |device| device.coulomb_friction)
    }

    /// Largest force of the motor of a point mass in a hand `[N]`, if it has a limit.
    #[must_use]
    pub fn largest_force(&self) -> Option<f64> {
        self.point_mass()?.largest_force
    }

    /// The hand that holds a point mass.
    #[must_use]
    pub fn hand(&self) -> Option<&Hand> {
        self.point_mass().map(|device| &device.hand)
    }

    /// Mass, spring and damper of the hand, if it has any.
    #[must_use]
    pub fn grip(&self) -> Option<&Grip> {
        self.hand()?.grip.as_ref()
    }

    /// Tremor of the hand, if it has any.
    #[must_use]
    pub fn tremor(&self) -> Option<Wave> {
        self.hand()?.tremor
    }

    /// Constant force of the hand `[N]`; a recorded hand has none.
    #[must_use]
    pub fn hand_force(&self) -> f64 {
        match self {
            Self::PointMass(device) => device.hand.force,
            Self::Pantograph(device) => device.force,
            Self::Recorded { .. } => 0.0,
        }
    }

    /// The point mass in its hand, if the device is one.
    #[must_use]
    pub fn point_mass(&self) -> Option<&PointMassDevice> {
        match self {
            Self::PointMass(device) => Some(device),
            Self::Pantograph(_) | Self::Recorded { .. } => None,
        }
    }

    /// The same, to change it.
    pub fn point_mass_mut(&mut self) -> Option<&mut PointMassDevice> {
        match self {
            Self::PointMass(device) => Some(device),
            Self::Pantograph(_) | Self::Recorded { .. } => None,
        }
    }

    /// The pantograph, if the device is one.
    #[must_use]
    pub fn pantograph(&self) -> Option<&PantographDevice> {
        match self {
            Self::Pantograph(device) => Some(device),
            Self::PointMass(_) | Self::Recorded { .. } => None,
        }
    }

    /// The same, to change it.
    pub fn pantograph_mut(&mut self) -> Option<&mut PantographDevice> {
        match self {
            Self::Pantograph(device) => Some(device),
            Self::PointMass(_) | Self::Recorded { .. } => None,
        }
    }

    /// The hand at whose recorded instants the loop samples, if it does so.
    #[must_use]
    pub fn sampled_as_recorded(&self) -> Option<&Arc<RecordedHand>> {
        match self {
            Self::Recorded {
                hand,
                at_its_instants: true,
                ..
            } => Some(hand),
            Self::Recorded { .. } | Self::PointMass(_) | Self::Pantograph(_) => None,
        }
    }

    /// The recorded hand, if the device is in one.
    #[must_use]
    pub fn recorded_hand(&self) -> Option<&Arc<RecordedHand>> {
        match self {
            Self::Recorded { hand, .. } => Some(hand),
            Self::PointMass(_) | Self::Pantograph(_) => None,
        }
    }
}
