//! Claims of the paper that studies check: those of its text and of its scenes over start heights.
//!
//! The claims that single runs and single intervals show are in `crates/palpate-sim/tests/it/paper/`, whose
//! first lines say what "the paper" is and what a test's source means.

mod readings;
mod scenes;
