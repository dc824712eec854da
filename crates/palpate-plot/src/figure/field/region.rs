//! Outlines of regions of grid cells.

use std::collections::BTreeMap;

/// A grid of cells on the page, with the boundaries of its columns and rows `[px]`.
pub(super) struct Grid {
    /// Column boundaries (one more than columns), from left to right.
    pub x: Vec<f64>,
    /// Row boundaries (one more than rows), from the lower end of the axis, so the values decrease.
    pub y: Vec<f64>,
}

/// A corner between cells: column and row.
type Corner = (usize, usize);

impl Grid {
    fn columns(&self) -> usize {
        self.x.len() - 1
    }

    fn rows(&self) -> usize {
        self.y.len() - 1
    }

    /// Returns the left boundary of a column `[px]`.
    fn x(&self, column: usize) -> f64 {
        tenths(self.x[column])
    }

    /// Returns the lower boundary of a row `[px]`.
    fn y(&self, row: usize) -> f64 {
        tenths(self.y[row])
    }

    /// Returns the cells for which `inside` holds, as a path to be filled. The path consists of the outlines of the
    /// regions, so that no paper shows between two cells.
    pub fn fill(&self, inside: impl Fn(usize, usize) -> bool) -> String {
        let holds = |row: Option<usize>, column: Option<usize>| match (row, column) {
            (Some(row), Some(column)) if row < self.rows() && column < self.columns() => {
                inside(row, column)
            }
            _ => false,
        };
        // Edges from corner to corner with the region on their left; corners are (column, row).
        let mut edges: BTreeMap<Corner, Vec<Corner>> = BTreeMap::new();
        let mut add = |from: Corner, to: Corner| edges.entry(from).or_default().push(to);
        for row in 0..self.rows() {
            for column in 0..self.columns() {
                if !inside(row, column) {
                    continue;
                }
                let (r, c) = (Some(row), Some(column));
                let (right, up) = (column + 1, row + 1);
                if !holds(row.checked_sub(1), c) {
                    add((column, row), (right, row));
                }
                if !holds(r, Some(right)) {
                    add((right, row), (right, up));
                }
                if !holds(Some(up), c) {
                    add((right, up), (column, up));
                }
                if !holds(r, column.checked_sub(1)) {
                    add((column, up), (column, row));
                }
            }
        }
        let mut path = String::new();
        while let Some((&start, _)) = edges.iter().find(|(_, ends)| !ends.is_empty()) {
            let mut at = start;
            let mut heading = None;
            let mut corners = Vec::new();
            while let Some(next) = edges.get_mut(&at).and_then(Vec::pop) {
                let horizontal = next.1 == at.1;
                if heading.is_some_and(|heading| heading != horizontal) {
                    corners.push((at, horizontal));
                }
                heading = Some(horizontal);
                at = next;
                if at == start {
                    break;
                }
            }
            edges.retain(|_, ends| !ends.is_empty());
            path.push_str(&format!("M{} {}", self.x(start.0), self.y(start.1)));
            // The path's own closing draws the last leg back to the start. Relative legs are shorter to write than
            // positions.
            let mut at = start;
            for (corner, horizontal) in corners {
                path.push_str(&if horizontal {
                    format!("v{}", tenths(self.y(corner.1) - self.y(at.1)))
                } else {
                    format!("h{}", tenths(self.x(corner.0) - self.x(at.0)))
                });
                at = corner;
            }
            path.push('z');
        }
        path
    }

    /// Returns the border between the cells for which `inside` holds and the others, as a path to be stroked. The
    /// frame of the grid is not part of it.
    pub fn border(&self, inside: impl Fn(usize, usize) -> bool) -> String {
        let mut path = String::new();
        let mut add = |text: String| path.push_str(&text);
        for row in 0..self.rows() - 1 {
            let differs = |column: usize| inside(row, column) != inside(row + 1, column);
            for (from, to) in runs(self.columns(), differs) {
                let (left, y) = (self.x(from), self.y(row + 1));
                add(format!("M{left} {y}h{}", tenths(self.x(to) - left)));
            }
        }
        for column in 0..self.columns() - 1 {
            let differs = |row: usize| inside(row, column) != inside(row, column + 1);
            for (from, to) in runs(self.rows(), differs) {
                let (x, bottom) = (self.x(column + 1), self.y(from));
                add(format!("M{x} {bottom}v{}", tenths(self.y(to) - bottom)));
            }
        }
        path
    }
}

/// Returns the runs of indices below `count` for which `holds` is true, as half-open ranges.
fn runs(count: usize, holds: impl Fn(usize) -> bool) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for index in (0..count).filter(|index| holds(*index)) {
        match runs.last_mut() {
            Some(run) if run.1 == index => run.1 += 1,
            _ => runs.push((index, index + 1)),
        }
    }
    runs
}

/// Rounds to a tenth of a pixel: few digits, and no visible difference.
fn tenths(value: f64) -> f64 {
    (value * 10.0).round() / 10.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Grid {
        Grid {
            x: vec![0.0, 10.0, 20.0, 30.0],
            y: vec![20.0, 10.0, 0.0],
        }
    }

    #[test]
    fn a_region_is_its_outline() {
        let path = grid().fill(|row, column| row == 1 && column < 2);
        assert_eq!(path, "M0 10h20v-10h-20z");
        assert_eq!(grid().fill(|_, column| column == 2), "M20 20h10v-20h-10z");
        assert_eq!(grid().fill(|_, _| false), "");
    }

    #[test]
    fn corners_that_touch_and_holes_are_outlines_of_their_own() {
        let touching =
            grid().fill(|row, column| (row, column) == (0, 0) || (row, column) == (1, 1));
        assert_eq!(touching.matches('M').count(), touching.matches('z').count());
        assert!(touching.starts_with("M0 20h10v-10"), "{touching}");
        let ring = Grid {
            x: vec![0.0, 1.0, 2.0, 3.0],
            y: vec![3.0, 2.0, 1.0, 0.0],
        };
        let path = ring.fill(|row, column| (row, column) != (1, 1));
        // The hole runs in the opposite direction, so that it stays open.
        assert_eq!(path, "M0 3h3v-3h-3zM1 2v-1h1v1z");
    }

    #[test]
    fn a_border_stands_between_and_not_around() {
        let path = grid().border(|row, column| row == 0 && column < 2);
        assert_eq!(path, "M0 10h20M20 20v-10");
        assert_eq!(grid().border(|_, _| true), "");
    }
}
