//! Integration over one interval: bounded work, with finer steps at changes of contact mode.

use crate::contact::convex_pairs::Blocks;
use crate::contact::islands::Kind;
use crate::contact::nearby::{Nearby, approach};
use crate::contact::pairs::Point;
use crate::dynamics::joint_springs::Link;
use crate::dynamics::moving_body::Part;
use crate::geometry::rigid::Vector3;
use crate::geometry::solid::Solid;
use crate::integration::moving::{Moving, Room};

/// Sub-step settings of an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SubSteps {
    /// Minimum number of sub-steps per interval.
    pub least: u32,
    /// Maximum number before refinement; four times as many if the integration would otherwise be unstable.
    pub most: u32,
    /// Target phase of the fastest contact per sub-step, if the maximum number allows it `[rad]`.
    pub phase: f64,
    /// Maximum number of shorter sub-steps that replace one in which a contact begins, ends, sticks, slides or
    /// crosses an edge to another face. The shortest is 1/2048 of the original and contains the change.
    pub finer: u32,
    /// Number of sub-steps per interval that can be refined with [`finer`](Self::finer) shorter ones each. If they
    /// need fewer, more can be refined.
    pub refined: u32,
}

impl Default for SubSteps {
    /// 16 to 64 sub-steps, 0.03 rad; up to 4 of them in 32 shorter ones. The maximum is 188 in total, or 380 if 64
    /// are too few for stability.
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

/// Ratio of the sub-steps of an island that hardly moves to those of others.
const COARSER: u32 = 8;
/// Largest phase per sub-step of such an island, within the stability limit `[rad]`. Its bodies move by nanometres in an
/// interval, of which such a sub-step misses a four-hundredth.
const MAX_PHASE_OF_STILL: f64 = 0.24;

impl SubSteps {
    /// Returns the settings for an island that has hardly moved in the last interval.
    fn of_still(self) -> Self {
        let coarse = self.phase * f64::from(COARSER);
        Self {
            least: (self.least / COARSER).max(1),
            phase: coarse.min(MAX_PHASE_OF_STILL).max(self.phase),
            ..self
        }
    }
}

/// Computing effort of the integration, and omitted work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Number of sub-steps of the island that needed the most, including replaced ones and those of repeated intervals.
    pub sub_steps: u32,
    /// Number of sub-steps that were replaced by shorter ones.
    pub refined: u32,
    /// Number of sub-steps with a change of contact mode or face that were not refined, because the budget of
    /// [`SubSteps::refined`] was used up.
    pub unrefined: u32,
    /// Whether the fastest contact, joint or field required more than [`SubSteps::most`]. With
    /// [`Fault::Overflow`](palpate_core::Fault::Overflow) it is the reason for rejecting the sample.
    pub too_fast: bool,
    /// Whether the integration would be unstable even with four times [`SubSteps::most`]. The sample is then
    /// rejected.
    pub unstable: bool,
    /// Maximum number of mesh triangles, mesh contacts and points of large shells omitted at a time for lack of capacity:
    /// the most distant or least deep ones.
    pub left_out: u32,
}

impl Effort {
    /// Adds the effort for another island in the same interval.
    fn beside(self, other: Self) -> Self {
        Self {
            sub_steps: self.sub_steps.max(other.sub_steps),
            ..self.and(other)
        }
    }

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

/// Factor on [`SubSteps::most`] for an interval that would otherwise be unstable.
pub(crate) const MAX_TIMES: u32 = 4;
/// Phase of the fastest contact per sub-step above which the integration counts as unstable `[rad]`: half of the
/// stability limit of Verlet's method, because the frequency is a bound over several contacts.
const MAX_PHASE: f64 = 1.0;
/// Maximum of the damping rate times the sub-step plus a quarter of the squared phase. A damper uses the velocity
/// expected at the end of the sub-step. Let w be the velocity and b the damper's push, both times the sub-step, s the
/// squared phase, and u the damping rate times the sub-step:
///
/// ```text
/// x' = x + w + b/2    b' = -s x' - u (w + b)    w' = w + (b + b')/2
/// ```
///
/// For s = 0 the factor r of w and b per sub-step satisfies r^2 - (1 - 3u/2) r - u/2 = 0, and r = -1 at u = 1. For
/// any s the motion is stable while u + s/4 < 1. (A damper with the velocity of half a sub-step earlier would be
/// stable up to u = 2.) The velocity at the end is w + b + (b' - b)/2, so the expected velocity w + b has the error m
/// = (b' - b)/2. If the damper adds the error of the last sub-step, the force error is of third order, and the motion
/// is stable while 2u + s/4 < 1.
const MAX_DAMPING: f64 = 0.9;

/// State that is advanced by sub-steps and restored when a sub-step is repeated.
pub(crate) trait SubStepped {
    /// A possible contact.
    type Pair;

