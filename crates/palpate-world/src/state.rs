//! What a world remembers from sample to sample, and what can be read from it.

use crate::books::{Books, ContactBook, CreatedAtPorts};
use crate::commands::Commands;
use crate::far_side::Entry;
use crate::guard::Account;
use crate::law::Mode;
use crate::method::Memory;
use crate::moving::Moving;
use crate::pairs::Side;
use crate::part::Part;
use crate::rigid::{Rigid, Rotation, Vector3};
use crate::tracking::Tracking;
use crate::{NOT_TURNED, Quaternion, Vector};

/// A world at a sample: made by [`WorldRenderer::start`](crate::WorldRenderer::start), changed by
/// [`WorldRenderer::step`](crate::WorldRenderer::step).
#[derive(Clone, Debug)]
pub struct WorldState {
    pub(crate) progress: Progress,
    pub(crate) memory: Memory,
}

/// What every method works on.
#[derive(Clone, Debug)]
pub(crate) struct Progress {
    /// The world at the last sample that was used, its contacts looked at.
    pub now: Moving,
    /// Room for what is predicted,
    pub ahead: Moving,
    /// and for what a sub-step begins with.
    pub room: Moving,
    pub tracking: Tracking,
    pub commands: Commands,
    /// Of torques; of no tool if none turns.
    pub torque_commands: Commands,
    /// Force that the method asks for on each tool `[N]`,
    pub intended: Vec<Vector3>,
    /// and torque `[N m]`.
    pub intended_torques: Vec<Vector3>,
    pub forces: Vec<Vector>,
    pub torques: Vec<Vector>,
    pub tools: Vec<ToolState>,
    pub bodies: Vec<BodyState>,
    pub contacts: Vec<ContactState>,
    /// Of each contact, whether it has changed its side.
    pub sides: Vec<Entry>,
    pub books: Books,
    pub at_ports: CreatedAtPorts,
    pub guard: Account,
}

impl Progress {
    /// Takes account of the energy created at the ports, up to this sample.
    pub fn close_ports(&mut self) {
        let (commands, torque_commands) = (&self.commands, &self.torque_commands);
        let part = |side: &Side| match *side {
            Side::Tool(tool) => commands
                .part_sent(tool)
                .min(torque_commands.part_sent(tool)),
            Side::Body(_) => 1.0,
        };
        let contacts = self.books.contacts.iter().zip(&self.contacts);
        let contacts = contacts.map(|(book, contact)| {
            let [first, second] = &contact.between;
            (ContactBook::created(book), part(first).min(part(second)))
        });
        let otherwise = (self.books.created_otherwise(), 1.0);
        self.at_ports
            .close(contacts, self.books.at_ports(), otherwise);
    }
}

/// Writes the contacts of a world in motion.
pub(crate) fn show_contacts(contacts: &mut [ContactState], moving: &Moving) {
    for (touch, contact) in moving.touches.iter().zip(contacts) {
        contact.mode = touch.mode;
        contact.point = touch.place.into();
        contact.normal = touch.normal.into();
        contact.penetration = touch.penetration;
        contact.force = touch.force.into();
        contact.bristle = touch.bristle.into();
    }
}

impl WorldState {
    /// Each tool at the last sample, in the world's order.
    #[must_use]
    pub fn tools(&self) -> &[ToolState] {
        &self.progress.tools
    }

    /// Each body at the last sample, fixed ones too, in the world's order.
    #[must_use]
    pub fn bodies(&self) -> &[BodyState] {
        &self.progress.bodies
    }

    /// Each point at which tools and bodies can touch, at the last sample, whether they do or not.
    #[must_use]
    pub fn contacts(&self) -> &[ContactState] {
        &self.progress.contacts
    }

    /// The spheres that are inside a mesh, as of the last sample, each with that mesh: nothing pushes such a sphere until it has
    /// come out. It was there when it was first seen.
    pub fn inside_meshes(&self) -> impl Iterator<Item = [Side; 2]> {
        let Moving {
            surfaces, tools, ..
        } = &self.progress.now;
        let side = |number: usize| Side::of(number, *tools);
        let inside = surfaces.iter().filter(|surface| surface.is_inside());
        inside.map(move |surface| surface.parts().map(side))
    }

