//! Colours, dashes and markers of the roles.

use kuva::plot::scatter::MarkerShape;

use super::Role;

/// Lines and text of the frame.
pub(super) const FRAME: &str = "#333333";
/// Lines behind the data.
pub(super) const GRID: &str = "#e9e9e9";
/// The line through zero.
pub(super) const ZERO: &str = "#9a9a9a";
/// Notes and small print.
pub(super) const NOTE: &str = "#555555";

/// Colour, dashes and marker of one role.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ink {
    /// Colour as `#rrggbb`.
    pub colour: &'static str,
    /// Lengths of dashes and gaps `[px]`; empty for a line without gaps.
    pub dashes: &'static [f64],
    /// Width of the line `[px]`.
    pub width: f64,
    /// Shape of a single sample.
    pub marker: MarkerShape,
}

const REFERENCE: Ink = Ink {
    colour: "#d2d2d2",
    dashes: &[],
    width: 5.5,
    marker: MarkerShape::Circle,
};

const BESIDE_REFERENCE: Ink = Ink {
    colour: "#a6a6a6",
    width: 2.8,
    ..REFERENCE
};

const DEVICE: Ink = Ink {
    colour: "#000000",
    dashes: &[11.0, 3.0],
    width: 1.0,
    marker: MarkerShape::Circle,
};

const RECORDED: Ink = Ink {
    dashes: &[],
    width: 1.1,
    ..DEVICE
};

const MARK: Ink = Ink {
    dashes: &[1.5, 2.5],
    width: 1.1,
    ..DEVICE
};

/// Width of a line with the role `Beside` `[px]`.
const BESIDE: f64 = 0.8;

/// Colours of Okabe and Ito. The yellow, the last, is darkened for contrast with white paper. Neighbours differ in
/// lightness.
const COLOURS: [&str; 8] = [
    "#0072b2", "#e69f00", "#000000", "#cc79a7", "#d55e00", "#56b4e9", "#009e73", "#c4b400",
];

const DASHES: [&[f64]; 8] = [
    &[],
    &[10.0, 3.5],
    &[2.0, 2.0],
    &[9.0, 2.5, 2.0, 2.5],
    &[3.5, 2.5],
    &[12.0, 3.0, 4.0, 3.0],
    &[6.0, 2.0, 1.5, 2.0, 1.5, 2.0],
    &[14.0, 3.0],
];

const MARKERS: [MarkerShape; 7] = [
    MarkerShape::Circle,
    MarkerShape::Square,
    MarkerShape::Triangle,
    MarkerShape::Diamond,
    MarkerShape::TriangleDown,
    MarkerShape::Cross,
    MarkerShape::Plus,
];

pub(super) fn ink(role: Role) -> Ink {
    match role {
        Role::Reference => REFERENCE,
        Role::BesideReference => BESIDE_REFERENCE,
        Role::Device => DEVICE,
        Role::Recorded => RECORDED,
        Role::Mark => MARK,
        Role::Beside(number) => Ink {
            width: BESIDE,
            ..ink(Role::Compared(number))
        },
        Role::Compared(number) => Ink {
            colour: COLOURS[number % COLOURS.len()],
            // Each repetition of the colours shifts the dashes by one, so that the combination is new.
            dashes: DASHES[(number + number / COLOURS.len()) % DASHES.len()],
            width: 1.7,
            marker: MARKERS[number % MARKERS.len()],
        },
    }
}

/// Returns the dashes in the form of `stroke-dasharray`; `None` for a line without gaps.
pub(super) fn dash_array(dashes: &[f64]) -> Option<String> {
    let lengths: Vec<String> = dashes.iter().map(f64::to_string).collect();
    (!lengths.is_empty()).then(|| lengths.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the relative luminance of a colour, 0 for black and 1 for white.
    fn luminance(colour: &str) -> f64 {
        let part = |at: usize| {
            let value = f64::from(u8::from_str_radix(&colour[at..at + 2], 16).unwrap()) / 255.0;
            if value <= 0.040_45 {
                value / 12.92
            } else {
                ((value + 0.055) / 1.055).powf(2.4)
            }
        };
        0.2126 * part(1) + 0.7152 * part(3) + 0.0722 * part(5)
    }

    #[test]
    fn the_first_64_look_different() {
        for number in 0..64 {
            for other in 0..number {
                let (a, b) = (ink(Role::Compared(number)), ink(Role::Compared(other)));
                assert!(
                    (a.colour, a.dashes) != (b.colour, b.dashes),
                    "{number} and {other}"
                );
            }
        }
    }

    #[test]
    fn the_first_eight_differ_in_their_dashes_alone() {
        for number in 0..8 {
            for other in 0..number {
                let dashes = |number| ink(Role::Compared(number)).dashes;
                assert_ne!(dashes(number), dashes(other));
            }
        }
    }

    #[test]
    fn neighbours_differ_in_lightness() {
        for pair in COLOURS.windows(2) {
            let (a, b) = (luminance(pair[0]), luminance(pair[1]));
            assert!((a - b).abs() > 0.05, "{pair:?}: {a:.2} and {b:.2}");
        }
    }

    #[test]
    fn every_colour_stands_out_from_paper() {
        for colour in COLOURS {
            assert!(1.05 / (luminance(colour) + 0.05) > 2.0, "{colour}");
        }
    }
}
