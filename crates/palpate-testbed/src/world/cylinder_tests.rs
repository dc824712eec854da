//! Stored energy of a cylinder in contact with a flat-faced solid or another cylinder, in random poses.

#![allow(clippy::print_stdout)] // what was measured

use super::between::Flat;
use super::contact::{Placed, Touch};
use super::cylinder::{Cylinder, OnCylinder, Plane};
use super::rod::Faces;
use super::turning::turned_by;
use super::vector::{Rotation, Vec3};
use super::wrapping::Wrapped;
use crate::random::SplitMix64;

const RADIUS: f64 = 0.02;
const HALF_LENGTH: f64 = 0.03;

struct Solid {
    name: &'static str,
    cylinder: Cylinder,
    /// None of another cylinder.
    faces: Option<Faces>,
}

fn solids() -> Vec<Solid> {
    let corners = |half: [f64; 3]| -> Vec<[f64; 3]> {
        let sign = |number: usize, i: usize| if number >> i & 1 == 1 { 1.0 } else { -1.0 };
        (0..8)
            .map(|number| std::array::from_fn(|i| sign(number, i) * half[i]))
            .collect()
    };
    let stone = vec![
        [0.025, 0.0, -0.005],
        [-0.01, 0.022, -0.01],
        [-0.012, -0.02, -0.006],
        [0.0, 0.003, 0.024],
        [0.01, 0.02, 0.012],
        [0.004, -0.018, 0.015],
    ];
    let prism = (0..7).flat_map(|k| {
        let (sine, cosine) = (std::f64::consts::TAU * f64::from(k) / 7.0).sin_cos();
        [-0.01, 0.01].map(|z| [0.03 * cosine, 0.03 * sine, z])
    });
    let all = [
        ("a box", corners([0.015, 0.025, 0.02])),
        ("a plate", corners([0.05, 0.06, 0.01])),
        ("a stone", stone),
        ("a prism", prism.collect()),
    ];
    let each = all.into_iter().map(|(name, points)| {
        let points: Vec<Vec3> = points.into_iter().map(Vec3).collect();
        let wrapped = Wrapped::around(&points, 64).unwrap();
        Solid {
            name,
            cylinder: Cylinder::new(true, [RADIUS, HALF_LENGTH], Flat::of(&wrapped)),
            faces: Some(Faces::of(&wrapped)),
        }
    });
    let two = [
        ("a wider can", [RADIUS, HALF_LENGTH], [0.025, 0.04]),
        ("a rod", [RADIUS, HALF_LENGTH], [0.008, 0.05]),
        ("a disc", [0.03, 0.004], [0.02, 0.006]),
        ("a plate and a rod", [0.05, 0.002], [0.004, 0.04]),
    ];
    let two = two.map(|(name, one, other)| Solid {
        name,
        cylinder: Cylinder::on_another(true, one, other),
        faces: None,
    });
    each.chain(two).collect()
}

type Pose = (Vec3, [f64; 4]);

fn placed((position, orientation): Pose) -> Placed {
    Placed {
        position,
        rotation: Rotation::of_quaternion(orientation),
        velocity: Vec3::ZERO,
        turning: Vec3::ZERO,
    }
}

/// Moved by a part of a way, in the six directions that there are.
fn moved((position, orientation): Pose, direction: usize, by: f64) -> Pose {
    let mut unit = Vec3::ZERO;
    unit.0[direction % 3] = by;
    if direction < 3 {
        (position + unit, orientation)
    } else {
        (position, turned_by(unit, orientation))
    }
}

fn touches(cylinder: &Cylinder, at: OnCylinder, two: [&Placed; 2]) -> Vec<Touch> {
    let mut found = vec![Touch::none(); cylinder.contacts()];
    cylinder.touch(0, at, two, &mut found);
    found
}

/// Returns the contact state, and the energy stored with a stiffness of 1 N/m.
fn energy(cylinder: &Cylinder, one: Pose, other: Pose) -> (OnCylinder, f64) {
    let (one, other) = (placed(one), placed(other));
    let at = cylinder.wanted(None, [&one, &other], 0.0);
    let touches = touches(cylinder, at, [&one, &other]);
    let squares = touches
        .iter()
        .map(|touch| touch.penetration.max(0.0).powi(2));
    let energy = 0.5 * squares.sum::<f64>() / cylinder.share() as f64;
    (at, energy)
}

struct Chance(SplitMix64);

impl Chance {
    fn new(seed: u64) -> Self {
        Self(SplitMix64::new(seed))
    }

    fn vector(&mut self) -> Vec3 {
        Vec3(std::array::from_fn(|_| 2.0 * self.0.unit() - 1.0))
    }

    fn orientation(&mut self) -> [f64; 4] {
        let vector = self.vector() * 3.0;
        turned_by(vector, [1.0, 0.0, 0.0, 0.0])
    }

