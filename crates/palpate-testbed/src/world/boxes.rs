//! Two boxes: which plane is between them, and how they lie across it.
//!
//! Every face of a box bounds a half-space, of which the corners of the other box are above or below; two edges that cross
//! span a plane. A plane's *overlap* p is such that K p²/2 is stored by it: with corners at depths d, p² = Σ max(0, d)²/4,
//! and with edges p is how far one has passed the other. The boxes touch across the plane of least overlap.

use super::contact::{Placed, Touch};
use super::vector::Vec3;

/// Contacts of a pair: one for each corner of a box. Two edges have the first four, all of them where they cross.
pub(super) const CONTACTS: usize = 8;
const ON_EDGES: usize = 4;
/// Another plane takes over where its overlap is less by this part.
const MARGIN: f64 = 1e-9;
/// Square of the sine of the angle of parallel edges.
const PARALLEL_SQUARE: f64 = 1e-12;

/// A plane between two boxes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Between {
    /// The face of the first (0) or second (1) box across an axis, on the side of that sign.
    Face { of: u8, axis: u8, sign: i8 },
    /// An edge of the first along one of its axes and of the second along one of its own.
    Edges { first: u8, second: u8 },
}

/// Half the lengths of the first and the second box \[m\].
pub(super) type Halves = [[f64; 3]; 2];

fn axis(placed: &Placed, number: u8) -> Vec3 {
    let mut unit = Vec3::ZERO;
    unit.0[usize::from(number)] = 1.0;
    placed.rotation.out(unit)
}

fn corner(half: &[f64; 3], number: usize) -> Vec3 {
    let sign = |i: usize| if number >> i & 1 == 1 { 1.0 } else { -1.0 };
    Vec3(std::array::from_fn(|i| sign(i) * half[i]))
}

fn corners(half: &[f64; 3], placed: &Placed) -> [Vec3; CONTACTS] {
    std::array::from_fn(|number| placed.position + placed.rotation.out(corner(half, number)))
}

/// Where two edges come nearest to each other.
struct Crossing {
    /// Directions of both.
    along: [Vec3; 2],
    /// The corner from which each begins.
    from: [Vec3; 2],
    /// From the second to the first, of any length: ± the cross product of the two.
    across: Vec3,
    turned: f64,
}

impl Crossing {
    fn of(first: u8, second: u8, halves: &Halves, placed: [&Placed; 2]) -> Self {
        let along = [axis(placed[0], first), axis(placed[1], second)];
        let bare = along[0].cross(along[1]);
        let turned = if bare.dot(placed[0].position - placed[1].position) < 0.0 {
            -1.0
        } else {
            1.0
        };
        let across = bare * turned;
        // The corner of each box that is furthest towards the other one; of the two on the edge, either.
        let furthest = |side: usize, towards: Vec3| {
            let all = corners(&halves[side], placed[side]);
            let by = |place: &Vec3| towards.dot(*place);
            all.into_iter()
                .max_by(|a, b| by(a).total_cmp(&by(b)))
                .unwrap_or(Vec3::ZERO)
        };
        Self {
            along,
            from: [furthest(0, -across), furthest(1, across)],
            across,
            turned,
        }
    }

    fn normal(&self) -> Vec3 {
        self.across.direction().unwrap_or(Vec3::ZERO)
    }

    fn overlap(&self) -> f64 {
        self.normal().dot(self.from[1] - self.from[0])
    }

    fn touch(&self, placed: [&Placed; 2]) -> Touch {
        let [u, v] = self.along;
        let [at_u, at_v] = self.from;
        let turning = placed.map(|placed| placed.turning);
        let (u_rate, v_rate) = (turning[0].cross(u), turning[1].cross(v));
        // The way from one line to the other is at right angles to both: two equations for how far along each.
        let between = at_v - at_u;
        let between_rate = placed[1].velocity_at(at_v) - placed[0].velocity_at(at_u);
        let (c, c_rate) = (u.dot(v), u_rate.dot(v) + u.dot(v_rate));
        let solve = |a: f64, b: f64| {
            let size = 1.0 - c * c;
            [(a - c * b) / size, (c * a - b) / size]
        };
        let [s, t] = solve(u.dot(between), v.dot(between));
        let a_rate = u_rate.dot(between) + u.dot(between_rate);
        let b_rate = v_rate.dot(between) + v.dot(between_rate);
        let [s_rate, t_rate] = solve(a_rate + c_rate * t, b_rate - c_rate * s);
        let point = (at_u + u * s + at_v + v * t) * 0.5;
        let moved =
            |placed: &Placed, from: Vec3, along: Vec3, rate: Vec3, by: f64, by_rate: f64| {
                placed.velocity_at(from) + rate * by + along * by_rate
            };
        let point_velocity = (moved(placed[0], at_u, u, u_rate, s, s_rate)
            + moved(placed[1], at_v, v, v_rate, t, t_rate))
            * 0.5;
        let normal = self.normal();
        let across_rate = (u_rate.cross(v) + u.cross(v_rate)) * self.turned;
        let normal_rate = across_rate.across(normal) * (1.0 / self.across.norm());
        Touch::across(
            self.overlap(),
            normal,
            normal_rate,
            point,
            point_velocity,
            placed,
        )
    }
}

