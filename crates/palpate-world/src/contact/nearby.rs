//! Selection of the contact points that an interval evaluates, for worlds with many points.

use std::sync::Arc;

use crate::contact::broad_phase::{BroadPhase, List, MARGIN, Pairs};
use crate::contact::convex_pairs::Blocks;
use crate::contact::islands::{Islands, Kind};
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

/// Indices of the active points: those of near pairs, and the nearest points in patches up to the capacity.
#[derive(Clone, Debug)]
pub(crate) struct Nearby {
    pub broad: BroadPhase,
    patches: Arc<[Patch]>,
    pub islands: Islands,
    /// Whether all that moves is one island.
    is_whole: bool,
    /// Parts of each sphere on a mesh, and of each spring of a joint.
    surfaces: Arc<[[usize; 2]]>,
    links: Arc<[[usize; 2]]>,
    /// Active points, those of large shells last.
    numbers: List,
    /// Number of active points outside patches.
    always: usize,
    /// Points that were active since the last tick. All others are apart, with zero sums.
    recent: List,
    is_recent: Box<[bool]>,
    /// Pairs of convex solids that the last selection added.
    fresh: List,
    /// Maximum number of near points in patches beyond the capacity at a time.
    left_out: u32,
}

/// Number of free bodies up to which a world is one island. Islands save little there, and a tool that nothing touches
/// yet keeps the sub-steps of the other contacts.
const MAX_OF_A_WHOLE: usize = 4;
/// Maximum number of active points in patches: as many as may lie in a plane, plus some beside it.
const ROOM: usize = MAX_CORNERS + MAX_CORNERS / 2;

/// Maximum ratio of the change in distance from a solid to the displacement: the spline of a grid overshoots near
/// edges.
const STEEPEST: f64 = 1.25;

/// Fraction of its distance by which a separated point must move before it is evaluated again: one half, because the
/// distance from a grid may change by more than the displacement.
pub(crate) const NEARER: f64 = 0.5;

impl Nearby {
    /// Creates the selection for a world. Points in these patches are active only if near. `surfaces` and `links`: parts
    /// of each sphere on a mesh, and of each spring of a joint. `halves`: half-extents of each tool and body along its
    /// own axes `[m]`. A world of few `free_bodies` is one island.
    pub fn new(
        points: &[Point],
        blocks: &[Blocks],
        patches: Vec<Patch>,
        [surfaces, links]: [Arc<[[usize; 2]]>; 2],
        halves: Vec<Vector3>,
        free_bodies: usize,
    ) -> Self {
        let parts = halves.len();
        let mut is_in_patch = vec![false; points.len()];
        for &number in patches.iter().flat_map(|patch| &patch.numbers) {
            is_in_patch[number] = true;
        }
        let in_patches = is_in_patch.iter().filter(|is_in| **is_in).count();
        let most_active = points.len() - in_patches + in_patches.min(ROOM);
        let pairs = Pairs::new(points, blocks, &is_in_patch, halves);
        Self {
            broad: BroadPhase::new(pairs),
            islands: Islands::new([
                parts,
                most_active,
                surfaces.len(),
                blocks.len(),
                links.len(),
            ]),
            is_whole: free_bodies <= MAX_OF_A_WHOLE,
            surfaces,
            links,
            patches: patches.into(),
            numbers: List::new(most_active),
            always: 0,
            recent: List::new(points.len()),
            is_recent: vec![false; points.len()].into(),
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
        self.islands.copy_from(&other.islands);
        (self.always, self.left_out) = (other.always, other.left_out);
    }

    /// Returns the indices of the active points of the selected islands.
    #[inline]
    pub fn numbers(&self) -> &[usize] {
        self.islands.all(Kind::Points)
    }

    /// Returns the indices of the tools and bodies of the selected islands.
    #[inline]
    pub fn parts(&self) -> &[usize] {
        self.islands.all(Kind::Parts)
    }

    /// Returns the indices of the points that were active since the last tick, in ascending order.
    pub fn recent(&self) -> &[usize] {
        self.recent.all()
    }

    pub fn is_recent(&self, number: usize) -> bool {
        self.is_recent[number]
    }

    /// Returns the active pairs of convex solids of the selected islands.
    pub fn blocks(&self) -> &[usize] {
        self.islands.all(Kind::Blocks)
    }

    /// Returns the pairs of convex solids that the last selection added.
    pub fn fresh(&self) -> &[usize] {
        self.fresh.all()
    }

    /// Returns the maximum number of points in patches beyond the capacity since the last call.
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
        self.take_pairs();
        let mut found = Found::new();
        for &number in self.patches.iter().flat_map(|patch| &patch.numbers) {
            if touches(number) {
                found.take(f64::NEG_INFINITY, number);
            }
        }
        self.keep(&found);
    }

    /// Joins the parts of active points of large shells, and divides the world into islands. `is_whole`: into one.
    fn divide(&mut self, parts: &[Part], points: &[Point], tools: usize, is_whole: bool) {
        let joined = &mut self.broad.joined;
        let moving = |part: usize| !parts[part].is_fixed;
        for &number in &self.numbers.all()[self.always..] {
            let Point { first, second, .. } = points[number];
            if moving(first) && moving(second) {
                joined.join(first, second);
            }
        }
        if is_whole {
            for part in (1..parts.len()).filter(|&part| moving(part)) {
                joined.join(0, part);
            }
        }
        let islands = &mut self.islands;
        islands.number(joined, parts, tools);
        let sides = |number: &usize| (*number, [points[*number].first, points[*number].second]);
        islands.distribute(Kind::Points, self.numbers.all().iter().map(sides));
        islands.distribute(Kind::Surfaces, self.surfaces.iter().copied().enumerate());
        islands.distribute(Kind::Links, self.links.iter().copied().enumerate());
        let pairs = &self.broad.pairs.all;
        let near = self.broad.near().iter().map(|&number| &pairs[number]);
        let blocks = near.filter_map(|pair| Some((pair.blocks?, pair.parts)));
        islands.distribute(Kind::Blocks, blocks);
    }

    /// Activates the points of the near pairs.
    fn take_pairs(&mut self) {
        self.numbers.clear();
        self.fresh.clear();
        for &number in self.broad.near() {
            let pair = &self.broad.pairs.all[number];
            for point in pair.numbers() {
                self.numbers.push(point);
            }
            if let Some(blocks) = pair.blocks.filter(|_| !self.broad.was_near(number)) {
                self.fresh.push(blocks);
            }
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
    /// touches. `is_whole`: all that moves is one island.
    pub fn gather(
        &mut self,
        parts: &[Part],
        points: &[Point],
        touches: impl Fn(usize) -> bool,
        (tools, is_whole): (usize, bool),
        h: f64,
    ) {
        let is_whole = is_whole || self.is_whole;
        let mut found = Found::new();
        for &number in &self.numbers.all()[self.always..] {
            if touches(number) {
                found.take(f64::NEG_INFINITY, number);
            }
        }
        self.broad.select(parts, &self.links, &touches, is_whole, h);
        self.take_pairs();
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
        self.divide(parts, points, tools, is_whole);
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
#[inline]
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
mod selection_tests;
