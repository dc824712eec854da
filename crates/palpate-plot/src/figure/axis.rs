//! Ranges and ticks of the axes.

use std::collections::BTreeMap;

use kuva::render::render_utils::compute_tick_step;

use super::{Kind, Limits, Role, Row, Series, Sheet};

/// Margin above and below the data, as a share of the data's range.
const AIR: f64 = 0.06;

/// Minimum margin beside a mark, as a share of the data's range.
const BESIDE_A_MARK: f64 = 0.02;

/// Largest magnitude that can be drawn; larger values count as infinite `[unit of the axis]`.
pub(super) const LARGEST: f64 = 1e100;

/// Returns the shared range of the horizontal axes.
pub(super) fn horizontal(sheet: &Sheet) -> (f64, f64) {
    let places = sheet.series().flat_map(|series| series.x.iter().copied());
    let (low, high) = span(places).unwrap_or((0.0, 1.0));
    if sheet.x_decades {
        // Extend to full powers of ten, or few ticks would be shown. The margin keeps the last number of a panel
        // clear of the first number of the next.
        let (first, last) = (low.floor(), high.ceil().max(low.floor() + 1.0));
        (first - 0.125, last + 0.125)
    } else if has_height(low, high) {
        // A mark at the end needs a margin, or half of it is cut off.
        let marks = sheet
            .series()
            .filter(|series| series.role == Role::Mark && series.kind == Kind::Points);
        let (first, last) = span(marks.flat_map(|series| series.x.iter().copied()))
            .unwrap_or((f64::INFINITY, f64::NEG_INFINITY));
        let air = BESIDE_A_MARK * (high - low);
        (low.min(first - air), high.max(last + air))
    } else {
        around(low)
    }
}

/// Vertical ranges by the label of their rows.
pub(super) type Shared<'a> = BTreeMap<&'a str, (f64, f64)>;

/// Returns the common range of all rows with the same label; empty if each row has its own range.
pub(super) fn shared(sheet: &Sheet) -> Shared<'_> {
    let mut shared = Shared::new();
    if !sheet.same_scales {
        return shared;
    }
    for row in sheet.lines.iter().flatten().flat_map(|grid| &grid.rows) {
        let (low, high) = vertical(row);
        let range = shared.entry(&*row.y_label).or_insert((low, high));
        *range = (range.0.min(low), range.1.max(high));
    }
    shared
}

/// Returns the shared range of the vertical axes of a row.
pub(super) fn vertical(row: &Row) -> (f64, f64) {
    let series: Vec<&Series> = row.panels.iter().flat_map(|panel| &panel.series).collect();
    let heights = |series: &Series| span(series.y.iter().copied());
    let Some(data) = union(series.iter().filter_map(|series| heights(series))) else {
        return (-1.0, 1.0);
    };
    let (low, high) = match row.limits {
        Limits::Data => data,
        Limits::Calm { times } => {
            let reference = series.iter().filter(|series| series.role.is_reference());
            let calm = union(reference.filter_map(|series| heights(series)))
                .filter(|range| range.1 > range.0)
                .unwrap_or_else(|| {
                    calmer_half(series.iter().filter_map(|series| heights(series)).collect())
                });
            let reach = 0.5 * (times - 1.0).max(0.0) * (calm.1 - calm.0);
            if calm.1 > calm.0 {
                (data.0.max(calm.0 - reach), data.1.min(calm.1 + reach))
            } else {
                data
            }
        }
    };
    if row.y_decades {
        let (first, last) = (low.floor(), high.ceil().max(low.floor() + 1.0));
        (first - 0.05, last + 0.05)
    } else if has_height(low, high) {
        let air = AIR * (high - low);
        (low - air, high + air)
    } else {
        around(low)
    }
}

/// Whether `f64` arithmetic resolves the two ends of a range and the values between them.
fn has_height(low: f64, high: f64) -> bool {
    let size = low.abs().max(high.abs());
    size <= LARGEST && (high - low).abs() > (1e-12 * size).max(LARGEST.recip())
}

/// Returns a range around one value; its half-width is half the magnitude of the value.
fn around(value: f64) -> (f64, f64) {
    let half = if value.abs() > 1.0 / LARGEST.sqrt() {
        0.5 * value.abs()
    } else {
        1.0
    };
    (value - half, value + half)
}

/// Returns the union of the narrower half of the ranges.
fn calmer_half(mut ranges: Vec<(f64, f64)>) -> (f64, f64) {
    ranges.sort_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)));
    let half = ranges.len().div_ceil(2);
    union(ranges.into_iter().take(half)).unwrap_or((0.0, 0.0))
}

