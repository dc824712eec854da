//! Lines, marks and words of a page, as elements of the drawing library.

use kuva::render::color::Color;
use kuva::render::render::{PathData, Primitive, TextAnchor};

use super::drawing::PagePoint;

/// A straight line.
pub(super) fn line(
    from: PagePoint,
    to: PagePoint,
    colour: &str,
    width: f64,
    dashes: Option<&str>,
) -> Primitive {
    Primitive::Line {
        x1: from.0,
        y1: from.1,
        x2: to.0,
        y2: to.1,
        stroke: Color::from(colour),
        stroke_width: width,
        stroke_dasharray: dashes.map(str::to_owned),
    }
}

/// Words on a baseline.
pub(super) fn words(
    content: &str,
    at: PagePoint,
    size: u32,
    anchor: TextAnchor,
    colour: Option<&str>,
) -> Primitive {
    Primitive::Text {
        x: at.0,
        y: at.1,
        content: content.to_owned(),
        size,
        anchor,
        rotate: None,
        bold: false,
        color: colour.map(Color::from),
    }
}

/// A disc, or a ring if it is not filled.
pub(super) fn disc((cx, cy): PagePoint, r: f64, colour: &str, filled: bool) -> Primitive {
    Primitive::Circle {
        cx,
        cy,
        r,
        fill: Color::from(if filled { colour } else { "#ffffff" }),
        fill_opacity: None,
        stroke: Some(Color::from(colour)),
        stroke_width: Some(1.4),
    }
}

/// A closed, filled outline through the positions.
pub(super) fn shape(places: &[PagePoint], colour: &str) -> Primitive {
    let mut d = String::new();
    for (number, (x, y)) in places.iter().enumerate() {
        let begin = if number == 0 { 'M' } else { 'L' };
        d += &format!("{begin}{x:.2} {y:.2}");
    }
    d.push('Z');
    Primitive::Path(Box::new(PathData {
        d,
        fill: Some(Color::from(colour)),
        stroke: Color::None,
        stroke_width: 0.0,
        opacity: None,
        stroke_dasharray: None,
    }))
}

/// The outline of a rectangle.
pub(super) fn frame((x, y): PagePoint, (width, height): (f64, f64), colour: &str) -> Primitive {
    Primitive::Rect {
        x,
        y,
        width,
        height,
        fill: Color::None,
        stroke: Some(Color::from(colour)),
        stroke_width: Some(0.8),
        opacity: None,
    }
}
