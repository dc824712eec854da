#![doc = include_str!("../README.md")]
//!
//! # Frames and signs
//!
//! All quantities are in the world frame and in SI units. A half-space is solid on the side opposite to its normal. A
//! contact pushes two bodies apart; the force on a tool is the force that its device exerts on the hand.

mod axes;
mod body;
mod change;
mod commands;
mod contact;
mod contact_point;
mod convex;
mod convex_pairs;
mod coplanar;
pub mod engine;
mod far_side;
mod fault;
mod guard;
mod hull;
mod inertia;
mod interval;
mod interval_ledger;
mod joint;
mod joint_springs;
mod law;
mod ledger;
mod linkage;
mod mass_table;
mod mesh;
mod method;
mod moving;
mod moving_body;
mod nearby;
mod observer;
mod pairs;
mod params;
mod renderer;
mod rigid;
mod sample;
mod shape;
mod solid;
mod state;
mod tracking;
mod turning;
mod turning_observer;
mod world;
mod world_field;

pub use body::{Body, Free, Motion, Tool};
pub use change::Succession;
pub use contact::{Contact, ContactLaw, Party};
pub use fault::{LARGEST, LEAST, WorldError, WorldPart, out_of_range};
pub use guard::{MAX_LATE, WorldGuard, WorldGuardParams};
pub use hull::{Hull, HullError};
pub use interval::{Effort, SubSteps};
pub use joint::{Joint, JointKind, JointLaw};
pub use law::Mode;
pub use ledger::{BodyLedger, ContactLedger, Departed, DeviceLedger, EnergyLedger, JointLedger};
pub use mass_table::{MassTable, MassTableError};
pub use mesh::{
    DistanceGrid, GridBytesError, GridError, InvalidGrid, InvalidShell, MassProperties, Mesh,
    MeshError, PointShell,
};
pub use method::{BasicParams, CoupledParams, GodObjectParams, VirtualCouplingParams, WorldMethod};
pub use observer::Prior;
pub use pairs::{MAX_POINTS, MAX_SHELL_POINTS, Side};
pub use params::WorldLoop;
pub use renderer::WorldRenderer;
pub use sample::{Limited, Output, Sample, WorldFault};
pub use shape::{Shape, SphereAt};
pub use state::{BodyState, ContactState, ToolState, WorldState};
pub use world::World;
pub use world_field::WorldField;

/// A vector along the axes of the world frame, for example a position `[m]` or a force `[N]`.
pub type Vector = [f64; 3];
/// A unit quaternion `[w, x, y, z]` `[1]` that rotates a body's own axes to the world's axes.
pub type Quaternion = [f64; 4];

/// The identity quaternion.
pub const IDENTITY: Quaternion = [1.0, 0.0, 0.0, 0.0];
