//! Readable state of a world: tuples of numbers, which the Python files name.

use palpate_world::{
    BodyLedger, BodyState, ContactLedger, ContactState, DeviceLedger, Field, FieldLedger, Joint,
    JointKind, JointLedger, Mode, Quaternion, Side, ToolState, Vector,
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
/// Entries of the energy ledger: contacts with their sides; bodies; devices; joints with their sides and kind; fields
/// with their device.
type LedgerNow = (
    Vec<([String; 2], [f64; 9])>,
    Vec<[f64; 5]>,
    Vec<[f64; 7]>,
    Vec<([String; 2], &'static str, [f64; 5])>,
    Vec<(String, [f64; 7])>,
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
        [tool.orientation, tool.proxy_orientation],
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
        proxy_position,
        proxy_velocity,
        offset,
        velocity_offset,
        force,
        mass,
        ..
    } = *tool;
    let vectors = [
        position,
        velocity,
        proxy_position,
        proxy_velocity,
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
pub fn contact_ledger(entry: &ContactLedger) -> [f64; 9] {
    [
        entry.stored,
        entry.dissipated,
        entry.work,
        entry.work_on_proxy,
        entry.held,
        entry.observed,
        entry.outside,
        entry.step_error,
        entry.handed,
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
pub fn world_ledger(world: PyRef<'_, PyWorld>) -> LedgerNow {
    let ledger = world.state().ledger();
    let contacts = world.state().contacts().iter().zip(&ledger.contacts);
    let of_contact = |(contact, entry): (&ContactState, &ContactLedger)| {
        let entries = contact_ledger(entry);
        (contact.between.map(|side| world.side(side)), entries)
    };
    let of_body = |entry: &BodyLedger| {
        [
            entry.kinetic,
            entry.potential,
            entry.work,
            entry.outside,
            entry.step_error,
        ]
    };
    let of_device = |entry: &DeviceLedger| {
        [
            entry.port_work,
            entry.held,
            entry.unforeseen,
            entry.offset,
            entry.velocity_offset,
            entry.unpaid,
            entry.walked_back,
        ]
    };
    let of_joint = |(joint, entry): (&Joint, &JointLedger)| {
        let against = joint.against.clone().unwrap_or_else(|| "world".into());
        let kind = match joint.kind {
            JointKind::Hinge => "hinge",
            JointKind::Slider => "slider",
        };
        let entries = [
            entry.stored,
            entry.dissipated,
            entry.work,
            entry.outside,
            entry.step_error,
        ];
        ([joint.body.clone(), against], kind, entries)
    };
    let of_field = |(field, entry): (&Field, &FieldLedger)| {
        let entries = [
            entry.stored,
            entry.work,
            entry.held,
            entry.observed,
            entry.outside,
            entry.supplied,
            entry.step_error,
        ];
        (field.tool.clone(), entries)
    };
    let joints = world.scene().world.joints.iter().zip(&ledger.joints);
    let fields = world.scene().world.fields.iter().zip(&ledger.fields);
    (
        contacts.map(of_contact).collect(),
        ledger.bodies.iter().map(of_body).collect(),
        ledger.devices.iter().map(of_device).collect(),
        joints.map(of_joint).collect(),
        fields.map(of_field).collect(),
    )
}
