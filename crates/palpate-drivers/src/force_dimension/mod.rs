//! Devices of Force Dimension (omega, delta, sigma, lambda) and Novint's Falcon, by the manufacturer's library, which is
//! loaded at run time.

mod driver;
mod kinds;
mod library;
mod open;
mod rotation;
mod velocity;

pub use driver::ForceDimension;
pub use kinds::{KINDS, Kind};
pub use library::{LibraryNotFound, find};
pub use open::{LONGEST_WATCHDOG, OpenError, Options, Part, PoseMass};
