//! HFCR in several dimensions: energy-consistent forces for several contacts, bodies and devices.
//!
//! The paper leaves several dimensions open. Its Eq. (9) and (11) are applied to each contact: the contact holds the
//! device at its own place for its own part of the interval, and its force is the mean along the predicted step of
//! the device, whose work is the change of the contact's energy.

use palpate_core::Range;

use super::one_per_tool;
use crate::error::out_of_range;
use crate::geometry::rigid::Vector3;
use crate::integration::held_load::Load;
use crate::integration::held_tools::HeldTools;
use crate::integration::interval::{Reach, advance};
use crate::method::basic::Basic;
use crate::method::state::{Progress, show_contacts};
use crate::{Effort, Vector, WorldError, WorldErrors, WorldField, WorldPart, WorldRenderer};

/// Parameters of HFCR.
///
/// The force on a tool is the sum over its contacts. The work of each along the predicted step of the device, which
/// repeats the last one, is the energy that the contact loses. Neither a mass nor a setting is needed.
#[derive(Clone, Debug, PartialEq)]
pub struct HfcrParams {
    /// Whether contacts begin and end within the interval, instead of at samples.
    pub smooth_transition: bool,
    /// Damping b of the leak dissipation along the normal of each tool's contacts, Eq. (11), at least 0 `[N s/m]`.
    /// Empty: no dissipation.
    pub damping: Vec<f64>,
}

impl Default for HfcrParams {
    /// Smooth transitions without leak dissipation.
    fn default() -> Self {
        Self {
            smooth_transition: true,
            damping: Vec::new(),
        }
    }
}

impl HfcrParams {
    /// Returns the parameters of the modified force alone: `hfcr-mod`.
    #[must_use]
    pub fn modified_force_only() -> Self {
        Self {
            smooth_transition: false,
            ..Self::default()
        }
    }

    pub(super) fn name(&self) -> &'static str {
        match (self.smooth_transition, self.damping.is_empty()) {
            (false, _) => "hfcr-mod",
            (true, true) => "hfcr-mod-st",
            (true, false) => "hfcr",
        }
    }

    pub(super) fn check(self, tools: usize) -> Result<Hfcr, WorldErrors> {
        let mut faults = Vec::new();
        let field = WorldField::Damping;
        faults.extend(one_per_tool(field, self.damping.len(), tools).err());
        let wrong = self.damping.iter();
        let wrong = wrong.filter_map(|damping| out_of_range(field, *damping, Range::NotNegative));
        faults.extend(
            wrong.map(|message| WorldError::new(WorldPart::Method, field, "the method", message)),
        );
        WorldErrors::check(faults)?;
        Ok(Hfcr {
            smooth_transition: self.smooth_transition,
            damping: self.damping,
        })
    }
}

/// HFCR, with checked parameters.
#[derive(Clone, Debug)]
pub(crate) struct Hfcr {
    smooth_transition: bool,
    damping: Vec<f64>,
}

/// Load that each contact point holds on its tool.
#[derive(Clone, Debug)]
pub(crate) struct HfcrMemory {
    loads: Vec<Load>,
}

impl HfcrMemory {
    pub fn new(points: usize) -> Self {
        Self {
            loads: vec![Load::none(); points],
        }
    }

    /// Continues from another world. `points` maps this world's contact points to the previous indices.
    pub fn goes_on_from(&mut self, before: &Self, points: &[Option<usize>]) {
        for (load, was) in self.loads.iter_mut().zip(points) {
            *load = was.map_or_else(Load::none, |was| before.loads[was]);
        }
    }
}

impl Hfcr {
    pub fn held_tools(&self, renderer: &WorldRenderer) -> HeldTools {
        HeldTools::new(
            self.smooth_transition,
            &renderer.parts[..renderer.tools],
            renderer.tool_points,
            [renderer.surfaces.len(), renderer.blocks.len()],
        )
    }

