//! A calibration as a file: flat keys with their units, and two tables with the same keys.

use std::fmt::{self, Write as _};
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::calibrate::calibration::{Calibration, Known};
use crate::calibrate::quantity::Quantity;

/// Format version of calibrations that this crate reads and writes.
const FORMAT: i64 = 1;
const FORMAT_KEY: &str = "calibration_format";
const DEVIATIONS: &str = "standard_deviation";
const FOUND_BY: &str = "found_by";

/// Error in a calibrated device file, with its position.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{file}:{line}:{column}: {message}")]
#[non_exhaustive]
pub struct CalibrationError {
    /// Name of the file.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Byte range of the error.
    pub span: Range<usize>,
    /// Description of the error and the allowed values.
    pub message: String,
    /// The whole text, for showing the context.
    pub source_text: String,
}

/// Byte range and description of an error.
type Fault = (Range<usize>, String);

impl Calibration {
    /// Parses the text of a device file called `name`.
    ///
    /// # Errors
    /// Returns the first error with its line and column: invalid TOML, another format version, an unknown key, a value
    /// out of range, or a deviation or origin of a value that the file does not have.
    pub fn parse(name: &str, source: &str) -> Result<Self, CalibrationError> {
        read(source).map_err(|(span, message)| {
            let before = &source[..span.start.min(source.len())];
            let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
            CalibrationError {
                file: name.into(),
                line: before.matches('\n').count() + 1,
                column: before[line_start..].chars().count() + 1,
                span,
                message,
                source_text: source.into(),
            }
        })
    }
}

fn read(source: &str) -> Result<Calibration, Fault> {
    let table = DeTable::parse(source)
        .map_err(|error| (error.span().unwrap_or(0..0), error.message().to_owned()))?;
    let mut calibration = Calibration::default();
    check_format(table.get_ref())?;
    let mut deviations = None;
    let mut found_by = None;
    for (key, value) in table.get_ref() {
        match key.get_ref().as_ref() {
            FORMAT_KEY => {}
            "axis" => calibration.axis = Some(text(key.get_ref(), value)?),
            "date" => calibration.date = Some(text(key.get_ref(), value)?),
            "command" => calibration.command = Some(text(key.get_ref(), value)?),
            DEVIATIONS => deviations = Some(inner(key.get_ref(), value)?),
            FOUND_BY => found_by = Some(inner(key.get_ref(), value)?),
            other => {
                let quantity =
                    Quantity::of_key(other).ok_or_else(|| unknown(key.span(), other, true))?;
                let number = number(other, value)?;
                if !quantity.range().contains(number) {
                    let allowed = quantity.range().words();
                    let message = format!("{other} is {number}, but must be {allowed}");
                    return Err((value.span(), message));
                }
                let known = Known {
                    value: number,
                    standard_deviation: None,
                    found_by: None,
                };
                calibration.set(quantity, known);
            }
        }
    }
    for (key, value) in deviations.into_iter().flatten() {
        let known = known_of(&mut calibration, DEVIATIONS, key)?;
        let number = number(key.get_ref(), value)?;
        if !(number >= 0.0 && number.is_finite()) {
            let message = format!(
                "the standard deviation of {} is {number}, but must be a finite number of 0 or above",
                key.get_ref()
            );
            return Err((value.span(), message));
        }
        known.standard_deviation = Some(number);
    }
    for (key, value) in found_by.into_iter().flatten() {
        known_of(&mut calibration, FOUND_BY, key)?.found_by = Some(text(key.get_ref(), value)?);
    }
    Ok(calibration)
}

/// Checks the format version first, because a file of another version may have unknown keys.
fn check_format(table: &DeTable<'_>) -> Result<(), Fault> {
    let Some(value) = table.get(FORMAT_KEY) else {
        let message = format!(
            "the file has no `{FORMAT_KEY} = {FORMAT}`: it is not a calibrated device file of \
             `palpate calibrate`"
        );
        return Err((0..0, message));
    };
    let is_known = matches!(value.get_ref(), DeValue::Integer(number)
        if number.radix() == 10 && number.as_str() == FORMAT.to_string());
    if is_known {
        return Ok(());
    }
    let message = format!("{FORMAT_KEY} must be {FORMAT}, the version that this program reads");
    Err((value.span(), message))
}

fn unknown(span: Range<usize>, key: &str, is_top: bool) -> Fault {
    let quantities: Vec<_> = Quantity::ALL.into_iter().map(Quantity::key).collect();
    let known = quantities.join(", ");
    let others = if is_top {
        format!("{FORMAT_KEY}, axis, date, command, {DEVIATIONS}, {FOUND_BY}, ")
    } else {
        String::new()
    };
    (
        span,
        format!("unknown key {key}. Known here: {others}{known}"),
    )
}

fn known_of<'a>(
    calibration: &'a mut Calibration,
    table: &str,
    key: &Spanned<std::borrow::Cow<'_, str>>,
) -> Result<&'a mut Known, Fault> {
    let name = key.get_ref();
    let quantity = Quantity::of_key(name).ok_or_else(|| unknown(key.span(), name, false))?;
    calibration.known.get_mut(&quantity).ok_or_else(|| {
        let message = format!(
            "[{table}] has {name}, but the file has no value for it: write `{name} = VALUE` above the tables"
        );
        (key.span(), message)
    })
}

