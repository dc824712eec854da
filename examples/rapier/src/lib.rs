//! Contact with the bodies of the physics engine Rapier, and its accuracy compared with the ideal.
//!
//! [`contact`] is the adapter. [`scenes`] and [`rendered`] evaluate it; the program `table` prints the results.

pub mod contact;
pub mod rendered;
pub mod scenes;
#[cfg(test)]
mod tests;
