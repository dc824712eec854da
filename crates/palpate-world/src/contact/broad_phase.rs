//! Pairs of tools and bodies that are near enough to touch within an interval: sweep and prune along one axis.

use std::sync::Arc;

use crate::contact::convex_pairs::Blocks;
use crate::contact::islands::Joined;
use crate::contact::pairs::Point;
use crate::dynamics::moving_body::Part;
use crate::geometry::rigid::{Rigid, Vector3};
use crate::geometry::solid::Solid;

/// A list of indices with a constant capacity, so a tick does not allocate.
#[derive(Clone, Debug)]
pub(crate) struct List {
    items: Box<[usize]>,
    count: usize,
}

impl List {
    pub fn new(capacity: usize) -> Self {
        Self {
            items: vec![0; capacity].into(),
            count: 0,
        }
    }

    pub fn all(&self) -> &[usize] {
        &self.items[..self.count]
    }

    pub fn clear(&mut self) {
        self.count = 0;
    }

    pub fn sort(&mut self) {
        self.items[..self.count].sort_unstable();
    }

    /// Adds an index. Returns whether there was room.
    pub fn push(&mut self, item: usize) -> bool {
        let has_room = self.count < self.items.len();
        if has_room {
            self.items[self.count] = item;
            self.count += 1;
        }
        has_room
    }

    /// Copies `other`, which has the same capacity.
    pub fn copy_from(&mut self, other: &Self) {
        self.items[..other.count].copy_from_slice(other.all());
        self.count = other.count;
    }
}

/// Two tools or bodies that can touch, with consecutive contact points.
#[derive(Clone, Debug)]
pub(crate) struct Pair {
    pub parts: [usize; 2],
    pub first_point: usize,
    pub points: usize,
    /// Index among the pairs of convex solids, if it is one.
    pub blocks: Option<usize>,
    /// Plane of the second, if it is a half-space: normal and offset in its axes `[m]`.
    plane: Option<(Vector3, f64)>,
    /// Whether it is near at any distance.
    is_always_near: bool,
}

impl Pair {
    pub fn numbers(&self) -> std::ops::Range<usize> {
        self.first_point..self.first_point + self.points
    }
}

/// All pairs of a world, by how the broad phase finds them.
#[derive(Debug)]
pub(crate) struct Pairs {
    pub all: Vec<Pair>,
    /// For each part, the later parts with which it forms a pair, in ascending order, and the indices of these pairs.
    partners: Vec<Vec<(usize, usize)>>,
    /// Pairs that are near at any distance.
    always: Vec<usize>,
    /// Pairs with an unbounded part.
    unbounded: Vec<usize>,
    /// Parts of the other pairs.
    bounded: Vec<usize>,
    /// Radius of each part's bounding sphere about its centre of mass `[m]`.
    radii: Vec<f64>,
    /// Half-extents of each part along its own axes; of a ball its radius `[m]`.
    halves: Vec<Vector3>,
}

