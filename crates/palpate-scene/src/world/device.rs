//! Devices of a world.

use palpate_core::Range;
use palpate_world::{IDENTITY, Quaternion, Shape, Tool, Vector, WorldField, WorldPart};
use toml::Spanned;

use super::file::Reading;
use super::per_axis::{DeviceAxes, PerAxis};
use super::shape::unit;
use super::{DeviceTurning, Drivetrain, Tremor, TurningHand, WorldDevice};
use crate::device_key::{RawDevice, TurningKeys, span as key_span};
use crate::drivetrain_key::RawDrivetrain;
use crate::fault::Span;

/// Returns the error of a device's name that cannot begin the name of a column.
pub(crate) fn wrong_device_name(name: &str) -> Option<&'static str> {
    let is_wrong = |letter: char| letter.is_control() || "\",".contains(letter);
    name.contains(is_wrong).then_some(
        "a device's name begins column names, so it must have no comma, quotation mark or control character",
    )
}

/// Returns the error of a body's name that a terminal would take for a command.
pub(crate) fn wrong_body_name(name: &str) -> Option<&'static str> {
    name.contains(char::is_control)
        .then_some("a body's name must have no control character")
}

impl Reading {
    pub(super) fn device(&mut self, index: usize, raw: Spanned<RawDevice>) -> (Tool, WorldDevice) {
        let place = WorldPart::Tool(index);
        let span = raw.span();
        self.places.part(place, span.clone());
        let mut raw = raw.into_inner();
        let given = [raw.hand.tremor_n.take(), raw.hand.tremor_hz.take()];
        let tremor = self.tremor(given, raw.hand.tremor_n_m.is_some());
        let turning = self.turning(index, &mut raw, tremor.frequency_hz);
        self.check_name(&raw.name);
        let name = self.places.take(place, WorldField::Name, raw.name.clone());
        let axes = raw.axes.take().map_or(DeviceAxes::WORLD, |axes| {
            self.places.take(place, WorldField::Axes, axes)
        });
        let known = self.has_its_axes(index).then_some(axes.has);
        let tool = Tool {
            shape: match raw.tool.clone() {
                Some(tool) => self.shape(place, &name, tool),
                None => Shape::Sphere { radius: 0.0 },
            },
            name,
            turns: turning.is_some(),
            gives_torque: turning.is_none_or(|turning| turning.gives_torque),
            axes: axes.has,
            own_axes: axes.own,
            mass_table: None,
        };
        let position = self.vector("position_m", raw.position_m.take(), [0.0; 3]);
        let (tool, mass) = self.with_mass(index, span, tool, &mut raw, position);
        let coulomb = key_span(&raw.drivetrain.coulomb_friction_n);
        let velocity = raw.velocity_m_per_s.take();
        self.nothing_elsewhere("velocity_m_per_s", velocity.as_ref(), &tool, [0.0; 3]);
        let drivetrain = self.drivetrain(raw.drivetrain, raw.noise_m);
        if tool.mass_table.is_some() {
            for (key, span) in [
                ("device.hand.mass_kg", key_span(&raw.hand.mass_kg)),
                ("device.drivetrain.coulomb_friction_n", coulomb),
            ] {
                if let Some(span) = span {
                    self.fault(
                        span,
                        format!("{key} is for a device with mass_kg, not with a mass_table"),
                    );
                }
            }
        }
        let device = WorldDevice {
            own_axes: tool.own_axes,
            mass,
            position,
            velocity: self.vector("velocity_m_per_s", velocity, [0.0; 3]),
            quantum: raw.quantum_m.map_or([0.0; 3], |quantum| {
                self.per_axis("quantum_m", &quantum, Range::NotNegative, (known, 0.0))
            }),
            hand: self.hand(raw.hand, &tool, position, tremor),
            drivetrain,
            turning,
        };
        (tool, device)
    }

    /// Returns friction, motors and noise along each axis.
    fn drivetrain(&mut self, raw: RawDrivetrain, noise: Option<Spanned<f64>>) -> Drivetrain {
        let mut or = |key: &str, value: Option<Spanned<f64>>, otherwise, range| {
            value.map_or(otherwise, |value| self.number(key, value, range))
        };
        let least = Range::NotNegative;
        let keys = [
            "viscous_friction_n_s_per_m",
            "coulomb_friction_n",
            "motor_limit_n",
        ]
        .map(|key| format!("drivetrain.{key}"));
        Drivetrain {
            viscous_friction: or(&keys[0], raw.viscous_friction_n_s_per_m, 0.0, least),
            coulomb_friction: or(&keys[1], raw.coulomb_friction_n, 0.0, least),
            largest_force: or(&keys[2], raw.motor_limit_n, f64::INFINITY, Range::Positive),
            noise: or("noise_m", noise, 0.0, least),
        }
    }

