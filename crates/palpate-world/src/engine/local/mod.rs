//! Multirate local model: a fast loop renders contact with objects of a low-rate simulator (the host).
//!
//! The host is a physics engine, a game or a query of a large mesh, at 20 to 200 Hz. The fast loop runs at, for
//! example, 1 kHz.
//!
//! ```text
//! host, slow        current states of its bodies, their mobility and external acceleration; contacts of tools with bodies, of
//!                   bodies with each other and with fixed geometry: a LocalModel
//!                         |  newest model                        ^  LocalProgress: positions of the proxies, and the
//!                         v                                      |  impulse of the tools on each body so far
//! loop, fast        copies of the bodies are integrated each period, in contact with the proxies, as `coupled` renders
//! ```
//!
//! The host steps over the elapsed time under the tools' mean wrench over that time ([`LocalProgress::wrench_since`])
//! and publishes the result. Each model states the loop tick up to which it includes the tools' impulses.
//!
//! When a model arrives, the loop predicts each body from the last model over the host's step, under the same mean
//! wrench. Each copy is moved by the difference between the new model and this prediction, which is new information.
//! The difference between a mean wrench and a varying force, which is large over a step of a low-rate simulator,
//! therefore does not move the copies. The remaining difference between host and copy decays with
//! [`LocalParams::return_time`].
//!
//! A loop that misses ticks counts them at its next tick, so tick time follows elapsed time to within one period.
//! Over missed ticks the copies move under the tools' mean wrench of the last period, because the device was held for
//! the same time.
//!
//! A model's change of an active contact is blended in over [`LocalParams::settle`], so the force is continuous. The
//! energy of the change is recorded as `outside`.

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
pub use state::{LocalLedger, LocalOutput, LocalState, ModelRefusal};