impl Pairs {
    /// Groups the contact points of a world. `is_excluded`: points that are selected otherwise. `halves`: half-extents of
    /// each tool and body along its own axes `[m]`.
    pub fn new(
        points: &[Point],
        blocks: &[Blocks],
        is_excluded: &[bool],
        halves: Vec<Vector3>,
    ) -> Self {
        let parts = halves.len();
        // A part without contact points also has an extent: its rotation moves its surface.
        let mut radii: Vec<f64> = halves.iter().map(|half| half.max()).collect();
        let mut all: Vec<Pair> = Vec::new();
        let key = |point: &Point| {
            let surface = match point.solid {
                Solid::Mesh { surface, .. } => Some(surface),
                _ => None,
            };
            ([point.first, point.second], surface)
        };
        for (number, point) in points.iter().enumerate() {
            let reaches = [point.centre.norm() + point.radius, point.solid.reach()];
            for (side, reach) in [point.first, point.second].into_iter().zip(reaches) {
                radii[side] = radii[side].max(reach);
            }
            if is_excluded[number] {
                continue;
            }
            let last = all.last_mut().filter(|last| {
                last.numbers().end == number && key(&points[last.first_point]) == key(point)
            });
            if let Some(last) = last {
                last.points += 1;
                continue;
            }
            all.push(Pair {
                parts: [point.first, point.second],
                first_point: number,
                points: 1,
                blocks: match point.solid {
                    Solid::Between { blocks, .. } => Some(blocks),
                    _ => None,
                },
                plane: match point.solid {
                    Solid::HalfSpace { normal, offset } => Some((normal, offset)),
                    Solid::Between { blocks: of, .. } => blocks[of].plane(),
                    _ => None,
                },
                // A mesh follows the side of a sphere in every sub-step; a held contact is at its method's discretion.
                is_always_near: point.is_held || matches!(point.solid, Solid::Mesh { .. }),
            });
        }
        let mut partners = vec![Vec::new(); parts];
        let (mut always, mut unbounded) = (Vec::new(), Vec::new());
        let mut is_bounded = vec![false; parts];
        for (number, pair) in all.iter().enumerate() {
            let [first, second] = pair.parts;
            if pair.is_always_near {
                always.push(number);
            } else if pair.parts.iter().any(|&part| !radii[part].is_finite()) {
                unbounded.push(number);
            } else {
                partners[first.min(second)].push((first.max(second), number));
                (is_bounded[first], is_bounded[second]) = (true, true);
            }
        }
        for partners in &mut partners {
            partners.sort_unstable();
        }
        Self {
            all,
            partners,
            always,
            unbounded,
            bounded: (0..parts).filter(|&part| is_bounded[part]).collect(),
            radii,
            halves,
        }
    }

    fn is_ball(&self, part: usize) -> bool {
        self.halves[part] == Vector3::repeat(self.radii[part])
    }

    /// Returns the radius of each part's bounding sphere `[m]`.
    pub fn radii(&self) -> &[f64] {
        &self.radii
    }

    fn between(&self, one: usize, other: usize) -> Option<usize> {
        let partners = &self.partners[one.min(other)];
        let found = partners.binary_search_by_key(&one.max(other), |(partner, _)| *partner);
        found.ok().map(|place| partners[place].1)
    }
}

/// Ratio of the speed that a part is assumed to reach within an interval to the largest one in its island: 2 by the push
/// of a heavier part, and as much again where that turns it. A part between two others may become faster, and the
/// interval is then repeated.
const PUSHED: f64 = 4.0;
/// Ratio of the displacement that a repeated interval assumes to that of a part that moved too far.
const WIDER: f64 = 2.0;
/// Number of searches for pairs after which all candidates are near.
const MAX_PASSES: usize = 16;

/// Ratio of the mean square extents of two axes above which the sweep changes to the larger one.
const CLEARLY: f64 = 1.5;

/// Width of the steps to which the lower ends of extents are rounded down; unlike positions of bodies, no round number
/// `[m]`.
const GRAIN: f64 = 1.618e-5;

/// Safety margin of the distance at which two parts stay apart within an interval, in addition to their approach `[m]`.
pub(crate) const MARGIN: f64 = 2e-4;

/// Selection of the near pairs.
#[derive(Clone, Debug)]
pub(crate) struct BroadPhase {
    pub pairs: Arc<Pairs>,
    /// Parts joined by near pairs.
    pub joined: Joined,
    /// Pairs that may be near (scratch buffer).
    candidates: List,
    /// Near pairs, in ascending order.
    near: List,
    is_near: Box<[bool]>,
    /// The same before the last selection.
    before: List,
    was_near: Box<[bool]>,
    /// Swept axis; `None` before the first sweep.
    axis: Option<usize>,
    /// Parts in the order of the lower ends of their extents along the swept axis.
    order: Box<[usize]>,
    /// Half-extents of each part along the world's axes `[m]`.
    halves: Box<[Vector3]>,
    /// Extent of each part along the swept axis `[m]`.
    extents: Box<[[f64; 2]]>,
    /// Speeds of all parts that the last selection assumed `[m/s]`.
    assumed: Box<[f64]>,
    /// Speeds that the next selection assumes at least `[m/s]`.
    least: Box<[f64]>,
}

