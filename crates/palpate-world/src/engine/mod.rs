//! Contact with bodies that another physics engine moves.
//!
//! The engine owns the bodies; this module renders their contacts with the tools. It passes only forces to the engine
//! and reads only states: it never sets the pose of a body. A period has three parts:
//!
//! ```text
//! sample    the devices' positions            where the avatars are when the period of the next command begins
//! advance   the engine's bodies, for each     avatars and contacts over one step of the engine: the mean wrench of
//!           step of the engine                the contacts on each body, which the engine holds over that step
//! hold      the forces on the devices         the mean force of the contacts over the period, as `coupled` holds it
//! ```
//!
//! The engine is stepped through a period before the force of that period is held. The force therefore includes the
//! effect of the engine's other contacts, joints and robots. Within a step a body responds with the mobility that the
//! engine reports for the beginning of the step.
//!
//! Two constant forces replace a varying force: one on the device over a period, one on the body over a step. Each
//! leads to an end position that differs from that of the varying force by a known amount. The difference at the
//! device becomes the offset of its proxy, as in [`CoupledParams`](crate::CoupledParams). The difference at the body
//! becomes the offset of its image, with which the proxy collides instead of the body.

mod body;
mod contact_point;
mod coupling;
mod image;
mod integration;
pub mod local;
mod pairs;
mod renderer;
mod state;

pub use body::{BodyNow, BodyWrench, EngineBody, PlacedShape, Stepping};
pub use renderer::EngineRenderer;
pub use state::{
    BodyPortLedger, EngineContact, EngineLedger, EngineOutput, EngineState, PortLedger,
};
