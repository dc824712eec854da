//! Local model of a low-rate simulator in the loop, and the simulator's end.

use palpate_core::Actuation;
use palpate_device::clock::Clock;
use palpate_device::{Device, Line, Vector, Wrench};
use palpate_record::recording::{ContactTick, Flags, Phase};
use palpate_world::engine::BodyNow;
use palpate_world::engine::local::{
    LocalContact, LocalModel, LocalProgress, LocalRenderer, LocalState,
};
use palpate_world::{Limited, Mode, Sample, WorldErrors};

use super::frame::WorldFrame;
use super::renders::{Answer, DeviceSamples, Renders};
use crate::control_loop::ControlLoop;
use crate::created_energy::CreatedEnergy;
use crate::safety::SafetyParams;
use crate::setup::SetupError;

/// The simulator's end, for any thread. It sends models and receives the loop's progress without blocking either
/// side. Of several models between two ticks only the latest takes effect.
#[derive(Debug)]
pub struct LowRateSimulator {
    renderer: LocalRenderer,
    out: triple_buffer::Input<Option<LocalModel>>,
    progress: triple_buffer::Output<LocalProgress>,
}

/// Local model in the loop: renderer, state, and frame of the device in the simulator's world.
#[derive(Debug)]
pub struct LocalWorld {
    renderer: LocalRenderer,
    state: LocalState,
    frame: WorldFrame,
    host: FromHost,
    /// Whether the held force acts without delay: the model of the actuator has neither delay nor lag.
    acts_at_once: bool,
    limited: Limited,
    created: CreatedEnergy,
    contacts: Vec<ContactTick>,
}

/// The loop's end of the exchange with a simulator, which never blocks.
#[derive(Debug)]
pub(crate) struct FromHost {
    coming: triple_buffer::Output<Option<LocalModel>>,
    back: triple_buffer::Input<LocalProgress>,
}

impl FromHost {
    /// Returns the newest model, if one has arrived since the last call.
    pub fn newest(&mut self) -> Option<&LocalModel> {
        if self.coming.update() {
            self.coming.output_buffer().as_ref()
        } else {
            None
        }
    }

    /// Publishes the loop's progress. It does not allocate.
    pub fn tell(&mut self, progress: &LocalProgress) {
        self.back.input_buffer_mut().copy_from(progress);
        self.back.publish();
    }
}

/// Creates both ends of the exchange between a simulator and the `renderer` of a loop.
pub(crate) fn sides(renderer: &LocalRenderer) -> (LowRateSimulator, FromHost) {
    let (out, coming) = triple_buffer::triple_buffer(&None);
    let (back, progress) = triple_buffer::triple_buffer(renderer.start().progress());
    let host = LowRateSimulator {
        renderer: renderer.clone(),
        out,
        progress,
    };
    (host, FromHost { coming, back })
}

/// Creates both ends of a local model of one tool, with a device in the simulator's world at `frame`.
///
/// The simulator's thread repeats these steps: read the newest [`progress`](LowRateSimulator::progress), advance by the
/// elapsed time under [`LocalProgress::wrench_since`], find contacts at the proxy states, and
/// [`publish`](LowRateSimulator::publish) them. `examples/low_rate_simulator.rs` of this crate is an example.
///
/// # Errors
/// A number of tools other than one: a local model in a real-time loop supports one device so far.
pub fn local_world(
    renderer: LocalRenderer,
    frame: WorldFrame,
) -> Result<(LowRateSimulator, LocalWorld), SetupError> {
    let state = renderer.start();
    let tools = state.tools().len();
    if tools != 1 {
        return Err(SetupError::Devices {
            world: tools,
            given: 1,
        });
    }
    let (host, from_host) = sides(&renderer);
    let actuation = renderer.loop_params().actuation;
    let world = LocalWorld {
        acts_at_once: actuation.delay == 0.0 && actuation.lag == 0.0,
        limited: Limited::default(),
        created: CreatedEnergy::default(),
        contacts: Vec::with_capacity(renderer.params().contacts),
        renderer,
        state,
        frame,
        host: from_host,
    };
    Ok((host, world))
}

impl LowRateSimulator {
    /// Returns the progress of the loop up to its last tick.
    pub fn progress(&mut self) -> &LocalProgress {
        self.progress.read()
    }

