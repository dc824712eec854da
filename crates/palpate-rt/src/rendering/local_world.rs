//! The local model of a slow host in the loop, and the host's end of it.

use palpate::Actuation;
use palpate_device::clock::Clock;
use palpate_device::{Device, Vector, Wrench};
use palpate_record::recording::{ContactTick, Flags, Phase};
use palpate_world::engine::BodyNow;
use palpate_world::engine::local::{
    LocalContact, LocalModel, LocalProgress, LocalRenderer, LocalState,
};
use palpate_world::{Limited, Mode, Sample, WorldError};

use super::frame::WorldFrame;
use super::renders::{Answer, Fresh, Renders};
use crate::control_loop::ControlLoop;
use crate::created_energy::CreatedEnergy;
use crate::safety::SafetyParams;
use crate::setup::SetupError;

/// The host's end, for any thread: models go in and the loop's progress comes out without either side ever waiting. Of
/// several models between two ticks the last counts.
#[derive(Debug)]
pub struct SlowHost {
    renderer: LocalRenderer,
    out: triple_buffer::Input<Option<LocalModel>>,
    progress: triple_buffer::Output<LocalProgress>,
}

/// What a slow host publishes, as the loop renders it: its renderer, its state, and where the device stands in the host's world.
#[derive(Debug)]
pub struct LocalWorld {
    renderer: LocalRenderer,
    state: LocalState,
    frame: WorldFrame,
    host: FromHost,
    /// Whether what was held is what acted: the renderer is told of no delay and no lag.
    acts_at_once: bool,
    limited: Limited,
    created: CreatedEnergy,
    contacts: Vec<ContactTick>,
}

/// The loop's side of what passes between the two, without either side ever waiting.
#[derive(Debug)]
pub(crate) struct FromHost {
    coming: triple_buffer::Output<Option<LocalModel>>,
    back: triple_buffer::Input<LocalProgress>,
}

impl FromHost {
    /// The newest model, if one has come since the last call.
    pub fn newest(&mut self) -> Option<&LocalModel> {
        if self.coming.update() {
            self.coming.output_buffer().as_ref()
        } else {
            None
        }
    }

    /// Tells the host how far the loop has come. It does not allocate.
    pub fn tell(&mut self, progress: &LocalProgress) {
        self.back.input_buffer_mut().copy_from(progress);
        self.back.publish();
    }
}

/// Both sides of what passes between a host and the `renderer` of a loop.
pub(crate) fn sides(renderer: &LocalRenderer) -> (SlowHost, FromHost) {
    let (out, coming) = triple_buffer::triple_buffer(&None);
    let (back, progress) = triple_buffer::triple_buffer(renderer.start().progress());
    let host = SlowHost {
        renderer: renderer.clone(),
        out,
        progress,
    };
    (host, FromHost { coming, back })
}

/// Both ends of a local model of one tool, with a device that stands in the host's world as `frame` says.
///
/// The host's thread repeats: take the newest [`progress`](SlowHost::progress), step over the time since the last one under
/// [`LocalProgress::wrench_since`], look for contacts at the avatars, and [`publish`](SlowHost::publish).
/// `examples/slow_host.rs` of this crate does so.
///
/// # Errors
/// Another number of tools than one: a local model in a loop in real time has one device so far.
pub fn local_world(
    renderer: LocalRenderer,
    frame: WorldFrame,
) -> Result<(SlowHost, LocalWorld), SetupError> {
    let state = renderer.start();
    let tools = state.tools().len();
    if tools != 1 {
        return Err(SetupError::Devices {
            world: tools,
            given: 1,
        });
    }
    let (host, from_host) = sides(&renderer);
    let actuation = renderer.in_loop().actuation;
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

impl SlowHost {
    /// How far the loop has come, as of its last tick.
    pub fn progress(&mut self) -> &LocalProgress {
        self.progress.read()
    }

    /// Publishes bodies and contacts as of the `tick` of a progress: see [`LocalRenderer::model`]. The loop renders by them from
    /// its next tick on. What it refuses, the next progress says.
    ///
    /// # Errors
    /// Everything that is wrong with bodies and contacts, by number; the model before stays then.
    pub fn publish(
        &mut self,
        tick: u64,
        bodies: &[BodyNow],
        contacts: &[Option<LocalContact>],
    ) -> Result<(), Vec<WorldError>> {
        let model = self.renderer.model(tick, bodies, contacts)?;
        // What was in this place before is freed here, and never by the loop.
        self.out.write(Some(model));
        Ok(())
    }
}

impl LocalWorld {
    /// The local model at the last sample.
    #[must_use]
    pub fn state(&self) -> &LocalState {
        &self.state
    }

    /// Tells the renderer what was sent, or held, in the axes of the device.
    fn report(&mut self, wrench: Wrench) {
        let force = self.frame.of_device(wrench.force);
        self.renderer.report_sent(&mut self.state, 0, force);
    }
}

impl Renders for LocalWorld {
    fn period(&self) -> f64 {
        self.renderer.in_loop().period
    }

    fn method(&self) -> &'static str {
        "coupled"
    }

    fn step(&mut self, sample: &Fresh<'_>, asked: &mut [Wrench]) -> Answer {
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
        let booked = self.state.created_at_ports();
        self.created.close(booked, fault.is_some(), sample.was_off);
        if let Some(asked) = asked.first_mut() {
            *asked = Wrench {
                force: self.frame.on_device(force),
                torque: [0.0; 3],
            };
        }
        Answer {
            coordinate: 0.0,
            fault,
        }
    }

    fn report_written(&mut self, _: usize, held: Wrench, sent: Option<Wrench>) {
        let sent = if self.acts_at_once {
            held
        } else {
            sent.unwrap_or(held)
        };
        self.report(sent);
    }

    fn account(&mut self, sequence: u64, _: Vector) {
        self.contacts.clear();
        let books = self.state.books().contacts;
        for (slot, contact) in self.state.contacts() {
            let Some(book) = books.get(slot).filter(|_| contact.mode != Mode::Free) else {
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
                stored_energy: book.stored,
                held_leak: book.leak(),
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
        self.renderer.in_loop().actuation
    }

    fn created_energy(&self) -> f64 {
        self.created.counted()
    }
}

impl<D: Device, C: Clock> ControlLoop<D, C, LocalWorld> {
    /// A loop that renders what a slow host publishes, on `device`. It ticks from the first call of [`tick`](Self::tick) on. A
    /// row has the contacts under the numbers that the host gives them, and no bodies.
    ///
    /// # Errors
    /// A limit of the safety outside its range; a period below a nanosecond or above 10 s.
    pub fn of_local_world(
        device: D,
        clock: C,
        world: LocalWorld,
        limits: SafetyParams,
    ) -> Result<Self, SetupError> {
        Self::rendering(vec![(device, limits)], clock, world)
    }
}
