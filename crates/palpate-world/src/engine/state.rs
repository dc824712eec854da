//! State between periods, and its readable part.

use nalgebra::Vector6;
use palpate_core::Fault;

use super::body::BodyNow;
use super::image::ImageOffset;
use super::integration::Meeting;
use super::pairs::Pair;
use crate::device::commands::Commands;
use crate::device::observer::{AxisMotion, AxisObserver, AxisPrior};
use crate::device::tracking::Tracking;
use crate::dynamics::ledger::CreatedAtPorts;
use crate::geometry::rigid::Vector3;
use crate::method::coupled_proxy::ProxyState;
use crate::{ContactLedger, Effort, Limited, Mode, ToolState, Vector, WorldFault};

/// State of the contacts with an engine's bodies at a sample, created by
/// [`EngineRenderer::start`](super::EngineRenderer::start).
#[derive(Clone, Debug)]
pub struct EngineState {
    pub(super) meeting: Meeting,
    /// Scratch buffer for the state at the start of a sub-step.
    pub(super) before: Meeting,
    pub(super) offsets: Vec<ImageOffset>,
    /// Whether a tool touched the body in the period.
    pub(super) is_body_touched: Vec<bool>,
    /// Effect of the tools on each body in the engine's step whose end state is not yet known.
    pub(super) pushed: Vec<Option<Pushed>>,
    pub(super) devices: Vec<TrackedDevice>,
    pub(super) tracking: Tracking,
    pub(super) commands: Commands,
    pub(super) intended: Vec<Vector3>,
    pub(super) forces: Vec<Vector>,
    /// Time by which the engine has been stepped since the sample `[s]`.
    pub(super) advanced: f64,
    pub(super) fault: Option<WorldFault>,
    pub(super) limited: Limited,
    pub(super) effort: Effort,
    pub(super) tools: Vec<ToolState>,
    pub(super) contacts: Vec<EngineContact>,
    pub(super) ledger: EngineLedger,
    pub(super) at_ports: CreatedAtPorts,
}

/// Estimated state of a device, and its proxy.
#[derive(Clone, Copy, Debug)]
pub(super) struct TrackedDevice {
    /// Position at the last sample `[m]`.
    pub measured: Vector3,
    pub observers: [AxisObserver; 3],
    /// Device at the beginning of the next command's period.
    pub ahead: [AxisMotion; 3],
    /// Proxy at the beginning of the period.
    pub proxy: ProxyState,
    pub period: Option<Period>,
}

/// Planned values of a period.
#[derive(Clone, Copy, Debug)]
pub(super) struct Period {
    /// Duration `[s]`.
    pub duration: f64,
    /// Mean contact force `[N]`. `lead` is the moment by which its impulse came early `[N s^2]`.
    pub mean: Vector3,
    pub lead: Vector3,
    /// Force to be held on the device `[N]`.
    pub held: Vector3,
    /// Whether the tool was touched, and whether its force limit acted.
    pub touched: bool,
    pub has_yielded: bool,
}

impl TrackedDevice {
    pub fn new(priors: &[AxisPrior; 3], measured: Vector3) -> Self {
        let observers = priors.each_ref().map(AxisObserver::new);
        Self {
            measured,
            observers,
            ahead: observers.each_ref().map(|observer| observer.motion),
            proxy: ProxyState::none(),
            period: None,
        }
    }

    pub fn of(&self, quantity: impl Fn(&AxisMotion) -> f64) -> Vector3 {
        Vector3::from(self.ahead.each_ref().map(quantity))
    }
}

/// Result of a period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EngineOutput<'a> {
    /// Force on each tool, which its device exerts on the hand until the next sample `[N]`.
    pub forces: &'a [Vector],
    /// Active limits.
    pub limited: Limited,
    /// Computing effort of the period over all steps of the engine, and sub-steps that exceeded the budget.
    pub effort: Effort,
    /// Reason for the absence of contact: an unusable sample or state. All forces are 0 then.
    pub fault: Option<WorldFault>,
}

/// A point at which a tool may touch a body, at the end of the last period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EngineContact {
    /// Index of the tool.
    pub tool: usize,
    /// Index of the body.
    pub body: usize,
    /// Contact mode.
    pub mode: Mode,
    /// Point of application of the force `[m]`.
    pub point: Vector,
    /// Unit vector from the body to the tool.
    pub normal: Vector,
    /// Overlap of proxy and image, 0 if they are apart `[m]`.
    pub penetration: f64,
    /// Force on the tool `[N]`.
    pub force: Vector,
}

/// Energy at the port of a device, over all completed periods `[J]`; positive towards the hand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct PortLedger {
    /// Work of the held force on the measured device motion.
    pub port_work: f64,
    /// Work of the mean contact force on the device.
    pub held: f64,
    /// Part of `held` along the axes that the device lacks ([`Tool::axes`](crate::Tool::axes)): the mechanism carries
    /// it.
    pub carried: f64,
}

/// Energy at the port between a renderer's image or copy of a body and the body of the engine or host, up to the
/// latest known state of the latter `[J]`.
///
/// `host_work - work` is energy generated (positive) or lost because the mean wrench moves the host's body along a
/// different path from the renderer's body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct BodyPortLedger {
    /// Work of the tools on the renderer's body. For a copy, periods that the loop has missed are excluded.
    pub work: f64,
    /// Work of the held wrench on the host's body between its known states.
    pub host_work: f64,
}

impl BodyPortLedger {
    /// Returns the energy generated at the ports of all bodies `[J]`.
    pub(super) fn created(ledger: &[Self]) -> f64 {
        ledger
            .iter()
            .map(|entry| entry.host_work - entry.work)
            .sum()
    }
}

