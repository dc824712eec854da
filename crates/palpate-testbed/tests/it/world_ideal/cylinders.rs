//! Cylinders on half-spaces, boxes and hulls.

use std::sync::Arc;

use palpate_testbed::world::{
    ContactLaw, Hull, Member, Shape, Tool, Turning, TurningHand, WorldBody, WorldIdeal, WorldScene,
};

use super::{body, device, half_space, motion, pair, solve};
use crate::world_ideal::boxes::{drift, sums};

pub const RADIUS: f64 = 0.02;
pub const HALF_LENGTH: f64 = 0.03;
pub const MASS: f64 = 0.2;
pub const WEIGHT: f64 = MASS * 9.81;
pub const STIFFNESS: f64 = 5000.0;
/// The axis along y.
pub const LYING: [f64; 4] = [
    std::f64::consts::FRAC_1_SQRT_2,
    std::f64::consts::FRAC_1_SQRT_2,
    0.0,
    0.0,
];

pub fn cylinder() -> Shape {
    Shape::Cylinder {
        radius: RADIUS,
        half_length: HALF_LENGTH,
    }
}

/// A cylinder with its centre so high, under its weight.
pub fn heavy(height: f64) -> WorldBody {
    let mut one = body(cylinder(), MASS, [0.0, 0.0, height]);
    motion(&mut one).force = [0.0, 0.0, -WEIGHT];
    one
}

pub fn on(below: WorldBody, above: WorldBody, law: ContactLaw) -> WorldScene {
    WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        devices: vec![],
        bodies: vec![above, below],
        pairs: vec![pair(Member::Body(0), Member::Body(1), law)],
    }
}

pub fn floor() -> WorldBody {
    half_space([0.0, 0.0, 1.0], 0.0)
}

/// The largest difference of a number of each sample from a function of time.
pub fn apart(
    ideal: &WorldIdeal,
    found: impl Fn(&palpate_testbed::world::BodyState) -> f64,
    expected: impl Fn(f64) -> f64,
) -> f64 {
    let states = ideal.states.iter();
    let each = states.map(|state| (found(&state.bodies[0]) - expected(state.time)).abs());
    each.fold(0.0, f64::max)
}

#[test]
fn a_cylinder_has_all_of_the_stiffness_on_its_end_and_half_of_it_on_its_side() {
    for (orientation, reach, stiffness) in [
        ([1.0, 0.0, 0.0, 0.0], HALF_LENGTH, STIFFNESS),
        (LYING, RADIUS, 0.5 * STIFFNESS),
    ] {
        let (rest, swing) = (reach - WEIGHT / stiffness, 0.9 * WEIGHT / stiffness);
        let mut one = heavy(rest + swing);
        one.orientation = orientation;
        let ideal = solve(&on(floor(), one, ContactLaw::spring(STIFFNESS)), 0.001, 200);
        let rate = (stiffness / MASS).sqrt();
        let apart = apart(
            &ideal,
            |body| body.position[2],
            |t| rest + swing * (rate * t).cos(),
        );
        println!("swings on {stiffness} N/m to {apart:.1e} m");
        assert!(apart < 1e-11, "{apart}");
    }
}

/// V = K ((h cos a - z)² + r² sin² a/2)/2 + m g z, so a small angle swings on K r²/2 - m g h.
#[test]
fn a_cylinder_on_its_end_tips_on_a_spring_of_k_r_squared_over_two() {
    let angle = 1e-5_f64;
    let mut one = heavy(HALF_LENGTH - WEIGHT / STIFFNESS);
    // About an axis between its x and y axes, and turned about its own axis by any angle.
    let (sine, cosine) = (0.5 * angle).sin_cos();
    one.orientation = [cosine, 0.6 * sine, 0.8 * sine, 0.0];
    let inertia = one.motion.unwrap().inertia[0];
    let ideal = solve(&on(floor(), one, ContactLaw::spring(STIFFNESS)), 0.001, 200);
    let stiffness = 0.5 * STIFFNESS * RADIUS * RADIUS - WEIGHT * HALF_LENGTH;
    let rate = (stiffness / inertia).sqrt();
    let off = apart(
        &ideal,
        |body| 2.0 * (0.6 * body.orientation[1] + 0.8 * body.orientation[2]),
        |t| angle * (rate * t).cos(),
    );
    println!("tips to {:.1e} of its angle", off / angle);
    assert!(off < 1e-5 * angle, "{off}");
}

