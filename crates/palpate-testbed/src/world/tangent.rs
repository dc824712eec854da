//! Families of planes between a cylinder and another solid: all planes through an edge of the solid whose normals lie
//! between those of its two faces, and for two cylinders all planes that are tangent to the side of either.
//!
//! Within a family the overlap p of a plane is a function of an angle φ. At a minimum of p², half its slope g(φ) = Σ
//! max(0, d) ∂d/∂φ is 0, and the angle turns at the rate −(∂g/∂t)/(∂g/∂φ). If one point has the whole law, g = ∂d/∂φ.

use std::f64::consts::TAU;

use super::between::MARGIN;
use super::cylinder::Lying;
use super::ridders::falls_through_zero;
use super::tube::Tube;
use super::vector::Vec3;

/// Parts of a family, by which one of its planes is named.
pub(super) const PARTS: u8 = 64;
/// A plane of which the name is more parts than this away has another name.
const RENAMED: f64 = 1.5;
/// Search range for a plane about its previous angle, in name steps.
const ABOUT: f64 = 3.0;
/// Largest number of points at which the slope along an arc is evaluated, and their largest distance `[rad]`.
const AROUND: usize = 32;
const APART: f64 = 0.1;
/// How far beyond its end an arc is taken to reach `[rad]`.
const BEYOND: f64 = 1e-12;

/// Planes that differ by an angle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Family {
    /// Those through an edge, by its number.
    Edge(u8),
    /// Those that are tangent to the side of the other cylinder.
    Around,
    /// Those that are tangent to the side of the cylinder, with a rim of the other one behind them, by its number.
    SideAtRim(u8),
}

/// What all planes of a family go through: a place, which is moved by so much along the normal of each.
pub(super) struct Through {
    pub on: Vec3,
    pub on_velocity: Vec3,
    pub lift: f64,
}

/// The normals of a family, which turn with one of the two solids.
pub(super) struct Turn {
    /// Normals at the angle 0 and a quarter turn on.
    zero: Vec3,
    quarter: Vec3,
    /// Angular velocity of both.
    pub turning: Vec3,
    /// Up to which angle there are normals.
    width: f64,
    is_round: bool,
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

    pub fn part(&self) -> f64 {
        self.width / f64::from(PARTS)
    }

    /// Those about a cylinder's axis.
    pub fn about(tube: &Tube) -> Self {
        let out = |v: [f64; 3]| tube.placed.rotation.out(Vec3(v));
        Self {
            zero: out([1.0, 0.0, 0.0]),
            quarter: out([0.0, 1.0, 0.0]),
            turning: tube.placed.turning,
            width: TAU,
            is_round: true,
        }
    }

    /// How far an angle is from another one.
    pub fn off(&self, angle: f64, other: f64) -> f64 {
        let off = (angle - other).abs();
        if self.is_round {
            off.min((TAU - off).abs())
        } else {
            off
        }
    }

