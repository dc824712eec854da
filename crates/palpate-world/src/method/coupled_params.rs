//! Parameters of coupled rendering, and their checks.

use palpate_core::Range;

use super::coupled::Coupled;
use crate::device::observer::{AxisPrior, Prior};
use crate::device::turning_observer::TurningPrior;
use crate::dynamics::linkage::Linkage;
use crate::error::out_of_range;
use crate::geometry::axes::Axes;
use crate::geometry::rigid::Vector3;
use crate::{Tool, Vector, WorldError, WorldErrors, WorldField, WorldPart};

/// Parameters of coupled rendering.
///
/// A held force leads to a different device position from the continuous force with the same impulse. The world
/// therefore collides with a proxy instead of the device. Over each interval proxies and bodies move together under
/// the continuous contact forces, and each device, as estimated by an observer, under the held force. The difference
/// at the end is the proxy offset. The held force is the mean contact force plus a correction that returns the
/// proxy's velocity to the device's. If the device masses and hand forces are known exactly, each held force is the
/// interval mean of the ideal force, which is the closest possible held force.
#[derive(Clone, Debug, PartialEq)]
pub struct CoupledParams {
    /// Mass of each tool's device along each of the world's axes, within a factor of 2 `[kg]`. The hand's share is
    /// estimated. Infinite if no force moves the device, as in a recording. Ignored along an axis that the device
    /// lacks ([`Tool::axes`]).
    pub device_mass: Vec<Vector>,
    /// Moments of inertia of each tool's device about its mass centre, along the tool's axes, within a factor of 2
    /// `[kg m^2]`. Infinite about all three axes if no torque turns the device, as in a recording. Ignored for a tool
    /// that does not turn; empty if none turns. For a tool turned by its hand ([`Tool::turned_by_hand`]) they
    /// determine the predicted rotation between samples.
    pub device_inertia: Vec<Vector>,
    /// Quantum of the position sensors `[m]`, 0 if unknown.
    pub encoder_quantum: f64,
    /// Quantum of the measured orientations `[rad]`, 0 if unknown.
    pub angle_quantum: f64,
    /// Maximum distance of a proxy from its device `[m]`.
    pub offset_limit: f64,
    /// Speed at which the proxy offset of a tool without contact decays `[m/s]`.
    pub offset_return: f64,
    /// Decay time of the velocity and angular momentum offsets of a tool without contact `[s]`.
    pub velocity_return: f64,
    /// Maximum angle between a proxy and its device `[rad]`.
    pub turn_limit: f64,
    /// Speed at which the rotational proxy offset of a tool without contact decays `[rad/s]`.
    pub turn_return: f64,
    /// Knowledge of devices and hands before the first sample.
    pub prior: Prior,
}

impl CoupledParams {
    /// Creates parameters for devices of these masses `[kg]`, with unknown sensor quanta.
    #[must_use]
    pub fn new(device_mass: Vec<Vector>) -> Self {
        Self {
            device_mass,
            device_inertia: Vec::new(),
            encoder_quantum: 0.0,
            angle_quantum: 0.0,
            offset_limit: 0.01,
            offset_return: 0.001,
            velocity_return: 0.1,
            turn_limit: 0.3,
            turn_return: 0.03,
            prior: Prior::default(),
        }
    }

    /// Sets the quantum of the position sensors `[m]`.
    #[must_use]
    pub fn with_encoder_quantum(self, encoder_quantum: f64) -> Self {
        Self {
            encoder_quantum,
            ..self
        }
    }

    /// Sets the moments of inertia of each device `[kg m^2]`.
    #[must_use]
    pub fn with_device_inertia(self, device_inertia: Vec<Vector>) -> Self {
        Self {
            device_inertia,
            ..self
        }
    }

    /// Sets the quantum of the measured orientations `[rad]`.
    #[must_use]
    pub fn with_angle_quantum(self, angle_quantum: f64) -> Self {
        Self {
            angle_quantum,
            ..self
        }
    }

    /// Sets the prior of devices and hands.
    #[must_use]
    pub fn with_prior(self, prior: Prior) -> Self {
        Self { prior, ..self }
    }

    pub(crate) fn check(self, all: &[Tool]) -> Result<Coupled, WorldErrors> {
        let mut faults = Vec::new();
        self.check_masses(all.len(), &mut faults);
        self.check_inertias(all, &mut faults);
        self.check_ranges(&mut faults);
        WorldErrors::check(faults)?;
        Ok(self.coupled(all))
    }

    /// Reports device masses that are missing or not above 0.
    fn check_masses(&self, tools: usize, faults: &mut Vec<WorldError>) {
        if self.device_mass.len() != tools {
            faults.push(fault(
                WorldField::DeviceMass,
                format!(
                    "device_mass has {} entries for {tools} tools; give one for each",
                    self.device_mass.len()
                ),
            ));
        }
        for mass in self.device_mass.iter().flatten() {
            let is_mass = *mass > 0.0;
            if !is_mass {
                faults.push(fault(
                    WorldField::DeviceMass,
                    format!("device_mass is {mass}, and has to be above 0, or infinite"),
                ));
            }
        }
    }