/// The bristle is a spring between the turning and the way: with the way u of the material at the place of contact,
/// m x″ = f − k u, I θ″ = R k u, u″ = x″ − R θ″.
#[test]
fn a_cylinder_rolls_down_a_slope_at_two_thirds_of_its_pull() {
    let (slope, stiffness) = (0.3_f64, 20_000.0);
    let deep = WEIGHT * slope.cos() / (0.5 * STIFFNESS);
    let mut one = heavy(RADIUS - deep);
    one.orientation = LYING;
    motion(&mut one).force = [WEIGHT * slope.sin(), 0.0, -WEIGHT * slope.cos()];
    let inertia = one.motion.unwrap().inertia[2];
    let law = ContactLaw::spring(STIFFNESS).rough(1.5, stiffness);
    let ideal = solve(&on(floor(), one, law), 0.002, 200);
    let reach = RADIUS - 0.5 * deep;
    let parts = 1.0 + MASS * reach * reach / inertia;
    let rate = (parts * 0.5 * stiffness / MASS).sqrt();
    let pull = WEIGHT * slope.sin() / MASS;
    let off = apart(
        &ideal,
        |body| body.position[0],
        |t| {
            let swing = (1.0 - (rate * t).cos()) / (parts * rate * rate);
            pull * ((1.0 - 1.0 / parts) * 0.5 * t * t + swing)
        },
    );
    let end = ideal.states.last().unwrap();
    let rolled = end.bodies[0].position[0] / (0.5 * pull * end.time * end.time);
    println!("rolls {rolled:.5} of a free slide, as the bristles have it to {off:.1e} m");
    assert!(off < 1e-9, "{off}");
    assert!((rolled - 2.0 / 3.0).abs() < 0.01);
}

/// Twisted as it stands, it swings on its bristles, k_t r², and does not creep.
#[test]
fn a_cylinder_that_stands_holds_against_a_twist() {
    // The bristles stay straight, so a large angle swings slower.
    let (stiffness, spin) = (3000.0, 0.05);
    let mut one = heavy(HALF_LENGTH - WEIGHT / STIFFNESS);
    motion(&mut one).angular_velocity = [0.0, 0.0, spin];
    let inertia = one.motion.unwrap().inertia[2];
    // Without damping, a bristle whose contact begins as it moves would start at its longest.
    let law = ContactLaw::spring(STIFFNESS)
        .rough(0.5, stiffness)
        .damped(1.0);
    let ideal = solve(&on(floor(), one, law), 0.005, 200);
    let rate = (stiffness * RADIUS * RADIUS / inertia).sqrt();
    let off = apart(
        &ideal,
        |body| 2.0 * body.orientation[3].atan2(body.orientation[0]),
        |t| spin / rate * (rate * t).sin(),
    );
    println!("swings by {:.1e} rad, to {off:.1e} rad", spin / rate);
    assert!(off < 1e-9, "{off}");
    assert!(off < 1e-5 * spin / rate);
}

/// A cylinder that is thrown, one of several by number.
pub fn thrown(case: u8) -> WorldBody {
    let turn = |prime: f64| 2.0 * (f64::from(case + 1) * prime).fract() - 1.0;
    let mut one = heavy(0.04);
    let q = [1.0, turn(0.82), turn(0.67), turn(0.55)];
    let size = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    one.orientation = q.map(|x| x / size);
    motion(&mut one).velocity = [0.2, 0.1 * turn(0.4), -0.3];
    motion(&mut one).angular_velocity = [0.3, 0.7, 0.1].map(|part| 6.0 * turn(part));
    one
}