impl BroadPhase {
    pub fn new(pairs: Pairs) -> Self {
        Self {
            joined: Joined::new(pairs.radii.len()),
            candidates: List::new(pairs.all.len()),
            near: List::new(pairs.all.len()),
            is_near: vec![false; pairs.all.len()].into(),
            before: List::new(pairs.all.len()),
            was_near: vec![false; pairs.all.len()].into(),
            axis: None,
            order: pairs.bounded.clone().into(),
            halves: pairs.halves.clone().into(),
            extents: vec![[0.0; 2]; pairs.radii.len()].into(),
            assumed: vec![0.0; pairs.radii.len()].into(),
            least: vec![0.0; pairs.radii.len()].into(),
            pairs: Arc::new(pairs),
        }
    }

    /// Returns the near pairs, in ascending order.
    pub fn near(&self) -> &[usize] {
        self.near.all()
    }

    /// Returns whether a pair was near before the last selection.
    pub fn was_near(&self, pair: usize) -> bool {
        self.was_near[pair]
    }

    /// Copies the selection, without allocation.
    pub fn copy_from(&mut self, other: &Self) {
        self.clear();
        for &pair in other.near() {
            Self::add(&mut self.near, &mut self.is_near, pair);
        }
        self.order.copy_from_slice(&other.order);
        self.axis = other.axis;
    }

    fn add(near: &mut List, is_near: &mut [bool], pair: usize) {
        if !is_near[pair] {
            is_near[pair] = true;
            near.push(pair);
        }
    }

    /// Begins a selection.
    fn clear(&mut self) {
        for &pair in self.before.all() {
            self.was_near[pair] = false;
        }
        std::mem::swap(&mut self.near, &mut self.before);
        std::mem::swap(&mut self.is_near, &mut self.was_near);
        self.near.clear();
    }

    /// Selects only the pairs with a point that `touches`.
    pub fn select_touching(&mut self, touches: impl Fn(usize) -> bool) {
        self.clear();
        for (number, pair) in self.pairs.all.iter().enumerate() {
            if pair.is_always_near || pair.numbers().any(&touches) {
                Self::add(&mut self.near, &mut self.is_near, number);
            }
        }
    }

    /// Selects the pairs with a point that `touches`, and those whose parts may touch within `h` `[s]`. Joins their parts,
    /// and those of `links`.
    pub fn select(
        &mut self,
        parts: &[Part],
        links: &[[usize; 2]],
        touches: impl Fn(usize) -> bool,
        is_whole: bool,
        h: f64,
    ) {
        let pairs = self.pairs.clone();
        self.clear();
        let fastest = self.joined.separate(parts, &pairs.radii, &self.least, h);
        for &[one, other] in links {
            self.join(parts, one, other);
        }
        for place in 0..self.before.all().len() {
            let number = self.before.all()[place];
            if pairs.all[number].numbers().any(&touches) {
                self.choose(parts, &pairs, number);
            }
        }
        for &number in &pairs.always {
            self.choose(parts, &pairs, number);
        }
        let reach = PUSHED * fastest * h + 0.5 * MARGIN;
        self.candidates.clear();
        for &number in &pairs.unbounded {
            if !self.is_near[number] && self.gap(number, parts) <= 2.0 * reach {
                self.candidates.push(number);
            }
        }
        self.sweep(&pairs, parts, reach);
        self.choose_candidates(parts, &pairs, is_whole, h);
        self.near.sort();
        for part in 0..parts.len() {
            self.assumed[part] = if is_whole {
                fastest
            } else {
                self.joined.speed(part)
            };
        }
    }

