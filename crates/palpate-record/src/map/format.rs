//! Versions of the map format.

use super::row::COLUMNS;

/// A version of the format. Each contains the columns of the earlier ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Format {
    /// Bounces only.
    Bounces,
    /// Bounces and sustained contacts.
    BouncesAndStays,
}

impl Format {
    /// All versions, the newest first.
    pub const ALL: [Self; 2] = [Self::BouncesAndStays, Self::Bounces];

    /// Returns the name of the column that identifies format and version.
    #[must_use]
    pub fn column(self) -> &'static str {
        match self {
            Self::Bounces => "palpate_map_1",
            Self::BouncesAndStays => "palpate_map_2",
        }
    }

    /// Returns the version number.
    #[must_use]
    pub fn version(self) -> u32 {
        match self {
            Self::Bounces => 1,
            Self::BouncesAndStays => 2,
        }
    }

    /// Returns a description of the contents.
    #[must_use]
    pub fn contents(self) -> &'static str {
        match self {
            Self::Bounces => "bounces alone",
            Self::BouncesAndStays => "bounces and contacts that stay",
        }
    }

    /// Returns the columns of a line, in order.
    #[must_use]
    pub fn columns(self) -> &'static [&'static str] {
        match self {
            Self::Bounces => &COLUMNS[..COLUMNS.len() - 2],
            Self::BouncesAndStays => &COLUMNS,
        }
    }

    /// Returns the first line of a file, with its line end.
    pub(super) fn head(self) -> String {
        format!("{},{}\n", self.columns().join(","), self.column())
    }
}
