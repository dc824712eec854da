//! Parameters of a pantograph.

use super::kinematics::Geometry;
use super::parameter::PantographParameter as Parameter;
use crate::InvalidParameter;
use crate::error::{finite, positive};

/// One rigid link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link {
    /// Mass `[kg]`.
    pub mass: f64,
    /// Centre of mass on the link's line, as a fraction of its length from the joint nearer to the
    /// motor; may lie outside 0 to 1 for a counterweight.
    pub centre: f64,
    /// Moment of inertia about the centre of mass `[kg m²]`.
    pub inertia: f64,
}

impl Link {
    /// A uniform slender rod: centre in the middle, m s²/12 about it.
    #[must_use]
    pub const fn rod(mass: f64, length: f64) -> Self {
        Self {
            mass,
            centre: 0.5,
            inertia: mass * length * length / 12.0,
        }
    }
}

/// Generation of forces at the end-point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Actuation {
    /// The force itself acts on the end-point, exactly and without a limit.
    Ideal,
    /// Motor torques JᵀF from the true pose at the sample, limited and held.
    MotorsAtTruePose,
    /// Motor torques JᵀF from the pose that the encoders report at the sample, limited and held.
    #[default]
    MotorsAtMeasuredPose,
}

/// Mechanism, motors and encoders of a five-bar pantograph.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PantographParams {
    /// Lengths, assembly and origin.
    pub geometry: Geometry,
    /// Motor angles at the start `[rad]`.
    pub home: [f64; 2],
    /// The links on motors 1 and 2.
    pub proximal: [Link; 2],
    /// The links from the elbows to the end-point.
    pub distal: [Link; 2],
    /// Moment of inertia of each rotor as felt at its joint (gear ratio squared) `[kg m²]`.
    pub rotor_inertia: f64,
    /// Mass of handle and joint at the end-point `[kg]`.
    pub end_point_mass: f64,
    /// Viscous friction of each motor joint `[N m s/rad]`.
    pub viscous_friction: f64,
    /// Coulomb friction of each motor joint, sliding and sticking alike `[N m]`.
    pub coulomb_friction: f64,
    /// Largest torque of each motor at its joint `[N m]`; infinite for no limit.
    pub max_torque: f64,
    /// Encoder counts per revolution of the joint; `None` measures exactly.
    pub counts_per_rev: Option<f64>,
    /// Generation of forces.
    pub actuation: Actuation,
    /// Gravity `[m/s²]`; zero for a device that lies flat.
    pub gravity: [f64; 2],
}

impl PantographParams {
    /// Returns the parameters if every value is allowed. [`Pantograph::new`](super::Pantograph::new) checks the home
    /// pose.
    ///
    /// # Errors
    ///
    /// The first number that is not allowed. A mass, an inertia or a friction may be zero, but
    /// some inertia must turn with each motor.
    pub fn checked(self) -> Result<Self, InvalidParameter<Parameter>> {
        self.geometry.checked()?;
        for angle in self.home {
            finite(Parameter::Home, angle, "finite [rad]")?;
        }
        for (links, [mass, centre, inertia]) in [
            (
                self.proximal,
                [
                    Parameter::ProximalMass,
                    Parameter::ProximalCentre,
                    Parameter::ProximalInertia,
                ],
            ),
            (
                self.distal,
                [
                    Parameter::DistalMass,
                    Parameter::DistalCentre,
                    Parameter::DistalInertia,
                ],
            ),
        ] {
            for link in links {
                at_least_zero(mass, link.mass, "finite and at least 0 kg")?;
                finite(centre, link.centre, "finite, a fraction of the length")?;
                at_least_zero(inertia, link.inertia, "finite and at least 0 kg m²")?;
            }
        }
        at_least_zero(
            Parameter::RotorInertia,
            self.rotor_inertia,
            "finite and at least 0 kg m²",
        )?;
        for link in self.proximal {
            let turning = self.rotor_inertia + link.inertia;
            positive(
                Parameter::TurningInertia,
                turning,
                "above 0 kg m² for each motor",
            )?;
        }
        at_least_zero(
            Parameter::EndPointMass,
            self.end_point_mass,
            "finite and at least 0 kg",
        )?;
        at_least_zero(
            Parameter::ViscousFriction,
            self.viscous_friction,
            "finite and at least 0 N m s/rad",
        )?;
        at_least_zero(
            Parameter::CoulombFriction,
            self.coulomb_friction,
            "finite and at least 0 N m",
        )?;
        InvalidParameter::unless(
            self.max_torque > 0.0,
            Parameter::MaxTorque,
            self.max_torque,
            "above 0 N m; infinite for no limit",
        )?;
        if let Some(counts) = self.counts_per_rev {
            positive(Parameter::CountsPerRev, counts, "finite and above 0")?;
        }
        for g in self.gravity {
            finite(Parameter::Gravity, g, "finite [m/s²]")?;
        }
        Ok(self)
    }

    /// Returns the same device without friction.
    #[must_use]
    pub fn frictionless(self) -> Self {
        Self {
            viscous_friction: 0.0,
            coulomb_friction: 0.0,
            ..self
        }
    }
}

fn at_least_zero(
    name: Parameter,
    value: f64,
    allowed: &'static str,
) -> Result<f64, InvalidParameter<Parameter>> {
    InvalidParameter::unless(value.is_finite() && value >= 0.0, name, value, allowed)
}
