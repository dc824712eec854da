//! Nearest point of a triangle.

use crate::geometry::rigid::Vector3;

/// Part of a triangle: its interior, or the edge or corner with this index. Edge k goes from corner k to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Region {
    Inside,
    Edge(usize),
    Corner(usize),
}

/// Returns the nearest point and the part of the triangle on which it lies (Ericson, *Real-Time Collision Detection*,
/// 2005, section 5.1.5).
pub(super) fn nearest([a, b, c]: [&Vector3; 3], place: &Vector3) -> (Vector3, Region) {
    let (ab, ac) = (b - a, c - a);
    let from_a = place - a;
    let (d1, d2) = (ab.dot(&from_a), ac.dot(&from_a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (*a, Region::Corner(0));
    }
    let from_b = place - b;
    let (d3, d4) = (ab.dot(&from_b), ac.dot(&from_b));
    if d3 >= 0.0 && d4 <= d3 {
        return (*b, Region::Corner(1));
    }
    let of_c = d1 * d4 - d3 * d2;
    if of_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (a + ab * (d1 / (d1 - d3)), Region::Edge(0));
    }
    let from_c = place - c;
    let (d5, d6) = (ab.dot(&from_c), ac.dot(&from_c));
    if d6 >= 0.0 && d5 <= d6 {
        return (*c, Region::Corner(2));
    }
    let of_b = d5 * d2 - d1 * d6;
    if of_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (a + ac * (d2 / (d2 - d6)), Region::Edge(2));
    }
    let of_a = d3 * d6 - d5 * d4;
    if of_a <= 0.0 && d4 >= d3 && d5 >= d6 {
        let share = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return (b + (c - b) * share, Region::Edge(1));
    }
    let sum = of_a + of_b + of_c;
    (a + ab * (of_b / sum) + ac * (of_c / sum), Region::Inside)
}

/// Returns the signed distance of a position from each edge, in the projection along the normal, positive inside
/// `[m]`.
pub(super) fn inside(corners: [&Vector3; 3], normal: &Vector3, place: &Vector3) -> [f64; 3] {
    let along = edges(corners);
    let lengths = [0, 1, 2].map(|k| along[k].norm());
    inside_of(
        &along,
        &lengths,
        normal,
        &[0, 1, 2].map(|k| place - corners[k]),
    )
}

/// Returns the signed distances of [inside](inside()) for a position with offset `off` from each corner `[m]`, given
/// the edges and their lengths `[m]`.
pub(super) fn inside_of(
    along: &[Vector3; 3],
    lengths: &[f64; 3],
    normal: &Vector3,
    off: &[Vector3; 3],
) -> [f64; 3] {
    let of_edge = |k: usize| normal.cross(&along[k]).dot(&off[k]) / lengths[k];
    [of_edge(0), of_edge(1), of_edge(2)]
}

/// Returns the edge vectors from each corner to the next.
pub(super) fn edges([a, b, c]: [&Vector3; 3]) -> [Vector3; 3] {
    [b - a, c - b, a - c]
}

/// Returns a lower bound of the displacement that brings a position [inside](inside()) all edges `[m]`.
pub(super) fn outside(inside: &[f64; 3]) -> f64 {
    inside.iter().fold(0.0, |way, inside| way.max(-inside))
}

/// Returns only the nearest point.
pub(crate) fn nearest_point(corners: [&Vector3; 3], place: &Vector3) -> Vector3 {
    nearest(corners, place).0
}

/// Returns the intersection of the segment between two positions with the triangle, as a fraction of the segment;
/// `None` if there is none.
pub(super) fn crossing(
    [a, b, c]: [&Vector3; 3],
    normal: &Vector3,
    from: &Vector3,
    to: &Vector3,
) -> Option<f64> {
    let (above, below) = (normal.dot(&(from - a)), normal.dot(&(to - a)));
    if (above > 0.0) == (below > 0.0) {
        return None;
    }
    let share = above / (above - below);
    let place = from + (to - from) * share;
    // The tolerance beyond the edges closes the gap between adjacent triangles.
    let is_within = [(a, b), (b, c), (c, a)].into_iter().all(|(start, end)| {
        let along = end - start;
        let inward = normal.cross(&along);
        inward.dot(&(place - start)) >= -1e-9 * along.norm_squared()
    });
    is_within.then_some(share)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners() -> [Vector3; 3] {
        [
            Vector3::new(0.1, -0.2, 0.3),
            Vector3::new(1.1, 0.1, 0.2),
            Vector3::new(0.3, 0.9, -0.4),
        ]
    }

    /// Comparison with many points of the triangle.
    #[test]
    fn no_point_of_the_triangle_is_nearer() {
        let corners = corners();
        let of = || corners.each_ref();
        let [a, b, c] = corners;
        let mut regions = [0; 3];
        for number in 0..400 {
            let part = |prime: f64| 4.0 * ((f64::from(number) * prime).fract() - 0.5);
            let place = Vector3::new(part(0.754_877), part(0.569_840), part(0.430_160));
            let (nearest, region) = nearest(of(), &place);
            let distance = (place - nearest).norm();
            regions[match region {
                Region::Inside => 0,
                Region::Edge(_) => 1,
                Region::Corner(_) => 2,
            }] += 1;
            let mut least = f64::INFINITY;
            for (i, j) in (0..=60).flat_map(|i| (0..=60 - i).map(move |j| (i, j))) {
                let [s, t] = [i, j].map(|k| f64::from(k) / 60.0);
                least = least.min((a + (b - a) * s + (c - a) * t - place).norm());
            }
            assert!(distance <= least + 1e-12, "{region:?}");
            assert!(distance > least - 0.03, "{region:?}");
        }
        assert!(regions.iter().all(|&count| count > 3), "{regions:?}");
    }

    #[test]
    fn a_way_through_the_triangle_crosses_it_and_one_beside_it_does_not() {
        let corners = corners();
        let of = || corners.each_ref();
        let [a, b, c] = corners;
        let normal = (b - a).cross(&(c - a)).normalize();
        let middle = (a + b + c) / 3.0;
        let share = crossing(of(), &normal, &(middle + normal), &(middle - normal * 3.0));
        assert!((share.unwrap() - 0.25).abs() < 1e-12);
        let beside = a + (a - middle) * 0.1;
        assert!(crossing(of(), &normal, &(beside + normal), &(beside - normal)).is_none());
        assert!(crossing(of(), &normal, &(middle + normal * 2.0), &(middle + normal)).is_none());
    }
}
