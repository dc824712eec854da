mod of_cylinders;
mod of_hulls;
mod of_poses;
mod of_rods;

use std::sync::Arc;

use super::rods::Other;
use super::*;
use crate::ContactLaw;
use crate::geometry::hull::Corners;
use crate::geometry::rigid::Rotation;
use crate::geometry::solid::Solid;

const HALF: [[f64; 3]; 2] = [[0.5, 0.3, 0.4], [0.35, 0.6, 0.2]];

/// Reproducible numbers from -1 to 1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 11) as f64 / f64::from(1_u32 << 26) / f64::from(1_u32 << 26) - 1.0
    }

    fn vector(&mut self) -> Vector3 {
        Vector3::from_fn(|_, _| self.next())
    }
}

fn rigid(position: Vector3, turned: Vector3) -> Rigid {
    Rigid {
        position,
        orientation: Rotation::from_scaled_axis(turned),
        velocity: Vector3::zeros(),
        spin: Vector3::zeros(),
    }
}

fn placed(first: &Rigid, second: &Rigid) -> Placed {
    Placed::new([first, second], HALF.map(Vector3::from))
}

fn moved(rigid: &Rigid, way: Vector3, turn: Vector3) -> Rigid {
    Rigid {
        position: rigid.position + way,
        orientation: Rotation::from_scaled_axis(turn) * rigid.orientation,
        ..*rigid
    }
}

/// A pair of solids at given poses, and the number of points that share its law.
trait Pair {
    fn placed(&self, first: &Rigid, second: &Rigid) -> impl Between;
    fn share(&self) -> usize;
    /// Returns the number of points: one per corner of either solid, or per end.
    fn points(&self) -> usize;
}

struct Boxes;

impl Pair for Boxes {
    fn placed(&self, first: &Rigid, second: &Rigid) -> impl Between {
        placed(first, second)
    }

    fn share(&self) -> usize {
        boxes::ON_A_FACE
    }

    fn points(&self) -> usize {
        8
    }
}

/// Asserts that the forces at the points (K p over the number that share the law, along the normal) are the negative
/// gradient of the energy for any motion of either solid. Tries random poses, and counts in `seen` those with an
/// overlap below `most`: by faces of the first, by faces of the second, and by edges.
fn assert_gradient(
    pair: &impl Pair,
    numbers: &mut Numbers,
    tries: usize,
    most: f64,
    seen: &mut [usize; 3],
) {
    let law = PointLaw::share(&ContactLaw::spring(1.0), pair.share() as f64);
    for _ in 0..tries {
        let first = rigid(numbers.vector() * 0.1, numbers.vector() * 3.0);
        let second = rigid(numbers.vector() * 1.2, numbers.vector() * 3.0);
        let here = pair.placed(&first, &second);
        let (plane, depth) = here.least(None);
        if !(0.0..most).contains(&depth) {
            continue;
        }
        let energy = |first: &Rigid, second: &Rigid| {
            let (at, depth) = pair.placed(first, second).least(Some(plane));
            (at == plane).then_some(0.5 * depth * depth)
        };
        let normal = here.normal(plane);
        let (way, turn) = (numbers.vector(), numbers.vector());
        let mut powers = [0.0; 2];
        let mut points = vec![Found::none(); pair.points()];
        here.points(plane, &mut points);
        for found in points.iter().filter(|found| found.penetration > 0.0) {
            let force = normal * law.normal_force(found.penetration, 0.0);
            for (power, (rigid, sign)) in powers.iter_mut().zip([(&first, 1.0), (&second, -1.0)]) {
                let velocity = way + turn.cross(&(found.place - rigid.position));
                *power += sign * force.dot(&velocity);
            }
        }
        let h = 1e-6;
        let [of_first, of_second] = [-h, h].map(|h| {
            let by = |rigid| moved(rigid, way * h, turn * h);
            (energy(&by(&first), &second), energy(&first, &by(&second)))
        });
        let changes = [of_second.0.zip(of_first.0), of_second.1.zip(of_first.1)];
        for (change, power) in changes.into_iter().zip(powers) {
            // Skip if another plane may be within an ulp.
            let Some((up, down)) = change else { continue };
            let slope = (up - down) / (2.0 * h);
            assert!((slope + power).abs() < 1e-7, "{plane:?} {slope} {power}");
        }
        seen[match plane {
            Plane::Face { of, .. } => of,
            Plane::Edges(_) => 2,
        }] += 1;
    }
}

