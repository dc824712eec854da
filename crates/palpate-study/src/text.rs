//! Numbers and tables for a terminal.

use std::fmt;

use comfy_table::presets::NOTHING;
use comfy_table::{Cell, CellAlignment, Table, TableComponent};

/// A table without blanks at the ends of its lines.
pub fn lines(table: &Table) -> String {
    let lines: Vec<String> = table.lines().map(|line| line.trim_end().into()).collect();
    lines.join("\n")
}

/// A table with a line under its header, its columns two blanks apart; the first column holds names, or
/// numbers like the others.
pub fn plain_table(first: CellAlignment, header: &[&str]) -> Table {
    let mut table = Table::new();
    table
        .load_preset(NOTHING)
        .set_style(TableComponent::HeaderLines, '─')
        .set_style(TableComponent::MiddleHeaderIntersections, '─');
    table.set_header(header.iter().enumerate().map(|(column, name)| {
        Cell::new(name).set_alignment(if column == 0 {
            first
        } else {
            CellAlignment::Right
        })
    }));
    for column in table.column_iter_mut() {
        column.set_padding((1, 0));
    }
    table
}

/// A right-aligned number, a dash where there is none.
pub fn number(value: Option<f64>, format: impl Fn(f64) -> String) -> Cell {
    Cell::new(value.map_or_else(|| "-".into(), format)).set_alignment(CellAlignment::Right)
}

/// A percentage, without its sign: one decimal, or an exponent where it is large.
pub fn percent(value: f64) -> String {
    short(value, 1)
}

/// With so many decimals, or an exponent where there are more than four digits before them.
pub fn short(value: f64, decimals: usize) -> String {
    if value.abs() < 9999.5 {
        format!("{value:.decimals$}")
    } else {
        format!("{value:.decimals$e}")
    }
}

/// `1 sample`, `2 samples`.
pub fn counted<N: fmt::Display + From<u8> + PartialEq>(count: N, thing: &str) -> String {
    let plural = if count == N::from(1) { "" } else { "s" };
    format!("{count} {thing}{plural}")
}

/// All digits that tell it from its neighbours, with an exponent where plain notation is mostly zeros.
pub fn exactly(value: f64) -> String {
    let is_plain = value == 0.0 || !value.is_finite() || (1e-5..1e16).contains(&value.abs());
    if is_plain {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

/// Three significant digits, in plain notation where that is short.
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
