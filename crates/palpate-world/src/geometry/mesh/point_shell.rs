//! Points distributed over a mesh's surface, for its contacts with other solids.

use super::build::Mesh;
use crate::Vector;
use crate::geometry::convex::hull;
use crate::geometry::hull::MAX_CORNERS;
use crate::geometry::rigid::{Rotation, Vector3};

/// Spacing of the candidate positions on a triangle, relative to the mean distance between points.
const CANDIDATES: f64 = 0.25;
/// Approximate maximum number of candidates along an edge, and in total.
const MAX_ALONG: f64 = 64.0;
const MAX_CANDIDATES: f64 = 2e5;
/// Maximum relative excess of the reported widest gap.
const SURPLUS: f64 = 1.01;
/// Distance from a triangle's plane, relative to the mesh's size, below which a point is in the plane.
const IN_PLANE: f64 = 1e-6;

/// Points of a surface. Each is a possible contact with an equal share of a contact's law.
#[derive(Clone, Debug, PartialEq)]
pub struct PointShell {
    places: Vec<Vector3>,
    shared_by: usize,
    widest: f64,
}

/// Reason for rejecting a point shell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum InvalidShell {
    /// Too few or too many points.
    #[error("the shell has {0} points, and has to have 4 to {most}", most = PointShell::MAX_POINTS)]
    Points(usize),
    /// More points in a plane than may touch at a time.
    #[error(
        "the shell has {points} points, of which {in_plane} lie in one plane, and at most {most} may touch at a time: \
         use fewer points", most = PointShell::MAX_ALWAYS
    )]
    Flat {
        /// Number of points.
        points: usize,
        /// Number of points in the plane of one triangle.
        in_plane: usize,
    },
    /// Share out of range.
    #[error(
        "the law is shared by {shared_by} points, and has to be shared by 1 to {points}, the size of the shell"
    )]
    SharedBy {
        /// Requested number.
        shared_by: usize,
        /// Number of points.
        points: usize,
    },
}

impl PointShell {
    /// Maximum number of points of a shell.
    pub const MAX_POINTS: usize = 2048;

    /// Number of points above which a shell is large. A tick evaluates all points of other shells in every sub-step.
    /// For large shells it evaluates only points that touch or may touch within a period, in a world at most
    /// 1.5 times this number.
    pub const MAX_ALWAYS: usize = MAX_CORNERS;

    /// Distributes `points` points (at least 4) over a mesh. They include all corners of its convex hull, unless the
    /// hull has more corners than `points`: then half of the points are vertices. The remaining points fill the
    /// widest gaps.
    ///
    /// # Errors
    /// The number of points is out of range, or more of them lie in a plane than [may touch](Self::MAX_ALWAYS) at a
    /// time.
    pub fn over(mesh: &Mesh, points: usize) -> Result<Self, InvalidShell> {
        if !(4..=Self::MAX_POINTS).contains(&points) {
            return Err(InvalidShell::Points(points));
        }
        let size = mesh.reach();
        // Extremal points touch first. On a round solid any vertex can be extremal.
        let corners = hull(mesh.places(), IN_PLANE * size, points);
        let (corners, most) = match corners {
            Ok((corners, _)) => (corners, points),
            Err(_) => (mesh.places().to_vec(), points.div_ceil(2)),
        };
        let all = candidates(mesh, points);
        let mut places = Vec::with_capacity(points);
        let middle = corners.iter().sum::<Vector3>() / corners.len() as f64;
        spread(&mut places, &corners, most, &middle);
        spread(&mut places, &all, points, &middle);
        let widest = bound_of_gaps(mesh, &places);
        let shared_by = most_in_a_plane(mesh, &places, IN_PLANE * size);
        if shared_by > Self::MAX_ALWAYS {
            return Err(InvalidShell::Flat {
                points: places.len(),
                in_plane: shared_by,
            });
        }
        Ok(Self {
            places,
            shared_by,
            widest,
        })
    }

