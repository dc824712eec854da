//! Parser of an input line: a sample, a header or a change.

use palpate_record::unit::LengthUnit;

use palpate_scene::LARGEST;

use crate::pipe::change::Change;

/// Format of the lines, from the flags or the header. It is never guessed from the text: `0,001` can be a time and a
/// position or a decimal comma, and a wrong guess would move a motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Format {
    /// Whether a time precedes the position.
    pub time: bool,
    /// Unit of the positions.
    pub unit: LengthUnit,
    /// Whether a flag set the unit.
    pub is_unit_given: bool,
    /// Whether the virtual force of the sample follows the position; only a header sets it.
    pub virtual_force: bool,
}

/// Name of the column of the virtual force.
const VIRTUAL_FORCE: &str = "virtual_force_n";

/// A valid line.
#[derive(Clone, Debug, PartialEq)]
pub enum Line {
    /// A sample.
    Sample {
        /// Time `[s]`, if the lines have one.
        time: Option<f64>,
        /// Device position `[m]`.
        position: f64,
        /// Virtual force on the object from this sample on, added to that of the contact `[N]`; 0 without the column.
        virtual_force: f64,
    },
    /// `set NAME=VALUE ...`: a change, or the reason for rejecting it.
    Set(Result<Change, String>),
}

/// Reason for rejecting a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// This line is invalid; the next one may be valid.
    Line(String),
    /// The lines do not have the requested format, so all following lines are invalid too.
    Stream(String),
}

impl Format {
    /// Returns the expected line for messages.
    #[must_use]
    pub fn shape(&self) -> String {
        let position = self.unit.position_column();
        let time = if self.time { "t_s," } else { "" };
        let (comma, force) = if self.virtual_force {
            (",", VIRTUAL_FORCE)
        } else {
            ("", "")
        };
        format!("`{time}{position}{comma}{force}`")
    }

    /// Parses the header in the first line. Returns `None` if the line is not a header. A word without a unit, such as
    /// the start-up message of a board, is a header that changes nothing.
    ///
    /// # Errors
    /// The header has unexpected columns.
    pub fn with_header(self, text: &str) -> Result<Option<Self>, String> {
        let names: Vec<&str> = text.split(',').map(str::trim).collect();
        let unit_of = |name: &str| {
            LengthUnit::ALL
                .into_iter()
                .find(|unit| unit.position_column() == name)
        };
        let are_names = names.iter().all(|name| is_named(name));
        if !are_names || text == "set" {
            return Ok(None);
        }
        if is_word(text) {
            return Ok(Some(self));
        }
        let (columns, virtual_force) = match names.as_slice() {
            [columns @ .., VIRTUAL_FORCE] => (columns, true),
            columns => (columns, false),
        };
        let (time, unit) = match columns {
            [position] => (false, unit_of(position)),
            ["t_s", position] => (true, unit_of(position)),
            _ => (false, None),
        };
        let Some(named) = unit else {
            return Err(
                "unknown columns in the header; allowed: `position_m` or `t_s,position_m`, with m, cm, mm or um, and \
                 virtual_force_n after it"
                    .into(),
            );
        };
        if self.time && !time {
            return Err("the header has a position only; --time requires `t_s,position_m`".into());
        }
        // A column called position_m may hold another unit, set by the flag.
        let unit = match named {
            LengthUnit::Metre => self.unit,
            _ if !self.is_unit_given || named == self.unit => named,
            _ => {
                return Err(format!(
                    "the header has the unit {named}, but --unit is {}",
                    self.unit
                ));
            }
        };
        Ok(Some(Self {
            time,
            unit,
            virtual_force,
            ..self
        }))
    }

