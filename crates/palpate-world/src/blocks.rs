//! Contact of two boxes: the plane between them that costs least.
//!
//! A face of one box bounds a half-space, and the other box overlaps it by corners, as it does a half-space that is a
//! body: E = K/8 sum of p^2 over the corners at depth p > 0. Two edges that cross have a plane between them too, along
//! both; they overlap by p and E = K/2 p^2. The pair stores the least E of all these planes: three faces of each
//! box, on the side of the other one, and nine pairs of edges. Two boxes are apart where one of the planes separates them
//! (S. Gottschalk, M. C. Lin, D. Manocha, OBBTree, 1996), so the pair pushes exactly while they overlap.
//!
//! The least of smooth functions is continuous, and where two of them are equal it bends downwards only. So the energy has
//! no jump where another plane takes over, and the pair does not stay at such a place.

use crate::law::PointLaw;
use crate::moving::Touch;
use crate::pairs::Point;
use crate::rigid::{Rigid, Vector3};

/// Points of contact of two boxes: the corners of one, or four quarters of the law where two edges cross.
pub(crate) const POINTS_PER_BLOCKS: usize = 8;
/// How many of them share the law of a pair: a face that lies flat has four corners.
pub(crate) const QUARTERS: usize = 4;

/// The law of each.
pub(crate) fn quarter(law: &crate::ContactLaw) -> PointLaw {
    PointLaw::share(law, 4.0)
}

/// Another plane takes over where its depth is less by more than this part of it: round-off decides nothing, and no energy
/// is made.
const PREFERENCE: f64 = 1e-9;
/// Sine of the angle below which two edges are parallel: a face of one of the boxes costs less than the plane between
/// them then.
const PARALLEL: f64 = 1e-6;

/// A plane that may be between two boxes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Plane {
    /// A face: of the first (0) or second (1) box, across that axis, on its positive side or not.
    Face {
        of: usize,
        axis: usize,
        positive: bool,
    },
    /// Along an edge of each box: the axes along which the first's and the second's are.
    Edges([usize; 2]),
}

/// Where the two boxes are: centre and axes of each, and the way from the first to the second `[m]`.
struct Placed {
    centres: [Vector3; 2],
    axes: [[Vector3; 3]; 2],
    half: [Vector3; 2],
    way: Vector3,
    /// The way along the axes of each `[m]`.
    along: [[f64; 3]; 2],
    /// Cosines between the first's axes (rows) and the second's.
    cosines: [[f64; 3]; 3],
}

/// What is found at one of the points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    /// Below 0 where the point does not touch `[m]`.
    pub penetration: f64,
    /// Midway between the two surfaces `[m]`.
    pub place: Vector3,
}

/// Two boxes that can touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blocks {
    /// Their numbers among tools and bodies.
    pub parts: [usize; 2],
    half: [Vector3; 2],
    /// The first of their points.
    first_point: usize,
    plane: Option<Plane>,
    /// How far the two overlap by the plane `[m]`: E = K/2 of its square; below 0 where it separates them.
    depth: f64,
    /// From the second box to the first.
    normal: Vector3,
    found: [Found; POINTS_PER_BLOCKS],
}

impl Blocks {
    pub fn new(parts: [usize; 2], half: [Vector3; 2], first_point: usize) -> Self {
        Self {
            parts,
            half,
            first_point,
            plane: None,
            depth: f64::NEG_INFINITY,
            normal: Vector3::x(),
            found: [Found {
                penetration: f64::NEG_INFINITY,
                place: Vector3::zeros(),
            }; POINTS_PER_BLOCKS],
        }
    }

    pub fn found(&self, number: usize) -> &Found {
        &self.found[number]
    }

    pub fn normal(&self) -> Vector3 {
        self.normal
    }

    /// Half the diagonal of each box `[m]`.
    pub fn reaches(&self) -> [f64; 2] {
        self.half.map(|half| half.norm())
    }

    /// The boxes were put to other places.
    pub fn forget(&mut self) {
        self.plane = None;
        self.depth = f64::NEG_INFINITY;
    }

    /// Whether they touched or touch by another plane than `other` does.
    pub fn changed_from(&self, other: &Self) -> bool {
        self.plane != other.plane && (self.depth > 0.0 || other.depth > 0.0)
    }