    /// Rejects a name that cannot begin the name of a column.
    fn check_name(&mut self, name: &Spanned<String>) {
        if let Some(message) = wrong_device_name(name.get_ref()) {
            self.fault(name.span(), message);
        }
    }

    /// Returns the tool with its mass table, if it has one, and the mass along each axis `[kg]`. `span` is that of the
    /// device, `position` its start `[m]`.
    fn with_mass(
        &mut self,
        index: usize,
        span: Span,
        tool: Tool,
        raw: &mut RawDevice,
        position: Vector,
    ) -> (Tool, Vector) {
        let known = self.has_its_axes(index).then_some(tool.axes);
        match (raw.mass_kg.take(), raw.mass_table.take()) {
            (None, Some(table)) if known.is_some() => {
                self.with_mass_table(tool, table.into_inner(), position)
            }
            (Some(mass), None) => {
                let mass = self.mass(&mass, known);
                (tool, mass)
            }
            (mass, table) => {
                let message = match (mass, table) {
                    (Some(_), Some(_)) => "a device has either mass_kg or mass_table",
                    _ => "a device needs mass_kg, mass_table or linkage",
                };
                // The missing key may itself have been faulty, and a linkage has been refused.
                if !self.damaged.contains(&format!("device.{index}")) && raw.linkage.is_none() {
                    self.fault(span, message);
                }
                (tool, [1.0; 3])
            }
        }
    }

    /// Returns the mass along each axis; infinite along missing axes of the device.
    fn mass(&mut self, mass: &Spanned<PerAxis>, known: Option<[bool; 3]>) -> Vector {
        if mass.get_ref().given().contains(&f64::INFINITY) {
            let message = "mass_kg is inf: list the axes of the device in `axes`, such as axes = [\"x\", \"y\"], and \
                           give masses along these only";
            self.fault(mass.span(), message);
            return [1.0; 3];
        }
        let elsewhere = f64::INFINITY;
        self.per_axis("mass_kg", mass, Range::Positive, (known, elsewhere))
    }

    /// Reads the rotation of a six-axis device, which has an inertia.
    fn turning(
        &mut self,
        index: usize,
        raw: &mut RawDevice,
        frequency_hz: f64,
    ) -> Option<DeviceTurning> {
        let given = TurningKeys::take(raw);
        let Some(inertia) = raw.inertia_kg_m2.take() else {
            // The inertia has already been reported; the other keys are valid.
            if !self.lost_its_inertia(index) {
                for (span, message) in given.refused() {
                    self.fault(span, message);
                }
            }
            return None;
        };
        self.numbers(
            "inertia_kg_m2",
            inertia.span(),
            inertia.get_ref(),
            Range::Positive,
        );
        let tremor = given.tremor.map_or(0.0, |tremor| {
            if frequency_hz == 0.0 {
                let message = "a tremor needs both tremor_n_m and tremor_hz";
                self.fault(tremor.span(), message);
            }
            self.number("hand.tremor_n_m", tremor, Range::NotNegative)
        });
        let mut at_least_0 = |key: &str, value: Option<Spanned<f64>>| {
            value.map_or(0.0, |value| self.number(key, value, Range::NotNegative))
        };
        let stiffness = at_least_0("hand.rotational_stiffness_n_m_per_rad", given.stiffness);
        let damping = at_least_0("hand.rotational_damping_n_m_s_per_rad", given.damping);
        let quantum = at_least_0("quantum_rad", given.quantum);
        let orientation = self.orientation("orientation", given.orientation, IDENTITY);
        let angular_velocity = given.angular_velocity;
        Some(DeviceTurning {
            inertia: inertia.into_inner(),
            orientation,
            angular_velocity: self.vector("angular_velocity_rad_per_s", angular_velocity, [0.0; 3]),
            quantum,
            gives_torque: given.gives_torque.is_none_or(Spanned::into_inner),
            hand: TurningHand {
                torque: self.vector("hand.torque_n_m", given.torque, [0.0; 3]),
                stiffness,
                damping,
                rest: self.orientation("hand.rest_orientation", given.rest, orientation),
                tremor: Tremor {
                    amplitude: tremor,
                    frequency_hz,
                },
            },
        })
    }

    /// A quaternion of any length above 0, brought to length 1.
    fn orientation(
        &mut self,
        key: &'static str,
        value: Option<Spanned<Quaternion>>,
        default: Quaternion,
    ) -> Quaternion {
        let Some(value) = value else {
            return default;
        };
        let span = value.span();
        let given = value.into_inner();
        let length = given.iter().map(|part| part * part).sum::<f64>().sqrt();
        let has_direction = length > 0.0 && length.is_finite();
        if !has_direction {
            let message = format!(
                "{key} has length {length}, and has to be a quaternion [w, x, y, z] with a length above 0"
            );
            self.fault(span, message);
            return default;
        }
        unit(given)
    }
}
