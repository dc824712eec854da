//! The parameters of a pantograph by name.

use std::fmt;

use crate::InvalidParameter;

/// A parameter of a pantograph, its start, its user, its controller or its safety box, to be matched by value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // the parameters are called what the fields are that have them
pub enum PantographParameter {
    Proximal,
    Distal,
    Base,
    Home,
    ProximalMass,
    ProximalCentre,
    ProximalInertia,
    DistalMass,
    DistalCentre,
    DistalInertia,
    RotorInertia,
    /// The inertia of a rotor together with that of its proximal link.
    TurningInertia,
    EndPointMass,
    ViscousFriction,
    CoulombFriction,
    MaxTorque,
    CountsPerRev,
    Gravity,
    /// The angles to start at.
    Angles,
    /// The rates to start at.
    Rates,
    UserForce,
    SafetyBox,
    Target,
    Proportional,
    Integral,
    Derivative,
    MaxForce,
}

impl PantographParameter {
    /// The field that has it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Proximal => "proximal",
            Self::Distal => "distal",
            Self::Base => "base",
            Self::Home => "home",
            Self::ProximalMass => "proximal mass",
            Self::ProximalCentre => "proximal centre",
            Self::ProximalInertia => "proximal inertia",
            Self::DistalMass => "distal mass",
            Self::DistalCentre => "distal centre",
            Self::DistalInertia => "distal inertia",
            Self::RotorInertia => "rotor_inertia",
            Self::TurningInertia => "rotor_inertia + inertia",
            Self::EndPointMass => "end_point_mass",
            Self::ViscousFriction => "viscous_friction",
            Self::CoulombFriction => "coulomb_friction",
            Self::MaxTorque => "max_torque",
            Self::CountsPerRev => "counts_per_rev",
            Self::Gravity => "gravity",
            Self::Angles => "angles",
            Self::Rates => "rates",
            Self::UserForce => "user_force",
            Self::SafetyBox => "safety_box",
            Self::Target => "target",
            Self::Proportional => "proportional",
            Self::Integral => "integral",
            Self::Derivative => "derivative",
            Self::MaxForce => "max_force",
        }
    }
}

impl fmt::Display for PantographParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl From<InvalidParameter<PantographParameter>> for InvalidParameter {
    fn from(error: InvalidParameter<PantographParameter>) -> Self {
        Self {
            name: error.name.name(),
            value: error.value,
            allowed: error.allowed,
        }
    }
}