    /// Looks for the plane between the boxes as they are now. Where another one takes over, their `touches` are handed
    /// on to its points.
    pub fn look(&mut self, first: &Rigid, second: &Rigid, touches: &mut [Touch], points: &[Point]) {
        let placed = Placed::new([first, second], self.half);
        let before = if self.depth > 0.0 { self.plane } else { None };
        let gap = placed.way.norm() - self.half[0].norm() - self.half[1].norm();
        if gap > 0.0 && before.is_none() {
            self.plane = None;
            self.depth = -gap;
            for found in &mut self.found {
                found.penetration = -gap;
            }
            return;
        }
        let (plane, depth) = placed.least(before);
        self.plane = Some(plane);
        self.depth = depth;
        self.normal = placed.normal(plane);
        self.found = placed.points(plane);
        if let Some(before) = before
            && before != plane
        {
            let range = self.first_point..self.first_point + POINTS_PER_BLOCKS;
            let law = &points[self.first_point].law;
            let by_old = placed.points(before);
            let keeps = before.corners_of() == plane.corners_of();
            hand_on(&mut touches[range], law, &by_old, &self.found, keeps);
        }
    }
}

impl Plane {
    /// The box whose corners touch.
    fn corners_of(&self) -> Option<usize> {
        match self {
            Self::Face { of, .. } => Some(1 - of),
            Self::Edges(_) => None,
        }
    }
}

/// Bristles go from the points of one plane to the nearest ones of another that touch: none is lost while there are as many,
/// and so neither force nor energy of friction. `keeps`: the points are the same corners, and each keeps its own.
fn hand_on(
    touches: &mut [Touch],
    law: &PointLaw,
    old: &[Found; POINTS_PER_BLOCKS],
    new: &[Found; POINTS_PER_BLOCKS],
    keeps: bool,
) {
    let stored =
        |touch: &Touch, found: &Found| law.stored(found.penetration.max(0.0), &touch.bristle);
    let mut by_old = [0.0; POINTS_PER_BLOCKS];
    for (stored_there, (touch, found)) in by_old.iter_mut().zip(touches.iter().zip(old)) {
        *stored_there = stored(touch, found);
    }
    if !keeps {
        let mut goes_to = [None; POINTS_PER_BLOCKS];
        let mut taken = [false; POINTS_PER_BLOCKS];
        // The nearest two that are left, again and again.
        for _ in 0..POINTS_PER_BLOCKS {
            let mut nearest: Option<(f64, usize, usize)> = None;
            for (from, touch) in touches.iter().enumerate() {
                if goes_to[from].is_some() || touch.is_apart() {
                    continue;
                }
                for (to, found) in new.iter().enumerate() {
                    if taken[to] || found.penetration <= 0.0 {
                        continue;
                    }
                    let way = (found.place - touch.place).norm_squared();
                    if nearest.is_none_or(|(least, ..)| way < least) {
                        nearest = Some((way, from, to));
                    }
                }
            }
            let Some((_, from, to)) = nearest else {
                break;
            };
            goes_to[from] = Some(to);
            taken[to] = true;
        }
        let mut before = [Touch::apart(); POINTS_PER_BLOCKS];
        before.copy_from_slice(touches);
        for (from, to) in goes_to.iter_mut().enumerate() {
            // What has nowhere to go takes a place that does not touch, where its bristle is let go.
            let free = taken.iter().position(|taken| !taken).unwrap_or(from);
            let to = *to.get_or_insert(free);
            taken[to] = true;
            touches[to] = before[from].at_the_point_of(&before[to]);
        }
    }
    let mut handed = [0.0; POINTS_PER_BLOCKS];
    for (number, (touch, found)) in touches.iter().zip(new).enumerate() {
        handed[number] = stored(touch, found) - by_old[number];
    }
    // All planes cost the same where one takes over; what a sub-step went beyond that is its error.
    let beyond = handed.iter().sum::<f64>() / handed.len() as f64;
    for (touch, handed) in touches.iter_mut().zip(handed) {
        touch.past.handed += handed - beyond;
    }
}

fn side(positive: bool) -> f64 {
    if positive { 1.0 } else { -1.0 }
}

