//! The calibration on a card: what a device file says, and the fit where its report is there.

use palpate_calibrate::{Calibration, Quantity};
use serde::{Deserialize, Serialize};

/// Format of the reports of calibrations that are read.
const RUN_FORMAT: &str = "palpate calibrate 1";

/// What a device file says.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct CalibrationCard {
    /// The device file.
    pub file: String,
    /// When it was found, if the file says.
    pub date: Option<String>,
    /// What found it, if the file says.
    pub command: Option<String>,
    /// Along which axis, if the file says.
    pub axis: Option<String>,
    /// What was found, in the order of the file.
    pub found: Vec<FoundCard>,
    /// The motion beside the fit, where the report of the calibration is there.
    pub motion: Option<MotionCard>,
}

/// A value of a device file.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FoundCard {
    /// Key of the file, with the unit.
    pub key: &'static str,
    /// What it is.
    pub meaning: &'static str,
    /// In the unit of the key.
    pub value: f64,
    /// In the same unit; none where nobody said it.
    pub standard_deviation: Option<f64>,
    /// How it was found; none where nobody said it.
    pub found_by: Option<String>,
}

/// A part of the motion of a calibration, and the same as the fit foresees it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "schema"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MotionCard {
    /// Times `[s]`.
    pub t_s: Vec<f64>,
    /// Positions from where the device started `[m]`.
    pub measured_m: Vec<f64>,
    /// The same as the fit foresees each from those before it `[m]`.
    pub fitted_m: Vec<f64>,
    /// Commands `[N]`.
    pub command_n: Vec<f64>,
}

/// What is read of the report of a calibration, `palpate calibrate --report`.
#[derive(Debug, Clone, Deserialize)]
pub struct CalibrationRun {
    format: String,
    /// Samples of the excitation.
    pub samples: usize,
    /// A part of the motion, if the report has it.
    pub motion: Option<MotionCard>,
}

/// Why a text is no report of a calibration.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NoCalibrationRun {
    /// It is no JSON of that kind.
    #[error("it is no report of a calibration, as `palpate calibrate --report` writes one: {0}")]
    Json(#[from] serde_json::Error),
    /// It is a report of another kind or version.
    #[error("its format is `{0}`, but must be `{RUN_FORMAT}`")]
    Format(String),
    /// It has no motion.
    #[error(
        "it has no motion to draw; `palpate calibrate --report FILE` writes a report with one, --json does not"
    )]
    NoMotion,
    /// Its series differ in length, or a value is no number.
    #[error("the series of its motion differ in length")]
    Lengths,
}

impl CalibrationRun {
    /// Reads the JSON text of a report.
    ///
    /// # Errors
    /// No JSON, a report of another kind, or one without a motion.
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
    pub(super) fn of(
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
        Self {
            file: file.to_owned(),
            date: calibration.date.clone(),
            command: calibration.command.clone(),
            axis: calibration.axis.clone(),
            found: found.collect(),
            motion: run.and_then(|(_, run)| run.motion.clone()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            ("what".into(), "no report of a calibration"),
        ] {
            let error = CalibrationRun::parse(&wrong).unwrap_err().to_string();
            assert!(error.contains(said), "{error}");
        }
    }
}