/// Effect of the tools on a body during an engine's step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pushed {
    /// Velocity `[m/s]` and angular velocity `[rad/s]` of the engine's body at the start of the step.
    pub twist: Vector6<f64>,
    /// Impulse of the tools `[N s]`, `[N m s]`.
    pub impulse: Vector6<f64>,
    /// Work of the tools on the image `[J]`.
    pub work: f64,
}

/// Energy ledger of the contacts with an engine's bodies.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct EngineLedger {
    /// Ledger of each contact point, in the order of [`EngineState::contacts`]. `observed` is the change in stored
    /// energy when a sample moved a proxy, or the engine a body, away from the expected position.
    pub contacts: Vec<ContactLedger>,
    /// Ledger of each device.
    pub devices: Vec<PortLedger>,
    /// Ledger of each body.
    pub bodies: Vec<BodyPortLedger>,
}

impl EngineLedger {
    /// Returns the energy that held forces have generated since the start `[J]`: the sum gained by hands, contacts
    /// and the engine's bodies. Work of the engine's constraints and motors on a body is excluded. The value
    /// fluctuates with the samples; a steady rise indicates instability.
    #[must_use]
    pub fn created(&self) -> f64 {
        let contacts = self.contacts.iter();
        let contacts =
            contacts.map(|entry| entry.observed + entry.step_error - entry.work_on_proxy);
        let devices = self.devices.iter();
        let devices = devices.map(|entry| entry.port_work + entry.carried);
        contacts.sum::<f64>() + devices.sum::<f64>() + BodyPortLedger::created(&self.bodies)
    }
}

impl EngineState {
    /// Returns the estimated state of each tool at the last sample.
    #[must_use]
    pub fn tools(&self) -> &[ToolState] {
        &self.tools
    }

    /// Returns the position of each proxy at the end of the period, for display `[m]`.
    #[must_use]
    pub fn proxies(&self) -> Vec<Vector> {
        let tools = self.meeting.tools.iter();
        tools.map(|tool| tool.rigid.position.into()).collect()
    }

    /// Returns every point at which a tool may touch a body, also if it does not.
    #[must_use]
    pub fn contacts(&self) -> &[EngineContact] {
        &self.contacts
    }

    /// Returns the energy generated at the ports of the devices `[J]`: [`EngineLedger::created`], weighted for each
    /// contact by the fraction of its force that reached the device after limiting.
    #[must_use]
    pub fn created_at_ports(&self) -> f64 {
        self.at_ports.created()
    }

    /// Returns the energy ledger.
    #[must_use]
    pub fn ledger(&self) -> &EngineLedger {
        &self.ledger
    }

    /// Updates the ports with the energy generated at the devices, up to this sample, and at the bodies `[J]`.
    pub(super) fn close_ports(&mut self, pairs: &[Pair], with_bodies: f64) {
        let commands = &self.commands;
        let contacts = self.ledger.contacts.iter().zip(pairs).enumerate();
        let contacts = contacts.map(|(number, (entry, pair))| {
            let tool = pair.toucher.tool();
            let part = tool.map_or(1.0, |tool| commands.part_sent(tool));
            (number, entry.created() + entry.outside, part)
        });
        let devices = self.ledger.devices.iter();
        let ports = devices.map(|entry| entry.port_work + entry.carried).sum();
        let tools = 0..self.devices.len();
        let least = tools
            .map(|tool| commands.part_sent(tool))
            .fold(1.0, f64::min);
        self.at_ports.close(contacts, ports, (with_bodies, least));
    }

    /// Records the work of the tools on each body over the engine's step that ended in the states `bodies`, and
    /// begins the next step.
    pub(super) fn record_ports(&mut self, bodies: &[BodyNow]) {
        let pushed = self.pushed.iter_mut().zip(&mut self.ledger.bodies);
        for ((pushed, entry), body) in pushed.zip(bodies) {
            let twist = body.twist();
            if let Some(pushed) = pushed {
                // Kinetic energy gained by the body, which does not depend on the engine's position integrator.
                let work = pushed.impulse.dot(&(0.5 * (pushed.twist + twist)));
                if work.is_finite() && pushed.work.is_finite() {
                    entry.host_work += work;
                    entry.work += pushed.work;
                }
            }
            *pushed = Some(Pushed {
                twist,
                impulse: Vector6::zeros(),
                work: 0.0,
            });
        }
    }

    /// Adds `times` the work of the tools' contacts on each image since the period began.
    pub(super) fn add_work(&mut self, pairs: &[Pair], times: f64) {
        for (touch, pair) in self.meeting.touches.iter().zip(pairs) {
            let pushed = self.pushed.get_mut(pair.body).and_then(Option::as_mut);
            if let Some(pushed) = pushed.filter(|_| pair.toucher.tool().is_some()) {
                pushed.work += times * (touch.work - touch.work_on_proxy);
            }
        }
    }

    /// Evaluates the contacts and records the change in their stored energy.
    pub(super) fn look(&mut self, pairs: &[Pair], entry: fn(&mut ContactLedger) -> &mut f64) {
        self.meeting.look(pairs);
        self.record_stored(pairs, entry);
    }

    /// Records the change in the stored energy of each contact of a tool under the given ledger entry.
    pub(super) fn record_stored(
        &mut self,
        pairs: &[Pair],
        entry: fn(&mut ContactLedger) -> &mut f64,
    ) {
        let touches = self.meeting.touches.iter().zip(pairs);
        for (contact, (touch, pair)) in self.ledger.contacts.iter_mut().zip(touches) {
            if pair.toucher.tool().is_none() {
                continue;
            }
            let stored = touch.stored(&pair.law);
            *entry(contact) += stored - contact.stored;
            contact.stored = stored;
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