    /// A cylinder and a solid at the origin that overlap by less than 1 mm or so, from a direction by chance.
    fn poses(&mut self, cylinder: &Cylinder) -> [Pose; 2] {
        let other = (self.vector() * 0.01, self.orientation());
        let orientation = self.orientation();
        let from = self.vector().direction().unwrap();
        let aside = self.vector() * 0.02;
        let at = |way: f64| (other.0 + aside + from * way, orientation);
        let (mut low, mut high) = (-0.2, 0.2);
        while energy(cylinder, at(low), other).1 == 0.0 && low < 0.0 {
            low += 0.005;
        }
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if energy(cylinder, at(middle), other).1 > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        let deep = 2e-6 + 1e-3 * self.0.unit();
        [at(high - deep), other]
    }
}

/// Force and torque about its centre are the fall of the energy, across planes of every kind.
#[test]
fn the_force_of_a_cylinder_is_the_fall_of_its_energy() {
    let mut chance = Chance::new(11);
    let mut worst = 0.0_f64;
    let mut kinds = [0; 7];
    for Solid { name, cylinder, .. } in solids() {
        for case in 0..150 {
            let [one, other] = chance.poses(&cylinder);
            let (at, _) = energy(&cylinder, one, other);
            let two = [placed(one), placed(other)];
            let mut wrench = [Vec3::ZERO; 2];
            for touch in touches(&cylinder, at, [&two[0], &two[1]]) {
                let size = touch.penetration.max(0.0) / cylinder.share() as f64;
                let force = touch.normal * size;
                wrench[0] += force;
                wrench[1] += (touch.point - one.0).cross(force);
            }
            for direction in 0..6 {
                let step = if direction < 3 { 2e-7 } else { 1e-5 };
                let along = |by: f64| energy(&cylinder, moved(one, direction, by * step), other);
                let ways = [-2.0, -1.0, 1.0, 2.0].map(along);
                if ways.iter().any(|(way, _)| !way.is_same(at)) {
                    continue;
                }
                let [a, b, c, d] = ways.map(|(_, energy)| energy);
                let slope = (8.0 * (c - b) - (d - a)) / (12.0 * step);
                let found = wrench[direction / 3].0[direction % 3];
                let scale = if direction < 3 { 1.0 } else { RADIUS };
                let off = (slope + found).abs() / (scale * wrench[0].norm().max(1e-5));
                worst = worst.max(off);
                assert!(
                    off < 1e-5,
                    "{name} {case} {direction} {at:?}: {slope} {found}"
                );
            }
            kinds[match at.plane {
                Plane::Face(_) => 0,
                Plane::End(..) => 1,
                Plane::Side(_) => 2,
                Plane::Edge(..) => 3,
                Plane::Around(_) => 4,
                Plane::SideAtRim(..) => 5,
                Plane::Rims(..) => 6,
            }] += 1;
        }
    }
    println!(
        "the fall to {worst:.1e}; faces, ends, sides, edges, around, sides at rims, rims {kinds:?}"
    );
    assert!(kinds.iter().all(|count| *count > 15), "{kinds:?}");
}

/// Depths, normals and points change at the computed rates.
#[test]
fn the_rates_of_a_cylinder_are_those_of_its_motion() {
    let mut chance = Chance::new(12);
    let mut worst = [0.0_f64; 3];
    for Solid { name, cylinder, .. } in solids() {
        for case in 0..100 {
            let poses = chance.poses(&cylinder);
            let rates = [0, 1].map(|_| [chance.vector() * 0.3, chance.vector() * 5.0]);
            let after = |time: f64| {
                [0, 1].map(|side| {
                    let ((position, orientation), [velocity, turning]) = (poses[side], rates[side]);
                    Placed {
                        velocity,
                        turning,
                        ..placed((
                            position + velocity * time,
                            turned_by(turning * time, orientation),
                        ))
                    }
                })
            };
            let step = 1e-7;
            let now = after(0.0);
            let at = cylinder.wanted(None, [&now[0], &now[1]], 0.0);
            let of = |time: f64| {
                let two = after(time);
                touches(&cylinder, at, [&two[0], &two[1]])
            };
            let (here, before, later) = (of(0.0), of(-step), of(step));
            if here.iter().any(|one| one.penetration.abs() < 1e-6) {
                continue; // one more point may begin to count
            }
            for ((one, before), later) in here.iter().zip(&before).zip(&later) {
                if one.penetration <= 0.0 {
                    continue;
                }
                let over = 0.5 / step;
                let normal = (later.normal - before.normal) * over;
                let growth = (later.penetration - before.penetration) * over;
                let point = (later.point - before.point) * over;
                let off = [
                    (normal - one.normal_rate).norm() / 5.0,
                    (growth - one.growth).abs(),
                    (point - one.point_velocity()).norm(),
                ];
                // If the plane has turned fast, the steps are long.
                let fast = 1.0 + normal.norm();
                for (worst, off) in worst.iter_mut().zip(off) {
                    *worst = worst.max(off / fast);
                }
                assert!(
                    off.iter().all(|off| *off < 1e-5 * fast),
                    "{name} {case} {at:?}: {off:?} {normal:?} {:?}",
                    one.normal_rate
                );
            }
        }
    }
    println!("rates to {worst:?}");
}

