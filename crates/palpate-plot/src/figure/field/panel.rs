//! One field with its frame.

use kuva::render::color::Color;
use kuva::render::render::{PathData, Primitive, Scene, TextAnchor};

use super::region::Grid;
use super::{Bound, FieldFigure, FieldPanel, Scale};
use crate::figure::element::line;
use crate::figure::ink;

/// Width of the strip at zero `[px]`.
pub(super) const STRIP: f64 = 7.0;
/// Gap between strip and field `[px]`.
pub(super) const SPLIT: f64 = 3.0;
/// Size of the numbers at the ticks `[px]`.
const TICK_SIZE: u32 = 10;
const TICK: f64 = 3.0;

/// Line styles of bounds: colour and dashes.
const LOOKS: [(&str, &str); 4] = [
    ("#000000", "2 2"),
    ("#a3195b", "6 2"),
    ("#a3195b", "2 1.5"),
    ("#000000", "7 2 1.5 2"),
];

/// Position of a panel, and which of its axes have numbers.
pub(super) struct PanelLayout {
    pub left: f64,
    pub top: f64,
    /// Width and height of the field `[px]`.
    pub size: f64,
    pub x_numbers: bool,
    pub y_numbers: bool,
}

/// Draws a panel.
pub(super) fn draw(
    page: &mut Scene,
    figure: &FieldFigure,
    scale: &Scale,
    panel: &FieldPanel,
    place: &PanelLayout,
) {
    let columns = panel.columns;
    if columns < 2 || panel.values.len() < columns {
        return;
    }
    let rows = panel.values.len() / columns;
    let grid = grid(place, columns, rows);
    let at = |row: usize, column: usize| row * columns + column;
    let step = |row, column| scale.step(panel.values[at(row, column)]);
    // Each step is painted over the ones below it, so that no paper shows between two.
    for (index, (colour, _)) in scale.steps.iter().enumerate() {
        let path = grid.fill(|row, column| step(row, column).is_some_and(|step| step >= index));
        if !path.is_empty() {
            page.add(filled(path, colour));
        }
    }
    // The gap separates the strip from the field.
    page.add(Primitive::Rect {
        x: place.left + STRIP,
        y: place.top,
        width: SPLIT,
        height: place.size,
        fill: Color::from("#ffffff"),
        stroke: None,
        stroke_width: None,
        opacity: None,
    });
    let marked = |row: usize, column: usize| panel.marked.get(at(row, column)) == Some(&true);
    // A casing below the line keeps the border visible on every colour.
    let border = grid.border(marked);
    if !border.is_empty() {
        page.add(stroked(border.clone(), "#ffffff", 2.6, None));
        page.add(stroked(border, "#000000", 1.2, None));
    }
    for bound in &panel.bounds {
        draw_bound(page, figure, bound, place, (columns - 1, rows));
    }
    for (left, width) in [
        (place.left, STRIP),
        (place.left + STRIP + SPLIT, place.size),
    ] {
        page.add(Primitive::Rect {
            x: left,
            y: place.top,
            width,
            height: place.size,
            fill: Color::None,
            stroke: Some(Color::from(ink::FRAME)),
            stroke_width: Some(0.8),
            opacity: None,
        });
    }
    ticks(page, figure, place, (columns - 1, rows));
}

fn grid(place: &PanelLayout, columns: usize, rows: usize) -> Grid {
    let field = place.left + STRIP + SPLIT;
    let width = place.size / (columns - 1) as f64;
    let mut x = vec![place.left];
    x.extend((0..columns).map(|column| field + column as f64 * width));
    // The strip's cells extend to the field; the gap is painted over them.
    let bottom = place.top + place.size;
    let height = place.size / rows as f64;
    Grid {
        x,
        y: (0..=rows).map(|row| bottom - row as f64 * height).collect(),
    }
}

/// Returns the distance of a value from the lower end of an axis, as a share of its length. Cells are centred on
/// their values.
fn share(range: (f64, f64), cells: usize, value: f64) -> f64 {
    let share = (value / range.0).ln() / (range.1 / range.0).ln();
    (share * (cells - 1) as f64 + 0.5) / cells as f64
}

