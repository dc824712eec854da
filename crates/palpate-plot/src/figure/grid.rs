//! A grid of panels with its axes, headings and notes.

use kuva::render::figure::Figure as Panels;
use kuva::render::layout::{ComputedLayout, Layout};
use kuva::render::render::{Scene, TextAnchor};

use super::page::{NOTE_SIZE, words};
use super::panel::{self, Drawn, LABEL_SIZE};
use super::stroke::Window;
use super::{Grid, Panel, axis, ink, text};

const HEAD_SIZE: u32 = 12;
/// Width right of each panel, half of the last number on its axis included `[px]`.
const RIGHT: f64 = 16.0;
/// Height above the frames of a row `[px]`.
const ABOVE: f64 = 7.0;
/// Height above the frames of a row with a note or a heading `[px]`.
const ABOVE_NOTED: f64 = 17.0;
/// Height above the frames of the first row, for the headings of the columns `[px]`.
const HEAD: f64 = 20.0;
/// Gap between the heading of a row and a note `[px]`.
const BETWEEN: f64 = 12.0;
/// Width left of the frames of every column but the first `[px]`.
const LEFT: f64 = 4.0;
/// Height below the frames of a row without numbers `[px]`.
const BELOW: f64 = 4.0;
/// Height below the frames of the last row, for numbers and label `[px]`.
const BELOW_LAST: f64 = 42.0;

/// Layout parameters common to all grids of a figure.
#[derive(Debug, Clone, Copy)]
pub(super) struct Common<'a> {
    /// Range of the horizontal axes.
    pub x: (f64, f64),
    /// Label of the horizontal axes.
    pub x_label: &'a str,
    /// Whether the horizontal axes show powers of ten.
    pub x_decades: bool,
    /// Height of a frame `[px]`.
    pub height: f64,
}

/// Space that grids side by side reserve together, so that their frames stay level.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Level {
    /// Headings of columns above the first row.
    pub heads: bool,
    /// A line of words above every row.
    pub words: bool,
}

/// A grid with known vertical axes and their widths, but unknown frame width.
pub(super) struct Planned<'a> {
    grid: &'a Grid,
    common: Common<'a>,
    columns: usize,
    /// Range of each row.
    ranges: Vec<(f64, f64)>,
    /// Width of the numbers of each row, and the largest of these widths `[px]`.
    numbers: (Vec<f64>, f64),
    /// Width left of the first frame `[px]`.
    pub left: f64,
}

impl<'a> Planned<'a> {
    /// Returns `None` if there is no panel. A row whose label is in `shared` gets the range of that entry.
    pub fn new(grid: &'a Grid, common: Common<'a>, shared: &axis::Shared) -> Option<Self> {
        let columns = grid.rows.iter().map(|row| row.panels.len()).max()?;
        if columns == 0 {
            return None;
        }
        let mut ranges: Vec<_> = grid.rows.iter().map(axis::vertical).collect();
        if grid.same_scale
            && let Some(all) = axis::union(ranges.iter().copied())
        {
            ranges.fill(all);
        }
        for (range, row) in ranges.iter_mut().zip(&grid.rows) {
            *range = shared.get(&*row.y_label).copied().unwrap_or(*range);
        }
        let mut planned = Self {
            grid,
            common,
            columns,
            ranges,
            numbers: (Vec::new(), 0.0),
            left: 0.0,
        };
        // Numbers and label do not depend on the width of the frames.
        let computed: Vec<ComputedLayout> = (0..grid.rows.len())
            .map(|row| ComputedLayout::from_layout(&planned.layout(row, 0, 200.0)))
            .collect();
        let widest = |of: fn(&ComputedLayout) -> f64| computed.iter().map(of).fold(0.0, f64::max);
        planned.left = widest(|computed| computed.margin_left);
        planned.numbers = (
            computed.iter().map(|row| row.y_tick_label_px).collect(),
            widest(|computed| computed.y_tick_label_px),
        );
        Some(planned)
    }

    /// Returns the number of frames side by side.
    pub fn columns(&self) -> f64 {
        self.columns as f64
    }

    /// Returns the number of frames below each other.
    pub fn rows(&self) -> f64 {
        self.grid.rows.len() as f64
    }

    /// Returns the width of the margins between and right of the frames `[px]`.
    pub fn between(&self) -> f64 {
        self.columns() * RIGHT + (self.columns() - 1.0) * LEFT
    }

    /// Returns the space that this grid requires in the [`Level`].
    pub fn level(&self) -> Level {
        Level {
            heads: !self.grid.columns.is_empty(),
            words: !self.grid.heads.is_empty(),
        }
    }

    fn window(&self, row: usize, width: f64) -> Window {
        let x = self.common.x;
        Window {
            x,
            y: self.ranges[row],
            pixel: (x.1 - x.0) / width,
        }
    }

