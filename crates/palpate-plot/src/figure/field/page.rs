//! Page layout of a field figure.

use kuva::render::color::Color;
use kuva::render::render::{Primitive, Scene, TextAnchor};

use super::panel::{self, PanelLayout, SPLIT, STRIP, swatch};
use super::{FieldFigure, Scale};
use crate::figure::element::{line, words};
use crate::figure::page::{Head, Page, foot};
use crate::figure::{Size, SizeError, ink, text};

const EDGE: f64 = 10.0;
/// Width left of the panels, for the name of the row, the axis label and its numbers `[px]`.
const LEFT: f64 = 74.0;
/// Gap between panels `[px]`.
const BETWEEN: f64 = 9.0;
/// Height below the panels of a row, without and with numbers `[px]`.
const BELOW: f64 = 8.0;
const BELOW_LAST: f64 = 36.0;
const HEAD_SIZE: u32 = 12;
const LABEL_SIZE: u32 = 11;
const NOTE_SIZE: u32 = 10;
const SWATCH: f64 = 16.0;
const LEGEND_LINE: f64 = 17.0;

/// Default width and height of a field: four fit on a page of 170 mm `[px]`.
const SIZE: f64 = 117.0;
/// Minimum width and height of a field `[px]`.
const LEAST: f64 = 40.0;

/// Returns the width of everything except the fields `[px]`.
fn beside(columns: f64) -> f64 {
    2.0 * EDGE + LEFT + columns * (STRIP + SPLIT + BETWEEN)
}

/// Draws a figure.
pub(crate) fn page(figure: &FieldFigure, size: Size) -> Result<Page, SizeError> {
    let columns = figure.rows.iter().map(|row| row.panels.len()).max();
    let columns = columns.unwrap_or(0).max(1) as f64;
    let within = |side: &'static str, asked: f64, other: f64, fields: f64| {
        let field = (asked - other) / fields;
        if field < LEAST {
            return Err(SizeError::too_small(side, asked, other + fields * LEAST));
        }
        Ok(field)
    };
    let mut field = match size.width {
        None => SIZE,
        Some(width) => within("width", width, beside(columns), columns)?,
    };
    let width = size
        .width
        .unwrap_or(beside(columns.max(3.0)) + columns.max(3.0) * field);
    if let Some(height) = size.height {
        let rows = figure.rows.len().max(1) as f64;
        let other = scene(figure, field, width).height - rows * field;
        // Fields are square: the scarcer dimension decides.
        field = field.min(within("height", height, other, rows)?);
    }
    let mut scene = scene(figure, field, width);
    scene.height = size.height.unwrap_or(scene.height);
    Ok(Page::from(scene))
}

fn scene(figure: &FieldFigure, size: f64, width: f64) -> Scene {
    let step = STRIP + SPLIT + size + BETWEEN;
    let mut page = Scene::new(width.ceil(), 0.0);
    page.font_family = Some(text::FAMILY.to_owned());
    page.text_color = Some("#111111".to_owned());
    let room = width - 2.0 * EDGE;
    let head = Head {
        title: &figure.title,
        subtitle: &figure.subtitle,
        middle: 0.5 * width,
        room,
    };
    let mut top = head.draw(&mut page, EDGE);
    let left = EDGE + LEFT;
    let last = figure.rows.len().saturating_sub(1);
    let mut scale: Option<&Scale> = None;
    for (index, row) in figure.rows.iter().enumerate() {
        if scale != Some(&row.scale) {
            top = legend(&mut page, figure, &row.scale, top + 6.0, room);
            scale = Some(&row.scale);
            top += f64::from(HEAD_SIZE) + 4.0;
            for (column, head) in figure.columns.iter().enumerate() {
                let middle = left + column as f64 * step + 0.5 * (STRIP + SPLIT + size);
                let at = (middle, top);
                page.add(words(
                    &text::clean(head),
                    at,
                    HEAD_SIZE,
                    TextAnchor::Middle,
                    None,
                ));
            }
            top += 6.0;
        }
        let middle = top + 0.5 * size;
        page.add(upright(&row.name, (EDGE + 9.0, middle), HEAD_SIZE, true));
        page.add(upright(
            &figure.y_label,
            (EDGE + 27.0, middle),
            LABEL_SIZE,
            false,
        ));
        for (column, panel) in row.panels.iter().enumerate() {
            let place = PanelLayout {
                left: left + column as f64 * step,
                top,
                size,
                x_numbers: index == last,
                y_numbers: column == 0,
            };
            panel::draw(&mut page, figure, &row.scale, panel, &place);
            if index == last {
                let bottom = top + size;
                let field = place.left + STRIP + SPLIT + 0.5 * size;
                let x_label = (field, bottom + 27.0);
                let label = text::clean(&figure.x_label);
                page.add(words(&label, x_label, LABEL_SIZE, TextAnchor::Middle, None));
                let zero = (place.left + 0.5 * STRIP, bottom + 27.0);
                let label = text::clean(&figure.zero_label);
                page.add(words(
                    &label,
                    zero,
                    NOTE_SIZE,
                    TextAnchor::Middle,
                    Some(ink::NOTE),
                ));
            }
        }
        top += size + if index == last { BELOW_LAST } else { BELOW };
    }
    top = foot(&mut page, &figure.footnote, EDGE, top, room);
    page.height = (top + EDGE).ceil();
    page
}