fn table() -> WorldBody {
    let mut table = body(
        Shape::Box {
            half_extents: [0.5, 0.4, 0.3],
        },
        1.0,
        [0.02, 0.01, -0.3],
    );
    table.orientation = [0.15_f64.cos(), 0.0, 0.0, 0.15_f64.sin()];
    table.motion = None;
    table
}

/// A disc that falls onto its rim rolls about it, lies down and rests: its points stop to turn with the deepest place.
/// On a large box off its middle as well, where the corners of the box are far from the disc and not equally far.
#[test]
fn a_disc_rolls_on_its_rim_until_it_lies_flat() {
    let half_length = 0.004;
    let disc = Shape::Cylinder {
        radius: RADIUS,
        half_length,
    };
    let law = ContactLaw::spring(STIFFNESS)
        .rough(0.2, STIFFNESS)
        .damped(20.0);
    let mut one = body(disc, MASS, [0.0, 0.0, 0.025]);
    let q = [0.98, 0.12, 0.04, 0.12];
    let size = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    one.orientation = q.map(|x| x / size);
    motion(&mut one).force = [0.0, 0.0, -WEIGHT];
    motion(&mut one).velocity = [0.15, 0.05, -0.2];
    motion(&mut one).angular_velocity = [1.0, 2.0, 0.5];
    let mut off_its_middle = table();
    off_its_middle.position = [0.3, -0.2, -0.3];
    let [on_floor, on_box] = [floor(), off_its_middle].map(|below| {
        let ideal = solve(&on(below, one.clone(), law), 0.02, 150);
        let end = ideal.states.last().unwrap().bodies[0];
        let off = (end.position[2] - half_length + WEIGHT / STIFFNESS).abs();
        let tilt = end.orientation[1].hypot(end.orientation[2]);
        println!(
            "a disc: {off:.1e} m from rest, tilt {tilt:.1e}; energy to {:.1e}, {} steps, {} events",
            drift(&ideal),
            ideal.steps,
            ideal.events
        );
        assert!(drift(&ideal) < 1e-9);
        assert!(off < 1e-12 && tilt < 1e-8, "{off} {tilt}");
        assert!(ideal.events > 20);
        ideal
    });
    assert!(5 * on_box.steps < 6 * on_floor.steps);
    let ends = [&on_floor, &on_box].map(|ideal| ideal.states.last().unwrap().bodies[0]);
    for axis in 0..3 {
        let apart = (ends[0].position[axis] - ends[1].position[axis]).abs();
        assert!(apart < 1e-6, "{apart}");
    }
}

/// It stands while its centre is above the box: there is no pull to the edge, nor away from it.
#[test]
fn a_can_falls_from_an_edge_if_and_only_if_its_centre_is_beyond_it() {
    let law = ContactLaw::spring(STIFFNESS)
        .rough(0.5, STIFFNESS)
        .damped(20.0);
    let size = Shape::Box {
        half_extents: [0.15, 0.2, 0.1],
    };
    for beyond in [-1e-3, 1e-3] {
        let mut below = body(size.clone(), 1.0, [-0.15 - beyond, 0.07, -0.1]);
        below.motion = None;
        let mut one = heavy(HALF_LENGTH - WEIGHT / STIFFNESS);
        motion(&mut one).velocity = [0.0, 0.0, -0.01];
        let ideal = solve(&on(below, one, law), 0.01, 100);
        let end = ideal.states.last().unwrap().bodies[0];
        let tilt = 2.0 * end.orientation[1].hypot(end.orientation[2]);
        println!(
            "{beyond} m beyond an edge: tilt {tilt:.2e}, {} steps, energy to {:.1e}",
            ideal.steps,
            drift(&ideal)
        );
        assert!(drift(&ideal) < 1e-6); // of the 10 µJ at the start
        if beyond < 0.0 {
            assert!(tilt < 1e-9, "{tilt}");
        } else {
            assert!(tilt > 0.5, "{tilt}");
        }
    }
}

