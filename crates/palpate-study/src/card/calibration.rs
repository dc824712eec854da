//! Calibration in a device report: the values of a device file, and the fit if its report is available.

use std::collections::BTreeMap;

use crate::calibrate::{Calibration, Quantity};
use crate::calibration::MotionCard;
use serde::{Deserialize, Serialize};

/// Format of the readable calibration reports.
const RUN_FORMAT: &str = "palpate calibrate 1";
/// Largest relative difference between a value of a device file and that of the same calibration's report.
const SAME_VALUE: f64 = 1e-3;

/// Content of a device file.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct CalibrationCard {
    /// The device file.
    pub file: String,
    /// Date of the calibration, if the file contains it.
    pub date: Option<String>,
    /// Command of the calibration, if the file contains it.
    pub command: Option<String>,
    /// Axis of the calibration, if the file contains it.
    pub axis: Option<String>,
    /// Identified values, in the order of the file.
    pub found: Vec<FoundCard>,
    /// The motion and its fit, if the report of the calibration is available.
    pub motion: Option<MotionCard>,
    /// Values of the report of the calibration that differ from those of the file: key, value of the file, and value
    /// of the report.
    #[serde(skip)]
    pub(super) differing: Vec<(&'static str, [f64; 2])>,
}

/// A value of a device file.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FoundCard {
    /// Key of the file, with the unit.
    pub key: &'static str,
    /// Meaning of the value.
    pub meaning: &'static str,
    /// Value in the unit of the key.
    pub value: f64,
    /// Standard deviation in the same unit; none if unknown.
    pub standard_deviation: Option<f64>,
    /// Identification method; none if unknown.
    pub found_by: Option<String>,
}

/// Parsed content of a calibration report, `palpate calibrate --report`.
#[derive(Debug, Clone, Deserialize)]
pub struct CalibrationRun {
    format: String,
    /// Number of samples of the excitation.
    pub samples: usize,
    /// The identified values, by key.
    #[serde(default)]
    pub found: BTreeMap<String, FoundValue>,
    /// A part of the motion, if the report contains it.
    pub motion: Option<MotionCard>,
}

/// An identified value of a calibration report, in the unit of its key.
#[derive(Debug, Clone, Copy, Deserialize)]
pub struct FoundValue {
    /// The value.
    pub value: f64,
}

/// Reason why a text is not a calibration report.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NoCalibrationRun {
    /// The JSON is invalid or of another type.
    #[error("it is not a calibration report of `palpate calibrate --report`: {0}")]
    Json(#[from] serde_json::Error),
    /// The report has another format or version.
    #[error("its format is `{0}`, but must be `{RUN_FORMAT}`")]
    Format(String),
    /// The report has no motion.
    #[error(
        "it has no motion to draw; `palpate calibrate --report FILE` writes a report with one, --json does not"
    )]
    NoMotion,
    /// The series differ in length, or a value is not finite.
    #[error("the series of its motion differ in length")]
    Lengths,
}

impl CalibrationRun {
    /// Reads the JSON text of a report.
    ///
    /// # Errors
    /// The text is not JSON, has another format, or has no motion.
    pub fn parse(text: &str) -> Result<Self, NoCalibrationRun> {
        let run: Self = serde_json::from_str(text)?;
        if run.format != RUN_FORMAT {
            return Err(NoCalibrationRun::Format(run.format));
        }
        let motion = run.motion.as_ref().ok_or(NoCalibrationRun::NoMotion)?;
        let lengths = [&motion.measured_m, &motion.fitted_m, &motion.command_n].map(Vec::len);
        if lengths != [motion.t_s.len(); 3] {
            return Err(NoCalibrationRun::Lengths);
        }
        Ok(run)
    }
}

impl CalibrationCard {
    pub(super) fn new(
        (file, calibration): (&str, &Calibration),
        run: Option<&(&str, CalibrationRun)>,
    ) -> Self {
        let found = Quantity::ALL.into_iter().filter_map(|quantity| {
            let known = calibration.known.get(&quantity)?;
            Some(FoundCard {
                key: quantity.key(),
                meaning: quantity.meaning(),
                value: known.value,
                standard_deviation: known.standard_deviation,
                found_by: known.found_by.clone(),
            })
        });
        let found: Vec<FoundCard> = found.collect();
        // The file has the digits of the report.
        let differing = found.iter().filter_map(|found| {
            let of_run = run?.1.found.get(found.key)?.value;
            let scale = found.value.abs().max(of_run.abs());
            let differs = (of_run - found.value).abs() > SAME_VALUE * scale;
            differs.then_some((found.key, [found.value, of_run]))
        });
        Self {
            differing: differing.collect(),
            file: file.to_owned(),
            date: calibration.date.clone(),
            command: calibration.command.clone(),
            axis: calibration.axis.clone(),
            found,
            motion: run.and_then(|(_, run)| run.motion.clone()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_of_another_calibration_is_noticed() {
        let file = "calibration_format = 1\ndevice_mass_kg = 0.25\nlag_s = 1e-5\n";
        let file = Calibration::parse("device.toml", file).unwrap();
        let differing = |mass: f64| {
            let run = format!(
                r#"{{"format":"{RUN_FORMAT}","samples":3,"found":{{"device_mass_kg":{{"value":{mass},"found_by":"fit"}},
                "lag_s":{{"value":1e-5}}}},
                "motion":{{"t_s":[0],"measured_m":[0],"fitted_m":[0],"command_n":[0]}}}}"#
            );
            let run = ("fit.json", CalibrationRun::parse(&run).unwrap());
            CalibrationCard::new(("device.toml", &file), Some(&run)).differing
        };
        assert_eq!(differing(0.25), []);
        assert_eq!(differing(0.05), [("device_mass_kg", [0.25, 0.05])]);
    }

    #[test]
    fn only_a_report_with_a_whole_motion_is_read() {
        let text = |format: &str, motion: &str| {
            format!(r#"{{"format":"{format}","samples":3,"found":{{}}{motion}}}"#)
        };
        let motion = r#","motion":{"t_s":[0],"measured_m":[0],"fitted_m":[0],"command_n":[0]}"#;
        assert!(CalibrationRun::parse(&text(RUN_FORMAT, motion)).is_ok());
        for (wrong, said) in [
            (text("palpate run 1", motion), "palpate run 1"),
            (text(RUN_FORMAT, ""), "no motion"),
            (
                text(RUN_FORMAT, &motion.replace("\"t_s\":[0]", "\"t_s\":[]")),
                "differ in length",
            ),
            ("what".into(), "not a calibration report"),
        ] {
            let error = CalibrationRun::parse(&wrong).unwrap_err().to_string();
            assert!(error.contains(said), "{error}");
        }
    }
}
