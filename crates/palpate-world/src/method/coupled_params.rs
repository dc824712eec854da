//! The parameters of coupled rendering, and their checks.

use super::coupled::Coupled;
use crate::observer::{AxisPrior, Prior};
use crate::{Place, Vector, WorldError};

/// Parameters of coupled rendering.
///
/// A held force moves a device to another place than the force it stands for would have. So the world never meets the
/// device but its avatar: over each interval avatars and bodies move on together under the continuous contact forces,
/// and each device, by what an observer knows of it, under the force that is held; the difference of the two at the
/// end is the avatar's offset. The held force is the mean of the contact force, with what brings the avatar's velocity
/// back to the device's. With the devices' masses and the forces of the hands known exactly, each held force is the
/// interval mean of the ideal one: no held force can be nearer.
#[derive(Clone, Debug, PartialEq)]
pub struct CoupledParams {
    /// Mass of each tool's device along each of the world's axes, within a factor of 2 `[kg]`. The hand's share is
    /// learned. Infinite where no force moves the device: along an axis that it does not have, or in a recording.
    pub device_mass: Vec<Vector>,
    /// Quantum of the position sensors `[m]`, 0 if they are not known to have one.
    pub encoder_quantum: f64,
    /// Largest distance of an avatar from its device `[m]`.
    pub offset_limit: f64,
    /// Speed at which the offset of a tool that touches nothing goes back to zero `[m/s]`.
    pub offset_return: f64,
    /// Time in which the velocity offset of a tool that touches nothing is given up `[s]`.
    pub velocity_return: f64,
    /// What is known of devices and hands before the first sample.
    pub prior: Prior,
}

impl CoupledParams {
    /// Coupled rendering with devices of these masses `[kg]`, by sensors of no known quantum.
    #[must_use]
    pub fn new(device_mass: Vec<Vector>) -> Self {
        Self {
            device_mass,
            encoder_quantum: 0.0,
            offset_limit: 0.01,
            offset_return: 0.001,
            velocity_return: 0.1,
            prior: Prior::default(),
        }
    }

    /// The same with position sensors of `encoder_quantum` `[m]`.
    #[must_use]
    pub fn with_encoder_quantum(self, encoder_quantum: f64) -> Self {
        Self {
            encoder_quantum,
            ..self
        }
    }

    /// The same with another knowledge of devices and hands.
    #[must_use]
    pub fn with_prior(self, prior: Prior) -> Self {
        Self { prior, ..self }
    }

    pub(super) fn check(self, tools: usize) -> Result<Coupled, Vec<WorldError>> {
        let mut faults = Vec::new();
        let mut fault = |field: &'static str, message: String| {
            faults.push(WorldError::new(Place::Method, field, "the method", message));
        };
        if self.device_mass.len() != tools {
            fault(
                "device_mass",
                format!(
                    "device_mass has {} entries for {tools} tools; give one for each",
                    self.device_mass.len()
                ),
            );
        }
        for mass in self.device_mass.iter().flatten() {
            let is_mass = *mass > 0.0;
            if !is_mass {
                fault(
                    "device_mass",
                    format!("device_mass is {mass}, and has to be above 0, or infinite"),
                );
            }
        }
        let positive = [
            ("offset_limit", self.offset_limit),
            ("velocity_return", self.velocity_return),
        ];
        for (field, value) in positive {
            let is_positive = value > 0.0;
            if !is_positive {
                fault(field, format!("{field} is {value}, and has to be above 0"));
            }
        }
        let Prior {
            velocity,
            acceleration,
            mobility,
            damping_rate,
            spring_rate,
            jerk,
        } = self.prior;
        let not_negative = [
            ("encoder_quantum", self.encoder_quantum),
            ("offset_return", self.offset_return),
            ("prior.velocity", velocity),
            ("prior.acceleration", acceleration),
            ("prior.mobility", mobility),
            ("prior.damping_rate", damping_rate),
            ("prior.spring_rate", spring_rate),
            ("prior.jerk", jerk),
        ];
        for (field, value) in not_negative {
            if !(value >= 0.0 && value.is_finite()) {
                fault(
                    field,
                    format!("{field} is {value}, and has to be at least 0"),
                );
            }
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        let of_axis = |mass: f64| AxisPrior::new(mass, self.encoder_quantum, self.prior);
        let priors = self.device_mass.iter().map(|mass| mass.map(of_axis));
        Ok(Coupled {
            priors: priors.collect(),
            offset_limit: self.offset_limit,
            offset_return: self.offset_return,
            velocity_return: self.velocity_return,
        })
    }
}
