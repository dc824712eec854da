//! Page layout of a dot plot.

use kuva::render::render::{Scene, TextAnchor};

use super::{Dot, DotFigure, DotPanel};
use crate::figure::element::{disc, frame, line, shape, words};
use crate::figure::page::{Head, Page, foot};
use crate::figure::{Size, SizeError, axis, ink, text};

const EDGE: f64 = 10.0;
const LABEL_SIZE: u32 = 12;
const NAME_SIZE: u32 = 11;
const NOTE_SIZE: u32 = 10;
/// Height of a line of the legend `[px]`.
const LEGEND_LINE: f64 = 19.0;
/// Minimum gap between two numbers of an axis `[px]`.
const BETWEEN_NUMBERS: f64 = 6.0;
/// Gap between panels side by side `[px]`.
const BETWEEN: f64 = 18.0;
/// Default and minimum height of the line of one dot `[px]`.
const LINE: f64 = 16.0;
const MIN_LINE: f64 = 9.0;
/// Default and minimum width of the inside of a panel `[px]`.
const PANEL: f64 = 190.0;
const MIN_PANEL: f64 = 70.0;
/// Height below the last panel of a column, for numbers and label `[px]`.
const BELOW: f64 = 34.0;
const DOT: f64 = 3.6;
/// Maximum number of panels side by side.
const MAX_COLUMNS: usize = 3;

/// Layout parameters common to all panels.
struct Plan {
    columns: usize,
    left: f64,
    panel: f64,
    line: f64,
    /// Logarithms of the ends of the axis.
    range: (f64, f64),
}

/// Draws a figure.
pub(crate) fn page(figure: &DotFigure, size: Size) -> Result<Page, SizeError> {
    let names = (figure.panels.iter().flat_map(|panel| &panel.dots))
        .map(|dot| text::width(&text::clean(&dot.name), NAME_SIZE))
        .fold(0.0, f64::max);
    let left = EDGE + names + 8.0;
    let width_of = |columns: usize, panel: f64| {
        left + columns as f64 * (panel + BETWEEN) - BETWEEN + 2.0 * EDGE
    };
    let most = figure.panels.len().clamp(1, MAX_COLUMNS);
    let (columns, panel) = match size.width {
        None => (most, PANEL),
        Some(width) => {
            // As many panels side by side as keep a readable axis.
            let columns = (1..=most)
                .rev()
                .find(|columns| width_of(*columns, 0.7 * PANEL) <= width)
                .unwrap_or(1);
            (columns, (width - width_of(columns, 0.0)) / columns as f64)
        }
    };
    if panel < MIN_PANEL {
        let asked = size.width.unwrap_or_default();
        return Err(SizeError::too_small("width", asked, width_of(1, MIN_PANEL)));
    }
    let mut plan = Plan {
        columns,
        left,
        panel,
        line: LINE,
        range: range(figure),
    };
    let scene = scene(figure, &plan);
    let Some(height) = size.height else {
        return Ok(Page::from(scene));
    };
    let lines: f64 = figure.panels.chunks(columns).map(lines).sum();
    plan.line += (height - scene.height) / lines.max(1.0);
    if plan.line < MIN_LINE {
        let least = scene.height + (MIN_LINE - LINE) * lines;
        return Err(SizeError::too_small("height", height, least));
    }
    let mut scene = self::scene(figure, &plan);
    scene.height = height;
    Ok(Page::from(scene))
}

/// Returns the number of dots of the longest of the panels side by side.
fn lines(panels: &[DotPanel]) -> f64 {
    panels
        .iter()
        .map(|panel| panel.dots.len())
        .max()
        .unwrap_or(0) as f64
}

/// Returns the range of powers of ten that contains all drawn values.
fn range(figure: &DotFigure) -> (f64, f64) {
    let values = figure.panels.iter().flat_map(|panel| {
        let dots = panel.dots.iter().filter_map(|dot| dot.value);
        dots.chain(panel.floor)
    });
    let shown = values.filter(|value| *value > 0.0 && value.is_finite());
    let logs = shown.map(|value| value.min(figure.largest).log10());
    let (low, high) = axis::union(logs.map(|log| (log, log))).unwrap_or((0.0, 1.0));
    (low.floor(), high.ceil().max(low.floor() + 1.0))
}

