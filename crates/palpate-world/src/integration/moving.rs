//! A world in motion: poses, contact states, and sums since the interval began.

use crate::contact::broad_phase::{List, MARGIN};
use crate::contact::convex_pairs::Blocks;
use crate::contact::islands::Kind;
use crate::contact::nearby::{NEARER, Nearby, approached};
use crate::contact::pairs::Point;
use crate::contact::point::{Met, Past, Touch};
use crate::dynamics::joint_springs::Link;
use crate::dynamics::linkage::Carried;
use crate::dynamics::moving_body::{Part, TIME_TO_REST, Twist};
use crate::dynamics::potentials::Potential;
use crate::geometry::mesh::Surface;
use crate::geometry::rigid::Vector3;
use crate::geometry::solid::{Nearest, Solid};
use crate::integration::held_tools::HeldTools;
use crate::integration::interval::SubStepped;
use crate::integration::yielding::ForceLimit;

/// Scratch buffers of an interval.
#[derive(Clone, Debug)]
pub(crate) struct Room {
    /// World at the start of a sub-step.
    pub before: Moving,
    /// World at the start of the interval.
    pub start: Moving,
}

/// A world in motion.
#[derive(Clone, Debug)]
pub(crate) struct Moving {
    /// Tools, then bodies.
    pub parts: Vec<Part>,
    /// Number of tools.
    pub tools: usize,
    pub touches: Vec<Touch>,
    /// Active contact points. Inactive points do not touch.
    pub nearby: Nearby,
    /// Meshes in contact with spheres.
    pub surfaces: Vec<Surface>,
    /// Pairs of boxes, hulls and capsules.
    pub blocks: Vec<Blocks>,
    /// Springs of the joints.
    pub links: Vec<Link>,
    /// Force fields.
    pub fields: Vec<Potential>,
    /// Linkage motion of each tool's proxy with a position-dependent mass; empty if no tool has one.
    pub carried: Vec<Option<Carried>>,
    /// Whether sub-steps sum the work of each tool, body and contact.
    pub keeps_books: bool,
    /// Whether contact dampers add the prediction error of the last sub-step to the velocity that they expect.
    pub expects_the_missed: bool,
    /// Tools that each contact holds at its own place; empty for other methods.
    pub held: HeldTools,
    /// Force limits of the tools; empty if the motion has none.
    pub limits: Vec<ForceLimit>,
    /// Sums of the bounds of squared angular frequency `[1/s^2]` and damping rate `[1/s]` at each part (scratch buffer).
    pub rates: Vec<(f64, f64)>,
    /// Points that touch or may touch within an interval (scratch buffer).
    pub within_reach: List,
    /// Time since the interval began `[s]`.
    pub elapsed: f64,
}

impl Moving {
    /// Copies the state of another motion of the same world, without allocation.
    pub fn copy_from(&mut self, other: &Self) {
        self.parts.copy_from_slice(&other.parts);
        self.touches.copy_from_slice(&other.touches);
        self.nearby.copy_from(&other.nearby);
        for (surface, other) in self.surfaces.iter_mut().zip(&other.surfaces) {
            surface.copy_from(other);
        }
        for (blocks, other) in self.blocks.iter_mut().zip(&other.blocks) {
            blocks.copy_from(other);
        }
        self.links.copy_from_slice(&other.links);
        self.fields.copy_from_slice(&other.fields);
    }

    /// Copies what an interval changes in the islands that are awake, without allocation. Both have the same active
    /// points.
    pub fn copy_awake_from(&mut self, other: &Self) {
        for &number in self.nearby.parts() {
            self.parts[number] = other.parts[number];
        }
        for &number in self.nearby.numbers() {
            self.touches[number] = other.touches[number];
        }
        self.copy_near_from(other);
        for (limit, other) in self.limits.iter_mut().zip(&other.limits) {
            limit.has_acted = other.has_acted;
        }
    }

    /// Copies the state of another motion of the same world, whose inactive points are apart in both, without
    /// allocation.
    pub fn continue_from(&mut self, other: &Self, points: &[Point]) {
        // What rests in both is the same.
        let mut touches = std::mem::take(&mut self.touches);
        let is_settled =
            |number: usize| self.is_settled(&points[number]) && other.is_settled(&points[number]);
        for &number in self.nearby.recent() {
            if !is_settled(number) {
                touches[number] = Touch::apart();
            }
        }
        for &number in other.nearby.recent() {
            if !is_settled(number) {
                touches[number] = other.touches[number];
            }
        }
        self.touches = touches;
        for (part, other) in self.parts.iter_mut().zip(&other.parts) {
            if !(part.is_settled && other.is_settled) {
                *part = *other;
            }
        }
        self.nearby.copy_from(&other.nearby);
        for (surface, other) in self.surfaces.iter_mut().zip(&other.surfaces) {
            surface.copy_from(other);
        }
        for &number in other.nearby.islands.with_resting(Kind::Blocks) {
            self.blocks[number].copy_from(&other.blocks[number]);
        }
        self.links.copy_from_slice(&other.links);
        self.fields.copy_from_slice(&other.fields);
    }