/// A tool of six axes, in a hand that presses and turns it, on a loose block.
#[test]
fn a_tool_that_is_a_cylinder_pays_for_what_it_pushes() {
    let mut tool = device(0.2, [0.0, 0.002, 0.075]);
    tool.tool = Tool::Solid(cylinder());
    tool.hand.force = [0.4, 0.0, -3.0];
    tool.hand.stiffness = 50.0;
    tool.hand.damping = 1.0;
    tool.hand.rest = [0.0, 0.0, 0.05];
    tool.turning = Some(Turning {
        inertia: cylinder().inertia(0.2),
        orientation: [0.8, 0.6, 0.0, 0.0],
        angular_velocity: [1.0, -2.0, 0.5],
        hand: TurningHand {
            stiffness: 0.05,
            damping: 1e-3,
            ..TurningHand::none()
        },
        gives_torque: true,
        quantum: 0.0,
    });
    let block = Shape::Box {
        half_extents: [0.04, 0.03, 0.02],
    };
    let mut block = body(block, 0.3, [0.0, 0.0, 0.0195]);
    motion(&mut block).force[2] = -2.943;
    let law = ContactLaw::spring(4000.0).rough(0.4, 2000.0).damped(2.0);
    let scene = WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        devices: vec![tool],
        bodies: vec![block, floor()],
        pairs: vec![
            pair(Member::Body(0), Member::Device(0), law),
            pair(Member::Body(0), Member::Body(1), law),
        ],
    };
    let ideal = solve(&scene, 0.002, 200);
    let start = ideal.states[0].ledger.balance();
    let balances = ideal.states.iter().map(|state| state.ledger.balance());
    let apart = balances.map(|one| (one - start).abs()).fold(0.0, f64::max);
    let of_tool = ideal.encounters.iter().filter(|one| one.is_of_device(0));
    let torque = ideal.states.iter().map(|state| state.devices[0].torque);
    let torque = torque.map(|[x, y, z]| x.hypot(y).hypot(z));
    let (hits, torque) = (of_tool.count(), torque.fold(0.0, f64::max));
    println!("a tool: energy to {apart:.1e} J, {hits} contacts, {torque:.3} N m");
    assert!(apart < 1e-10, "{apart}");
    assert!(hits > 2 && torque > 0.01);
}

/// On its ends, its rims and its side, with and without friction and damping.
#[test]
fn a_cylinder_that_tumbles_keeps_its_energy() {
    for (kind, law, most) in [
        ("springs", ContactLaw::spring(4000.0), 1e-9),
        (
            "both",
            ContactLaw::spring(4000.0).rough(0.4, 2000.0).damped(1.0),
            1e-9,
        ),
    ] {
        for (name, below) in [("floor", floor()), ("table", table())] {
            let (mut worst, mut hits) = (0.0_f64, 0);
            for case in 0..6 {
                let ideal = solve(&on(below.clone(), thrown(case), law), 0.002, 250);
                worst = worst.max(drift(&ideal));
                hits += ideal.encounters.len();
            }
            println!("on a {name}, {kind}: energy to {worst:.1e}, {hits} contacts");
            assert!(worst < most, "{worst}");
            assert!(hits > 40, "{hits}");
        }
    }
}

#[test]
fn a_large_box_bears_a_cylinder_as_a_half_space_does() {
    let law = ContactLaw::spring(5000.0).damped(4.0).rough(0.4, 5000.0);
    let mut hits = 0;
    for case in 0..3 {
        let [on_box, on_floor] =
            [table(), floor()].map(|below| solve(&on(below, thrown(case), law), 0.002, 150));
        let mut apart = 0.0_f64;
        for (one, other) in on_box.states.iter().zip(&on_floor.states) {
            for axis in 0..3 {
                let [one, other] = [one, other].map(|state| state.bodies[0].position[axis]);
                apart = apart.max((one - other).abs());
            }
        }
        hits += on_box.encounters.len();
        println!("a cylinder on a box and on a half-space: {apart:.1e} m apart, {hits} contacts");
        assert!(apart < 1e-9, "{apart}");
    }
    assert!(hits > 12, "{hits}");
}

