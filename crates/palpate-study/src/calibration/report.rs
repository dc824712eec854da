//! What a calibration found, as text and as JSON.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use palpate_calibrate::{Calibration, Quantity};
use serde::Serialize;

use crate::card::MotionCard;
use crate::text::digits;

/// Name and version of the JSON report.
const FORMAT: &str = "palpate calibrate 1";

/// What a calibration found.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct CalibrationReport {
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    format: &'static str,
    /// Samples of the excitation.
    pub samples: usize,
    /// How far the device went from where it started.
    pub excursion_m: f64,
    /// Time that the fit took.
    pub fit_s: f64,
    /// What was found, by the keys of a device file.
    pub found: BTreeMap<&'static str, Found>,
    /// A part of the motion beside its fit; only in the file of `--report`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<MotionCard>,
    /// Files that were written.
    pub wrote: Vec<String>,
}

/// A value that was found.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct Found {
    /// In the unit of the key.
    pub value: f64,
    /// In the same unit; none where nobody said it.
    pub standard_deviation: Option<f64>,
    /// How it was found.
    pub found_by: Option<String>,
}

impl CalibrationReport {
    /// The report of a calibration on the `positions` `[m]` of its motion, whose fit took `fit_s` `[s]`.
    ///
    /// # Panics
    /// Without a position.
    #[must_use]
    pub fn new(calibration: &Calibration, positions: &[f64], fit_s: f64) -> Self {
        let from = positions[0];
        let excursion = positions.iter().map(|x| (x - from).abs());
        let found = calibration.known.iter().map(|(quantity, known)| {
            let found = Found {
                value: known.value,
                standard_deviation: known.standard_deviation,
                found_by: known.found_by.clone(),
            };
            (quantity.key(), found)
        });
        Self {
            format: FORMAT,
            samples: positions.len(),
            excursion_m: excursion.fold(0.0, f64::max),
            fit_s,
            found: found.collect(),
            motion: None,
            wrote: Vec::new(),
        }
    }

    /// Says that a file was written.
    pub fn wrote(&mut self, path: &Path) {
        self.wrote.push(path.display().to_string());
    }
}

impl fmt::Display for CalibrationReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} samples, at most {} mm from the start; fit in {:.2} s",
            self.samples,
            digits(1e3 * self.excursion_m),
            self.fit_s
        )?;
        for quantity in Quantity::ALL {
            if let Some(found) = self.found.get(quantity.key()) {
                write!(f, "  {:27}{}", quantity.key(), found.value)?;
                match found.standard_deviation {
                    Some(deviation) if deviation > 0.0 => writeln!(f, " +- {deviation}")?,
                    _ => writeln!(f)?,
                }
            }
        }
        if !self.found.contains_key(Quantity::Resonance.key()) {
            writeln!(f, "no resonance found")?;
        }
        for path in &self.wrote {
            writeln!(f, "wrote {path}")?;
        }
        Ok(())
    }
}
