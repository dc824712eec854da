//! Figures of the paper.

mod experiment;
mod linkage;
mod modes;
mod sampled_loop;
mod steps;

pub use experiment::{Compared, MEASURED_1, MEASURED_2, Measured, experiment};
pub use linkage::drawing as linkage;
pub use modes::drawing as modes;
pub use steps::{fig2, fig2_long};