fn draw_bound(
    page: &mut Scene,
    figure: &FieldFigure,
    bound: &Bound,
    place: &PanelLayout,
    cells: (usize, usize),
) {
    let height = share(figure.range, cells.1, bound.at);
    if !(0.0..=1.0).contains(&height) {
        return;
    }
    let y = place.top + place.size * (1.0 - height);
    let field = place.left + STRIP + SPLIT;
    let to = field + place.size * share(figure.range, cells.0, bound.to).clamp(0.0, 1.0);
    page.add(line((place.left, y), (to, y), "#ffffff", 2.8, None));
    let (colour, dashes) = LOOKS[bound.look % LOOKS.len()];
    page.add(line((place.left, y), (to, y), colour, 1.5, Some(dashes)));
}

/// Returns a bound as drawn in the legend.
pub(super) fn swatch(look: usize, from: (f64, f64), to: (f64, f64)) -> Primitive {
    let (colour, dashes) = LOOKS[look % LOOKS.len()];
    line(from, to, colour, 1.5, Some(dashes))
}

fn ticks(page: &mut Scene, figure: &FieldFigure, place: &PanelLayout, cells: (usize, usize)) {
    let field = place.left + STRIP + SPLIT;
    let bottom = place.top + place.size;
    for (number, value) in decades(figure.range).into_iter().enumerate() {
        let x = field + place.size * share(figure.range, cells.0, value);
        let y = bottom - place.size * share(figure.range, cells.1, value);
        page.add(line((x, bottom), (x, bottom + TICK), ink::FRAME, 0.8, None));
        page.add(line(
            (place.left - TICK, y),
            (place.left, y),
            ink::FRAME,
            0.8,
            None,
        ));
        // Numbers only at every second decade, and not at the ends, keep clear of each other.
        if place.x_numbers && number % 2 == 1 {
            page.add(words(
                &value.to_string(),
                (x, bottom + 12.0),
                TextAnchor::Middle,
            ));
        }
        if place.y_numbers {
            page.add(words(
                &value.to_string(),
                (place.left - 5.0, y + 3.0),
                TextAnchor::End,
            ));
        }
    }
}

/// Returns the powers of ten on the axis.
fn decades(range: (f64, f64)) -> Vec<f64> {
    let exponent = |value: f64| value.log10();
    let (mut power, last) = ((exponent(range.0) - 1e-9).ceil(), exponent(range.1) + 1e-9);
    let mut decades = Vec::new();
    while power <= last {
        #[expect(clippy::cast_possible_truncation, reason = "an exponent of ten")]
        let value = format!("1e{}", power as i32).parse().unwrap_or(f64::NAN);
        decades.push(value);
        power += 1.0;
    }
    decades
}

fn words(content: &str, at: (f64, f64), anchor: TextAnchor) -> Primitive {
    Primitive::Text {
        x: at.0,
        y: at.1,
        content: content.to_owned(),
        size: TICK_SIZE,
        anchor,
        rotate: None,
        bold: false,
        color: None,
    }
}

fn filled(d: String, colour: &str) -> Primitive {
    Primitive::Path(Box::new(PathData {
        d,
        fill: Some(Color::from(colour)),
        stroke: Color::None,
        stroke_width: 0.0,
        opacity: None,
        stroke_dasharray: None,
    }))
}

fn stroked(d: String, colour: &str, width: f64, dashes: Option<String>) -> Primitive {
    Primitive::Path(Box::new(PathData {
        d,
        fill: None,
        stroke: Color::from(colour),
        stroke_width: width,
        opacity: None,
        stroke_dasharray: dashes,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decades_are_exact_and_within_the_axis() {
        assert_eq!(decades((1e-3, 10.0)), [1e-3, 0.01, 0.1, 1.0, 10.0]);
        assert_eq!(decades((0.5, 30.0)), [1.0, 10.0]);
    }

    #[test]
    fn a_value_stands_in_the_middle_of_its_cell() {
        assert!((share((1e-3, 10.0), 5, 1e-3) - 0.1).abs() < 1e-9);
        assert!((share((1e-3, 10.0), 5, 0.1) - 0.5).abs() < 1e-9);
    }
}
