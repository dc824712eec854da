//! Classic virtual coupling: a spring and a damper between the device and a proxy with mass.

use palpate_core::Range;

use crate::dynamics::moving_body::Drive;
use crate::error::out_of_range;
use crate::geometry::rigid::{Rotation, Vector3, quaternion};
use crate::geometry::turning::TurningDrive;
use crate::integration::interval::{Reach, advance};
use crate::method::state::{Progress, show_contacts};
use crate::{Effort, Tool, Vector, WorldError, WorldErrors, WorldField, WorldPart, WorldRenderer};

/// Parameters of virtual coupling.
///
/// The world collides with a proxy that has its own mass. A spring and a damper pull the proxy to the device's
/// position at the sample. The opposite of their force at the sample is held on the device.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VirtualCouplingParams {
    /// Stiffness of each tool's spring, above 0 `[N/m]`.
    pub stiffness: Vec<f64>,
    /// Damping of each tool's damper, at least 0 `[N s/m]`.
    pub damping: Vec<f64>,
    /// Mass of each tool's proxy, above 0 `[kg]`.
    pub mass: Vec<f64>,
    /// Rotational stiffness of each tool, above 0 `[N m/rad]`. The rotational lists are empty if no tool renders
    /// torque.
    pub rotational_stiffness: Vec<f64>,
    /// Rotational damping of each tool, at least 0 `[N m s/rad]`.
    pub rotational_damping: Vec<f64>,
    /// Moment of inertia of each proxy about any axis, above 0 `[kg m^2]`.
    pub inertia: Vec<f64>,
}

/// Translational coupling of a tool, or its rotational coupling with stiffness `[N m/rad]`, damping `[N m s/rad]` and
/// moment of inertia `[kg m^2]`.
#[derive(Clone, Copy, Debug)]
struct Coupling {
    stiffness: f64,
    damping: f64,
    mass: f64,
}

impl VirtualCouplingParams {
    pub(super) fn check(self, all: &[Tool]) -> Result<VirtualCoupling, WorldErrors> {
        let tools = all.len();
        WorldErrors::check(self.faults(all))?;
        let coupling = |lists: [&[f64]; 3], tool: usize| Coupling {
            stiffness: lists[0][tool],
            damping: lists[1][tool],
            mass: lists[2][tool],
        };
        let linear = [&self.stiffness[..], &self.damping, &self.mass];
        let turned = [
            &self.rotational_stiffness[..],
            &self.rotational_damping,
            &self.inertia,
        ];
        Ok(VirtualCoupling {
            couplings: (0..tools).map(|tool| coupling(linear, tool)).collect(),
            turning: (0..tools)
                .map(|tool| all[tool].feels_torque().then(|| coupling(turned, tool)))
                .collect(),
        })
    }

    /// Returns the faults of all lists: a wrong number of entries, and entries out of range.
    fn faults(&self, all: &[Tool]) -> Vec<WorldError> {
        let tools = all.len();
        let mut faults = Vec::new();
        let turning = if all.iter().any(Tool::feels_torque) {
            tools
        } else {
            0
        };
        let lists = [
            (
                WorldField::Stiffness,
                &self.stiffness,
                Range::Positive,
                tools,
            ),
            (
                WorldField::Damping,
                &self.damping,
                Range::NotNegative,
                tools,
            ),
            (WorldField::Mass, &self.mass, Range::Positive, tools),
            (
                WorldField::RotationalStiffness,
                &self.rotational_stiffness,
                Range::Positive,
                turning,
            ),
            (
                WorldField::RotationalDamping,
                &self.rotational_damping,
                Range::NotNegative,
                turning,
            ),
            (WorldField::Inertia, &self.inertia, Range::Positive, turning),
        ];
        for (field, list, range, asked) in lists {
            let mut fault = |message: String| {
                faults.push(WorldError::new(
                    WorldPart::Method,
                    field,
                    "the method",
                    message,
                ));
            };
            let count = list.len();
            if count != asked && asked > 0 {
                fault(format!(
                    "{field} has {count} entries for {tools} tools; give one for each"
                ));
            } else if count != asked && count != tools {
                fault(format!(
                    "{field} has {count} entries, and no tool gives a torque; give none"
                ));
            }
            let wrong = list
                .iter()
                .filter_map(|value| out_of_range(field, *value, range));
            wrong.for_each(&mut fault);
        }
        faults
    }
}

