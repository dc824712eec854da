//! Two boxes, and the candidate planes between them.

use super::{Between, Found, PARALLEL, PREFERENCE, Plane};
use crate::geometry::rigid::{Rigid, Vector3};

/// Number of corners of a box.
const CORNERS: usize = 8;
/// Number of corners of a face, which share the law of a pair.
pub(super) const ON_A_FACE: usize = 4;

/// Ratio of two lengths above which the first is the larger one in spite of rounding.
const CERTAINLY: f64 = 1.0 + 1e-9;

/// Poses of the two boxes: centre and axes of each, and the vector from the first to the second `[m]`.
pub(super) struct Placed {
    pub(super) centres: [Vector3; 2],
    axes: [[Vector3; 3]; 2],
    pub(super) half: [Vector3; 2],
    pub(super) way: Vector3,
    /// Components of `way` along the axes of each box `[m]`.
    along: [[f64; 3]; 2],
    /// Cosines between the axes of the first box (rows) and those of the second.
    cosines: [[f64; 3]; 3],
}

/// Returns the axis and side of a face by its index.
fn axis_of(number: usize) -> (usize, bool) {
    (number / 2, number % 2 == 1)
}

fn side(positive: bool) -> f64 {
    if positive { 1.0 } else { -1.0 }
}

impl Placed {
    pub(super) fn new(rigids: [&Rigid; 2], half: [Vector3; 2]) -> Self {
        let axes = rigids.map(|rigid| {
            let turned = rigid.orientation.to_rotation_matrix();
            [0, 1, 2].map(|axis| turned.matrix().column(axis).into_owned())
        });
        let centres = rigids.map(|rigid| rigid.position);
        let way = centres[1] - centres[0];
        Self {
            centres,
            axes,
            half,
            way,
            along: axes.map(|axes| axes.map(|axis| axis.dot(&way))),
            cosines: axes[0].map(|a| axes[1].map(|b| a.dot(&b))),
        }
    }

    /// Returns the cosine between an axis of a box and an axis of the other.
    fn cosine(&self, of: usize, axis: usize, other: usize) -> f64 {
        if of == 0 {
            self.cosines[axis][other]
        } else {
            self.cosines[other][axis]
        }
    }

    /// Returns the vector from the centre of a box to a corner `[m]`.
    pub(super) fn corner(&self, of: usize, number: usize) -> Vector3 {
        let (axes, half) = (&self.axes[of], &self.half[of]);
        let along = |axis: usize| axes[axis] * (side(number >> axis & 1 == 1) * half[axis]);
        along(0) + along(1) + along(2)
    }

    /// Returns the overlap of the boxes in the direction of a plane: the length p with E = K/2 p^2, or the negative
    /// gap `[m]`. A depth that is certainly above `most` `[m]` is returned as infinite.
    fn depth_below(&self, plane: Plane, most: f64) -> f64 {
        match plane {
            Plane::Face { of, number } => {
                let (axis, positive) = axis_of(number);
                let towards = if of == 0 { 1.0 } else { -1.0 };
                let way = towards * side(positive) * self.along[of][axis];
                let middle = self.half[of][axis] - way;
                let half = &self.half[1 - of];
                let parts = [0, 1, 2].map(|i| half[i] * self.cosine(of, axis, i));
                let deepest = middle + parts.iter().map(|part| part.abs()).sum::<f64>();
                if deepest <= 0.0 {
                    return deepest;
                }
                // One of the four corners of the law is this deep.
                if deepest > CERTAINLY * (ON_A_FACE as f64).sqrt() * most {
                    return f64::INFINITY;
                }
                let mut squares = 0.0;
                for number in 0..CORNERS {
                    let signed = |i: usize| side(number >> i & 1 == 1) * parts[i];
                    let depth = middle - (signed(0) + signed(1) + signed(2));
                    squares += depth.max(0.0).powi(2);
                }
                (squares / ON_A_FACE as f64).sqrt()
            }
            Plane::Edges([i, j]) => {
                // Overlap along the cross product of axis i of the first and j of the second, times the sine between
                // them.
                let after = |axis: usize| [(axis + 1) % 3, (axis + 2) % 3];
                let ([k, l], [m, n]) = (after(i), after(j));
                let (c, [one, other]) = (&self.cosines, &self.half);
                let extents = one[k] * c[l][j].abs()
                    + one[l] * c[k][j].abs()
                    + other[m] * c[i][n].abs()
                    + other[n] * c[i][m].abs();
                let way = self.along[0][l] * c[k][j] - self.along[0][k] * c[l][j];
                let overlap = extents - way.abs();
                // A sine is at most 1.
                if overlap > CERTAINLY * most.max(0.0) {
                    return f64::INFINITY;
                }
                overlap / self.sine(i, j)
            }
        }
    }

