//! One interval of a world: bounded work, and finer where a contact changes its mode.

use crate::blocks::Blocks;
use crate::moving::Moving;
use crate::nearby::{MOST_NEARBY, approach};
use crate::pairs::Point;
use crate::part::Part;
use crate::rigid::Vector3;
use crate::solid::Solid;

/// How finely an interval is integrated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SubSteps {
    /// Least number in an interval.
    pub least: u32,
    /// Most, before any is refined.
    pub most: u32,
    /// Phase of the fastest contact that one may have, where the number allows it `[rad]`.
    pub phase: f64,
    /// How many finer ones replace one in which a contact begins, ends, sticks or slides, or comes across an edge to
    /// another face.
    pub finer: u32,
    /// How many of an interval may be replaced.
    pub refined: u32,
}

impl Default for SubSteps {
    /// 16 to 64, 0.03 rad; up to 4 of them 32 times finer: 188 at most.
    fn default() -> Self {
        Self {
            least: 16,
            most: 64,
            phase: 0.03,
            finer: 32,
            refined: 4,
        }
    }
}

/// What the integration of intervals has cost, and what it left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Sub-steps taken, with those that were replaced.
    pub sub_steps: u32,
    /// Sub-steps that were replaced by finer ones.
    pub refined: u32,
    /// Sub-steps in which a contact changed its mode or its face and that were not refined, because
    /// [`SubSteps::refined`] others were.
    pub unrefined: u32,
    /// Whether the fastest contact asked for more than [`SubSteps::most`].
    pub too_fast: bool,
    /// Whether it is so fast that its computed motion would grow without bound.
    pub unstable: bool,
    /// Triangles of meshes, contacts with them, and points of shells that a sub-step had no room for, at most: the furthest from what
    /// they might touch, or the least deep.
    pub left_out: u32,
}

impl Effort {
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            sub_steps: self.sub_steps + other.sub_steps,
            refined: self.refined + other.refined,
            unrefined: self.unrefined + other.unrefined,
            too_fast: self.too_fast || other.too_fast,
            unstable: self.unstable || other.unstable,
            left_out: self.left_out.max(other.left_out),
        }
    }
}

/// Phase of the fastest contact in a sub-step beyond which its motion would grow `[rad]`: Verlet's method is stable up to 2
/// for a spring, and for a damper, whose velocity is that of half a sub-step before, up to a rate of 2 a sub-step, which
/// [`DAMPING_PER_FREQUENCY`] counts as 1.
const MOST_PHASE: f64 = 1.0;

/// Integrates `moving` over `h` `[s]`, from contacts that were looked at. `before` is overwritten.
pub(crate) fn advance(
    moving: &mut Moving,
    before: &mut Moving,
    points: &[Point],
    sub_steps: &SubSteps,
    h: f64,
) -> Effort {
    let mut effort = Effort::default();
    moving.gather(points, h);
    let asked = fastest(moving, points, h) * h / sub_steps.phase;
    let count = if asked <= f64::from(sub_steps.least) {
        sub_steps.least
    } else if asked < f64::from(sub_steps.most) {
        whole(asked.ceil())
    } else {
        effort.too_fast = asked > f64::from(sub_steps.most);
        sub_steps.most
    };
    effort.unstable = asked * sub_steps.phase > MOST_PHASE * f64::from(count);
    let step = h / f64::from(count);
    for _ in 0..count {
        before.copy_nearby_from(moving);
        moving.sub_step(points, step);
        effort.sub_steps += 1;
        if !moving.changed_from(before) {
            continue;
        }
        if effort.refined == sub_steps.refined {
            effort.unrefined += 1;
            continue;
        }
        effort.refined += 1;
        moving.copy_nearby_from(before);
        let finer = step / f64::from(sub_steps.finer);
        for _ in 0..sub_steps.finer {
            moving.sub_step(points, finer);
        }
        effort.sub_steps += sub_steps.finer;
    }
    effort.left_out = moving.take_left_out();
    effort
}

/// A count that is known to be one.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "it lies between two numbers of that type"
)]
fn whole(count: f64) -> u32 {
    count as u32
}

/// Material damping of this rate `[1/s]` counts as a frequency of 1 rad/s.
const DAMPING_PER_FREQUENCY: f64 = 2.0;

