//! The page of a figure of fields.

use kuva::render::color::Color;
use kuva::render::render::{Primitive, Scene, TextAnchor};

use super::panel::{self, Place, SIZE, SPLIT, STRIP, line, swatch};
use super::{FieldFigure, Scale};
use crate::{ink, text};

const EDGE: f64 = 10.0;
/// Left of the panels, for the name of the row, the axis' label and its numbers \[px\].
const LEFT: f64 = 74.0;
/// Between panels \[px\].
const BETWEEN: f64 = 9.0;
/// Below the panels of a row without numbers, and with them \[px\].
const BELOW: f64 = 8.0;
const BELOW_LAST: f64 = 36.0;
const TITLE_SIZE: u32 = 14;
const HEAD_SIZE: u32 = 12;
const LABEL_SIZE: u32 = 11;
const NOTE_SIZE: u32 = 10;
const SWATCH: f64 = 16.0;
const LEGEND_LINE: f64 = 17.0;

/// Draws a figure.
pub(crate) fn scene(figure: &FieldFigure) -> Scene {
    let columns = figure
        .rows
        .iter()
        .map(|row| row.panels.len())
        .max()
        .unwrap_or(0);
    let step = STRIP + SPLIT + SIZE + BETWEEN;
    let width = (2.0 * EDGE + LEFT + columns.max(3) as f64 * step).ceil();
    let mut page = Scene::new(width, 0.0);
    page.font_family = Some(text::FAMILY.to_owned());
    page.text_color = Some("#111111".to_owned());
    let room = width - 2.0 * EDGE;
    let mut top = EDGE;
    for title in text::lines(&text::clean(&figure.title), room / 1.17, TITLE_SIZE) {
        top += f64::from(TITLE_SIZE);
        page.add(words(
            &title,
            (EDGE, top),
            TITLE_SIZE,
            TextAnchor::Start,
            None,
        ));
        top += 6.0;
    }
    let left = EDGE + LEFT;
    let last = figure.rows.len().saturating_sub(1);
    let mut scale: Option<&Scale> = None;
    for (index, row) in figure.rows.iter().enumerate() {
        if scale != Some(&row.scale) {
            top = legend(&mut page, figure, &row.scale, top + 6.0, room);
            scale = Some(&row.scale);
            top += f64::from(HEAD_SIZE) + 4.0;
            for (column, head) in figure.columns.iter().enumerate() {
                let middle = left + column as f64 * step + 0.5 * (STRIP + SPLIT + SIZE);
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
        let middle = top + 0.5 * SIZE;
        page.add(upright(&row.name, (EDGE + 9.0, middle), HEAD_SIZE, true));
        page.add(upright(
            &figure.y_label,
            (EDGE + 27.0, middle),
            LABEL_SIZE,
            false,
        ));
        for (column, panel) in row.panels.iter().enumerate() {
            let place = Place {
                left: left + column as f64 * step,
                top,
                x_numbers: index == last,
                y_numbers: column == 0,
            };
            panel::draw(&mut page, figure, &row.scale, panel, &place);
            if index == last {
                let bottom = top + SIZE;
                let field = place.left + STRIP + SPLIT + 0.5 * SIZE;
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
        top += SIZE + if index == last { BELOW_LAST } else { BELOW };
    }
    for note in text::lines(&text::clean(&figure.footnote), room, NOTE_SIZE) {
        top += 1.3 * f64::from(NOTE_SIZE);
        let at = (EDGE, top);
        page.add(words(
            &note,
            at,
            NOTE_SIZE,
            TextAnchor::Start,
            Some(ink::NOTE),
        ));
    }
    page.height = (top + EDGE).ceil();
    page
}

/// The colours of a quantity, its border and the bounds, from `top` on; where it ends.
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

/// Where the next entry of a legend goes.
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

fn words(
    content: &str,
    at: (f64, f64),
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
        bold: size == TITLE_SIZE,
        color: colour.map(Color::from),
    }
}
