//! Error distributions of methods on random plants.

use std::ops::Range;

use crate::figure::{Figure, Kind, Limits, Panel, Role, Row, Series};
use palpate_study::suite::{Column, Score, Set};
use palpate_study::text::counted;

/// Returns the role of a column: the role of its method if all columns are methods with their defaults.
fn role(columns: &[Column], number: usize) -> Role {
    let of_methods = columns
        .iter()
        .all(|column| *column == Column::new(column.method));
    if of_methods {
        crate::results::role(columns[number].method)
    } else {
        Role::Compared(number)
    }
}

/// Logarithm of the largest drawn error E: above it the force is unusable in any case.
const LARGEST_DRAWN: f64 = 3.0;

/// Returns the distribution of E of the `drawn` `columns`, with one panel per condition.
#[must_use]
pub fn suite(
    set: Set,
    seeds: &Range<u64>,
    columns: &[Column],
    drawn: &[usize],
    scores: &[Score],
) -> Figure {
    let conditions = set.conditions();
    let of_set = match set {
        Set::Paper => String::new(),
        other => format!(" of the set {other}"),
    };
    let last = seeds.end.saturating_sub(1);
    let of_seeds = if last > seeds.start {
        format!("seeds {} to {last}", seeds.start)
    } else {
        format!("seed {}", seeds.start)
    };
    let panel = |condition: usize| Panel {
        series: (drawn.iter().copied())
            .map(|number| {
                let mut errors: Vec<f64> = trials(scores, number, condition)
                    .map(|score| score.error.log10())
                    .collect();
                errors.sort_by(f64::total_cmp);
                let all = errors.len() as f64;
                // The curve starts at 0 at the lowest error and ends at the largest, or at the edge.
                let within = errors.partition_point(|error| *error <= LARGEST_DRAWN);
                let shares = (0..=within).map(|below| 100.0 * below as f64 / all);
                Series {
                    name: columns[number].name.clone(),
                    kind: Kind::Step,
                    role: role(columns, number),
                    y: shares.collect(),
                    x: errors[..within]
                        .first()
                        .into_iter()
                        .chain(&errors[..within])
                        .copied()
                        .collect(),
                }
            })
            .collect(),
    };
    Figure {
        title: finding(set, columns, drawn, scores),
        subtitle: format!("{}{of_set}, {of_seeds}", counted(trials(scores, 0, 0).count(), "random plant")),
        footnote: Some(
            "Share of the plants on which E, the error of the mean force of each period, is at most this large: \
             further left is better. Errors above 1000 % are not drawn."
                .into(),
        ),
        x_label: "mean-force error E [%]".into(),
        x_decades: true,
        columns: conditions.iter().map(ToString::to_string).collect(),
        rows: vec![Row {
            y_label: "plants [%]".into(),
            y_decades: false,
            limits: Limits::Data,
            panels: (0..conditions.len()).map(panel).collect(),
        }],
    }
}

/// Returns the scores of a column under a condition: one per plant.
fn trials(scores: &[Score], column: usize, condition: usize) -> impl Iterator<Item = &Score> {
    let is_of = move |score: &&Score| score.column == column && score.condition == condition;
    scores.iter().filter(is_of)
}

/// States the share of plants with E < 20 % for the two best columns: without a delay in the paper's set, under the
/// last condition in the other sets.
fn finding(set: Set, columns: &[Column], drawn: &[usize], scores: &[Score]) -> String {
    const FAITHFUL_PERCENT: f64 = 20.0;
    let conditions = set.conditions();
    let condition = match set {
        Set::Paper => 0,
        Set::Desk | Set::Real | Set::Calibrated | Set::Steps => conditions.len() - 1,
    };
    let mut shares: Vec<(&str, f64)> = (drawn.iter().copied())
        .map(|number| {
            let faithful = trials(scores, number, condition)
                .filter(|score| score.error < FAITHFUL_PERCENT)
                .count();
            let plants = trials(scores, number, condition).count();
            (
                &*columns[number].name,
                100.0 * faithful as f64 / plants as f64,
            )
        })
        .collect();
    shares.sort_by(|a, b| b.1.total_cmp(&a.1));
    let best: Vec<String> = (shares.iter().take(2))
        .map(|(name, share)| format!("{name} on {share:.0} %"))
        .collect();
    format!(
        "E below {FAITHFUL_PERCENT} % with {}: {} of the plants",
        conditions[condition],
        best.join(", ")
    )
}
