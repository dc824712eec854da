//! The convex hull of points, by wrapping a plane around them.
//!
//! From a face, the plane turns about each of its edges until it meets the next points; all points in it are the next
//! face, whose corners are those of their hull in the plane.

use std::collections::{HashSet, VecDeque};

use super::vector::Vec3;

/// Points nearer to a plane than this share of the size of all lie in it.
const FLAT: f64 = 1e-9;

/// Corners and faces of a convex solid; a face has the numbers of its corners, counter-clockwise when seen from
/// outside.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Wrapped {
    pub corners: Vec<Vec3>,
    pub faces: Vec<Vec<usize>>,
}

impl Wrapped {
    /// Around `points`, if the solid has a volume and at most `most` corners.
    pub fn around(points: &[Vec3], most: usize) -> Option<Self> {
        let first = points
            .iter()
            .copied()
            .reduce(|a, b| if a.0.iter().lt(b.0.iter()) { a } else { b })?;
        let size = points.iter().map(|point| (*point - first).norm());
        let flat = FLAT * size.fold(0.0, f64::max);
        // No point has a smaller x than the first. Turn the plane about the y axis, then about what it has met.
        let x = Vec3([1.0, 0.0, 0.0]);
        let normal = turned_to(points, first, Vec3([0.0, 1.0, 0.0]), -x, flat)?;
        let mut faces = VecDeque::new();
        let mut face = face_in(points, first, normal, flat);
        if face.len() == 2 {
            let along = points[face[1]] - points[face[0]];
            let normal = turned_to(points, first, along.direction()?, normal, flat)?;
            face = face_in(points, first, normal, flat);
        }
        faces.push_back(face);
        let (mut found, mut done) = (Vec::new(), HashSet::new());
        while let Some(face) = faces.pop_front() {
            let edges = || {
                let next = face.iter().cycle().skip(1);
                face.iter().copied().zip(next.copied())
            };
            if face.len() < 3 || edges().next().is_none_or(|edge| done.contains(&edge)) {
                continue;
            }
            done.extend(edges());
            if found.len() > 2 * most {
                return None; // a solid has fewer faces than two for each corner
            }
            let corners = face.iter().map(|&corner| points[corner]);
            let normal = normal_of(&corners.collect::<Vec<_>>())?;
            for (from, to) in edges().filter(|(from, to)| !done.contains(&(*to, *from))) {
                let along = (points[to] - points[from]).direction()?;
                let next = turned_to(points, points[from], along, normal, flat)?;
                faces.push_back(face_in(points, points[from], next, flat));
            }
            found.push(face.clone());
        }
        let is_closed = done.iter().all(|(from, to)| done.contains(&(*to, *from)));
        let mut used: Vec<usize> = found.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let number = |corner: &usize| used.partition_point(|other| other < corner);
        let faces = found.iter().map(|face| face.iter().map(number).collect());
        let wrapped = Self {
            faces: faces.collect(),
            corners: used.iter().map(|&corner| points[corner]).collect(),
        };
        (is_closed && found.len() > 3 && wrapped.corners.len() <= most).then_some(wrapped)
    }

    /// How many corners the face with the most has.
    pub fn most_corners(&self) -> usize {
        self.faces.iter().map(Vec::len).max().unwrap_or(1)
    }
}

/// Twice the area's vector of a polygon, at length 1.
pub(super) fn normal_of(corners: &[Vec3]) -> Option<Vec3> {
    let mut sum = Vec3::ZERO;
    for (number, corner) in corners.iter().enumerate() {
        let next = corners[(number + 1) % corners.len()];
        sum += (*corner - corners[0]).cross(next - corners[0]);
    }
    sum.direction()
}

/// The plane through a line, turned about that line from `normal` until it meets a point: its normal.
fn turned_to(points: &[Vec3], on: Vec3, along: Vec3, normal: Vec3, flat: f64) -> Option<Vec3> {
    // Away from the face that the plane comes from.
    let beyond = along.cross(normal);
    let mut least: Option<(f64, f64, f64)> = None;
    for point in points {
        let off = *point - on;
        let (u, h) = (beyond.dot(off), normal.dot(off));
        let distance = u.hypot(h);
        if distance <= flat {
            continue;
        }
        // Points of the plane that it comes from are half a turn away.
        let angle = (-h).max(0.0).atan2(u);
        // Of several points in one plane, the farthest one determines the plane best.
        let is_less = least.is_none_or(|(other, far, _)| {
            angle < other - flat / distance.min(far)
                || (angle - other).abs() <= flat / distance.min(far) && distance > far
        });
        if is_less {
            least = Some((angle, distance, h));
        }
    }
    let (angle, ..) = least?;
    (normal * angle.cos() + beyond * angle.sin()).direction()
}

