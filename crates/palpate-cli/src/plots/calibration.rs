//! The motion of a calibration: measured against fitted, and what is left.

use palpate_figure::{Figure, Kind, Panel, Role, Row, Series};
use palpate_study::card::MotionCard;

/// Positions, what the fit left of them, and commands; without a title.
pub fn figure(motion: &MotionCard) -> Figure {
    let curve = |name: &str, kind, role, y: Vec<f64>| Series {
        name: name.into(),
        kind,
        role,
        x: motion.t_s.clone(),
        y,
    };
    let in_millimetres = |of: &[f64]| of.iter().map(|x| 1e3 * x).collect();
    let left = motion
        .measured_m
        .iter()
        .zip(&motion.fitted_m)
        .map(|(measured, fitted)| 1e6 * (measured - fitted))
        .collect();
    let row = |y_label: &str, series| Row {
        y_label: y_label.into(),
        panels: vec![Panel { series }],
        ..Row::default()
    };
    Figure {
        x_label: "time [s]".into(),
        rows: vec![
            row(
                "position [mm]",
                vec![
                    curve(
                        "measured",
                        Kind::Points,
                        Role::Recorded,
                        in_millimetres(&motion.measured_m),
                    ),
                    curve(
                        "fitted",
                        Kind::Line,
                        Role::Compared(0),
                        in_millimetres(&motion.fitted_m),
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
                    motion.command_n.clone(),
                )],
            ),
        ],
        ..Figure::default()
    }
}
