//! Contact with bodies that another physics engine moves.
//!
//! The engine owns the bodies; the contacts of the tools with them are rendered here. Nothing but forces goes into the
//! engine, and nothing but states comes out of it: no body is put anywhere. A period has three parts:
//!
//! ```text
//! sample    the devices' positions            where the avatars are when the period of the next command begins
//! advance   the engine's bodies, for each     avatars and contacts over one step of the engine: the mean wrench of
//!           step of the engine                the contacts on each body, which the engine holds over that step
//! hold      the forces on the devices         the mean force of the contacts over the period, as `coupled` holds it
//! ```
//!
//! So the engine is stepped through a period before its force is held, and the force is that of what the engine really
//! did, with its other contacts, joints and robots. A body answers within a step by its mobility, as the engine tells
//! it for the step's beginning.
//!
//! Two things are held that stand for a changing force, and each moves what it is held on to another place than the
//! force itself would have: the device over a period, and the body over a step. Both differences are known. The
//! device's becomes the offset of its avatar, as in [`CoupledParams`](crate::CoupledParams). The body's becomes the
//! offset of its image, which the avatar meets in place of the body.

mod body;
mod coupling;
mod image;
pub mod local;
mod meeting;
mod pairs;
mod renderer;
mod state;
mod touch;

pub use body::{BodyNow, BodyWrench, EngineBody, PlacedShape, Stepping};
pub use renderer::EngineRenderer;
pub use state::{BodyPortBook, EngineBooks, EngineContact, EngineOutput, EngineState, PortBook};
