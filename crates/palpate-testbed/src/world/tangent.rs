//! Planes between a cylinder and a solid with flat faces that are found among many: all through an edge of the solid whose
//! normals lie between those of the two faces there.
//!
//! Among those the overlap p of a plane is a function of an angle φ. Where p² has its least, half its slope
//! g(φ) = Σ max(0, d) ∂d/∂φ is 0, and the angle turns at the rate −(∂g/∂t)/(∂g/∂φ).

use super::cylinder::Lying;
use super::ridders::falls_through_zero;
use super::vector::Vec3;

/// Parts of a family, by which one of its planes is named.
pub(super) const PARTS: u8 = 64;
/// A plane of which the name is more parts than this away has another name.
const RENAMED: f64 = 1.5;
/// A plane is looked for so many parts about where it was.
const ABOUT: f64 = 3.0;
/// Places at which the slope along an arc is looked at, at most, and the longest way from one to the next `[rad]`.
const AROUND: usize = 32;
const APART: f64 = 0.1;
/// How far beyond its end an arc is taken to reach `[rad]`.
const BEYOND: f64 = 1e-12;

/// The normals of the planes through an edge, which turn with one of the two solids.
pub(super) struct Turn {
    /// Normals at the angle 0 and a quarter turn on.
    zero: Vec3,
    quarter: Vec3,
    /// Angular velocity of both.
    pub turning: Vec3,
    /// Up to which angle there are normals.
    width: f64,
}

impl Turn {
    /// The normal at an angle, and how it changes with the angle.
    pub fn at(&self, angle: f64) -> (Vec3, Vec3) {
        let (sine, cosine) = angle.sin_cos();
        (
            self.zero * cosine + self.quarter * sine,
            self.quarter * cosine - self.zero * sine,
        )
    }

    /// In the middle of the part of that name.
    pub fn angle(&self, name: u8) -> f64 {
        f64::from(name) * self.part()
    }

    fn part(&self) -> f64 {
        self.width / f64::from(PARTS)
    }

    /// The name of the plane at an angle, if it was called `now`.
    fn name(&self, angle: f64, now: Option<u8>) -> u8 {
        let at = angle / self.part();
        if let Some(now) = now
            && (at - f64::from(now)).abs() <= RENAMED
        {
            return now;
        }
        super::cylinder::small(at.round().clamp(0.0, f64::from(PARTS)))
    }
}

/// What there is to know of such a plane.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Bend {
    /// p `[m]`, negative where there is a gap.
    pub overlap: f64,
    /// g, or what has its sign where there is a gap.
    pub slope: f64,
    /// ∂g/∂φ and ∂g/∂t; 0 where there is a gap.
    by_angle: f64,
    by_time: f64,
}

impl Bend {
    /// How fast the angle of least overlap turns `[rad/s]`.
    pub fn turning(&self) -> f64 {
        if self.by_angle > 0.0 {
            -self.by_time / self.by_angle
        } else {
            0.0
        }
    }
}

/// A depth d with its derivatives: by the angle, twice by it, by the time and by both.
#[derive(Clone, Copy)]
struct Depth {
    depth: f64,
    by_angle: f64,
    by_angle_twice: f64,
    by_time: f64,
    by_both: f64,
}

impl Bend {
    /// One more point, if it lies behind the plane; p² so far stands in the place of p.
    fn add(&mut self, at: Depth) {
        if at.depth > 0.0 {
            self.overlap += at.depth * at.depth;
            self.slope += at.depth * at.by_angle;
            self.by_angle += at.by_angle * at.by_angle + at.depth * at.by_angle_twice;
            self.by_time += at.by_time * at.by_angle + at.depth * at.by_both;
        }
    }

    /// Of a sum over the points of which so many share the law, the deepest with that depth and slope.
    fn shared(self, share: usize, deepest: f64, slope: f64) -> Self {
        if deepest <= 0.0 {
            return Self {
                overlap: deepest,
                slope,
                ..Self::default()
            };
        }
        Self {
            overlap: (self.overlap / share as f64).sqrt(),
            ..self
        }
    }
}

