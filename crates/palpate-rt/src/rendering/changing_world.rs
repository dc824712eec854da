//! A world in the loop that another one can take the place of, from any thread.

use palpate::Actuation;
use palpate_device::clock::Clock;
use palpate_device::{Device, Vector, Wrench};
use palpate_record::recording::{BodyTick, ContactTick, Flags};
use palpate_world::{Motion, Succession, World, WorldError};

use super::renders::{Answer, Fresh, Renders};
use super::world::RenderedWorld;
use crate::control_loop::ControlLoop;
use crate::fade::Fade;
use crate::safety::SafetyParams;
use crate::setup::{SetupError, can_turn};

/// Worlds that may wait to be taken by the loop.
const WAITING: usize = 8;

/// A world in the loop, and those that come to take its place.
#[derive(Debug)]
pub struct ChangingWorld {
    world: RenderedWorld,
    generation: u32,
    /// What takes its place with the next sample.
    next: Option<Box<Other>>,
    /// The world before the last change, while the device is held as by that.
    before: Option<Box<Other>>,
    /// What is left of what was held before a change.
    fade: Fade,
    /// What was answered last, for each device.
    held: Vec<Wrench>,
    /// What the world asks for, and what the one before the last change does.
    asked: Vec<Wrench>,
    asked_before: Vec<Wrench>,
    coming: rtrb::Consumer<Box<Other>>,
    /// Those that have gone, for the other side to free: a tick does not.
    gone: rtrb::Producer<Box<Other>>,
}

/// A world that is to be rendered, and after that the one that was.
#[derive(Debug)]
struct Other {
    world: RenderedWorld,
    generation: u32,
    /// What goes on in it of the world that was handed over before it.
    succession: Succession,
}

/// The other end of the loop's world, for any thread: worlds are handed over without either side ever waiting.
#[derive(Debug)]
pub struct Worlds {
    out: rtrb::Producer<Box<Other>>,
    back: rtrb::Consumer<Box<Other>>,
    described: World,
    /// As it was handed over last.
    last: RenderedWorld,
    generation: u32,
}

/// Why a world cannot take the place of another one.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WorldChangeError {
    /// The period is another.
    #[error("the period is {now} s and cannot become {then} s while the loop runs")]
    Period {
        /// In the loop `[s]`.
        now: f64,
        /// In the world that is refused `[s]`.
        then: f64,
    },
    /// Devices or bodies are others, or in another order: rows of ticks go by their numbers.
    #[error(
        "{what} are {then}, but must stay {now} while the loop runs: ticks go by their numbers"
    )]
    Names {
        /// What, in the plural.
        what: &'static str,
        /// Those in the loop.
        now: String,
        /// Those of the world that is refused.
        then: String,
    },
    /// The device would stand elsewhere in the world, or turn where it did not.
    #[error(
        "the device must stand in the world as it does, and turn or not as it does, while the loop runs"
    )]
    Device,
    /// It cannot go on from the world before.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Succession(Vec<WorldError>),
    /// The loop has not taken what came before.
    #[error("{WAITING} worlds wait to be rendered already; the loop takes them with its next tick")]
    Busy,
}

/// A loop's world and the other end of it. `described` is what `world` renders.
#[must_use]
pub fn changing_world(described: World, world: RenderedWorld) -> (Worlds, ChangingWorld) {
    let (out, coming) = rtrb::RingBuffer::new(WAITING);
    // With room for what waits, and for what was taken with it and before it.
    let (gone, back) = rtrb::RingBuffer::new(3 * WAITING);
    let worlds = Worlds {
        out,
        back,
        described,
        last: world.clone(),
        generation: 0,
    };
    let devices = world.devices();
    let world = ChangingWorld {
        world,
        generation: 0,
        next: None,
        before: None,
        fade: Fade::none(devices),
        held: vec![Wrench::NONE; devices],
        asked: vec![Wrench::NONE; devices],
        asked_before: vec![Wrench::NONE; devices],
        coming,
        gone,
    };
    (worlds, world)
}