    /// Publishes bodies and contacts for the `tick` of a progress: see [`LocalRenderer::model`]. The loop renders
    /// them from its next tick on. The next progress reports a model that the loop rejects.
    ///
    /// # Errors
    /// All errors of bodies and contacts, by index; the previous model then stays in use.
    pub fn publish(
        &mut self,
        tick: u64,
        bodies: &[BodyNow],
        contacts: &[Option<LocalContact>],
    ) -> Result<(), WorldErrors> {
        let model = self.renderer.model(tick, bodies, contacts)?;
        // This frees the previous content of the buffer here, never in the loop.
        self.out.write(Some(model));
        Ok(())
    }
}

impl LocalWorld {
    /// Returns the local model at the last sample.
    #[must_use]
    pub fn state(&self) -> &LocalState {
        &self.state
    }

    /// Reports the sent or held wrench, in the axes of the device, to the renderer.
    fn report(&mut self, wrench: Wrench) {
        let force = self.frame.of_device(wrench.force);
        self.renderer.report_sent(&mut self.state, 0, force);
    }
}

impl Renders for LocalWorld {
    fn period(&self) -> f64 {
        self.renderer.loop_params().period
    }

    fn method(&self) -> &'static str {
        "coupled"
    }

    fn step(&mut self, sample: &DeviceSamples<'_>, asked: &mut [Line]) -> Answer {
        let device = sample.devices.first().copied().unwrap_or_default();
        if let Some(held) = device.held
            && self.acts_at_once
        {
            self.report(held);
        }
        let model = self.host.newest();
        let positions = [self.frame.in_world(device.position)];
        let fresh = Sample {
            elapsed: sample.elapsed,
            ..Sample::at(&positions)
        };
        let output = self.renderer.step(&mut self.state, &fresh, model);
        let force = output.forces.first().copied().unwrap_or_default();
        let fault = output.fault.map(|fault| fault.fault);
        self.limited = output.limited;
        self.host.tell(self.state.progress());
        let recorded = self.state.created_at_ports();
        self.created
            .close(recorded, fault.is_some(), sample.was_off);
        if let Some(asked) = asked.first_mut() {
            *asked = Wrench::of_force(self.frame.on_device(force)).into();
        }
        Answer {
            coordinate: 0.0,
            fault,
            is_crowded: false,
        }
    }

    fn report_written(&mut self, _: usize, held: Line, sent: Option<Line>) {
        let sent = if self.acts_at_once {
            held
        } else {
            sent.unwrap_or(held)
        };
        self.report(sent.wrench);
    }

    fn account(&mut self, sequence: u64, _: Vector) {
        self.contacts.clear();
        let ledger = self.state.ledger().contacts;
        for (slot, contact) in self.state.contacts() {
            let Some(entry) = ledger.get(slot).filter(|_| contact.mode != Mode::Free) else {
                continue;
            };
            if self.contacts.len() == self.contacts.capacity() {
                break;
            }
            self.contacts.push(ContactTick {
                sequence,
                pair: u32::try_from(slot).unwrap_or(u32::MAX),
                flags: Flags::CONTACT,
                penetration: contact.penetration,
                stored_energy: entry.stored,
                held_leak: entry.leak(),
                point: contact.point,
                normal: contact.normal,
                force: contact.force,
                phase: Phase::Contact,
                ..ContactTick::UNKNOWN
            });
        }
    }

    fn contacts(&self) -> &[ContactTick] {
        &self.contacts
    }

    fn flags(&self) -> Flags {
        Flags::default()
            .with(Flags::CONTACT, !self.contacts.is_empty())
            .with(Flags::LIMITED_FORCE, self.limited.force)
    }

    fn actuation(&self) -> Actuation<f64> {
        self.renderer.loop_params().actuation
    }

    fn created_energy(&self) -> f64 {
        self.created.counted()
    }
}

impl<D: Device, C: Clock> ControlLoop<D, C, LocalWorld> {
    /// Creates a loop that renders the models of a low-rate simulator on `device`. It starts at the first call of
    /// [`tick`](Self::tick). A row contains the contacts with the simulator's numbers, and no bodies.
    ///
    /// # Errors
    /// A safety limit outside its range; a period below a nanosecond or above 10 s.
    pub fn of_local_world(
        device: D,
        clock: C,
        world: LocalWorld,
        limits: SafetyParams,
    ) -> Result<Self, SetupError> {
        Self::rendering(vec![(device, limits)], clock, world)
    }
}
