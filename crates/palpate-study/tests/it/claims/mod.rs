//! Claims of the paper that the studies check: claims of its text, and of its scenes over start heights.
//!
//! Claims about single runs and single intervals are in `crates/palpate-study/tests/it/paper/`. Its module comment
//! defines "the paper" and the meaning of a test's source.

mod readings;
mod scenes;
