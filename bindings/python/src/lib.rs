//! Compiled part of the Python package palpate: `palpate._palpate`.
//!
//! It converts arguments of the Python files, calls the libraries, and returns results: reports as the JSON that the
//! program prints, ticks as arrays. It computes nothing itself.

mod advise;
mod arrays;
mod bounded;
mod calibration;
mod card;
mod checked;
mod claims;
mod columns;
mod contact;
mod engine;
mod fields;
mod figures;
mod interrupt;
mod map;
mod methods;
mod names;
mod own_method;
mod real_time;
mod recording;
mod render;
mod renderer;
mod renderers;
mod replay;
mod scene;
mod setup;
mod simulate;
mod simulate_world;
mod studies;
mod suite;
mod world;
mod world_state;
mod worlds;

use pyo3::prelude::*;

/// Functions and classes for the Python files of the package.
#[pymodule]
mod _palpate {
    #[pymodule_export]
    use super::advise::{advice_figure, advise};
    #[pymodule_export]
    use super::calibration::{PyExcitation, calibrate, excite_scene};
    #[pymodule_export]
    use super::card::report;
    #[pymodule_export]
    use super::claims::claims;
    #[pymodule_export]
    use super::columns::{columns, ideal_columns};
    #[pymodule_export]
    use super::engine::EngineContact;
    #[pymodule_export]
    use super::map::{map, map_check, map_columns, map_of_parts, map_part};
    #[pymodule_export]
    use super::methods::methods;
    #[cfg(unix)]
    #[pymodule_export]
    use super::real_time::guard;
    #[pymodule_export]
    use super::real_time::{Hand, HandInWorld, LowRateSimulator, RealTimeLoop};
    #[pymodule_export]
    use super::recording::{read_recording, recorded_columns};
    #[pymodule_export]
    use super::render::{read_trace, render, render_figure};
    #[pymodule_export]
    use super::renderer::{Renderer, RendererState};
    #[pymodule_export]
    use super::renderers::{Renderers, RenderersState};
    #[pymodule_export]
    use super::replay::{replay, replay_figure};
    #[pymodule_export]
    use super::scene::{PyScene, from_toml, lag_question, period_question, read_scene, to_toml};
    #[pymodule_export]
    use super::simulate::{compare, simulate, simulate_figure};
    #[pymodule_export]
    use super::simulate_world::simulate_world;
    #[pymodule_export]
    use super::studies::{heights, sweep, tune};
    #[pymodule_export]
    use super::suite::{run_suite, suite_names, suite_of_parts, suite_part};
    #[pymodule_export]
    use super::world::{PyWorld, PyWorldState, is_world};
    #[pymodule_export]
    use super::world_state::{world_bodies, world_contacts, world_ledger, world_tools};
    #[pymodule_export]
    use super::worlds::{Worlds, WorldsState};

    /// Version of the package.
    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