fn scene(figure: &DotFigure, plan: &Plan) -> Scene {
    let width = plan.left + plan.columns as f64 * (plan.panel + BETWEEN) - BETWEEN + 2.0 * EDGE;
    let mut page = Scene::new(width, 0.0);
    page.font_family = Some(text::FAMILY.to_owned());
    page.text_color = Some("#111111".to_owned());
    let head = Head {
        title: &figure.title,
        subtitle: &figure.subtitle,
        middle: 0.5 * width,
        room: width - 2.0 * EDGE,
    };
    let mut top = head.draw(&mut page, EDGE);
    top = legend(&mut page, figure, (plan.left, width - EDGE), top);
    let rows: Vec<&[DotPanel]> = figure.panels.chunks(plan.columns).collect();
    for (number, row) in rows.iter().enumerate() {
        let heads: Vec<Vec<String>> = (row.iter())
            .map(|panel| text::lines(&text::clean(&panel.head), plan.panel, NAME_SIZE))
            .collect();
        let tallest = heads.iter().map(Vec::len).max().unwrap_or(0) as f64;
        top += 8.0 + 13.0 * tallest;
        for (column, (panel, head)) in row.iter().zip(&heads).enumerate() {
            let left = plan.left + column as f64 * (plan.panel + BETWEEN);
            for (line, words_of) in head.iter().rev().enumerate() {
                let at = (left, top - 5.0 - 13.0 * line as f64);
                page.add(words(words_of, at, NAME_SIZE, TextAnchor::Start, None));
            }
            // A panel without another panel below it shows the numbers of the axis.
            let is_last = rows.get(number + 1).is_none_or(|next| next.len() <= column);
            draw(&mut page, figure, plan, panel, (left, top), is_last);
            if column == 0 {
                for (line, dot) in panel.dots.iter().enumerate() {
                    let at = (left - 6.0, top + (line as f64 + 0.5) * plan.line + 4.0);
                    let name = text::clean(&dot.name);
                    page.add(words(&name, at, NAME_SIZE, TextAnchor::End, None));
                }
            }
        }
        top += lines(row) * plan.line;
    }
    top += BELOW;
    top = foot(&mut page, &figure.footnote, EDGE, top, width - 2.0 * EDGE);
    page.height = (top + EDGE).ceil();
    page
}

/// Draws the legend entries of line and ring, side by side if both fit between `left` and `right`. Returns its lower
/// end.
fn legend(page: &mut Scene, figure: &DotFigure, (left, right): (f64, f64), mut top: f64) -> f64 {
    let mut x = left;
    if figure.panels.iter().any(|panel| panel.floor.is_some()) {
        let middle = x + 8.0;
        let (from, to) = ((middle, top), (middle, top + 14.0));
        page.add(line(from, to, FLOOR, FLOOR_WIDTH, None));
        let label = text::clean(&figure.floor_label);
        let at = (x + 18.0, top + 11.0);
        page.add(words(&label, at, LABEL_SIZE, TextAnchor::Start, None));
        x += 38.0 + text::width(&label, LABEL_SIZE);
    }
    let mut dots = figure.panels.iter().flat_map(|panel| &panel.dots);
    if dots.any(|dot| dot.ring) {
        let label = text::clean(&figure.ring_label);
        if x > left && x + 18.0 + text::width(&label, LABEL_SIZE) > right {
            (x, top) = (left, top + LEGEND_LINE);
        }
        page.add(disc((x + 8.0, top + 7.0), DOT, DOTS, false));
        let lines = text::lines(&label, right - x - 18.0, LABEL_SIZE);
        for (number, words_of) in lines.iter().enumerate() {
            top += if number > 0 { LEGEND_LINE } else { 0.0 };
            let at = (x + 18.0, top + 11.0);
            page.add(words(words_of, at, LABEL_SIZE, TextAnchor::Start, None));
        }
        x = right;
    }
    if x > left { top + LEGEND_LINE } else { top }
}

const DOTS: &str = "#0072b2";
const FLOOR: &str = "#b5b5b5";
const FLOOR_WIDTH: f64 = 4.0;

/// Inside of a panel: its position and its axis.
struct Inside<'a> {
    /// Width, height of a line and range of the axis, common to all panels.
    plan: &'a Plan,
    /// Left edge `[px]`.
    left: f64,
    /// Upper edge `[px]`.
    top: f64,
    /// Lower edge `[px]`.
    bottom: f64,
}

impl Inside<'_> {
    /// Returns the horizontal position `[px]` of a decimal logarithm.
    fn at(&self, log: f64) -> f64 {
        let (low, high) = self.plan.range;
        self.left + self.plan.panel * (log - low) / (high - low)
    }
}