    /// Returns whether all pairs are near, so nothing depends on the assumed speeds.
    pub fn has_all(&self) -> bool {
        self.near().len() == self.pairs.all.len()
    }

    /// Assumes only the speeds at the start of an interval.
    pub fn assume_little(&mut self) {
        self.least.fill(0.0);
    }

    /// Assumes that everything moves by any distance, so all pairs are near.
    pub fn assume_all(&mut self) {
        self.least.fill(f64::INFINITY);
    }

    /// Returns whether one of the parts `moved` further within `h` `[s]` than the last selection assumed, and assumes that
    /// it moves by more in the next.
    pub fn was_outrun(&mut self, parts: &[Part], moved: &[usize], h: f64) -> bool {
        let mut was_outrun = false;
        for &number in moved {
            let part = &parts[number];
            let way = part.way + part.turned * self.pairs.radii[number];
            if way > PUSHED * h * self.assumed[number] + 0.5 * MARGIN {
                self.least[number] = WIDER * way / (PUSHED * h);
                was_outrun = true;
            }
        }
        was_outrun
    }

    /// Returns the distance at which two parts stay apart within `h` `[s]` `[m]`.
    fn reach(&mut self, sides: [usize; 2], h: f64) -> f64 {
        let [one, other] = sides.map(|part| self.joined.speed(part));
        PUSHED * h * (one + other) + MARGIN
    }

    fn join(&mut self, parts: &[Part], one: usize, other: usize) {
        if !parts[one].is_fixed && !parts[other].is_fixed {
            self.joined.join(one, other);
        }
    }

    fn choose(&mut self, parts: &[Part], pairs: &Pairs, number: usize) {
        Self::add(&mut self.near, &mut self.is_near, number);
        let [one, other] = pairs.all[number].parts;
        self.join(parts, one, other);
    }

    /// Selects the candidates that the parts of their islands bring together. A chosen pair makes an island faster, so
    /// the search is repeated until none is chosen.
    fn choose_candidates(&mut self, parts: &[Part], pairs: &Pairs, is_whole: bool, h: f64) {
        let mut is_done = false;
        let mut passes = 0;
        while !is_done {
            (is_done, passes) = (true, passes + 1);
            for place in 0..self.candidates.all().len() {
                let number = self.candidates.all()[place];
                if self.is_near[number] {
                    continue;
                }
                let reach = self.reach(pairs.all[number].parts, h);
                // Not reached if a speed is not a number, which the tick reports.
                if self.gap(number, parts) <= reach || passes > MAX_PASSES || is_whole {
                    self.choose(parts, pairs, number);
                    is_done = false;
                }
            }
        }
    }

    /// Returns a lower bound of the distance of the two parts of a pair `[m]`.
    fn gap(&self, number: usize, parts: &[Part]) -> f64 {
        let pair = &self.pairs.all[number];
        let [one, other] = pair.parts;
        let [first, second] = pair.parts.map(|part| &parts[part].rigid);
        let apart = first.position - second.position;
        let Some((normal, offset)) = pair.plane else {
            let between_boxes = apart.abs() - self.halves[one] - self.halves[other];
            let between_balls = apart.norm() - self.pairs.radii[one] - self.pairs.radii[other];
            return between_boxes.max().max(between_balls);
        };
        let normal = second.orientation * normal;
        let reach = if self.pairs.is_ball(one) {
            self.pairs.radii[one]
        } else {
            let own = first.orientation.inverse_transform_vector(&normal);
            own.abs().dot(&self.pairs.halves[one])
        };
        normal.dot(&apart) - offset - reach
    }