    fn layout(&self, row: usize, column: usize, width: f64) -> Layout {
        let height = self.common.height;
        let window = self.window(row, width);
        let decades = (self.common.x_decades, self.grid.rows[row].y_decades);
        let mut layout = panel::axes(&window, width, height, decades);
        if column == 0 {
            let label = text::clean(&self.grid.rows[row].y_label);
            layout.y_label_wrap = Some(text::characters(&label, height, LABEL_SIZE));
            layout.y_label = Some(label);
        }
        layout
    }

    /// Draws the grid with frames of a `width`; the first frame is `left` of the grid's edge `[px]`.
    pub fn draw(&self, left: f64, width: f64, level: Level) -> Scene {
        let height = self.common.height;
        let empty = Panel::default();
        let drawn: Vec<Vec<Drawn>> = (self.grid.rows.iter().enumerate())
            .map(|(index, row)| {
                let window = self.window(index, width);
                (0..self.columns)
                    .map(|column| row.panels.get(column).unwrap_or(&empty))
                    .map(|panel| panel::draw(panel, &window, height))
                    .collect()
            })
            .collect();

        let last = drawn.len() - 1;
        let mut layouts = Vec::new();
        let mut row_heights = Vec::new();
        let mut tops = Vec::new();
        for (index, row) in drawn.iter().enumerate() {
            let noted = level.words || row.iter().any(|drawn| !drawn.leaving.is_empty());
            let head = if index == 0 && level.heads { HEAD } else { 0.0 };
            let above = head + if noted { ABOVE_NOTED } else { ABOVE };
            let below = if index == last { BELOW_LAST } else { BELOW };
            for column in 0..self.columns {
                let mut layout = self.layout(index, column, width);
                layout.suppress_x_ticks = index != last;
                layout.suppress_y_ticks = column != 0;
                if index == last {
                    layout.x_label = Some(text::clean(self.common.x_label));
                }
                layout.y_label_offset.0 = self.numbers.0[index] - self.numbers.1;
                layout.force_margin_left = Some(if column == 0 { left } else { LEFT });
                layout.force_margin_right = Some(RIGHT);
                layout.force_margin_top = Some(above);
                layout.force_margin_bottom = Some(below);
                layouts.push(layout);
            }
            row_heights.push(above + height + below);
            tops.push(above);
        }

        // The heading of a row is above its first frame, like the note.
        let taken = |row: usize, column: usize| match self.grid.heads.get(row) {
            Some(head) if column == 0 => text::width(&text::clean(head), HEAD_SIZE) + BETWEEN,
            _ => 0.0,
        };
        let notes: Vec<Vec<Option<String>>> = (drawn.iter().enumerate())
            .map(|(index, row)| {
                (row.iter().enumerate())
                    .map(|(column, drawn)| note(drawn, width - taken(index, column)))
                    .collect()
            })
            .collect();
        let mut panels = Panels::new(drawn.len(), self.columns)
            .with_spacing(0.0)
            .with_padding(0.0)
            .with_plots(
                drawn
                    .into_iter()
                    .flatten()
                    .map(|drawn| drawn.plots)
                    .collect(),
            )
            .with_layouts(layouts);
        for (index, height) in row_heights.iter().enumerate() {
            panels = panels.with_row_height(index, *height);
        }
        for column in 0..self.columns {
            let left = if column == 0 { left } else { LEFT };
            panels = panels.with_col_width(column, left + width + RIGHT);
        }
        let mut scene = panels.render();
        self.write(&mut scene, left, width, &notes, &row_heights, &tops);
        scene
    }

    /// Draws the headings of columns and rows, and the notes.
    fn write(
        &self,
        scene: &mut Scene,
        left: f64,
        width: f64,
        notes: &[Vec<Option<String>>],
        row_heights: &[f64],
        tops: &[f64],
    ) {
        let frame_left = |column: usize| left + column as f64 * (width + RIGHT + LEFT);
        for (column, head) in self.grid.columns.iter().take(self.columns).enumerate() {
            let middle = frame_left(column) + 0.5 * width;
            let (head, anchor) = (text::clean(head), TextAnchor::Middle);
            scene.add(words(&head, middle, 14.0, HEAD_SIZE, anchor, None));
        }
        let mut top = 0.0;
        for (index, row) in notes.iter().enumerate() {
            let baseline = top + tops[index] - 4.0;
            if let Some(head) = self.grid.heads.get(index) {
                let (head, anchor) = (text::clean(head), TextAnchor::Start);
                scene.add(words(&head, left, baseline, HEAD_SIZE, anchor, None));
            }
            for (column, note) in row.iter().enumerate() {
                if let Some(note) = note {
                    let (right, anchor) = (frame_left(column) + width, TextAnchor::End);
                    let colour = Some(ink::NOTE);
                    scene.add(words(note, right, baseline, NOTE_SIZE, anchor, colour));
                }
            }
            top += row_heights[index];
        }
    }
}

/// Returns the note above a frame that some series leave, at most `room` wide `[px]`.
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