fn draw(
    page: &mut Scene,
    figure: &DotFigure,
    plan: &Plan,
    panel: &DotPanel,
    (left, top): (f64, f64),
    is_last: bool,
) {
    let height = panel.dots.len() as f64 * plan.line;
    let bottom = top + height;
    let (low, high) = plan.range;
    let inside = Inside {
        plan,
        left,
        top,
        bottom,
    };
    draw_axis(page, &inside, is_last);
    if is_last {
        let place = (left + 0.5 * plan.panel, bottom + 30.0);
        let label = text::clean(&figure.x_label);
        page.add(words(&label, place, LABEL_SIZE, TextAnchor::Middle, None));
    }
    if let Some(floor) = panel.floor.filter(|floor| *floor > 0.0) {
        let x = inside.at(floor.log10().clamp(low, high));
        page.add(line((x, top), (x, bottom), FLOOR, FLOOR_WIDTH, None));
    }
    for (number, dot) in panel.dots.iter().enumerate() {
        let y = top + (number as f64 + 0.5) * plan.line;
        draw_dot(page, figure, &inside, dot, y);
    }
    page.add(frame((left, top), (plan.panel, height), ink::FRAME));
}

/// Draws the grid lines and, below the last panel of a column, the ticks and numbers of the axis.
fn draw_axis(page: &mut Scene, inside: &Inside, is_last: bool) {
    let (top, bottom) = (inside.top, inside.bottom);
    let (low, high) = inside.plan.range;
    // The last number is left of its tick. If it would overlap the number before it, only the tick is drawn.
    let number_width = |decade: f64| text::width(&axis::decade_label(decade), NAME_SIZE);
    let taken = number_width(high) + 0.5 * number_width(high - 1.0) + BETWEEN_NUMBERS;
    let has_last_number = taken <= inside.at(high) - inside.at(high - 1.0);
    let mut decade = low;
    while decade <= high {
        for step in [1.0_f64, 2.0, 5.0] {
            let log = decade + step.log10();
            if log > high + 1e-9 {
                continue;
            }
            let x = inside.at(log);
            page.add(line((x, top), (x, bottom), ink::GRID, 0.7, None));
            if is_last && step == 1.0 {
                page.add(line((x, bottom), (x, bottom + 4.0), ink::FRAME, 0.8, None));
                if decade + 1.0 > high && !has_last_number {
                    continue;
                }
                let number = axis::decade_label(decade);
                let place = (x, bottom + 15.0);
                // Numbers at the ends stay within the panel, clear of the numbers of its neighbours.
                let anchor = if decade == low {
                    TextAnchor::Start
                } else if decade + 1.0 > high {
                    TextAnchor::End
                } else {
                    TextAnchor::Middle
                };
                page.add(words(&number, place, NAME_SIZE, anchor, None));
            }
        }
        decade += 1.0;
    }
}

/// Draws a dot on its line at the height `y` `[px]`, and its note.
fn draw_dot(page: &mut Scene, figure: &DotFigure, inside: &Inside, dot: &Dot, y: f64) {
    let (left, plan) = (inside.left, inside.plan);
    page.add(line(
        (left, y),
        (left + plan.panel, y),
        ink::GRID,
        0.7,
        Some("1 3"),
    ));
    let ends = (left, left + plan.panel);
    let x = mark(page, figure, dot, ends, y, |log| inside.at(log));
    if dot.note.is_empty() {
        return;
    }
    let note = text::clean(&dot.note);
    let room = left + plan.panel - x - DOT - 4.0;
    let (x, anchor) = if text::width(&note, NOTE_SIZE) <= room {
        (x + DOT + 4.0, TextAnchor::Start)
    } else {
        (x - DOT - 4.0, TextAnchor::End)
    };
    page.add(words(
        &note,
        (x, y + 3.5),
        NOTE_SIZE,
        anchor,
        Some(ink::NOTE),
    ));
}

/// Draws the value of a dot and returns its position on the page.
fn mark(
    page: &mut Scene,
    figure: &DotFigure,
    dot: &Dot,
    (left, right): (f64, f64),
    y: f64,
    at: impl Fn(f64) -> f64,
) -> f64 {
    let Some(value) = dot.value.filter(|value| *value > 0.0) else {
        return left;
    };
    if value > figure.largest {
        let tip = right - 2.0;
        let back = tip - 2.2 * DOT;
        page.add(shape(&[(back, y - DOT), (tip, y), (back, y + DOT)], DOTS));
        return back;
    }
    let x = at(value.log10());
    page.add(disc((x, y), DOT, DOTS, !dot.ring));
    x
}
