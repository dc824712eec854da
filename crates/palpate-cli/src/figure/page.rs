//! The whole page: title, legend, grid of panels, small print.

use kuva::render::color::Color;
use kuva::render::figure::Figure as Grid;
use kuva::render::layout::{ComputedLayout, Layout};
use kuva::render::render::{Primitive, Scene, TextAnchor};

use super::legend::Legend;
use super::panel::{self, Drawn, LABEL_SIZE};
use super::stroke::Window;
use super::{Figure, Panel, axis, ink, text};

const TITLE_SIZE: u32 = 14;
/// How much broader bold letters are.
const BOLD: f64 = 1.17;
const HEAD_SIZE: u32 = 12;
const NOTE_SIZE: u32 = 10;

/// Free space around everything \[px\].
const EDGE: f64 = 10.0;
/// Right of each panel, half of the last number on its axis included \[px\].
const RIGHT: f64 = 16.0;
/// Above the frames of a row \[px\].
const ABOVE: f64 = 7.0;
/// Above the frames of a row where a note stands there \[px\].
const ABOVE_NOTED: f64 = 17.0;
/// Above the frames of the first row, for the heads of the columns \[px\].
const HEAD: f64 = 20.0;
/// Left of the frames of every column but the first \[px\].
const LEFT: f64 = 4.0;
/// Below the frames of a row without numbers \[px\].
const BELOW: f64 = 4.0;
/// Below the frames of the last row, for numbers and label \[px\].
const BELOW_LAST: f64 = 42.0;

/// Size of a frame \[px\] in a grid of so many columns.
fn frame(columns: usize) -> (f64, f64) {
    match columns {
        1 => (600.0, 130.0),
        2 => (330.0, 125.0),
        3 => (245.0, 120.0),
        _ => (205.0, 115.0),
    }
}