    /// Sets the number of points that share a contact's law: each has K, B and k_t divided by it.
    ///
    /// # Errors
    /// The number is 0 or exceeds the number of points.
    pub fn shared_by(self, points: usize) -> Result<Self, InvalidShell> {
        if !(1..=self.places.len()).contains(&points) {
            return Err(InvalidShell::SharedBy {
                shared_by: points,
                points: self.places.len(),
            });
        }
        Ok(Self {
            shared_by: points,
            ..self
        })
    }

    /// Returns the points in the mesh's axes `[m]`.
    #[must_use]
    pub fn points(&self) -> Vec<Vector> {
        self.places.iter().map(|&place| place.into()).collect()
    }

    /// Returns the number of points that share a contact's law. By default it is the largest number in the plane of a
    /// triangle, so that a flat side on a plane has at most the full stiffness.
    #[must_use]
    pub fn sharers(&self) -> usize {
        self.shared_by
    }

    /// Returns an upper bound of the distance from any surface position to the nearest point `[m]`, at most one
    /// percent above the exact value. Narrower objects may pass between points.
    #[must_use]
    pub fn widest_gap(&self) -> f64 {
        self.widest
    }

    pub(crate) fn places(&self) -> &[Vector3] {
        &self.places
    }

    /// Returns the same points in axes with origin `centre` `[m]` and orientation `orientation`.
    pub(super) fn seen_from(&self, centre: &Vector3, orientation: &Rotation) -> Self {
        let places = self.places.iter();
        Self {
            places: places
                .map(|place| orientation.inverse_transform_vector(&(place - centre)))
                .collect(),
            ..*self
        }
    }
}

/// Adds positions until there are `count`, each time the one furthest from all present ones. The first is the
/// position furthest from `middle`.
fn spread(places: &mut Vec<Vector3>, from: &[Vector3], count: usize, middle: &Vector3) {
    let off = |place: &Vector3, to: &Vector3| (place - to).norm_squared();
    let mut nearest: Vec<f64> = from
        .iter()
        .map(|place| {
            let each = places.iter().map(|other| off(place, other));
            each.fold(f64::INFINITY, f64::min)
        })
        .collect();
    loop {
        let furthest = (0..from.len()).max_by(|&a, &b| {
            let key = |number: usize| {
                if places.is_empty() {
                    off(&from[number], middle)
                } else {
                    nearest[number]
                }
            };
            // Ties go to the lower index.
            key(a).total_cmp(&key(b)).then(b.cmp(&a))
        });
        let Some(furthest) = furthest else {
            return;
        };
        if places.len() >= count || nearest[furthest] == 0.0 {
            return;
        }
        let place = from[furthest];
        places.push(place);
        for (nearest, other) in nearest.iter_mut().zip(from) {
            *nearest = nearest.min(off(other, &place));
        }
    }
}

/// Returns an upper bound of the distance from any surface position to the nearest of `places` `[m]`, at most
/// [`SURPLUS`] times the exact value.
///
/// A distance changes by at most the displacement. For all positions of a triangle it is therefore at most the
/// distance at the centroid plus that from the centroid to the furthest corner. Triangles that could exceed the
/// largest distance so far are split at their longest side.
fn bound_of_gaps(mesh: &Mesh, places: &[Vector3]) -> f64 {
    let gap = |from: &Vector3| {
        let ways = places.iter().map(|place| (place - from).norm_squared());
        ways.fold(f64::INFINITY, f64::min).sqrt()
    };
    let mut longest = mesh.places().iter().map(gap).fold(0.0, f64::max);
    for number in 0..super::tree::size(mesh.faces.len()) {
        let mut left = vec![mesh.corners(number).map(|corner| *corner)];
        while let Some([a, b, c]) = left.pop() {
            let middle = (a + b + c) / 3.0;
            let way = gap(&middle);
            longest = longest.max(way);
            let reach = [a, b, c].map(|corner| (corner - middle).norm());
            if way + reach.into_iter().fold(0.0, f64::max) <= SURPLUS * longest {
                continue;
            }
            let length = |[from, to, _]: &[Vector3; 3]| (to - from).norm_squared();
            let mut sides = [[a, b, c], [b, c, a], [c, a, b]];
            sides.sort_by(|one, other| length(other).total_cmp(&length(one)));
            let [[from, to, other], ..] = sides;
            let half = (from + to) * 0.5;
            left.extend([[from, half, other], [half, to, other]]);
        }
    }
    SURPLUS * longest
}