fn number(key: &str, value: &Spanned<DeValue<'_>>) -> Result<f64, Fault> {
    let parsed = match value.get_ref() {
        DeValue::Float(number) => number.as_str().parse().ok(),
        DeValue::Integer(number) if number.radix() == 10 => number.as_str().parse().ok(),
        _ => None,
    };
    parsed.ok_or_else(|| (value.span(), format!("{key} must be a number")))
}

fn text(key: &str, value: &Spanned<DeValue<'_>>) -> Result<String, Fault> {
    match value.get_ref() {
        DeValue::String(text) => Ok(text.clone().into_owned()),
        _ => Err((value.span(), format!("{key} must be a text in quotes"))),
    }
}

fn inner<'a, 'i>(key: &str, value: &'a Spanned<DeValue<'i>>) -> Result<&'a DeTable<'i>, Fault> {
    match value.get_ref() {
        DeValue::Table(table) => Ok(table),
        _ => Err((value.span(), format!("{key} must be a table, `[{key}]`"))),
    }
}

/// The text of the device file.
impl fmt::Display for Calibration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "# Calibration of a haptic device in its loop, for --device-file of `palpate`."
        )?;
        writeln!(f, "{FORMAT_KEY} = {FORMAT}")?;
        for (key, text) in [
            ("axis", &self.axis),
            ("date", &self.date),
            ("command", &self.command),
        ] {
            if let Some(text) = text {
                writeln!(f, "{key} = {}", quoted(text))?;
            }
        }
        f.write_char('\n')?;
        for (quantity, known) in &self.known {
            writeln!(f, "{} = {}", quantity.key(), decimal(known.value))?;
        }
        write_table(
            f,
            DEVIATIONS,
            |known| known.standard_deviation.map(decimal),
            self,
        )?;
        write_table(
            f,
            FOUND_BY,
            |known| known.found_by.as_deref().map(quoted),
            self,
        )
    }
}

fn write_table(
    f: &mut fmt::Formatter<'_>,
    name: &str,
    written: impl Fn(&Known) -> Option<String>,
    calibration: &Calibration,
) -> fmt::Result {
    let rows: Vec<_> = calibration
        .known
        .iter()
        .filter_map(|(quantity, known)| Some((quantity.key(), written(known)?)))
        .collect();
    if rows.is_empty() {
        return Ok(());
    }
    writeln!(f, "\n[{name}]")?;
    for (key, value) in rows {
        writeln!(f, "{key} = {value}")?;
    }
    Ok(())
}

/// Formats with the fewest digits that read back to the same bits; a TOML float has a point or an exponent.
fn decimal(value: f64) -> String {
    format!("{value:?}")
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault(lines: &str) -> String {
        let source = format!("calibration_format = 1\n{lines}");
        Calibration::parse("x.toml", &source)
            .expect_err(lines)
            .to_string()
    }

    #[test]
    fn every_quantity_is_written_and_read_back() {
        let mut calibration = Calibration {
            axis: Some("[1, 0]".into()),
            date: Some("2026-11-22".into()),
            command: Some("palpate calibrate --pipe \"quoted\"".into()),
            ..Calibration::default()
        };
        for (index, quantity) in Quantity::ALL.into_iter().enumerate() {
            let value = 1.0 / (3.0 + index as f64);
            calibration.set(quantity, Known::given(value, quantity.meaning()));
        }
        calibration.set(Quantity::Delay, Known::found(1e-9, 3e-7, "least squares"));
        assert_eq!(
            Calibration::parse("x", &calibration.to_string()),
            Ok(calibration)
        );
    }

    #[test]
    fn a_fault_has_its_place_and_what_is_allowed() {
        let unknown = fault("delay = 1\n");
        assert!(
            unknown.starts_with("x.toml:2:1: unknown key delay. Known here: "),
            "{unknown}"
        );
        for key in ["delay_s", "device_mass_kg", "standard_deviation"] {
            assert!(unknown.contains(key), "{unknown}");
        }
        let negative = fault("delay_s = 0.1\ndevice_mass_kg = -1\n");
        assert!(
            negative.starts_with("x.toml:3:18: device_mass_kg is -1, but must be "),
            "{negative}"
        );
        let text = fault("lag_s = \"0\"\n");
        assert!(text.contains("lag_s must be a number"), "{text}");
        let without = fault("lag_s = 0\n[standard_deviation]\ndelay_s = 0.1\n");
        assert!(
            without.starts_with("x.toml:4:1: [standard_deviation] has delay_s"),
            "{without}"
        );
        let deviation = fault("lag_s = 0\n[standard_deviation]\nlag_s = nan\n");
        assert!(
            deviation.contains("standard deviation of lag_s is NaN"),
            "{deviation}"
        );
        let twice = fault("lag_s = 0\nlag_s = 0\n");
        assert!(twice.starts_with("x.toml:3:1: "), "{twice}");
    }

    #[test]
    fn a_file_of_another_kind_is_refused_before_its_keys_are_read() {
        for source in ["", "scene_format = 1\n", "calibration_format = 2\nx = 1\n"] {
            let error = Calibration::parse("x.toml", source).expect_err(source);
            assert!(error.message.contains("calibration_format"), "{error}");
        }
    }
}