/// The place of a cylinder that is nearest to another one.
fn nearest_of([radius, half_length]: [f64; 2], placed: &Placed, at: Vec3) -> Vec3 {
    let own = placed.rotation.back(at - placed.position).0;
    let away = own[0].hypot(own[1]);
    let by = if away > radius { radius / away } else { 1.0 };
    let height = own[2].clamp(-half_length, half_length);
    placed.position
        + placed
            .rotation
            .out(Vec3([own[0] * by, own[1] * by, height]))
}

/// How far a cylinder reaches along a direction, from its centre.
fn reach_of([radius, half_length]: [f64; 2], placed: &Placed, along: Vec3) -> f64 {
    let along = along.dot(placed.rotation.out(Vec3([0.0, 0.0, 1.0])));
    half_length * along.abs() + radius * (1.0 - along * along).max(0.0).sqrt()
}

/// Whether two solids are apart, by going from each to the nearest place of the other one by turns: until there is no
/// way left, or a plane across the way has one solid on each side.
fn are_apart(solid: &Solid, one: Pose, other: Pose) -> bool {
    let (round, base) = (placed(one), placed(other));
    let size = [solid.cylinder.radius, solid.cylinder.half_length];
    let mut at = base.position;
    for _ in 0..400_000 {
        let on_round = nearest_of(size, &round, at);
        at = match (&solid.faces, solid.cylinder.other) {
            (Some(faces), _) => {
                let own = base.rotation.back(on_round - base.position);
                let (above, normal) = faces.nearest(own);
                on_round - base.rotation.out(normal) * above.max(0.0)
            }
            (None, size) => nearest_of(size.unwrap(), &base, on_round),
        };
        let way = on_round - at;
        if way.norm() < 1e-7 {
            return false;
        }
        let out = way.direction().unwrap();
        let highest = match solid.cylinder.other {
            Some(size) => reach_of(size, &base, out),
            None => {
                let corners = solid.cylinder.flat.corners.iter();
                let heights = corners.map(|corner| out.dot(base.rotation.out(*corner)));
                heights.fold(f64::NEG_INFINITY, f64::max)
            }
        };
        let lowest = out.dot(round.position - base.position) - reach_of(size, &round, out);
        if lowest > highest {
            return true;
        }
    }
    let way = nearest_of(size, &round, at) - at;
    panic!("{}: neither apart nor not, {:e} m", solid.name, way.norm());
}

/// They push where they overlap, and not where they are apart.
#[test]
fn a_cylinder_pushes_if_and_only_if_it_overlaps() {
    let mut chance = Chance::new(13);
    for solid in solids() {
        for case in 0..50 {
            let [one, other] = chance.poses(&solid.cylinder);
            let from = chance.vector().direction().unwrap();
            let at = |way: f64| (one.0 + from * way, one.1);
            let pushes = |way: f64| energy(&solid.cylinder, at(way), other).1 > 0.0;
            // Out to where they come apart.
            let (mut low, mut high) = (0.0, 0.2);
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                if pushes(middle) {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            for off in [-5e-5, 5e-5] {
                assert_eq!(
                    pushes(high + off),
                    !are_apart(&solid, at(high + off), other),
                    "{} {case}: {off}",
                    solid.name
                );
            }
        }
    }
}

/// Along a way by chance, through the surfaces and over faces, edges and rims, the energy has no jump: its change over
/// a step is what the forces at both ends have done, or falls short of it where another plane takes over.
#[test]
fn the_energy_of_a_cylinder_has_no_jump() {
    let mut chance = Chance::new(14);
    let (mut worst, mut planes) = (0.0_f64, 0);
    for Solid { name, cylinder, .. } in solids() {
        for case in 0..30 {
            let [one, other] = chance.poses(&cylinder);
            let (way, turn) = (chance.vector() * 0.01, chance.vector());
            let at = |part: f64| (one.0 + way * part, turned_by(turn * part, one.1));
            let mut last: Option<(OnCylinder, f64)> = None;
            for number in 0..1000 {
                let (way, energy) = energy(&cylinder, at(f64::from(number) * 1e-3 - 0.5), other);
                if let Some((before, was)) = last {
                    planes += usize::from(!way.is_same(before));
                    // At a depth of p at most, and at less than 0.1 m/s of it.
                    let depth = (2.0 * energy.max(was)).sqrt();
                    let off = (energy - was).abs() / (depth * 1e-4 + 1e-9);
                    worst = worst.max(off);
                    assert!(
                        off < 2.0,
                        "{name} {case} {number}: {was} {energy} {before:?} {way:?}"
                    );
                }
                last = Some((way, energy));
            }
        }
    }
    println!("steps of {worst:.2} of those that are allowed, over {planes} planes");
    assert!(planes > 100, "{planes}");
}
