//! A world in the loop that any thread can replace.

use palpate_core::Actuation;
use palpate_device::clock::Clock;
use palpate_device::{Device, Line, Vector, Wrench};
use palpate_record::recording::{BodyTick, ContactTick, Flags};
use palpate_world::{Motion, Succession, World, WorldErrors};

use super::renders::{Answer, DeviceSamples, Renders};
use super::world::RenderedWorld;
use crate::control_loop::ControlLoop;
use crate::fade::Fade;
use crate::safety::SafetyParams;
use crate::setup::{SetupError, can_turn};

/// Maximum number of worlds that wait for the loop.
const WAITING: usize = 8;

/// A world in the loop, with its pending replacements.
#[derive(Debug)]
pub struct ChangingWorld {
    world: RenderedWorld,
    generation: u32,
    /// World that replaces it at the next sample.
    next: Option<Box<Other>>,
    /// The world before the last change, while the device holds its forces.
    before: Option<Box<Other>>,
    /// Fading difference to the force before a change.
    fade: Fade,
    /// Last commanded wrench of each device.
    held: Vec<Wrench>,
    /// Wrenches requested by the world and by the one before the last change.
    asked: Vec<Line>,
    asked_before: Vec<Line>,
    coming: rtrb::Consumer<Box<Other>>,
    /// Replaced worlds, which the other end frees: a tick does not free memory.
    gone: rtrb::Producer<Box<Other>>,
}

/// A world that waits to be rendered, and later the replaced one.
#[derive(Debug)]
struct Other {
    world: RenderedWorld,
    generation: u32,
    /// State to continue from the world handed over before it.
    succession: Succession,
}

/// The other end of the loop's world, for any thread. Worlds are handed over without blocking either side.
#[derive(Debug)]
pub struct Worlds {
    out: rtrb::Producer<Box<Other>>,
    back: rtrb::Consumer<Box<Other>>,
    described: World,
    /// The world that was handed over last.
    last: RenderedWorld,
    generation: u32,
}

/// Reason why a world cannot replace another one.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WorldChangeError {
    /// The periods differ.
    #[error("the period is {now} s and cannot become {then} s while the loop runs")]
    Period {
        /// Period of the loop `[s]`.
        now: f64,
        /// Period of the rejected world `[s]`.
        then: f64,
    },
    /// The devices or bodies differ, or are in another order: rows of ticks refer to their indices.
    #[error(
        "{what} are {then}, but must stay {now} while the loop runs: ticks refer to their indices"
    )]
    Names {
        /// Kind of the items, in the plural.
        what: &'static str,
        /// Items of the loop.
        now: String,
        /// Items of the rejected world.
        then: String,
    },
    /// The frame of a device, or whether its tool rotates, differs.
    #[error(
        "the frame of a device, and whether its tool rotates, cannot change while the loop runs"
    )]
    Device,
    /// The actuators hold lines in one world and constants in the other.
    #[error("the hold of the actuators cannot change while the loop runs")]
    Hold,
    /// The world cannot continue from the previous one.
    #[error(transparent)]
    Succession(#[from] WorldErrors),
    /// The loop has not taken the earlier worlds.
    #[error("{WAITING} worlds are already queued; the loop takes them at its next tick")]
    Busy,
}

/// Creates a loop's world and its other end. `described` is the world that `world` renders.
#[must_use]
pub fn changing_world(described: World, world: RenderedWorld) -> (Worlds, ChangingWorld) {
    let (out, coming) = rtrb::RingBuffer::new(WAITING);
    // Capacity for the waiting worlds and for those replaced together with and before them.
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
        asked: vec![Line::NONE; devices],
        asked_before: vec![Line::NONE; devices],
        coming,
        gone,
    };
    (worlds, world)
}

impl Worlds {
    /// Returns the world that was handed over last.
    #[must_use]
    pub fn described(&self) -> &World {
        &self.described
    }

    /// Returns the number of that world. Ticks carry the number of the world in force.
    #[must_use]
    pub fn generation(&self) -> u32 {
        self.generation
    }

