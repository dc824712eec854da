//! Motion of tools and bodies: joints, fields, linkages, drives, and the energy ledger.

pub(crate) mod joint_springs;
pub(crate) mod ledger;
pub(crate) mod linkage;
pub(crate) mod moving_body;
pub(crate) mod potentials;
