//! The tables of docs/results/readings.md: the committed columns over the start heights.

use palpate_study::heights::over_heights;
use palpate_study::suite::Column;

use crate::common::{PAPER_SCENES, experiments, scene};

/// A row of a table: the column's name, and FRE `[%]` at the scene's own height, median and worst of
/// 21 on the paper's three scenes.
type Row = (&'static str, [[f64; 3]; 3]);

/// Columns without several dampings.
const ROWS: [Row; 10] = [
    (
        "damper, spring-and-damper, B = K T/2",
        [
            [33.7, 82.1, 91.2],
            [100.3, 100.7, 104.1],
            [194.1, 192.5, 223.9],
        ],
    ),
    (
        "damper, spring, B = K T/2",
        [
            [99.9, 84.5, 102.2],
            [93.0, 93.4, 99.1],
            [151.4, 172.6, 292.2],
        ],
    ),
    (
        "damper, held-force, B = K T/2",
        [
            [82.2, 64.3, 87.7],
            [107.9, 107.9, 112.6],
            [165.1, 178.6, 226.8],
        ],
    ),
    (
        "hfcr, crossing, b = 0",
        [
            [15.0, 15.0, 15.7],
            [22.7, 22.8, 23.2],
            [107.7, 106.3, 112.9],
        ],
    ),
    (
        "hfcr, sample, b = 0",
        [[14.1, 14.2, 14.5], [23.1, 23.1, 23.5], [97.8, 97.8, 126.6]],
    ),
    (
        "hfcr, midpoint, b = 0",
        [[17.0, 16.3, 17.9], [22.7, 24.1, 26.4], [85.9, 86.6, 108.5]],
    ),
    (
        "damper, extrapolation, B = K T/2",
        [
            [88.2, 88.2, 91.9],
            [81.0, 82.3, 94.2],
            [175.5, 172.5, 221.9],
        ],
    ),
    (
        "damper, observer, B = K T/2",
        [
            [86.3, 87.1, 95.7],
            [90.3, 90.3, 98.6],
            [113.8, 121.3, 195.3],
        ],
    ),
    (
        "hfcr, extrapolation, b = 0",
        [
            [30.0, 29.4, 30.0],
            [38.2, 38.2, 39.0],
            [114.4, 114.6, 117.9],
        ],
    ),
    (
        "hfcr, observer, b = 0",
        [
            [22.3, 21.7, 22.4],
            [34.8, 34.0, 34.8],
            [111.4, 108.8, 114.2],
        ],
    ),
];

/// Source: derived here, on the paper's scenes; `palpate paper heights` with the committed columns.
#[test]
fn the_committed_columns_have_the_errors_of_the_tables() {
    let text = std::fs::read_to_string(experiments().join("columns/readings.toml")).unwrap();
    let columns: Vec<Column> = Column::parse(&text)
        .unwrap()
        .into_iter()
        .filter(|column| ROWS.iter().any(|(name, _)| *name == column.name))
        .collect();
    assert_eq!(columns.len(), ROWS.len());
    for (place, name) in PAPER_SCENES.into_iter().enumerate() {
        let found = over_heights(&scene(name), &columns, || ()).unwrap();
        for (column, found) in columns.iter().zip(found) {
            let (_, rows) = ROWS.iter().find(|(name, _)| *name == column.name).unwrap();
            let [own, median, worst] = rows[place];
            let given = found.force_rendering_error;
            eprintln!("{name}, {}: {given:.1?}", column.name);
            // Chaotic loops amplify rounding.
            let tolerance = if median > 60.0 { 1.0 } else { 0.1 };
            for (given, expected) in [
                (given.own, own),
                (given.median, median),
                (given.worst, worst),
            ] {
                assert!(
                    (given - expected).abs() <= tolerance,
                    "{name}, {}: {given:.2} for {expected}",
                    column.name
                );
            }
        }
    }
}