    /// Copies the state that sub-steps change from `other`, which has the same interval and active pairs. It does not
    /// allocate.
    fn copy_near_from(&mut self, other: &Self);

    /// Performs one sub-step of `h` `[s]`.
    fn sub_step(&mut self, pairs: &[Self::Pair], h: f64);

    /// Returns whether a contact's mode differs from that in `other`, or a contact crossed an edge.
    fn changed_from(&self, other: &Self) -> bool;

    /// Sets whether contact dampers add the prediction error of the last sub-step to the velocity that they expect.
    fn expect_the_missed(&mut self, is_added: bool);

    /// Discards the prediction error: the next sub-step has another length, or a contact changed its mode.
    fn expect_anew(&mut self);
}

/// Bounds of the fastest modes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fastest {
    /// Angular frequency `[rad/s]`.
    pub frequency: f64,
    /// Damping rate `[1/s]`.
    pub damping: f64,
    /// Angular frequency at which a tool passes the detents of a field `[rad/s]`. It limits the error of a sub-step, but
    /// not its stability.
    pub passing: f64,
}

impl Fastest {
    /// Returns the number of sub-steps of an interval of `h` `[s]` that limits the phase `[rad]`.
    fn asks_for(self, h: f64, phase: f64) -> f64 {
        let frequency = self.frequency.max(self.passing);
        frequency.max(self.damping / DAMPING_PER_FREQUENCY) * h / phase
    }

    /// Returns whether sub-steps of `h` `[s]` are unstable.
    fn grows(self, h: f64) -> bool {
        let phase = self.frequency * h;
        phase > MAX_PHASE || self.damping * h + 0.25 * phase * phase > MAX_DAMPING
    }

    /// Returns whether a damper may add the prediction error of the last sub-step.
    fn may_expect(self, h: f64) -> bool {
        let phase = self.frequency * h;
        2.0 * self.damping * h + 0.25 * phase * phase < MAX_DAMPING
    }
}

/// Maximum number of times that an interval is repeated because a part moved further than the selection of pairs
/// assumed. The last one has all pairs.
const MAX_REPEATS: u32 = 2;

/// Integrates `moving` over `h` `[s]`, starting from evaluated contacts, each island with its own sub-steps. If a part
/// moves further than the selection of pairs assumed, the interval is repeated with more pairs. `room` is overwritten.
pub(crate) fn advance(
    moving: &mut Moving,
    room: &mut Room,
    points: &[Point],
    sub_steps: &SubSteps,
    reach: Reach,
    h: f64,
) -> Effort {
    let Room { before, start } = room;
    let (mut repeats, mut replaced) = (0, 0);
    moving.nearby.broad.assume_little();
    loop {
        moving.gather(points, h);
        let may_repeat = repeats < MAX_REPEATS && !moving.nearby.broad.has_all();
        if may_repeat {
            start.nearby.copy_numbers_from(&moving.nearby);
            start.copy_awake_from(moving);
        }
        let effort = advance_islands(moving, before, points, sub_steps, reach, h);
        let Nearby { broad, islands, .. } = &mut moving.nearby;
        if !may_repeat || !broad.was_outrun(&moving.parts, islands.all(Kind::Parts), h) {
            return Effort {
                sub_steps: replaced + effort.sub_steps,
                ..effort
            };
        }
        (repeats, replaced) = (repeats + 1, replaced + effort.sub_steps);
        if repeats == MAX_REPEATS {
            broad.assume_all();
        }
        moving.copy_awake_from(start);
    }
}