    pub fn conclude(
        renderer: &WorldRenderer,
        state: &mut Progress,
        memory: &HfcrMemory,
        positions: &[Vector],
        elapsed: f64,
    ) -> Effort {
        let points = &renderer.points;
        Self::account_loads(renderer, state, memory, positions);
        state.now.begin();
        state.now.hold_tools();
        let sub_steps = &renderer.loop_params.sub_steps;
        let effort = advance(
            &mut state.now,
            &mut state.room,
            points,
            sub_steps,
            Reach::All,
            elapsed,
        );
        state.now.let_tools_go();
        state.ledger.pass(&state.now, points, renderer.tools);
        for (tool, position) in positions.iter().enumerate().take(renderer.tools) {
            Basic::move_tool(renderer, state, tool, &Vector3::from(*position), elapsed);
        }
        state.now.slide_held(points);
        state.now.begin();
        state.now.look(points);
        Basic::account_contacts(renderer, state);
        effort
    }

    /// Adds the work of the held loads on the motion of the devices.
    fn account_loads(
        renderer: &WorldRenderer,
        state: &mut Progress,
        memory: &HfcrMemory,
        positions: &[Vector],
    ) {
        for (number, point) in renderer.points[..renderer.tool_points].iter().enumerate() {
            let Some(tool) = point.tool(renderer.tools) else {
                continue;
            };
            let part = &state.now.parts[tool];
            let Load { force, torque } = &memory.loads[number];
            let way = Vector3::from(positions[tool]) - part.rigid.position;
            let mut work = force.dot(&way);
            let device = &mut state.ledger.devices[tool];
            device.carried += renderer.axes[tool].across(force).dot(&way);
            if part.has_torque {
                let turned = state.tracking.seen_turn[tool] * part.rigid.orientation.inverse();
                let by_torque = torque.dot(&turned.scaled_axis());
                work += by_torque;
                if part.led {
                    device.carried += by_torque;
                }
            }
            device.held += work;
            state.ledger.contacts[number].held += work;
        }
    }

    pub fn plan(
        &self,
        renderer: &WorldRenderer,
        state: &mut Progress,
        memory: &mut HfcrMemory,
    ) -> Effort {
        let points = &renderer.points;
        let period = renderer.loop_params.period;
        show_contacts(&mut state.contacts, &mut state.shown, &state.now);
        state.ahead.continue_from(&state.now, points);
        state.ahead.exchange_gathered(&mut state.now);
        state.ahead.begin();
        state.ahead.hold_tools();
        let sub_steps = &renderer.loop_params.sub_steps;
        let effort = advance(
            &mut state.ahead,
            &mut state.room,
            points,
            sub_steps,
            Reach::All,
            period,
        );
        state.ahead.conclude_holding(points);
        for (tool, intended) in state.intended.iter_mut().enumerate() {
            let mut sum = Load::none();
            for (number, (point, load)) in points.iter().zip(&mut memory.loads).enumerate() {
                let Some(sign) = point.sign_on(tool) else {
                    continue;
                };
                let span = state.ahead.held.span(number);
                *load = span.impulse.times(1.0 / period);
                let damping = self.damping.get(tool).copied().unwrap_or_default();
                if damping > 0.0 && span.duration > 0.0 {
                    // Eq. (11).
                    let parts = &state.now.parts;
                    let (first, second) = (&parts[point.first], &parts[point.second]);
                    let relative = first.velocity_at(&first.twist, &span.place)
                        - second.velocity_at(&second.twist, &span.place)
                        + first.apparent_velocity_at(&span.place)
                        - second.apparent_velocity_at(&span.place);
                    let push = -span.normal.dot(&relative) * damping * span.duration / period;
                    let force = span.normal * (push * sign);
                    let arm = span.place - parts[tool].rigid.position;
                    load.add(&Load {
                        force,
                        torque: arm.cross(&force),
                    });
                }
                sum.add(load);
            }
            *intended = state.commands.for_force(&sum.force);
            let part = &state.now.parts[tool];
            if part.has_torque && !part.led {
                state.intended_torques[tool] = state.torque_commands.for_force(&sum.torque);
            }
        }
        state.ahead.let_tools_go();
        effort
    }
}