    /// Renders `world` from the next tick on. `described` is the world that it renders. Returns the number of this
    /// change.
    ///
    /// - A body keeps its position and velocity if `described` and the world before have the same initial state of
    ///   the body. Otherwise the body moves to the state in `described`.
    /// - [`WorldRenderer::changed`](palpate_world::WorldRenderer::changed) describes the other state that continues,
    ///   and the energy ledger. A new method starts without knowledge of the device's motion.
    /// - For three samples the device gets the force of the world before. The difference to the new force then fades
    ///   in [`CHANGE_DURATION`](crate::CHANGE_DURATION).
    ///
    /// # Errors
    /// Another period, device, body, pair of bodies or frame of a device; too many waiting worlds.
    pub fn change(
        &mut self,
        described: World,
        mut world: RenderedWorld,
    ) -> Result<u32, WorldChangeError> {
        // Free the worlds that the loop returned.
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
        let succession = world.migrate(&self.last, &is_kept)?;
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
        same("the contact pairs", now.join(", "), then.join(", "))?;
        if self.last.actuation().hold != world.actuation().hold {
            return Err(WorldChangeError::Hold);
        }
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
    /// Returns the rendered world.
    #[must_use]
    pub fn world(&self) -> &RenderedWorld {
        &self.world
    }

    /// Returns a world to the other end, which frees it.
    fn disable_output(&mut self, other: Box<Other>) {
        if let Err(rtrb::PushError::Full(other)) = self.gone.push(other) {
            // Unreachable: the ring has capacity for every world in flight, and this is its only producer. Leak
            // rather than free memory in a tick.
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
        // At most as many as may wait. A world stays in the ring while there is no capacity to return it.
        for _ in 0..WAITING {
            if self.gone.slots() < 3 {
                break;
            }
            let Ok(mut other) = self.coming.pop() else {
                break;
            };
            taken = Some(other.generation);
            if let Some(overtaken) = self.next.take() {
                // A body that the skipped world would have moved starts from its state in the newer world.
                other.succession.skip(&overtaken.succession);
                self.disable_output(overtaken);
            }
            self.next = Some(other);
        }
        self.generation = taken.unwrap_or(self.generation);
        taken
    }

    fn generation(&self) -> u32 {
        self.generation
    }

    fn step(&mut self, sample: &DeviceSamples<'_>, asked: &mut [Line]) -> Answer {
        if let Some(mut other) = self.next.take() {
            other.world.resume(&self.world, &other.succession);
            std::mem::swap(&mut self.world, &mut other.world);
            if let Some(before) = self.before.replace(other) {
                self.disable_output(before);
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
        let is_settling = self.fade.is_settling();
        let wanted = self.asked.iter().map(|asked| asked.wrench);
        let as_before = |device: usize| {
            let before = self.asked_before.get(device).filter(|_| is_compared);
            before.map(|before| before.wrench)
        };
        let is_fading = self.fade.answer(wanted, as_before, elapsed, &mut self.held);
        if is_fading {
            self.world.keep_within(&mut self.held);
        }
        if !self.fade.is_settling()
            && let Some(before) = self.before.take()
        {
            self.disable_output(before);
        }
        let lines = self.asked.iter().zip(&self.asked_before).zip(&self.held);
        for (device, (asked, ((now, before), held))) in asked.iter_mut().zip(lines).enumerate() {
            let mut slope = match (is_settling, is_compared) {
                (false, _) => now.slope,
                (true, true) => before.slope,
                (true, false) => [0.0; 3],
            };
            if is_fading {
                self.world
                    .keep_slope_within(device, &held.force, &mut slope);
            }
            *asked = Line {
                slope,
                ..(*held).into()
            };
        }
        answer
    }

    fn report_written(&mut self, device: usize, held: Line, sent: Option<Line>) {
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
    /// Creates a loop that renders a replaceable world on `device`. It starts at the first call of
    /// [`tick`](Self::tick).
    ///
    /// # Errors
    /// Those of [`of_world`](ControlLoop::of_world).
    pub fn of_changing_world(
        device: D,
        clock: C,
        world: ChangingWorld,
        limits: SafetyParams,
    ) -> Result<Self, SetupError> {
        Self::of_changing_devices(vec![(device, limits)], clock, world)
    }

    /// Creates a loop that renders a replaceable world on several devices, each with its own limits: one for each
    /// tool of the world, in their order.
    ///
    /// # Errors
    /// Those of [`of_devices`](ControlLoop::of_devices).
    pub fn of_changing_devices(
        devices: Vec<(D, SafetyParams)>,
        clock: C,
        world: ChangingWorld,
    ) -> Result<Self, SetupError> {
        can_turn(world.world(), devices.iter().map(|(device, _)| device))?;
        Self::rendering(devices, clock, world)
    }
}
