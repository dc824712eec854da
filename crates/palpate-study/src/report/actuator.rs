//! True values of an actuator and the renderer's model values, under the names of scene files.

use palpate_core::{Actuation, Hold, LARGEST_DELAY};
use palpate_scene::Scene;

/// Returns the true values of a scene's actuator and its renderer's model values, by key, and `hold_order` 1 if it
/// holds lines. Empty for an ideal actuator of constants with a correctly modelled delay of whole samples.
#[must_use]
pub fn of(scene: &Scene) -> Vec<(&'static str, f64)> {
    let actuation = scene.model_actuation();
    let mut lines = Vec::new();
    let truth = &scene.actuator;
    if truth.lag != 0.0 || truth.gain != 1.0 {
        lines.extend([("lag_s", truth.lag), ("gain", truth.gain)]);
    }
    if actuation.hold == Hold::Line {
        lines.push(("hold_order", 1.0));
    }
    lines.extend(model(
        &actuation,
        scene.delay.whole_samples(),
        scene.loop_params.period,
    ));
    lines
}

/// Returns the renderer's model values, by key; empty if the model is only a delay of `samples` whole samples.
pub fn model(
    model: &Actuation<f64>,
    samples: usize,
    period: f64,
) -> impl Iterator<Item = (&'static str, f64)> + use<> {
    let usual = Actuation {
        hold: model.hold,
        ..Actuation::after_samples(samples.min(LARGEST_DELAY), period)
    };
    let as_usual = *model == usual;
    let transmission = model.transmission.map(|it| {
        [
            ("model_resonance_hz", it.resonance),
            ("model_resonance_damping_ratio", it.damping_ratio),
            ("model_flexible_mass_fraction", it.flexible_mass_fraction),
        ]
    });
    let lines = [
        ("model_delay_s", model.delay),
        ("model_lag_s", model.lag),
        ("model_gain", model.gain),
        ("model_delay_deviation_s", model.delay_deviation),
        ("model_lag_deviation_s", model.lag_deviation),
        ("model_gain_deviation", model.gain_deviation),
    ];
    let transmission = transmission.into_iter().flatten();
    lines
        .into_iter()
        .chain(transmission)
        .filter(move |_| !as_usual)
}
