//! The whole page: title, legend, grids of panels, small print.

use kuva::render::color::Color;
use kuva::render::render::{Primitive, Scene, TextAnchor};

use super::grid::{Common, Level, Planned};
use super::legend::Legend;
use super::{Sheet, axis, ink, text};

const TITLE_SIZE: u32 = 14;
/// How much broader bold letters are.
const BOLD: f64 = 1.17;
pub(super) const NOTE_SIZE: u32 = 10;

/// Free space around everything \[px\].
const EDGE: f64 = 10.0;

/// Size of a frame \[px\] where so many stand side by side.
fn frame(columns: f64) -> (f64, f64) {
    match columns {
        ..2.0 => (600.0, 130.0),
        ..3.0 => (330.0, 125.0),
        ..4.0 => (245.0, 120.0),
        _ => (205.0, 115.0),
    }
}

/// Draws a figure.
pub(super) fn scene(sheet: &Sheet) -> Scene {
    let (grids, heads) = grids(sheet);
    let width = 2.0 * EDGE
        + if grids.is_empty() {
            400.0
        } else {
            widths(&grids).fold(0.0, f64::max)
        };
    let left = EDGE + heads;

    let middle = 0.5 * (left + width - EDGE);
    let title = text::clean(&sheet.title);
    let title = text::lines(&title, (width - left - EDGE) / BOLD, TITLE_SIZE);
    let legend = Legend::new(sheet, width - left - EDGE);
    let note = text::clean(sheet.footnote.as_deref().unwrap_or_default());
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
    for line in grids {
        let mut x = EDGE;
        let mut height = 0.0_f64;
        for grid in line {
            page.defs.extend(grid.defs);
            page.add(Primitive::GroupStart {
                transform: Some(format!("translate({x},{top})")),
                title: None,
                extra_attrs: Some(r#"stroke-linejoin="round""#.to_owned()),
            });
            page.elements.extend(grid.elements);
            page.add(Primitive::GroupEnd);
            x += grid.width;
            height = height.max(grid.height);
        }
        top += height;
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

/// The lines of grids, and how far right of its edge the first frame begins.
fn grids(sheet: &Sheet) -> (Vec<Vec<Scene>>, f64) {
    let common = |height| Common {
        x: axis::horizontal(sheet),
        x_label: &sheet.x_label,
        x_decades: sheet.x_decades,
        height,
    };
    let plan = |height: f64| -> Vec<Vec<Planned>> {
        sheet
            .lines
            .iter()
            .map(|line| {
                line.iter()
                    .filter_map(|grid| Planned::new(grid, common(height)))
                    .collect::<Vec<_>>()
            })
            .filter(|line| !line.is_empty())
            .collect()
    };
    let side_by_side = |line: &Vec<Planned>| line.iter().map(Planned::columns).sum::<f64>();
    let most = plan(100.0).iter().map(side_by_side).fold(0.0, f64::max);
    let (frame_width, height) = frame(most);
    let lines = plan(height);
    // Grids below each other begin their frames together.
    let left = |place: usize| {
        let grids = lines.iter().filter_map(|line| line.get(place));
        grids.map(|grid| grid.left).fold(0.0, f64::max)
    };
    let margins = |line: &Vec<Planned>| -> f64 {
        let each = line.iter().enumerate();
        each.map(|(place, grid)| left(place) + grid.between()).sum()
    };
    let width = lines
        .iter()
        .map(|line| margins(line) + side_by_side(line) * frame_width)
        .fold(0.0, f64::max);
    let drawn = lines
        .iter()
        .map(|line| {
            let frames = (width - margins(line)) / side_by_side(line);
            let wants = |of: fn(Level) -> bool| line.iter().any(|grid| of(grid.level()));
            let level = Level {
                heads: wants(|level| level.heads),
                words: wants(|level| level.words),
            };
            let each = line.iter().enumerate();
            each.map(|(place, grid)| grid.draw(left(place), frames, level))
                .collect()
        })
        .collect();
    (drawn, left(0))
}

/// Width of each line \[px\].
fn widths(lines: &[Vec<Scene>]) -> impl Iterator<Item = f64> {
    lines
        .iter()
        .map(|line| line.iter().map(|grid| grid.width).sum())
}

pub(super) fn words(
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