    /// Returns whether both parts of a point were at rest when the interval began, and still are.
    pub fn is_settled(&self, point: &Point) -> bool {
        let [first, second] = [point.first, point.second].map(|part| &self.parts[part]);
        (first.is_settled || first.is_fixed) && (second.is_settled || second.is_fixed)
    }

    /// Ends a tick.
    pub fn end_tick(&mut self) {
        let touches = &mut self.touches;
        self.nearby
            .end_tick(|number| touches[number] = Touch::apart());
    }

    pub fn is_finite(&self) -> bool {
        let mut sum = 0.0;
        for Part { rigid, .. } in &self.parts {
            sum += rigid.position.sum() + rigid.velocity.sum() + rigid.spin.sum();
            sum += rigid.orientation.coords.sum();
        }
        for &number in self.nearby.recent() {
            let touch = &self.touches[number];
            sum += touch.bristle.sum() + touch.force.sum() + touch.past.work;
        }
        for field in &self.fields {
            sum += field.force.sum() + field.past.work;
        }
        sum.is_finite()
    }

    /// Begins an interval with zero sums.
    pub fn begin(&mut self) {
        for limit in &mut self.limits {
            limit.has_acted = false;
        }
        self.elapsed = 0.0;
        for &number in self.nearby.recent() {
            self.touches[number].past = Past::default();
        }
        for link in &mut self.links {
            link.begin();
        }
        for field in &mut self.fields {
            field.begin();
        }
        for part in &mut self.parts {
            part.begin();
        }
    }

    /// Begins an interval after an external change, with zero sums of inactive points also.
    pub fn begin_everywhere(&mut self) {
        for touch in &mut self.touches {
            touch.past = Past::default();
        }
        self.begin();
    }

    /// Resets the sides of spheres relative to meshes, and the faces of boxes relative to each other.
    pub fn forget_sides(&mut self) {
        for blocks in &mut self.blocks {
            blocks.forget();
        }
        for surface in &mut self.surfaces {
            surface.forget();
        }
    }

    /// Returns the maximum number of mesh triangles, mesh contacts or contact points omitted at a time since the last
    /// call.
    pub fn take_left_out(&mut self) -> u32 {
        let each = self.surfaces.iter_mut().map(Surface::take_left_out);
        each.fold(self.nearby.take_left_out(), u32::max)
    }

    /// Activates all touching points, after an external change.
    pub fn recollect(&mut self) {
        let touches = |number: usize| !self.touches[number].is_apart();
        self.nearby.recollect(touches);
    }

    /// Activates the points that touch or may touch within `h` `[s]`.
    pub fn gather(&mut self, points: &[Point], h: f64) {
        let touches = |number: usize| !self.touches[number].is_apart();
        let of = (self.tools, self.held.is_holding);
        self.nearby.gather(&self.parts, points, touches, of, h);
        for &number in self.nearby.fresh() {
            let blocks = &mut self.blocks[number];
            blocks.forget();
            let [first, second] = blocks.parts.map(|number| &self.parts[number].rigid);
            blocks.look(first, second, &mut self.touches, points);
        }
    }

    /// Wakes the bodies of the selected island. With a tool, their time to rest restarts.
    pub fn wake(&mut self, has_tool: bool) {
        for &number in self.nearby.parts() {
            let part = &mut self.parts[number];
            if part.rests || has_tool {
                part.wake();
            }
        }
    }

    /// Lets the bodies of the selected island rest, if they were all still for long enough, now for another `h` `[s]`.
    pub fn settle_down(&mut self, points: &[Point], h: f64) {
        self.find_supported(points);
        let radii = self.nearby.broad.pairs.radii();
        let mut parts = self.nearby.parts().iter();
        let are_still = parts.all(|&part| self.parts[part].is_still(radii[part]));
        let mut rest = are_still;
        for &number in self.nearby.parts() {
            let part = &mut self.parts[number];
            part.still_for = if are_still { part.still_for + h } else { 0.0 };
            rest &= part.still_for >= TIME_TO_REST;
        }
        if !rest {
            return;
        }
        for &number in self.nearby.parts() {
            self.parts[number].rest();
        }
        for &number in self.nearby.numbers() {
            self.touches[number].rest();
        }
        for &number in self.nearby.islands.all(Kind::Links) {
            self.links[number].rest();
        }
    }

