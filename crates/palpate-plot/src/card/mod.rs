//! A card as a page: HTML with its figures inside.

mod escape;
mod figures;
mod page;
mod sections;

pub use page::html;