impl Placed {
    fn new(rigids: [&Rigid; 2], half: [Vector3; 2]) -> Self {
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

    /// Cosine between an axis of a box and one of the other.
    fn cosine(&self, of: usize, axis: usize, other: usize) -> f64 {
        if of == 0 {
            self.cosines[axis][other]
        } else {
            self.cosines[other][axis]
        }
    }

    /// From the centre of a box to its corner of that number `[m]`.
    fn corner(&self, of: usize, number: usize) -> Vector3 {
        let (axes, half) = (&self.axes[of], &self.half[of]);
        let along = |axis: usize| axes[axis] * (side(number >> axis & 1 == 1) * half[axis]);
        along(0) + along(1) + along(2)
    }

    /// Unit vector from the second box to the first.
    fn normal(&self, plane: Plane) -> Vector3 {
        match plane {
            Plane::Face { of, axis, positive } => {
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

    /// By how much the boxes overlap across a plane: the length p for which E = K/2 p^2, or less than 0, the gap `[m]`.
    fn depth(&self, plane: Plane) -> f64 {
        match plane {
            Plane::Face { of, axis, positive } => {
                let towards = if of == 0 { 1.0 } else { -1.0 };
                let way = towards * side(positive) * self.along[of][axis];
                let middle = self.half[of][axis] - way;
                let half = &self.half[1 - of];
                let parts = [0, 1, 2].map(|i| half[i] * self.cosine(of, axis, i));
                let deepest = middle + parts.iter().map(|part| part.abs()).sum::<f64>();
                if deepest <= 0.0 {
                    return deepest;
                }
                let mut squares = 0.0;
                for number in 0..POINTS_PER_BLOCKS {
                    let signed = |i: usize| side(number >> i & 1 == 1) * parts[i];
                    let depth = middle - (signed(0) + signed(1) + signed(2));
                    squares += depth.max(0.0).powi(2);
                }
                (squares / QUARTERS as f64).sqrt()
            }
            Plane::Edges([i, j]) => {
                // Along the cross product of axis i of the first and j of the second, times the sine between them.
                let after = |axis: usize| [(axis + 1) % 3, (axis + 2) % 3];
                let ([k, l], [m, n]) = (after(i), after(j));
                let (c, [one, other]) = (&self.cosines, &self.half);
                let extents = one[k] * c[l][j].abs()
                    + one[l] * c[k][j].abs()
                    + other[m] * c[i][n].abs()
                    + other[n] * c[i][m].abs();
                let way = self.along[0][l] * c[k][j] - self.along[0][k] * c[l][j];
                (extents - way.abs()) / self.sine(i, j)
            }
        }
    }

    /// Sine between an axis of the first box and one of the second.
    fn sine(&self, i: usize, j: usize) -> f64 {
        (1.0 - self.cosines[i][j].powi(2)).max(0.0).sqrt()
    }

    /// The plane of least depth; of nearly equals `before`, or else the first one.
    fn least(&self, before: Option<Plane>) -> (Plane, f64) {
        let start = before.unwrap_or(self.face(0, 0));
        let mut least = (start, self.depth(start));
        let mut look = |plane: Plane| {
            let depth = self.depth(plane);
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

    /// The face of a box across an axis that is towards the other box.
    fn face(&self, of: usize, axis: usize) -> Plane {
        let along = self.along[of][axis];
        Plane::Face {
            of,
            axis,
            positive: if of == 0 { along >= 0.0 } else { along <= 0.0 },
        }
    }

    /// The points of contact by a plane.
    fn points(&self, plane: Plane) -> [Found; POINTS_PER_BLOCKS] {
        match plane {
            Plane::Face { of, axis, positive } => {
                let out = self.axes[of][axis] * side(positive);
                let other = 1 - of;
                std::array::from_fn(|number| {
                    let corner = self.centres[other] + self.corner(other, number);
                    let above = out.dot(&(corner - self.centres[of])) - self.half[of][axis];
                    Found {
                        penetration: -above,
                        place: corner - out * (0.5 * above),
                    }
                })
            }
            Plane::Edges(pair) => {
                let normal = self.normal(plane);
                let found = Found {
                    penetration: self.depth(plane),
                    place: self.crossing(pair, &normal),
                };
                std::array::from_fn(|number| {
                    if number < QUARTERS {
                        found
                    } else {
                        Found {
                            penetration: f64::NEG_INFINITY,
                            ..found
                        }
                    }
                })
            }
        }
    }

    /// Midway between the edges of the two boxes that are nearest to each other across a plane `[m]`.
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
        // Of two lines along unit vectors, the places nearest to each other.
        let sine_square = 1.0 - cosine * cosine;
        let along_u = (u.dot(&between) - cosine * v.dot(&between)) / sine_square;
        let along_v = (cosine * u.dot(&between) - v.dot(&between)) / sine_square;
        0.5 * (one + u * along_u + other + v * along_v)
    }
}

#[cfg(test)]
mod tests;