    /// Reports moments of inertia of turning devices that are missing or out of range.
    fn check_inertias(&self, all: &[Tool], faults: &mut Vec<WorldError>) {
        let tools = all.len();
        if all.iter().any(|tool| tool.turns) && self.device_inertia.len() != tools {
            faults.push(fault(
                WorldField::DeviceInertia,
                format!(
                    "device_inertia has {} entries for {tools} tools, of which one turns; give three moments for each",
                    self.device_inertia.len()
                ),
            ));
        }
        for (tool, moments) in all.iter().zip(&self.device_inertia) {
            let is_immovable = *moments == [f64::INFINITY; 3];
            for moment in moments {
                if tool.turns && !is_immovable && !(*moment > 0.0 && moment.is_finite()) {
                    faults.push(fault(
                        WorldField::DeviceInertia,
                        format!(
                            "device_inertia is {moment}, and has to be above 0 and finite, or infinite about all three axes"
                        ),
                    ));
                }
            }
        }
    }

    /// Reports limits, return rates, quanta and priors that are out of range.
    fn check_ranges(&self, faults: &mut Vec<WorldError>) {
        let positive = [
            (WorldField::OffsetLimit, self.offset_limit),
            (WorldField::VelocityReturn, self.velocity_return),
            (WorldField::TurnLimit, self.turn_limit),
        ];
        for (field, value) in positive {
            let is_positive = value > 0.0;
            if !is_positive {
                faults.push(fault(
                    field,
                    format!("{field} is {value}, and has to be above 0"),
                ));
            }
        }
        let Prior {
            velocity,
            acceleration,
            mobility,
            damping_rate,
            spring_rate,
            jerk,
            angular_velocity,
            angular_acceleration,
            angular_jerk,
        } = self.prior;
        let not_negative = [
            (WorldField::EncoderQuantum, self.encoder_quantum),
            (WorldField::AngleQuantum, self.angle_quantum),
            (WorldField::OffsetReturn, self.offset_return),
            (WorldField::TurnReturn, self.turn_return),
            (WorldField::PriorVelocity, velocity),
            (WorldField::PriorAcceleration, acceleration),
            (WorldField::PriorMobility, mobility),
            (WorldField::PriorDampingRate, damping_rate),
            (WorldField::PriorSpringRate, spring_rate),
            (WorldField::PriorJerk, jerk),
            (WorldField::PriorAngularVelocity, angular_velocity),
            (WorldField::PriorAngularAcceleration, angular_acceleration),
            (WorldField::PriorAngularJerk, angular_jerk),
        ];
        for (field, value) in not_negative {
            if let Some(message) = out_of_range(field, value, Range::NotNegative) {
                faults.push(fault(field, message));
            }
        }
    }

    /// Returns the method for checked parameters.
    fn coupled(&self, all: &[Tool]) -> Coupled {
        let priors = self.device_mass.iter().zip(all).map(|(mass, tool)| {
            std::array::from_fn(|axis| {
                let prior = AxisPrior::new(mass[axis], self.encoder_quantum, self.prior);
                let prior = if tool.mass_table.is_some() {
                    prior.of_a_linkage()
                } else {
                    prior
                };
                if tool.axes[axis] {
                    prior
                } else {
                    prior.of_no_axis()
                }
            })
        });
        let turning_priors = all.iter().enumerate().map(|(number, tool)| {
            let moments = self.device_inertia.get(number).filter(|_| tool.turns)?;
            let moments = Vector3::from(*moments);
            let prior = TurningPrior::new(moments, self.angle_quantum, self.prior);
            Some(if tool.is_led() {
                prior.of_a_hand()
            } else {
                prior
            })
        });
        // The mass of a device that no force moves is irrelevant.
        let linkages = all.iter().zip(&self.device_mass).map(|(tool, mass)| {
            let mut there = mass.iter().zip(tool.axes).filter(|(_, has)| *has);
            Linkage::new(tool).filter(|_| there.all(|(mass, _)| mass.is_finite()))
        });
        Coupled {
            turning_priors: turning_priors.collect(),
            turn_limit: self.turn_limit,
            turn_return: self.turn_return,
            priors: priors.collect(),
            axes: all
                .iter()
                .map(|tool| Axes::new(tool.axes, tool.own_axes))
                .collect(),
            linkages: linkages.collect(),
            offset_limit: self.offset_limit,
            offset_return: self.offset_return,
            velocity_return: self.velocity_return,
        }
    }
}

/// Creates a fault of the method's parameters.
fn fault(field: WorldField, message: String) -> WorldError {
    WorldError::new(WorldPart::Method, field, "the method", message)
}
