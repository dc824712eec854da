//! Selection of the contact points that an interval evaluates, for worlds with many points.

use std::sync::Arc;

use crate::contact::broad_phase::{BroadPhase, List, MARGIN, Pairs};
use crate::contact::convex_pairs::Blocks;
use crate::contact::pairs::Point;
use crate::dynamics::moving_body::Part;
use crate::geometry::hull::MAX_CORNERS;
use crate::geometry::rigid::Vector3;

/// A cluster of shell points. If the other solid is far from all of them, none is evaluated.
#[derive(Clone, Debug)]
pub(crate) struct Patch {
    /// Indices of the points in the world.
    numbers: Vec<usize>,
    /// Bounding sphere of the points, in the axes of the first part: centre and radius `[m]`.
    centre: Vector3,
    radius: f64,
}

/// Maximum number of points of a patch: small enough to evaluate each, large enough for few patches.
const MAX_OF_A_PATCH: usize = 16;

impl Patch {
    /// Divides a shell into patches, given the indices and positions of its points.
    pub fn new(points: Vec<(usize, Vector3)>) -> Vec<Self> {
        let (mut whole, mut left) = (Vec::new(), vec![points]);
        while let Some(mut points) = left.pop() {
            let (mut low, mut high) = (points[0].1, points[0].1);
            for (_, place) in &points {
                (low, high) = (low.inf(place), high.sup(place));
            }
            if points.len() > MAX_OF_A_PATCH {
                let along = (high - low).imax();
                points.sort_by(|one, other| one.1[along].total_cmp(&other.1[along]));
                let other_half = points.split_off(points.len() / 2);
                left.extend([points, other_half]);
                continue;
            }
            let centre = (low + high) * 0.5;
            let ways = points.iter().map(|(_, place)| (place - centre).norm());
            whole.push(Self {
                radius: ways.fold(0.0, f64::max),
                numbers: points.into_iter().map(|(number, _)| number).collect(),
                centre,
            });
        }
        whole
    }
}

/// Maximum number of contact points that a tick evaluates, without those of [large](crate::PointShell::MAX_ALWAYS)
/// shells. Memory for them is reserved when a world is created. Of more points near enough to touch within an
/// interval, those of whole pairs without contact are omitted and counted ([`Effort::left_out`](crate::Effort::left_out)).
pub const MAX_POINTS: usize = 1024;

/// Indices of the active points: those of near pairs, and the nearest points in patches up to the capacity.
#[derive(Clone, Debug)]
pub(crate) struct Nearby {
    pub broad: BroadPhase,
    patches: Arc<[Patch]>,
    /// Points outside patches come first.
    numbers: List,
    /// Number of active points outside patches.
    always: usize,
    /// Points that were active since the last tick. All others are apart, with zero sums.
    recent: List,
    is_recent: Box<[bool]>,
    /// Active pairs of convex solids, and those that the last selection added.
    blocks: List,
    fresh: List,
    /// Maximum number of near points beyond the capacity at a time.
    left_out: u32,
}

/// Maximum number of active points in patches: as many as may lie in a plane, plus some beside it.
const ROOM: usize = MAX_CORNERS + MAX_CORNERS / 2;
/// Maximum number of active points.
pub(crate) const MAX_NEARBY: usize = MAX_POINTS + ROOM;

/// Maximum ratio of the change in distance from a solid to the displacement: the spline of a grid overshoots near
/// edges.
const STEEPEST: f64 = 1.25;

/// Fraction of its distance by which a separated point must move before it is evaluated again: one half, because the
/// distance from a grid may change by more than the displacement.
pub(crate) const NEARER: f64 = 0.5;