/// Draws a figure.
pub(super) fn scene(figure: &Figure) -> Scene {
    let columns = figure
        .rows
        .iter()
        .map(|row| row.panels.len())
        .max()
        .unwrap_or(0);
    let (grid, heads) = if columns == 0 {
        (None, 0.0)
    } else {
        grid(figure, columns)
    };
    let width = 2.0 * EDGE + grid.as_ref().map_or(400.0, |grid| grid.width);
    let left = EDGE + heads;

    let middle = 0.5 * (left + width - EDGE);
    let title = text::clean(&figure.title);
    let title = text::lines(&title, (width - left - EDGE) / BOLD, TITLE_SIZE);
    let legend = Legend::new(figure, width - left - EDGE);
    let note = text::clean(figure.footnote.as_deref().unwrap_or_default());
    let note = text::lines(&note, width - left - EDGE, NOTE_SIZE);

    let mut page = Scene::new(width, 0.0);
    page.font_family = Some(text::FAMILY.to_owned());
    page.text_color = Some("#111111".to_owned());
    let mut top = EDGE;
    for line in &title {
        let baseline = top + f64::from(TITLE_SIZE);
        page.add(words(
            line,
            middle,
            baseline,
            TITLE_SIZE,
            TextAnchor::Middle,
            None,
        ));
        top += 1.35 * f64::from(TITLE_SIZE);
    }
    if !title.is_empty() {
        top += 4.0;
    }
    legend.draw(&mut page, left, top);
    top += legend.height();
    if let Some(grid) = grid {
        page.defs.extend(grid.defs);
        page.add(Primitive::GroupStart {
            transform: Some(format!("translate({EDGE},{top})")),
            title: None,
            extra_attrs: Some(r#"stroke-linejoin="round""#.to_owned()),
        });
        page.elements.extend(grid.elements);
        page.add(Primitive::GroupEnd);
        top += grid.height;
    }
    for line in &note {
        top += 1.3 * f64::from(NOTE_SIZE);
        page.add(words(
            line,
            left,
            top,
            NOTE_SIZE,
            TextAnchor::Start,
            Some(ink::NOTE),
        ));
    }
    page.height = (top + EDGE).ceil();
    page
}

/// The panels with their notes and heads, and how far right of its edge the first frame begins.
fn grid(figure: &Figure, columns: usize) -> (Option<Scene>, f64) {
    let (width, height) = frame(columns);
    let x = axis::horizontal(figure);
    let pixel = (x.1 - x.0) / width;
    let empty = Panel::default();

    let mut drawn: Vec<Vec<Drawn>> = Vec::new();
    let mut layouts: Vec<Vec<Layout>> = Vec::new();
    for row in &figure.rows {
        let window = Window {
            x,
            y: axis::vertical(row),
            pixel,
        };
        let panels = (0..columns).map(|column| row.panels.get(column).unwrap_or(&empty));
        drawn.push(
            panels
                .map(|panel| panel::draw(panel, &window, height))
                .collect(),
        );
        layouts.push(
            (0..columns)
                .map(|_| panel::axes(&window, width, height, figure.x_decades))
                .collect(),
        );
    }

    // The widest of the first column's margins serves all of them, so that the frames align.
    for (row, layouts) in figure.rows.iter().zip(&mut layouts) {
        let label = text::clean(&row.y_label);
        layouts[0].y_label_wrap = Some(text::characters(&label, height, LABEL_SIZE));
        layouts[0].y_label = Some(label);
    }
    let computed: Vec<ComputedLayout> = layouts
        .iter()
        .map(|row| ComputedLayout::from_layout(&row[0]))
        .collect();
    let widest = |of: fn(&ComputedLayout) -> f64| computed.iter().map(of).fold(0.0, f64::max);
    let first_left = widest(|computed| computed.margin_left);
    let numbers = widest(|computed| computed.y_tick_label_px);

    let last = layouts.len() - 1;
    let mut row_heights = Vec::new();
    let mut tops = Vec::new();
    for (index, row) in layouts.iter_mut().enumerate() {
        let noted = drawn[index].iter().any(|drawn| !drawn.leaving.is_empty());
        let head = if index == 0 && !figure.columns.is_empty() {
            HEAD
        } else {
            0.0
        };
        let above = head + if noted { ABOVE_NOTED } else { ABOVE };
        let below = if index == last { BELOW_LAST } else { BELOW };
        for (column, layout) in row.iter_mut().enumerate() {
            layout.suppress_x_ticks = index != last;
            layout.suppress_y_ticks = column != 0;
            if index == last {
                layout.x_label = Some(text::clean(&figure.x_label));
            }
            layout.y_label_offset.0 = computed[index].y_tick_label_px - numbers;
            layout.force_margin_left = Some(if column == 0 { first_left } else { LEFT });
            layout.force_margin_right = Some(RIGHT);
            layout.force_margin_top = Some(above);
            layout.force_margin_bottom = Some(below);
        }
        row_heights.push(above + height + below);
        tops.push(above);
    }

    let notes: Vec<Vec<Option<String>>> = drawn
        .iter()
        .map(|row| row.iter().map(|drawn| note(drawn, width)).collect())
        .collect();
    let mut grid = Grid::new(layouts.len(), columns)
        .with_spacing(0.0)
        .with_padding(0.0)
        .with_plots(
            drawn
                .into_iter()
                .flatten()
                .map(|drawn| drawn.plots)
                .collect(),
        )
        .with_layouts(layouts.into_iter().flatten().collect());
    for (index, height) in row_heights.iter().enumerate() {
        grid = grid.with_row_height(index, *height);
    }
    for column in 0..columns {
        let left = if column == 0 { first_left } else { LEFT };
        grid = grid.with_col_width(column, left + width + RIGHT);
    }
    let mut scene = grid.render();

    let frame_left = |column: usize| first_left + column as f64 * (width + RIGHT + LEFT);
    for (column, head) in figure.columns.iter().take(columns).enumerate() {
        let middle = frame_left(column) + 0.5 * width;
        let head = text::clean(head);
        scene.add(words(
            &head,
            middle,
            14.0,
            HEAD_SIZE,
            TextAnchor::Middle,
            None,
        ));
    }
    let mut top = 0.0;
    for (index, row) in notes.into_iter().enumerate() {
        for (column, note) in row.into_iter().enumerate() {
            if let Some(note) = note {
                let (right, baseline) = (frame_left(column) + width, top + tops[index] - 4.0);
                let colour = Some(ink::NOTE);
                scene.add(words(
                    &note,
                    right,
                    baseline,
                    NOTE_SIZE,
                    TextAnchor::End,
                    colour,
                ));
            }
        }
        top += row_heights[index];
    }
    (Some(scene), first_left)
}

/// The note above a frame that some series leave, no wider than `room` \[px\].
fn note(drawn: &Drawn, room: f64) -> Option<String> {
    let arrow = |above: bool, below: bool| match (above, below) {
        (true, false) => "\u{25b2}",
        (false, true) => "\u{25bc}",
        _ => "\u{25b2}\u{25bc}",
    };
    let leaving = &drawn.leaving;
    if leaving.is_empty() {
        return None;
    }
    let above = leaving.iter().any(|&(_, above, _)| above);
    let below = leaving.iter().any(|&(_, _, below)| below);
    let plain = format!("{} off scale", arrow(above, below));
    if drawn.series == 1 || leaving.iter().any(|(name, ..)| name.is_empty()) {
        return Some(plain);
    }
    let named: Vec<String> = leaving
        .iter()
        .map(|(name, above, below)| format!("{name} {}", arrow(*above, *below)))
        .collect();
    let named = format!("off scale: {}", named.join(", "));
    if text::width(&named, NOTE_SIZE) <= room {
        Some(named)
    } else {
        Some(format!(
            "{plain}: {} of {} series",
            leaving.len(),
            drawn.series
        ))
    }
}

fn words(
    content: &str,
    x: f64,
    y: f64,
    size: u32,
    anchor: TextAnchor,
    colour: Option<&str>,
) -> Primitive {
    Primitive::Text {
        x,
        y,
        content: content.to_owned(),
        size,
        anchor,
        rotate: None,
        bold: size == TITLE_SIZE,
        color: colour.map(Color::from),
    }
}
