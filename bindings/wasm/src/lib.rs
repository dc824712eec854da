//! palpate in a browser: the loop of `palpate live`, its virtual device and the worlds, as WebAssembly.
//!
//! The loops are the program's own ([`palpate_rt::ControlLoop`]), with a clock that the page advances. The crates below
//! do all computations. A host calls the functions of [`edge`]; `web/engine.js` does so for the page.
//! `docs/playground.md` describes the page.

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
