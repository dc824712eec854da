//! The whole page: title, legend, grids of panels, small print.

use kuva::render::render::{Primitive, Scene, TextAnchor};

use super::grid::{Common, Level, Planned};
use super::legend::Legend;
use super::{Sheet, Size, SizeError, axis, element, ink, text};

const TITLE_SIZE: u32 = 14;
const SUBTITLE_SIZE: u32 = 12;
/// Width of bold letters relative to plain ones.
const BOLD: f64 = 1.17;
pub(super) const NOTE_SIZE: u32 = 10;

/// Margin around the page `[px]`.
const EDGE: f64 = 10.0;

/// Minimum size of a frame `[px]`.
const MIN_FRAME: (f64, f64) = (70.0, 36.0);

/// The laid-out page of a figure.
pub struct Page {
    /// Everything on the page.
    pub scene: Scene,
    /// Page size of a scene pixel `[px]`.
    pub scale: f64,
}

impl From<Scene> for Page {
    fn from(scene: Scene) -> Self {
        Self { scene, scale: 1.0 }
    }
}

/// Returns the size of a frame if `columns` frames are side by side `[px]`.
fn frame(columns: f64) -> (f64, f64) {
    match columns {
        ..2.0 => (600.0, 130.0),
        ..3.0 => (330.0, 125.0),
        ..4.0 => (245.0, 120.0),
        _ => (205.0, 115.0),
    }
}

/// Draws a figure.
pub(super) fn page(sheet: &Sheet, size: Size) -> Result<Page, SizeError> {
    let planned = Lines::plan(sheet, frame(Lines::most(sheet)).1);
    let frame_width = match size.width {
        None => planned.natural_frame(),
        Some(width) => planned.frame_within(width)?,
    };
    let natural = scene(sheet, &planned, frame_width);
    let Some(height) = size.height else {
        return Ok(Page::from(natural));
    };
    let frames = planned.frames_below_each_other().max(1.0);
    let frame_height = planned.height + (height - natural.height) / frames;
    if frame_height < MIN_FRAME.1 {
        let least = natural.height + (MIN_FRAME.1 - planned.height) * frames;
        return Err(SizeError::too_small("height", height, least));
    }
    let planned = Lines::plan(sheet, frame_height);
    let frame_width = match size.width {
        None => planned.natural_frame(),
        Some(width) => planned.frame_within(width)?,
    };
    let mut scene = scene(sheet, &planned, frame_width);
    scene.height = height;
    Ok(Page::from(scene))
}

fn scene(sheet: &Sheet, planned: &Lines, frame_width: f64) -> Scene {
    let (grids, heads) = planned.draw(frame_width);
    let width = 2.0 * EDGE
        + if grids.is_empty() {
            400.0
        } else {
            widths(&grids).fold(0.0, f64::max)
        };
    let left = EDGE + heads;
    let legend = Legend::new(sheet, width - left - EDGE);

    let mut page = Scene::new(width, 0.0);
    page.font_family = Some(text::FAMILY.to_owned());
    page.text_color = Some("#111111".to_owned());
    let head = Head {
        title: &sheet.title,
        subtitle: &sheet.subtitle,
        middle: 0.5 * width,
        room: width - 2.0 * EDGE,
    };
    let mut top = head.draw(&mut page, EDGE);
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
    let note = sheet.footnote.as_deref().unwrap_or_default();
    top = foot(&mut page, note, left, top, width - left - EDGE);
    page.height = (top + EDGE).ceil();
    page
}

/// Title and subtitle.
pub(super) struct Head<'a> {
    pub title: &'a str,
    pub subtitle: &'a str,
    /// Centre of both `[px]`.
    pub middle: f64,
    /// Available width of a line `[px]`.
    pub room: f64,
}

impl Head<'_> {
    /// Draws both from `top` down. Returns the lower end.
    pub fn draw(&self, page: &mut Scene, mut top: f64) -> f64 {
        let title = text::balanced(&text::clean(self.title), self.room / BOLD, TITLE_SIZE);
        let subtitle = text::lines(&text::clean(self.subtitle), self.room, SUBTITLE_SIZE);
        let lines = title.iter().map(|line| (line, TITLE_SIZE));
        for (line, size) in lines.chain(subtitle.iter().map(|line| (line, SUBTITLE_SIZE))) {
            let baseline = top + f64::from(size);
            let middle = TextAnchor::Middle;
            page.add(words(line, self.middle, baseline, size, middle, None));
            top += 1.35 * f64::from(size);
        }
        if title.is_empty() && subtitle.is_empty() {
            top
        } else {
            top + 4.0
        }
    }
}

