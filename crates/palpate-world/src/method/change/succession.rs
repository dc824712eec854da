//! Mapping between the elements of a world and those of its predecessor.

use std::collections::{HashMap, VecDeque};
use std::sync::Arc;

use crate::{Joint, Shape, WorldErrors, WorldRenderer};

/// Index mapping from the elements of a world to those of its predecessor, created by [`WorldRenderer::migrate`] and
/// used by [`WorldRenderer::resume`].
#[derive(Clone, Debug)]
pub struct Succession {
    /// Previous index of each tool and body, among tools and bodies.
    pub(super) parts: Vec<Option<usize>>,
    /// Previous index of each body, among bodies.
    pub(super) bodies: Origins,
    /// Previous index of each contact point.
    pub(super) points: Origins,
    /// Previous index of each sphere on a mesh.
    pub(super) surfaces: Vec<Option<usize>>,
    /// Previous index of each pair of boxes, hulls and capsules.
    pub(super) blocks: Vec<Option<usize>>,
    /// Previous index of each joint.
    pub(super) joints: Origins,
}

/// Previous indices of elements that have ledgers.
#[derive(Clone, Debug)]
pub(super) struct Origins {
    /// Previous index of each element.
    pub each: Vec<Option<usize>>,
    /// The same indices in ascending order.
    kept: Vec<usize>,
}

impl Origins {
    fn new(each: Vec<Option<usize>>) -> Self {
        let kept = Vec::with_capacity(each.len());
        let mut all = Self { each, kept };
        all.sort();
        all
    }

    /// Updates the sorted indices. It does not allocate, since no index is ever added.
    fn sort(&mut self) {
        self.kept.clear();
        self.kept.extend(self.each.iter().flatten());
        self.kept.sort_unstable();
    }

    /// Returns the indices of the `count` previous elements that have no successor.
    pub fn gone(&self, count: usize) -> impl Iterator<Item = usize> {
        let mut kept = self.kept.iter().copied().peekable();
        (0..count).filter(move |number| kept.next_if_eq(number).is_none())
    }
}

impl Succession {
    /// Composes the mapping with `before`, the mapping of the predecessor, which never ran. It allocates nothing.
    pub fn skip(&mut self, before: &Self) {
        let each = [
            (&mut self.parts, &before.parts),
            (&mut self.bodies.each, &before.bodies.each),
            (&mut self.points.each, &before.points.each),
            (&mut self.surfaces, &before.surfaces),
            (&mut self.blocks, &before.blocks),
            (&mut self.joints.each, &before.joints.each),
        ];
        for (own, before) in each {
            for was in own {
                *was = was.and_then(|was| before.get(was).copied().flatten());
            }
        }
        for origins in [&mut self.bodies, &mut self.points, &mut self.joints] {
            origins.sort();
        }
    }
}

impl WorldRenderer {
    /// Prepares to continue from the world of `before`; it may run in any thread. Joints that continue keep their
    /// anchors. [Start](Self::start) states only afterwards. `is_kept` states for each body of this world whether a
    /// body with its name continues; otherwise the body starts in its state in this world. Bodies beyond the end of
    /// the list continue.
    ///
    /// [`changed`](Self::changed) defines which bodies, contacts and joints continue. It allocates.
    ///
    /// # Errors
    /// A different number, order, name or kind of tools.
    pub fn migrate(&mut self, before: &Self, is_kept: &[bool]) -> Result<Succession, WorldErrors> {
        before.check_tools(&self.world)?;
        let from = self.origins(before, is_kept);
        for (joint, was) in from.joints.each.iter().enumerate() {
            let links = self.links.iter_mut().filter(|link| link.joint == joint);
            let befores = before.links.iter().filter(|link| Some(link.joint) == *was);
            for (link, before) in links.zip(befores) {
                link.stays_at(before, &self.parts);
            }
        }
        Ok(from)
    }

    fn name_and_shape(&self, part: usize) -> (&str, &Shape) {
        match self.world.tools.get(part) {
            Some(tool) => (&tool.name, &tool.shape),
            None => {
                let body = &self.world.bodies[part - self.tools];
                (&body.name, &body.shape)
            }
        }
    }