    /// Returns whether a body of the selected island could reach a tool within `h` `[s]`, if it got all energy of the
    /// island.
    pub fn could_reach_a_tool(&self, points: &[Point], h: f64) -> bool {
        let parts = self.nearby.parts().iter();
        let parts = parts.map(|&number| (number, &self.parts[number]));
        let kinetic = parts.clone().map(|(_, part)| {
            let (velocity, pushed) = (&part.rigid.velocity, part.drive.acceleration * h);
            let worked = part.mobility.weighted(&pushed, &(velocity + pushed * 0.5));
            part.mobility.kinetic_energy(&part.rigid) + worked.abs()
        });
        let stored = self.nearby.numbers().iter();
        let stored = stored.map(|&number| self.stored(number, &points[number]));
        let links = self.nearby.islands.all(Kind::Links).iter();
        let links = links.map(|&number| self.links[number].stored);
        let energy = kinetic.chain(stored).chain(links).sum::<f64>();
        let radii = self.nearby.broad.pairs.radii();
        parts.clone().any(|(number, part)| {
            let speed = (2.0 * energy * part.mobility.linear.max()).sqrt();
            self.parts[..self.tools]
                .iter()
                .zip(radii)
                .any(|(tool, radius)| {
                    let apart = (part.rigid.position - tool.rigid.position).norm();
                    apart - radii[number] - radius <= (speed + tool.speed(*radius, h)) * h + MARGIN
                })
        })
    }

    /// Finds the bodies of the selected island that a contact or a joint supports.
    fn find_supported(&mut self, points: &[Point]) {
        for &number in self.nearby.parts() {
            self.parts[number].is_supported = false;
        }
        for &number in self.nearby.numbers() {
            if !self.touches[number].is_apart() {
                for side in [points[number].first, points[number].second] {
                    self.parts[side].is_supported = true;
                }
            }
        }
        for &number in self.nearby.islands.all(Kind::Links) {
            for side in self.links[number].sides() {
                self.parts[side].is_supported = true;
            }
        }
    }

    /// Exchanges the triangles that two motions have gathered around the spheres. Both passes of a tick visit the same
    /// regions of the meshes, so this motion, which begins, needs the triangles that the other gathered last.
    pub fn exchange_gathered(&mut self, other: &mut Self) {
        for (surface, other) in self.surfaces.iter_mut().zip(&mut other.surfaces) {
            surface.exchange_gathered(other);
        }
    }

    /// Returns the energy stored in the contact at a point `[J]`.
    pub fn stored(&self, number: usize, point: &Point) -> f64 {
        let touch = &self.touches[number];
        touch.stored(&point.law)
    }

    /// Resets the clearances of all points, because displacements are counted from the start of the interval.
    pub fn look_at_all(&mut self, points: &[Point]) {
        for &number in self.nearby.numbers() {
            self.touches[number].clear = 0.0;
        }
        for &number in self.nearby.blocks() {
            let blocks = &mut self.blocks[number];
            let sides = blocks.parts.map(|number| &self.parts[number]);
            blocks.update(sides, &mut self.touches, points);
        }
    }

    /// Re-evaluates the contacts after tools or bodies have been displaced.
    pub fn look(&mut self, points: &[Point]) {
        for part in self.parts.iter_mut().filter(|part| !part.rests) {
            part.settle();
        }
        self.gather(points, 0.0);
        self.look_at_all(points);
        self.meet::<true>(points, 0.0);
        self.measure(points);
    }

    /// Evaluates the contacts and their loads at the current positions, which were reached by moving for `half` a
    /// sub-step with the current velocities.
    pub(super) fn meet<const BOOKS: bool>(&mut self, points: &[Point], half: f64) {
        self.look_at_shapes(points);
        for &number in self.nearby.numbers() {
            let (touch, point) = (&mut self.touches[number], &points[number]);
            if self.held.is_holding && point.tool(self.tools).is_some() {
                let shapes = (&self.surfaces[..], &self.blocks[..]);
                self.held
                    .meet(number, point, touch, &mut self.parts, shapes, half);
                continue;
            }
            if let Solid::Mesh { surface, point, .. } = point.solid
                && touch.is_apart()
                && self.surfaces[surface].found(point).is_none()
            {
                continue;
            }
            if let Solid::Between { blocks, point, .. } = point.solid
                && touch.is_apart()
                && self.blocks[blocks].found(point).penetration <= 0.0
            {
                continue;
            }
            let (first, second) = (&self.parts[point.first], &self.parts[point.second]);
            if point.is_held {
                if !touch.is_apart() {
                    touch.relative =
                        relative(first, &first.twist, second, &second.twist, &touch.place);
                    for (side, force) in [(point.first, touch.force), (point.second, -touch.force)]
                    {
                        self.parts[side].load(&force, &touch.place);
                    }
                }
                continue;
            }
            let is_looked_up = matches!(point.solid, Solid::Mesh { .. } | Solid::Between { .. });
            let moved = if touch.is_apart() && !is_looked_up {
                approached(first, second, point)
            } else {
                0.0
            };
            if touch.is_apart() && moved < touch.clear {
                continue;
            }
            let met = overlap(point, [first, second], &self.surfaces, &self.blocks);
            if met.penetration > 0.0 {
                let Met { normal, place, .. } = met;
                let relative = relative(first, &first.twist, second, &second.twist, &place);
                let ahead = self::relative(first, &first.ahead, second, &second.ahead, &place);
                touch.press(point, &met, -normal.dot(&ahead));
                touch.rub::<BOOKS>(point, normal, relative * half, &ahead);
                touch.normal = normal;
                touch.place = place;
                touch.relative = relative;
                touch.force = touch.force_of(point);
                let (force, place) = (touch.force, touch.place);
                self.parts[point.first].load(&force, &place);
                self.parts[point.second].load(&-force, &place);
            } else if !touch.is_apart() {
                touch.part(point);
            } else if !is_looked_up {
                touch.clear = moved - NEARER * met.penetration;
            }
        }
        self.yield_to_limits(points);
        if self.held.is_holding {
            let numbers = self.nearby.numbers();
            self.held
                .release_pairs(numbers, points, &mut self.touches, &mut self.parts);
        }
        for &number in self.nearby.islands.all(Kind::Links) {
            self.links[number].meet(&mut self.parts);
        }
        self.meet_fields();
    }

