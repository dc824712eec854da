//! What is remembered from period to period, and what can be read from it.

use nalgebra::Vector6;
use palpate::Fault;

use super::body::BodyNow;
use super::image::ImageOffset;
use super::meeting::Meeting;
use super::pairs::Pair;
use crate::books::CreatedAtPorts;
use crate::commands::Commands;
use crate::method::coupled_avatar::Avatar;
use crate::observer::{AxisMotion, AxisObserver, AxisPrior};
use crate::rigid::Vector3;
use crate::tracking::Tracking;
use crate::{ContactBook, Effort, Limited, Mode, ToolState, Vector, WorldFault};

/// Contacts with an engine's bodies at a sample: made by [`EngineRenderer::start`](super::EngineRenderer::start).
#[derive(Clone, Debug)]
pub struct EngineState {
    pub(super) meeting: Meeting,
    /// Room for what a sub-step begins with.
    pub(super) before: Meeting,
    pub(super) offsets: Vec<ImageOffset>,
    /// Whether a tool touched the body in the period.
    pub(super) is_body_touched: Vec<bool>,
    /// Of each body, what the tools did to it in the engine's step that has not been seen to end.
    pub(super) pushed: Vec<Option<Pushed>>,
    pub(super) devices: Vec<TrackedDevice>,
    pub(super) tracking: Tracking,
    pub(super) commands: Commands,
    pub(super) intended: Vec<Vector3>,
    pub(super) forces: Vec<Vector>,
    /// How long the engine has been stepped since the sample `[s]`.
    pub(super) advanced: f64,
    pub(super) fault: Option<WorldFault>,
    pub(super) limited: Limited,
    pub(super) effort: Effort,
    pub(super) tools: Vec<ToolState>,
    pub(super) contacts: Vec<EngineContact>,
    pub(super) books: EngineBooks,
    pub(super) at_ports: CreatedAtPorts,
}

/// What is known of a device and of its avatar.
#[derive(Clone, Copy, Debug)]
pub(super) struct TrackedDevice {
    /// Where the last sample has found it `[m]`.
    pub measured: Vector3,
    pub observers: [AxisObserver; 3],
    /// The device where the period of the next command begins.
    pub ahead: [AxisMotion; 3],
    /// At the beginning of the period.
    pub avatar: Avatar,
    pub period: Option<Period>,
}

/// What a period was planned to be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Period {
    /// How long it was `[s]`.
    pub duration: f64,
    /// Mean force of the contacts `[N]`, and by how much its impulse came early `[N s^2]`.
    pub mean: Vector3,
    pub lead: Vector3,
    /// What the device was to be held by `[N]`.
    pub held: Vector3,
    /// Whether something touched the tool.
    pub touched: bool,
}

impl TrackedDevice {
    pub fn new(priors: &[AxisPrior; 3], measured: Vector3) -> Self {
        let observers = priors.each_ref().map(AxisObserver::new);
        Self {
            measured,
            observers,
            ahead: observers.each_ref().map(|observer| observer.motion),
            avatar: Avatar::none(),
            period: None,
        }
    }

    pub fn of(&self, quantity: impl Fn(&AxisMotion) -> f64) -> Vector3 {
        Vector3::from(self.ahead.each_ref().map(quantity))
    }
}

/// The answer to a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EngineOutput<'a> {
    /// Force on each tool `[N]`: what its device is to give to the hand, and to hold until the next sample.
    pub forces: &'a [Vector],
    /// Limits that acted.
    pub limited: Limited,
    /// What the period has cost, over all steps of the engine, and what did not fit in it.
    pub effort: Effort,
    /// Why there was no contact, if there was none: a sample or a state that cannot be used. All forces are then 0.
    pub fault: Option<WorldFault>,
}

/// A point at which a tool may touch a body, at the end of the last period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EngineContact {
    /// Number of the tool.
    pub tool: usize,
    /// Number of the body.
    pub body: usize,
    /// Whether they touch, and how.
    pub mode: Mode,
    /// Where the force acts `[m]`.
    pub point: Vector,
    /// Unit vector from the body to the tool.
    pub normal: Vector,
    /// How far avatar and image overlap, 0 where they do not `[m]`.
    pub penetration: f64,
    /// Force on the tool `[N]`.
    pub force: Vector,
}

/// Energy at the port of a device, over all periods that have ended `[J]`; positive: to the hand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct PortBook {
    /// Work of the force that was held on the device as it was measured.
    pub port_work: f64,
    /// Work of the mean force of its contacts on the device.
    pub held: f64,
    /// The part of it along the axes that the device lacks ([`Tool::axes`](crate::Tool::axes)): its mechanism carries that force.
    pub carried: f64,
}

/// Energy at the port between an image or copy of a body in the renderer and the body of an engine or host, up to the last state
/// of the latter `[J]`.
///
/// `host_work - work` is energy that was made (positive) or lost because the host's body was pushed by a mean wrench, and went
/// another way than the renderer's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct BodyPortBook {
    /// Work of the tools on the renderer's body; of a copy but for periods that the loop has missed.
    pub work: f64,
    /// Work of their wrench on the host's body, from one time that it was seen to the next.
    pub host_work: f64,
}

impl BodyPortBook {
    /// Energy that was made at the ports of all bodies `[J]`.
    pub(super) fn created(books: &[Self]) -> f64 {
        books.iter().map(|book| book.host_work - book.work).sum()
    }
}

/// Effect of the tools on a body in an engine's step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pushed {
    /// Velocity `[m/s]` and angular velocity `[rad/s]` of the engine's body where the step began.
    pub twist: Vector6<f64>,
    /// Impulse of the tools `[N s]`, `[N m s]`.
    pub impulse: Vector6<f64>,
    /// Their work on the image `[J]`.
    pub work: f64,
}

