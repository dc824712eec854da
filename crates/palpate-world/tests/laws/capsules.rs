//! Capsules on boxes, capsules, cylinders and hulls: comparison with a half-space, conservation, energy ledger.

use palpate_world::{
    Body, ContactLaw, CoupledParams, Free, Motion, Sample, Shape, WorldLoop, WorldRenderer,
};

use crate::balance::{Balance, of_bodies};
use crate::common::{leave_alone, plane, world};
use crate::hulls::{box_of, stone};
use crate::tumbling::{conserves, part, renderer, thrown, turned};

const ROD: Shape = Shape::Capsule {
    radius: 0.01,
    half_length: 0.025,
};

/// Returns the other shape of a case.
fn other(kind: &str, case: u32) -> Shape {
    let half_length = 0.02 + 0.015 * part(case, 0.618);
    match kind {
        "boxes" => box_of([0.015, 0.025, 0.02]),
        "capsules" => Shape::Capsule {
            radius: 0.015,
            half_length,
        },
        "cylinders" => Shape::Cylinder {
            radius: 0.02,
            half_length,
        },
        _ => stone(case + 50, 6 + case % 5),
    }
}

#[test]
fn a_capsule_and_another_solid_conserve_momentum_angular_momentum_and_energy() {
    for kind in ["boxes", "capsules", "cylinders", "hulls"] {
        let pairs = (0..8).map(|case| {
            let mut shapes = [ROD, other(kind, case)];
            // Either may be the first.
            shapes.rotate_left(case as usize % 2);
            thrown(case, shapes)
        });
        conserves(&format!("a capsule and {kind}"), pairs, 5);
    }
}

/// A capsule that falls, rolls and slides on a large fixed box moves as on a half-space, to rounding: K has the same
/// meaning.
#[test]
fn a_large_box_bears_a_capsule_as_a_half_space_does() {
    let law = ContactLaw::spring(5000.0)
        .with_damping(4.0)
        .with_friction(0.4);
    let free = Free {
        angular_velocity: [3.0, -2.0, 4.0],
        velocity: [0.2, 0.1, -0.3],
        ..Free::of_mass(0.1).pulled_by([0.0, 0.0, -0.981])
    };
    let falls = Body::new("falls", ROD, Motion::Free(free))
        .at([0.0, 0.0, 0.045])
        .turned(turned(0.1, 0.7, 0.05));
    let table = Body::new("table", box_of([0.5, 0.4, 0.3]), Motion::Fixed).at([0.02, 0.01, -0.3]);
    // The number of sub-steps depends on the proximity query, which differs between the two shapes.
    let mut loop_params = WorldLoop::new(0.001);
    loop_params.sub_steps.least = loop_params.sub_steps.most;
    let renderers = [table, plane("table", [0.0, 0.0, 1.0])].map(|below| {
        let world = world(0.005, vec![falls.clone(), below], law);
        let method = CoupledParams::new(vec![[0.1; 3]]);
        WorldRenderer::new(&world, loop_params.clone(), method).unwrap()
    });
    let mut states = renderers.each_ref().map(WorldRenderer::start);
    let (mut apart, mut pushed) = (0.0_f64, [0; 3]);
    for _ in 0..400 {
        for (renderer, state) in renderers.iter().zip(&mut states) {
            leave_alone(renderer, state, 1);
        }
        let [one, other] = states.each_ref().map(|state| state.bodies()[0]);
        for axis in 0..3 {
            apart = apart.max((one.position[axis] - other.position[axis]).abs());
        }
        let touching = states[0].contacts().iter();
        pushed[touching.filter(|contact| contact.penetration > 0.0).count()] += 1;
    }
    println!(
        "a capsule on a box against one on a half-space: {apart:.1e} m apart, {pushed:?} samples on no end, one and both"
    );
    assert!(apart < 1e-10, "{apart}");
    assert!(pushed[1] > 5 && pushed[2] > 50, "{pushed:?}");
}

/// A tool rolls a log off a block that lies across another log: ledgers of each contact and of the world.
#[test]
fn ledger_of_pushed_capsules_closes() {
    let law = ContactLaw::spring(4000.0)
        .with_damping(2.0)
        .with_friction(0.4);
    let free = |mass: f64| Motion::Free(Free::of_mass(mass).pulled_by([0.0, 0.0, -9.81 * mass]));
    let bodies = vec![
        plane("table", [0.0, 0.0, 1.0]),
        Body::new("lower", ROD, free(0.05))
            .at([0.0, 0.0, 0.01])
            .turned(turned(1.0, 0.0, 0.0)),
        Body::new("across", ROD, free(0.04))
            .at([0.001, 0.002, 0.0305])
            .turned(turned(0.0, 1.0, 0.05)),
        Body::new("stone", stone(3, 8), free(0.03))
            .at([0.0, 0.05, 0.035])
            .balanced(),
        Body::new("block", box_of([0.01, 0.012, 0.008]), free(0.03)).at([0.004, -0.001, 0.05]),
    ];
    let renderer = renderer(&world(0.005, bodies, law));
    let mut state = renderer.start();
    let start = of_bodies(&state);
    for sample in 0..500 {
        let y = -0.06 + 0.2 * 0.001 * f64::from(sample);
        let output = renderer.step(&mut state, &Sample::at(&[[0.002, y, 0.033]]));
        assert_eq!(output.fault, None);
    }
    let balance = Balance::since(start, &state);
    println!("logs: {balance}");
    assert!(balance.turned_over > 0.01, "{}", balance.turned_over);
    balance.holds_to(1e-13, 2e-3);
}