impl Nearby {
    /// Creates the selection for a world with this number of tools and bodies. Points in these patches are active only
    /// if near.
    pub fn new(points: &[Point], blocks: &[Blocks], patches: Vec<Patch>, parts: usize) -> Self {
        let mut is_in_patch = vec![false; points.len()];
        for &number in patches.iter().flat_map(|patch| &patch.numbers) {
            is_in_patch[number] = true;
        }
        let pairs = Pairs::new(points, blocks, &is_in_patch, parts);
        Self {
            broad: BroadPhase::new(pairs),
            patches: patches.into(),
            numbers: List::new(points.len().min(MAX_NEARBY)),
            always: 0,
            recent: List::new(points.len()),
            is_recent: vec![false; points.len()].into(),
            blocks: List::new(blocks.len()),
            fresh: List::new(blocks.len()),
            left_out: 0,
        }
    }

    /// Copies the selection, without allocation.
    pub fn copy_from(&mut self, other: &Self) {
        self.broad.copy_from(&other.broad);
        for &number in self.recent.all() {
            self.is_recent[number] = false;
        }
        for &number in other.recent.all() {
            self.is_recent[number] = true;
        }
        self.recent.copy_from(&other.recent);
        self.copy_numbers_from(other);
    }

    /// Copies the active points, without allocation.
    pub fn copy_numbers_from(&mut self, other: &Self) {
        self.numbers.copy_from(&other.numbers);
        self.blocks.copy_from(&other.blocks);
        (self.always, self.left_out) = (other.always, other.left_out);
    }

    /// Returns the indices of the active points.
    pub fn numbers(&self) -> &[usize] {
        self.numbers.all()
    }

    /// Returns the indices of the points that were active since the last tick, in ascending order.
    pub fn recent(&self) -> &[usize] {
        self.recent.all()
    }

    pub fn is_recent(&self, number: usize) -> bool {
        self.is_recent[number]
    }

    /// Returns the active pairs of convex solids.
    pub fn blocks(&self) -> &[usize] {
        self.blocks.all()
    }

    /// Returns the pairs of convex solids that the last selection added.
    pub fn fresh(&self) -> &[usize] {
        self.fresh.all()
    }

    /// Returns the maximum number of points beyond the capacity since the last call.
    pub fn take_left_out(&mut self) -> u32 {
        std::mem::take(&mut self.left_out)
    }

    /// Ends a tick: only the active points are recent. `forget` is called for each other one.
    pub fn end_tick(&mut self, mut forget: impl FnMut(usize)) {
        if self.recent.all().len() == self.numbers.all().len() {
            return;
        }
        for &number in self.recent.all() {
            self.is_recent[number] = false;
        }
        for &number in self.numbers.all() {
            self.is_recent[number] = true;
        }
        for &number in self.recent.all() {
            if !self.is_recent[number] {
                forget(number);
            }
        }
        self.recent.clear();
        for &number in self.numbers.all() {
            self.recent.push(number);
        }
        self.recent.sort();
    }

    /// Activates all touching points, after an external change.
    pub fn recollect(&mut self, touches: impl Fn(usize) -> bool) {
        self.broad.select_touching(&touches);
        self.take_pairs(&touches);
        let mut found = Found::new();
        for &number in self.patches.iter().flat_map(|patch| &patch.numbers) {
            if touches(number) {
                found.take(f64::NEG_INFINITY, number);
            }
        }
        self.keep(&found);
    }

    /// Activates the points of the near pairs, if there are too many those of touching ones first.
    fn take_pairs(&mut self, touches: impl Fn(usize) -> bool) {
        let pairs = self.broad.pairs.clone();
        let near = || self.broad.near().iter().copied();
        self.numbers.clear();
        self.blocks.clear();
        self.fresh.clear();
        let total: usize = near().map(|pair| pairs.all[pair].points).sum();
        let is_crowded = total > MAX_POINTS;
        let mut left = MAX_POINTS;
        for is_touching in [true, false] {
            for number in near() {
                let pair = &pairs.all[number];
                let is_due = if is_crowded {
                    pair.numbers().any(&touches) == is_touching
                } else {
                    is_touching
                };
                if !is_due || pair.points > left {
                    continue;
                }
                left -= pair.points;
                for point in pair.numbers() {
                    self.numbers.push(point);
                }
                if let Some(blocks) = pair.blocks {
                    self.blocks.push(blocks);
                    if !self.broad.was_near(number) {
                        self.fresh.push(blocks);
                    }
                }
            }
        }
        if is_crowded {
            self.numbers.sort();
            let left_out = total - self.numbers.all().len();
            self.left_out = self
                .left_out
                .max(u32::try_from(left_out).unwrap_or(u32::MAX));
        }
        self.always = self.numbers.all().len();
    }

