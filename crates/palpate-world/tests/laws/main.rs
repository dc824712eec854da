//! Physical laws that a rendered world obeys.
#![allow(missing_docs)]
#![allow(clippy::print_stdout)] // the tests print measured values
#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // numbers of samples

mod adversary;
mod balance;
mod boxes;
mod capsules;
mod changes;
mod closed_form;
mod common;
mod conservation;
mod cylinders;
mod cylinders_anyhow;
mod description;
mod ejected;
mod engine;
mod engine_convex;
mod engine_sub_steps;
mod far_side;
mod fields;
mod floor;
mod god_object;
mod grasp;
mod guard;
mod guard_attack;
mod held;
mod hfcr;
mod hulls;
mod ideal;
mod joints;
mod kick;
mod late_copies;
mod late_ticks;
mod ledger;
mod lines;
mod local;
mod many;
mod meshes;
mod migration;
mod orientations;
mod pressed;
mod refusals;
mod rejected;
mod resting;
mod settling;
mod six_axes;
mod tumbling;
mod turned_by_hand;