fn span(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    union(
        values
            .filter(|value| value.abs() <= LARGEST)
            .map(|value| (value, value)),
    )
}

pub(super) fn union(ranges: impl Iterator<Item = (f64, f64)>) -> Option<(f64, f64)> {
    ranges.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// Returns the distance of the ticks for about one tick per `room` of `length` `[px]`.
pub(super) fn tick_step(range: (f64, f64), length: f64, room: f64) -> f64 {
    let width = range.1 - range.0;
    let mut spaces = (length / room).round().clamp(2.0, 10.0);
    // The rule rounds to the nearest round step, which may be the next smaller one.
    loop {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "2 to 10"
        )]
        let step = compute_tick_step(range.0, range.1, spaces as usize);
        if width / step <= length / room || spaces <= 2.0 {
            return with_two(range, step);
        }
        spaces -= 1.0;
    }
}

/// Returns the largest round step up to `step` that has two ticks in the range: a single number shows no scale.
fn with_two(range: (f64, f64), mut step: f64) -> f64 {
    const LESS: f64 = 1e-9;
    let ticks = |step: f64| (range.1 / step + LESS).floor() - (range.0 / step - LESS).ceil() + 1.0;
    // After three reductions any range has two ticks.
    for _ in 0..4 {
        if ticks(step) >= 2.0 {
            break;
        }
        let leading = step / 10.0_f64.powf((step.log10() + LESS).floor());
        // Steps from 5 to 2.5, 2, 1 and 0.5.
        step *= if (leading - 2.5).abs() < 0.1 {
            0.8
        } else {
            0.5
        };
    }
    step
}

/// Returns the label of the tick at `value`, as short as the distance of the ticks allows.
pub(super) fn tick_label(value: f64, step: f64) -> String {
    // Snap to 0: a multiple of the step that differs from 0 only by rounding.
    let value = if value.abs() < 1e-6 * step {
        0.0
    } else {
        value
    };
    let size = value.abs();
    let text = if size == 0.0 && step < 1e-4 {
        "0".to_owned()
    } else if size >= 1e5 || step < 1e-4 {
        let places = (size / step).log10().ceil().clamp(0.0, 15.0) + 1.0;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 to 16"
        )]
        let text = format!("{value:.*e}", places as usize);
        let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
        let digits = if digits.contains('.') {
            digits.trim_end_matches('0').trim_end_matches('.')
        } else {
            digits
        };
        format!("{digits}e{power}")
    } else {
        format!("{value:.*}", decimals(step))
    };
    text.replace('-', "\u{2212}")
}

/// Returns the label of a tick on a logarithmic axis; `value` is the decimal logarithm of the quantity. Below 0.001
/// and above 1000 the label is a power of ten, so that the first label of a panel stays clear of the last label of
/// the panel beside it.
pub(super) fn decade_label(value: f64) -> String {
    let decade = value.round();
    if decade.abs() > 3.0 {
        return format!("1e{decade}").replace('-', "\u{2212}");
    }
    let shown = 10.0_f64.powf(decade);
    tick_label(shown, shown)
}