impl Between {
    /// How the two lie at one of the contacts.
    pub fn touch(self, number: usize, halves: &Halves, placed: [&Placed; 2]) -> Touch {
        match self {
            Self::Face { of, axis: a, sign } => {
                let of = usize::from(of);
                let (owner, other) = (placed[of], placed[1 - of]);
                let out = axis(owner, a) * f64::from(sign);
                let out_rate = owner.turning.cross(out);
                let place = other.position + other.rotation.out(corner(&halves[1 - of], number));
                let depth = halves[of][usize::from(a)] - out.dot(place - owner.position);
                let velocity = other.velocity_at(place);
                let rate = out.dot(owner.velocity_at(place) - velocity);
                let point = place + out * (0.5 * depth);
                let point_velocity = velocity + (out_rate * depth + out * rate) * 0.5;
                let towards_first = if of == 0 { -1.0 } else { 1.0 };
                Touch::across(
                    depth,
                    out * towards_first,
                    out_rate * towards_first,
                    point,
                    point_velocity,
                    placed,
                )
            }
            Self::Edges { first, second } => {
                let touch = Crossing::of(first, second, halves, placed).touch(placed);
                if number < ON_EDGES {
                    touch
                } else {
                    touch.of_none()
                }
            }
        }
    }

    fn overlap(self, halves: &Halves, placed: [&Placed; 2]) -> f64 {
        match self {
            Self::Face { of, axis: a, sign } => {
                let of = usize::from(of);
                let out = axis(placed[of], a) * f64::from(sign);
                let face = out.dot(placed[of].position) + halves[of][usize::from(a)];
                let depths = corners(&halves[1 - of], placed[1 - of]).map(|at| face - out.dot(at));
                let deepest = depths.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                if deepest <= 0.0 {
                    return deepest;
                }
                let squares: f64 = depths.iter().map(|depth| depth.max(0.0).powi(2)).sum();
                (squares / 4.0).sqrt()
            }
            Self::Edges { first, second } => Crossing::of(first, second, halves, placed).overlap(),
        }
    }

    /// The plane of least overlap, and by how much less that is than what `now` has, where both boxes touch across it.
    pub fn least(now: Option<Self>, halves: &Halves, placed: [&Placed; 2], slack: f64) -> Self {
        let mut least = now.map(|now| (now, now.overlap(halves, placed)));
        if let Some((now, overlap)) = least
            && overlap <= slack
        {
            return now;
        }
        for plane in planes(placed) {
            let overlap = plane.overlap(halves, placed);
            let is_less = least.is_none_or(|(_, least): (Self, f64)| {
                overlap < least - (MARGIN * least.abs()).max(slack)
            });
            if is_less {
                least = Some((plane, overlap));
            }
        }
        least.map_or(
            Self::Face {
                of: 0,
                axis: 0,
                sign: 1,
            },
            |(plane, _)| plane,
        )
    }

    /// The box whose corners touch, if corners do.
    pub fn has_corners_of(self) -> Option<u8> {
        match self {
            Self::Face { of, .. } => Some(1 - of),
            Self::Edges { .. } => None,
        }
    }
}

/// All planes that may be between two boxes: faces first, those of the first box before those of the second.
fn planes(placed: [&Placed; 2]) -> Vec<Between> {
    let mut planes = Vec::with_capacity(15);
    let way = placed[1].position - placed[0].position;
    for (of, towards) in [(0, way), (1, -way)] {
        for a in 0..3 {
            let sign = if axis(placed[usize::from(of)], a).dot(towards) < 0.0 {
                -1
            } else {
                1
            };
            planes.push(Between::Face { of, axis: a, sign });
        }
    }
    for first in 0..3 {
        for second in 0..3 {
            let across = axis(placed[0], first).cross(axis(placed[1], second));
            if across.dot(across) > PARALLEL_SQUARE {
                planes.push(Between::Edges { first, second });
            }
        }
    }
    planes
}

/// To which contact each goes that touched, as another plane takes over: those nearest to each other first. What does not
/// touch takes what is left.
pub(super) fn order_after(old: &[Touch], touched: &[bool], new: &[Touch]) -> [usize; CONTACTS] {
    let mut ways = Vec::new();
    for (from, one) in old.iter().enumerate().filter(|(from, _)| touched[*from]) {
        for (to, other) in new.iter().enumerate() {
            if other.penetration > 0.0 {
                ways.push(((one.point - other.point).norm(), from, to));
            }
        }
    }
    ways.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut order, mut taken) = ([None; CONTACTS], [false; CONTACTS]);
    for (_, from, to) in ways {
        if order[from].is_none() && !taken[to] {
            order[from] = Some(to);
            taken[to] = true;
        }
    }
    let mut left = (0..CONTACTS).filter(|&to| !taken[to]);
    order.map(|to| to.or_else(|| left.next()).unwrap_or(0))
}