/// Integrates the islands that are awake, after the selection of pairs.
fn advance_islands(
    moving: &mut Moving,
    before: &mut Moving,
    points: &[Point],
    sub_steps: &SubSteps,
    reach: Reach,
    h: f64,
) -> Effort {
    moving.look_at_all(points);
    moving.begin_holding(points);
    before.nearby.copy_numbers_from(&moving.nearby);
    for &number in moving.nearby.numbers() {
        before.touches[number].past = moving.touches[number].past;
    }
    let mut effort = Effort::default();
    for island in 0..moving.nearby.islands.awake() {
        moving.nearby.islands.enter(island);
        before.nearby.islands.enter(island);
        let has_tool = moving
            .nearby
            .parts()
            .iter()
            .any(|&part| part < moving.tools);
        if !has_tool && reach == Reach::OfTools && !moving.could_reach_a_tool(points, h) {
            continue;
        }
        moving.elapsed = 0.0;
        moving.wake(has_tool);
        let fastest = fastest(moving, before, points, h);
        let is_still = |&part: &usize| moving.parts[part].still_for > 0.0;
        let sub_steps = if !has_tool && moving.nearby.parts().iter().all(is_still) {
            sub_steps.of_still()
        } else {
            *sub_steps
        };
        let passed = integrate(moving, before, points, fastest, &sub_steps, MAX_TIMES, h);
        if !has_tool && !passed.unstable {
            moving.settle_down(points, h);
        }
        effort = effort.beside(passed);
    }
    moving.nearby.islands.leave();
    effort.left_out = moving.take_left_out();
    effort
}

/// Returns whether the motion of an island that is awake would grow within `h` `[s]`, even with the most sub-steps.
/// `room` is overwritten.
pub(crate) fn would_grow(
    moving: &mut Moving,
    room: &mut Room,
    points: &[Point],
    sub_steps: &SubSteps,
    h: f64,
) -> bool {
    moving.nearby.broad.assume_little();
    moving.gather(points, h);
    let shortest = h / f64::from(sub_steps.most.saturating_mul(MAX_TIMES));
    let grows = (0..moving.nearby.islands.awake()).any(|island| {
        moving.nearby.islands.enter(island);
        fastest(moving, &mut room.before, points, h).grows(shortest)
    });
    moving.nearby.islands.leave();
    grows
}

/// Islands that an interval covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reach {
    All,
    /// Islands with a tool, and those whose energy could carry a body to one. The others stay where they are.
    OfTools,
}

/// Integrates `moving` over `h` `[s]`. The bounds `fastest` determine the number of sub-steps: up to
/// [`SubSteps::most`], or up to `times` that number if the integration would be unstable. If it would still be
/// unstable, nothing moves. `before` is overwritten.
pub(crate) fn integrate<M: SubStepped>(
    moving: &mut M,
    before: &mut M,
    pairs: &[M::Pair],
    fastest: Fastest,
    sub_steps: &SubSteps,
    times: u32,
    h: f64,
) -> Effort {
    let mut effort = Effort::default();
    let asked = fastest.asks_for(h, sub_steps.phase);
    let mut count = if asked <= f64::from(sub_steps.least) {
        sub_steps.least
    } else if asked < f64::from(sub_steps.most) {
        whole(asked.ceil())
    } else {
        effort.too_fast = asked > f64::from(sub_steps.most);
        sub_steps.most
    };
    if fastest.grows(h / f64::from(count)) {
        effort.too_fast = true;
        count = sub_steps.most.saturating_mul(times);
        effort.unstable = fastest.grows(h / f64::from(count));
    }
    // The sample is rejected, and the energy ledger excludes an unstable motion.
    if effort.unstable {
        return effort;
    }
    let step = h / f64::from(count);
    moving.expect_the_missed(fastest.may_expect(step));
    moving.expect_anew();
    let mut left = sub_steps.refined.saturating_mul(sub_steps.finer);
    for _ in 0..count {
        before.copy_near_from(moving);
        moving.sub_step(pairs, step);
        effort.sub_steps += 1;
        if !moving.changed_from(before) {
            continue;
        }
        if left < sub_steps.finer {
            effort.unrefined += 1;
            moving.expect_anew();
            continue;
        }
        effort.refined += 1;
        moving.copy_near_from(before);
        let pieces = refine(moving, before, pairs, sub_steps.finer, step);
        effort.sub_steps += pieces;
        left -= pieces;
    }
    effort
}

