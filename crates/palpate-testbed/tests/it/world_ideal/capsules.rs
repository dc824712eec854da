//! Capsules on boxes, capsules, cylinders and hulls.

use std::sync::Arc;

use palpate_testbed::world::{ContactLaw, Hull, Member, Shape, WorldScene};

use super::{body, half_space, motion, pair, solve};
use crate::world_ideal::boxes::{drift, sums};

fn capsule(radius: f64, half_length: f64) -> Shape {
    Shape::Capsule {
        radius,
        half_length,
    }
}

fn others() -> [(&'static str, Shape); 4] {
    let stone = [
        [0.025, 0.0, -0.005],
        [-0.01, 0.022, -0.01],
        [-0.012, -0.02, -0.006],
        [0.0, 0.003, 0.024],
        [0.01, 0.02, 0.012],
        [0.004, -0.018, 0.015],
    ];
    let half_extents = [0.015, 0.025, 0.02];
    let cylinder = Shape::Cylinder {
        radius: 0.02,
        half_length: 0.02,
    };
    [
        ("box", Shape::Box { half_extents }),
        ("capsule", capsule(0.012, 0.03)),
        ("cylinder", cylinder),
        ("hull", Shape::Hull(Arc::new(Hull::around(&stone).unwrap()))),
    ]
}

/// A capsule that falls and rolls on a large box, and on a half-space.
#[test]
fn a_large_box_bears_a_capsule_as_a_half_space_does() {
    let law = ContactLaw::spring(5000.0).damped(4.0).rough(0.4, 5000.0);
    let mut table = body(
        Shape::Box {
            half_extents: [0.5, 0.4, 0.3],
        },
        1.0,
        [0.02, 0.01, -0.3],
    );
    table.motion = None;
    let [on_box, on_floor] = [table, half_space([0.0, 0.0, 1.0], 0.0)].map(|below| {
        let mut falls = body(capsule(0.01, 0.03), 0.1, [0.0, 0.0, 0.03]);
        falls.orientation = [0.8, 0.0, 0.6, 0.0];
        let moves = motion(&mut falls);
        moves.velocity = [0.2, 0.1, -0.3];
        moves.force = [0.0, 0.0, -0.981];
        let scene = WorldScene {
            joints: Vec::new(),
            fields: Vec::new(),
            devices: vec![],
            bodies: vec![falls, below],
            pairs: vec![pair(Member::Body(0), Member::Body(1), law)],
        };
        solve(&scene, 0.002, 120)
    });
    let pairs = on_box.states.iter().zip(&on_floor.states);
    let apart = pairs.flat_map(|(one, other)| {
        let [one, other] = [one, other].map(|state| state.bodies[0].position);
        (0..3).map(move |axis| (one[axis] - other[axis]).abs())
    });
    let apart = apart.fold(0.0, f64::max);
    println!(
        "a capsule on a box and on a half-space: {apart:.1e} m apart, {} contacts",
        on_box.encounters.len()
    );
    assert!(apart < 1e-8, "{apart}");
    assert!(on_box.encounters.len() >= 2);
}

/// Without and with friction and damping, a capsule and another solid that fly into each other and tumble.
#[test]
fn a_capsule_keeps_energy_momentum_and_angular_momentum() {
    let springs = ContactLaw::spring(4000.0);
    // Where friction slides, the energy asks for rates, which are differences in time: they are wrong as a contact
    // begins.
    for (kind, law, most_drift) in [
        ("springs", springs, 1e-8),
        ("both", springs.rough(0.4, 2000.0).damped(1.0), 1e-6),
    ] {
        for (name, other) in others() {
            let (mut worst, mut hits) = ([0.0_f64; 3], 0);
            for case in 0..4_u8 {
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
                let rod = capsule(0.01, 0.025);
                let one = of(rod, 0.1, [0.05, 0.0, 0.0], [0.82, 0.67, 0.55], -0.4);
                let other = of(other.clone(), 0.06, place, [0.732, 0.236, 0.142], 0.4);
                let scene = WorldScene {
                    joints: Vec::new(),
                    fields: Vec::new(),
                    devices: vec![],
                    bodies: vec![one, other],
                    pairs: vec![pair(Member::Body(0), Member::Body(1), law)],
                };
                let ideal = solve(&scene, 0.002, 100);
                hits += usize::from(!ideal.encounters.is_empty());
                worst[0] = worst[0].max(drift(&ideal));
                let [before, after] =
                    [0, ideal.states.len() - 1].map(|at| sums(&scene, &ideal, at));
                for (i, (a, b)) in before.iter().zip(after).enumerate() {
                    worst[1 + i / 3] = worst[1 + i / 3].max((a - b).abs());
                }
            }
            println!(
                "a capsule and a {name}, {kind}: {hits} of 4 meet; energy to {:.1e}, momentum {:.1e} N s, angular {:.1e}",
                worst[0], worst[1], worst[2]
            );
            assert!(hits > 2, "{hits}");
            assert!(
                worst[0] < most_drift && worst[1] < 1e-13 && worst[2] < 1e-14,
                "{worst:?}"
            );
        }
    }
}
