//! The three parts of a period.

use palpate::Fault;

use super::body::{BodyNow, BodyWrench, EngineBody, Stepping};
use super::coupling::Coupling;
use super::image::Image;
use super::pairs::{Pair, pairs};
use super::state::{BodyPortBook, EngineOutput, EngineState};
use crate::{CoupledParams, Sample, Tool, Vector, WorldError, WorldLoop};

/// Contacts of tools with the bodies of another engine, in one loop. Immutable: one renderer serves any number of
/// [`EngineState`]s.
#[derive(Clone, Debug)]
pub struct EngineRenderer {
    coupling: Coupling,
    bodies: usize,
    pairs: Vec<Pair>,
    stepping: Stepping,
}

impl EngineRenderer {
    /// Checks everything once.
    ///
    /// # Errors
    ///
    /// Everything that is wrong with tools and bodies, or else with the loop and the parameters: at least one fault.
    pub fn new(
        tools: &[Tool],
        bodies: &[EngineBody],
        stepping: Stepping,
        in_loop: WorldLoop,
        params: CoupledParams,
    ) -> Result<Self, Vec<WorldError>> {
        let (pairs, faults) = pairs(tools, bodies);
        Ok(Self {
            coupling: Coupling::checked(tools, in_loop, params, "an engine's", faults)?,
            bodies: bodies.len(),
            pairs,
            stepping,
        })
    }

    /// The loop it is rendered in.
    #[must_use]
    pub fn in_loop(&self) -> &WorldLoop {
        &self.coupling.in_loop
    }

    /// A new state: nothing sampled, nothing touched, the books empty.
    #[must_use]
    pub fn start(&self) -> EngineState {
        self.coupling.start(&self.pairs, self.bodies)
    }

    /// Takes a sample of all devices: a period begins. A sample that cannot be used gives no contact in it, and
    /// [`EngineRenderer::hold`] says why.
    pub fn sample(&self, state: &mut EngineState, sample: &Sample<'_>) {
        self.coupling.sample(&self.pairs, state, sample);
    }

    /// Steps avatars and contacts on by `h` `[s]` against the engine's bodies, in the order of their description, as
    /// they are now. `wrenches` is what the engine is to hold on them over that step.
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
            && h <= self.coupling.in_loop.bridged_gap();
        if !is_usable {
            state.fail(Fault::Overflow);
            self.coupling.let_go(state);
            return;
        }
        state.book_ports(bodies);
        let images = state.meeting.images.iter_mut();
        for ((image, body), offset) in images.zip(bodies).zip(&state.offsets) {
            *image = Image::of(body, offset);
        }
        state.look(&self.pairs, |book| &mut book.observed);
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
            offsets[number].0 += image.ahead_of(body, self.stepping, h);
            state.is_body_touched[number] |= image.impulse.norm() > 0.0;
        }
    }

    /// Ends the period: the forces on the devices, to hold until the next.
    pub fn hold<'s>(&self, state: &'s mut EngineState) -> EngineOutput<'s> {
        let with_bodies = BodyPortBook::created(&state.books.bodies);
        self.coupling.hold(&self.pairs, state, with_bodies);
        state.output()
    }

    /// Says what was really sent to a tool for the last [`EngineRenderer::hold`] `[N]`, where it is not that force. A
    /// force that is not finite is left as it is.
    pub fn report_sent(&self, state: &mut EngineState, tool: usize, force: Vector) {
        self.coupling.report_sent(state, tool, force);
    }
}