/// Draws the colours of a quantity, its border and the bounds, from `top` down. Returns its lower end.
fn legend(page: &mut Scene, figure: &FieldFigure, scale: &Scale, top: f64, room: f64) -> f64 {
    let mut pen = Pen {
        x: EDGE,
        baseline: top + 12.0,
        right: EDGE + room,
    };
    let name = text::clean(&scale.name);
    let (x, y) = pen.room_for(text::width(&name, LABEL_SIZE) * 1.1);
    page.add(words(&name, (x, y), LABEL_SIZE, TextAnchor::Start, None));
    for (colour, says) in &scale.steps {
        let says = text::clean(says);
        let (x, y) = pen.room_for(SWATCH + 4.0 + text::width(&says, NOTE_SIZE));
        page.add(Primitive::Rect {
            x,
            y: y - 10.0,
            width: SWATCH,
            height: 11.0,
            fill: Color::from(*colour),
            stroke: Some(Color::from(ink::FRAME)),
            stroke_width: Some(0.5),
            opacity: None,
        });
        let at = (x + SWATCH + 4.0, y);
        page.add(words(&says, at, NOTE_SIZE, TextAnchor::Start, None));
    }
    pen.break_line();
    let border = text::clean(&scale.border);
    let (x, y) = pen.room_for(SWATCH + 4.0 + text::width(&border, NOTE_SIZE));
    page.add(line(
        (x, y - 4.0),
        (x + SWATCH, y - 4.0),
        "#000000",
        1.2,
        None,
    ));
    let at = (x + SWATCH + 4.0, y);
    page.add(words(&border, at, NOTE_SIZE, TextAnchor::Start, None));
    let mut known: Vec<&str> = Vec::new();
    let rows = figure.rows.iter().filter(|row| row.scale == *scale);
    let panels = rows.flat_map(|row| &row.panels);
    for bound in panels.flat_map(|panel| &panel.bounds) {
        if known.contains(&&*bound.name) {
            continue;
        }
        known.push(&bound.name);
        let says = text::clean(&bound.name);
        let (x, y) = pen.room_for(26.0 + 4.0 + text::width(&says, NOTE_SIZE));
        page.add(swatch(bound.look, (x, y - 4.0), (x + 26.0, y - 4.0)));
        let at = (x + 30.0, y);
        page.add(words(&says, at, NOTE_SIZE, TextAnchor::Start, None));
    }
    pen.baseline + 6.0
}

/// Position of the next entry of a legend.
struct Pen {
    x: f64,
    baseline: f64,
    right: f64,
}

impl Pen {
    fn room_for(&mut self, width: f64) -> (f64, f64) {
        if self.x > EDGE && self.x + width > self.right {
            self.break_line();
        }
        let at = (self.x, self.baseline);
        self.x += width + 16.0;
        at
    }

    fn break_line(&mut self) {
        if self.x > EDGE {
            self.x = EDGE;
            self.baseline += LEGEND_LINE;
        }
    }
}

fn upright(content: &str, at: (f64, f64), size: u32, bold: bool) -> Primitive {
    Primitive::Text {
        x: at.0,
        y: at.1,
        content: text::clean(content),
        size,
        anchor: TextAnchor::Middle,
        rotate: Some(-90.0),
        bold,
        color: None,
    }
}
