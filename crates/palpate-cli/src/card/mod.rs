//! A card as a page: HTML with its figures inside.

mod escape;
mod figures;
pub mod page;
mod sections;
