//! Worlds: several devices, bodies and contacts in space, their ideal motion and the evaluation of renderings.
//!
//! ```text
//! tool of a device   m x″ = f + F − k (x − x_rest) − b x′ + Σ tremor     along each axis
//! of a linkage       (M v)′ = f + F … + grad (vᵀ M v/2)             M a matrix by the place
//! of six axes        L′ = τ + T − k φ − b ω + Σ tremor          and the tool turns with it
//! rigid body         M x″ = F + Σ f,   L′ = Σ r × f                      L the angular momentum
//! contact            N = max(0, K p + B p′) while p > 0, along n, from the second member to the first
//! friction           z′ = v_t + (n × n′) × z, cut to |z| ≤ μ N/k_t; force on the first member −k_t z
//! ```
//!
//! A contact acts at one point, midway between the two surfaces on the line along n. All quantities are in world axes
//! and SI units; a force on a tool is the force that its device applies to the hand.
//!
//! # From scene to evaluation
//!
//! ```
//! use palpate_testbed::grid::Grid;
//! use palpate_testbed::world::benchmarks::paddle;
//! use palpate_testbed::world::{CheckedIdeal, PlantParams, WorldEvaluation, WorldPlant};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let benchmark = paddle();
//! let grid = Grid::even(0.0, benchmark.period, benchmark.intervals());
//! let ideal = CheckedIdeal::new(&benchmark.scene, grid)?.ideal;
//!
//! // A loop that renders nothing at all.
//! let mut plant = WorldPlant::new(&benchmark.scene, PlantParams::perfect(benchmark.period))?;
//! for _ in 0..benchmark.intervals() {
//!     let _measured = plant.measure();
//!     plant.hold(&[[0.0; 3]]);
//! }
//! let held = [plant.delivered(0)];
//! let evaluation = WorldEvaluation::new(&benchmark.scene, &ideal, &held)?;
//! let sum = evaluation.sum.ok_or("no touch")?;
//! assert_eq!(format!("{:.1} %", sum.force_rendering_error), "100.0 %");
//! assert_eq!(format!("{:.1} %", sum.hold_bound), "6.5 %");
//! # Ok(())
//! # }
//! ```

pub mod benchmarks;
mod between;
mod contact;
mod crossing;
mod cylinder;
#[cfg(test)]
mod cylinder_tests;
mod decisive;
mod dormand_prince;
mod evaluation;
mod field;
mod force_field;
mod hand;
mod held_axis;
mod held_linkage;
mod held_turning;
mod hull;
mod ideal;
mod joints;
mod layout;
mod mass_table;
pub mod mesh;
mod modes;
mod motion;
mod overlap;
mod pairing;
mod plant;
mod prescribed_motion;
pub mod random_worlds;
mod record;
mod ridders;
mod rod;
mod run;
mod scene;
mod self_check;
mod surface;
mod tangent;
mod tube;
mod turning;
mod vector;
mod wrapping;

pub use contact::WorldError;
pub use decisive::Decisive;
pub use evaluation::{
    ContactEvaluation, DeviceEvaluation, EvaluationError, RenderedTouch, TorqueEvaluation,
    WindowRule, WorldEvaluation,
};
pub use field::Field;
pub use force_field::{Attractor, ForceField, Potential};
pub use hand::{Drivetrain, Swing, WorldHand};
pub use held_turning::HeldTurning;
pub use hull::Hull;
pub use ideal::{TOLERANCE, WorldIdeal};
pub use joints::{Freedom, WorldJoint};
pub use mass_table::MassTable;
pub use overlap::Overlap;
pub use plant::{PlantParams, WorldPlant};
pub use prescribed_motion::LedPath;
pub use record::{
    BodyState, ContactState, DeviceProfile, DeviceState, Encounter, ReferenceLedger, WorldState,
};
pub use scene::{
    ContactLaw, FreeMotion, InvalidScene, Member, Pair, Shape, SphereAt, Tool, Vector, WorldBody,
    WorldDevice, WorldScene,
};
pub use self_check::{CheckedIdeal, LARGEST_ERROR};
pub use turning::{Turning, TurningHand};