    fn depth(&self, plane: Plane) -> f64 {
        self.depth_below(plane, f64::INFINITY)
    }

    /// Returns the sine between an axis of the first box and one of the second.
    fn sine(&self, i: usize, j: usize) -> f64 {
        (1.0 - self.cosines[i][j].powi(2)).max(0.0).sqrt()
    }

    /// Returns the face of a box across an axis that faces the other box.
    fn face(&self, of: usize, axis: usize) -> Plane {
        let along = self.along[of][axis];
        let positive = if of == 0 { along >= 0.0 } else { along <= 0.0 };
        Plane::Face {
            of,
            number: 2 * axis + usize::from(positive),
        }
    }

    /// Returns the midpoint between the closest edges of the two boxes across a plane `[m]`.
    fn crossing(&self, pair: [usize; 2], normal: &Vector3) -> Vector3 {
        let middle = |of: usize, towards: Vector3| {
            let mut place = self.centres[of];
            for axis in (0..3).filter(|&axis| axis != pair[of]) {
                let along = self.axes[of][axis];
                place += along * self.half[of][axis].copysign(along.dot(&towards));
            }
            place
        };
        let (one, other) = (middle(0, -normal), middle(1, *normal));
        let (u, v) = (self.axes[0][pair[0]], self.axes[1][pair[1]]);
        let (between, cosine) = (other - one, u.dot(&v));
        // Closest points of two lines along unit vectors.
        let sine_square = 1.0 - cosine * cosine;
        let along_u = (u.dot(&between) - cosine * v.dot(&between)) / sine_square;
        let along_v = (cosine * u.dot(&between) - v.dot(&between)) / sine_square;
        0.5 * (one + u * along_u + other + v * along_v)
    }
}

impl Between for Placed {
    fn normal(&self, plane: Plane) -> Vector3 {
        match plane {
            Plane::Face { of, number } => {
                let (axis, positive) = axis_of(number);
                let out = self.axes[of][axis] * side(positive);
                if of == 0 { -out } else { out }
            }
            Plane::Edges([i, j]) => {
                let across = self.axes[0][i].cross(&self.axes[1][j]);
                let out = across / across.norm();
                if out.dot(&self.way) > 0.0 { -out } else { out }
            }
        }
    }

    fn least(&self, before: Option<Plane>) -> (Plane, f64) {
        let start = before.unwrap_or(self.face(0, 0));
        let mut least = (start, self.depth(start));
        let mut look = |plane: Plane| {
            let depth = self.depth_below(plane, least.1);
            if depth < least.1 - PREFERENCE * least.1.abs() {
                least = (plane, depth);
            }
        };
        for number in 0..6 {
            look(self.face(number / 3, number % 3));
        }
        for number in 0..9 {
            let [i, j] = [number / 3, number % 3];
            if self.sine(i, j) > PARALLEL {
                look(Plane::Edges([i, j]));
            }
        }
        least
    }

    fn points(&self, plane: Plane, found: &mut [Found]) {
        match plane {
            Plane::Face { of, number } => {
                let (axis, positive) = axis_of(number);
                let out = self.axes[of][axis] * side(positive);
                let other = 1 - of;
                for (number, found) in found.iter_mut().enumerate() {
                    let corner = self.centres[other] + self.corner(other, number);
                    let above = out.dot(&(corner - self.centres[of])) - self.half[of][axis];
                    *found = Found {
                        penetration: -above,
                        place: corner - out * (0.5 * above),
                    };
                }
            }
            Plane::Edges(pair) => {
                let place = self.crossing(pair, &self.normal(plane));
                Found::cross(found, self.depth(plane), place, ON_A_FACE);
            }
        }
    }
}