/// The corners of the points in a plane that all points lie behind; two where they lie in a line.
fn face_in(points: &[Vec3], on: Vec3, normal: Vec3, flat: f64) -> Vec<usize> {
    let axis = [0, 1, 2].map(|i| normal.0[i].abs());
    let least = if axis[0] <= axis[1] && axis[0] <= axis[2] {
        Vec3([1.0, 0.0, 0.0])
    } else if axis[1] <= axis[2] {
        Vec3([0.0, 1.0, 0.0])
    } else {
        Vec3([0.0, 0.0, 1.0])
    };
    let x = least.across(normal).direction().unwrap_or(Vec3::ZERO);
    let y = normal.cross(x);
    let mut flat_ones: Vec<(f64, f64, usize)> = points
        .iter()
        .enumerate()
        .filter(|(_, point)| normal.dot(**point - on).abs() <= 8.0 * flat)
        .map(|(number, point)| (x.dot(*point - on), y.dot(*point - on), number))
        .collect();
    flat_ones.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    // Andrew's chains: the lower one from left to right, the upper one back.
    let turns = |a: (f64, f64, usize), b: (f64, f64, usize), c: (f64, f64, usize)| {
        let [u, v] = [(b.0 - a.0, b.1 - a.1), (c.0 - b.0, c.1 - b.1)];
        let length = u.0.hypot(u.1).max(v.0.hypot(v.1));
        u.0 * v.1 - u.1 * v.0 > 8.0 * flat * length
    };
    let chain = |points: &mut dyn Iterator<Item = (f64, f64, usize)>| {
        let mut chain: Vec<(f64, f64, usize)> = Vec::new();
        for point in points {
            let is_same =
                |other: &(f64, f64, usize)| (other.0 - point.0).hypot(other.1 - point.1) <= flat;
            if chain.last().is_some_and(is_same) {
                continue;
            }
            while let [.., a, b] = chain[..]
                && !turns(a, b, point)
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut corners = chain(&mut flat_ones.iter().copied());
    corners.extend(chain(&mut flat_ones.iter().rev().copied()));
    corners.into_iter().map(|(.., number)| number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hull_is_closed_and_around_all_points_and_a_grid_is_a_cube() {
        let mut numbers = crate::random::SplitMix64::new(7);
        let mut cloud = |count: usize| -> Vec<Vec3> {
            (0..count)
                .map(|_| Vec3(std::array::from_fn(|_| 2.0 * numbers.unit() - 1.0)))
                .collect()
        };
        let rotation = super::super::vector::Rotation::of_quaternion([0.8, 0.3, -0.4, 0.2]);
        let grid: Vec<Vec3> = (0..64)
            .map(|k| Vec3([k % 4, k / 4 % 4, k / 16].map(f64::from)))
            .collect();
        let turned: Vec<Vec3> = grid.iter().map(|point| rotation.out(*point)).collect();
        for points in [
            grid.clone(),
            turned.clone(),
            cloud(12),
            cloud(60),
            cloud(300),
        ] {
            let wrapped = Wrapped::around(&points, 200).unwrap();
            let edges: usize = wrapped.faces.iter().map(Vec::len).sum();
            assert_eq!(wrapped.corners.len() + wrapped.faces.len(), edges / 2 + 2);
            for face in &wrapped.faces {
                let corners: Vec<Vec3> = face.iter().map(|&k| wrapped.corners[k]).collect();
                let normal = normal_of(&corners).unwrap();
                for point in &points {
                    assert!(normal.dot(*point - corners[0]) < 1e-8);
                }
            }
        }
        for points in [grid, turned] {
            let wrapped = Wrapped::around(&points, 64).unwrap();
            assert_eq!((wrapped.corners.len(), wrapped.faces.len()), (8, 6));
            assert_eq!(wrapped.most_corners(), 4);
        }
        assert_eq!(Wrapped::around(&cloud(300), 10), None);
        let flat: Vec<Vec3> = cloud(40)
            .iter()
            .map(|point| Vec3([point.0[0], point.0[1], 0.5 * point.0[1]]))
            .collect();
        assert_eq!(Wrapped::around(&flat, 64), None);
    }
}