    /// Parses a line.
    ///
    /// # Errors
    /// The line is neither a sample nor a change.
    pub fn parse(&self, text: &str) -> Result<Line, Refusal> {
        if text.is_empty() {
            return Err(Refusal::Line(format!(
                "the line is empty; expected {}",
                self.shape()
            )));
        }
        let mut words = text.split_whitespace();
        if words.next() == Some("set") {
            return Ok(Line::Set(words.collect::<Vec<_>>().as_slice().try_into()));
        }
        let fields: Vec<&str> = text.split(',').map(str::trim).collect();
        let numbers = fields
            .iter()
            .map(|field| field.parse::<f64>().map_err(|_| self.no_number(field)))
            .collect::<Result<Vec<f64>, _>>()?;
        let (columns, virtual_force) = match numbers.as_slice() {
            [columns @ .., force] if self.virtual_force => (columns, *force),
            columns => (columns, 0.0),
        };
        let (time, position) = match (self.time, columns) {
            (false, &[position]) => (None, position),
            (true, &[time, _]) if !time.is_finite() => {
                return Err(Refusal::Line("the time is not a finite number".into()));
            }
            (true, &[time, position]) => (Some(time), position),
            _ => return Err(Refusal::Stream(self.other_columns(text, fields.len()))),
        };
        let position = self.unit.metres(position);
        check_size("the position", position, "m")?;
        check_size(VIRTUAL_FORCE, virtual_force, "N")?;
        Ok(Line::Sample {
            time,
            position,
            virtual_force,
        })
    }

    fn no_number(&self, field: &str) -> Refusal {
        Refusal::Line(format!(
            "\"{}\" is not a number; expected {}",
            field.escape_debug(),
            self.shape()
        ))
    }

    /// Describes a line with another count of numbers.
    fn other_columns(&self, text: &str, count: usize) -> String {
        let shape = self.shape();
        match (self.time, count) {
            _ if self.virtual_force => {
                format!("`{text}` has {count} columns; the header requires {shape} on every line")
            }
            (false, _) => format!(
                "`{text}` has {count} columns; expected {shape}: write decimals with a point, as in 0.001, or add \
                 --time if the lines contain a time and a position"
            ),
            (true, 1) => format!(
                "`{text}` has 1 column; with --time, expected {shape}: put the time [s] before every position, or \
                 omit --time"
            ),
            (true, _) => format!(
                "`{text}` has {count} columns; with --time, expected {shape}: write decimals with \
                 a point, as in 0.5,0.001"
            ),
        }
    }
}

/// Rejects a finite value that no contact can be computed with.
pub(crate) fn check_size(name: &str, value: f64, unit: &str) -> Result<(), Refusal> {
    if value.is_finite() && value.abs() > LARGEST {
        return Err(Refusal::Line(format!(
            "{name} is {value:e} {unit}, but must be between -1e12 and 1e12 {unit}"
        )));
    }
    Ok(())
}

/// Whether a first line of names is one word without a unit.
pub(crate) fn is_word(text: &str) -> bool {
    is_named(text) && !text.contains(['_', ','])
}

/// Message for such a line, before lines of the `shape`.
pub(crate) fn word_in_words(text: &str, shape: &str) -> String {
    let text = text.escape_debug();
    format!(
        "line 1: \"{text}\" is taken as a header and gets no answer; expected {shape} from here on"
    )
}

/// Whether a field of the first line is a column name: it begins with a letter or a quote, and is neither a number
/// (such as `nan`) nor a change.
pub(crate) fn is_named(field: &str) -> bool {
    field.starts_with(|first: char| first.is_alphabetic() || first == '"')
        && field.parse::<f64>().is_err()
        && !field.contains('=')
}

#[cfg(test)]
mod tests {
    use super::*;

    const POSITIONS: Format = Format {
        time: false,
        unit: LengthUnit::Metre,
        is_unit_given: false,
        virtual_force: false,
    };
    const TIMES: Format = Format {
        time: true,
        ..POSITIONS
    };

