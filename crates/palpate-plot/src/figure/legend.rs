//! The legend: one line of swatches above all panels, or more lines if they do not fit.

use kuva::plot::legend::{LegendEntry, LegendShape};
use kuva::render::render::{Primitive, Scene, TextAnchor, render_legend_at};
use kuva::render::theme::Theme;

use super::element::{disc, line};
use super::ink::{Ink, dash_array, ink};
use super::{Kind, Role, Sheet, text};

const SIZE: u32 = 12;
/// Length of a swatch: it shows the longest dashes once `[px]`.
const SWATCH: f64 = 34.0;
const GAP: f64 = 6.0;
const BETWEEN: f64 = 20.0;
const LINE: f64 = 19.0;

/// The entries of a figure's legend with their positions.
pub(super) struct Legend {
    entries: Vec<Entry>,
    lines: usize,
}

struct Entry {
    name: String,
    kind: Kind,
    role: Role,
    ink: Ink,
    x: f64,
    line: usize,
}

impl Legend {
    /// Creates one entry per name, in the order of first appearance, within `room` `[px]`.
    pub fn new(sheet: &Sheet, room: f64) -> Self {
        let mut entries: Vec<Entry> = Vec::new();
        let (mut x, mut line) = (0.0, 0);
        for series in sheet.series() {
            let (name, ink) = (text::clean(&series.name), ink(series.role));
            let known = |entry: &Entry| entry.name == name && entry.ink == ink;
            if name.is_empty() || entries.iter().any(known) {
                continue;
            }
            let width = SWATCH + GAP + text::width(&name, SIZE);
            if x > 0.0 && x + width > room {
                (x, line) = (0.0, line + 1);
            }
            entries.push(Entry {
                name,
                kind: series.kind,
                role: series.role,
                ink,
                x,
                line,
            });
            x += width + BETWEEN;
        }
        let lines = if entries.is_empty() { 0 } else { line + 1 };
        Self { entries, lines }
    }

    /// Returns the height of the whole legend `[px]`.
    pub fn height(&self) -> f64 {
        LINE * self.lines as f64
    }

    /// Draws the legend with its upper left corner at `left`, `top`.
    pub fn draw(&self, scene: &mut Scene, left: f64, top: f64) {
        for entry in &self.entries {
            let x = left + entry.x;
            let y = top + LINE * (entry.line as f64 + 0.5);
            match (entry.kind, entry.role) {
                (Kind::Points, Role::Mark) => {
                    let middle = (x + 0.5 * SWATCH, y);
                    scene.add(disc(middle, 5.0, entry.ink.colour, false));
                }
                (Kind::Points, _) => {
                    marker(scene, entry, x, y);
                    continue;
                }
                _ => {
                    let (from, to) = ((x, y), (x + SWATCH, y));
                    let dashes = dash_array(entry.ink.dashes);
                    let (colour, width) = (entry.ink.colour, entry.ink.width);
                    scene.add(line(from, to, colour, width, dashes.as_deref()));
                }
            }
            scene.add(Primitive::Text {
                x: x + SWATCH + GAP,
                y: y + 0.36 * f64::from(SIZE),
                content: entry.name.clone(),
                size: SIZE,
                anchor: TextAnchor::Start,
                rotate: None,
                bold: false,
                color: None,
            });
        }
    }
}

/// Draws the entry of a series of points with the library's legend. Its lines are too short for the dashes of this
/// crate.
fn marker(scene: &mut Scene, entry: &Entry, x: f64, y: f64) {
    let shown = LegendEntry {
        label: entry.name.clone(),
        color: entry.ink.colour.to_owned(),
        shape: LegendShape::Marker(entry.ink.marker),
        dasharray: None,
    };
    // The library draws the name 25 px right of its corner and the marker's centre 5 px below it.
    let (x, y) = (x + SWATCH + GAP - 25.0, y - 5.0);
    let theme = Theme::light();
    render_legend_at(&[shown], None, None, false, scene, x, y, 0.0, SIZE, &theme);
}
