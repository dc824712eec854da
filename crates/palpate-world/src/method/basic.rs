//! Basic rendering: the spring force at the sample.

use palpate_core::Range;

use super::one_per_tool;
use crate::dynamics::moving_body::Drive;
use crate::error::out_of_range;
use crate::geometry::rigid::{Rotation, Vector3, quaternion};
use crate::geometry::turning::TurningDrive;
use crate::integration::interval::{Reach, advance};
use crate::method::state::{Progress, show_contacts};
use crate::{Effort, Vector, WorldError, WorldErrors, WorldField, WorldPart, WorldRenderer};

/// Parameters of basic rendering.
///
/// The force on a tool is the force of contacts and fields at the sample. Over the interval the bodies move against the tool at its
/// position at the sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BasicParams {
    /// Damping of each tool's virtual damper, at least 0 `[N s/m]`. While the tool touches something, this value
    /// times the device's velocity over the last step is subtracted from its force. Empty: no damping.
    pub damping: Vec<f64>,
    /// Damping of each tool's rotational virtual damper, at least 0 `[N m s/rad]`. This value times the device's
    /// angular velocity over the last step is subtracted from its torque. Empty: no damping.
    pub rotational_damping: Vec<f64>,
}

impl BasicParams {
    pub(super) fn name(&self) -> &'static str {
        if self.damping.is_empty() && self.rotational_damping.is_empty() {
            "basic"
        } else {
            "virtual-damper"
        }
    }

    pub(super) fn check(self, tools: usize) -> Result<Basic, WorldErrors> {
        let mut faults = Vec::new();
        let lists = [
            (WorldField::Damping, &self.damping),
            (WorldField::RotationalDamping, &self.rotational_damping),
        ];
        for (field, list) in lists {
            faults.extend(one_per_tool(field, list.len(), tools).err());
            for damping in list {
                if let Some(message) = out_of_range(field, *damping, Range::NotNegative) {
                    faults.push(WorldError::new(
                        WorldPart::Method,
                        field,
                        "the method",
                        message,
                    ));
                }
            }
        }
        WorldErrors::check(faults)?;
        Ok(Basic {
            damping: self.damping,
            rotational_damping: self.rotational_damping,
        })
    }
}

/// Basic rendering, with checked parameters.
#[derive(Clone, Debug)]
pub(crate) struct Basic {
    damping: Vec<f64>,
    rotational_damping: Vec<f64>,
}

impl Basic {
    /// Returns basic rendering without a damper.
    pub fn undamped() -> Self {
        Self {
            damping: Vec::new(),
            rotational_damping: Vec::new(),
        }
    }

    pub fn begin(renderer: &WorldRenderer, state: &mut Progress, positions: &[Vector]) {
        let turned = &state.tracking.seen_turn;
        for (part, (position, turned)) in state
            .now
            .parts
            .iter_mut()
            .zip(positions.iter().zip(turned))
            .take(renderer.tools)
        {
            part.rigid.orientation = *turned;
            part.turning_drive = TurningDrive::none();
            part.rigid.position = Vector3::from(*position);
            part.rigid.velocity = Vector3::zeros();
            part.drive = Drive::constant(Vector3::zeros());
        }
        state.now.begin();
        state.now.look(&renderer.points);
        state.ledger.observe(&state.now, &renderer.points);
    }

    pub fn conclude(
        renderer: &WorldRenderer,
        state: &mut Progress,
        positions: &[Vector],
        elapsed: f64,
    ) -> Effort {
        let points = &renderer.points;
        Self::hold_contacts(renderer, state, positions);
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

        // The tools are at the current device positions; the energy that this motion adds to the contacts is work of
        // the tools.
        for (tool, position) in positions.iter().enumerate().take(renderer.tools) {
            Self::move_tool(renderer, state, tool, &Vector3::from(*position), elapsed);
        }
        state.now.begin();
        state.now.look(points);
        Self::account_contacts(renderer, state);
        effort
    }

    /// Adds the work of the held forces of contacts and fields on the motion of the tools.
    #[inline]
    fn hold_contacts(renderer: &WorldRenderer, state: &mut Progress, positions: &[Vector]) {
        for &number in state.now.nearby.recent() {
            let (point, touch) = (&renderer.points[number], &state.now.touches[number]);
            let entry = &mut state.ledger.contacts[number];
            if let Some(tool) = point.tool(renderer.tools)
                && let Some(sign) = point.sign_on(tool)
            {
                let part = &state.now.parts[tool];
                let way = Vector3::from(positions[tool]) - part.rigid.position;
                let mut work = touch.force.dot(&way) * sign;
                let carried = renderer.axes[tool].across(&touch.force).dot(&way) * sign;
                state.ledger.devices[tool].carried += carried;
                if part.has_torque {
                    let by = step(&state.tracking.seen_turn[tool], &part.rigid.orientation);
                    let arm = touch.place - part.rigid.position;
                    let by_torque = arm.cross(&touch.force).dot(&by) * sign;
                    work += by_torque;
                    if part.led {
                        state.ledger.devices[tool].carried += by_torque;
                    }
                }
                entry.held += work;
                state.ledger.devices[tool].held += work;
            }
        }
        for (field, entry) in state.now.fields.iter().zip(&mut state.ledger.fields) {
            let tool = field.tool;
            let way = Vector3::from(positions[tool]) - state.now.parts[tool].rigid.position;
            let work = field.force.dot(&way);
            state.ledger.devices[tool].carried +=
                renderer.axes[tool].across(&field.force).dot(&way);
            entry.held += work;
            state.ledger.devices[tool].held += work;
            if field.is_supplied() {
                entry.supplied += work;
                entry.work += work;
            }
        }
    }

