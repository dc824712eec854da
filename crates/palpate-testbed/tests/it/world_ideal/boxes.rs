//! Boxes on boxes.

use palpate_testbed::world::{ContactLaw, Member, Shape, WorldBody, WorldIdeal, WorldScene};

use super::{body, half_space, motion, pair, solve};

const NEAR: f64 = 1e-9;

fn block(half_extents: [f64; 3]) -> Shape {
    Shape::Box { half_extents }
}

fn falling(below: WorldBody, law: ContactLaw) -> WorldScene {
    let mut falls = body(block([0.03, 0.02, 0.015]), 0.1, [0.0, 0.0, 0.045]);
    falls.orientation = [0.975_718_7, 0.123_999, 0.173_598, 0.049_599_6];
    let moves = motion(&mut falls);
    moves.velocity = [0.2, 0.1, -0.3];
    moves.angular_velocity = [3.0, -2.0, 4.0];
    moves.force = [0.0, 0.0, -0.981];
    WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        devices: vec![],
        bodies: vec![falls, below],
        pairs: vec![pair(Member::Body(0), Member::Body(1), law)],
    }
}

#[test]
fn a_large_box_pushes_as_a_half_space() {
    let law = ContactLaw::spring(5000.0).damped(4.0).rough(0.4, 5000.0);
    let mut table = body(block([0.5, 0.4, 0.3]), 1.0, [0.02, 0.01, -0.3]);
    table.orientation = [0.15_f64.cos(), 0.0, 0.0, 0.15_f64.sin()];
    table.motion = None;
    let [on_box, on_floor] = [table, half_space([0.0, 0.0, 1.0], 0.0)]
        .map(|below| solve(&falling(below, law), 0.002, 150));
    let mut apart = 0.0_f64;
    for (one, other) in on_box.states.iter().zip(&on_floor.states) {
        for axis in 0..3 {
            let [one, other] = [one, other].map(|state| state.bodies[0].position[axis]);
            apart = apart.max((one - other).abs());
        }
    }
    println!(
        "a box on a box and on a half-space: {apart:.1e} m apart, {} contacts",
        on_box.encounters.len()
    );
    assert!(apart < NEAR, "{apart}");
    assert!(on_box.encounters.len() > 4);
}

/// By how much the balance of energy drifts, of the kinetic energy at the start.
pub fn drift(ideal: &WorldIdeal) -> f64 {
    let start = ideal.states[0].ledger.balance();
    let apart = ideal
        .states
        .iter()
        .map(|state| (state.ledger.balance() - start).abs());
    apart.fold(0.0, f64::max) / ideal.states[0].ledger.kinetic
}

/// Momentum and angular momentum of all bodies at a sample.
pub fn sums(scene: &WorldScene, ideal: &WorldIdeal, number: usize) -> [f64; 6] {
    let mut sums = [0.0; 6];
    for (body, state) in scene.bodies.iter().zip(&ideal.states[number].bodies) {
        let mass = body.motion.unwrap().mass;
        let ([x, y, z], [u, v, w]) = (state.position, state.velocity);
        let orbital = [y * w - z * v, z * u - x * w, x * v - y * u];
        for axis in 0..3 {
            sums[axis] += mass * state.velocity[axis];
            sums[3 + axis] += mass * orbital[axis] + state.angular_momentum[axis];
        }
    }
    sums
}

/// Two boxes that tumble into each other, over their faces, edges and corners: no energy comes or goes where another
/// plane takes over, but for the 1e-9 by which its overlap has to be less; momentum and angular momentum stay.
#[test]
fn two_boxes_keep_energy_momentum_and_angular_momentum() {
    for (name, law) in [
        ("springs", ContactLaw::spring(4000.0)),
        (
            "both",
            ContactLaw::spring(4000.0).rough(0.4, 2000.0).damped(1.0),
        ),
    ] {
        let (mut planes, mut worst) = (0, [0.0_f64; 3]);
        for case in 0..8_u8 {
            let turn = |prime: f64| 2.0 * (f64::from(case + 1) * prime).fract() - 1.0;
            let of = |half, mass, position, parts: [f64; 3], speed: f64| {
                let mut one = body(block(half), mass, position);
                let q = [1.0, turn(parts[0]), turn(parts[1]), turn(parts[2])];
                let size = q.iter().map(|x| x * x).sum::<f64>().sqrt();
                one.orientation = q.map(|x| x / size);
                motion(&mut one).velocity = [speed, 0.05 * turn(0.618), 0.05 * turn(0.414)];
                motion(&mut one).angular_velocity = parts.map(|part| 6.0 * turn(part + 0.1));
                one
            };
            let one = of(
                [0.03, 0.02, 0.015],
                0.1,
                [0.05, 0.0, 0.0],
                [0.82, 0.67, 0.55],
                -0.4,
            );
            let place = [-0.05, 0.005 * turn(0.3), 0.005 * turn(0.7)];
            let other = of(
                [0.015, 0.025, 0.02],
                0.06,
                place,
                [0.732, 0.236, 0.142],
                0.4,
            );
            let scene = WorldScene {
                joints: Vec::new(),
                fields: Vec::new(),
                devices: vec![],
                bodies: vec![one, other],
                pairs: vec![pair(Member::Body(0), Member::Body(1), law)],
            };
            let ideal = solve(&scene, 0.002, 100);
            worst[0] = worst[0].max(drift(&ideal));
            let [before, after] = [0, ideal.states.len() - 1].map(|at| sums(&scene, &ideal, at));
            for (i, (a, b)) in before.iter().zip(after).enumerate() {
                worst[1 + i / 3] = worst[1 + i / 3].max((a - b).abs());
            }
            let mut normals: Vec<_> = ideal
                .states
                .iter()
                .flat_map(|state| {
                    let pushing = state
                        .contacts
                        .iter()
                        .find(|contact| contact.normal_force > 0.0);
                    pushing.map(|contact| contact.normal)
                })
                .collect();
            normals.dedup_by(|a, b| a.iter().zip(&*b).map(|(a, b)| a * b).sum::<f64>() > 0.9);
            planes += normals.len();
        }
        println!(
            "{name}: energy to {:.1e}, momentum {:.1e} N s, angular {:.1e}; {planes} planes that differ",
            worst[0], worst[1], worst[2]
        );
        assert!(
            worst[0] < 1e-8 && worst[1] < 1e-13 && worst[2] < 1e-14,
            "{worst:?}"
        );
        assert!(planes > 8, "{planes}");
    }
}