    /// Adds the pairs of bounded parts that are nearer than twice the `reach` `[m]`.
    fn sweep(&mut self, pairs: &Pairs, parts: &[Part], reach: f64) {
        let axis = self.swept_axis(parts);
        for &part in &self.order {
            let Rigid {
                position,
                orientation,
                ..
            } = &parts[part].rigid;
            if !pairs.is_ball(part) {
                let turned = orientation.to_rotation_matrix().into_inner().abs();
                self.halves[part] = turned * pairs.halves[part];
            }
            let half = self.halves[part][axis] + reach;
            // Parts in a row would change places at every interval by displacements of nanometres.
            let low = ((position[axis] - half) / GRAIN).floor() * GRAIN;
            self.extents[part] = [low, position[axis] + half];
        }
        if self.axis != Some(axis) {
            self.axis = Some(axis);
            let extents = &self.extents;
            let low = |part: usize| extents[part][0];
            self.order
                .sort_unstable_by(|&one, &other| low(one).total_cmp(&low(other)));
        }
        // The order hardly changes from one interval to the next.
        for end in 1..self.order.len() {
            let mut place = end;
            while place > 0 && self.low(place) < self.low(place - 1) {
                self.order.swap(place, place - 1);
                place -= 1;
            }
        }
        for place in 0..self.order.len() {
            let one = self.order[place];
            let high = self.extents[one][1];
            for &other in &self.order[place + 1..] {
                if self.extents[other][0] > high {
                    break;
                }
                // The distance of the bounding spheres takes less time than the look-up.
                let [first, second] = [one, other].map(|part| &parts[part].rigid.position);
                let between_balls = (first - second).norm() - pairs.radii[one] - pairs.radii[other];
                if between_balls > 2.0 * reach {
                    continue;
                }
                if let Some(pair) = pairs.between(one, other)
                    && !self.is_near[pair]
                    && self.gap(pair, parts) <= 2.0 * reach
                {
                    self.candidates.push(pair);
                }
            }
        }
    }

    /// Returns the axis along which the bounded parts are spread out most, by the mean square: one distant part does not
    /// decide it. The axis of the last sweep stays unless another is clearly better.
    fn swept_axis(&self, parts: &[Part]) -> usize {
        let (mut sum, mut squares) = (Vector3::zeros(), Vector3::zeros());
        let Some(&any) = self.order.first() else {
            return 0;
        };
        let origin = parts[any].rigid.position;
        for &part in &self.order {
            let place = parts[part].rigid.position - origin;
            sum += place;
            squares += place.component_mul(&place);
        }
        let spread = squares - sum.component_mul(&sum) / self.order.len() as f64;
        let best = spread.imax();
        self.axis
            .filter(|&last| spread[best] <= CLEARLY * spread[last])
            .unwrap_or(best)
    }

    fn low(&self, place: usize) -> f64 {
        self.extents[self.order[place]][0]
    }
}

#[cfg(test)]
mod tests {
    use crate::{
        BasicParams, Body, Contact, ContactLaw, Free, Motion, Party, Sample, Shape, Tool, World,
        WorldLoop, WorldRenderer,
    };

    /// Balls in a row, and a tool far above them: along z all balls overlap.
    #[test]
    fn one_distant_part_does_not_decide_the_swept_axis() {
        let radius = 0.02;
        let balls = (0..20).map(|number| {
            let free = Motion::Free(Free::of_mass(0.05));
            let ball = Body::new(format!("ball {number}"), Shape::Sphere { radius }, free);
            ball.at([0.0, 0.1 * f64::from(number), 0.0])
        });
        let world = World {
            tools: vec![Tool::new("tool", Shape::Sphere { radius })],
            bodies: balls.collect(),
            contacts: vec![Contact {
                between: [Party::Any, Party::Any],
                law: ContactLaw::spring(1000.0),
            }],
            ..World::default()
        };
        let method = BasicParams::default();
        let renderer = WorldRenderer::new(&world, WorldLoop::new(0.001), method).unwrap();
        let mut state = renderer.start();
        for _ in 0..3 {
            let _ = renderer.step(&mut state, &Sample::at(&[[0.0, 1.0, 2.1]]));
        }
        assert_eq!(state.progress.now.nearby.broad.axis, Some(1));
    }
}
