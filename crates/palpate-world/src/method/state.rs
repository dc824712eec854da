//! State of a world between samples, and its readable part.

use crate::contact::broad_phase::List;
use crate::contact::law::Mode;
use crate::contact::pairs::Side;
use crate::device::commands::Commands;
use crate::device::guard::Account;
use crate::device::tracking::Tracking;
use crate::dynamics::ledger::{CreatedAtPorts, EnergyLedger};
use crate::dynamics::moving_body::Part;
use crate::geometry::rigid::{Rigid, Vector3, quaternion};
use crate::integration::moving::{Moving, Room};
use crate::method::Memory;
use crate::method::far_side::Entry;
use crate::method::lines::Slopes;
use crate::{IDENTITY, Quaternion, Vector};

/// State of a world at a sample, created by [`WorldRenderer::start`](crate::WorldRenderer::start) and advanced by
/// [`WorldRenderer::step`](crate::WorldRenderer::step).
#[derive(Clone, Debug)]
pub struct WorldState {
    pub(crate) progress: Progress,
    pub(crate) memory: Memory,
}

/// State shared by all methods.
#[derive(Clone, Debug)]
pub(crate) struct Progress {
    /// World at the last used sample, with evaluated contacts.
    pub now: Moving,
    /// Scratch buffer for the prediction.
    pub ahead: Moving,
    pub room: Room,
    pub tracking: Tracking,
    pub commands: Commands,
    /// Torques; empty if no tool turns.
    pub torque_commands: Commands,
    /// Force commanded by the method on each tool `[N]`.
    pub intended: Vec<Vector3>,
    /// Torque commanded by the method on each tool `[N m]`.
    pub intended_torques: Vec<Vector3>,
    /// Slopes of these forces.
    pub slopes: Slopes,
    pub forces: Vec<Vector>,
    pub torques: Vec<Vector>,
    pub tools: Vec<ToolState>,
    pub bodies: Vec<BodyState>,
    pub contacts: Vec<ContactState>,
    pub shown: Shown,
    pub ledger: EnergyLedger,
    pub at_ports: CreatedAtPorts,
    pub guard: Account,
}

/// Contacts that were active at the last sample. All others are apart.
#[derive(Clone, Debug)]
pub(crate) struct Shown {
    pub numbers: List,
    /// Side tracking of each contact.
    pub sides: Vec<Entry>,
}

impl Progress {
    /// Sends the commands of a sample to the actuators.
    pub fn send(&mut self) {
        let (forces, slopes) = (&self.forces, &self.slopes.sent);
        self.commands.send(&self.intended, forces, slopes);
        let (intended, torques) = (&self.intended_torques, &self.torques);
        self.torque_commands.send(intended, torques, &[]);
    }

    /// Updates the energy generated at the ports up to this sample.
    pub fn close_ports(&mut self) {
        let (commands, torque_commands) = (&self.commands, &self.torque_commands);
        let part = |side: &Side| match *side {
            Side::Tool(tool) => commands
                .part_sent(tool)
                .min(torque_commands.part_sent(tool)),
            Side::Body(_) => 1.0,
        };
        // No other entry has changed.
        let contacts = self.now.nearby.recent().iter().map(|&number| {
            let [first, second] = &self.contacts[number].between;
            let created = self.ledger.contacts[number].created();
            (number, created, part(first).min(part(second)))
        });
        let fields = self.now.fields.iter().zip(&self.ledger.fields).enumerate();
        let fields = fields.map(|(number, (field, entry))| {
            let number = self.contacts.len() + number;
            (number, entry.created(), part(&Side::Tool(field.tool)))
        });
        let otherwise = (self.ledger.created_otherwise(), 1.0);
        self.at_ports
            .close(contacts.chain(fields), self.ledger.at_ports(), otherwise);
    }
}

/// Copies the contacts of a world in motion.
pub(crate) fn show_contacts(contacts: &mut [ContactState], shown: &mut Shown, moving: &Moving) {
    let Shown { numbers, sides } = shown;
    for &number in numbers.all() {
        if !moving.nearby.is_recent(number) {
            contacts[number] = ContactState::apart(contacts[number].between);
            sides[number] = Entry::default();
        }
    }
    numbers.clear();
    for &number in moving.nearby.recent() {
        let (touch, contact) = (&moving.touches[number], &mut contacts[number]);
        contact.mode = touch.mode;
        contact.point = touch.place.into();
        contact.normal = touch.normal.into();
        contact.penetration = touch.penetration;
        contact.force = touch.force.into();
        contact.bristle = touch.bristle.into();
        numbers.push(number);
    }
}

impl WorldState {
    /// Returns each tool at the last sample, in the world's order.
    #[must_use]
    pub fn tools(&self) -> &[ToolState] {
        &self.progress.tools
    }

    /// Returns each body at the last sample, including fixed ones, in the world's order.
    #[must_use]
    pub fn bodies(&self) -> &[BodyState] {
        &self.progress.bodies
    }

    /// Returns each possible contact point of tools and bodies at the last sample, also if it does not touch.
    #[must_use]
    pub fn contacts(&self) -> &[ContactState] {
        &self.progress.contacts
    }

