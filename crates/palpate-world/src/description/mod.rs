//! The description of a world: tools, bodies, joints, contacts and fields.

pub(crate) mod body;
pub(crate) mod contact;
pub(crate) mod field;
pub(crate) mod joint;
pub(crate) mod mass_table;
pub(crate) mod world;
