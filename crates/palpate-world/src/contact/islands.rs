//! Islands: tools and bodies that no others can reach through contacts and joints within an interval.

use crate::dynamics::moving_body::Part;

/// Joined tools and bodies, each with the speed of the fastest part that can push it.
#[derive(Clone, Debug)]
pub(crate) struct Joined {
    /// Another part of the same island, or the part itself for the first of an island.
    towards: Box<[usize]>,
    /// Largest speed in the island of a first part `[m/s]`.
    speeds: Box<[f64]>,
}

impl Joined {
    pub fn new(parts: usize) -> Self {
        Self {
            towards: (0..parts).collect(),
            speeds: vec![0.0; parts].into(),
        }
    }

    /// Makes each part an island. `radii` are those of the parts' bounding spheres `[m]`; parts that can move have at
    /// least the speeds `least` `[m/s]`. Returns the largest speed over `h` `[s]` `[m/s]`.
    pub fn separate(&mut self, parts: &[Part], radii: &[f64], least: &[f64], h: f64) -> f64 {
        let mut fastest = 0.0_f64;
        for (number, part) in parts.iter().enumerate() {
            self.towards[number] = number;
            self.speeds[number] = part.speed(radii[number], h);
            if least[number] > self.speeds[number] && !part.is_fixed {
                self.speeds[number] = least[number];
            }
            fastest = fastest.max(self.speeds[number]);
        }
        fastest
    }

    /// Returns the first part of a part's island.
    pub fn first(&mut self, mut part: usize) -> usize {
        while self.towards[part] != part {
            self.towards[part] = self.towards[self.towards[part]];
            part = self.towards[part];
        }
        part
    }

    /// Joins the islands of two parts that can move.
    pub fn join(&mut self, one: usize, other: usize) {
        let (one, other) = (self.first(one), self.first(other));
        if one != other {
            let (first, second) = (one.min(other), one.max(other));
            self.towards[second] = first;
            self.speeds[first] = self.speeds[first].max(self.speeds[second]);
        }
    }

    /// Returns the largest speed in the island of a part `[m/s]`.
    pub fn speed(&mut self, part: usize) -> f64 {
        let first = self.first(part);
        self.speeds[first]
    }
}

/// Items in the order of their islands, with a constant capacity.
#[derive(Clone, Debug)]
struct Grouped {
    items: Box<[usize]>,
    /// End of each island's items.
    ends: Box<[usize]>,
}

impl Grouped {
    fn new(capacity: usize, islands: usize) -> Self {
        Self {
            items: vec![0; capacity].into(),
            ends: vec![0; islands + 1].into(),
        }
    }

    /// Sets the items, each with its island.
    fn fill(&mut self, islands: usize, each: impl Iterator<Item = (usize, usize)> + Clone) {
        let ends = &mut self.ends[..=islands];
        ends.fill(0);
        for (_, island) in each.clone() {
            ends[island] += 1;
        }
        let mut start = 0;
        for end in ends.iter_mut() {
            start += std::mem::replace(end, start);
        }
        for (item, island) in each {
            self.items[ends[island]] = item;
            ends[island] += 1;
        }
    }

    /// Returns the number of items of the first `islands`.
    fn end(&self, islands: usize) -> usize {
        islands.checked_sub(1).map_or(0, |last| self.ends[last])
    }

    fn copy_from(&mut self, other: &Self, islands: usize) {
        self.ends[..=islands].copy_from_slice(&other.ends[..=islands]);
        let count = other.end(islands);
        self.items[..count].copy_from_slice(&other.items[..count]);
    }
}

/// What belongs to an island.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Kind {
    /// Tools and bodies that move; tools come first.
    Parts,
    /// Contact points.
    Points,
    /// Spheres on meshes.
    Surfaces,
    /// Pairs of convex solids.
    Blocks,
    /// Springs of joints.
    Links,
}

