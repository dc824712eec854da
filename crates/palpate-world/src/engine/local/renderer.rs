//! Ticks with a local model.

use nalgebra::Vector6;

use super::copies::{duration, nowhere, put_fixed_world};
use super::model::{LocalContact, LocalModel};
use super::params::LocalParams;
use super::past::{Past, Then};
use super::progress::{BodyImpulse, LocalProgress};
use super::slot::{Slot, closed};
use super::state::{LocalOutput, LocalState, ModelRefusal};
use crate::engine::body::BodyNow;
use crate::engine::contact_point::Touch;
use crate::engine::coupling::Coupling;
use crate::engine::image::{angular, linear};
use crate::engine::integration::Meeting;
use crate::engine::pairs::of_spheres;
use crate::engine::state::BodyPortLedger;
use crate::{CoupledParams, Sample, Tool, Vector, WorldErrors, WorldLoop};

/// Renderer for contacts of tools by the local models of a low-rate simulator, in one fast loop. It is immutable: one
/// renderer serves any number of [`LocalState`]s.
///
/// ```
/// use palpate_world::engine::BodyNow;
/// use palpate_world::engine::local::{LocalContact, LocalParams, LocalRenderer};
/// use palpate_world::{ContactLaw, CoupledParams, Sample, Shape, Tool, WorldLoop};
///
/// let tool = Tool::new("tool", Shape::Sphere { radius: 0.005 });
/// let renderer = LocalRenderer::new(
///     &[tool],
///     LocalParams::new(0, 1),
///     WorldLoop::new(0.001),
///     CoupledParams::new(vec![[0.1; 3]]),
/// )?;
/// let mut state = renderer.start();
/// // The host has found a floor 5 mm below the tool's centre.
/// let floor = LocalContact::at_gap((0, [0.0; 3], 0.005), None, 0.0, [0.0, 0.0, 1.0], ContactLaw::spring(1000.0));
/// let model = renderer.model(state.progress().tick, &[], &[Some(floor)])?;
/// let first = renderer.step(&mut state, &Sample::at(&[[0.0; 3]]), Some(&model));
/// assert_eq!(first.refusal, None);
/// // Every millisecond, with no model or a new one.
/// let output = renderer.step(&mut state, &Sample::at(&[[0.0, 0.0, -0.001]]), None);
/// assert!(output.forces[0][2] > 0.5); // [N]
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct LocalRenderer {
    coupling: Coupling,
    tools: Vec<Tool>,
    /// Radius of each tool `[m]`.
    radii: Vec<f64>,
    params: LocalParams,
}

impl LocalRenderer {
    /// Checks all inputs and creates the renderer.
    ///
    /// # Errors
    /// Returns all faults (at least one).
    pub fn new(
        tools: &[Tool],
        params: LocalParams,
        loop_params: WorldLoop,
        coupled: CoupledParams,
    ) -> Result<Self, WorldErrors> {
        let (radii, mut faults) = of_spheres(tools);
        faults.extend(params.faults(loop_params.period));
        Ok(Self {
            coupling: Coupling::checked(tools, loop_params, coupled, "a host's", faults)?,
            tools: tools.to_vec(),
            radii,
            params,
        })
    }

    /// Returns the loop parameters.
    #[must_use]
    pub fn loop_params(&self) -> &WorldLoop {
        &self.coupling.loop_params
    }

    /// Returns the capacity of models and the transition times.
    #[must_use]
    pub fn params(&self) -> &LocalParams {
        &self.params
    }

    /// Checks bodies and contacts of a host at `tick` and creates a model. `tick` is that of the [`LocalProgress`]
    /// whose impulses the bodies include. This function allocates; call it from the host's thread.
    ///
    /// A contact is identified by its index: the contact with the same index in the next model is the same contact
    /// after motion. `None` or a missing index means no contact.
    ///
    /// # Errors
    /// Returns all faults of bodies and contacts by index: too many entries, non-finite numbers, a normal that is not
    /// a unit vector, a law out of range, an unknown tool or body.
    pub fn model(
        &self,
        tick: u64,
        bodies: &[BodyNow],
        contacts: &[Option<LocalContact>],
    ) -> Result<LocalModel, WorldErrors> {
        LocalModel::checked(tick, bodies, contacts, &self.tools, &self.params)
    }

