//! Text that fits: its width, its lines, its characters.

use kuva::render::layout::{ComputedLayout, Layout};
use kuva::render::render_utils;

/// Families that look alike and of which every system has one.
pub(super) const FAMILY: &str = "Helvetica, Arial, Liberation Sans, DejaVu Sans, sans-serif";

/// Width of `text` `[px]` in the broadest of the families.
pub(super) fn width(text: &str, size: u32) -> f64 {
    // The only door to the library's font metrics is the room it reserves for tick labels.
    let layout = Layout::new((0.0, 1.0), (0.0, 1.0))
        .with_y_categories(vec![text.to_owned()])
        .with_tick_size(size);
    ComputedLayout::from_layout(&layout).y_tick_label_px
}

/// What stays with the number before it.
const UNITS: [&str; 16] = [
    "%", "Hz", "kHz", "N", "mN", "N/m", "s/m", "kg", "g", "s", "ms", "m", "mm", "um", "J", "mJ",
];

/// `text` in lines of at most `characters`; a unit stays with its number.
fn wrap_text(text: &str, characters: usize) -> Vec<String> {
    // A character that is no white space, and that no text has after `clean`.
    const GLUE: &str = "\u{fffe}";
    let mut glued = String::with_capacity(text.len());
    for (number, word) in text.split(' ').enumerate() {
        let is_unit = UNITS.contains(&word.trim_end_matches([',', ';', '.', ':', ')']));
        let follows = glued.ends_with(|c: char| c.is_ascii_digit() || c == 'N');
        if number > 0 {
            glued += if is_unit && follows { GLUE } else { " " };
        }
        glued += word;
    }
    let lines = render_utils::wrap_text(&glued, characters).into_iter();
    lines.map(|line| line.replace(GLUE, " ")).collect()
}

/// How many characters a line may have for `text` to fit into `room` `[px]`.
pub(super) fn characters(text: &str, room: f64, size: u32) -> usize {
    let fits = |count: &usize| {
        wrap_text(text, *count)
            .iter()
            .all(|line| width(line, size) <= room)
    };
    (8..=text.chars().count()).rev().find(fits).unwrap_or(8)
}

/// `text` in lines of at most `room` `[px]`.
pub(super) fn lines(text: &str, room: f64, size: u32) -> Vec<String> {
    if text.is_empty() {
        return Vec::new();
    }
    wrap_text(text, characters(text, room, size))
}

/// `text` in as few lines as fit into `room` `[px]`, none much shorter than the others.
pub(super) fn balanced(text: &str, room: f64, size: u32) -> Vec<String> {
    let lines = lines(text, room, size);
    let least = (8..text.chars().count())
        .map(|count| wrap_text(text, count))
        .find(|shorter| shorter.len() == lines.len());
    least.unwrap_or(lines)
}

/// `text` without the characters that XML does not allow.
pub(super) fn clean(text: &str) -> String {
    let allowed = |&c: &char| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}');
    text.chars()
        .map(|c| if c.is_whitespace() { ' ' } else { c })
        .filter(allowed)
        .collect()
}