    fn refused_stream(format: Format, text: &str) -> String {
        match format.parse(text) {
            Err(Refusal::Stream(why)) => why,
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn what_was_asked_for_decides_and_not_the_comma() {
        let sample = |time, position| {
            Ok(Line::Sample {
                time,
                position,
                virtual_force: 0.0,
            })
        };
        assert_eq!(POSITIONS.parse("0.001"), sample(None, 0.001));
        assert_eq!(TIMES.parse("0, 0.001"), sample(Some(0.0), 0.001));
        let comma = refused_stream(POSITIONS, "0,001");
        assert!(
            comma.contains("a point") && comma.contains("--time"),
            "{comma}"
        );
        let three = refused_stream(POSITIONS, "1,2,3");
        assert!(three.contains("3 columns"), "{three}");
        let four = refused_stream(TIMES, "0,5,0,001");
        assert!(
            four.contains("4 columns") && four.contains("a point"),
            "{four}"
        );
        assert!(refused_stream(TIMES, "0.001").contains("1 column"));
    }

    #[test]
    fn a_line_with_something_else_than_numbers_is_refused_alone() {
        for text in ["", "0.001,", "what", "1,x", "nan,0.1,"] {
            for format in [POSITIONS, TIMES] {
                let refused = format.parse(text);
                assert!(
                    matches!(refused, Err(Refusal::Line(_))),
                    "{text}: {refused:?}"
                );
            }
        }
    }

    #[test]
    fn units_are_those_of_the_flag_or_of_the_header() {
        let millimetres = Format {
            unit: LengthUnit::Millimetre,
            is_unit_given: true,
            ..POSITIONS
        };
        let in_metres = Line::Sample {
            time: None,
            position: 0.012,
            virtual_force: 0.0,
        };
        assert_eq!(millimetres.parse("12"), Ok(in_metres.clone()));
        let named = POSITIONS.with_header("position_mm").unwrap().unwrap();
        assert_eq!(named.parse("12"), Ok(in_metres));
        // The flag overrides the unit of the default column name.
        let usual = millimetres.with_header("position_m").unwrap().unwrap();
        assert_eq!(usual.unit, LengthUnit::Millimetre);
        let other = millimetres.with_header("position_cm").unwrap_err();
        assert!(
            other.contains("the unit cm") && other.contains("--unit is mm"),
            "{other}"
        );
    }

    #[test]
    fn a_header_adds_the_virtual_force() {
        let format = POSITIONS
            .with_header("t_s,position_mm,virtual_force_n")
            .unwrap()
            .unwrap();
        let sample = Line::Sample {
            time: Some(0.5),
            position: 0.001,
            virtual_force: -0.981,
        };
        assert_eq!(format.parse("0.5,1,-0.981"), Ok(sample));
        let short = refused_stream(format, "0.5,1");
        assert!(
            short.contains("requires `t_s,position_mm,virtual_force_n`"),
            "{short}"
        );
        assert!(POSITIONS.with_header("virtual_force_n").is_err());
    }

    #[test]
    fn a_number_beyond_all_contacts_is_named_with_its_bound() {
        for (format, text) in [(POSITIONS, "1e300"), (TIMES, "0,-1e13")] {
            let Err(Refusal::Line(why)) = format.parse(text) else {
                panic!("{text}");
            };
            assert!(why.starts_with("the position is"), "{why}");
            assert!(why.contains("between -1e12 and 1e12 m"), "{why}");
        }
        assert!(POSITIONS.parse("1e12").is_ok() && POSITIONS.parse("inf").is_ok());
    }

    #[test]
    fn a_header_says_whether_there_are_times() {
        assert_eq!(POSITIONS.with_header("0.001"), Ok(None));
        assert_eq!(POSITIONS.with_header("t_s,position_m"), Ok(Some(TIMES)));
        assert_eq!(TIMES.with_header("t_s, position_m"), Ok(Some(TIMES)));
        assert!(TIMES.with_header("position_m").is_err());
        // Columns of another unit or quantity would be taken for metres.
        for text in [
            "position_m,t_s",
            "t_s,position_m,force_n",
            "t_s",
            "position_in",
            "x_mm",
            "time,position",
        ] {
            assert!(POSITIONS.with_header(text).is_err(), "{text}");
        }
        // Column words and start-up messages of a board.
        for text in ["position", "ready", "position (m)"] {
            assert_eq!(POSITIONS.with_header(text), Ok(Some(POSITIONS)), "{text}");
        }
        // Cut-off lines are not headers.
        for text in ["set", "nan", "inf,0", "", "1,x_m", "set mass_kg=1"] {
            assert_eq!(POSITIONS.with_header(text), Ok(None), "{text}");
        }
    }
}
