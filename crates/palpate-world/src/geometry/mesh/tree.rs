//! Bounding volume hierarchy of boxes over the triangles of a mesh.

use crate::geometry::rigid::Vector3;

/// Maximum number of triangles in a leaf.
const LEAF: usize = 4;
/// Depth of a median-split tree over 2^32 triangles, plus a margin.
const DEPTH: usize = 40;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub least: Vector3,
    pub most: Vector3,
}

impl Bounds {
    /// Returns an empty box.
    pub fn empty() -> Self {
        Self {
            least: Vector3::repeat(f64::INFINITY),
            most: Vector3::repeat(f64::NEG_INFINITY),
        }
    }

    pub fn with(self, place: &Vector3) -> Self {
        Self {
            least: self.least.inf(place),
            most: self.most.sup(place),
        }
    }

    fn and(self, other: &Self) -> Self {
        self.with(&other.least).with(&other.most)
    }

    /// Returns the squared distance of a position from the box `[m^2]`.
    fn square_from(&self, place: &Vector3) -> f64 {
        let off = |axis: usize| {
            let short = self.least[axis] - place[axis];
            short.max(place[axis] - self.most[axis]).max(0.0)
        };
        Vector3::new(off(0), off(1), off(2)).norm_squared()
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    bounds: Bounds,
    /// Leaf: index of its first triangle in `order`, and their number. Inner node: index of its second child, and 0;
    /// its first child is the next node.
    first: u32,
    count: u32,
}

/// A tree of boxes, each split across its longest side into halves with equal numbers of triangles.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

impl Tree {
    /// Builds a tree over the boxes of triangles: at least one and fewer than 2^31.
    pub fn over(boxes: &[Bounds]) -> Self {
        let mut order: Vec<u32> = (0..).take(boxes.len()).collect();
        let mut nodes = Vec::new();
        split(boxes, &mut order, 0, &mut nodes);
        Self { nodes, order }
    }

    /// Calls `take` with every triangle whose box is within `reach` `[m]` of `place`, near boxes first, until it
    /// returns `false`. Returns whether it never did.
    pub fn within(&self, place: &Vector3, reach: f64, mut take: impl FnMut(u32) -> bool) -> bool {
        let mut goes_on = true;
        self.nearest(place, |triangle| {
            goes_on &= take(triangle);
            if goes_on { reach * reach } else { -1.0 }
        });
        goes_on
    }

    /// Calls `take` with the triangles that may be nearest to `place`, near boxes first. `take` returns the least
    /// squared distance found so far `[m^2]`.
    pub fn nearest(&self, place: &Vector3, mut take: impl FnMut(u32) -> f64) {
        let mut waiting = [(0.0, 0_u32); DEPTH];
        let mut count = 1;
        let mut least = f64::INFINITY;
        while count > 0 {
            count -= 1;
            let (square, number) = waiting[count];
            if square > least {
                continue;
            }
            let node = &self.nodes[number as usize];
            if node.count > 0 {
                let from = node.first as usize;
                for &triangle in &self.order[from..from + node.count as usize] {
                    least = take(triangle);
                }
            } else if count + 2 <= DEPTH {
                let of = |child: u32| {
                    let bounds = &self.nodes[child as usize].bounds;
                    (bounds.square_from(place), child)
                };
                let (one, other) = (of(number + 1), of(node.first));
                // Visit the nearer child next.
                (waiting[count], waiting[count + 1]) = if one.0 < other.0 {
                    (other, one)
                } else {
                    (one, other)
                };
                count += 2;
            }
        }
    }
}

fn split(boxes: &[Bounds], order: &mut [u32], from: u32, nodes: &mut Vec<Node>) {
    let all = order.iter().map(|&triangle| &boxes[triangle as usize]);
    let bounds = all.fold(Bounds::empty(), Bounds::and);
    let number = nodes.len();
    let count = order.len();
    let is_leaf = count <= LEAF;
    nodes.push(Node {
        bounds,
        first: from,
        count: if is_leaf { size(count) } else { 0 },
    });
    if is_leaf {
        return;
    }
    let axis = (bounds.most - bounds.least).imax();
    let middle = |triangle: &u32| {
        let Bounds { least, most } = &boxes[*triangle as usize];
        least[axis] + most[axis]
    };
    let half = count / 2;
    order.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)));
    let (low, high) = order.split_at_mut(half);
    split(boxes, low, from, nodes);
    nodes[number].first = size(nodes.len());
    split(boxes, high, from + size(half), nodes);
}

/// Converts a number of triangles or nodes; a mesh has far fewer than 2^32.
#[expect(
    clippy::cast_possible_truncation,
    reason = "a mesh has at most a million triangles"
)]
pub(super) fn size(count: usize) -> u32 {
    count as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tree_finds_what_looking_at_every_box_finds() {
        let boxes: Vec<Bounds> = (0..1500)
            .map(|number| {
                let part = |prime: f64| (f64::from(number) * prime).fract();
                let place = Vector3::new(part(0.754_877), part(0.569_840), part(0.430_160));
                let size = Vector3::new(0.02, 0.01 + 0.1 * part(0.31), 0.03);
                Bounds::empty().with(&place).with(&(place + size))
            })
            .collect();
        let tree = Tree::over(&boxes);
        let mut largest = 0;
        for number in 0..200 {
            let part = |prime: f64| 1.4 * (f64::from(number) * prime).fract() - 0.2;
            let place = Vector3::new(part(0.819_173), part(0.671_044), part(0.549_700));
            let reach = 0.1 * part(0.618_034).abs();
            let mut found = Vec::new();
            let all = tree.within(&place, reach, |triangle| {
                found.push(triangle);
                true
            });
            assert!(all);
            let near =
                |triangle: &u32| boxes[*triangle as usize].square_from(&place) <= reach * reach;
            found.retain(near);
            found.sort_unstable();
            let all: Vec<u32> = (0..1500).filter(near).collect();
            assert_eq!(found, all);
            let square = |triangle: u32| boxes[triangle as usize].square_from(&place);
            let mut nearest = f64::INFINITY;
            tree.nearest(&place, |triangle| {
                nearest = nearest.min(square(triangle));
                nearest
            });
            assert_eq!(nearest, (0..1500).map(square).fold(f64::INFINITY, f64::min));
            largest = largest.max(all.len());
        }
        assert!(largest > 20, "{largest}");
    }
}