    fn keep(&mut self, found: &Found) {
        for &number in &found.numbers[..found.count] {
            self.numbers.push(number);
        }
        self.left_out = self.left_out.max(found.left_out);
        let mut has_new = false;
        for &number in self.numbers.all() {
            if !self.is_recent[number] {
                self.is_recent[number] = true;
                self.recent.push(number);
                has_new = true;
            }
        }
        if has_new {
            self.recent.sort();
        }
    }

    /// Activates the points that touch or may touch within `h` `[s]`. `touches` returns whether a point already
    /// touches.
    pub fn gather(
        &mut self,
        parts: &[Part],
        points: &[Point],
        touches: impl Fn(usize) -> bool,
        h: f64,
    ) {
        let mut found = Found::new();
        for &number in &self.numbers.all()[self.always..] {
            if touches(number) {
                found.take(f64::NEG_INFINITY, number);
            }
        }
        self.broad.select(parts, &touches, h);
        self.take_pairs(&touches);
        for patch in self.patches.iter() {
            let Some(any) = patch.numbers.first().map(|&number| &points[number]) else {
                continue;
            };
            if any.is_held {
                // The method decides which points touch, and may have changed it since the last call.
                for &number in &patch.numbers {
                    if touches(number) && !found.has(number) {
                        found.take(f64::NEG_INFINITY, number);
                    }
                }
                continue;
            }
            let (first, second) = (&parts[any.first], &parts[any.second]);
            let centre = first.rigid.position + first.rigid.orientation * patch.centre;
            let lever = patch.centre.norm() + patch.radius;
            let reach = approach(
                first,
                second,
                lever,
                (centre - second.rigid.position).norm(),
                h,
            ) + MARGIN;
            let from_centre = STEEPEST * patch.radius + reach;
            let nearest = any
                .solid
                .nearest_within(&second.rigid, &centre, from_centre);
            if nearest.distance > from_centre {
                continue;
            }
            for &number in &patch.numbers {
                if touches(number) && found.has(number) {
                    continue;
                }
                let point = &points[number];
                let place = point.centre_of(&first.rigid);
                let nearest = point.solid.nearest_within(&second.rigid, &place, reach);
                if nearest.distance < reach {
                    found.take(nearest.distance, number);
                }
            }
        }
        self.keep(&found);
    }
}

/// Returns twice the distance by which two parts may approach each other within `h` `[s]`, at these distances from
/// their centres `[m]`.
pub(crate) fn approach(first: &Part, second: &Part, of_first: f64, of_second: f64, h: f64) -> f64 {
    let velocity = |part: &Part| part.rigid.velocity + part.step.velocity;
    let turning = |part: &Part| (part.twist.turning + part.step.turning).norm();
    let relative = (velocity(first) - velocity(second)).norm();
    let pushed = (first.drive.acceleration - second.drive.acceleration).norm();
    let turns = turning(first) * of_first + turning(second) * of_second;
    (relative + turns + pushed * h) * 2.0 * h
}

/// Returns an upper bound of a point's displacement since the interval began, in the axes of the second `[m]`.
pub(crate) fn approached(first: &Part, second: &Part, point: &Point) -> f64 {
    let way = first.way + first.turned * point.lever + second.way;
    if second.turned > 0.0 {
        let apart = (first.rigid.position - second.rigid.position).norm();
        way + second.turned * (apart + point.lever + way)
    } else {
        way
    }
}

