//! Worlds: several devices, bodies and contacts in space, their ideal and their judgement.
//!
//! ```text
//! tool of a device   m x″ = f + F − k (x − x_rest) − b x′ + Σ tremor     along each axis
//! rigid body         M x″ = F + Σ f,   L′ = Σ r × f                      L the angular momentum
//! contact            N = max(0, K p + B p′) while p > 0, along n, from the second member to the first
//! friction           z′ = v_t + (n × n′) × z, cut to |z| ≤ μ N/k_t; force on the first member −k_t z
//! ```
//!
//! A contact acts at one point, midway between the two surfaces on the line along n. All is in world axes and
//! SI units; a force on a tool is what its device gives to the hand.

mod contact;
mod dormand_prince;
mod held_axis;
mod ideal;
mod judgement;
mod modes;
mod motion;
mod plant;
mod scene;
mod self_check;
mod surface;
mod vector;

pub use contact::WorldError;
pub use ideal::{
    BodyState, ContactState, DeviceProfile, DeviceState, Encounter, TOLERANCE, WorldBooks,
    WorldIdeal, WorldState,
};
pub use judgement::{
    DeviceJudgement, JudgementError, RenderedTouch, TouchJudgement, WindowRule, WorldJudgement,
};
pub use plant::{PlantParams, WorldPlant};
pub use scene::{
    ContactLaw, InvalidScene, Member, Motion, Pair, Shape, Vector, WorldBody, WorldDevice,
    WorldHand, WorldScene,
};
pub use self_check::{CheckedIdeal, LARGEST_ERROR};
