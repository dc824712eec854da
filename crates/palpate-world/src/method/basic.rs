//! The usual way: the spring force at the sample.

use super::one_per_tool;
use crate::interval::advance;
use crate::part::Drive;
use crate::rigid::Vector3;
use crate::state::{Progress, show_contacts};
use crate::{Effort, Place, Vector, WorldError, WorldRenderer};

/// Parameters of basic rendering.
///
/// The force on a tool is that of its contacts at the sample. Over the interval the bodies move against the tool as
/// it was at the sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BasicParams {
    /// Virtual damper of each tool, at least 0 `[N s/m]`: while the tool touches something, its force is less by this
    /// times the velocity of the device's last step. Empty: none.
    pub damping: Vec<f64>,
}

impl BasicParams {
    pub(super) fn check(self, tools: usize) -> Result<Basic, Vec<WorldError>> {
        let mut faults = Vec::new();
        faults.extend(one_per_tool("damping", self.damping.len(), tools).err());
        for damping in &self.damping {
            if !(*damping >= 0.0 && damping.is_finite()) {
                let message = format!("damping is {damping}, and has to be at least 0");
                faults.push(WorldError::new(
                    Place::Method,
                    "damping",
                    "the method",
                    message,
                ));
            }
        }
        if faults.is_empty() {
            Ok(Basic {
                damping: self.damping,
            })
        } else {
            Err(faults)
        }
    }
}

/// Basic rendering, with checked parameters.
#[derive(Clone, Debug)]
pub(crate) struct Basic {
    damping: Vec<f64>,
}

impl Basic {
    pub fn begin(renderer: &WorldRenderer, state: &mut Progress, positions: &[Vector]) {
        for (part, position) in state
            .now
            .parts
            .iter_mut()
            .zip(positions)
            .take(renderer.tools)
        {
            part.rigid.position = Vector3::from(*position);
            part.rigid.velocity = Vector3::zeros();
            part.drive = Drive::constant(Vector3::zeros());
        }
        state.now.begin();
        state.now.look(&renderer.points);
        state.books.observe(&state.now, &renderer.points);
    }

    pub fn conclude(
        renderer: &WorldRenderer,
        state: &mut Progress,
        positions: &[Vector],
        elapsed: f64,
    ) -> Effort {
        let points = &renderer.points;
        for (point, (touch, book)) in points
            .iter()
            .zip(state.now.touches.iter().zip(&mut state.books.contacts))
        {
            if point.first < renderer.tools {
                let way = Vector3::from(positions[point.first])
                    - state.now.parts[point.first].rigid.position;
                let work = touch.force.dot(&way);
                book.held += work;
                state.books.devices[point.first].held += work;
            }
        }
        state.now.begin();
        let sub_steps = &renderer.in_loop.sub_steps;
        let effort = advance(&mut state.now, &mut state.room, points, sub_steps, elapsed);
        state.books.pass(&state.now, points, renderer.tools);

        // The tools are where their devices are now, and what that does to the contacts is their work.
        for (tool, position) in positions.iter().enumerate().take(renderer.tools) {
            let held = state.commands.passed(tool).sent;
            let part = &mut state.now.parts[tool];
            let way = Vector3::from(*position) - part.rigid.position;
            part.rigid.position += way;
            part.drive.apparent_velocity = way / elapsed;
            for (point, touch) in points.iter().zip(&mut state.now.touches) {
                if point.first == tool && !touch.is_apart() {
                    touch.slid = way - touch.normal * touch.normal.dot(&way);
                }
            }
            let book = &mut state.books.devices[tool];
            book.port_work += held.dot(&way);
            book.unforeseen = book.port_work - book.held;
        }
        state.now.begin();
        state.now.look(points);
        for (number, (book, point)) in state.books.contacts.iter_mut().zip(points).enumerate() {
            if point.first < renderer.tools {
                let stored = state.now.stored(number, point);
                let dissipated = state.now.touches[number].past.dissipated;
                let work = book.stored - stored - dissipated;
                book.work += work;
                book.work_on_avatar += work;
                book.dissipated += dissipated;
                book.stored = stored;
            }
        }
        effort
    }

    pub fn plan(&self, renderer: &WorldRenderer, state: &mut Progress) -> Effort {
        show_contacts(&mut state.contacts, &state.now);
        for (tool, intended) in state.intended.iter_mut().enumerate() {
            let mut force = Vector3::zeros();
            let mut touches = false;
            for (point, touch) in renderer.points.iter().zip(&state.now.touches) {
                if point.first == tool && !touch.is_apart() {
                    force += touch.force;
                    touches = true;
                }
            }
            if touches {
                let damping = self.damping.get(tool).copied().unwrap_or_default();
                force -= state.now.parts[tool].drive.apparent_velocity * damping;
            }
            *intended = state.commands.for_force(&force);
        }
        Effort::default()
    }

    /// Writes what is known of the tools.
    pub fn publish(state: &mut Progress) {
        for (tool, part) in state.tools.iter_mut().zip(&state.now.parts) {
            tool.position = part.rigid.position.into();
            tool.avatar_position = tool.position;
            tool.velocity = part.drive.apparent_velocity.into();
            tool.avatar_velocity = tool.velocity;
        }
    }
}