    /// The name of the plane at an angle, if it was called `now`.
    pub fn name(&self, angle: f64, now: Option<u8>) -> u8 {
        let at = angle / self.part();
        if let Some(now) = now
            && (at - f64::from(now)).abs() <= RENAMED
        {
            return now;
        }
        let all = f64::from(PARTS);
        super::cylinder::small(if self.is_round {
            at.round().rem_euclid(all)
        } else {
            at.round().clamp(0.0, all)
        })
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
    /// Adds a point if it lies behind the plane; `overlap` accumulates p² instead of p.
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

/// How the rims of a cylinder lie behind a plane of a family.
struct Rims {
    centres: [Depth; 2],
    /// How much deeper than that the deepest place is.
    more: Depth,
    /// Part of the normal along the axis with its derivatives, and the size of the part across it.
    b: Depth,
    size: f64,
}

impl Rims {
    fn behind(tube: &Tube, through: &Through, turn: &Turn, angle: f64) -> Self {
        let (normal, onward) = turn.at(angle);
        let (normal_rate, onward_rate) = (turn.turning.cross(normal), turn.turning.cross(onward));
        let (axis, axis_rate, radius) = (tube.axis, tube.axis_rate, tube.radius);
        // The derivative of the normal by the angle is `onward`, whose own is -n.
        let b = Depth {
            depth: normal.dot(axis),
            by_angle: onward.dot(axis),
            by_angle_twice: -normal.dot(axis),
            by_time: normal_rate.dot(axis) + normal.dot(axis_rate),
            by_both: onward_rate.dot(axis) + onward.dot(axis_rate),
        };
        // sqrt(1 - b²)
        let size = normal.across(axis).norm();
        let over = if size > 0.0 { 1.0 / size } else { 0.0 };
        let more = Depth {
            depth: radius * size,
            by_angle: -radius * b.depth * b.by_angle * over,
            by_angle_twice: radius
                * over
                * (b.depth * b.depth
                    - b.by_angle * b.by_angle
                    - (b.depth * b.by_angle * over).powi(2)),
            by_time: -radius * b.depth * b.by_time * over,
            by_both: -radius
                * over
                * (b.by_time * b.by_angle
                    + b.depth * b.by_both
                    + b.depth * b.depth * b.by_angle * b.by_time * over * over),
        };
        let centres = [0, 1].map(|rim| {
            let centre = tube.centre(rim);
            let off = through.on - centre;
            let velocity = through.on_velocity - tube.placed.velocity_at(centre);
            Depth {
                depth: normal.dot(off) + through.lift,
                by_angle: onward.dot(off),
                by_angle_twice: -normal.dot(off),
                by_time: normal_rate.dot(off) + normal.dot(velocity),
                by_both: onward_rate.dot(off) + onward.dot(velocity),
            }
        });
        Self {
            centres,
            more,
            b,
            size,
        }
    }

    /// Of the deepest place of one of them.
    fn of_one(&self, rim: usize) -> Bend {
        let (centre, more) = (&self.centres[rim], &self.more);
        Bend {
            overlap: centre.depth + more.depth,
            slope: centre.by_angle + more.by_angle,
            by_angle: centre.by_angle_twice + more.by_angle_twice,
            by_time: centre.by_both + more.by_both,
        }
    }
}

impl Lying<'_> {
    pub fn turn(&self, family: Family) -> Turn {
        let edge = match (family, &self.other) {
            (Family::Edge(edge), _) => usize::from(edge),
            (Family::Around, Some(other)) => return Turn::about(other),
            (Family::Around, None) | (Family::SideAtRim(_), _) => return Turn::about(&self.tube),
        };
        let solid = &self.cylinder.flat;
        let [zero, other] = solid.edges[edge].faces.map(|face| solid.faces[face].0);
        let quarter = other.across(zero).direction().unwrap_or(Vec3::ZERO);
        Turn {
            zero: self.flat.rotation.out(zero),
            quarter: self.flat.rotation.out(quarter),
            turning: self.flat.turning,
            width: other.dot(quarter).atan2(other.dot(zero)),
            is_round: false,
        }
    }

    pub fn through(&self, family: Family) -> Through {
        let of = |tube: &Tube| Through {
            on: tube.placed.position,
            on_velocity: tube.placed.velocity,
            lift: tube.radius,
        };
        match (family, &self.other) {
            (Family::Edge(edge), _) => {
                let on = self.on_edge(edge);
                Through {
                    on,
                    on_velocity: self.flat.velocity_at(on),
                    lift: 0.0,
                }
            }
            (Family::Around, Some(other)) => of(other),
            (Family::Around, None) | (Family::SideAtRim(_), _) => of(&self.tube),
        }
    }

    /// The first end of an edge.
    fn on_edge(&self, edge: u8) -> Vec3 {
        let end = self.cylinder.flat.edges[usize::from(edge)].ends[0];
        self.corners[end]
    }

    pub fn bend(&self, family: Family, turn: &Turn, angle: f64) -> Bend {
        let through = self.through(family);
        if let (Family::SideAtRim(rim), Some(other)) = (family, &self.other) {
            return Rims::behind(other, &through, turn, angle).of_one(usize::from(rim));
        }
        let Rims {
            centres,
            more,
            b,
            size,
        } = Rims::behind(&self.tube, &through, turn, angle);
        let radius = self.tube.radius;
        let share = self.cylinder.share();
        let mut bend = Bend::default();
        let mut deepest = (f64::NEG_INFINITY, 0.0);
        for of_centre in centres {
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
                    ..
                } = of_centre;
                bend.overlap += count * (c * c + half * size * size);
                bend.slope += count * (c * by_angle - half * b.depth * b.by_angle);
                bend.by_angle += count
                    * (by_angle * by_angle + c * of_centre.by_angle_twice
                        - half * (b.by_angle * b.by_angle - b.depth * b.depth));
                bend.by_time += count
                    * (by_time * by_angle + c * of_centre.by_both
                        - half * (b.by_time * b.by_angle + b.depth * b.by_both));
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

    /// The angles at which planes of a family have less overlap than those beside them. Along an arc they count even if
    /// the overlap does not fall from both ends inwards: the energy would jump where it ceases to.
    pub fn least_of(&self, family: Family, turn: &Turn) -> Vec<f64> {
        let slope = |angle: f64| self.bend(family, turn, angle).slope;
        let count = if turn.is_round {
            AROUND
        } else {
            (2..AROUND)
                .find(|count| turn.width <= APART * *count as f64)
                .unwrap_or(AROUND)
        };
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
    pub fn least_about(&self, family: Family, turn: &Turn, name: u8) -> Option<f64> {
        let slope = |angle: f64| self.bend(family, turn, angle).slope;
        let about = turn.angle(name);
        let reach = ABOUT * turn.part();
        let (low, high) = (about - reach, about + reach);
        if slope(low) < 0.0 && slope(high) > 0.0 {
            return Some(falls_through_zero(|angle| -slope(angle), low, high));
        }
        let mut all = self.least_of(family, turn);
        all.retain(|angle| turn.off(*angle, about) <= reach);
        all.into_iter()
            .min_by(|one, other| turn.off(*one, about).total_cmp(&turn.off(*other, about)))
    }

    /// Returns the overlap of the plane with that name, and its present name.
    pub fn overlap_about(&self, family: Family, name: u8) -> (f64, u8) {
        let turn = self.turn(family);
        let is_there =
            |angle: &f64| turn.is_round || (-BEYOND..=turn.width + BEYOND).contains(angle);
        match self.least_about(family, &turn, name).filter(is_there) {
            Some(angle) => (
                self.overlap_at(family, &turn, angle),
                turn.name(angle, Some(name)),
            ),
            None => (f64::INFINITY, name),
        }
    }

    /// Returns the overlap of a plane; infinite if the other rim is deeper, because the minimum then belongs to that
    /// rim.
    fn overlap_at(&self, family: Family, turn: &Turn, angle: f64) -> f64 {
        let overlap = self.bend(family, turn, angle).overlap;
        if let Family::SideAtRim(rim) = family {
            let other = Family::SideAtRim(1 - rim);
            let other = self.bend(other, turn, angle).overlap;
            if other > overlap + MARGIN * overlap.abs() {
                return f64::INFINITY;
            }
        }
        overlap
    }

    /// Returns a lower bound on the overlap of all planes through an edge. The cylinder contains a ball about its
    /// centre. If the ball is behind the planes at both ends of the arc, it is at least as deep behind those between.
    pub fn least_that_can_be(&self, edge: u8) -> f64 {
        let turn = self.turn(Family::Edge(edge));
        let off = self.on_edge(edge) - self.tube.placed.position;
        let depth = [0.0, turn.width].map(|angle| turn.at(angle).0.dot(off));
        let depth = depth[0].min(depth[1]);
        if depth <= 0.0 {
            return f64::NEG_INFINITY;
        }
        let ball = self.cylinder.radius.min(self.cylinder.half_length);
        (depth + ball) / (self.cylinder.share() as f64).sqrt()
    }

    /// The name of each plane of a family that has less overlap than those beside it, and that overlap.
    pub fn overlaps_of(&self, family: Family) -> Vec<(u8, f64)> {
        let turn = self.turn(family);
        let angles = self.least_of(family, &turn).into_iter();
        let each = angles.map(|angle| {
            let overlap = self.overlap_at(family, &turn, angle);
            (turn.name(angle, None), overlap)
        });
        each.collect()
    }
}
