//! A world with one device, as the loop renders it.

use palpate_device::Vector;
use palpate_record::recording::{BodyTick, ContactTick, Flags, Phase};
use palpate_world::{Mode, Motion, Sample, World, WorldRenderer, WorldState};

use super::frame::WorldFrame;
use super::renders::{Answer, Fresh, Renders};
use crate::setup::SetupError;

/// A world with one device in the loop: its renderer, its state, and where the device stands in it.
#[derive(Clone, Debug)]
pub struct RenderedWorld {
    renderer: WorldRenderer,
    state: WorldState,
    method: &'static str,
    frame: WorldFrame,
    /// Whether what was held is what acted: the renderer is told of no delay and no lag.
    acts_at_once: bool,
    is_limited: bool,
    /// What the books said of created energy at the last sample `[J]`.
    booked: f64,
    /// As much of it as was created while the motors were on `[J]`.
    created: f64,
    /// Whether the last sample was refused, or there was none: what a sample then changes is from outside.
    is_new: bool,
    /// Which of the world's bodies move.
    moving: Vec<usize>,
    bodies_of_world: usize,
    contacts: Vec<ContactTick>,
    bodies: Vec<BodyTick>,
}

impl RenderedWorld {
    /// `world`, which `renderer` renders by the method of that name, with a device that stands in it as `frame` says.
    ///
    /// # Errors
    /// The world has another number of tools than one: a loop has one device so far. A tool that turns: a loop gives no
    /// torque so far.
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
        if world.tools.iter().any(|tool| tool.turns) {
            return Err(SetupError::SixAxes);
        }
        let actuation = renderer.in_loop().actuation;
        let free = |place: &usize| {
            let body = world.bodies.get(*place);
            body.is_some_and(|body| matches!(body.motion, Motion::Free(_)))
        };
        let moving: Vec<usize> = (0..state.bodies().len()).filter(free).collect();
        Ok(Self {
            acts_at_once: actuation.delay == 0.0 && actuation.lag == 0.0,
            method,
            frame,
            is_limited: false,
            booked: 0.0,
            created: 0.0,
            is_new: true,
            bodies_of_world: state.bodies().len(),
            contacts: Vec::with_capacity(state.contacts().len()),
            bodies: Vec::with_capacity(moving.len() + tools),
            moving,
            state,
            renderer,
        })
    }

    /// Where the device stands in the world.
    #[must_use]
    pub fn frame(&self) -> &WorldFrame {
        &self.frame
    }

    /// The world at the last sample.
    #[must_use]
    pub fn state(&self) -> &WorldState {
        &self.state
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
            let held = self.frame.of_device(held);
            self.renderer.report_sent(&mut self.state, 0, held);
        }
        let positions = [self.frame.in_world(sample.position)];
        let output = self.renderer.step(
            &mut self.state,
            &Sample {
                elapsed: sample.elapsed,
                ..Sample::at(&positions)
            },
        );
        let force = output.forces.first().copied().unwrap_or_default();
        let fault = output.fault.map(|fault| fault.fault);
        self.is_limited = output.limited.force;
        let booked = self.state.books().created();
        let is_from_outside = sample.was_off || self.is_new || fault.is_some();
        if !is_from_outside {
            self.created += booked - self.booked;
        }
        self.booked = booked;
        self.is_new = fault.is_some();
        Answer {
            force: self.frame.on_device(force),
            coordinate: 0.0,
            fault,
        }
    }

    fn report_written(&mut self, held: Vector, sent: Option<Vector>) {
        let sent = if self.acts_at_once {
            held
        } else {
            sent.unwrap_or(held)
        };
        let sent = self.frame.of_device(sent);
        self.renderer.report_sent(&mut self.state, 0, sent);
    }

    fn account(&mut self, sequence: u64, _: Vector) {
        self.contacts.clear();
        let books = &self.state.books().contacts;
        for (pair, (contact, book)) in (0..).zip(self.state.contacts().iter().zip(books)) {
            if contact.mode == Mode::Free || self.contacts.len() == self.contacts.capacity() {
                continue;
            }
            self.contacts.push(ContactTick {
                sequence,
                pair,
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
        self.bodies.clear();
        for place in &self.moving {
            if let Some(body) = self.state.bodies().get(*place) {
                self.bodies.push(BodyTick {
                    sequence,
                    body: u32::try_from(*place).unwrap_or(u32::MAX),
                    position: body.position,
                    orientation: body.orientation,
                    velocity: body.velocity,
                    angular_velocity: body.angular_velocity,
                });
            }
        }
        for (number, tool) in self.state.tools().iter().enumerate() {
            self.bodies.push(BodyTick {
                sequence,
                body: u32::try_from(self.bodies_of_world + number).unwrap_or(u32::MAX),
                position: tool.avatar_position,
                orientation: [1.0, 0.0, 0.0, 0.0],
                velocity: tool.avatar_velocity,
                angular_velocity: [0.0; 3],
            });
        }
    }

    fn contacts(&self) -> &[ContactTick] {
        &self.contacts
    }

    fn bodies(&self) -> &[BodyTick] {
        &self.bodies
    }

    fn flags(&self) -> Flags {
        Flags::default()
            .with(Flags::CONTACT, !self.contacts.is_empty())
            .with(Flags::LIMITED_FORCE, self.is_limited)
    }

    fn created_energy(&self) -> f64 {
        self.created
    }
}
