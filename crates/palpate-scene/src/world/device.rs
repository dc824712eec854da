//! Devices as a file gives them.

use palpate_core::Range;
use palpate_world::{IDENTITY, Quaternion, Tool, Vector, WorldField, WorldPart};
use serde::Deserialize;
use toml::Spanned;

use super::file::Reading;
use super::mass_table::RawMassTable;
use super::per_axis::{DeviceAxes, PerAxis};
use super::shape::{RawShape, unit};
use super::{DeviceTurning, Tremor, TurningHand, WorldDevice, WorldHand};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawDevice {
    name: Spanned<String>,
    axes: Option<Spanned<DeviceAxes>>,
    mass_kg: Option<Spanned<PerAxis>>,
    mass_table: Option<Spanned<RawMassTable>>,
    position_m: Option<Spanned<Vector>>,
    velocity_m_per_s: Option<Spanned<Vector>>,
    quantum_m: Option<Spanned<PerAxis>>,
    hand_force_n: Option<Spanned<Vector>>,
    hand_stiffness_n_per_m: Option<Spanned<f64>>,
    hand_damping_n_s_per_m: Option<Spanned<f64>>,
    hand_rest_m: Option<Spanned<Vector>>,
    tremor_n: Option<Spanned<f64>>,
    tremor_hz: Option<Spanned<f64>>,
    inertia_kg_m2: Option<Spanned<Vector>>,
    gives_torque: Option<Spanned<bool>>,
    orientation: Option<Spanned<Quaternion>>,
    angular_velocity_rad_per_s: Option<Spanned<Vector>>,
    quantum_rad: Option<Spanned<f64>>,
    hand_torque_n_m: Option<Spanned<Vector>>,
    hand_rotational_stiffness_n_m_per_rad: Option<Spanned<f64>>,
    hand_rotational_damping_n_m_s_per_rad: Option<Spanned<f64>>,
    hand_rest_orientation: Option<Spanned<Quaternion>>,
    tremor_n_m: Option<Spanned<f64>>,
    tool: Spanned<RawShape>,
}

/// Largest component of a vector outside the axes of its device, relative to its largest component: decimal fractions
/// are rounded.
const MAX_BEYOND: f64 = 1e-6;

