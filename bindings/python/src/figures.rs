//! Figures as SVG, in natural size.

use palpate_plot::figure::{Picture, Size, svg};
use palpate_plot::{Devices, RunsFigure};
use palpate_study::sim::run::{Reference, Run};

/// Returns a figure as SVG.
///
/// # Errors
/// The figure does not fit its size.
pub fn drawn(figure: &(impl Picture + ?Sized)) -> Result<String, String> {
    svg(figure, Size::NATURAL).map_err(|error| error.to_string())
}

/// Returns the figure of the runs of a scene or a recorded motion called `of`.
///
/// # Errors
/// The figure does not fit its size.
pub fn of_runs(
    of: &str,
    reference: &Reference,
    runs: &[Run],
    devices: Devices,
) -> Result<String, String> {
    let figure = RunsFigure {
        of: of.to_owned(),
        reference,
        runs,
        devices,
        recorded: None,
    };
    drawn(&figure.sheet())
}
