//! Text layout: width, line breaks, allowed characters.

use kuva::render::layout::{ComputedLayout, Layout};
use kuva::render::render_utils;

/// Similar font families; every system has one of them.
pub(super) const FAMILY: &str = "Helvetica, Arial, Liberation Sans, DejaVu Sans, sans-serif";

/// Returns the width of `text` in the broadest of the families `[px]`.
pub(super) fn width(text: &str, size: u32) -> f64 {
    // The library exposes its font metrics only through the space that it reserves for tick labels.
    let layout = Layout::new((0.0, 1.0), (0.0, 1.0))
        .with_y_categories(vec![text.to_owned()])
        .with_tick_size(size);
    ComputedLayout::from_layout(&layout).y_tick_label_px
}

/// Units that stay on the line of their number.
const UNITS: [&str; 16] = [
    "%", "Hz", "kHz", "N", "mN", "N/m", "s/m", "kg", "g", "s", "ms", "m", "mm", "um", "J", "mJ",
];

/// Breaks `text` into lines of at most `characters`; a unit stays with its number.
fn wrap_text(text: &str, characters: usize) -> Vec<String> {
    // A character that is not white space and that `clean` removes from every text.
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

/// Returns the number of characters per line for which `text` fits into `room` `[px]`.
pub(super) fn characters(text: &str, room: f64, size: u32) -> usize {
    let fits = |count: &usize| {
        wrap_text(text, *count)
            .iter()
            .all(|line| width(line, size) <= room)
    };
    (8..=text.chars().count()).rev().find(fits).unwrap_or(8)
}

/// Breaks `text` into lines of at most `room` `[px]`.
pub(super) fn lines(text: &str, room: f64, size: u32) -> Vec<String> {
    if text.is_empty() {
        return Vec::new();
    }
    wrap_text(text, characters(text, room, size))
}

/// Breaks `text` into the minimum number of lines that fit into `room` `[px]`, of similar length.
pub(super) fn balanced(text: &str, room: f64, size: u32) -> Vec<String> {
    let lines = lines(text, room, size);
    let least = (8..text.chars().count())
        .map(|count| wrap_text(text, count))
        .find(|shorter| shorter.len() == lines.len());
    least.unwrap_or(lines)
}

/// Returns `text` without the characters that XML does not allow.
pub(super) fn clean(text: &str) -> String {
    let allowed = |&c: &char| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}');
    text.chars()
        .map(|c| if c.is_whitespace() { ' ' } else { c })
        .filter(allowed)
        .collect()
}
