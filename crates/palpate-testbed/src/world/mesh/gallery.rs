//! Closed meshes by formula.

use std::collections::HashMap;
use std::f64::consts::TAU;

use super::super::scene::Vector;
use crate::world::vector::Vec3;

/// Vertices `[m]`, and triangles by the numbers of their corners.
pub type Triangles = (Vec<Vector>, Vec<[u32; 3]>);

/// A sphere with bumps and hollows: along a direction (x, y, z) its surface is at
/// radius + height sin(waves x) sin(waves y) sin(waves z) from the centre `[m]`.
///
/// `cells` is how many squares, of two triangles each, lie along each edge of the cube that it is made from: it has
/// 12 cells² triangles.
#[must_use]
pub fn bumpy_sphere(radius: f64, height: f64, waves: f64, cells: u32) -> Triangles {
    let mut numbers: HashMap<[u32; 3], u32> = HashMap::new();
    let mut vertices = Vec::new();
    let mut number = |place: [u32; 3]| {
        *numbers.entry(place).or_insert_with(|| {
            // Equal angles, so that the triangles have about one size.
            let tangent =
                |k: u32| (TAU / 8.0 * (2.0 * f64::from(k) / f64::from(cells) - 1.0)).tan();
            let out = Vec3(place.map(tangent));
            let out = out * (1.0 / out.norm());
            let bump: f64 = out.0.iter().map(|x| (waves * x).sin()).product();
            vertices.push((out * (radius + height * bump)).0);
            index(vertices.len() - 1)
        })
    };
    let mut faces = Vec::new();
    for axis in 0..3 {
        for (far, (i, j)) in [0, cells]
            .into_iter()
            .flat_map(|far| (0..cells).flat_map(move |i| (0..cells).map(move |j| (far, (i, j)))))
        {
            let mut corner = |u: u32, v: u32| {
                let mut place = [far; 3];
                place[(axis + 1) % 3] = u;
                place[(axis + 2) % 3] = v;
                number(place)
            };
            let (a, b) = (corner(i, j), corner(i + 1, j));
            let (c, d) = (corner(i + 1, j + 1), corner(i, j + 1));
            for [x, y, z] in [[a, b, c], [a, c, d]] {
                faces.push(if far == 0 { [x, z, y] } else { [x, y, z] });
            }
        }
    }
    (vertices, faces)
}

/// The solid that a profile sweeps around the z axis.
///
/// `profile` has points (distance from the axis, z) `[m]`; the first and the last are on the axis, and the solid lies
/// to the left of the way from one to the next. No piece is longer than `longest` `[m]`, and around the axis there are
/// `segments` pieces.
///
/// `None` where the profile has fewer than three points, does not begin and end on the axis, or touches it between,
/// there are fewer than 3 segments, or `longest` is not above 0.
#[must_use]
pub fn revolved(profile: &[[f64; 2]], segments: u32, longest: f64) -> Option<Triangles> {
    let (first, middle, last) = match profile {
        [first, middle @ .., last] if !middle.is_empty() => (first, middle, last),
        _ => return None,
    };
    let is_right = first[0] == 0.0
        && last[0] == 0.0
        && middle.iter().all(|point| point[0] > 0.0)
        && segments >= 3
        && longest > 0.0;
    if !is_right {
        return None;
    }
    let mut fine = Vec::new();
    for pair in profile.windows(2) {
        let ([r, z], [s, y]) = (pair[0], pair[1]);
        let pieces = ((s - r).hypot(y - z) / longest).ceil().clamp(1.0, 1e4);
        let mut piece = 0.0;
        while piece < pieces {
            let share = piece / pieces;
            fine.push([r + (s - r) * share, z + (y - z) * share]);
            piece += 1.0;
        }
    }
    fine.push(*last);
    let rings = &fine[1..fine.len() - 1];
    let mut vertices = vec![[0.0, 0.0, first[1]], [0.0, 0.0, last[1]]];
    for [r, z] in rings {
        for segment in 0..segments {
            let (sine, cosine) = (TAU * f64::from(segment) / f64::from(segments)).sin_cos();
            vertices.push([r * cosine, r * sine, *z]);
        }
    }
    let at = |ring: usize, segment: u32| 2 + index(ring) * segments + segment % segments;
    let mut faces = Vec::new();
    for k in 0..segments {
        faces.push([0, at(0, k + 1), at(0, k)]);
        for ring in 0..rings.len() - 1 {
            let [a, b] = [at(ring, k), at(ring, k + 1)];
            let [c, d] = [at(ring + 1, k + 1), at(ring + 1, k)];
            faces.extend([[a, b, c], [a, c, d]]);
        }
        let end = rings.len() - 1;
        faces.push([1, at(end, k), at(end, k + 1)]);
    }
    Some((vertices, faces))
}

fn index(count: usize) -> u32 {
    #[expect(clippy::cast_possible_truncation, reason = "far fewer than 2^32")]
    let index = count as u32;
    index
}

#[cfg(test)]
mod tests {
    use super::super::TriangleMesh;
    use super::*;

    fn volume((vertices, faces): &Triangles) -> f64 {
        let cones = faces.iter().map(|face| {
            let [a, b, c] = face.map(|corner| Vec3(vertices[corner as usize]));
            a.dot(b.cross(c)) / 6.0
        });
        cones.sum()
    }

    #[test]
    fn solids_are_closed_and_enclose_their_volume() {
        let ball = bumpy_sphere(0.04, 0.0, 1.0, 33);
        assert_eq!(ball.1.len(), 13_068);
        let exact = TAU * 2.0 / 3.0 * 0.04_f64.powi(3);
        assert!(
            (volume(&ball) / exact - 1.0).abs() < 2e-3,
            "{}",
            volume(&ball)
        );
        let shaft = [
            [0.0, 0.0],
            [0.01, 0.0],
            [0.01, 0.02],
            [0.006, 0.02],
            [0.006, 0.05],
            [0.0, 0.05],
        ];
        let shaft = revolved(&shaft, 200, 0.002).unwrap();
        let exact = TAU / 2.0 * (1e-4 * 0.02 + 3.6e-5 * 0.03);
        assert!(
            (volume(&shaft) / exact - 1.0).abs() < 1e-3,
            "{}",
            volume(&shaft)
        );
        for (vertices, faces) in [ball, bumpy_sphere(0.04, 0.001, 9.0, 12), shaft] {
            let mesh = TriangleMesh::new(&vertices, &faces).unwrap();
            assert!(mesh.edges.iter().all(|edge| edge.faces.len() == 2));
            assert_eq!(mesh.vertices.len() + mesh.faces.len(), mesh.edges.len() + 2);
        }
    }

    #[test]
    fn what_is_no_profile_sweeps_nothing() {
        let cone = [[0.0, 0.0], [0.01, 0.0], [0.0, 0.01]];
        assert!(revolved(&cone, 3, 0.1).is_some());
        assert!(revolved(&cone, 2, 0.1).is_none());
        assert!(revolved(&cone, 3, f64::NAN).is_none());
        assert!(revolved(&cone[1..], 3, 0.1).is_none());
        assert!(revolved(&[[0.0, 0.0], [0.0, 0.1], [0.0, 0.2]], 3, 0.1).is_none());
    }
}
