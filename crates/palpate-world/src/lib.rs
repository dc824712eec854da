#![doc = include_str!("../README.md")]
//!
//! # Frames and signs
//!
//! All quantities are in the world frame and in SI units. A half-space is solid on the side opposite to its normal. A
//! contact pushes two bodies apart; the force on a tool is the force that its device exerts on the hand.

mod contact;
mod description;
mod device;
mod dynamics;
pub mod engine;
mod error;
mod geometry;
mod integration;
mod method;

pub use contact::law::Mode;
pub use contact::pairs::{MAX_POSSIBLE_POINTS, MAX_SHELL_POINTS, Side};
pub use description::body::{Body, Free, Motion, Tool};
pub use description::contact::{Contact, ContactLaw, Party};
pub use description::field::{Field, FieldKind};
pub use description::joint::{Joint, JointKind, JointLaw};
pub use description::mass_table::{MassTable, MassTableError};
pub use description::world::World;
pub use device::guard::{MAX_LATE, WorldGuard, WorldGuardParams, WorldHandBound, WorldHandLimit};
pub use device::observer::Prior;
pub use device::params::WorldLoop;
pub use device::sample::{Limited, Output, Sample, WorldFault};
pub use dynamics::ledger::{
    BodyLedger, ContactLedger, Departed, DeviceLedger, EnergyLedger, FieldLedger, JointLedger,
};
pub use error::field::WorldField;
pub use error::{LARGEST, LEAST, WorldError, WorldErrors, WorldPart, out_of_range};
pub use geometry::hull::{Hull, HullError};
pub use geometry::mesh::{
    DistanceGrid, GridBytesError, GridError, InvalidGrid, InvalidShell, MassProperties, Mesh,
    MeshError, PointShell,
};
pub use geometry::shape::{Shape, SphereAt};
pub use integration::interval::{Effort, SubSteps};
pub use method::change::Succession;
pub use method::renderer::WorldRenderer;
pub use method::state::{BodyState, ContactState, ToolState, WorldState};
pub use method::{
    BasicParams, CoupledParams, GodObjectParams, HfcrParams, PopcParams, SehParams,
    VirtualCouplingParams, WorldMethod,
};

/// A vector along the axes of the world frame, for example a position `[m]` or a force `[N]`.
pub type Vector = [f64; 3];
/// A unit quaternion `[w, x, y, z]` `[1]` that rotates a body's own axes to the world's axes.
pub type Quaternion = [f64; 4];

/// The identity quaternion.
pub const IDENTITY: Quaternion = [1.0, 0.0, 0.0, 0.0];
