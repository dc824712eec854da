//! A local model: how a fast loop renders contact with what a slow host computes.
//!
//! The host is a physics engine, a game or a query of a large mesh, at 20 to 200 Hz. The fast loop renders at 1 kHz, say.
//!
//! ```text
//! host, slow        its bodies as they are now, their mobility, and what else accelerates them; the places where a tool may
//!                   touch them, and where they touch each other and what is fixed: a LocalModel
//!                         |  newest model                        ^  LocalProgress: where the avatars are, and the
//!                         v                                      |  impulse of the tools on each body so far
//! loop, fast        copies of the bodies go on from period to period, and meet the avatars, as `coupled` renders
//! ```
//!
//! The host steps over the time that has passed, under the mean wrench of the tools in it ([`LocalProgress::wrench_since`]), and
//! publishes what came out. Each model says up to which tick of the loop it has the tools' impulses in it.
//!
//! When a model comes, the loop computes by the last model where the host's step should have brought each body, with the same
//! mean wrench. What the host says beyond that is what the loop did not know, and each copy is moved by it. So the difference of
//! a held mean wrench and a force that changes, which is large over a step of a slow host, does not move the copies. What is left
//! between host and copy goes away in [`LocalParams::return_time`].
//!
//! A loop that misses ticks counts them when it comes back, so the time of the ticks is the time that has passed, to less than a
//! period. Over what it has missed the copies go on under the mean wrench of the tools in the last period, as the device was held.
//!
//! What a model changes of a contact that touches comes in over [`LocalParams::settle`]: the force does not step. The energy of
//! the change is booked as `outside`.

mod copies;
mod late;
mod model;
mod params;
mod past;
mod progress;
mod renderer;
mod slot;
mod state;

pub use model::{LocalContact, LocalModel, Touching};
pub use params::LocalParams;
pub use progress::{BodyImpulse, LocalProgress};
pub use renderer::LocalRenderer;
pub use state::{LocalBooks, LocalOutput, LocalState, ModelRefusal};
