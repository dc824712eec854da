//! The device report as an HTML page with inline figures.

mod escape;
mod figures;
mod page;
mod sections;

pub use page::html;