/// How far two boxes may come nearer to each other within `h` `[s]`, and as much again `[m]`.
fn reach_of_blocks(first: &Part, second: &Part, blocks: &Blocks, h: f64) -> f64 {
    let [one, other] = blocks.reaches();
    approach(first, second, one, other, h)
}

/// A bound of the largest angular frequency among the contacts that touch, or may within `h` `[s]` `[rad/s]`: over a
/// contact's two sides, the sum of the stiffness times mobility of all contacts there, and the stiffest spring of a drive.
fn fastest(moving: &Moving, points: &[Point], h: f64) -> f64 {
    let mut most_square: f64 = 0.0;
    let mut most_damping: f64 = 0.0;
    let is_near = |number: usize, point: &Point| {
        if point.is_held {
            return false;
        }
        if !moving.touches[number].is_apart() {
            return true;
        }
        let (first, second) = (&moving.parts[point.first], &moving.parts[point.second]);
        if let Solid::Between { blocks, point, .. } = point.solid {
            let found = moving.blocks[blocks].found(point);
            return -found.penetration < reach_of_blocks(first, second, &moving.blocks[blocks], h);
        }
        let centre = point.centre_of(&first.rigid);
        let relative: Vector3 = first.rigid.velocity - second.rigid.velocity;
        let pushed = (first.drive.acceleration - second.drive.acceleration).norm();
        let mut turns = first.twist.turning.norm() * point.centre.norm();
        if point.second < moving.tools {
            turns += second.twist.turning.norm() * (centre - second.rigid.position).norm();
        }
        let reach = point.radius + (relative.norm() + turns + pushed * h) * 2.0 * h;
        match point.solid {
            // One of its points is the first to be touched.
            Solid::Mesh {
                surface, point: 0, ..
            } => {
                let surface = &moving.surfaces[surface];
                surface.clearance() < reach && surface.distance(&first.rigid, &second.rigid) < reach
            }
            _ => {
                let nearest = point.solid.nearest_within(&second.rigid, &centre, reach);
                nearest.distance < reach
            }
        }
    };
    let of_links = |number: usize| {
        let links = moving
            .links
            .iter()
            .flat_map(|link| link.rates(&moving.parts));
        let here = links.filter(|(side, ..)| *side == Some(number));
        here.fold((0.0, 0.0), |sum, (_, square, rate)| {
            (sum.0 + square, sum.1 + rate)
        })
    };
    for link in &moving.links {
        let (mut square, mut damping) = (0.0, 0.0);
        for (side, ..) in link.rates(&moving.parts) {
            let of_side = side.map_or((0.0, 0.0), of_links);
            (square, damping) = (square + of_side.0, damping + of_side.1);
        }
        most_square = most_square.max(square);
        most_damping = most_damping.max(damping);
    }
    let mut near = [false; MOST_NEARBY];
    for (near, &number) in near.iter_mut().zip(moving.nearby.numbers()) {
        *near = is_near(number, &points[number]);
    }
    let nearby = || {
        let each = moving.nearby.numbers().iter().zip(&near);
        each.filter(|(_, near)| **near).map(|(&number, _)| number)
    };
    for number in nearby() {
        let point = &points[number];
        let (mut square, mut damping) = (0.0, 0.0);
        for side in [point.first, point.second] {
            let held = of_links(side);
            (square, damping) = (square + held.0, damping + held.1);
            let mobility = moving.parts[side].mobility.linear.max();
            for other in nearby().map(|other| &points[other]) {
                let lever = if other.first == side {
                    0
                } else if other.second == side {
                    1
                } else {
                    continue;
                };
                let law = &other.law;
                let along = mobility + other.along[lever];
                let across = mobility + other.across[lever];
                let tangential = if law.friction > 0.0 {
                    law.friction_stiffness * across
                } else {
                    0.0
                };
                square += (law.stiffness * along).max(tangential);
                damping += law.damping * along;
            }
        }
        most_square = most_square.max(square);
        most_damping = most_damping.max(damping);
    }
    let of_drives = |part: &Part| {
        let turning = part.turning_drive.stiffness * part.mobility.angular.max();
        part.drive.spring_rate.max().max(turning)
    };
    let most_drive = moving.parts.iter().map(of_drives).fold(0.0, f64::max);
    (most_square + most_drive)
        .sqrt()
        .max(most_damping / DAMPING_PER_FREQUENCY)
}
