//! A world with one device, as the loop renders it.

use palpate_device::{Vector, Wrench};
use palpate_record::recording::{BodyTick, ContactTick, Flags};
use palpate_world::{Limited, Sample, Succession, World, WorldError, WorldRenderer, WorldState};

use super::frame::WorldFrame;
use super::renders::{Answer, Fresh, Renders};
use super::world_rows::WorldRows;
use crate::setup::SetupError;

/// A world with one device in the loop: its renderer, its state, and where the device stands in it.
#[derive(Clone, Debug)]
pub struct RenderedWorld {
    renderer: WorldRenderer,
    state: WorldState,
    method: &'static str,
    frame: WorldFrame,
    /// Whether the tool turns.
    turns: bool,
    /// Whether what was held is what acted: the renderer is told of no delay and no lag.
    acts_at_once: bool,
    limited: Limited,
    /// What the books said of created energy at the last sample `[J]`.
    booked: f64,
    /// As much of it as was created while the motors were on `[J]`.
    created: f64,
    /// Whether the last sample was refused, or there was none: what a sample then changes is from outside.
    is_new: bool,
    rows: WorldRows,
}

impl RenderedWorld {
    /// `world`, which `renderer` renders by the method of that name, with a device that stands in it as `frame` says.
    ///
    /// # Errors
    /// The world has another number of tools than one: a loop has one device so far. A tool that turns, with a frame whose
    /// axes are not those of the world.
    pub fn new(
        world: &World,
        renderer: WorldRenderer,
        method: &'static str,
        frame: WorldFrame,
    ) -> Result<Self, SetupError> {
        let state = renderer.start();
        let tools = state.tools().len();
        if tools != 1 {
            return Err(SetupError::Devices(tools));
        }
        let turns = world.tools.iter().any(|tool| tool.turns);
        if turns && !frame.is_aligned() {
            return Err(SetupError::TurnedFrame);
        }
        let actuation = renderer.in_loop().actuation;
        Ok(Self {
            acts_at_once: actuation.delay == 0.0 && actuation.lag == 0.0,
            method,
            frame,
            turns,
            limited: Limited::default(),
            booked: 0.0,
            created: 0.0,
            is_new: true,
            rows: WorldRows::new(world, &state),
            state,
            renderer,
        })
    }

    /// Where the device stands in the world.
    #[must_use]
    pub fn frame(&self) -> &WorldFrame {
        &self.frame
    }

    /// Whether the tool turns: a device of six axes.
    #[must_use]
    pub fn turns(&self) -> bool {
        self.turns
    }

    /// Makes ready to go on from `before`, with those bodies that are kept ([`WorldRenderer::succeed`]).
    pub(super) fn succeed(
        &mut self,
        before: &Self,
        is_kept: &[bool],
    ) -> Result<Succession, Vec<WorldError>> {
        let succession = self.renderer.succeed(&before.renderer, is_kept)?;
        self.state = self.renderer.start();
        Ok(succession)
    }

    /// Goes on from `before` between two samples ([`WorldRenderer::go_on`]).
    pub(super) fn go_on(&mut self, before: &Self, succession: &Succession) {
        let past = (&before.renderer, &before.state);
        self.renderer.go_on(&mut self.state, past, succession);
        self.booked = self.state.books().created();
        self.created = before.created;
        self.is_new = before.is_new;
    }

    /// Tells the renderer what was sent, or held, in the axes of the device.
    fn report(&mut self, wrench: Wrench) {
        let force = self.frame.of_device(wrench.force);
        self.renderer.report_sent(&mut self.state, 0, force);
        // A device of six axes has those of the world.
        self.renderer
            .report_sent_torque(&mut self.state, 0, wrench.torque);
    }

    /// The world at the last sample.
    #[must_use]
    pub fn state(&self) -> &WorldState {
        &self.state
    }
}

impl Renders for RenderedWorld {
    fn period(&self) -> f64 {
        self.renderer.in_loop().period
    }

    fn method(&self) -> &'static str {
        self.method
    }

    fn step(&mut self, sample: &Fresh) -> Answer {
        if let Some(held) = sample.held
            && self.acts_at_once
        {
            self.report(held);
        }
        // An orientation that is missing is none that can be used.
        let orientations = [sample.orientation.unwrap_or([f64::NAN; 4])];
        let positions = [self.frame.in_world(sample.position)];
        let output = self.renderer.step(
            &mut self.state,
            &Sample {
                elapsed: sample.elapsed,
                ..Sample::at(&positions).turned(&orientations)
            },
        );
        let force = output.forces.first().copied().unwrap_or_default();
        let torque = output.torques.first().copied().unwrap_or_default();
        let fault = output.fault.map(|fault| fault.fault);
        self.limited = output.limited;
        let booked = self.state.books().created();
        let is_from_outside = sample.was_off || self.is_new || fault.is_some();
        if !is_from_outside {
            self.created += booked - self.booked;
        }
        self.booked = booked;
        self.is_new = fault.is_some();
        Answer {
            wrench: Wrench {
                force: self.frame.on_device(force),
                torque,
            },
            coordinate: 0.0,
            fault,
        }
    }

    fn report_written(&mut self, held: Wrench, sent: Option<Wrench>) {
        let sent = if self.acts_at_once {
            held
        } else {
            sent.unwrap_or(held)
        };
        self.report(sent);
    }

    fn account(&mut self, sequence: u64, _: Vector) {
        self.rows.fill(sequence, &self.state);
    }

    fn contacts(&self) -> &[ContactTick] {
        self.rows.contacts()
    }

    fn bodies(&self) -> &[BodyTick] {
        self.rows.bodies()
    }

    fn flags(&self) -> Flags {
        Flags::default()
            .with(Flags::CONTACT, !self.rows.contacts().is_empty())
            .with(
                Flags::LIMITED_FORCE,
                self.limited.force || self.limited.torque,
            )
            .with(Flags::LIMITED_GUARD, self.limited.guard)
    }

    fn created_energy(&self) -> f64 {
        self.created
    }
}