/// Islands of a world over an interval. Those that are awake come first.
#[derive(Clone, Debug)]
pub(crate) struct Islands {
    grouped: [Grouped; 5],
    /// Island of each part.
    numbers: Box<[usize]>,
    count: usize,
    awake: usize,
    /// Places of the items of the selected islands.
    scope: [(usize, usize); 5],
}

const NONE: usize = usize::MAX;

impl Islands {
    /// `capacities`: largest number of items of each [`Kind`].
    pub fn new(capacities: [usize; 5]) -> Self {
        let parts = capacities[Kind::Parts as usize];
        Self {
            grouped: capacities.map(|capacity| Grouped::new(capacity, parts)),
            numbers: vec![NONE; parts].into(),
            count: 0,
            awake: 0,
            scope: [(0, 0); 5],
        }
    }

    /// Returns the items of the selected islands.
    #[inline]
    pub fn all(&self, kind: Kind) -> &[usize] {
        let (start, end) = self.scope[kind as usize];
        &self.grouped[kind as usize].items[start..end]
    }

    /// Returns the items of all islands, including those at rest.
    pub fn with_resting(&self, kind: Kind) -> &[usize] {
        let grouped = &self.grouped[kind as usize];
        &grouped.items[..grouped.end(self.count)]
    }

    /// Returns the number of islands that are awake.
    pub fn awake(&self) -> usize {
        self.awake
    }

    /// Selects one island.
    pub fn enter(&mut self, island: usize) {
        self.scope = self
            .grouped
            .each_ref()
            .map(|of| (of.end(island), of.end(island + 1)));
    }

    /// Selects all islands that are awake.
    pub fn leave(&mut self) {
        self.scope = self.grouped.each_ref().map(|of| (0, of.end(self.awake)));
    }

    pub fn copy_from(&mut self, other: &Self) {
        for (own, other_items) in self.grouped.iter_mut().zip(&other.grouped) {
            own.copy_from(other_items, other.count);
        }
        (self.count, self.awake, self.scope) = (other.count, other.awake, other.scope);
    }

    /// Numbers the islands. One without a tool whose bodies are all at rest is at rest.
    pub fn number(&mut self, joined: &mut Joined, parts: &[Part], tools: usize) {
        let Self { numbers, .. } = self;
        // Whether an island is awake, at the place of its first part.
        numbers.fill(0);
        for (part, of) in parts.iter().enumerate() {
            if !of.is_fixed && (part < tools || !of.rests) {
                numbers[joined.first(part)] = 1;
            }
        }
        let mut count = 0;
        for is_awake in [1, 0] {
            for part in 0..parts.len() {
                if !parts[part].is_fixed && joined.first(part) == part && numbers[part] == is_awake
                {
                    numbers[part] = 2 + count;
                    count += 1;
                }
            }
            if is_awake == 1 {
                self.awake = count;
            }
        }
        for part in 0..parts.len() {
            let first = joined.first(part);
            numbers[part] = if parts[part].is_fixed {
                NONE
            } else if first == part {
                numbers[part] - 2
            } else {
                // A first part comes before the others of its island.
                numbers[first]
            };
        }
        self.count = count;
        let each = numbers.iter().copied().enumerate();
        let each = each.filter(|(_, island)| *island != NONE);
        self.grouped[Kind::Parts as usize].fill(count, each);
        self.leave();
    }

    /// Distributes items over the islands by their two sides; those between fixed bodies are left out.
    pub fn distribute(
        &mut self,
        kind: Kind,
        items: impl Iterator<Item = (usize, [usize; 2])> + Clone,
    ) {
        let Self { numbers, .. } = self;
        // A fixed side has the largest number.
        let each = items.map(|(item, [one, other])| (item, numbers[one].min(numbers[other])));
        let each = each.filter(|(_, island)| *island != NONE);
        self.grouped[kind as usize].fill(self.count, each);
        self.scope[kind as usize] = (0, self.grouped[kind as usize].end(self.awake));
    }
}
