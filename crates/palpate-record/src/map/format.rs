//! The versions of the format.

use super::row::COLUMNS;

/// A version of the format; each has the columns of those before it, and more.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Format {
    /// Bounces alone.
    Bounces,
    /// Bounces, and contacts that stay.
    BouncesAndStays,
}

impl Format {
    /// All, the newest first.
    pub const ALL: [Self; 2] = [Self::BouncesAndStays, Self::Bounces];

    /// The column that names format and version.
    #[must_use]
    pub fn column(self) -> &'static str {
        match self {
            Self::Bounces => "palpate_map_1",
            Self::BouncesAndStays => "palpate_map_2",
        }
    }

    /// The version.
    #[must_use]
    pub fn version(self) -> u32 {
        match self {
            Self::Bounces => 1,
            Self::BouncesAndStays => 2,
        }
    }

    /// What a file of this format has, in words.
    #[must_use]
    pub fn contents(self) -> &'static str {
        match self {
            Self::Bounces => "bounces alone",
            Self::BouncesAndStays => "bounces and contacts that stay",
        }
    }

    /// The columns of a line, in order.
    #[must_use]
    pub fn columns(self) -> &'static [&'static str] {
        match self {
            Self::Bounces => &COLUMNS[..COLUMNS.len() - 2],
            Self::BouncesAndStays => &COLUMNS,
        }
    }

    /// The first line of a file, with its end.
    pub(super) fn head(self) -> String {
        format!("{},{}\n", self.columns().join(","), self.column())
    }
}