    /// Moves a tool to its device at `position` `[m]`, and adds the work at its port.
    #[inline]
    pub(super) fn move_tool(
        renderer: &WorldRenderer,
        state: &mut Progress,
        tool: usize,
        position: &Vector3,
        elapsed: f64,
    ) {
        let held = state.commands.passed(tool).sent;
        let torque = state.torque_commands.passed_or_none(tool);
        let turned = state.tracking.seen_turn[tool];
        let part = &mut state.now.parts[tool];
        let way = position - part.rigid.position;
        let turn = turned * part.rigid.orientation.inverse();
        let by = step(&turned, &part.rigid.orientation);
        let before = part.rigid.position;
        part.rigid.position += way;
        part.rigid.orientation = turned;
        part.rigid.spin = Vector3::zeros();
        part.drive.apparent_velocity = way / elapsed;
        part.turning_drive.apparent_turning = by / elapsed;
        let has_torque = part.has_torque;
        for &number in state.now.nearby.recent() {
            let (point, touch) = (&renderer.points[number], &mut state.now.touches[number]);
            if let Some(sign) = point.sign_on(tool)
                && !touch.is_apart()
            {
                let mut way = way;
                if has_torque {
                    let arm = touch.place - before;
                    way += turn * arm - arm;
                }
                touch.slid += (way - touch.normal * touch.normal.dot(&way)) * sign;
            }
        }
        let entry = &mut state.ledger.devices[tool];
        entry.port_work += held.dot(&way) + torque.dot(&by);
        entry.unforeseen = entry.port_work + entry.carried - entry.held;
    }

    /// Adds the energy that the motion of the tools has given to their contacts and fields.
    #[inline]
    pub(super) fn account_contacts(renderer: &WorldRenderer, state: &mut Progress) {
        for &number in state.now.nearby.recent() {
            let (point, entry) = (&renderer.points[number], &mut state.ledger.contacts[number]);
            if point.tool(renderer.tools).is_some() {
                let stored = state.now.stored(number, point);
                let dissipated = state.now.touches[number].past.dissipated;
                let work = entry.stored - stored - dissipated;
                entry.work += work;
                entry.work_on_proxy += work;
                entry.dissipated += dissipated;
                entry.stored = stored;
            }
        }
        for (field, entry) in state.now.fields.iter().zip(&mut state.ledger.fields) {
            entry.work += entry.stored - field.stored;
            entry.stored = field.stored;
        }
    }

    pub fn plan(&self, renderer: &WorldRenderer, state: &mut Progress) -> Effort {
        show_contacts(&mut state.contacts, &mut state.shown, &state.now);
        for (tool, intended) in state.intended.iter_mut().enumerate() {
            let (mut force, mut torque) = (Vector3::zeros(), Vector3::zeros());
            let mut touches = false;
            let part = &state.now.parts[tool];
            for &number in state.now.nearby.recent() {
                let (point, touch) = (&renderer.points[number], &state.now.touches[number]);
                if let Some(sign) = point.sign_on(tool)
                    && !touch.is_apart()
                {
                    let on_tool = touch.force * sign;
                    force += on_tool;
                    torque += (touch.place - part.rigid.position).cross(&on_tool);
                    touches = true;
                }
            }
            for field in state.now.fields.iter().filter(|field| field.tool == tool) {
                force += field.force;
                touches |= field.acts();
            }
            if touches {
                let of = |list: &[f64]| list.get(tool).copied().unwrap_or_default();
                force -= part.drive.apparent_velocity * of(&self.damping);
                torque -= part.turning_drive.apparent_turning * of(&self.rotational_damping);
            }
            *intended = state.commands.for_force(&force);
            if part.has_torque && !part.led {
                state.intended_torques[tool] = state.torque_commands.for_force(&torque);
            }
        }
        Effort::default()
    }

    /// Writes the estimated state of the tools.
    pub fn publish(state: &mut Progress) {
        for (tool, part) in state.tools.iter_mut().zip(&state.now.parts) {
            tool.position = part.rigid.position.into();
            tool.proxy_position = tool.position;
            tool.velocity = part.drive.apparent_velocity.into();
            tool.proxy_velocity = tool.velocity;
            tool.orientation = quaternion(&part.rigid.orientation);
            tool.proxy_orientation = tool.orientation;
            tool.angular_velocity = part.turning_drive.apparent_turning.into();
        }
    }
}

/// Returns the rotation vector from one orientation to another, along the world's axes `[rad]`.
fn step(to: &Rotation, from: &Rotation) -> Vector3 {
    (to * from.inverse()).scaled_axis()
}
