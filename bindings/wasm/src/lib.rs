//! palpate in a browser: the loop of `palpate live`, its virtual device and the worlds, as WebAssembly.
//!
//! The loops are the program's own ([`palpate_rt::ControlLoop`]), on a clock that the page moves; nothing is computed
//! here that is not computed by the crates below. A host calls the functions of [`edge`]; `web/engine.js` is the one
//! of the page. `docs/playground.md` says what the page shows.

pub mod edge;
mod lane;
#[cfg(feature = "numbers")]
mod numbers;
mod playground;
mod space;

#[cfg(feature = "numbers")]
pub use numbers::numbers;
pub use playground::{Playground, Refused};
pub use space::Space;