/// Returns the number of decimals needed to write every multiple of `step`.
fn decimals(step: f64) -> usize {
    let mut scaled = step;
    for places in 0..6 {
        if (scaled - scaled.round()).abs() < 1e-6 * scaled {
            return places;
        }
        scaled *= 10.0;
    }
    6
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::{Figure, Kind, Panel, Role};

    fn series(role: Role, y: &[f64]) -> Series {
        let (name, kind) = (String::new(), Kind::Line);
        Series {
            name,
            kind,
            role,
            x: vec![0.0; y.len()],
            y: y.to_vec(),
        }
    }

    fn range(limits: Limits, series: Vec<Series>) -> (f64, f64) {
        let (y_label, panels) = (String::new(), vec![Panel { series }]);
        vertical(&Row {
            y_label,
            y_decades: false,
            limits,
            panels,
        })
    }

    #[test]
    fn a_diverging_series_does_not_flatten_the_reference() {
        let (low, high) = range(
            Limits::Calm { times: 3.0 },
            vec![
                series(Role::Reference, &[0.0, 1.0]),
                series(Role::Compared(0), &[0.0, -0.5, 1e9]),
            ],
        );
        assert!(low < -0.5 && low > -1.0, "{low}");
        assert!(high > 2.0 && high < 2.5, "{high}");
    }

    #[test]
    fn without_a_reference_the_calmer_half_counts() {
        let (low, high) = range(
            Limits::Calm { times: 3.0 },
            vec![
                series(Role::Compared(0), &[0.0, 1.0]),
                series(Role::Compared(1), &[0.0, 1.2]),
                series(Role::Compared(2), &[0.0, 1e300]),
            ],
        );
        assert!(low > -0.5 && high < 3.0, "{low}..{high}");
    }

    #[test]
    fn decades_reach_from_one_power_of_ten_to_another() {
        let decades = |x: &[f64]| {
            let mut series = series(Role::Compared(0), x);
            series.x = x.to_vec();
            let (low, high) = horizontal(&Sheet::from(&Figure {
                x_decades: true,
                rows: vec![Row {
                    panels: vec![Panel {
                        series: vec![series],
                    }],
                    ..Row::default()
                }],
                ..Figure::default()
            }));
            (low + 0.125, high - 0.125)
        };
        assert_eq!(decades(&[0.7, 1.9, 2.99]), (0.0, 3.0));
        assert_eq!(decades(&[-1.2, f64::INFINITY, 0.0]), (-2.0, 0.0));
        assert_eq!(decades(&[2.0]), (2.0, 3.0));
        assert_eq!(decades(&[]), (0.0, 1.0));
    }

    #[test]
    fn every_range_has_a_height() {
        for y in [
            &[0.0][..],
            &[7.0, 7.0],
            &[-1e-12],
            &[f64::NAN],
            &[],
            &[f64::MIN, f64::MAX],
        ] {
            for limits in [Limits::Data, Limits::default()] {
                let (low, high) = range(limits, vec![series(Role::Compared(0), y)]);
                assert!(has_height(low, high), "{y:?}: {low}..{high}");
            }
        }
    }

    #[test]
    fn a_low_axis_has_two_numbers() {
        let ticks = |range: (f64, f64)| {
            let step = tick_step(range, 36.0, 26.0);
            let first = (range.0 / step).ceil();
            let places = (0..9).map(|tick| (first + f64::from(tick)) * step);
            places.take_while(|place| *place <= range.1).count()
        };
        for range in [
            (-0.034, 0.022),
            (0.9, 2.1),
            (-0.011, 0.0),
            (6.5, 19.5),
            (-3e-7, 4e-7),
        ] {
            assert!(
                (2..=4).contains(&ticks(range)),
                "{range:?}: {}",
                ticks(range)
            );
        }
        assert!((tick_step((-0.034, 0.022), 36.0, 26.0) - 0.025).abs() < 1e-12);
    }

    #[test]
    fn tick_labels_are_short() {
        let label = |value, step| tick_label(value, step);
        assert_eq!(label(0.1 + 0.2, 0.1), "0.3");
        assert_eq!(label(0.25, 0.25), "0.25");
        assert_eq!(label(-2.0, 1.0), "\u{2212}2");
        assert_eq!(label(-1e-17, 0.1), "0.0");
        assert_eq!(label(3.0 * 1e-6, 1e-6), "3e\u{2212}6");
        assert_eq!(label(0.0, 5e-6), "0");
        assert_eq!(label(2.5e7, 5e6), "2.5e7");
        assert_eq!(label(1000.0, 500.0), "1000");
        let decades: Vec<String> = (-4..5).map(|at| decade_label(f64::from(at))).collect();
        let expected = [
            "1e\u{2212}4",
            "0.001",
            "0.01",
            "0.1",
            "1",
            "10",
            "100",
            "1000",
            "1e4",
        ];
        assert_eq!(decades, expected);
    }

    #[test]
    fn a_mark_at_the_end_has_room_beside_it() {
        let at = |role, kind, x: &[f64]| Series {
            name: String::new(),
            kind,
            role,
            x: x.to_vec(),
            y: vec![0.0; x.len()],
        };
        let reach = |mark: f64| {
            let series = vec![
                at(Role::Compared(0), Kind::Line, &[0.0, 10.0]),
                at(Role::Mark, Kind::Points, &[mark]),
            ];
            let rows = vec![Row {
                panels: vec![Panel { series }],
                ..Row::default()
            }];
            horizontal(&Sheet::from(&Figure {
                rows,
                ..Figure::default()
            }))
        };
        assert_eq!(reach(5.0), (0.0, 10.0));
        assert_eq!(reach(10.0), (0.0, 10.2));
        assert_eq!(reach(0.0), (-0.2, 10.0));
    }
}
