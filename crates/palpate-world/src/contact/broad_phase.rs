//! Pairs of tools and bodies that are near enough to touch within an interval: sweep and prune along one axis.

use std::sync::Arc;

use crate::contact::convex_pairs::Blocks;
use crate::contact::pairs::Point;
use crate::dynamics::moving_body::Part;
use crate::geometry::rigid::Vector3;
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

/// All pairs of a world, by what the broad phase has to do for each.
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
}

impl Pairs {
    /// Groups the contact points of a world with this number of tools and bodies. `is_excluded`: points that are
    /// selected otherwise.
    pub fn new(points: &[Point], blocks: &[Blocks], is_excluded: &[bool], parts: usize) -> Self {
        let mut radii = vec![0.0_f64; parts];
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
        }
    }

    fn between(&self, one: usize, other: usize) -> Option<usize> {
        let partners = &self.partners[one.min(other)];
        let found = partners.binary_search_by_key(&one.max(other), |(partner, _)| *partner);
        found.ok().map(|place| partners[place].1)
    }
}

/// Safety margin of the distance at which two parts stay apart within an interval, in addition to their approach `[m]`.
pub(crate) const MARGIN: f64 = 2e-4;

/// Selection of the near pairs.
#[derive(Clone, Debug)]
pub(crate) struct BroadPhase {
    pub pairs: Arc<Pairs>,
    /// Near pairs, in ascending order.
    near: List,
    is_near: Box<[bool]>,
    /// The same before the last selection.
    before: List,
    was_near: Box<[bool]>,
    /// Parts in the order of the lower ends of their extents along the swept axis.
    order: Box<[usize]>,
    /// Extent of each part along that axis `[m]`.
    extents: Box<[[f64; 2]]>,
}

impl BroadPhase {
    pub fn new(pairs: Pairs) -> Self {
        Self {
            near: List::new(pairs.all.len()),
            is_near: vec![false; pairs.all.len()].into(),
            before: List::new(pairs.all.len()),
            was_near: vec![false; pairs.all.len()].into(),
            order: pairs.bounded.clone().into(),
            extents: vec![[0.0; 2]; pairs.radii.len()].into(),
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

    /// Selects the pairs with a point that `touches`, and those whose parts may touch within `h` `[s]`.
    pub fn select(&mut self, parts: &[Part], touches: impl Fn(usize) -> bool, h: f64) {
        let pairs = self.pairs.clone();
        self.clear();
        for &number in self.before.all() {
            if pairs.all[number].numbers().any(&touches) {
                Self::add(&mut self.near, &mut self.is_near, number);
            }
        }
        for &number in &pairs.always {
            Self::add(&mut self.near, &mut self.is_near, number);
        }
        // Each of the two may become twice as fast as the fastest part, by the push of a heavier one.
        let speeds = parts.iter().zip(&pairs.radii);
        let fastest = speeds.map(|(part, radius)| part.speed(*radius, h));
        let reach = 2.0 * fastest.fold(0.0, f64::max) * 2.0 * h + 0.5 * MARGIN;
        for &number in &pairs.unbounded {
            if is_near_plane(&pairs.all[number], &pairs, parts, 2.0 * reach) {
                Self::add(&mut self.near, &mut self.is_near, number);
            }
        }
        self.sweep(&pairs, parts, reach);
        self.near.sort();
    }

    /// Adds the pairs of bounded parts that are nearer than twice the `reach` `[m]`.
    fn sweep(&mut self, pairs: &Pairs, parts: &[Part], reach: f64) {
        let places = || self.order.iter().map(|&part| &parts[part].rigid.position);
        let mut bounds = [
            Vector3::repeat(f64::INFINITY),
            Vector3::repeat(f64::NEG_INFINITY),
        ];
        for place in places() {
            bounds = [bounds[0].inf(place), bounds[1].sup(place)];
        }
        let axis = (bounds[1] - bounds[0]).imax();
        for &part in &self.order {
            let (middle, radius) = (parts[part].rigid.position[axis], pairs.radii[part] + reach);
            self.extents[part] = [middle - radius, middle + radius];
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
                let apart = parts[one].rigid.position - parts[other].rigid.position;
                let near = pairs.radii[one] + pairs.radii[other] + 2.0 * reach;
                if apart.norm_squared() <= near * near
                    && let Some(pair) = pairs.between(one, other)
                {
                    Self::add(&mut self.near, &mut self.is_near, pair);
                }
            }
        }
    }

    fn low(&self, place: usize) -> f64 {
        self.extents[self.order[place]][0]
    }
}

/// Returns whether the bounding sphere of the first part is nearer to the half-space of the second than `reach` `[m]`.
fn is_near_plane(pair: &Pair, pairs: &Pairs, parts: &[Part], reach: f64) -> bool {
    let Some((normal, offset)) = pair.plane else {
        return true;
    };
    let [first, second] = pair.parts.map(|part| &parts[part].rigid);
    let normal = second.orientation * normal;
    let above = normal.dot(&(first.position - second.position)) - offset;
    above <= pairs.radii[pair.parts[0]] + reach
}
