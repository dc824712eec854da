//! Two nondimensional numbers for the difficulty of a contact at a loop rate.

use crate::Scalar;
use crate::parameter::{Allowed, Parameter, ParameterError};

/// Nondimensional pair (kappa, Kc): contact stiffness relative to the inertia of device and object over one period.
///
/// Scenes with the same pair behave alike at any loop rate. No virtual damper stabilises an undamped device of kappa
/// above 0.69 on a wall; the paper's experiments have (0.16, 0.4) and (0.64, 1.6).
///
/// ```
/// use palpate_core::Difficulty;
///
/// let second_experiment = Difficulty::new(400.0, 0.25, 0.1, 0.02)?;
/// assert!((second_experiment.kappa - 0.64_f64).abs() < 1e-12);
/// assert!((second_experiment.object_kappa - 1.6_f64).abs() < 1e-12);
/// assert!((second_experiment.stiffness(0.25, 0.02)? - 400.0).abs() < 1e-9);
/// assert!((second_experiment.object_mass(0.25)? - 0.1).abs() < 1e-12);
/// # Ok::<(), palpate_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difficulty<S> {
    /// `K T^2 / m`, of the device's effective mass m `[1]`.
    pub kappa: S,
    /// `K T^2 / M`, of the object's mass M `[1]`; the paper's calligraphic K; 0 for a wall.
    pub object_kappa: S,
}

impl<S: Scalar> Difficulty<S> {
    /// Returns the pair of a contact of `stiffness` `[N/m]` between a device of effective mass `device_mass` `[kg]` and
    /// an object of `object_mass` `[kg]` (infinite: a wall), at the loop `period` `[s]`. An immovable device has an
    /// infinite mass and kappa = 0.
    ///
    /// # Errors
    /// A stiffness or period is not finite and positive, or a mass is not positive.
    pub fn new(
        stiffness: S,
        device_mass: S,
        object_mass: S,
        period: S,
    ) -> Result<Self, ParameterError> {
        Parameter::Stiffness.positive(stiffness)?;
        Parameter::Period.positive(period)?;
        let force_per_acceleration = stiffness * period * period;
        Ok(Self {
            kappa: force_per_acceleration / mass(Parameter::DeviceMass, device_mass)?,
            object_kappa: force_per_acceleration / mass(Parameter::ObjectMass, object_mass)?,
        })
    }

    /// Returns the contact stiffness K `[N/m]` with this kappa for a device of effective mass `device_mass` `[kg]` at
    /// the loop `period` `[s]`.
    ///
    /// # Errors
    /// A mass, a period or a kappa is not finite and positive.
    pub fn stiffness(&self, device_mass: S, period: S) -> Result<S, ParameterError> {
        Parameter::Kappa.positive(self.kappa)?;
        Parameter::DeviceMass.positive(device_mass)?;
        Parameter::Period.positive(period)?;
        Ok(self.kappa * device_mass / (period * period))
    }

    /// Returns the object mass M `[kg]` with this pair for a device of effective mass `device_mass` `[kg]`; infinite
    /// for an object kappa of 0.
    ///
    /// # Errors
    /// A mass or a kappa is not finite and positive, or the object kappa is negative.
    pub fn object_mass(&self, device_mass: S) -> Result<S, ParameterError> {
        Parameter::Kappa.positive(self.kappa)?;
        Parameter::ObjectKappa.not_negative(self.object_kappa)?;
        Parameter::DeviceMass.positive(device_mass)?;
        Ok(if self.object_kappa == S::ZERO {
            S::INFINITY
        } else {
            device_mass * self.kappa / self.object_kappa
        })
    }
}

fn mass<S: Scalar>(parameter: Parameter, mass: S) -> Result<S, ParameterError> {
    parameter.unless(mass > S::ZERO, mass, Allowed::Words("greater than 0"))
}