/// The books of contacts with an engine's bodies.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct EngineBooks {
    /// Of each point of contact, in the order of [`EngineState::contacts`]. `observed` is what the stored energy changed
    /// by because a sample moved an avatar, or the engine a body, to another place than was expected.
    pub contacts: Vec<ContactBook>,
    /// Of each device.
    pub devices: Vec<PortBook>,
    /// Of each body.
    pub bodies: Vec<BodyPortBook>,
}

impl EngineBooks {
    /// Energy that held forces have created since the start `[J]`: hands, contacts and the engine's bodies have gained it together.
    /// Work that the engine's constraints and motors take from a body or do on it is not created. It fluctuates with the samples; a rising
    /// sum is an instability.
    #[must_use]
    pub fn created(&self) -> f64 {
        let contacts = self.contacts.iter();
        let contacts = contacts.map(|book| book.observed + book.step_error - book.work_on_avatar);
        let devices = self.devices.iter();
        let devices = devices.map(|book| book.port_work + book.carried);
        contacts.sum::<f64>() + devices.sum::<f64>() + BodyPortBook::created(&self.bodies)
    }
}

impl EngineState {
    /// What is known of each tool at the last sample.
    #[must_use]
    pub fn tools(&self) -> &[ToolState] {
        &self.tools
    }

    /// Where each avatar is at the end of the period `[m]`: what an engine may show as the tool.
    #[must_use]
    pub fn avatars(&self) -> Vec<Vector> {
        let tools = self.meeting.tools.iter();
        tools.map(|tool| tool.rigid.position.into()).collect()
    }

    /// Each point at which a tool may touch a body, whether it does or not.
    #[must_use]
    pub fn contacts(&self) -> &[EngineContact] {
        &self.contacts
    }

    /// Energy that forces created at the ports of the devices `[J]`: [`EngineBooks::created`], where a contact whose force reached
    /// its device by a part, because a limit cut it, counts by that part.
    #[must_use]
    pub fn created_at_ports(&self) -> f64 {
        self.at_ports.created()
    }

    /// The books of energy.
    #[must_use]
    pub fn books(&self) -> &EngineBooks {
        &self.books
    }

    /// Takes account of the energy created at the ports of the devices, up to this sample, and at those of the bodies `[J]`.
    pub(super) fn close_ports(&mut self, pairs: &[Pair], with_bodies: f64) {
        let commands = &self.commands;
        let contacts = self.books.contacts.iter().zip(pairs).map(|(book, pair)| {
            let tool = pair.toucher.tool();
            let part = tool.map_or(1.0, |tool| commands.part_sent(tool));
            (book.created() + book.outside, part)
        });
        let devices = self.books.devices.iter();
        let ports = devices.map(|book| book.port_work + book.carried).sum();
        let tools = 0..self.devices.len();
        let least = tools
            .map(|tool| commands.part_sent(tool))
            .fold(1.0, f64::min);
        self.at_ports.close(contacts, ports, (with_bodies, least));
    }

    /// The engine's `bodies` are seen where a step ended: books what the tools did to each in it. The next step begins.
    pub(super) fn book_ports(&mut self, bodies: &[BodyNow]) {
        let pushed = self.pushed.iter_mut().zip(&mut self.books.bodies);
        for ((pushed, book), body) in pushed.zip(bodies) {
            let twist = body.twist();
            if let Some(pushed) = pushed {
                // Kinetic energy that it has gained by them, however the engine integrates its position.
                let work = pushed.impulse.dot(&(0.5 * (pushed.twist + twist)));
                if work.is_finite() && pushed.work.is_finite() {
                    book.host_work += work;
                    book.work += pushed.work;
                }
            }
            *pushed = Some(Pushed {
                twist,
                impulse: Vector6::zeros(),
                work: 0.0,
            });
        }
    }

    /// Adds `times` the work that the tools' contacts have done on each image since the period began.
    pub(super) fn add_work(&mut self, pairs: &[Pair], times: f64) {
        for (touch, pair) in self.meeting.touches.iter().zip(pairs) {
            let pushed = self.pushed.get_mut(pair.body).and_then(Option::as_mut);
            if let Some(pushed) = pushed.filter(|_| pair.toucher.tool().is_some()) {
                pushed.work += times * (touch.work - touch.work_on_avatar);
            }
        }
    }

    /// Looks at the contacts anew, and books what their stored energy changed by.
    pub(super) fn look(&mut self, pairs: &[Pair], entry: fn(&mut ContactBook) -> &mut f64) {
        self.meeting.look(pairs);
        self.book_stored(pairs, entry);
    }

    /// Books what the stored energy of each contact of a tool has changed by, under one of its entries.
    pub(super) fn book_stored(&mut self, pairs: &[Pair], entry: fn(&mut ContactBook) -> &mut f64) {
        let touches = self.meeting.touches.iter().zip(pairs);
        for (book, (touch, pair)) in self.books.contacts.iter_mut().zip(touches) {
            if pair.toucher.tool().is_none() {
                continue;
            }
            let stored = touch.stored(&pair.law);
            *entry(book) += stored - book.stored;
            book.stored = stored;
        }
    }

    pub(super) fn output(&self) -> EngineOutput<'_> {
        EngineOutput {
            forces: &self.forces,
            limited: self.limited,
            effort: self.effort,
            fault: self.fault,
        }
    }

    pub(super) fn fail(&mut self, fault: Fault) {
        self.fault = Some(WorldFault { fault, tool: None });
    }
}