/// Ratio of a sub-step to the shortest piece, which contains a mode change: a power of two.
const SHORTEST: u32 = 2048;

/// Performs a sub-step of `step` `[s]` with a change of contact mode in at most `most` pieces, including rejected
/// ones. The piece with the change is halved down to the shortest length, so no longer piece contains a change.
/// Returns the number of pieces.
fn refine<M: SubStepped>(
    moving: &mut M,
    before: &mut M,
    pairs: &[M::Pair],
    most: u32,
    step: f64,
) -> u32 {
    let shortest = step / f64::from(SHORTEST);
    // Each halving rejects one piece and adds another.
    let halvings = most / 2;
    let (mut pieces, mut halved) = (0, 0);
    let (mut at, mut length) = (0, SHORTEST);
    // Whether it is still unknown if the change is in this piece or in its other half.
    let mut is_sought = halvings > 0;
    if is_sought {
        (length, halved) = (SHORTEST / 2, 1);
    }
    while at < SHORTEST {
        before.copy_near_from(moving);
        moving.expect_anew();
        moving.sub_step(pairs, shortest * f64::from(length));
        pieces += 1;
        let may_halve = length > 1 && halved < halvings;
        let changed = moving.changed_from(before);
        if changed && may_halve {
            moving.copy_near_from(before);
            (length, halved, is_sought) = (length / 2, halved + 1, true);
            continue;
        }
        at += length;
        if is_sought && !changed && may_halve {
            (length, halved) = (length / 2, halved + 1);
        } else {
            is_sought = false;
            length = 1 << at.trailing_zeros();
        }
    }
    moving.expect_anew();
    pieces
}

/// Converts a non-negative integral value.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "it lies between two numbers of that type"
)]
pub(crate) fn whole(count: f64) -> u32 {
    count as u32
}

/// Material damping rate `[1/s]` equivalent to a frequency of 1 rad/s.
const DAMPING_PER_FREQUENCY: f64 = 2.0;

/// Returns twice the distance by which two boxes may approach each other within `h` `[s]` `[m]`.
fn reach_of_blocks(first: &Part, second: &Part, blocks: &Blocks, h: f64) -> f64 {
    let [one, other] = blocks.reaches();
    approach(first, second, one, other, h)
}