    /// The contacts whose first went through its second: inside a sphere, box, capsule, cylinder or hull, it has come to an opposite
    /// side at the last sample, so that it is pushed out there and no longer back.
    pub fn gone_through(&self) -> impl Iterator<Item = [Side; 2]> {
        let contacts = self.progress.contacts.iter().zip(&self.progress.sides);
        let through = contacts.filter(|(_, side)| side.is_through);
        through.map(|(contact, _)| contact.between)
    }

    /// Energy that forces created at the ports of the devices `[J]`: [`Books::created`], where a contact whose force reached its
    /// device by a part, because a limit cut it, counts by that part. A hand that presses on against a limited force creates
    /// nothing, nor does a body that is pushed by more than reaches the hand.
    #[must_use]
    pub fn created_at_ports(&self) -> f64 {
        self.progress.at_ports.created()
    }

    /// The books of energy, as of the last sample.
    #[must_use]
    pub fn books(&self) -> &Books {
        &self.progress.books
    }
}

/// A tool at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolState {
    /// Where its device is, by what the method knows `[m]`.
    pub position: Vector,
    /// Its device's velocity `[m/s]`.
    pub velocity: Vector,
    /// What the world meets in the device's place: position `[m]`,
    pub avatar_position: Vector,
    /// and velocity `[m/s]`.
    pub avatar_velocity: Vector,
    /// Position of the avatar less that of the device `[m]`.
    pub offset: Vector,
    /// Velocity of the avatar less that of the device `[m/s]`.
    pub velocity_offset: Vector,
    /// Force that is sent for this sample `[N]`: what the device is to give to the hand.
    pub force: Vector,
    /// Mass of the device with the hand, as far as the method has learned it, along each axis `[kg]`.
    pub mass: Option<Vector>,
    /// How its device is turned, by what the method knows; not turned where the tool does not turn.
    pub orientation: Quaternion,
    /// Its device's angular velocity along the world's axes `[rad/s]`.
    pub angular_velocity: Vector,
    /// How the avatar is turned.
    pub avatar_orientation: Quaternion,
    /// Rotation vector along the world's axes that turns the device into the avatar `[rad]`.
    pub turn_offset: Vector,
    /// Angular momentum of the avatar less that of the device `[N m s]`.
    pub momentum_offset: Vector,
    /// Torque that is sent for this sample, about the mass centre, along the world's axes `[N m]`.
    pub torque: Vector,
    /// Moments of inertia of the device with the hand along the tool's axes, as far as the method has learned them
    /// `[kg m^2]`.
    pub inertia: Option<Vector>,
}

impl Default for ToolState {
    fn default() -> Self {
        let none = [0.0; 3];
        Self {
            position: none,
            velocity: none,
            avatar_position: none,
            avatar_velocity: none,
            offset: none,
            velocity_offset: none,
            force: none,
            mass: None,
            orientation: NOT_TURNED,
            angular_velocity: none,
            avatar_orientation: NOT_TURNED,
            turn_offset: none,
            momentum_offset: none,
            torque: none,
            inertia: None,
        }
    }
}

/// A rotation as a quaternion `[w, x, y, z]`.
pub(crate) fn quaternion(rotation: &Rotation) -> Quaternion {
    let q = rotation.quaternion();
    [q.w, q.i, q.j, q.k]
}

/// A part of a world as it is.
pub(crate) fn body_state(part: &Part) -> BodyState {
    let Rigid {
        position,
        orientation,
        velocity,
        spin,
    } = &part.rigid;
    BodyState {
        position: (*position).into(),
        orientation: quaternion(orientation),
        velocity: (*velocity).into(),
        angular_velocity: part.mobility.turning(orientation, spin).into(),
    }
}

/// A body at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyState {
    /// Position of the centre of mass `[m]`.
    pub position: Vector,
    /// How the body is turned.
    pub orientation: Quaternion,
    /// Velocity of the centre of mass `[m/s]`.
    pub velocity: Vector,
    /// Angular velocity along the world's axes `[rad/s]`.
    pub angular_velocity: Vector,
}

/// A point of contact at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactState {
    /// The two sides: the force is that on the first.
    pub between: [Side; 2],
    /// Whether they touch, and how.
    pub mode: Mode,
    /// Where the force acts `[m]`.
    pub point: Vector,
    /// Unit vector from the second to the first.
    pub normal: Vector,
    /// How far they overlap, 0 where they do not `[m]`.
    pub penetration: f64,
    /// Force of the contact on the first `[N]`.
    pub force: Vector,
    /// Deflection of the bristle `[m]`.
    pub bristle: Vector,
}
