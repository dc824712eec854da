//! Physical laws that a rendered world keeps.
#![allow(missing_docs)]

mod common;
mod conservation;
mod floor;
mod ideal;
