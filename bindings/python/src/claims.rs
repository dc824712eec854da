//! `claims`: the paper's numerical claims, recomputed.

use palpate_scene::{ContactFile, Scene};
use palpate_study::claims::report::ClaimsReport;
use palpate_study::claims::{PaperScenes, check};
use pyo3::prelude::*;

use crate::interrupt::interruptible;
use crate::names::refused;

/// Committed scenes of the claims.
const SCENES: [(&str, &str); 6] = [
    ("fig2", include_str!("../experiments/fig2.toml")),
    (
        "experiment1",
        include_str!("../experiments/experiment1.toml"),
    ),
    (
        "experiment2",
        include_str!("../experiments/experiment2.toml"),
    ),
    ("fig4", include_str!("../experiments/fig4.toml")),
    ("fig5", include_str!("../experiments/fig5.toml")),
    ("fig5_box", include_str!("../experiments/fig5_box.toml")),
];

/// Checks the claims and returns the report as JSON and as text.
#[pyfunction]
pub fn claims(py: Python<'_>) -> PyResult<(String, String)> {
    let scenes: PyResult<Vec<Scene>> = SCENES
        .iter()
        .map(|(name, text)| Ok(ContactFile::parse(name, text).map_err(refused)?.scene))
        .collect();
    let scenes: [Scene; 6] = scenes?
        .try_into()
        .map_err(|_| refused("the scenes do not match the texts"))?;
    let checked = interruptible(py, move |stop| {
        let [fig2, experiment1, experiment2, fig4, fig5, fig5_box] = &scenes;
        let scenes = PaperScenes {
            fig2,
            point_mass: [experiment1, experiment2],
            pantograph: [fig4, fig5],
            fig5_box,
        };
        check(&scenes, || stop.leave_if_raised()).map(ClaimsReport::new)
    })?;
    let report = checked.map_err(refused)?;
    Ok((palpate_study::json(&report), report.to_string()))
}
