//! The figure of a calibration: measured against fitted, and what is left.

use palpate_calibrate::{Calibration, Measured, Quantity};
use palpate_figure::{Figure, Kind, Panel, Role, Row, Series};

use super::motion::Motion;
use palpate_study::text::digits;

/// How much of the motion is drawn `[s]`: steps of the force have to be seen.
const SHOWN: f64 = 0.25;

/// Positions, forces and what the fit left of the positions, over a part in the middle.
pub fn figure(motion: &Motion, measured: &Measured, period: f64) -> Figure {
    let excited = motion.excited();
    let middle = usize::midpoint(excited.start, excited.end);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a number of samples"
    )]
    let half = (0.5 * SHOWN / period).ceil() as usize;
    let shown = middle.saturating_sub(half).max(excited.start)..(middle + half).min(excited.end);
    let time: Vec<f64> = shown.clone().map(|i| i as f64 * period).collect();
    let curve = |name: &str, kind, role, y: Vec<f64>| Series {
        name: name.into(),
        kind,
        role,
        x: time.clone(),
        y,
    };
    let start = motion.positions[0];
    let moved = |of: &[f64]| -> Vec<f64> {
        of[shown.clone()]
            .iter()
            .map(|x| 1e3 * (x - start))
            .collect()
    };
    let left = shown
        .clone()
        .map(|i| 1e6 * (motion.positions[i] - measured.foreseen[i]))
        .collect();
    let row = |y_label: &str, series| Row {
        y_label: y_label.into(),
        panels: vec![Panel { series }],
        ..Row::default()
    };
    Figure {
        title: finding(&measured.fitted.calibration),
        subtitle:
            "Positions under random force steps, and each as the fit foresees it from those before"
                .into(),
        x_label: "time [s]".into(),
        rows: vec![
            row(
                "position [mm]",
                vec![
                    curve(
                        "measured",
                        Kind::Points,
                        Role::Recorded,
                        moved(&motion.positions),
                    ),
                    curve(
                        "fitted",
                        Kind::Line,
                        Role::Compared(0),
                        moved(&measured.foreseen),
                    ),
                ],
            ),
            row(
                "measured - fitted [um]",
                vec![curve("measured - fitted", Kind::Line, Role::Recorded, left)],
            ),
            row(
                "command [N]",
                vec![curve(
                    "command",
                    Kind::Step,
                    Role::Compared(0),
                    motion.forces[shown.clone()].to_vec(),
                )],
            ),
        ],
        ..Figure::default()
    }
}

/// What was found, in a line.
fn finding(calibration: &Calibration) -> String {
    let said = |quantity, unit: f64, name: &str, symbol: &str| {
        let value = calibration.value(quantity)? * unit;
        let deviation = calibration.standard_deviation(quantity)? * unit;
        Some(format!(
            "{name} {} ± {} {symbol}",
            digits(value),
            digits(deviation)
        ))
    };
    let found = [
        said(Quantity::DeviceMass, 1e3, "mass", "g"),
        said(Quantity::DelayPlusLag, 1e3, "delay and lag", "ms"),
        said(Quantity::Resonance, 1.0, "resonance", "Hz"),
    ];
    let found: Vec<String> = found.into_iter().flatten().collect();
    found.join(", ")
}
