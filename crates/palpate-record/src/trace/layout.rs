//! How a table of a recorded motion is laid out, where its header does not say it.

use std::fmt;

use crate::unit::{LengthUnit, TimeUnit};

/// Layout of a table that its header does not state, or that replaces it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Layout {
    /// Which column of the header holds a quantity: pairs of quantity and column. Quantities are `t`,
    /// `x`, `force`, and in a world `y`, `z`, `qw`, `qx`, `qy`, `qz`; of several devices with the name of
    /// the device, as `left.x`. A column is a name, or `#3` for the third.
    pub columns: Vec<(String, String)>,
    /// Unit of the positions; none: the unit in the unit row or in the column's name, else metres.
    pub unit: Option<LengthUnit>,
    /// Unit of the times; none: the unit in the unit row or in the column's name, else seconds.
    pub time_unit: Option<TimeUnit>,
    /// What separates the fields; none: what separates those of the header.
    pub delimiter: Option<Delimiter>,
    /// Whether numbers have a comma where others have a point.
    pub decimal_comma: bool,
    /// Whether samples without a value are left out; else they are refused.
    pub skip_missing: bool,
    /// How messages name these.
    pub ways: Ways,
}

impl Layout {
    /// The layout with positions in `unit`.
    #[must_use]
    pub fn in_unit(unit: Option<LengthUnit>) -> Self {
        Self {
            unit,
            ..Self::default()
        }
    }

    /// The pairs of a text such as `t=time,x=X`.
    ///
    /// # Errors
    /// A part without `=`, with nothing on one side of it, or a quantity that stands twice.
    pub fn parse_columns(text: &str) -> Result<Vec<(String, String)>, String> {
        let mut columns: Vec<(String, String)> = Vec::new();
        for part in text.split(',') {
            let pair = part
                .split_once('=')
                .map(|(key, name)| (key.trim(), name.trim()));
            let Some((key, name)) = pair.filter(|(key, name)| !key.is_empty() && !name.is_empty())
            else {
                return Err(format!(
                    "`{part}` must be QUANTITY=COLUMN, such as t=time,x=X"
                ));
            };
            if columns.iter().any(|(given, _)| given == key) {
                return Err(format!("`{key}` is given twice"));
            }
            columns.push((key.to_owned(), name.to_owned()));
        }
        Ok(columns)
    }

    /// The column that was named for a quantity.
    pub(super) fn column(&self, keys: &[String]) -> Option<&str> {
        let mut pairs = self.columns.iter();
        let found = pairs.find(|(key, _)| keys.contains(key));
        found.map(|(_, name)| name.as_str())
    }
}

/// What separates the fields of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Delimiter {
    /// `,`
    Comma,
    /// `;`
    Semicolon,
    /// A tab.
    Tab,
}

impl Delimiter {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Comma, Self::Semicolon, Self::Tab];

    /// Its byte.
    #[must_use]
    pub fn byte(self) -> u8 {
        match self {
            Self::Comma => b',',
            Self::Semicolon => b';',
            Self::Tab => b'\t',
        }
    }

    /// The delimiter with a name, `comma`, `semicolon` or `tab`, or the character itself.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "comma" | "," => Some(Self::Comma),
            "semicolon" | ";" => Some(Self::Semicolon),
            "tab" | "\t" | "\\t" => Some(Self::Tab),
            _ => None,
        }
    }
}

/// How messages name what a caller can say of a layout.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Ways {
    /// The caller can say nothing: the file has to be changed.
    #[default]
    Nothing,
    /// Flags of the program, as `--skip-missing`.
    Flags,
    /// Arguments of a function in Python, as `skip_missing=True`.
    Arguments,
}

/// Remedy in an error, with its effect; empty without one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Way {
    ways: Ways,
    out: Out,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Out {
    Columns,
    SkipMissing,
    DecimalComma,
    Units,
}

impl Ways {
    pub(super) const fn columns(self) -> Way {
        Way {
            ways: self,
            out: Out::Columns,
        }
    }

    pub(super) const fn skip_missing(self) -> Way {
        Way {
            ways: self,
            out: Out::SkipMissing,
        }
    }

    pub(super) const fn decimal_comma(self) -> Way {
        Way {
            ways: self,
            out: Out::DecimalComma,
        }
    }

    pub(super) const fn unit(self) -> Way {
        Way {
            ways: self,
            out: Out::Units,
        }
    }
}

impl fmt::Display for Way {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (flag, argument, does) = match self.out {
            Out::Columns => (
                "--columns t=NAME,x=NAME",
                "columns={\"t\": NAME, \"x\": NAME}",
                "says which columns they are (#2: the second)",
            ),
            Out::SkipMissing => (
                "--skip-missing",
                "skip_missing=True",
                "leaves such samples out",
            ),
            Out::DecimalComma => (
                "--decimal-comma",
                "decimal_comma=True",
                "reads numbers with a decimal comma",
            ),
            Out::Units => (
                "--unit and --time-unit",
                "unit= and time_unit=",
                "say the units of a table that does not agree with itself",
            ),
        };
        match self.ways {
            Ways::Nothing => Ok(()),
            Ways::Flags => write!(f, "; {flag} {does}"),
            Ways::Arguments => write!(f, "; {argument} {does}"),
        }
    }
}
