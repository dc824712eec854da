//! Conversion of samples to drawn lines.

use super::axis::LARGEST;
use super::cut::cut;
use super::thin::thin;
use super::{Kind, Series};

/// The visible part of the plane of a panel, and its resolution.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    /// Range of the horizontal axis.
    pub x: (f64, f64),
    /// Range of the vertical axis.
    pub y: (f64, f64),
    /// Width of one pixel in units of the horizontal axis.
    pub pixel: f64,
}

/// The drawn elements of a series.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Strokes {
    /// Polylines, or groups of single points.
    pub pieces: Vec<Vec<(f64, f64)>>,
    /// First horizontal position at which the series rises above the window.
    pub above: Option<f64>,
    /// First horizontal position at which the series falls below the window.
    pub below: Option<f64>,
}

pub(super) fn strokes(series: &Series, window: &Window) -> Strokes {
    let (low, high) = window.y;
    let samples = || series.x.iter().copied().zip(series.y.iter().copied());
    let mut pieces = Vec::new();
    for run in runs(&samples().collect::<Vec<_>>(), series.kind == Kind::Step) {
        let run = thin(&run, window.pixel);
        match series.kind {
            Kind::Points => pieces.push(
                run.into_iter()
                    .filter(|&(_, y)| (low..=high).contains(&y))
                    .collect(),
            ),
            Kind::Line => pieces.extend(cut(&visible(run, window), low, high)),
            Kind::Step => pieces.extend(cut(&visible(stairs(&run), window), low, high)),
        }
    }
    pieces.retain(|piece: &Vec<_>| !piece.is_empty());
    // The marker of a series that leaves the window is at the intersection of its line and the edge.
    let leaves = |outside: &dyn Fn(f64) -> bool, edge: f64| {
        let (x, _) = samples().find(|&(x, y)| x.abs() <= LARGEST && outside(y))?;
        let lines = pieces.iter().filter(|_| series.kind != Kind::Points);
        let met = lines.flatten().find(|point| point.1 == edge);
        Some(met.map_or(x, |point| point.0))
    };
    let above = leaves(&|y| y > high, high);
    let below = leaves(&|y| y < low, low);
    Strokes {
        pieces,
        above,
        below,
    }
}

/// Returns the runs of finite samples. A held value extends to the next sample's time even if that sample has no
/// value.
fn runs(samples: &[(f64, f64)], holds: bool) -> Vec<Vec<(f64, f64)>> {
    let finite = |sample: &(f64, f64)| sample.0.abs() <= LARGEST && sample.1.abs() <= LARGEST;
    let mut runs = Vec::new();
    let mut run: Vec<(f64, f64)> = Vec::new();
    for sample in samples {
        if finite(sample) {
            run.push(*sample);
        } else if let Some(&(_, held)) = run.last() {
            if holds && sample.0.abs() <= LARGEST {
                run.push((sample.0, held));
            }
            runs.push(std::mem::take(&mut run));
        }
    }
    runs.push(run);
    runs.retain(|run| !run.is_empty());
    runs
}

/// Returns the corners of a zero-order hold.
fn stairs(samples: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut corners = Vec::with_capacity(2 * samples.len());
    for &(x, y) in samples {
        if let Some(&(_, held)) = corners.last()
            && held != y
        {
            corners.push((x, held));
        }
        corners.push((x, y));
    }
    corners
}

/// Draws a single sample as a short line, since a line without length is invisible.
fn visible(mut points: Vec<(f64, f64)>, window: &Window) -> Vec<(f64, f64)> {
    if let [(x, y)] = points[..] {
        points = vec![(x - window.pixel, y), (x + window.pixel, y)];
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::Role;

    const WINDOW: Window = Window {
        x: (0.0, 10.0),
        y: (-1.0, 1.0),
        pixel: 0.01,
    };

    fn draw(kind: Kind, y: &[f64]) -> Strokes {
        let x = (0..y.len()).map(|i| i as f64).collect();
        let (name, role) = (String::new(), Role::Compared(0));
        strokes(
            &Series {
                name,
                kind,
                role,
                x,
                y: y.to_vec(),
            },
            &WINDOW,
        )
    }

    #[test]
    fn a_line_is_broken_where_there_is_no_value() {
        let drawn = draw(Kind::Line, &[0.0, 0.5, f64::NAN, 0.2, 0.1, f64::INFINITY]);
        assert_eq!(
            drawn.pieces,
            [[(0.0, 0.0), (1.0, 0.5)], [(3.0, 0.2), (4.0, 0.1)]]
        );
        assert_eq!((drawn.above, drawn.below), (Some(5.0), None));
    }

    #[test]
    fn a_lone_sample_is_drawn() {
        assert_eq!(
            draw(Kind::Line, &[f64::NAN, 0.5, f64::NAN]).pieces,
            [[(0.99, 0.5), (1.01, 0.5)]]
        );
    }

    #[test]
    fn a_hold_is_a_staircase_that_reaches_the_gap() {
        assert_eq!(
            draw(Kind::Step, &[0.0, 0.5, f64::NAN, 0.2]).pieces,
            [
                vec![(0.0, 0.0), (1.0, 0.0), (1.0, 0.5), (2.0, 0.5)],
                vec![(2.99, 0.2), (3.01, 0.2)]
            ]
        );
    }

    #[test]
    fn points_outside_are_not_drawn_but_known() {
        let drawn = draw(Kind::Points, &[0.0, 3.0, -2.0, 1.0]);
        assert_eq!(drawn.pieces, [[(0.0, 0.0), (3.0, 1.0)]]);
        assert_eq!((drawn.above, drawn.below), (Some(1.0), Some(2.0)));
    }

    #[test]
    fn no_value_at_all_draws_nothing() {
        assert_eq!(draw(Kind::Line, &[f64::NAN; 3]), Strokes::default());
        assert_eq!(draw(Kind::Step, &[]), Strokes::default());
    }
}