    /// Returns the indices of the contact points that were near enough to touch at the last sample, in ascending order.
    /// All others are apart.
    #[must_use]
    pub fn near_contacts(&self) -> &[usize] {
        self.progress.shown.numbers.all()
    }

    /// Returns the spheres that are inside a mesh as of the last sample, each with that mesh. Such a sphere was
    /// inside when first seen, and nothing pushes it until it has come out.
    pub fn inside_meshes(&self) -> impl Iterator<Item = [Side; 2]> {
        let Moving {
            surfaces, tools, ..
        } = &self.progress.now;
        let side = |number: usize| Side::new(number, *tools);
        let inside = surfaces.iter().filter(|surface| surface.is_inside());
        inside.map(move |surface| surface.parts().map(side))
    }

    /// Returns the contacts whose first side has passed through its second side. Inside a sphere, box, capsule,
    /// cylinder or hull it reached an opposite side at the last sample, and is now pushed out there.
    pub fn gone_through(&self) -> impl Iterator<Item = [Side; 2]> {
        let Progress {
            contacts, shown, ..
        } = &self.progress;
        let through = shown.numbers.all().iter();
        let through = through.filter(|&&number| shown.sides[number].is_through);
        through.map(|&number| contacts[number].between)
    }

    /// Returns the energy generated at the ports of the devices `[J]`: [`EnergyLedger::created`], weighted for each
    /// contact by the fraction of its force that reached the device after limiting. A hand that presses against a
    /// limited force therefore generates no energy, and neither does a body pushed by a larger force than the hand
    /// feels.
    #[must_use]
    pub fn created_at_ports(&self) -> f64 {
        self.progress.at_ports.created()
    }

    /// Returns the energy ledger as of the last sample.
    #[must_use]
    pub fn ledger(&self) -> &EnergyLedger {
        &self.progress.ledger
    }
}

/// A tool at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolState {
    /// Position of its device as estimated by the method `[m]`.
    pub position: Vector,
    /// Velocity of its device `[m/s]`.
    pub velocity: Vector,
    /// Position of the proxy, with which the world collides instead of the device `[m]`.
    pub proxy_position: Vector,
    /// Velocity of the proxy `[m/s]`.
    pub proxy_velocity: Vector,
    /// Position of the proxy minus that of the device `[m]`.
    pub offset: Vector,
    /// Velocity of the proxy minus that of the device `[m/s]`.
    pub velocity_offset: Vector,
    /// Force sent for this sample, which the device exerts on the hand `[N]`.
    pub force: Vector,
    /// Estimated mass of device and hand along each axis, if the method estimates it `[kg]`.
    pub mass: Option<Vector>,
    /// Orientation of its device as estimated by the method; the identity for a tool that does not turn.
    pub orientation: Quaternion,
    /// Angular velocity of its device along the world's axes `[rad/s]`.
    pub angular_velocity: Vector,
    /// Orientation of the proxy.
    pub proxy_orientation: Quaternion,
    /// Rotation vector along the world's axes from the device to the proxy `[rad]`.
    pub turn_offset: Vector,
    /// Angular momentum of the proxy minus that of the device `[N m s]`.
    pub momentum_offset: Vector,
    /// Torque sent for this sample, about the mass centre, along the world's axes `[N m]`.
    pub torque: Vector,
    /// Estimated moments of inertia of device and hand along the tool's axes, if the method estimates them `[kg
    /// m^2]`.
    pub inertia: Option<Vector>,
}

impl Default for ToolState {
    fn default() -> Self {
        let none = [0.0; 3];
        Self {
            position: none,
            velocity: none,
            proxy_position: none,
            proxy_velocity: none,
            offset: none,
            velocity_offset: none,
            force: none,
            mass: None,
            orientation: IDENTITY,
            angular_velocity: none,
            proxy_orientation: IDENTITY,
            turn_offset: none,
            momentum_offset: none,
            torque: none,
            inertia: None,
        }
    }
}

/// Returns the current state of a part of a world.
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
    /// Orientation of the body.
    pub orientation: Quaternion,
    /// Velocity of the centre of mass `[m/s]`.
    pub velocity: Vector,
    /// Angular velocity along the world's axes `[rad/s]`.
    pub angular_velocity: Vector,
}

/// A point of contact at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactState {
    /// The two sides; `force` acts on the first.
    pub between: [Side; 2],
    /// Contact mode.
    pub mode: Mode,
    /// Point of application of the force `[m]`.
    pub point: Vector,
    /// Unit vector from the second to the first.
    pub normal: Vector,
    /// Overlap, 0 if apart `[m]`.
    pub penetration: f64,
    /// Contact force on the first side `[N]`.
    pub force: Vector,
    /// Deflection of the bristle `[m]`.
    pub bristle: Vector,
}

impl ContactState {
    pub(crate) fn apart(between: [Side; 2]) -> Self {
        Self {
            between,
            mode: Mode::Free,
            point: [0.0; 3],
            normal: [1.0, 0.0, 0.0],
            penetration: 0.0,
            force: [0.0; 3],
            bristle: [0.0; 3],
        }
    }
}
