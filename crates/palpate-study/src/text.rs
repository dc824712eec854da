//! Numbers and tables for a terminal.

use std::fmt;
use std::ops::Range;

use comfy_table::presets::NOTHING;
use comfy_table::{Cell, CellAlignment, Row, Table, TableComponent};

/// Number of characters of a terminal line.
pub const WIDTH: usize = 80;

/// Explanation of the mean-force error column.
pub const E: &str =
    "E: error of the mean force of each period, the part of FRE that a method can avoid.";
/// Explanation of the force rendering error column.
pub const FRE: &str = "FRE: error of the held force, the hold bound included.";
/// Explanation of the absolute leak column.
pub const ABSOLUTE_LEAK: &str = "|leak|: energy that the held force created or took \
    away, every part counted as positive.";

/// Returns a table of any width, without blanks at the ends of its lines.
#[must_use]
pub fn whole(table: &Table) -> String {
    let lines: Vec<String> = table.lines().map(|line| line.trim_end().into()).collect();
    lines.join("\n")
}

/// Returns a table without blanks at the ends of its lines. If it is wider than a terminal, the remaining columns
/// follow in a separate block, which repeats the first column.
pub fn lines(table: &Table) -> String {
    let columns = table.header().map_or(0, Row::cell_count);
    let mut blocks = Vec::new();
    let mut from = 1;
    loop {
        let mut block = part(table, from..columns);
        let mut to = columns;
        // A single column that is too wide is not cut.
        while width(&block) > WIDTH && to > from + 1 {
            to -= 1;
            block = part(table, from..to);
        }
        blocks.push(block);
        from = to;
        if from >= columns {
            return blocks.join("\n\n");
        }
    }
}

/// Returns the first column and these columns.
fn part(table: &Table, columns: Range<usize>) -> String {
    let cells = |row: &Row| -> Vec<Cell> {
        let all: Vec<&Cell> = row.cell_iter().collect();
        let rest = all.get(columns.start..columns.end.min(all.len()));
        let first = all.first().into_iter();
        first
            .chain(rest.into_iter().flatten())
            .map(|cell| (*cell).clone())
            .collect()
    };
    let mut part = empty();
    part.set_header(table.header().map(cells).unwrap_or_default());
    part.add_rows(table.row_iter().map(cells));
    close_up(&mut part);
    whole(&part)
}

/// Returns the length of the longest line of a text in characters.
#[must_use]
pub fn width(text: &str) -> usize {
    text.lines()
        .map(|line| line.chars().count())
        .max()
        .unwrap_or(0)
}

/// Wraps a text to lines of less than [`WIDTH`] characters, because some terminals show an empty line after a full
/// one.
#[must_use]
pub fn wrapped(text: &str) -> String {
    within(text, WIDTH - 1).join("\n")
}

/// Wraps one line to lines of less than [`WIDTH`] characters. The first keeps its indentation; the others are
/// indented by `blanks`.
#[must_use]
pub fn hanging(line: &str, blanks: usize) -> String {
    if line.chars().count() < WIDTH {
        return line.into();
    }
    let words = line.trim_start();
    let own = line.len() - words.len();
    let lines = within(words, WIDTH - 1 - own.max(blanks));
    let below = format!("\n{}", " ".repeat(blanks));
    " ".repeat(own) + &lines.join(&below)
}

/// Wraps a text to lines of at most `width` characters; a longer word gets its own line. A number keeps its `%`, and
/// line breaks of the text are kept.
#[must_use]
pub fn within(text: &str, width: usize) -> Vec<String> {
    let lines = text.split('\n');
    lines.flat_map(|line| line_within(line, width)).collect()
}

fn line_within(line: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = vec![String::new()];
    for word in line.replace(" %", "\u{a0}%").split(' ') {
        let word = word.replace('\u{a0}', " ");
        let line = lines.last_mut().expect("there is always one");
        if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > width {
            lines.push(word);
        } else {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(&word);
        }
    }
    lines
}

/// Returns a title with the seed of its random values.
pub(crate) fn drawn_title(title: &str, seed: Option<u64>) -> String {
    seed.map_or_else(
        || title.to_owned(),
        |seed| format!("{title}; one draw of seed {seed}"),
    )
}

/// Returns the explanation of a table's columns, as a text below it.
#[must_use]
pub fn legend(columns: &[&str]) -> String {
    wrapped(&columns.join(" "))
}

fn empty() -> Table {
    let mut table = Table::new();
    table
        .load_preset(NOTHING)
        .set_style(TableComponent::HeaderLines, '─')
        .set_style(TableComponent::MiddleHeaderIntersections, '─');
    table
}

/// Sets the gap between columns to two blanks.
fn close_up(table: &mut Table) {
    for column in table.column_iter_mut() {
        column.set_padding((1, 0));
    }
}