fn others() -> [(&'static str, Shape); 3] {
    let stone = [
        [0.025, 0.0, -0.005],
        [-0.01, 0.022, -0.01],
        [-0.012, -0.02, -0.006],
        [0.0, 0.003, 0.024],
        [0.01, 0.02, 0.012],
        [0.004, -0.018, 0.015],
    ];
    let prism: Vec<[f64; 3]> = (0..7_u8)
        .flat_map(|k| {
            let (sine, cosine) = (std::f64::consts::TAU * f64::from(k) / 7.0).sin_cos();
            [-0.015, 0.015].map(|z| [0.02 * cosine, 0.02 * sine, z])
        })
        .collect();
    let half_extents = [0.015, 0.025, 0.02];
    let hull = |points: &[[f64; 3]]| Shape::Hull(Arc::new(Hull::around(points).unwrap()));
    [
        ("box", Shape::Box { half_extents }),
        ("stone", hull(&stone)),
        ("prism", hull(&prism)),
    ]
}

/// A cylinder and another solid that fly into each other, one of several cases by number.
pub fn colliding(other: &Shape, case: u8, law: ContactLaw) -> WorldScene {
    let turn = |prime: f64| 2.0 * (f64::from(case + 1) * prime).fract() - 1.0;
    let of = |shape, mass, position, parts: [f64; 3], speed: f64| {
        let mut one = body(shape, mass, position);
        let q = [1.0, turn(parts[0]), turn(parts[1]), turn(parts[2])];
        let size = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        one.orientation = q.map(|x| x / size);
        motion(&mut one).velocity = [speed, 0.05 * turn(0.618), 0.05 * turn(0.414)];
        motion(&mut one).angular_velocity = parts.map(|part| 6.0 * turn(part + 0.1));
        one
    };
    let place = [-0.05, 0.005 * turn(0.3), 0.005 * turn(0.7)];
    let one = of(cylinder(), 0.1, [0.05, 0.0, 0.0], [0.82, 0.67, 0.55], -0.4);
    let other = of(other.clone(), 0.06, place, [0.732, 0.236, 0.142], 0.4);
    let first = case as usize % 2;
    WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        devices: vec![],
        bodies: vec![one, other],
        pairs: vec![pair(Member::Body(first), Member::Body(1 - first), law)],
    }
}

/// Over faces, ends, the side and edges, for springs alone and with friction and damping.
pub fn keeps_its_sums(name: &str, other: &Shape) {
    let springs = ContactLaw::spring(4000.0);
    for (kind, law) in [
        ("springs", springs),
        ("both", springs.rough(0.4, 2000.0).damped(1.0)),
    ] {
        let (mut worst, mut hits, mut steps) = ([0.0_f64; 3], 0, 0);
        for case in 0..6 {
            let scene = colliding(other, case, law);
            let ideal = solve(&scene, 0.002, 100);
            hits += usize::from(!ideal.encounters.is_empty());
            steps += ideal.steps;
            worst[0] = worst[0].max(drift(&ideal));
            let [before, after] = [0, ideal.states.len() - 1].map(|at| sums(&scene, &ideal, at));
            for (i, (a, b)) in before.iter().zip(after).enumerate() {
                worst[1 + i / 3] = worst[1 + i / 3].max((a - b).abs());
            }
        }
        println!(
            "a cylinder and a {name}, {kind}: {hits} of 6 meet; energy to {:.1e}, momentum {:.1e} N s, angular {:.1e}; {steps} steps",
            worst[0], worst[1], worst[2]
        );
        assert!(hits > 4, "{hits}");
        assert!(
            worst[0] < 1e-8 && worst[1] < 1e-13 && worst[2] < 1e-14,
            "{worst:?}"
        );
    }
}

#[test]
fn a_cylinder_keeps_energy_momentum_and_angular_momentum() {
    for (name, other) in others() {
        keeps_its_sums(name, &other);
    }
}
