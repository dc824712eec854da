//! Results of a calibration, as text and as JSON.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use crate::calibrate::{Calibration, Quantity};
use serde::Serialize;

use super::MotionCard;
use crate::text::digits;

/// Name and version of the JSON report.
const FORMAT: &str = "palpate calibrate 1";

/// Results of a calibration.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct CalibrationReport {
    #[cfg_attr(any(test, feature = "schema"), schemars(extend("const" = FORMAT)))]
    format: &'static str,
    /// Number of samples of the excitation.
    pub samples: usize,
    /// Largest distance of the device from its start.
    pub excursion_m: f64,
    /// Duration of the fit.
    pub fit_s: f64,
    /// Identified values, by the keys of a device file.
    pub found: BTreeMap<&'static str, Found>,
    /// A part of the motion and its fit; only in the file of `--report`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<MotionCard>,
    /// Files that were written.
    pub wrote: Vec<String>,
}

/// An identified value.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
pub struct Found {
    /// Value in the unit of the key.
    pub value: f64,
    /// Standard deviation in the same unit; none if unknown.
    pub standard_deviation: Option<f64>,
    /// Identification method.
    pub found_by: Option<String>,
}

impl CalibrationReport {
    /// Creates the report of a calibration on the `positions` `[m]` of its motion, whose fit took `fit_s` `[s]`.
    ///
    /// # Panics
    /// `positions` is empty.
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

    /// Adds a written file.
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
