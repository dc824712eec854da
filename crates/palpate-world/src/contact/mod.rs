//! Contacts: pairs of shapes, contact points, and their law.

pub(crate) mod broad_phase;
pub(crate) mod convex_pairs;
pub(crate) mod islands;
pub(crate) mod law;
pub(crate) mod nearby;
pub(crate) mod pairs;
pub(crate) mod point;
