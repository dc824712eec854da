//! State of a world as rows of a recording.

use palpate_record::recording::{BodyTick, ContactTick, Flags, Phase};
use palpate_world::{Mode, Motion, World, WorldState};

/// Recorded contacts and bodies of a world at a tick. All memory is allocated at construction, so a tick does not
/// allocate.
#[derive(Debug)]
pub struct WorldRows {
    /// Indices of the moving bodies of the world.
    moving: Vec<usize>,
    bodies_of_world: usize,
    contacts: Vec<ContactTick>,
    bodies: Vec<BodyTick>,
}

impl WorldRows {
    /// Allocates the rows of `world`, which is in a `state`.
    #[must_use]
    pub fn new(world: &World, state: &WorldState) -> Self {
        let free = |place: &usize| {
            let body = world.bodies.get(*place);
            body.is_some_and(|body| matches!(body.motion, Motion::Free(_)))
        };
        let moving: Vec<usize> = (0..state.bodies().len()).filter(free).collect();
        Self {
            bodies_of_world: state.bodies().len(),
            contacts: Vec::with_capacity(state.contacts().len()),
            bodies: Vec::with_capacity(moving.len() + state.tools().len()),
            moving,
        }
    }

    /// Stores the state at tick number `sequence`. It does not allocate.
    pub fn fill(&mut self, sequence: u64, state: &WorldState) {
        self.contacts.clear();
        let ledger = &state.ledger().contacts;
        for &number in state.near_contacts() {
            let (Some(contact), Some(entry)) = (state.contacts().get(number), ledger.get(number))
            else {
                continue;
            };
            if contact.mode == Mode::Free || self.contacts.len() == self.contacts.capacity() {
                continue;
            }
            self.contacts.push(ContactTick {
                sequence,
                pair: u32::try_from(number).unwrap_or(u32::MAX),
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
        self.bodies.clear();
        for place in &self.moving {
            if let Some(body) = state.bodies().get(*place) {
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
        for (number, tool) in state.tools().iter().enumerate() {
            self.bodies.push(BodyTick {
                sequence,
                body: u32::try_from(self.bodies_of_world + number).unwrap_or(u32::MAX),
                position: tool.proxy_position,
                orientation: tool.proxy_orientation,
                velocity: tool.proxy_velocity,
                angular_velocity: tool.angular_velocity,
            });
        }
    }

    /// Returns the touching contacts.
    #[must_use]
    pub fn contacts(&self) -> &[ContactTick] {
        &self.contacts
    }

    /// Returns the moving bodies and the proxy states of the tools.
    #[must_use]
    pub fn bodies(&self) -> &[BodyTick] {
        &self.bodies
    }
}

impl Clone for WorldRows {
    /// Keeps the capacity: a cloned `Vec` has capacity only for its items.
    fn clone(&self) -> Self {
        let mut contacts = Vec::with_capacity(self.contacts.capacity());
        contacts.extend_from_slice(&self.contacts);
        let mut bodies = Vec::with_capacity(self.bodies.capacity());
        bodies.extend_from_slice(&self.bodies);
        Self {
            moving: self.moving.clone(),
            bodies_of_world: self.bodies_of_world,
            contacts,
            bodies,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_world::{
        BasicParams, Body, Contact, ContactLaw, Party, Sample, Shape, Tool, WorldLoop,
        WorldRenderer,
    };

    #[test]
    fn clone_of_world_rows_keeps_capacity_for_contacts_and_bodies() {
        let floor = Shape::HalfSpace {
            normal: [0.0, 0.0, 1.0],
            offset: 0.0,
        };
        let world = World {
            tools: vec![Tool::new("tool", Shape::Sphere { radius: 0.0 })],
            bodies: vec![Body::new("floor", floor, Motion::Fixed)],
            contacts: vec![Contact {
                between: [Party::Any, Party::Any],
                law: ContactLaw::spring(1000.0),
            }],
            joints: Vec::new(),
            fields: Vec::new(),
        };
        let renderer =
            WorldRenderer::new(&world, WorldLoop::new(1e-3), BasicParams::default()).unwrap();
        let mut state = renderer.start();
        let mut rows = WorldRows::new(&world, &state).clone();
        for _ in 0..2 {
            let _ = renderer.step(&mut state, &Sample::at(&[[0.0, 0.0, -1e-3]]));
        }
        rows.fill(7, &state);
        let [contact] = rows.contacts() else {
            panic!("{:?}", rows.contacts());
        };
        assert_eq!((contact.sequence, contact.penetration), (7, 1e-3));
        // The proxy state of the tool.
        assert_eq!(rows.bodies().len(), 1);
    }
}
