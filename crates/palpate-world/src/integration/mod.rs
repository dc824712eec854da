//! Integration of the motion over an interval between samples.

mod fields;
pub(crate) mod held_load;
pub(crate) mod held_tools;
pub(crate) mod interval;
pub(crate) mod interval_ledger;
pub(crate) mod moving;
mod sub_step;
pub(crate) mod yielding;
