//! State between ticks, and its readable part.

use super::past::{Past, Then};
use super::progress::LocalProgress;
use super::slot::Slot;
use crate::engine::integration::Meeting;
use crate::engine::pairs::Pair;
use crate::engine::state::{BodyPortLedger, EngineContact, EngineState, PortLedger};
use crate::{ContactLedger, Effort, Limited, ToolState, Vector, WorldFault};

/// State of a local model in the loop, created by [`LocalRenderer::start`](super::LocalRenderer::start).
#[derive(Clone, Debug)]
pub struct LocalState {
    pub(super) engine: EngineState,
    pub(super) pairs: Vec<Pair>,
    pub(super) slots: Vec<Slot>,
    /// Prediction of the host's bodies from one model to the next.
    pub(super) host: Meeting,
    /// Scratch buffer for the state of `host` at the start of a sub-step.
    pub(super) host_before: Meeting,
    /// Scratch buffer for the copies over missed ticks.
    pub(super) late: Meeting,
    /// Delay of tick time relative to elapsed time, in periods; negative if ticks came early.
    pub(super) behind: f64,
    pub(super) past: Past,
    /// Tick of the newest model.
    pub(super) model_tick: Option<u64>,
    /// Whether the copies follow the newest model; `false` once it is stale.
    pub(super) is_known: bool,
    /// State of the copies at that tick.
    pub(super) at_model: Vec<Then>,
    /// Time over which changes are blended in `[s]`.
    pub(super) settle: f64,
    pub(super) is_stale: bool,
    pub(super) progress: LocalProgress,
    pub(super) refusal: Option<ModelRefusal>,
    /// Whether a model arrived with the last sample.
    pub(super) came: bool,
    pub(super) slow_ports: Vec<BodyPortLedger>,
    /// Work of the tools on each copy since the start `[J]`.
    pub(super) works: Vec<f64>,
}

/// Result of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalOutput<'a> {
    /// Force on each tool, which its device exerts on the hand until the next sample `[N]`.
    pub forces: &'a [Vector],
    /// Active limits.
    pub limited: Limited,
    /// Computing effort of the tick, and sub-steps that exceeded the budget.
    pub effort: Effort,
    /// Reason for the absence of contact: an unusable sample or a non-finite motion. All forces are 0 then.
    pub fault: Option<WorldFault>,
    /// Age of the newest model `[s]`; `None` without a model.
    pub age: Option<f64>,
    /// Whether the contacts are fading or have faded because the model is missing or stale.
    pub is_stale: bool,
    /// Reason why the model that arrived with this sample was rejected, if it was. The previous model remains in use.
    pub refusal: Option<ModelRefusal>,
}

/// Reason for rejecting a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelRefusal {
    /// Its tick is in the future.
    NotYet,
    /// Its tick precedes that of the previous model.
    OutOfOrder,
    /// It is older than [`LocalParams::stale_after`](super::LocalParams::stale_after).
    TooOld,
    /// It was made by a renderer with a different number of tools, bodies or contacts.
    OtherRoom,
}

/// Energy ledger of a local model.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct LocalLedger<'a> {
    /// Ledger of each contact slot; zero for contacts between the host's own bodies. `outside` is the energy added by
    /// new models and by contacts that fade out or in.
    pub contacts: &'a [ContactLedger],
    /// Ledger of each device.
    pub devices: &'a [PortLedger],
    /// Ledger of each body.
    pub slow_ports: &'a [BodyPortLedger],
}

impl LocalLedger<'_> {
    /// Returns the energy generated between hand, contacts and the host's bodies since the start `[J]`. It is the sum
    /// of three parts: work at the devices, plus the part carried by mechanisms that lack an axis, minus the work on
    /// their proxies; work on the host's bodies minus the work on their copies; energy added to the tools' contacts
    /// by samples, models and finite sub-steps.
    #[must_use]
    pub fn created(&self) -> f64 {
        let contacts = self.contacts.iter();
        let of_contacts: f64 = contacts
            .map(|entry| entry.observed + entry.outside + entry.step_error - entry.work_on_proxy)
            .sum();
        let devices = self.devices.iter();
        let devices: f64 = devices.map(|entry| entry.port_work + entry.carried).sum();
        of_contacts + devices + BodyPortLedger::created(self.slow_ports)
    }
}

impl LocalState {
    /// Returns the estimated state of each tool at the last sample.
    #[must_use]
    pub fn tools(&self) -> &[ToolState] {
        self.engine.tools()
    }

    /// Returns the progress that the host needs for its next step.
    #[must_use]
    pub fn progress(&self) -> &LocalProgress {
        &self.progress
    }

    /// Returns the contacts of all slots in which a tool may touch something, with the slot index. The fixed world
    /// has body index [`LocalParams::bodies`](super::LocalParams::bodies), which no body has.
    pub fn contacts(&self) -> impl Iterator<Item = (usize, &EngineContact)> {
        let slots = self.engine.contacts().iter().zip(&self.pairs).enumerate();
        let of_tools = slots.filter(|(_, (_, pair))| pair.is_open && pair.toucher.tool().is_some());
        of_tools.map(|(slot, (contact, _))| (slot, contact))
    }

    /// Returns the energy generated at the ports of the devices `[J]`: [`LocalLedger::created`], weighted for each
    /// contact by the fraction of its force that reached the device after limiting.
    #[must_use]
    pub fn created_at_ports(&self) -> f64 {
        self.engine.created_at_ports()
    }

    /// Returns the energy ledger.
    #[must_use]
    pub fn ledger(&self) -> LocalLedger<'_> {
        let ledger = self.engine.ledger();
        LocalLedger {
            contacts: &ledger.contacts,
            devices: &ledger.devices,
            slow_ports: &self.slow_ports,
        }
    }
}