impl Lying<'_> {
    pub fn turn(&self, edge: u8) -> Turn {
        let solid = &self.cylinder.flat;
        let [zero, other] = solid.edges[usize::from(edge)]
            .faces
            .map(|face| solid.faces[face].0);
        let quarter = other.across(zero).direction().unwrap_or(Vec3::ZERO);
        Turn {
            zero: self.flat.rotation.out(zero),
            quarter: self.flat.rotation.out(quarter),
            turning: self.flat.turning,
            width: other.dot(quarter).atan2(other.dot(zero)),
        }
    }

    /// The first end of an edge.
    pub fn on_edge(&self, edge: u8) -> Vec3 {
        let end = self.cylinder.flat.edges[usize::from(edge)].ends[0];
        self.corners[end]
    }

    pub fn bend(&self, edge: u8, turn: &Turn, angle: f64) -> Bend {
        let (normal, onward) = turn.at(angle);
        let (normal_rate, onward_rate) = (turn.turning.cross(normal), turn.turning.cross(onward));
        let (axis, axis_rate, radius) = (self.axis, self.axis_rate, self.cylinder.radius);
        let on = self.on_edge(edge);
        let on_velocity = self.flat.velocity_at(on);
        // Of the normal, the part along the axis. Its derivative by the angle is that of `onward`, whose own is -n.
        let (b, b_by_angle) = (normal.dot(axis), onward.dot(axis));
        let b_by_time = normal_rate.dot(axis) + normal.dot(axis_rate);
        let b_by_both = onward_rate.dot(axis) + onward.dot(axis_rate);
        // And the size of the part across it, sqrt(1 - b²).
        let size = normal.across(axis).norm();
        let over = if size > 0.0 { 1.0 / size } else { 0.0 };
        let more = Depth {
            depth: radius * size,
            by_angle: -radius * b * b_by_angle * over,
            by_angle_twice: radius
                * over
                * (b * b - b_by_angle * b_by_angle - (b * b_by_angle * over).powi(2)),
            by_time: -radius * b * b_by_time * over,
            by_both: -radius
                * over
                * (b_by_time * b_by_angle
                    + b * b_by_both
                    + b * b * b_by_angle * b_by_time * over * over),
        };
        let share = self.cylinder.share();
        let mut bend = Bend::default();
        let mut deepest = (f64::NEG_INFINITY, 0.0);
        for rim in [0, 1] {
            let centre = self.centre(rim);
            let off = on - centre;
            let velocity = on_velocity - self.round.velocity_at(centre);
            let of_centre = Depth {
                depth: normal.dot(off),
                by_angle: onward.dot(off),
                by_angle_twice: -normal.dot(off),
                by_time: normal_rate.dot(off) + normal.dot(velocity),
                by_both: onward_rate.dot(off) + onward.dot(velocity),
            };
            if of_centre.depth + more.depth > deepest.0 {
                deepest = (
                    of_centre.depth + more.depth,
                    of_centre.by_angle + more.by_angle,
                );
            }
            if of_centre.depth >= more.depth {
                // All of the rim is behind the plane: m (c² + s²/2), which is smooth where s is 0.
                let count = share as f64;
                let half = 0.5 * radius * radius;
                let Depth {
                    depth: c,
                    by_angle,
                    by_time,
                    by_both,
                    ..
                } = of_centre;
                bend.overlap += count * (c * c + half * size * size);
                bend.slope += count * (c * by_angle - half * b * b_by_angle);
                bend.by_angle += count
                    * (by_angle * by_angle - c * c - half * (b_by_angle * b_by_angle - b * b));
                bend.by_time += count
                    * (by_time * by_angle + c * by_both
                        - half * (b_by_time * b_by_angle + b * b_by_both));
                continue;
            }
            for &cosine in &self.cylinder.cosines {
                bend.add(Depth {
                    depth: of_centre.depth + more.depth * cosine,
                    by_angle: of_centre.by_angle + more.by_angle * cosine,
                    by_angle_twice: of_centre.by_angle_twice + more.by_angle_twice * cosine,
                    by_time: of_centre.by_time + more.by_time * cosine,
                    by_both: of_centre.by_both + more.by_both * cosine,
                });
            }
        }
        bend.shared(share, deepest.0, deepest.1)
    }

    /// The angles at which planes through an edge have less overlap than those beside them. They count even if the overlap does
    /// not fall from both ends of the arc inwards: the energy would jump where it ceases to.
    pub fn least_of(&self, edge: u8, turn: &Turn) -> Vec<f64> {
        let slope = |angle: f64| self.bend(edge, turn, angle).slope;
        let count = (2..AROUND)
            .find(|count| turn.width <= APART * *count as f64)
            .unwrap_or(AROUND);
        let angle = |number: usize| turn.width * number as f64 / count as f64;
        let mut found = Vec::new();
        let mut before = slope(0.0);
        for number in 1..=count {
            let after = slope(angle(number));
            if before < 0.0 && after >= 0.0 {
                let (low, high) = (angle(number - 1), angle(number));
                found.push(falls_through_zero(|angle| -slope(angle), low, high));
            }
            before = after;
        }
        found
    }

    /// The angle at which the plane of that name has its least overlap.
    pub fn least_about(&self, edge: u8, turn: &Turn, name: u8) -> Option<f64> {
        let slope = |angle: f64| self.bend(edge, turn, angle).slope;
        let about = turn.angle(name);
        let reach = ABOUT * turn.part();
        let (low, high) = (about - reach, about + reach);
        if slope(low) < 0.0 && slope(high) > 0.0 {
            return Some(falls_through_zero(|angle| -slope(angle), low, high));
        }
        let off = |angle: &f64| (angle - about).abs();
        let mut all = self.least_of(edge, turn);
        all.retain(|angle| off(angle) <= reach);
        all.into_iter()
            .min_by(|one, other| off(one).total_cmp(&off(other)))
    }

    /// The overlap of the plane of that name, and what it is called now.
    pub fn overlap_about(&self, edge: u8, name: u8) -> (f64, u8) {
        let turn = self.turn(edge);
        let is_there = |angle: &f64| (-BEYOND..=turn.width + BEYOND).contains(angle);
        match self.least_about(edge, &turn, name).filter(is_there) {
            Some(angle) => (
                self.bend(edge, &turn, angle).overlap,
                turn.name(angle, Some(name)),
            ),
            None => (f64::INFINITY, name),
        }
    }

    /// What no plane through an edge has less overlap than: the cylinder holds a ball about its centre, and where that is
    /// behind the planes at both ends of the arc, it is behind those between by no less.
    pub fn least_that_can_be(&self, edge: u8) -> f64 {
        let turn = self.turn(edge);
        let off = self.on_edge(edge) - self.round.position;
        let depth = [0.0, turn.width].map(|angle| turn.at(angle).0.dot(off));
        let depth = depth[0].min(depth[1]);
        if depth <= 0.0 {
            return f64::NEG_INFINITY;
        }
        let ball = self.cylinder.radius.min(self.cylinder.half_length);
        (depth + ball) / (self.cylinder.share() as f64).sqrt()
    }

    /// The name of each plane through an edge that has less overlap than those beside it, and that overlap.
    pub fn overlaps_of(&self, edge: u8) -> Vec<(u8, f64)> {
        let turn = self.turn(edge);
        let angles = self.least_of(edge, &turn).into_iter();
        angles
            .map(|angle| {
                let overlap = self.bend(edge, &turn, angle).overlap;
                (turn.name(angle, None), overlap)
            })
            .collect()
    }
}
