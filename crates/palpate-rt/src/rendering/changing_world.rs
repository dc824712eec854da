//! A world in the loop that another one can take the place of, from any thread.

use palpate_device::clock::Clock;
use palpate_device::{Device, Vector, Wrench};
use palpate_record::recording::{BodyTick, ContactTick, Flags};
use palpate_world::{Motion, World};

use super::renders::{Answer, Fresh, Renders};
use super::world::RenderedWorld;
use crate::control_loop::ControlLoop;
use crate::safety::SafetyParams;
use crate::setup::SetupError;

/// Worlds that may wait to be taken by the loop.
const WAITING: usize = 8;

/// A world in the loop, and those that come to take its place.
#[derive(Debug)]
pub struct ChangingWorld {
    world: RenderedWorld,
    generation: u32,
    /// What takes its place with the next sample.
    next: Option<Box<Other>>,
    coming: rtrb::Consumer<Box<Other>>,
    /// Those that have gone, for the other side to free: a tick does not.
    gone: rtrb::Producer<Box<Other>>,
}

/// A world that is to be rendered, and after that the one that was.
#[derive(Debug)]
struct Other {
    world: RenderedWorld,
    generation: u32,
    is_kept: Vec<bool>,
}

/// The other end of the loop's world, for any thread: worlds are handed over without either side ever waiting.
#[derive(Debug)]
pub struct Worlds {
    out: rtrb::Producer<Box<Other>>,
    back: rtrb::Consumer<Box<Other>>,
    described: World,
    /// Of the first world: its period and where the device stands in it.
    like: RenderedWorld,
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
    /// The loop has not taken what came before.
    #[error("{WAITING} worlds wait to be rendered already; the loop takes them with its next tick")]
    Busy,
}

/// A loop's world and the other end of it. `described` is what `world` renders.
#[must_use]
pub fn changing_world(described: World, world: RenderedWorld) -> (Worlds, ChangingWorld) {
    let (out, coming) = rtrb::RingBuffer::new(WAITING);
    // With room for what waits and for what was taken with it.
    let (gone, back) = rtrb::RingBuffer::new(2 * WAITING);
    let worlds = Worlds {
        out,
        back,
        described,
        like: world.clone(),
        generation: 0,
    };
    let world = ChangingWorld {
        world,
        generation: 0,
        next: None,
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

    /// Renders `world` from the next tick on; `described` is what it renders. A body goes on from where it is, as fast as it
    /// is, where place and motion at the start are described as before; else it is put there. The answer passes over to the
    /// new one in a tenth of a second. The books of energy begin anew. Its number.
    ///
    /// # Errors
    /// Another period, other devices, bodies or pairs that may touch, or a device that stands elsewhere; too many at once.
    pub fn change(
        &mut self,
        described: World,
        world: RenderedWorld,
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
        let generation = self.generation.wrapping_add(1);
        let other = Box::new(Other {
            is_kept: is_kept.collect(),
            world,
            generation,
        });
        self.out.push(other).map_err(|_| WorldChangeError::Busy)?;
        self.described = described;
        self.generation = generation;
        Ok(generation)
    }

    fn check(&self, described: &World, world: &RenderedWorld) -> Result<(), WorldChangeError> {
        let (now, then) = (self.like.period(), world.period());
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
        let (now, then) = (pairs(&self.like), pairs(world));
        same("the pairs that may touch", now.join(", "), then.join(", "))?;
        if self.like.frame() != world.frame() || self.like.turns() != world.turns() {
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
            if self.gone.slots() < 2 {
                break;
            }
            let Ok(mut other) = self.coming.pop() else {
                break;
            };
            taken = Some(other.generation);
            if let Some(overtaken) = self.next.take() {
                // Where it would have put a body is where the other one describes it.
                let kept = other.is_kept.iter_mut().zip(&overtaken.is_kept);
                kept.for_each(|(kept, was_kept)| *kept &= was_kept);
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

    fn step(&mut self, sample: &Fresh) -> Answer {
        let Some(mut other) = self.next.take() else {
            return self.world.step(sample);
        };
        let answer = other
            .world
            .take_over(&mut self.world, &other.is_kept, sample);
        std::mem::swap(&mut self.world, &mut other.world);
        self.let_go(other);
        answer
    }

    fn report_written(&mut self, held: Wrench, sent: Option<Wrench>) {
        self.world.report_written(held, sent);
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
        if world.world.turns() && device.capabilities().torque_axes != 3 {
            return Err(SetupError::SixAxes);
        }
        Self::rendering(device, clock, world, limits)
    }
}
