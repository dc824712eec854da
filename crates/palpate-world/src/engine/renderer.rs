//! The three parts of a period.

use palpate_core::Fault;

use super::body::{BodyNow, BodyWrench, EngineBody, Stepping};
use super::coupling::Coupling;
use super::image::Image;
use super::pairs::{Pair, pairs};
use super::state::{BodyPortLedger, EngineOutput, EngineState};
use crate::{CoupledParams, Sample, Tool, Vector, WorldErrors, WorldLoop};

/// Renderer for contacts of tools with the bodies of another engine, in one loop. It is immutable: one renderer
/// serves any number of [`EngineState`]s.
#[derive(Clone, Debug)]
pub struct EngineRenderer {
    coupling: Coupling,
    bodies: usize,
    pairs: Vec<Pair>,
    stepping: Stepping,
}

impl EngineRenderer {
    /// Checks all inputs and creates the renderer.
    ///
    /// # Errors
    ///
    /// Returns all faults of tools and bodies, or otherwise those of the loop and the parameters (at least one).
    pub fn new(
        tools: &[Tool],
        bodies: &[EngineBody],
        stepping: Stepping,
        loop_params: WorldLoop,
        params: CoupledParams,
    ) -> Result<Self, WorldErrors> {
        let (pairs, faults) = pairs(tools, bodies);
        Ok(Self {
            coupling: Coupling::checked(tools, loop_params, params, "an engine's", faults)?,
            bodies: bodies.len(),
            pairs,
            stepping,
        })
    }

    /// Returns the loop parameters.
    #[must_use]
    pub fn loop_params(&self) -> &WorldLoop {
        &self.coupling.loop_params
    }

    /// Creates a state before the first sample: no contact, empty energy ledger.
    #[must_use]
    pub fn start(&self) -> EngineState {
        self.coupling.start(&self.pairs, self.bodies)
    }

    /// Takes a sample of all devices and begins a period. After an unusable sample the period has no contact, and
    /// [`EngineRenderer::hold`] reports the fault.
    pub fn sample(&self, state: &mut EngineState, sample: &Sample<'_>) {
        self.coupling.sample(&self.pairs, state, sample);
    }

    /// Advances proxies and contacts by `h` `[s]` against the current states of the engine's bodies, in the order of
    /// their description. Writes to `wrenches` the wrenches that the engine must hold over this step.
    pub fn advance(
        &self,
        state: &mut EngineState,
        h: f64,
        bodies: &[BodyNow],
        wrenches: &mut [BodyWrench],
    ) {
        wrenches.fill(BodyWrench::default());
        if state.fault.is_some() {
            return;
        }
        let is_usable = bodies.len() == self.bodies
            && wrenches.len() == self.bodies
            && bodies.iter().all(BodyNow::is_finite)
            && h > 0.0
            && h <= self.coupling.loop_params.bridged_gap();
        if !is_usable {
            state.fail(Fault::Overflow);
            self.coupling.disable_output(state);
            return;
        }
        state.record_ports(bodies);
        let images = state.meeting.images.iter_mut();
        for ((image, body), offset) in images.zip(bodies).zip(&state.offsets) {
            *image = Image::new(body, offset);
        }
        state.look(&self.pairs, |entry| &mut entry.observed);
        state.add_work(&self.pairs, -1.0);
        if !self.coupling.meet(&self.pairs, state, h) {
            return;
        }
        state.add_work(&self.pairs, 1.0);
        let EngineState {
            meeting,
            offsets,
            pushed,
            ..
        } = state;
        for (number, body) in bodies.iter().enumerate() {
            let image = &meeting.images[number];
            wrenches[number] = image.wrench(h);
            if let Some(pushed) = &mut pushed[number] {
                pushed.impulse = image.impulse;
            }
            image.lead(&mut offsets[number], body, self.stepping, h);
            state.is_body_touched[number] |= image.impulse.norm() > 0.0;
        }
    }

    /// Ends the period and returns the forces to hold on the devices until the next one.
    pub fn hold<'s>(&self, state: &'s mut EngineState) -> EngineOutput<'s> {
        let with_bodies = BodyPortLedger::created(&state.ledger.bodies);
        self.coupling.hold(&self.pairs, state, with_bodies);
        state.output()
    }

    /// Replaces the force of the last [`EngineRenderer::hold`] on a tool by the force that was actually sent `[N]`.
    /// Non-finite values are ignored.
    pub fn report_sent(&self, state: &mut EngineState, tool: usize, force: Vector) {
        self.coupling.report_sent(state, tool, force);
    }
}
