//! Layout of a table of a recorded motion, where its header does not state it.

use std::fmt;

use crate::unit::{LengthUnit, TimeUnit};

/// Layout of a table that its header does not state, or that replaces it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Layout {
    /// Selected columns: pairs of quantity and column. Quantities are `t`, `x`, `force`, and in a world `y`, `z`,
    /// `qw`, `qx`, `qy`, `qz`; for several devices with the name of the device, such as `left.x`. A column is a name,
    /// or `#3` for the third one.
    pub columns: Vec<(String, String)>,
    /// Unit of the positions; `None`: the unit in the unit row or in the column's name, else metres.
    pub unit: Option<LengthUnit>,
    /// Unit of the times; `None`: the unit in the unit row or in the column's name, else seconds.
    pub time_unit: Option<TimeUnit>,
    /// Delimiter of the fields; `None`: the delimiter of the header.
    pub delimiter: Option<Delimiter>,
    /// Whether the decimal separator is a comma.
    pub decimal_comma: bool,
    /// Whether samples without a value are skipped; otherwise they are rejected.
    pub skip_missing: bool,
    /// Caller's interface, for remedies in messages.
    pub ways: Ways,
}

impl Layout {
    /// Returns the layout with positions in `unit`.
    #[must_use]
    pub fn in_unit(unit: Option<LengthUnit>) -> Self {
        Self {
            unit,
            ..Self::default()
        }
    }

    /// Parses the pairs of a text such as `t=time,x=X`.
    ///
    /// # Errors
    /// A part without `=`, an empty side, or a duplicate quantity.
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

    /// Returns the column selected for a quantity.
    pub(super) fn column(&self, keys: &[String]) -> Option<&str> {
        let mut pairs = self.columns.iter();
        let found = pairs.find(|(key, _)| keys.contains(key));
        found.map(|(_, name)| name.as_str())
    }
}

/// Delimiter of the fields of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Delimiter {
    /// `,`
    Comma,
    /// `;`
    Semicolon,
    /// Tab
    Tab,
}

impl Delimiter {
    /// All delimiters.
    pub const ALL: [Self; 3] = [Self::Comma, Self::Semicolon, Self::Tab];

    /// Returns the byte of the delimiter.
    #[must_use]
    pub fn byte(self) -> u8 {
        match self {
            Self::Comma => b',',
            Self::Semicolon => b';',
            Self::Tab => b'\t',
        }
    }

    /// Returns the delimiter with a name, `comma`, `semicolon` or `tab`, or the character itself.
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

/// Caller's interface for the layout, for remedies in messages.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Ways {
    /// The caller has no interface: the file must be changed.
    #[default]
    Nothing,
    /// Command-line flags, such as `--skip-missing`.
    Flags,
    /// Arguments of a Python function, such as `skip_missing=True`.
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
                "selects the columns (#2: the second)",
            ),
            Out::SkipMissing => ("--skip-missing", "skip_missing=True", "skips such samples"),
            Out::DecimalComma => (
                "--decimal-comma",
                "decimal_comma=True",
                "reads numbers with a decimal comma",
            ),
            Out::Units => (
                "--unit and --time-unit",
                "unit= and time_unit=",
                "set the units of an inconsistent table",
            ),
        };
        match self.ways {
            Ways::Nothing => Ok(()),
            Ways::Flags => write!(f, "; {flag} {does}"),
            Ways::Arguments => write!(f, "; {argument} {does}"),
        }
    }
}
