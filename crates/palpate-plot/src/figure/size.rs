//! Size of a figure on paper or on a slide.

use std::fmt;
use std::str::FromStr;

/// Pixels of a figure per millimetre: 96 to the inch, as in SVG.
const PER_MILLIMETRE: f64 = 96.0 / 25.4;

/// Minimum and maximum side of a requested size `[mm]`.
const SIDES: (f64, f64) = (20.0, 2000.0);

/// Size of a figure. Unset sides follow from the content of the figure.
///
/// Words keep their size, 11 to 14 px (8 to 10.5 pt), at any figure size; frames take the remaining space. A
/// [`Drawing`](crate::figure::Drawing) is scaled as a whole.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Size {
    pub(crate) width: Option<f64>,
    pub(crate) height: Option<f64>,
}

impl Size {
    /// The natural size of the figure.
    pub const NATURAL: Self = Self {
        width: None,
        height: None,
    };

    /// Named sizes with width and height `[mm]`.
    pub const NAMED: [(&'static str, f64, Option<f64>); 3] = [
        ("column", 85.0, None),
        ("page", 170.0, None),
        ("slide", 254.0, Some(142.875)),
    ];

    /// Returns this size with another height `[mm]`.
    #[cfg(feature = "results")]
    pub(crate) fn with_height(self, millimetres: f64) -> Self {
        Self {
            height: Some(PER_MILLIMETRE * millimetres),
            ..self
        }
    }

    fn of_millimetres(width: f64, height: Option<f64>) -> Self {
        Self {
            width: Some(PER_MILLIMETRE * width),
            height: height.map(|height| PER_MILLIMETRE * height),
        }
    }
}

impl FromStr for Size {
    type Err = SizeError;

    /// Parses `column` (85 mm wide), `page` (170 mm wide), `slide` (254 x 142.9 mm), or width and height in mm,
    /// `120x80`.
    fn from_str(text: &str) -> Result<Self, SizeError> {
        if let Some((_, width, height)) = Self::NAMED.into_iter().find(|(name, ..)| *name == text) {
            return Ok(Self::of_millimetres(width, height));
        }
        let side = |text: &str| {
            let side: f64 = text.trim().parse().ok()?;
            (SIDES.0..=SIDES.1).contains(&side).then_some(side)
        };
        text.split_once('x')
            .and_then(|(width, height)| {
                Some(Self::of_millimetres(side(width)?, Some(side(height)?)))
            })
            .ok_or_else(|| SizeError::Unknown(text.to_owned()))
    }
}

/// Reason for rejecting a size.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum SizeError {
    /// The text is not a size.
    Unknown(String),
    /// The figure does not fit.
    TooSmall {
        /// `width` or `height`.
        side: &'static str,
        /// Requested length `[mm]`.
        asked: f64,
        /// Minimum length of this figure `[mm]`.
        least: f64,
    },
}

impl SizeError {
    /// Creates the error for a side that is too small, from lengths in pixels.
    pub(crate) fn too_small(side: &'static str, asked: f64, least: f64) -> Self {
        Self::TooSmall {
            side,
            asked: asked / PER_MILLIMETRE,
            least: (least / PER_MILLIMETRE).ceil(),
        }
    }
}

impl fmt::Display for SizeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(_) => {
                let named: Vec<&str> = Size::NAMED.iter().map(|(name, ..)| *name).collect();
                write!(
                    f,
                    "a size is {}, or width x height in mm from {} to {}, such as 120x80",
                    named.join(", "),
                    SIDES.0,
                    SIDES.1
                )
            }
            Self::TooSmall { side, asked, least } => write!(
                f,
                "the {side} of {asked:.0} mm is too small for this figure, which needs {least:.0} mm"
            ),
        }
    }
}

impl std::error::Error for SizeError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_names_or_millimetres() {
        assert_eq!(
            "25.4x50.8".parse(),
            Ok(Size {
                width: Some(96.0),
                height: Some(192.0)
            })
        );
        let page: Size = "page".parse().unwrap();
        assert!((page.width.unwrap() - 642.5).abs() < 0.1 && page.height.is_none());
        for wrong in [
            "", "poster", "120", "x", "19x80", "120x80x", "nanx80", "1e9x80", "-50x50",
        ] {
            let error = wrong.parse::<Size>().unwrap_err();
            assert!(error.to_string().contains("column, page, slide"), "{wrong}");
        }
    }
}