/// Returns bounds of the angular frequency and damping rate among the fields and the contacts that touch or may touch within `h`
/// `[s]`. The bound over the two sides of a contact is the sum of stiffness or damping times mobility of all contacts
/// and fields there, plus the stiffest drive spring. The scratch buffers of `room` are overwritten.
fn fastest(moving: &Moving, room: &mut Moving, points: &[Point], h: f64) -> Fastest {
    let Moving {
        rates: sums,
        within_reach,
        ..
    } = room;
    let mut most_square: f64 = 0.0;
    let mut most_damping: f64 = 0.0;
    let links = moving.nearby.islands.all(Kind::Links).iter();
    let links = links.map(|&number| &moving.links[number]);
    within_reach.clear();
    for &number in moving.nearby.numbers() {
        if may_touch(moving, number, &points[number], h) {
            within_reach.push(number);
        }
    }
    let near = within_reach.all().iter().map(|&number| &points[number]);
    for side in near.clone().flat_map(|point| [point.first, point.second]) {
        sums[side] = (0.0, 0.0);
    }
    for side in links.clone().flat_map(Link::sides) {
        sums[side] = (0.0, 0.0);
    }
    let fields = moving.fields.iter();
    let fields = fields.filter(|field| moving.nearby.parts().contains(&field.tool));
    for field in fields.clone() {
        sums[field.tool] = (0.0, 0.0);
    }
    for field in fields.clone() {
        sums[field.tool].0 += field.square(&moving.parts[field.tool]);
    }
    for (side, square, rate) in links.clone().flat_map(|link| link.rates(&moving.parts)) {
        sums[side].0 += square;
        sums[side].1 += rate;
    }
    for link in links {
        let of_sides = link.sides().map(|side| sums[side]);
        let of_sides = of_sides.fold((0.0, 0.0), |sum, side| (sum.0 + side.0, sum.1 + side.1));
        most_square = most_square.max(of_sides.0);
        most_damping = most_damping.max(of_sides.1);
    }
    for point in near.clone() {
        for (lever, side) in [point.first, point.second].into_iter().enumerate() {
            let mobility = moving.parts[side].mobility.linear.max();
            let law = &point.law;
            let along = mobility + point.along[lever];
            let across = mobility + point.across[lever];
            let tangential = if law.friction > 0.0 {
                law.friction_stiffness * across
            } else {
                0.0
            };
            sums[side].0 += (law.stiffness * along).max(tangential);
            sums[side].1 += law.damping_rate(along, across);
        }
    }
    for point in near {
        let [first, second] = [point.first, point.second].map(|side| sums[side]);
        most_square = most_square.max(first.0 + second.0);
        most_damping = most_damping.max(first.1 + second.1);
    }
    let mut passing: f64 = 0.0;
    for field in fields {
        most_square = most_square.max(sums[field.tool].0);
        passing = passing.max(field.passing(&moving.parts[field.tool], h));
    }
    let of_drives = |part: &Part| {
        let turning = part.turning_drive.stiffness * part.mobility.angular.max();
        part.drive.spring_rate.max().max(turning)
    };
    let parts = moving.nearby.parts().iter();
    let most_drive = parts.map(|&part| of_drives(&moving.parts[part]));
    let most_drive = most_drive.fold(0.0, f64::max);
    Fastest {
        frequency: (most_square + most_drive).sqrt(),
        damping: most_damping,
        passing,
    }
}

/// Returns whether a contact touches or may touch within `h` `[s]`.
fn may_touch(moving: &Moving, number: usize, point: &Point, h: f64) -> bool {
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
    let relative: Vector3 =
        first.rigid.velocity + first.step.velocity - second.rigid.velocity - second.step.velocity;
    let pushed = (first.drive.acceleration - second.drive.acceleration).norm();
    let mut turns = (first.twist.turning + first.step.turning).norm() * point.lever;
    if point.second < moving.tools {
        let turning = (second.twist.turning + second.step.turning).norm();
        turns += turning * (centre - second.rigid.position).norm();
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
}

#[cfg(test)]
mod tests {
    /// Returns the growth of a contact's motion after 4000 sub-steps, by the equations at [`super::MAX_DAMPING`].
    /// `u` is the damping rate times the sub-step, `s` the squared phase.
    fn growth(u: f64, s: f64) -> f64 {
        let (mut x, mut w, mut b, mut missed) = (1.0_f64, 0.3_f64, -s, 0.0);
        for _ in 0..4000 {
            x += w + 0.5 * b;
            let expected = w + b;
            let after = -s * x - u * (expected + missed);
            w += 0.5 * (b + after);
            (missed, b) = (w - expected, after);
            if w.abs() > 1e6 {
                break;
            }
        }
        (s * x * x + w * w + b * b).sqrt()
    }

    #[test]
    fn a_damper_that_corrects_its_velocity_is_stable_up_to_its_bound_and_not_beyond() {
        for s in [0.01, 0.1, 0.4, 0.7, 1.0] {
            let at = |bound: f64| growth(0.5 * (bound - 0.25 * s), s);
            let (inside, beyond) = (at(0.97), at(1.03));
            assert!(inside < 1e-3 && beyond > 1e6, "{s}: {inside} {beyond}");
        }
    }
}