impl Reading {
    pub(super) fn device(&mut self, index: usize, raw: Spanned<RawDevice>) -> (Tool, WorldDevice) {
        let place = WorldPart::Tool(index);
        let span = raw.span();
        self.places.part(place, span.clone());
        let mut raw = raw.into_inner();
        let tremor_torque = raw.tremor_n_m.take();
        let tremor = match (raw.tremor_n.take(), raw.tremor_hz.take()) {
            (None, Some(frequency)) if tremor_torque.is_some() => Tremor {
                amplitude: 0.0,
                frequency_hz: self.number("tremor_hz", frequency, Range::Positive),
            },
            (Some(amplitude), Some(frequency)) => Tremor {
                amplitude: self.number("tremor_n", amplitude, Range::NotNegative),
                frequency_hz: self.number("tremor_hz", frequency, Range::Positive),
            },
            (None, None) => Tremor::default(),
            (Some(key), None) | (None, Some(key)) => {
                self.fault(key.span(), "a tremor needs both tremor_n and tremor_hz");
                Tremor::default()
            }
        };
        let turning = self.turning(index, &mut raw, tremor_torque, tremor.frequency_hz);
        if raw
            .name
            .get_ref()
            .contains(|letter: char| letter.is_control() || "\",".contains(letter))
        {
            let message = "a device's name begins column names, so it must have no comma, quotation mark or control \
                           character";
            self.fault(raw.name.span(), message);
        }
        let name = self.places.take(place, WorldField::Name, raw.name);
        let axes = raw.axes.take().map_or(DeviceAxes::WORLD, |axes| {
            self.places.take(place, WorldField::Axes, axes)
        });
        let known = self.has_its_axes(index).then_some(axes.has);
        let tool = Tool {
            shape: self.shape(place, &name, raw.tool),
            name,
            turns: turning.is_some(),
            gives_torque: turning.is_none_or(|turning| turning.gives_torque),
            axes: axes.has,
            own_axes: axes.own,
            mass_table: None,
        };
        let position = self.vector("position_m", raw.position_m, [0.0; 3]);
        let (tool, mass) = match (raw.mass_kg, raw.mass_table) {
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
                    _ => "a device needs either mass_kg or mass_table",
                };
                // The missing key may itself have been faulty.
                if !self.damaged.contains(&format!("device.{index}")) {
                    self.fault(span, message);
                }
                (tool, [1.0; 3])
            }
        };
        let mut at_least_0 = |key: &str, value: Option<Spanned<f64>>| {
            value.map_or(0.0, |value| self.number(key, value, Range::NotNegative))
        };
        let stiffness = at_least_0("hand_stiffness_n_per_m", raw.hand_stiffness_n_per_m);
        let damping = at_least_0("hand_damping_n_s_per_m", raw.hand_damping_n_s_per_m);
        for (key, value, held) in [
            ("velocity_m_per_s", &raw.velocity_m_per_s, [0.0; 3]),
            ("hand_force_n", &raw.hand_force_n, [0.0; 3]),
            ("hand_rest_m", &raw.hand_rest_m, position),
        ] {
            self.nothing_elsewhere(key, value.as_ref(), &tool, held);
        }
        let hand = WorldHand {
            force: self.vector("hand_force_n", raw.hand_force_n, [0.0; 3]),
            stiffness,
            damping,
            rest: self.vector("hand_rest_m", raw.hand_rest_m, position),
            tremor,
        };
        let device = WorldDevice {
            own_axes: tool.own_axes,
            mass,
            position,
            velocity: self.vector("velocity_m_per_s", raw.velocity_m_per_s, [0.0; 3]),
            quantum: raw.quantum_m.map_or([0.0; 3], |quantum| {
                self.per_axis("quantum_m", &quantum, Range::NotNegative, (known, 0.0))
            }),
            hand,
            turning,
        };
        (tool, device)
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

    /// Rejects a value that would move a tool along an axis that its device lacks. `held` is the value that is allowed
    /// there.
    fn nothing_elsewhere(
        &mut self,
        key: &str,
        value: Option<&Spanned<Vector>>,
        tool: &Tool,
        held: Vector,
    ) {
        let Some(value) = value else {
            return;
        };
        let lacking = (0..3).filter(|&axis| !tool.axes[axis]);
        if let Some(own) = &tool.own_axes {
            let given = value.get_ref();
            let beyond = |axis: usize| {
                let parts = own[axis].iter().zip(given.iter().zip(held));
                parts
                    .map(|(of, (given, held))| of * (given - held))
                    .sum::<f64>()
            };
            let off = lacking.map(beyond).fold(0.0, |a: f64, b: f64| a.hypot(b));
            let size = given
                .iter()
                .chain(&held)
                .fold(0.0, |most: f64, part| most.max(part.abs()));
            if off > MAX_BEYOND * size {
                let message = format!(
                    "{key} has a component of {off} along an axis that is not in the `axes` of the device: its \
                     mechanism blocks that axis; give components along its axes only"
                );
                self.fault(value.span(), message);
            }
            return;
        }
        for axis in lacking {
            let given = value.get_ref()[axis];
            let name = ["x", "y", "z"][axis];
            if given != held[axis] {
                let message = format!(
                    "{key} is {given} along {name}, but the `axes` of the device are {} only: its mechanism blocks \
                     {name}; write {} there",
                    tool.names_of_axes(),
                    held[axis]
                );
                self.fault(value.span(), message);
            }
        }
    }

    /// Reads the rotation of a six-axis device, which has an inertia.
    fn turning(
        &mut self,
        index: usize,
        raw: &mut RawDevice,
        tremor: Option<Spanned<f64>>,
        frequency_hz: f64,
    ) -> Option<DeviceTurning> {
        let stiffness = raw.hand_rotational_stiffness_n_m_per_rad.take();
        let damping = raw.hand_rotational_damping_n_m_s_per_rad.take();
        let quantum = raw.quantum_rad.take();
        let orientation = raw.orientation.take();
        let rest = raw.hand_rest_orientation.take();
        let torque = raw.hand_torque_n_m.take();
        let angular_velocity = raw.angular_velocity_rad_per_s.take();
        let gives_torque = raw.gives_torque.take();
        let Some(inertia) = raw.inertia_kg_m2.take() else {
            // The inertia has already been reported; the other keys are valid.
            if self.lost_its_inertia(index) {
                return None;
            }
            let spans = [
                ("hand_rotational_stiffness_n_m_per_rad", &stiffness),
                ("hand_rotational_damping_n_m_s_per_rad", &damping),
                ("quantum_rad", &quantum),
                ("tremor_n_m", &tremor),
            ]
            .map(|(key, value)| (key, value.as_ref().map(Spanned::span)));
            let more = [
                ("orientation", orientation.as_ref().map(Spanned::span)),
                ("hand_rest_orientation", rest.as_ref().map(Spanned::span)),
                ("hand_torque_n_m", torque.as_ref().map(Spanned::span)),
                (
                    "angular_velocity_rad_per_s",
                    angular_velocity.as_ref().map(Spanned::span),
                ),
                ("gives_torque", gives_torque.as_ref().map(Spanned::span)),
            ];
            for (key, span) in spans.into_iter().chain(more) {
                if let Some(span) = span {
                    let message = format!(
                        "{key} needs a device of six axes, with inertia_kg_m2 (three moments)"
                    );
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
        let tremor = tremor.map_or(0.0, |tremor| {
            if frequency_hz == 0.0 {
                let message = "a tremor needs both tremor_n_m and tremor_hz";
                self.fault(tremor.span(), message);
            }
            self.number("tremor_n_m", tremor, Range::NotNegative)
        });
        let mut at_least_0 = |key: &str, value: Option<Spanned<f64>>| {
            value.map_or(0.0, |value| self.number(key, value, Range::NotNegative))
        };
        let stiffness = at_least_0("hand_rotational_stiffness_n_m_per_rad", stiffness);
        let damping = at_least_0("hand_rotational_damping_n_m_s_per_rad", damping);
        let quantum = at_least_0("quantum_rad", quantum);
        let orientation = self.orientation("orientation", orientation, IDENTITY);
        Some(DeviceTurning {
            inertia: inertia.into_inner(),
            orientation,
            angular_velocity: self.vector("angular_velocity_rad_per_s", angular_velocity, [0.0; 3]),
            quantum,
            gives_torque: gives_torque.is_none_or(Spanned::into_inner),
            hand: TurningHand {
                torque: self.vector("hand_torque_n_m", torque, [0.0; 3]),
                stiffness,
                damping,
                rest: self.orientation("hand_rest_orientation", rest, orientation),
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