    /// Returns the previous indices of all elements, except elements with a body that is not kept.
    fn origins(&self, before: &Self, is_kept: &[bool]) -> Succession {
        let number = |name: &str| {
            let bodies = &before.world.bodies;
            let place = bodies.iter().position(|body| body.name == *name)?;
            Some(before.tools + place)
        };
        let parts: Vec<_> = (0..self.parts.len())
            .map(|part| {
                let Some(body) = part.checked_sub(self.tools) else {
                    return Some(part);
                };
                let is_kept = is_kept.get(body).copied().unwrap_or(true);
                number(self.name_and_shape(part).0).filter(|_| is_kept)
            })
            .collect();
        // Previous index of a part with an unchanged shape.
        let stays = |part: usize| {
            let was = parts[part]?;
            is_same_shape(self.name_and_shape(part).1, before.name_and_shape(was).1).then_some(was)
        };
        let pair = |[first, second]: [usize; 2]| Some([stays(first)?, stays(second)?]);
        let sides = |points: &[crate::contact::pairs::Point]| -> Vec<[usize; 2]> {
            points.iter().map(|p| [p.first, p.second]).collect()
        };
        let points = in_order(&sides(&self.points), &sides(&before.points), pair);
        let surfaces = |of: &Self| -> Vec<_> { of.surfaces.iter().map(|s| s.parts()).collect() };
        let blocks = |of: &Self| -> Vec<_> { of.blocks.iter().map(|b| b.parts).collect() };
        let named = |name: &str| {
            let place = self
                .world
                .bodies
                .iter()
                .position(|body| body.name == *name)?;
            stays(self.tools + place)
        };
        let mut is_taken = vec![false; before.world.joints.len()];
        let joints = self.world.joints.iter().map(|joint| {
            named(&joint.body)?;
            if let Some(against) = &joint.against {
                named(against)?;
            }
            let mut olds = before.world.joints.iter().enumerate();
            let (old, _) =
                olds.find(|(old, was)| !is_taken[*old] && is_same_bearing(joint, was))?;
            is_taken[old] = true;
            Some(old)
        });
        let bodies = parts[self.tools..].iter();
        let bodies = bodies.map(|was| was.map(|was| was - before.tools));
        Succession {
            bodies: Origins::new(bodies.collect()),
            joints: Origins::new(joints.collect()),
            points: Origins::new(points),
            surfaces: in_order(&surfaces(self), &surfaces(before), pair),
            blocks: in_order(&blocks(self), &blocks(before), pair),
            parts,
        }
    }
}

/// Returns whether two shapes are equal. A shared mesh is not compared with itself.
fn is_same_shape(one: &Shape, other: &Shape) -> bool {
    match (one, other) {
        (Shape::Mesh(one), Shape::Mesh(other)) => Arc::ptr_eq(one, other) || one == other,
        (Shape::Hull(one), Shape::Hull(other)) => Arc::ptr_eq(one, other) || one == other,
        _ => one == other,
    }
}

/// Maps each of `new` to the element of `old` with the same pair and the same rank among the elements of that pair.
fn in_order(
    new: &[[usize; 2]],
    old: &[[usize; 2]],
    pair: impl Fn([usize; 2]) -> Option<[usize; 2]>,
) -> Vec<Option<usize>> {
    let mut left: HashMap<[usize; 2], VecDeque<usize>> = HashMap::new();
    for (number, sides) in old.iter().enumerate() {
        left.entry(*sides).or_default().push_back(number);
    }
    let each = new.iter();
    each.map(|sides| left.get_mut(&pair(*sides)?)?.pop_front())
        .collect()
}

/// Returns whether a joint has the same geometry as before; its springs may differ.
fn is_same_bearing(joint: &Joint, before: &Joint) -> bool {
    let Joint {
        body,
        against,
        kind,
        point,
        axis,
        law,
    } = joint;
    *body == before.body
        && *against == before.against
        && *kind == before.kind
        && *point == before.point
        && *axis == before.axis
        && law.span == before.law.span
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_keep_their_rank_in_a_pair_and_others_are_gone() {
        let old = [[0, 1], [0, 2], [0, 1], [1, 2], [0, 1]];
        let new = [[0, 1], [1, 2], [0, 1], [2, 2], [1, 2]];
        let from = Origins::new(in_order(&new, &old, Some));
        assert_eq!(from.each, [Some(0), Some(3), Some(2), None, None]);
        assert_eq!(from.gone(old.len()).collect::<Vec<_>>(), [1, 4]);
    }
}
