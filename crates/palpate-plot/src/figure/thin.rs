//! Reduction of samples without visible change.

/// Reduces each run of points within one column of width `cell` to its first, lowest, highest and last point, in
/// their order. The visible line stays the same, peaks included.
pub(super) fn thin(points: &[(f64, f64)], cell: f64) -> Vec<(f64, f64)> {
    let mut kept = Vec::new();
    let column = |point: &(f64, f64)| (point.0 / cell).floor();
    for run in points.chunk_by(|a, b| column(a).total_cmp(&column(b)).is_eq()) {
        let indices = 0..run.len();
        let by_height = |a: &usize, b: &usize| run[*a].1.total_cmp(&run[*b].1);
        let lowest = indices.clone().min_by(by_height);
        let highest = indices.max_by(by_height);
        let mut keep = [Some(0), lowest, highest, run.len().checked_sub(1)];
        keep.sort_unstable();
        let mut before = None;
        for index in keep.into_iter().flatten() {
            if before != Some(index) {
                kept.push(run[index]);
            }
            before = Some(index);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_points_stay_as_they_are() {
        let points = [(0.0, 1.0), (1.0, -1.0), (2.0, 0.0)];
        assert_eq!(thin(&points, 0.5), points);
        assert!(thin(&[], 0.5).is_empty());
    }

    #[test]
    fn first_lowest_highest_and_last_of_a_column_stay_in_order() {
        let points = [
            (0.0, 1.0),
            (0.1, 9.0),
            (0.2, 2.0),
            (0.3, -9.0),
            (0.4, 3.0),
            (0.5, 4.0),
        ];
        assert_eq!(
            thin(&points, 1.0),
            [(0.0, 1.0), (0.1, 9.0), (0.3, -9.0), (0.5, 4.0)]
        );
    }

    #[test]
    fn a_single_peak_among_many_survives() {
        let mut points: Vec<(f64, f64)> = (0..100_000).map(|i| (f64::from(i), 0.0)).collect();
        points[54_321].1 = 7.0;
        points[54_322].1 = -7.0;
        let thinned = thin(&points, 200.0);
        assert!(thinned.len() <= 4 * 500);
        assert!(thinned.contains(&(54_321.0, 7.0)) && thinned.contains(&(54_322.0, -7.0)));
    }
}