/// Creates a table with a line under its header and gaps of two blanks. The first column contains names, or numbers
/// like the others.
#[must_use]
pub fn plain_table(first: CellAlignment, header: &[&str]) -> Table {
    let mut table = empty();
    table.set_header(header.iter().enumerate().map(|(column, name)| {
        Cell::new(name).set_alignment(if column == 0 {
            first
        } else {
            CellAlignment::Right
        })
    }));
    close_up(&mut table);
    table
}

/// Returns a right-aligned number, or a dash for `None`.
pub fn number(value: Option<f64>, format: impl Fn(f64) -> String) -> Cell {
    Cell::new(value.map_or_else(|| "-".into(), format)).set_alignment(CellAlignment::Right)
}

/// Returns a percentage without its sign: one decimal, or an exponent if it is large.
#[must_use]
pub fn percent(value: f64) -> String {
    short(value, 1)
}

/// Returns a number with `decimals` decimals, or with an exponent if it has more than four integer digits.
#[must_use]
pub fn short(value: f64, decimals: usize) -> String {
    if value.abs() < 9999.5 {
        format!("{value:.decimals$}")
    } else {
        format!("{value:.decimals$e}")
    }
}

/// Returns a count with its noun: `1 sample`, `2 samples`.
pub fn counted<N: fmt::Display + From<u8> + PartialEq>(count: N, thing: &str) -> String {
    let plural = if count == N::from(1) { "" } else { "s" };
    format!("{count} {thing}{plural}")
}

/// Returns a number with all digits that distinguish it from its neighbours, with an exponent if plain notation is
/// mostly zeros.
#[must_use]
pub fn exactly(value: f64) -> String {
    let is_plain = value == 0.0 || !value.is_finite() || (1e-5..1e16).contains(&value.abs());
    if is_plain {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

/// Returns a number with three significant digits, in plain notation if that is short.
#[must_use]
pub fn digits(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    let magnitude = value.abs().log10().floor();
    if (-4.0..5.0).contains(&magnitude) {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 to 6"
        )]
        let decimals = (2.0 - magnitude).max(0.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.2e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a table of one row with these column widths. Each column after the first takes two more characters for
    /// the gap, the first column takes one more.
    fn table(widths: &[usize]) -> Table {
        let names: Vec<String> = widths
            .iter()
            .enumerate()
            .map(|(k, w)| format!("{k:0>w$}"))
            .collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let mut table = plain_table(CellAlignment::Left, &names);
        table.add_row(names);
        table
    }

    #[test]
    fn a_table_that_is_too_wide_goes_on_below_with_its_first_column() {
        // 1 + 8, then 2 + 16 four times: 81.
        let text = lines(&table(&[8, 16, 16, 16, 16]));
        let blocks: Vec<&str> = text.split("\n\n").collect();
        let names = |block: &str| -> Vec<String> {
            let last = block.lines().last().unwrap();
            last.split_whitespace()
                .map(|name| name.trim_start_matches('0').to_owned())
                .collect()
        };
        assert_eq!(blocks.len(), 2, "{text}");
        assert_eq!(names(blocks[0]), ["", "1", "2", "3"]);
        assert_eq!(names(blocks[1]), ["", "4"]);
        assert!(width(&text) <= WIDTH, "{text}");
        // It fits with one character less.
        let text = lines(&table(&[7, 16, 16, 16, 16]));
        assert_eq!(width(&text), WIDTH, "{text}");
        assert_eq!(text.split("\n\n").count(), 1, "{text}");
    }

    #[test]
    fn a_column_that_is_too_wide_by_itself_is_shown_whole() {
        let text = lines(&table(&[8, 90, 16]));
        assert_eq!(text.split("\n\n").count(), 2, "{text}");
        assert_eq!(width(&text), 1 + 8 + 2 + 90);
    }

    #[test]
    fn a_long_line_goes_on_below_its_own_beginning() {
        let short = format!("  ok  {}", "a".repeat(73));
        assert_eq!(hanging(&short, 6), short);
        let [one, other] = ["a".repeat(60), "b".repeat(20)];
        let long = format!("  ok  {one} {other}");
        assert_eq!(hanging(&long, 6), format!("  ok  {one}\n      {other}"));
    }

    #[test]
    fn a_number_keeps_its_percent_sign() {
        assert_eq!(within("aa below 20 %, b", 11), ["aa below", "20 %, b"]);
    }

    #[test]
    fn a_line_that_has_ended_stays_ended() {
        assert_eq!(within("aa;\nb cc dd", 5), ["aa;", "b cc", "dd"]);
    }

    #[test]
    fn a_wrapped_text_keeps_its_words() {
        let text = format!("{}, {E} {FRE} {ABSOLUTE_LEAK}", "a".repeat(100));
        let wrapped = wrapped(&text);
        assert_eq!(wrapped.replace('\n', " "), text);
        assert!(
            wrapped
                .lines()
                .skip(1)
                .all(|line| line.chars().count() <= WIDTH)
        );
    }
}