/// Inverse moments of inertia of a proxy that rotates with its device `[1/(kg m^2)]`. The value is arbitrary, because
/// no torque acts on the proxy.
const OF_A_LED_TURN: Vector3 = Vector3::new(1.0, 1.0, 1.0);

/// Virtual coupling, with checked parameters.
#[derive(Clone, Debug)]
pub(crate) struct VirtualCoupling {
    couplings: Vec<Coupling>,
    /// Rotational coupling of each tool that renders torque.
    turning: Vec<Option<Coupling>>,
}

/// State of virtual coupling.
#[derive(Clone, Debug)]
pub(crate) struct VirtualCouplingMemory {
    devices: Vec<LastSample>,
}

/// A device at the last sample.
#[derive(Clone, Copy, Debug)]
struct LastSample {
    position: Vector3,
    /// Velocity over the last step `[m/s]`.
    velocity: Vector3,
    orientation: Rotation,
    /// Angular velocity over the last step `[rad/s]`.
    turning: Vector3,
}

impl VirtualCouplingMemory {
    /// Copies the state of `other`, which has the same number of tools.
    pub fn copy_from(&mut self, other: &Self) {
        self.devices.copy_from_slice(&other.devices);
    }

    pub fn new(tools: usize) -> Self {
        let device = LastSample {
            position: Vector3::zeros(),
            velocity: Vector3::zeros(),
            orientation: Rotation::identity(),
            turning: Vector3::zeros(),
        };
        Self {
            devices: vec![device; tools],
        }
    }

    /// Writes the estimated state of the tools.
    pub fn publish(&self, state: &mut Progress) {
        for (tool, (device, part)) in state
            .tools
            .iter_mut()
            .zip(self.devices.iter().zip(&state.now.parts))
        {
            let rigid = &part.rigid;
            tool.position = device.position.into();
            tool.velocity = device.velocity.into();
            tool.proxy_position = rigid.position.into();
            tool.proxy_velocity = rigid.velocity.into();
            tool.offset = (rigid.position - device.position).into();
            tool.velocity_offset = (rigid.velocity - device.velocity).into();
            tool.orientation = quaternion(&device.orientation);
            tool.angular_velocity = device.turning.into();
            tool.proxy_orientation = quaternion(&rigid.orientation);
            let apart = rigid.orientation * device.orientation.inverse();
            tool.turn_offset = apart.scaled_axis().into();
        }
    }
}

impl VirtualCoupling {
    /// Returns the inverse moments of inertia of the proxy of a tool that contacts turn `[1/(kg m^2)]`.
    pub fn angular_mobility(&self, tool: usize) -> Vector3 {
        let coupling = self.turning.get(tool).copied().flatten();
        coupling.map_or(Vector3::zeros(), |coupling| {
            Vector3::repeat(1.0 / coupling.mass)
        })
    }

    pub fn begin(
        &self,
        renderer: &WorldRenderer,
        state: &mut Progress,
        memory: &mut VirtualCouplingMemory,
        positions: &[Vector],
    ) {
        let parts = state.now.parts.iter_mut().zip(&mut memory.devices);
        for ((part, device), position) in parts.zip(positions) {
            device.position = Vector3::from(*position);
            device.velocity = Vector3::zeros();
            part.rigid.position = device.position;
            part.rigid.velocity = Vector3::zeros();
        }
        let parts = state.now.parts.iter_mut().zip(&renderer.axes);
        for ((part, axes), coupling) in parts.zip(&self.couplings) {
            part.mobility.linear = axes.where_there(1.0 / coupling.mass);
        }
        for (tool, device) in memory.devices.iter_mut().enumerate() {
            device.orientation = state.tracking.seen_turn[tool];
            device.turning = Vector3::zeros();
            let part = &mut state.now.parts[tool];
            part.rigid.orientation = device.orientation;
            part.rigid.spin = Vector3::zeros();
            part.mobility.angular = if part.led {
                OF_A_LED_TURN
            } else {
                self.angular_mobility(tool)
            };
        }
        state.now.look(&renderer.points);
        state.ledger.observe(&state.now, &renderer.points);
    }

