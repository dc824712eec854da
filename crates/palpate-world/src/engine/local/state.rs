//! What is remembered from tick to tick, and what can be read from it.

use super::past::{Past, Then};
use super::progress::LocalProgress;
use super::slot::Slot;
use crate::engine::meeting::Meeting;
use crate::engine::pairs::Pair;
use crate::engine::state::{BodyPortBook, EngineContact, EngineState, PortBook};
use crate::{ContactBook, Effort, Limited, ToolState, Vector, WorldFault};

/// A local model in the loop: made by [`LocalRenderer::start`](super::LocalRenderer::start).
#[derive(Clone, Debug)]
pub struct LocalState {
    pub(super) engine: EngineState,
    pub(super) pairs: Vec<Pair>,
    pub(super) slots: Vec<Slot>,
    /// The host's bodies as they are expected from one model to the next.
    pub(super) host: Meeting,
    /// Room for what a sub-step of it begins with.
    pub(super) host_before: Meeting,
    /// Room for the copies over ticks that the loop has missed.
    pub(super) late: Meeting,
    /// How far the time of the ticks is behind that which has passed, in periods; below 0 where ticks came early.
    pub(super) behind: f64,
    pub(super) past: Past,
    /// Tick of the newest model.
    pub(super) model_tick: Option<u64>,
    /// Whether the copies go on from it: not where it has become too old.
    pub(super) is_known: bool,
    /// The copies at that tick.
    pub(super) at_model: Vec<Then>,
    /// Time in which changes come in `[s]`.
    pub(super) settle: f64,
    pub(super) is_stale: bool,
    pub(super) progress: LocalProgress,
    pub(super) refusal: Option<ModelRefusal>,
    /// Whether a model came with the last sample.
    pub(super) came: bool,
    pub(super) slow_ports: Vec<BodyPortBook>,
    /// Work of the tools on each copy since the start `[J]`.
    pub(super) works: Vec<f64>,
}

/// The answer to one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalOutput<'a> {
    /// Force on each tool `[N]`: what its device is to give to the hand, and to hold until the next sample.
    pub forces: &'a [Vector],
    /// Limits that acted.
    pub limited: Limited,
    /// What the tick has cost, and what did not fit in it.
    pub effort: Effort,
    /// Why there was no contact, if there was none: a sample that cannot be used, or a motion that is no number. All forces are
    /// then 0.
    pub fault: Option<WorldFault>,
    /// Age of the newest model `[s]`; `None` where there is none.
    pub age: Option<f64>,
    /// Whether the contacts fade, or have faded, because there is no model or it is too old.
    pub is_stale: bool,
    /// Why the model that came with this sample was not taken, if it was not. The one before goes on.
    pub refusal: Option<ModelRefusal>,
}

/// Why a model was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelRefusal {
    /// It is of a tick that has not been.
    NotYet,
    /// It is of a tick before that of the model before.
    OutOfOrder,
    /// It is older than [`LocalParams::stale_after`](super::LocalParams::stale_after).
    TooOld,
    /// It was made by a renderer with other numbers of tools, bodies or contacts.
    OtherRoom,
}

/// The books of a local model.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct LocalBooks<'a> {
    /// Of each slot for a contact; zero for contacts of the host's own. `outside` is what new models, and contacts that fade or come back, have put into it.
    pub contacts: &'a [ContactBook],
    /// Of each device.
    pub devices: &'a [PortBook],
    /// Of each body.
    pub slow_ports: &'a [BodyPortBook],
}

impl LocalBooks<'_> {
    /// Energy that was made between hand, contacts and the host's bodies since the start `[J]`: work at the devices, and of what
    /// the mechanisms carry of those that lack an axis, less the work on their avatars, work on the host's bodies less the work on their copies, and what samples, models and finite
    /// sub-steps have put into the contacts of tools.
    #[must_use]
    pub fn created(&self) -> f64 {
        let contacts = self.contacts.iter();
        let of_contacts: f64 = contacts
            .map(|book| book.observed + book.outside + book.step_error - book.work_on_avatar)
            .sum();
        let devices = self.devices.iter();
        let devices: f64 = devices.map(|book| book.port_work + book.carried).sum();
        of_contacts + devices + BodyPortBook::created(self.slow_ports)
    }
}

impl LocalState {
    /// What is known of each tool at the last sample.
    #[must_use]
    pub fn tools(&self) -> &[ToolState] {
        self.engine.tools()
    }

    /// What the host needs for its next step.
    #[must_use]
    pub fn progress(&self) -> &LocalProgress {
        &self.progress
    }

    /// Each slot in which a tool may touch something, with its number. The body of what never moves is
    /// [`LocalParams::bodies`](super::LocalParams::bodies), which no body has.
    pub fn contacts(&self) -> impl Iterator<Item = (usize, &EngineContact)> {
        let slots = self.engine.contacts().iter().zip(&self.pairs).enumerate();
        let of_tools = slots.filter(|(_, (_, pair))| pair.is_open && pair.toucher.tool().is_some());
        of_tools.map(|(slot, (contact, _))| (slot, contact))
    }

    /// Energy that forces created at the ports of the devices `[J]`: [`LocalBooks::created`], where a contact whose force reached
    /// its device by a part, because a limit cut it, counts by that part.
    #[must_use]
    pub fn created_at_ports(&self) -> f64 {
        self.engine.created_at_ports()
    }

    /// The books of energy.
    #[must_use]
    pub fn books(&self) -> LocalBooks<'_> {
        let books = self.engine.books();
        LocalBooks {
            contacts: &books.contacts,
            devices: &books.devices,
            slow_ports: &self.slow_ports,
        }
    }
}
