//! Figure of a calibration: measured and fitted motion, residual, and results.

use crate::figure::{Figure, Kind, Panel, Role, Row, Series};
use palpate_study::calibrate::{Calibration, Quantity};
use palpate_study::calibration::MotionCard;

/// Returns the figure of positions, fit residual and commands, without a title.
#[must_use]
pub fn motion(motion: &MotionCard) -> Figure {
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
                "measured - fitted [µm]",
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

/// Returns the figure of positions, forces and fit residual, with the results in its title.
#[must_use]
pub fn calibration(shown: &MotionCard, calibration: &Calibration) -> Figure {
    Figure {
        title: finding(calibration),
        subtitle:
            "Positions under random force steps, and their predictions by the fit from earlier samples"
                .into(),
        ..motion(shown)
    }
}

/// Returns the results as one line.
fn finding(calibration: &Calibration) -> String {
    let said = |quantity, unit: f64, name: &str, symbol: &str| {
        let value = calibration.value(quantity)? * unit;
        let deviation = calibration.standard_deviation(quantity)? * unit;
        let decimals = decimals(deviation);
        Some(format!(
            "{name} {value:.decimals$} ± {deviation:.decimals$} {symbol}"
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

/// Returns the decimals for a value and its `deviation`: two digits of the deviation.
fn decimals(deviation: f64) -> usize {
    let two_digits = (0..9).find(|decimals| deviation >= 0.1_f64.powi(*decimals) * 9.5);
    two_digits.map_or(9, |decimals| decimals.unsigned_abs() as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deviation_has_two_digits_and_its_value_as_many_decimals() {
        for (deviation, expected) in [
            (120.0, 0),
            (12.0, 0),
            (0.751, 2),
            (0.0945, 3),
            (0.0045, 4),
            (0.0, 9),
        ] {
            assert_eq!(decimals(deviation), expected, "{deviation}");
        }
    }
}