    pub fn conclude(
        &self,
        renderer: &WorldRenderer,
        state: &mut Progress,
        memory: &mut VirtualCouplingMemory,
        positions: &[Vector],
        elapsed: f64,
    ) -> Effort {
        let points = &renderer.points;
        // Along an axis that its device lacks, a proxy followed the device.
        let parts = state.now.parts.iter_mut().zip(&renderer.axes);
        for ((part, axes), (device, position)) in parts.zip(memory.devices.iter().zip(positions)) {
            let led = (Vector3::from(*position) - device.position) / elapsed;
            part.rigid.velocity = axes.mixed(&part.rigid.velocity, &led);
        }
        // A tool turned by its hand has rotated with its device.
        let seen = memory.devices.iter().zip(&state.tracking.seen_turn);
        let mut is_any_led = false;
        for (part, (device, turned)) in state.now.parts.iter_mut().zip(seen) {
            if part.led {
                let by = (turned * device.orientation.inverse()).scaled_axis();
                part.set_turning(&(by / elapsed));
                is_any_led = true;
            }
        }
        if is_any_led || !renderer.axes.iter().all(|axes| axes.are_all()) {
            state.now.look(points);
            state.ledger.observe(&state.now, points);
        }
        state.now.begin();
        let sub_steps = &renderer.loop_params.sub_steps;
        let effort = advance(
            &mut state.now,
            &mut state.room,
            points,
            sub_steps,
            Reach::All,
            elapsed,
        );
        state.ledger.pass(&state.now, points, renderer.tools);
        for (tool, device) in memory.devices.iter_mut().enumerate() {
            let way = Vector3::from(positions[tool]) - device.position;
            device.position += way;
            device.velocity = way / elapsed;
            let axes = renderer.axes[tool];
            let place = &mut state.now.parts[tool].rigid.position;
            *place = axes.mixed(place, &device.position);
            let turned = state.tracking.seen_turn[tool];
            let by = (turned * device.orientation.inverse()).scaled_axis();
            device.orientation = turned;
            device.turning = by / elapsed;
            let part = &mut state.now.parts[tool];
            let led = part.led;
            if led {
                part.rigid.orientation = turned;
            }
            let entry = &mut state.ledger.devices[tool];
            for &number in state.now.nearby.recent() {
                let (point, touch) = (&points[number], &state.now.touches[number]);
                let contact = &mut state.ledger.contacts[number];
                if let Some(sign) = point.sign_on(tool) {
                    let past = &touch.past;
                    let impulse = past.impulse.dot(&way) * sign;
                    let held = if led {
                        entry.carried += past.work_on_led_turn;
                        impulse / elapsed + past.work_on_led_turn
                    } else {
                        (impulse + past.angular_impulse.dot(&by)) / elapsed
                    };
                    let carried = axes.across(&touch.past.impulse).dot(&way);
                    entry.carried += carried * sign / elapsed;
                    contact.held += held;
                    entry.held += held;
                }
            }
            entry.port_work += state.commands.passed(tool).sent.dot(&way)
                + state.torque_commands.passed_or_none(tool).dot(&by);
            entry.unforeseen = entry.port_work + entry.carried - entry.held;
        }
        effort
    }

    pub fn plan(
        &self,
        renderer: &WorldRenderer,
        state: &mut Progress,
        memory: &VirtualCouplingMemory,
    ) -> Effort {
        show_contacts(&mut state.contacts, &mut state.shown, &state.now);
        let devices = memory.devices.iter().zip(&self.couplings);
        let devices = devices.zip(&renderer.axes);
        for ((part, intended), ((device, coupling), axes)) in state
            .now
            .parts
            .iter_mut()
            .zip(&mut state.intended)
            .zip(devices)
        {
            let Coupling {
                stiffness,
                damping,
                mass,
            } = *coupling;
            let pull = (device.position - part.rigid.position) * stiffness
                + (device.velocity - part.rigid.velocity) * damping;
            let pull = axes.along(&pull);
            part.drive = Drive {
                damping_rate: axes.where_there(damping / mass),
                spring_rate: axes.where_there(stiffness / mass),
                ..Drive::constant(pull / mass)
            };
            *intended = state.commands.for_force(&-pull);
        }
        let devices = memory.devices.iter().zip(&self.turning);
        for (tool, (device, coupling)) in devices.enumerate() {
            let Some(coupling) = coupling else {
                continue;
            };
            let part = &mut state.now.parts[tool];
            let slowed = device.turning - part.rigid.spin / coupling.mass;
            part.turning_drive = TurningDrive {
                torque: slowed * coupling.damping,
                damping_rate: coupling.damping / coupling.mass,
                stiffness: coupling.stiffness,
                aim: device.orientation,
                ..TurningDrive::none()
            };
            let apart = (device.orientation * part.rigid.orientation.inverse()).scaled_axis();
            let pull = apart * coupling.stiffness + slowed * coupling.damping;
            state.intended_torques[tool] = state.torque_commands.for_force(&-pull);
        }
        Effort::default()
    }
}
