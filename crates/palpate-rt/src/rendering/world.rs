//! A world with one device, as the loop renders it.

use palpate_device::{Vector, Wrench};
use palpate_record::recording::{BodyTick, ContactTick, Flags};
use palpate_world::{Limited, Sample, World, WorldRenderer, WorldState};

use super::CHANGE_DURATION;
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
    /// What was answered last.
    answered: Wrench,
    passing: Passing,
}

/// How the answers of a world that has taken over from another pass from that one's to its own.
#[derive(Clone, Copy, Debug)]
enum Passing {
    /// They are its own.
    Over,
    /// The first is that of the world before.
    Begins,
    /// What the world before answered more, of which a part has passed.
    Under { more: Wrench, part: f64 },
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
            answered: Wrench::NONE,
            passing: Passing::Over,
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

    /// Takes the sample that `before` has been told of in `before`'s place: `before` is stepped a last time, and this world goes
    /// on from there ([`WorldRenderer::take_over`]). The answer is that of `before`, and comes to be this world's own within a
    /// tenth of a second.
    pub(super) fn take_over(
        &mut self,
        before: &mut Self,
        is_kept: &[bool],
        sample: &Fresh,
    ) -> Answer {
        let from = (&before.renderer, &before.state);
        self.renderer.take_commands(&mut self.state, from);
        let _ = before.step(sample);
        self.renderer
            .take_over(&mut self.state, &before.state, is_kept);
        self.booked = self.state.books().created();
        self.created = before.created;
        self.is_new = true;
        self.answered = before.answered;
        self.passing = Passing::Begins;
        self.step(sample)
    }

    /// The answer to a sample, on its way from that of the world before to `own`.
    fn pass(&mut self, own: Wrench) -> Wrench {
        let (more, part) = match self.passing {
            Passing::Over => return own,
            Passing::Begins => (apart(self.answered, own), 0.0),
            Passing::Under { more, part } => (more, part + self.period() / CHANGE_DURATION),
        };
        self.passing = if part < 1.0 {
            Passing::Under { more, part }
        } else {
            Passing::Over
        };
        let left = 1.0 - part.min(1.0);
        let on_top = |own: Vector, more: Vector| {
            let mut sum = own;
            for (sum, more) in sum.iter_mut().zip(more) {
                *sum += left * more;
            }
            sum
        };
        Wrench {
            force: on_top(own.force, more.force),
            torque: on_top(own.torque, more.torque),
        }
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

/// What `one` is more than `other`.
fn apart(one: Wrench, other: Wrench) -> Wrench {
    let less = |one: Vector, other: Vector| {
        let mut less = one;
        for (less, other) in less.iter_mut().zip(other) {
            *less -= other;
        }
        less
    };
    Wrench {
        force: less(one.force, other.force),
        torque: less(one.torque, other.torque),
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
        let own = Wrench {
            force: self.frame.on_device(force),
            torque,
        };
        // A sample that was refused is answered by nothing.
        self.answered = if fault.is_some() { own } else { self.pass(own) };
        Answer {
            wrench: self.answered,
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
