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
use crate::fault::Span;

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

/// The keys of a device's rotation, without its inertia.
struct TurningKeys {
    /// Rotational stiffness of the hand `[N m/rad]`.
    stiffness: Option<Spanned<f64>>,
    /// Rotational damping of the hand `[N m s/rad]`.
    damping: Option<Spanned<f64>>,
    /// Quantum of the angle sensor `[rad]`.
    quantum: Option<Spanned<f64>>,
    /// Amplitude of the tremor's torque `[N m]`.
    tremor: Option<Spanned<f64>>,
    /// Orientation at the start.
    orientation: Option<Spanned<Quaternion>>,
    /// Orientation at which the hand is at rest.
    rest: Option<Spanned<Quaternion>>,
    /// Torque of the hand `[N m]`.
    torque: Option<Spanned<Vector>>,
    /// Angular velocity at the start `[rad/s]`.
    angular_velocity: Option<Spanned<Vector>>,
    /// Whether the motors give torques.
    gives_torque: Option<Spanned<bool>>,
}

impl TurningKeys {
    /// Takes the keys out of a device; `tremor` is the amplitude of the torque `[N m]`.
    fn take(raw: &mut RawDevice, tremor: Option<Spanned<f64>>) -> Self {
        Self {
            stiffness: raw.hand_rotational_stiffness_n_m_per_rad.take(),
            damping: raw.hand_rotational_damping_n_m_s_per_rad.take(),
            quantum: raw.quantum_rad.take(),
            tremor,
            orientation: raw.orientation.take(),
            rest: raw.hand_rest_orientation.take(),
            torque: raw.hand_torque_n_m.take(),
            angular_velocity: raw.angular_velocity_rad_per_s.take(),
            gives_torque: raw.gives_torque.take(),
        }
    }

    /// Returns the name of each key, and its span if it is given.
    fn spans(&self) -> [(&'static str, Option<Span>); 9] {
        [
            (
                "hand_rotational_stiffness_n_m_per_rad",
                span(&self.stiffness),
            ),
            ("hand_rotational_damping_n_m_s_per_rad", span(&self.damping)),
            ("quantum_rad", span(&self.quantum)),
            ("tremor_n_m", span(&self.tremor)),
            ("orientation", span(&self.orientation)),
            ("hand_rest_orientation", span(&self.rest)),
            ("hand_torque_n_m", span(&self.torque)),
            ("angular_velocity_rad_per_s", span(&self.angular_velocity)),
            ("gives_torque", span(&self.gives_torque)),
        ]
    }
}

/// Returns the span of a value, if it is given.
fn span<T>(value: &Option<Spanned<T>>) -> Option<Span> {
    value.as_ref().map(Spanned::span)
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
        let given = [raw.tremor_n.take(), raw.tremor_hz.take()];
        let tremor = self.tremor(given, tremor_torque.is_some());
        let turning = self.turning(index, &mut raw, tremor_torque, tremor.frequency_hz);
        self.check_name(&raw.name);
        let name = self.places.take(place, WorldField::Name, raw.name.clone());
        let axes = raw.axes.take().map_or(DeviceAxes::WORLD, |axes| {
            self.places.take(place, WorldField::Axes, axes)
        });
        let known = self.has_its_axes(index).then_some(axes.has);
        let tool = Tool {
            shape: self.shape(place, &name, raw.tool.clone()),
            name,
            turns: turning.is_some(),
            gives_torque: turning.is_none_or(|turning| turning.gives_torque),
            axes: axes.has,
            own_axes: axes.own,
            mass_table: None,
        };
        let position = self.vector("position_m", raw.position_m.take(), [0.0; 3]);
        let (tool, mass) = self.with_mass(index, span, tool, &mut raw, position);
        let hand = self.hand(&mut raw, &tool, position, tremor);
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

    /// Returns the tremor of an amplitude `[N]` and a frequency `[Hz]`; the latter may be alone if the tremor has a
    /// torque.
    fn tremor(&mut self, given: [Option<Spanned<f64>>; 2], has_torque: bool) -> Tremor {
        match given.into() {
            (None, Some(frequency)) if has_torque => Tremor {
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
        }
    }

    /// Rejects a name that cannot begin the name of a column.
    fn check_name(&mut self, name: &Spanned<String>) {
        if name
            .get_ref()
            .contains(|letter: char| letter.is_control() || "\",".contains(letter))
        {
            let message = "a device's name begins column names, so it must have no comma, quotation mark or control \
                           character";
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
                    _ => "a device needs either mass_kg or mass_table",
                };
                // The missing key may itself have been faulty.
                if !self.damaged.contains(&format!("device.{index}")) {
                    self.fault(span, message);
                }
                (tool, [1.0; 3])
            }
        }
    }

    /// Returns the hand, whose rest is by default the device's `position` `[m]`. Rejects velocities, forces and rests
    /// along the axes that the tool lacks.
    fn hand(
        &mut self,
        raw: &mut RawDevice,
        tool: &Tool,
        position: Vector,
        tremor: Tremor,
    ) -> WorldHand {
        let mut at_least_0 = |key: &str, value: Option<Spanned<f64>>| {
            value.map_or(0.0, |value| self.number(key, value, Range::NotNegative))
        };
        let stiffness = at_least_0("hand_stiffness_n_per_m", raw.hand_stiffness_n_per_m.take());
        let damping = at_least_0("hand_damping_n_s_per_m", raw.hand_damping_n_s_per_m.take());
        for (key, value, held) in [
            ("velocity_m_per_s", &raw.velocity_m_per_s, [0.0; 3]),
            ("hand_force_n", &raw.hand_force_n, [0.0; 3]),
            ("hand_rest_m", &raw.hand_rest_m, position),
        ] {
            self.nothing_elsewhere(key, value.as_ref(), tool, held);
        }
        WorldHand {
            force: self.vector("hand_force_n", raw.hand_force_n.take(), [0.0; 3]),
            stiffness,
            damping,
            rest: self.vector("hand_rest_m", raw.hand_rest_m.take(), position),
            tremor,
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
        let given = TurningKeys::take(raw, tremor);
        let Some(inertia) = raw.inertia_kg_m2.take() else {
            // The inertia has already been reported; the other keys are valid.
            if !self.lost_its_inertia(index) {
                self.refuse_turning(&given);
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
            self.number("tremor_n_m", tremor, Range::NotNegative)
        });
        let mut at_least_0 = |key: &str, value: Option<Spanned<f64>>| {
            value.map_or(0.0, |value| self.number(key, value, Range::NotNegative))
        };
        let stiffness = at_least_0("hand_rotational_stiffness_n_m_per_rad", given.stiffness);
        let damping = at_least_0("hand_rotational_damping_n_m_s_per_rad", given.damping);
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
                torque: self.vector("hand_torque_n_m", given.torque, [0.0; 3]),
                stiffness,
                damping,
                rest: self.orientation("hand_rest_orientation", given.rest, orientation),
                tremor: Tremor {
                    amplitude: tremor,
                    frequency_hz,
                },
            },
        })
    }

    /// Rejects the keys of a rotation, for a device without an inertia.
    fn refuse_turning(&mut self, given: &TurningKeys) {
        for (key, span) in given.spans() {
            if let Some(span) = span {
                let message =
                    format!("{key} needs a device of six axes, with inertia_kg_m2 (three moments)");
                self.fault(span, message);
            }
        }
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