    /// Creates a state before the first sample: no model, no contact, empty energy ledger.
    #[must_use]
    pub fn start(&self) -> LocalState {
        let (bodies, period) = (self.params.bodies, self.coupling.loop_params.period);
        let pairs = vec![closed(bodies); self.params.contacts];
        let mut engine = self.coupling.start(&pairs, bodies + 1);
        put_fixed_world(&mut engine.meeting);
        let host = Meeting {
            tools: Vec::new(),
            leads: Vec::new(),
            impulses: Vec::new(),
            images: engine.meeting.images.clone(),
            touches: vec![Touch::apart(); pairs.len()],
            limits: Vec::new(),
            expects_the_missed: false,
        };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "1 to 1000"
        )]
        let ticks = (self.params.stale_after / period).ceil() as usize + 2;
        let tools = self.tools.len();
        LocalState {
            slots: vec![Slot::empty(); pairs.len()],
            host_before: host.clone(),
            late: host.clone(),
            behind: 0.0,
            host,
            past: Past::new(bodies, ticks, nowhere()),
            model_tick: None,
            is_known: false,
            at_model: vec![nowhere(); bodies],
            settle: self.params.fade,
            is_stale: true,
            progress: LocalProgress {
                tick: 0,
                period,
                positions: vec![[0.0; 3]; tools],
                velocities: vec![[0.0; 3]; tools],
                impulses: vec![BodyImpulse::default(); bodies],
                copies: vec![[0.0; 3]; bodies],
                model_tick: None,
                is_stale: true,
                refusal: None,
            },
            refusal: None,
            came: false,
            slow_ports: vec![BodyPortLedger::default(); bodies],
            works: vec![0.0; bodies],
            pairs,
            engine,
        }
    }

    /// Performs one tick: takes a sample of all tools, and the newest model if one has arrived since the last tick,
    /// and returns the forces to hold. It does not allocate, lock or wait. The output is free of NaN for any input.
    pub fn step<'s>(
        &self,
        state: &'s mut LocalState,
        sample: &Sample<'_>,
        model: Option<&LocalModel>,
    ) -> LocalOutput<'s> {
        let LocalState { engine, pairs, .. } = state;
        if let Some(elapsed) = self.coupling.sample(pairs, engine, sample) {
            state.catch_up(elapsed, self.coupling.loop_params.period);
        }
        let LocalState { engine, pairs, .. } = state;
        if engine.fault.is_none() {
            engine.look(pairs, |entry| &mut entry.observed);
        }
        state.came = model.is_some();
        state.refusal = model.and_then(|model| self.take(state, model).err());
        self.go_over(state);
        for image in &mut state.engine.meeting.images {
            image.begin();
        }
        let LocalState { engine, pairs, .. } = state;
        if engine.fault.is_none() {
            engine.look(pairs, |entry| &mut entry.outside);
            if !self
                .coupling
                .meet(pairs, engine, self.coupling.loop_params.period)
            {
                self.forget(state);
            }
        }
        let with_bodies = BodyPortLedger::created(&state.slow_ports);
        self.coupling
            .hold(&state.pairs, &mut state.engine, with_bodies);
        self.remember(state);
        let engine = &state.engine;
        LocalOutput {
            forces: &engine.forces,
            limited: engine.limited,
            effort: engine.effort,
            fault: engine.fault,
            age: self.age(state),
            is_stale: state.is_stale,
            refusal: state.refusal,
        }
    }

    /// Replaces the force of the last [`step`](Self::step) on a tool by the force that was actually sent `[N]`.
    /// Non-finite values are ignored.
    pub fn report_sent(&self, state: &mut LocalState, tool: usize, force: Vector) {
        self.coupling.report_sent(&mut state.engine, tool, force);
    }

    /// Returns the age of the newest model at the beginning of the next period `[s]`.
    fn age(&self, state: &LocalState) -> Option<f64> {
        let period = self.coupling.loop_params.period;
        let tick = state.model_tick?;
        Some(duration(state.progress.tick.saturating_sub(tick), period))
    }

    fn take(&self, state: &mut LocalState, model: &LocalModel) -> Result<(), ModelRefusal> {
        let period = self.coupling.loop_params.period;
        let is_room = model.tools == self.tools.len()
            && model.bodies.len() == self.params.bodies
            && model.contacts.len() == self.params.contacts;
        if !is_room {
            return Err(ModelRefusal::OtherRoom);
        }
        let now = state.progress.tick;
        if model.tick > now {
            return Err(ModelRefusal::NotYet);
        }
        if state.model_tick.is_some_and(|tick| model.tick < tick) {
            return Err(ModelRefusal::OutOfOrder);
        }
        if duration(now - model.tick, period) > self.params.stale_after {
            return Err(ModelRefusal::TooOld);
        }
        let step = state.model_tick.map_or(0, |tick| model.tick - tick);
        state.settle = if state.is_stale {
            self.params.fade
        } else {
            self.params.settle.min(duration(step, period)).max(period)
        };
        let meeting = &state.engine.meeting;
        for (slot, pair) in state.slots.iter_mut().zip(&state.pairs) {
            slot.look_back(pair, &meeting.tools, &meeting.images);
        }
        state.take_bodies(model, period, self.params.return_time);
        let meeting = &state.engine.meeting;
        let slots = state.slots.iter_mut().zip(&mut state.pairs);
        for ((slot, pair), contact) in slots.zip(&model.contacts) {
            slot.take(pair, contact.as_ref(), &state.host.images, &self.radii);
            slot.compare(pair, &meeting.tools, &meeting.images);
        }
        for (contact, pair) in state.engine.contacts.iter_mut().zip(&state.pairs) {
            contact.tool = pair.toucher.tool().unwrap_or(contact.tool);
            contact.body = pair.body;
        }
        Ok(())
    }

    /// Advances the blending of changes by one period, and fades a stale model.
    fn go_over(&self, state: &mut LocalState) {
        let period = self.coupling.loop_params.period;
        let is_fresh = self
            .age(state)
            .is_some_and(|age| age <= self.params.stale_after);
        state.is_stale = !(is_fresh && state.is_known);
        let (settling, fading) = (period / state.settle, period / self.params.fade);
        let mut is_felt = false;
        for (slot, pair) in state.slots.iter_mut().zip(&mut state.pairs) {
            slot.go_over(pair, state.is_stale, settling, fading);
            is_felt |= pair.toucher.tool().is_some() && slot.strength > 0.0;
        }
        if state.is_stale && !is_felt {
            self.forget(state);
        }
    }

    /// Removes the model: the copies stop until a new one arrives.
    fn forget(&self, state: &mut LocalState) {
        state.is_known = false;
        state.is_stale = true;
        for (slot, pair) in state.slots.iter_mut().zip(&mut state.pairs) {
            *slot = Slot::empty();
            pair.is_open = false;
        }
        let images = &mut state.engine.meeting.images;
        for image in images.iter_mut().take(self.params.bodies) {
            image.stop();
        }
        put_fixed_world(&mut state.engine.meeting);
    }

    /// Stores the results of the tick, and updates the progress for the host.
    fn remember(&self, state: &mut LocalState) {
        state.progress.tick += 1;
        let meeting = &state.engine.meeting;
        let progress = &mut state.progress;
        if state.engine.fault.is_none() {
            for (touch, pair) in meeting.touches.iter().zip(&state.pairs) {
                if pair.toucher.tool().is_some()
                    && let Some(work) = state.works.get_mut(pair.body)
                {
                    *work += touch.work - touch.work_on_proxy;
                }
            }
        }
        let tick = progress.tick;
        for (body, image) in meeting.images.iter().take(self.params.bodies).enumerate() {
            let before = &state.past.at(tick - 1, body).map(|then| then.impulse);
            let before = before.unwrap_or_else(Vector6::zeros);
            let impulse = if state.engine.fault.is_none() {
                before + image.impulse
            } else {
                before
            };
            if let Some(then) = state.past.at(tick, body) {
                *then = Then::new(image, impulse, state.works[body]);
            }
            progress.impulses[body] = BodyImpulse {
                linear: linear(&impulse).into(),
                angular: angular(&impulse).into(),
            };
            progress.copies[body] = image.position.into();
        }
        for (tool, part) in meeting.tools.iter().enumerate() {
            progress.positions[tool] = part.rigid.position.into();
            progress.velocities[tool] = part.rigid.velocity.into();
        }
        progress.model_tick = state.model_tick;
        progress.is_stale = state.is_stale;
        if state.came {
            progress.refusal = state.refusal;
        }
    }
}
