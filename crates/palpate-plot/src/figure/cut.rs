//! Clipping of lines to a range of heights.

/// Returns the pieces of the polyline `points` whose height lies within `low..=high`.
///
/// SVG and PDF readers do not accept coordinates far outside the page; clipping removes them.
pub(super) fn cut(points: &[(f64, f64)], low: f64, high: f64) -> Vec<Vec<(f64, f64)>> {
    let inside = |point: (f64, f64)| low <= point.1 && point.1 <= high;
    let mut pieces = Vec::new();
    let mut piece: Vec<(f64, f64)> = Vec::new();
    if let [only] = points {
        return if inside(*only) {
            vec![vec![*only]]
        } else {
            vec![]
        };
    }
    for pair in points.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        if let Some((start, end)) = segment(from, to, low, high) {
            if piece.is_empty() {
                piece.push(start);
            }
            piece.push(end);
        }
        if !inside(to) && !piece.is_empty() {
            pieces.push(std::mem::take(&mut piece));
        }
    }
    if !piece.is_empty() {
        pieces.push(piece);
    }
    pieces
}

type Segment = ((f64, f64), (f64, f64));

/// Returns the part of one segment within the band, if any.
fn segment(from: (f64, f64), to: (f64, f64), low: f64, high: f64) -> Option<Segment> {
    let (bottom, top) = (from.1.min(to.1), from.1.max(to.1));
    if top < low || bottom > high {
        return None;
    }
    let rise = to.1 - from.1;
    let at = |height: f64| {
        let share = ((height - from.1) / rise).clamp(0.0, 1.0);
        (from.0 + share * (to.0 - from.0), height)
    };
    let bound = |point: (f64, f64)| match point.1 {
        height if height < low => at(low),
        height if height > high => at(high),
        _ => point,
    };
    Some((bound(from), bound(to)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_inside_stays_whole() {
        let points = [(0.0, 0.0), (1.0, 1.0), (2.0, 0.5)];
        assert_eq!(cut(&points, 0.0, 1.0), [points]);
    }

    #[test]
    fn a_line_is_cut_where_it_crosses() {
        let points = [(0.0, 0.0), (4.0, 4.0), (8.0, 0.0)];
        assert_eq!(
            cut(&points, -1.0, 1.0),
            [[(0.0, 0.0), (1.0, 1.0)], [(7.0, 1.0), (8.0, 0.0)]]
        );
    }

    #[test]
    fn a_line_that_crosses_the_whole_band_leaves_its_middle() {
        assert_eq!(
            cut(&[(0.0, -2.0), (1.0, 2.0)], -1.0, 1.0),
            [[(0.25, -1.0), (0.75, 1.0)]]
        );
    }

    #[test]
    fn what_lies_outside_is_gone() {
        assert!(cut(&[(0.0, 2.0), (1.0, 3.0)], -1.0, 1.0).is_empty());
        assert!(cut(&[(0.0, 2.0)], -1.0, 1.0).is_empty());
        assert!(cut(&[], -1.0, 1.0).is_empty());
    }

    #[test]
    fn large_numbers_are_cut_like_any_other() {
        let pieces = cut(&[(0.0, -1e100), (1.0, 1e100)], -1.0, 1.0);
        assert_eq!(pieces, [[(0.5, -1.0), (0.5, 1.0)]]);
    }
}
