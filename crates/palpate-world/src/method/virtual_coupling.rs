//! The classic virtual coupling: a spring and a damper between device and avatar, which the world meets.

use crate::interval::advance;
use crate::part::Drive;
use crate::rigid::Vector3;
use crate::state::{Progress, show_contacts};
use crate::{Effort, Place, Vector, WorldError, WorldRenderer};

/// Parameters of rendering by a virtual coupling.
///
/// The world meets an avatar that has a mass of its own. A spring and a damper pull it to the device as that was at
/// the sample; their force at the sample, turned round, is held on the device.
#[derive(Clone, Debug, PartialEq)]
pub struct VirtualCouplingParams {
    /// Stiffness of each tool's spring, above 0 `[N/m]`.
    pub stiffness: Vec<f64>,
    /// Damping of each tool's damper, at least 0 `[N s/m]`.
    pub damping: Vec<f64>,
    /// Mass of each tool's avatar, above 0 `[kg]`.
    pub mass: Vec<f64>,
}

/// The coupling of one tool.
#[derive(Clone, Copy, Debug)]
struct Coupling {
    stiffness: f64,
    damping: f64,
    mass: f64,
}

impl VirtualCouplingParams {
    pub(super) fn check(self, tools: usize) -> Result<VirtualCoupling, Vec<WorldError>> {
        let mut faults = Vec::new();
        let lists = [
            ("stiffness", &self.stiffness, true),
            ("damping", &self.damping, false),
            ("mass", &self.mass, true),
        ];
        for (field, list, above_zero) in lists {
            let mut fault = |message: String| {
                faults.push(WorldError::new(Place::Method, field, "the method", message));
            };
            if list.len() != tools {
                let count = list.len();
                fault(format!(
                    "{field} has {count} entries for {tools} tools; give one for each"
                ));
            }
            for value in list {
                let allowed = if above_zero {
                    *value > 0.0
                } else {
                    *value >= 0.0
                };
                if !(allowed && value.is_finite()) {
                    let range = if above_zero { "above 0" } else { "at least 0" };
                    fault(format!("{field} is {value}, and has to be {range}"));
                }
            }
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        let each = self.stiffness.iter().zip(&self.damping).zip(&self.mass);
        let couplings = each.map(|((&stiffness, &damping), &mass)| Coupling {
            stiffness,
            damping,
            mass,
        });
        Ok(VirtualCoupling {
            couplings: couplings.collect(),
        })
    }
}

/// Rendering by a virtual coupling, with checked parameters.
#[derive(Clone, Debug)]
pub(crate) struct VirtualCoupling {
    couplings: Vec<Coupling>,
}

/// What rendering by a virtual coupling remembers.
#[derive(Clone, Debug)]
pub(crate) struct VirtualCouplingMemory {
    devices: Vec<Device>,
}

/// A device at the last sample.
#[derive(Clone, Copy, Debug)]
struct Device {
    position: Vector3,
    /// Of its last step `[m/s]`.
    velocity: Vector3,
}

impl VirtualCouplingMemory {
    pub fn new(tools: usize) -> Self {
        let device = Device {
            position: Vector3::zeros(),
            velocity: Vector3::zeros(),
        };
        Self {
            devices: vec![device; tools],
        }
    }

    /// Writes what is known of the tools.
    pub fn publish(&self, state: &mut Progress) {
        for (tool, (device, part)) in state
            .tools
            .iter_mut()
            .zip(self.devices.iter().zip(&state.now.parts))
        {
            let rigid = &part.rigid;
            tool.position = device.position.into();
            tool.velocity = device.velocity.into();
            tool.avatar_position = rigid.position.into();
            tool.avatar_velocity = rigid.velocity.into();
            tool.offset = (rigid.position - device.position).into();
            tool.velocity_offset = (rigid.velocity - device.velocity).into();
        }
    }
}

impl VirtualCoupling {
    pub fn begin(
        &self,
        renderer: &WorldRenderer,
        state: &mut Progress,
        memory: &mut VirtualCouplingMemory,
        positions: &[Vector],
    ) {
        let parts = state.now.parts.iter_mut().zip(&mut memory.devices);
        for ((part, device), (coupling, position)) in
            parts.zip(self.couplings.iter().zip(positions))
        {
            device.position = Vector3::from(*position);
            device.velocity = Vector3::zeros();
            part.rigid.position = device.position;
            part.rigid.velocity = Vector3::zeros();
            part.mobility.linear = Vector3::repeat(1.0 / coupling.mass);
        }
        state.now.look(&renderer.points);
        state.books.observe(&state.now, &renderer.points);
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
        state.now.begin();
        let sub_steps = &renderer.in_loop.sub_steps;
        let effort = advance(&mut state.now, &mut state.room, points, sub_steps, elapsed);
        state.books.pass(&state.now, points, renderer.tools);
        for (tool, device) in memory.devices.iter_mut().enumerate() {
            let way = Vector3::from(positions[tool]) - device.position;
            device.position += way;
            device.velocity = way / elapsed;
            let book = &mut state.books.devices[tool];
            for (point, (touch, contact)) in points
                .iter()
                .zip(state.now.touches.iter().zip(&mut state.books.contacts))
            {
                if point.first == tool {
                    let held = touch.past.impulse.dot(&way) / elapsed;
                    contact.held += held;
                    book.held += held;
                }
            }
            book.port_work += state.commands.passed(tool).sent.dot(&way);
            book.unforeseen = book.port_work - book.held;
        }
        effort
    }

    pub fn plan(&self, state: &mut Progress, memory: &VirtualCouplingMemory) -> Effort {
        show_contacts(&mut state.contacts, &state.now);
        let devices = memory.devices.iter().zip(&self.couplings);
        for ((part, intended), (device, coupling)) in state
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
            part.drive = Drive {
                damping_rate: Vector3::repeat(damping / mass),
                spring_rate: Vector3::repeat(stiffness / mass),
                ..Drive::constant(pull / mass)
            };
            *intended = state.commands.for_force(&-pull);
        }
        Effort::default()
    }
}