    /// Resets the loads of all parts, and evaluates the meshes and the pairs of blocks at the current positions.
    #[inline]
    fn look_at_shapes(&mut self, points: &[Point]) {
        for &number in self.nearby.parts() {
            let part = &mut self.parts[number];
            part.force = Vector3::zeros();
            part.torque = Vector3::zeros();
        }
        if self.held.is_holding {
            self.look_at_held_shapes(points);
            return;
        }
        for &number in self.nearby.islands.all(Kind::Surfaces) {
            let surface = &mut self.surfaces[number];
            let [first, second] = surface.parts().map(|number| &self.parts[number].rigid);
            surface.look(first, second);
        }
        for &number in self.nearby.blocks() {
            let blocks = &mut self.blocks[number];
            let sides = blocks.parts.map(|number| &self.parts[number]);
            blocks.look_if_near(sides, &mut self.touches, points);
        }
    }

    /// Computes the power dissipated by contact damping at the current state.
    fn measure(&mut self, points: &[Point]) {
        for &number in self.nearby.numbers() {
            let (touch, point) = (&mut self.touches[number], &points[number]);
            if !touch.is_apart() {
                let (first, second) = (&self.parts[point.first], &self.parts[point.second]);
                let relative = touch.relative;
                touch.watch_damping::<true>(point, &relative, first, second);
            }
        }
        for &number in self.nearby.islands.all(Kind::Links) {
            self.links[number].watch_damping(&self.parts);
        }
    }
}

/// Returns the overlap of a point of the first part with the solid of the second.
#[inline(always)]
pub(super) fn overlap(
    point: &Point,
    [first, second]: [&Part; 2],
    surfaces: &[Surface],
    blocks: &[Blocks],
) -> Met {
    let of_sphere = |centre: Vector3, nearest: Nearest| {
        let penetration = point.radius - nearest.distance;
        let below = point.radius - 0.5 * penetration;
        Met {
            penetration,
            normal: nearest.normal,
            slope: nearest.slope,
            place: centre - nearest.normal * below,
        }
    };
    match point.solid {
        Solid::Mesh {
            surface,
            point: number,
            ..
        } => {
            let found = surfaces[surface].found(number);
            let nearest = found.map_or(Nearest::far(), |found| Nearest {
                normal: second.rigid.orientation * found.normal,
                ..Nearest::exact(found.distance, found.normal)
            });
            of_sphere(point.centre_of(&first.rigid), nearest)
        }
        Solid::Between {
            blocks: number,
            point,
            ..
        } => {
            let blocks = &blocks[number];
            let found = blocks.found(point);
            Met {
                penetration: found.penetration,
                normal: blocks.normal(),
                slope: 1.0,
                place: found.place,
            }
        }
        _ => {
            let centre = point.centre_of(&first.rigid);
            let solid = &point.solid;
            let nearest = solid.nearest_within(&second.rigid, &centre, point.radius);
            of_sphere(centre, nearest)
        }
    }
}

/// Returns the velocity of the first's material at `place` relative to the second's `[m/s]`.
#[inline]
pub(super) fn relative(
    first: &Part,
    of_first: &Twist,
    second: &Part,
    of_second: &Twist,
    place: &Vector3,
) -> Vector3 {
    let of_first = first.velocity_at(of_first, place);
    if second.is_fixed {
        of_first
    } else {
        of_first - second.velocity_at(of_second, place)
    }
}
