//! palpate as a Python package: the part that is compiled, `palpate._palpate`.
//!
//! It takes what the Python files of the package give it, calls the libraries, and hands back numbers:
//! reports as the JSON that the program prints, ticks as arrays. Nothing is computed here.

mod columns;
mod engine;
mod interrupt;
mod methods;
mod names;
mod own_method;
mod reach;
mod recording;
mod render;
mod renderer;
mod scene;
mod setup;
mod simulate;
mod studies;
mod world;
mod world_state;
mod worlds;

use pyo3::prelude::*;

/// What the Python files of the package call.
#[pymodule]
mod _palpate {
    #[pymodule_export]
    use super::columns::{columns, ideal_columns};
    #[pymodule_export]
    use super::engine::EngineContact;
    #[pymodule_export]
    use super::methods::methods;
    #[pymodule_export]
    use super::reach::{advise, map};
    #[pymodule_export]
    use super::recording::{read_recording, recorded_columns};
    #[pymodule_export]
    use super::render::render;
    #[pymodule_export]
    use super::renderer::Renderer;
    #[pymodule_export]
    use super::scene::{PyScene, from_toml, read_scene, to_toml};
    #[pymodule_export]
    use super::simulate::{compare, simulate};
    #[pymodule_export]
    use super::studies::{heights, run_suite, tune};
    #[pymodule_export]
    use super::world::{PyWorld, is_world};
    #[pymodule_export]
    use super::world_state::{world_bodies, world_books, world_contacts, world_tools};
    #[pymodule_export]
    use super::worlds::simulate_world;

    /// Version of the package.
    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