/// Draws small print below `top`, within `room` `[px]`. Returns its lower end.
pub(super) fn foot(page: &mut Scene, note: &str, left: f64, mut top: f64, room: f64) -> f64 {
    for line in text::lines(&text::clean(note), room, NOTE_SIZE) {
        top += 1.3 * f64::from(NOTE_SIZE);
        let (size, colour) = (NOTE_SIZE, Some(ink::NOTE));
        page.add(words(&line, left, top, size, TextAnchor::Start, colour));
    }
    top
}

/// The lines of grids, with known frame height but unknown width.
struct Lines<'a> {
    lines: Vec<Vec<Planned<'a>>>,
    /// Height of each frame `[px]`.
    height: f64,
}

impl<'a> Lines<'a> {
    fn plan(sheet: &'a Sheet, height: f64) -> Self {
        let common = Common {
            x: axis::horizontal(sheet),
            x_label: &sheet.x_label,
            x_decades: sheet.x_decades,
            height,
        };
        let shared = axis::shared(sheet);
        let lines = sheet.lines.iter().map(|line| {
            let planned = line.iter();
            let planned = planned.filter_map(|grid| Planned::new(grid, common, &shared));
            planned.collect::<Vec<_>>()
        });
        Self {
            lines: lines.filter(|line| !line.is_empty()).collect(),
            height,
        }
    }

    /// Returns the number of frames side by side in the widest line.
    fn most(sheet: &'a Sheet) -> f64 {
        let planned = Self::plan(sheet, 100.0);
        let columns = planned.lines.iter().map(side_by_side);
        columns.fold(0.0, f64::max)
    }

    /// Returns the default width of the frames `[px]`.
    fn natural_frame(&self) -> f64 {
        frame(self.lines.iter().map(side_by_side).fold(0.0, f64::max)).0
    }

    /// Returns the width of the frames of the widest line on a page of a `width` `[px]`.
    fn frame_within(&self, width: f64) -> Result<f64, SizeError> {
        let frame = self
            .lines
            .iter()
            .map(|line| (width - 2.0 * EDGE - self.margins(line)) / side_by_side(line))
            .fold(f64::INFINITY, f64::min);
        if frame < MIN_FRAME.0 {
            let least = |line: &Vec<Planned>| self.margins(line) + side_by_side(line) * MIN_FRAME.0;
            let least = self.lines.iter().map(least).fold(0.0, f64::max) + 2.0 * EDGE;
            return Err(SizeError::too_small("width", width, least));
        }
        Ok(if frame.is_finite() { frame } else { 0.0 })
    }

    fn frames_below_each_other(&self) -> f64 {
        let of_line = |line: &Vec<Planned>| line.iter().map(Planned::rows).fold(0.0, f64::max);
        self.lines.iter().map(of_line).sum()
    }

    /// Returns the width left of the frames; grids below each other start at the same position.
    fn left(&self, place: usize) -> f64 {
        let grids = self.lines.iter().filter_map(|line| line.get(place));
        grids.map(|grid| grid.left).fold(0.0, f64::max)
    }

    fn margins(&self, line: &[Planned]) -> f64 {
        let each = line.iter().enumerate();
        each.map(|(place, grid)| self.left(place) + grid.between())
            .sum()
    }

    /// Draws the lines with `frame_width` for the widest of them. Also returns the distance of the first frame from
    /// its left edge.
    fn draw(&self, frame_width: f64) -> (Vec<Vec<Scene>>, f64) {
        let width_of = |line: &Vec<Planned>| self.margins(line) + side_by_side(line) * frame_width;
        let width = self.lines.iter().map(width_of).fold(0.0, f64::max);
        let drawn = self
            .lines
            .iter()
            .map(|line| {
                let frames = (width - self.margins(line)) / side_by_side(line);
                let wants = |of: fn(Level) -> bool| line.iter().any(|grid| of(grid.level()));
                let level = Level {
                    heads: wants(|level| level.heads),
                    words: wants(|level| level.words),
                };
                let each = line.iter().enumerate();
                each.map(|(place, grid)| grid.draw(self.left(place), frames, level))
                    .collect()
            })
            .collect();
        (drawn, self.left(0))
    }
}

fn side_by_side(line: &Vec<Planned>) -> f64 {
    line.iter().map(Planned::columns).sum::<f64>()
}

/// Returns the width of each line `[px]`.
fn widths(lines: &[Vec<Scene>]) -> impl Iterator<Item = f64> {
    lines
        .iter()
        .map(|line| line.iter().map(|grid| grid.width).sum())
}

/// Words, bold if they have the size of a title.
pub(super) fn words(
    content: &str,
    x: f64,
    y: f64,
    size: u32,
    anchor: TextAnchor,
    colour: Option<&str>,
) -> Primitive {
    let mut words = element::words(content, (x, y), size, anchor, colour);
    if let Primitive::Text { bold, .. } = &mut words {
        *bold = size == TITLE_SIZE;
    }
    words
}