/// The nearest points found so far, in order of discovery.
struct Found {
    distances: [f64; ROOM],
    numbers: [usize; ROOM],
    count: usize,
    left_out: u32,
}

impl Found {
    fn new() -> Self {
        Self {
            distances: [0.0; ROOM],
            numbers: [0; ROOM],
            count: 0,
            left_out: 0,
        }
    }

    fn has(&self, number: usize) -> bool {
        self.numbers[..self.count].contains(&number)
    }

    /// Adds a point; at full capacity it replaces the most distant one if that is further away.
    fn take(&mut self, distance: f64, number: usize) {
        if self.count < ROOM {
            (self.distances[self.count], self.numbers[self.count]) = (distance, number);
            self.count += 1;
            return;
        }
        self.left_out += 1;
        let mut furthest = 0;
        for place in 1..ROOM {
            if self.distances[place] > self.distances[furthest] {
                furthest = place;
            }
        }
        if distance < self.distances[furthest] {
            (self.distances[furthest], self.numbers[furthest]) = (distance, number);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Body, Contact, ContactLaw, CoupledParams, Free, Mesh, Motion, Party, PointShell, Sample,
        Shape, Tool, World, WorldLoop, WorldRenderer,
    };

    /// Returns a ball of 20 mm with bumps: 16 rings of 24 vertices and two poles.
    fn bumpy_ball() -> Mesh {
        let (rings, around) = (16_u32, 24_u32);
        let mut vertices = vec![[0.0, 0.0, 0.02], [0.0, 0.0, -0.02]];
        for ring in 1..=rings {
            let polar = std::f64::consts::PI * f64::from(ring) / f64::from(rings + 1);
            for step in 0..around {
                let angle = std::f64::consts::TAU * f64::from(step) / f64::from(around);
                let radius = 0.02 * (1.0 + 0.15 * (3.0 * angle).cos() * polar.sin().powi(2));
                let (across, along) = (radius * polar.sin(), radius * polar.cos());
                vertices.push([across * angle.cos(), across * angle.sin(), along]);
            }
        }
        let at = |ring: u32, step: u32| 2 + (ring - 1) * around + step % around;
        let mut faces = Vec::new();
        for step in 0..around {
            faces.push([0, at(1, step), at(1, step + 1)]);
            faces.push([1, at(rings, step + 1), at(rings, step)]);
            for ring in 1..rings {
                faces.push([at(ring, step), at(ring + 1, step), at(ring + 1, step + 1)]);
                faces.push([at(ring, step), at(ring + 1, step + 1), at(ring, step + 1)]);
            }
        }
        Mesh::new(&vertices, &faces).unwrap()
    }

    /// The ball with `points` points falls into a corner formed by a floor, a block and a capsule.
    fn renderer(points: usize) -> WorldRenderer {
        let shell = PointShell::over(&bumpy_ball(), points).unwrap();
        let mesh = bumpy_ball().with_shell(shell.shared_by(3).unwrap());
        let free = Free {
            velocity: [0.3, 0.1, -0.4],
            angular_velocity: [6.0, -9.0, 4.0],
            ..Free::of_mass(0.08).pulled_by([0.2, 0.1, -0.8])
        };
        let fixed = |name: &str, shape: Shape| Body::new(name, shape, Motion::Fixed);
        let world = World {
            tools: vec![Tool::new("tool", Shape::Sphere { radius: 0.005 })],
            bodies: vec![
                fixed(
                    "floor",
                    Shape::HalfSpace {
                        normal: [0.0, 0.0, 1.0],
                        offset: 0.0,
                    },
                ),
                fixed(
                    "block",
                    Shape::Box {
                        half_extents: [0.02, 0.2, 0.05],
                    },
                )
                .at([0.06, 0.0, 0.03]),
                fixed(
                    "rod",
                    Shape::Capsule {
                        radius: 0.01,
                        half_length: 0.1,
                    },
                )
                .at([0.0, 0.05, 0.02]),
                Body::new("ball", Shape::Mesh(Arc::new(mesh)), Motion::Free(free))
                    .at([0.0, 0.0, 0.04]),
            ],
            contacts: vec![Contact {
                between: [Party::Named("ball".into()), Party::Any],
                law: ContactLaw::spring(4000.0)
                    .with_friction(0.3)
                    .with_damping(1.0),
            }],
            ..World::default()
        };
        WorldRenderer::new(
            &world,
            WorldLoop::new(0.001),
            CoupledParams::new(vec![[0.2; 3]]),
        )
        .unwrap()
    }

    #[test]
    fn looking_at_what_is_near_is_as_good_as_looking_at_all() {
        let all = renderer(20);
        assert!(all.nearby.patches.is_empty());
        let mut near = all.clone();
        let mut patches = Vec::new();
        for fixed in 1..=3 {
            let of_pair = (0..)
                .zip(&near.points)
                .filter(|(_, point)| point.second == fixed);
            patches.extend(Patch::new(
                of_pair
                    .map(|(number, point)| (number, point.centre))
                    .collect(),
            ));
        }
        near.nearby = Nearby::new(&near.points, &[], patches, near.parts.len());
        let (mut one, mut other) = (all.start(), near.start());
        let (mut off, mut least, mut touched) = (0.0_f64, usize::MAX, 0);
        for _ in 0..600 {
            let far = Sample::at(&[[0.5; 3]]);
            let outputs = [all.step(&mut one, &far), near.step(&mut other, &far)];
            for output in outputs {
                assert_eq!((output.fault, output.effort.left_out), (None, 0));
            }
            let places = one.bodies()[3]
                .position
                .iter()
                .zip(other.bodies()[3].position);
            off = places.fold(off, |off, (a, b)| off.max((a - b).abs()));
            least = least.min(other.progress.now.nearby.numbers().len());
            touched += usize::from(
                other
                    .progress
                    .now
                    .touches
                    .iter()
                    .any(|touch| !touch.is_apart()),
            );
        }
        assert!(
            touched > 50 && least < 20,
            "{touched} samples touch, of {least} points at least"
        );
        assert!(off < 1e-9, "{off} m apart");
    }

    #[test]
    fn every_point_that_touches_is_near_however_the_body_lies() {
        let renderer = renderer(400);
        let mut moving = renderer.start().progress.now;
        let mut random = 1_u64;
        let mut between = |low: f64, high: f64| {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            low + (high - low) * (random >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut seen = 0;
        for _ in 0..400 {
            let ball = moving.parts.last_mut().unwrap();
            ball.rigid.position = Vector3::new(
                between(-0.01, 0.025),
                between(-0.01, 0.03),
                between(0.018, 0.04),
            );
            let turned = Vector3::from_fn(|_, _| between(-3.0, 3.0));
            ball.rigid.orientation = crate::geometry::rigid::Rotation::from_scaled_axis(turned);
            moving.gather(&renderer.points, 0.0);
            let numbers = moving.nearby.numbers();
            let left_out = moving.nearby.clone().take_left_out();
            for (number, point) in renderer.points.iter().enumerate() {
                let (first, second) = (
                    &moving.parts[point.first].rigid,
                    &moving.parts[point.second].rigid,
                );
                let nearest = point.solid.nearest(second, &point.centre_of(first));
                if nearest.distance < 0.0 && left_out == 0 {
                    seen += 1;
                    assert!(
                        numbers.contains(&number),
                        "{number} is {} m deep",
                        -nearest.distance
                    );
                }
            }
            moving.nearby.take_left_out();
        }
        assert!(seen > 500, "{seen}");
    }

    #[test]
    fn what_there_is_no_room_for_is_counted_and_the_deepest_stay() {
        let mut found = Found::new();
        for number in 0..ROOM + 10 {
            found.take(-(number as f64), number);
        }
        assert_eq!((found.count, found.left_out), (ROOM, 10));
        assert!(found.has(ROOM + 9) && !found.has(0));
    }
}
