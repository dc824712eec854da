//! Restriction of a figure to a part of its horizontal axis.

use super::{Figure, Kind, Row, Series, Sheet};

impl Figure {
    /// Keeps the data between two positions of the horizontal axis, both included.
    pub fn keep(&mut self, from: f64, to: f64) {
        self.rows.iter_mut().for_each(|row| keep(row, from, to));
    }
}

impl Sheet {
    /// Keeps the data between two positions of the horizontal axis, both included.
    pub fn keep(&mut self, from: f64, to: f64) {
        let grids = self.lines.iter_mut().flatten();
        grids
            .flat_map(|grid| &mut grid.rows)
            .for_each(|row| keep(row, from, to));
    }

    /// Returns the horizontal range of all samples; `None` without samples.
    #[must_use]
    pub fn reach(&self) -> Option<(f64, f64)> {
        let places = self.series().flat_map(|series| &series.x).copied();
        let finite = places.filter(|place| place.is_finite());
        super::axis::union(finite.map(|place| (place, place)))
    }
}

fn keep(row: &mut Row, from: f64, to: f64) {
    for series in row.panels.iter_mut().flat_map(|panel| &mut panel.series) {
        let kept = cut(series, from, to);
        (series.x, series.y) = kept.into_iter().unzip();
    }
}

/// Returns the samples of a series between two positions; lines and steps also get their values at both ends.
fn cut(series: &Series, from: f64, to: f64) -> Vec<(f64, f64)> {
    let samples = series.x.iter().copied().zip(series.y.iter().copied());
    let samples: Vec<(f64, f64)> = samples.collect();
    let first = samples.partition_point(|sample| sample.0 < from);
    let last = samples.partition_point(|sample| sample.0 <= to);
    let inside = &samples[first.min(last)..last];
    if series.kind == Kind::Points {
        return inside.to_vec();
    }
    let at = |place: f64, index: usize| {
        let (before, after) = (*samples.get(index.checked_sub(1)?)?, *samples.get(index)?);
        let share = (place - before.0) / (after.0 - before.0);
        let value = match series.kind {
            Kind::Step => before.1,
            _ => before.1 + share * (after.1 - before.1),
        };
        Some((place, value))
    };
    let begins = inside.first().is_some_and(|sample| sample.0 == from);
    let ends = inside.last().is_some_and(|sample| sample.0 == to);
    let mut kept = Vec::with_capacity(inside.len() + 2);
    kept.extend(at(from, first).filter(|_| !begins));
    kept.extend_from_slice(inside);
    kept.extend(at(to, last).filter(|_| !ends));
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::Role;

    fn kept(kind: Kind, from: f64, to: f64) -> Vec<(f64, f64)> {
        let series = Series {
            name: String::new(),
            kind,
            role: Role::Reference,
            x: vec![0.0, 1.0, 2.0, 3.0],
            y: vec![0.0, 10.0, 20.0, 0.0],
        };
        cut(&series, from, to)
    }

    #[test]
    fn a_part_begins_and_ends_where_it_is_asked_to() {
        assert_eq!(
            kept(Kind::Line, 0.5, 2.5),
            [(0.5, 5.0), (1.0, 10.0), (2.0, 20.0), (2.5, 10.0)]
        );
        assert_eq!(
            kept(Kind::Step, 0.5, 2.5),
            [(0.5, 0.0), (1.0, 10.0), (2.0, 20.0), (2.5, 20.0)]
        );
        assert_eq!(kept(Kind::Points, 0.5, 2.0), [(1.0, 10.0), (2.0, 20.0)]);
    }

    #[test]
    fn a_part_between_two_samples_or_beyond_all_is_there() {
        assert_eq!(kept(Kind::Line, 1.25, 1.5), [(1.25, 12.5), (1.5, 15.0)]);
        assert_eq!(kept(Kind::Line, 1.0, 2.0), [(1.0, 10.0), (2.0, 20.0)]);
        assert_eq!(kept(Kind::Line, 4.0, 5.0), []);
        assert_eq!(kept(Kind::Line, -2.0, 0.5), [(0.0, 0.0), (0.5, 5.0)]);
    }
}
