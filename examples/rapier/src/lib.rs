//! Contact with the bodies of the physics engine Rapier, and how near it is to the ideal.
//!
//! [`contact`] is the adapter. [`scenes`] and [`rendered`] judge it; the program `table` prints what they find.

pub mod contact;
pub mod rendered;
pub mod scenes;
#[cfg(test)]
mod tests;