/// Returns the number of plane switches on straight paths of one solid through the other. No corner moves faster than
/// the solid, so the depth changes by at most its displacement times `most_share`, the root of the corners per share.
/// Overlaps above `within` are not checked.
fn changes_without_a_jump(
    pair: &impl Pair,
    numbers: &mut Numbers,
    ways: usize,
    most_share: f64,
    within: f64,
) -> u32 {
    let mut changes = 0;
    for _ in 0..ways {
        let (from, to) = (numbers.vector(), numbers.vector());
        let (turned, turn) = (numbers.vector() * 3.0, numbers.vector());
        let steps = 2000;
        let h = 1.0 / f64::from(steps);
        let first = rigid(Vector3::zeros(), Vector3::zeros());
        let mut before: Option<(Plane, f64)> = None;
        for step in 0..steps {
            let along = h * f64::from(step);
            let second = rigid(from + (to - from) * along, turned);
            let second = moved(&second, Vector3::zeros(), turn * along);
            let here = pair.placed(&first, &second);
            let (plane, depth) = here.least(before.map(|(plane, _)| plane));
            if let Some((old, was)) = before
                && was < within
            {
                let most = most_share * ((to - from).norm() + turn.norm()) * h;
                assert!(
                    (depth.max(0.0) - was.max(0.0)).abs() < most,
                    "{old:?} {plane:?} {was} {depth}"
                );
                changes += u32::from(old != plane && depth > 0.0);
            }
            before = Some((plane, depth));
        }
    }
    changes
}

#[test]
fn force_and_torque_are_the_gradient_of_the_energy() {
    let mut seen = [0; 3];
    assert_gradient(&Boxes, &mut Numbers(7), 40_000, 0.08, &mut seen);
    assert!(seen.iter().all(|&seen| seen > 100), "{seen:?}");
}

#[test]
fn the_energy_has_no_jump() {
    let changes = changes_without_a_jump(&Boxes, &mut Numbers(3), 200, 2.0, f64::INFINITY);
    assert!(changes > 100, "{changes}");
}

/// Separated boxes have no energy, and boxes with a common point have some.
#[test]
fn boxes_push_if_and_only_if_they_overlap() {
    let mut numbers = Numbers(11);
    let (mut apart, mut together) = (0, 0);
    for _ in 0..2000 {
        let first = rigid(Vector3::zeros(), numbers.vector());
        let second = rigid(numbers.vector() * 1.4, numbers.vector() * 3.0);
        let here = placed(&first, &second);
        let (plane, depth) = here.least(None);
        if depth < 0.0 {
            // The plane separates all corners of one box from all of the other.
            let normal = here.normal(plane);
            let ends = |of: usize| (0..8).map(move |number| (of, number));
            let along = |(of, number): (usize, usize)| {
                normal.dot(&(here.centres[of] + here.corner(of, number)))
            };
            let least = ends(0).map(along).fold(f64::INFINITY, f64::min);
            let most = ends(1).map(along).fold(f64::NEG_INFINITY, f64::max);
            assert!(least > most, "{plane:?} {least} {most}");
            apart += 1;
        } else {
            together += 1;
        }
        // Alternating projection between the boxes converges to a common point, if there is one.
        let into = |of: usize, rigid: &Rigid, place: Vector3| {
            let own = rigid.orientation.inverse() * (place - rigid.position);
            let half = here.half[of];
            rigid.position + rigid.orientation * own.zip_map(&half, |x, half| x.clamp(-half, half))
        };
        let mut place = second.position;
        let mut way = f64::INFINITY;
        for _ in 0..400 {
            let one = into(0, &first, place);
            place = into(1, &second, one);
            way = (place - one).norm();
        }
        let common = way < 1e-9;
        // Convergence is slow for small overlaps.
        assert!(way < 1e-5 || depth < 0.01, "{plane:?} {depth} {way}");
        assert!(!common || depth > 0.0, "{plane:?} {depth}");
    }
    assert!(apart > 200 && together > 200, "{apart} {together}");
}