impl Worlds {
    /// The world that was handed over last.
    #[must_use]
    pub fn described(&self) -> &World {
        &self.described
    }

    /// Number of the world that was handed over last, which the ticks carry from where it is in force.
    #[must_use]
    pub fn generation(&self) -> u32 {
        self.generation
    }

    /// Renders `world` from the next tick on. `described` is the world that it renders. Returns the number of this change.
    ///
    /// - A body keeps its place and its velocity if `described` and the world before give the same place and motion at the
    ///   start. Otherwise the body is put where `described` says.
    /// - [`WorldRenderer::changed`](palpate_world::WorldRenderer::changed) says what else goes on, and how the energy is booked.
    ///   Another method knows nothing of the device yet.
    /// - For three samples the device gets the force of the world before. The difference to the new force then fades in
    ///   [`CHANGE_DURATION`](crate::CHANGE_DURATION).
    ///
    /// # Errors
    /// Another period, other devices, bodies or pairs that may touch, or a device that stands elsewhere; too many at once.
    pub fn change(
        &mut self,
        described: World,
        mut world: RenderedWorld,
    ) -> Result<u32, WorldChangeError> {
        // What the loop has done with is freed here.
        while self.back.pop().is_ok() {}
        self.check(&described, &world)?;
        let now = self.described.bodies.iter();
        let is_kept = now.zip(&described.bodies).map(|(now, then)| {
            let motion = |motion: &Motion| match motion {
                Motion::Free(free) => Some((free.velocity, free.angular_velocity)),
                Motion::Fixed => None,
            };
            let is_there = (now.position, now.orientation) == (then.position, then.orientation);
            is_there && motion(&now.motion) == motion(&then.motion)
        });
        let is_kept: Vec<bool> = is_kept.collect();
        let succession = world
            .succeed(&self.last, &is_kept)
            .map_err(WorldChangeError::Succession)?;
        let generation = self.generation.wrapping_add(1);
        let last = world.clone();
        let other = Box::new(Other {
            succession,
            world,
            generation,
        });
        self.out.push(other).map_err(|_| WorldChangeError::Busy)?;
        self.last = last;
        self.described = described;
        self.generation = generation;
        Ok(generation)
    }

    fn check(&self, described: &World, world: &RenderedWorld) -> Result<(), WorldChangeError> {
        let (now, then) = (self.last.period(), world.period());
        if now != then {
            return Err(WorldChangeError::Period { now, then });
        }
        let tools = |world: &World| list(world.tools.iter().map(|tool| tool.name.as_str()));
        let bodies = |world: &World| list(world.bodies.iter().map(|body| body.name.as_str()));
        let same = |what, now: String, then: String| {
            if now == then {
                Ok(())
            } else {
                Err(WorldChangeError::Names { what, now, then })
            }
        };
        same("the devices", tools(&self.described), tools(described))?;
        same("the bodies", bodies(&self.described), bodies(described))?;
        let pairs = |world: &RenderedWorld| {
            let between = world.state().contacts().iter();
            let between = between.map(|contact| format!("{:?}", contact.between));
            between.collect::<Vec<_>>()
        };
        let (now, then) = (pairs(&self.last), pairs(world));
        same("the pairs that may touch", now.join(", "), then.join(", "))?;
        if self.last.frames() != world.frames() || self.last.turns() != world.turns() {
            return Err(WorldChangeError::Device);
        }
        Ok(())
    }
}

fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.collect::<Vec<_>>().join(", ")
}

impl ChangingWorld {
    /// What is rendered.
    #[must_use]
    pub fn world(&self) -> &RenderedWorld {
        &self.world
    }

    /// Hands back what the loop has done with.
    fn let_go(&mut self, other: Box<Other>) {
        if let Err(rtrb::PushError::Full(other)) = self.gone.push(other) {
            // There was room, and nobody else fills it. What is freed by nobody keeps no tick waiting.
            std::mem::forget(other);
        }
    }
}

impl Renders for ChangingWorld {
    fn devices(&self) -> usize {
        self.world.devices()
    }

    fn device_name(&self, device: usize) -> Option<&str> {
        self.world.device_name(device)
    }

