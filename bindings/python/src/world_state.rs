//! Readable state of a world: tuples of numbers, which the Python files name.

use palpate_world::{
    BodyBook, BodyState, ContactBook, ContactState, DeviceBook, Joint, JointBook, JointKind, Mode,
    Quaternion, Side, ToolState, Vector,
};
use pyo3::prelude::*;

use crate::world::PyWorld;

/// Position, orientation, velocity and angular velocity of a body.
type BodyNow = (Vector, [f64; 4], Vector, Vector);
/// Position, velocity, proxy position and proxy velocity, offset, velocity offset, force, and mass if it is known.
type ToolNow = ([Vector; 7], Option<Vector>);
/// Orientations of device and proxy, angular velocity, turn offset, momentum offset, torque, and inertia if it is
/// known.
type Turned = ([Quaternion; 2], [Vector; 4], Option<Vector>);
/// The two sides, mode, point, normal, penetration, force and bristle.
type ContactNow = (
    [String; 2],
    &'static str,
    Vector,
    Vector,
    f64,
    Vector,
    Vector,
);
/// Entries of the energy ledger: contacts with their sides; bodies; devices; joints with their sides and kind.
type BooksNow = (
    Vec<([String; 2], [f64; 8])>,
    Vec<[f64; 5]>,
    Vec<[f64; 7]>,
    Vec<([String; 2], &'static str, [f64; 4])>,
);

impl PyWorld {
    fn side(&self, side: Side) -> String {
        let world = &self.scene().world;
        match side {
            Side::Tool(number) => world.tools[number].name.clone(),
            Side::Body(number) => world.bodies[number].name.clone(),
        }
    }
}

/// Returns each body at the last sample.
#[pyfunction]
pub fn world_bodies(world: PyRef<'_, PyWorld>) -> Vec<BodyNow> {
    let bodies = world.state().bodies().iter();
    bodies
        .map(|body| {
            let BodyState {
                position,
                orientation,
                velocity,
                angular_velocity,
                ..
            } = *body;
            (position, orientation, velocity, angular_velocity)
        })
        .collect()
}

/// Returns each tool at the last sample, with its rotation if it rotates.
#[pyfunction]
pub fn world_tools(world: PyRef<'_, PyWorld>) -> Vec<(ToolNow, Option<Turned>)> {
    let states = world.state().tools().iter();
    let tools = states.zip(&world.scene().world.tools);
    tools
        .map(|(state, described)| (tool(state), described.turns.then(|| turned(state))))
        .collect()
}

/// Returns the rotation of a tool as numbers.
fn turned(tool: &ToolState) -> Turned {
    (
        [tool.orientation, tool.avatar_orientation],
        [
            tool.angular_velocity,
            tool.turn_offset,
            tool.momentum_offset,
            tool.torque,
        ],
        tool.inertia,
    )
}

/// Returns a tool as numbers.
pub fn tool(tool: &ToolState) -> ToolNow {
    let ToolState {
        position,
        velocity,
        avatar_position,
        avatar_velocity,
        offset,
        velocity_offset,
        force,
        mass,
        ..
    } = *tool;
    let vectors = [
        position,
        velocity,
        avatar_position,
        avatar_velocity,
        offset,
        velocity_offset,
        force,
    ];
    (vectors, mass)
}

/// Returns the name of a contact mode.
pub fn mode(mode: Mode) -> &'static str {
    match mode {
        Mode::Free => "free",
        Mode::Sticks => "sticks",
        Mode::Slides => "slides",
        Mode::Parts => "parts",
    }
}

/// Returns the ledger entries of a contact.
pub fn contact_book(book: &ContactBook) -> [f64; 8] {
    [
        book.stored,
        book.dissipated,
        book.work,
        book.work_on_avatar,
        book.held,
        book.observed,
        book.step_error,
        book.handed,
    ]
}

/// Returns each contact point at the last sample.
#[pyfunction]
pub fn world_contacts(world: PyRef<'_, PyWorld>) -> Vec<ContactNow> {
    let contacts = world.state().contacts().iter();
    contacts
        .map(|contact| {
            let ContactState {
                between,
                mode,
                point,
                normal,
                penetration,
                force,
                bristle,
                ..
            } = *contact;
            let mode = self::mode(mode);
            let between = between.map(|side| world.side(side));
            (between, mode, point, normal, penetration, force, bristle)
        })
        .collect()
}

/// Returns the energy ledger at the last sample.
#[pyfunction]
pub fn world_books(world: PyRef<'_, PyWorld>) -> BooksNow {
    let books = world.state().books();
    let contacts = world.state().contacts().iter().zip(&books.contacts);
    let of_contact = |(contact, book): (&ContactState, &ContactBook)| {
        let entries = contact_book(book);
        (contact.between.map(|side| world.side(side)), entries)
    };
    let of_body = |book: &BodyBook| {
        [
            book.kinetic,
            book.potential,
            book.work,
            book.outside,
            book.step_error,
        ]
    };
    let of_device = |book: &DeviceBook| {
        [
            book.port_work,
            book.held,
            book.unforeseen,
            book.offset,
            book.velocity_offset,
            book.unpaid,
            book.walked_back,
        ]
    };
    let of_joint = |(joint, book): (&Joint, &JointBook)| {
        let against = joint.against.clone().unwrap_or_else(|| "world".into());
        let kind = match joint.kind {
            JointKind::Hinge => "hinge",
            JointKind::Slider => "slider",
        };
        let entries = [book.stored, book.dissipated, book.work, book.step_error];
        ([joint.body.clone(), against], kind, entries)
    };
    let joints = world.scene().world.joints.iter().zip(&books.joints);
    (
        contacts.map(of_contact).collect(),
        books.bodies.iter().map(of_body).collect(),
        books.devices.iter().map(of_device).collect(),
        joints.map(of_joint).collect(),
    )
}