/// Returns the candidate positions for points: all corners, and a lattice on each triangle.
fn candidates(mesh: &Mesh, points: usize) -> Vec<Vector3> {
    let triangles = || (0..super::tree::size(mesh.faces.len())).map(|number| mesh.corners(number));
    let area_of = |[a, b, c]: [&Vector3; 3]| 0.5 * (b - a).cross(&(c - a)).norm();
    let area: f64 = triangles().map(area_of).sum();
    let finest = (2.0 * area / MAX_CANDIDATES).sqrt();
    let apart = (CANDIDATES * (area / points as f64).sqrt()).max(finest);
    let mut all = mesh.places().to_vec();
    for [a, b, c] in triangles() {
        let longest = [b - a, c - b, a - c].map(|side| side.norm());
        let longest = longest.into_iter().fold(0.0, f64::max);
        let along = (longest / apart).ceil().min(MAX_ALONG);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "it is at most MAX_ALONG"
        )]
        let along = along as u32;
        for i in 0..=along {
            for j in 0..=along - i {
                let [s, t] = [i, j].map(|k| f64::from(k) / f64::from(along));
                all.push(a + (b - a) * s + (c - a) * t);
            }
        }
    }
    all
}

fn most_in_a_plane(mesh: &Mesh, places: &[Vector3], slack: f64) -> usize {
    let normals = &mesh.topology.normals;
    let in_plane = |(number, normal): (u32, &Vector3)| {
        let [corner, ..] = mesh.corners(number);
        let is_in = |place: &&Vector3| normal.dot(&(*place - corner)).abs() <= slack;
        places.iter().filter(is_in).count()
    };
    (0..).zip(normals).map(in_plane).max().unwrap_or(0).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a block of 20 x 10 x 30 mm, with each side divided into squares of 5 mm.
    fn block() -> Mesh {
        let [nx, ny, nz] = [4_u32, 2, 6];
        let number = |x: u32, y: u32, z: u32| x + (nx + 1) * (y + (ny + 1) * z);
        let mut vertices = Vec::new();
        for z in 0..=nz {
            for y in 0..=ny {
                for x in 0..=nx {
                    vertices.push([x, y, z].map(|k| 5e-3 * f64::from(k)));
                }
            }
        }
        let mut faces = Vec::new();
        let mut square = |a: u32, b: u32, c: u32, d: u32| {
            faces.push([a, b, c]);
            faces.push([a, c, d]);
        };
        for x in 0..nx {
            for y in 0..ny {
                for (z, up) in [(0, false), (nz, true)] {
                    let corners = [
                        number(x, y, z),
                        number(x + 1, y, z),
                        number(x + 1, y + 1, z),
                        number(x, y + 1, z),
                    ];
                    let [a, b, c, d] = corners;
                    if up {
                        square(a, b, c, d)
                    } else {
                        square(a, d, c, b)
                    }
                }
            }
            for z in 0..nz {
                for (y, back) in [(0, false), (ny, true)] {
                    let [a, b, c, d] = [
                        number(x, y, z),
                        number(x + 1, y, z),
                        number(x + 1, y, z + 1),
                        number(x, y, z + 1),
                    ];
                    if back {
                        square(a, d, c, b)
                    } else {
                        square(a, b, c, d)
                    }
                }
            }
        }
        for y in 0..ny {
            for z in 0..nz {
                for (x, right) in [(0, false), (nx, true)] {
                    let [a, b, c, d] = [
                        number(x, y, z),
                        number(x, y + 1, z),
                        number(x, y + 1, z + 1),
                        number(x, y, z + 1),
                    ];
                    if right {
                        square(a, b, c, d)
                    } else {
                        square(a, d, c, b)
                    }
                }
            }
        }
        // Vertices inside the block belong to no triangle.
        Mesh::new(&vertices, &faces).unwrap()
    }

    #[test]
    fn the_corners_come_first_and_no_place_is_far_from_a_point() {
        let mesh = block();
        assert!((mesh.volume() - 6e-6).abs() < 1e-15);
        let shell = PointShell::over(&mesh, 40).unwrap();
        assert_eq!(shell.points().len(), 40);
        for corner in 0..8 {
            let at = [2e-2, 1e-2, 3e-2];
            let corner: Vector = [0, 1, 2].map(|axis| {
                if corner >> axis & 1 == 0 {
                    0.0
                } else {
                    at[axis]
                }
            });
            let is_there = |point: &Vector| {
                let off = Vector3::from(*point) - Vector3::from(corner);
                off.norm() < 1e-12
            };
            assert!(shell.points().iter().any(is_there), "{corner:?}");
        }
        // 2200 mm^2 over 40 points: squares of 7.4 mm.
        assert!(shell.widest_gap() < 7.5e-3, "{}", shell.widest_gap());
        let furthest = furthest_sample(&mesh, &shell, 60);
        let said = shell.widest_gap() / furthest;
        assert!((1.0..1.02).contains(&said), "{said} of {furthest} m");
        let on_largest = shell.points().iter().filter(|p| p[1].abs() < 1e-12).count();
        assert!(shell.sharers() >= on_largest && on_largest > 6);
    }

    /// Returns the largest distance to a point of the shell over `along` sample positions per side of each triangle
    /// `[m]`.
    fn furthest_sample(mesh: &Mesh, shell: &PointShell, along: u32) -> f64 {
        let mut furthest = 0.0_f64;
        for (number, _) in (0..).zip(mesh.faces()) {
            let [a, b, c] = mesh.corners(number);
            for i in 0..=along {
                for j in 0..=along - i {
                    let [s, t] = [i, j].map(|k| f64::from(k) / f64::from(along));
                    let at = a + (b - a) * s + (c - a) * t;
                    let ways = shell.places().iter().map(|place| (place - at).norm());
                    furthest = furthest.max(ways.fold(f64::INFINITY, f64::min));
                }
            }
        }
        furthest
    }

    #[test]
    fn the_widest_gap_of_slender_triangles_is_a_bound() {
        // 200 mm long, 2 mm wide: a shell of four points has only the corners.
        let rod = Mesh::new(
            &[
                [0.0; 3],
                [0.2, 0.0, 0.0],
                [0.1, 2e-3, 0.0],
                [0.1, 1e-3, 1.5e-3],
            ],
            &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        );
        let rod = rod.unwrap();
        for points in [4, 5, 12] {
            let shell = PointShell::over(&rod, points).unwrap();
            let furthest = furthest_sample(&rod, &shell, 500);
            let said = shell.widest_gap() / furthest;
            assert!(
                (1.0..1.02).contains(&said),
                "{points}: {said} of {furthest} m"
            );
        }
    }

    #[test]
    fn what_cannot_be_a_shell_is_refused() {
        let mesh = block();
        assert_eq!(
            PointShell::over(&mesh, 3).unwrap_err(),
            InvalidShell::Points(3)
        );
        assert_eq!(
            PointShell::over(&mesh, 2049).unwrap_err(),
            InvalidShell::Points(2049)
        );
        let shell = PointShell::over(&mesh, 8).unwrap();
        assert!(shell.clone().shared_by(0).is_err());
        assert!(shell.clone().shared_by(9).is_err());
        assert_eq!(shell.shared_by(8).unwrap().sharers(), 8);
    }
}
