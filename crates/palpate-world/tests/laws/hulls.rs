//! Hulls on hulls and boxes: comparison with boxes, conservation, energy ledger.

use std::sync::Arc;

use palpate_world::{Body, ContactLaw, Free, Hull, Motion, Sample, Shape, Vector};

use crate::balance::{Balance, of_bodies};
use crate::common::{plane, world};
use crate::tumbling::{conserves, part, renderer, thrown, turned};

fn hull(points: &[Vector]) -> Shape {
    Shape::Hull(Arc::new(Hull::around(points).unwrap()))
}

pub fn box_of(half: Vector) -> Shape {
    Shape::Box { half_extents: half }
}

/// Returns the corners of a box.
fn corners(half: Vector) -> Vec<Vector> {
    let side = |number: usize, axis: usize| if number >> axis & 1 == 1 { 1.0 } else { -1.0 };
    (0..8)
        .map(|number| [0, 1, 2].map(|axis| side(number, axis) * half[axis]))
        .collect()
}

/// Returns a solid of some corners on a ball of 30 mm.
pub fn stone(case: u32, count: u32) -> Shape {
    let points: Vec<Vector> = (0..count)
        .map(|k| {
            let at = [0.618, 0.414, 0.732].map(|prime| part(97 * case + k, prime));
            let size = at.iter().map(|x| x * x).sum::<f64>().sqrt();
            at.map(|x| 0.03 * x / size)
        })
        .collect();
    hull(&points)
}

#[test]
fn two_free_hulls_conserve_momentum_angular_momentum_and_energy() {
    let pairs = (0..24).map(|case| {
        let other = if case % 3 == 0 {
            box_of([0.015, 0.025, 0.02])
        } else {
            stone(case + 50, 6 + case % 5)
        };
        thrown(case, [stone(case, 4 + case % 9), other])
    });
    conserves("hulls", pairs, 15);
}

/// A tool knocks one box off another; both are boxes or hulls with the same corners. Includes the ledger of the
/// hulls.
#[test]
fn hulls_of_boxes_move_like_boxes_and_their_ledger_closes() {
    let halves = [[0.02, 0.02, 0.01], [0.018, 0.015, 0.01]];
    let run = |shapes: [Shape; 2], friction: f64| {
        let law = ContactLaw::spring(4000.0)
            .with_damping(2.0)
            .with_friction(friction);
        let [lower, upper] = shapes.map(|shape| {
            let free = Free::of_mass(0.05).pulled_by([0.0, 0.0, -0.4905]);
            Body::new("", shape, Motion::Free(free)).balanced()
        });
        let named = |name: &str, body: Body| Body {
            name: name.into(),
            ..body
        };
        let bodies = vec![
            plane("table", [0.0, 0.0, 1.0]),
            named("lower", lower).at([0.0, 0.0, 0.01]),
            named("upper", upper)
                .at([0.004, 0.003, 0.036])
                .turned(turned(0.1, -0.07, 0.14)),
        ];
        let renderer = renderer(&world(0.005, bodies, law));
        let mut state = renderer.start();
        let mut places = Vec::new();
        let start = of_bodies(&state);
        for sample in 0..450 {
            let x = -0.05 + 0.15 * 0.001 * f64::from(sample);
            let output = renderer.step(&mut state, &Sample::at(&[[x, 0.004, 0.034]]));
            assert_eq!(output.fault, None);
            places.extend(state.bodies()[1..].iter().map(|body| body.position));
        }
        let balance = Balance::since(start, &state);
        println!("a box knocked off another, friction {friction}: {balance}");
        assert!(balance.turned_over > 0.002, "{}", balance.turned_over);
        balance.holds_to(1e-13, f64::INFINITY);
        places
    };
    // The sub-step of a plane switch differs, and with friction so does the choice of planes with bristles.
    for (friction, allowed) in [(0.0, 1e-6), (0.4, 2e-4)] {
        let boxes = run(halves.map(box_of), friction);
        let mixed = run([box_of(halves[0]), hull(&corners(halves[1]))], friction);
        let hulls = run(halves.map(|half| hull(&corners(half))), friction);
        for (word, other) in [("a hull on a box", mixed), ("hulls", hulls)] {
            let pairs = boxes.iter().flatten().zip(other.iter().flatten());
            let apart = pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
            println!(
                "friction {friction}, boxes and {word} of the same corners: {apart:.1e} m apart"
            );
            assert!(apart < allowed, "{apart}");
        }
    }
}