    fn period(&self) -> f64 {
        self.world.period()
    }

    fn method(&self) -> &'static str {
        let next = self.next.as_ref().map(|other| &other.world);
        next.unwrap_or(&self.world).method()
    }

    fn take_other_world(&mut self) -> Option<u32> {
        let mut taken = None;
        // At most as many as may wait. One for which there is no room among those that have gone waits on.
        for _ in 0..WAITING {
            if self.gone.slots() < 3 {
                break;
            }
            let Ok(mut other) = self.coming.pop() else {
                break;
            };
            taken = Some(other.generation);
            if let Some(overtaken) = self.next.take() {
                // Where it would have put a body is where the other one describes it.
                other.succession.skip(&overtaken.succession);
                self.let_go(overtaken);
            }
            self.next = Some(other);
        }
        self.generation = taken.unwrap_or(self.generation);
        taken
    }

    fn generation(&self) -> u32 {
        self.generation
    }

    fn step(&mut self, sample: &Fresh<'_>, asked: &mut [Wrench]) -> Answer {
        if let Some(mut other) = self.next.take() {
            other.world.go_on(&self.world, &other.succession);
            std::mem::swap(&mut self.world, &mut other.world);
            if let Some(before) = self.before.replace(other) {
                self.let_go(before);
            }
            self.fade.begin();
        }
        let is_compared = match &mut self.before {
            Some(before) if self.fade.is_settling() => {
                let answer = before.world.step(sample, &mut self.asked_before);
                answer.fault.is_none()
            }
            _ => false,
        };
        let answer = self.world.step(sample, &mut self.asked);
        if answer.fault.is_some() {
            self.fade.end();
        }
        let elapsed = sample.elapsed.unwrap_or_else(|| self.world.period());
        let wanted = self.asked.iter().copied();
        let as_before = is_compared.then_some(&*self.asked_before);
        if self.fade.answer(wanted, as_before, elapsed, &mut self.held) {
            self.world.keep_within(&mut self.held);
        }
        if !self.fade.is_settling()
            && let Some(before) = self.before.take()
        {
            self.let_go(before);
        }
        for (asked, held) in asked.iter_mut().zip(&self.held) {
            *asked = *held;
        }
        answer
    }

    fn report_written(&mut self, device: usize, held: Wrench, sent: Option<Wrench>) {
        self.world.report_written(device, held, sent);
    }

    fn account(&mut self, sequence: u64, delivered: Vector) {
        self.world.account(sequence, delivered);
    }

    fn contacts(&self) -> &[ContactTick] {
        self.world.contacts()
    }

    fn bodies(&self) -> &[BodyTick] {
        self.world.bodies()
    }

    fn flags(&self) -> Flags {
        self.world.flags()
    }

    fn learned_lateness(&self) -> f64 {
        self.world.learned_lateness()
    }

    fn actuation(&self) -> Actuation<f64> {
        self.world.actuation()
    }

    fn created_energy(&self) -> f64 {
        self.world.created_energy()
    }
}

impl<D: Device, C: Clock> ControlLoop<D, C, ChangingWorld> {
    /// A loop that renders a world on `device`, of which another one can take the place. It ticks from the first call of
    /// [`tick`](Self::tick) on.
    ///
    /// # Errors
    /// As those of [`of_world`](ControlLoop::of_world).
    pub fn of_changing_world(
        device: D,
        clock: C,
        world: ChangingWorld,
        limits: SafetyParams,
    ) -> Result<Self, SetupError> {
        Self::of_changing_devices(vec![(device, limits)], clock, world)
    }

    /// The same on several devices, each with its own limits: one for each tool of the world, in their order.
    ///
    /// # Errors
    /// As those of [`of_devices`](ControlLoop::of_devices).
    pub fn of_changing_devices(
        devices: Vec<(D, SafetyParams)>,
        clock: C,
        world: ChangingWorld,
    ) -> Result<Self, SetupError> {
        can_turn(world.world(), devices.iter().map(|(device, _)| device))?;
        Self::rendering(devices, clock, world)
    }
}
