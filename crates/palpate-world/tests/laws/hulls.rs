//! Hulls on hulls and boxes: beside boxes, conservation, books.

use std::sync::Arc;

use palpate_world::{
    Body, ContactBook, ContactLaw, CoupledParams, Free, Hull, Motion, Sample, Shape, Vector, World,
    WorldLoop, WorldRenderer, WorldState,
};

use crate::common::{leave_alone, plane, world};

fn renderer(world: &World) -> WorldRenderer {
    let method = CoupledParams::new(vec![[0.1; 3]]);
    WorldRenderer::new(world, WorldLoop::new(0.001), method).unwrap()
}

fn hull(points: &[Vector]) -> Shape {
    Shape::Hull(Arc::new(Hull::around(points).unwrap()))
}

fn box_of(half: Vector) -> Shape {
    Shape::Box { half_extents: half }
}

/// The corners of a box.
fn corners(half: Vector) -> Vec<Vector> {
    let side = |number: usize, axis: usize| if number >> axis & 1 == 1 { 1.0 } else { -1.0 };
    (0..8)
        .map(|number| [0, 1, 2].map(|axis| side(number, axis) * half[axis]))
        .collect()
}

/// From -1 to 1, by the number of a case.
fn part(case: u32, prime: f64) -> f64 {
    2.0 * (f64::from(case + 1) * prime).fract() - 1.0
}

/// A solid of some corners on a ball of 30 mm.
fn stone(case: u32, count: u32) -> Shape {
    let points: Vec<Vector> = (0..count)
        .map(|k| {
            let at = [0.618, 0.414, 0.732].map(|prime| part(97 * case + k, prime));
            let size = at.iter().map(|x| x * x).sum::<f64>().sqrt();
            at.map(|x| 0.03 * x / size)
        })
        .collect();
    hull(&points)
}

fn turned(a: f64, b: f64, c: f64) -> [f64; 4] {
    let q = [1.0, a, b, c];
    let size = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    q.map(|x| x / size)
}

/// R I Rᵀ ω of moments along a body's own axes.
fn spin_of([w, x, y, z]: [f64; 4], omega: Vector, moments: Vector) -> Vector {
    let axes = [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y + w * z),
            2.0 * (x * z - w * y),
        ],
        [
            2.0 * (x * y - w * z),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z + w * x),
        ],
        [
            2.0 * (x * z + w * y),
            2.0 * (y * z - w * x),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ];
    let mut spin = [0.0; 3];
    for (axis, moment) in axes.iter().zip(moments) {
        let along: f64 = (0..3).map(|n| axis[n] * omega[n]).sum();
        for n in 0..3 {
            spin[n] += moment * along * axis[n];
        }
    }
    spin
}

/// Two solids that fly into each other and tumble: momentum and angular momentum stay to round-off, energy but for the steps.
#[test]
fn two_free_hulls_conserve_momentum_angular_momentum_and_energy() {
    let (mut worst, mut hits) = ([0.0_f64; 3], 0);
    for case in 0..24_u32 {
        let turn = |prime: f64| part(case, prime);
        let free = |sign: f64, mass: f64| Free {
            velocity: [-0.5 * sign, 0.1 * turn(0.618), 0.1 * turn(0.414)],
            angular_velocity: [5.0 * turn(0.755), 5.0 * turn(0.570), 5.0 * turn(0.430)],
            ..Free::of_mass(mass)
        };
        let other = if case % 3 == 0 {
            box_of([0.015, 0.025, 0.02])
        } else {
            stone(case + 50, 6 + case % 5)
        };
        let bodies = vec![
            Body::new(
                "one",
                stone(case, 4 + case % 9),
                Motion::Free(free(1.0, 0.1)),
            )
            .at([0.06, 0.0, 0.0])
            .turned(turned(turn(0.82), turn(0.67), turn(0.55)))
            .balanced(),
            Body::new("other", other, Motion::Free(free(-1.0, 0.06)))
                .at([-0.06, 0.006 * turn(0.3), 0.006 * turn(0.7)])
                .turned(turned(turn(0.732), turn(0.236), turn(0.142)))
                .balanced(),
        ];
        let masses = [0.1, 0.06];
        let moments = [0, 1].map(|body: usize| bodies[body].shape.moments(masses[body]).unwrap());
        let renderer = renderer(&world(0.005, bodies, ContactLaw::spring(8000.0)));
        let mut state = renderer.start();
        let momenta = |state: &WorldState| {
            let mut sums = [0.0; 6];
            for ((body, mass), moments) in state.bodies().iter().zip(masses).zip(moments) {
                let (x, v) = (body.position, body.velocity);
                let spin = spin_of(body.orientation, body.angular_velocity, moments);
                for i in 0..3 {
                    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                    sums[i] += mass * v[i];
                    sums[3 + i] += mass * (x[j] * v[k] - x[k] * v[j]) + spin[i];
                }
            }
            sums
        };
        let energy = |state: &WorldState| {
            let books = state.books();
            let kinetic: f64 = books.bodies.iter().map(|book| book.kinetic).sum();
            let stored: f64 = books.contacts.iter().map(|book| book.stored).sum();
            (kinetic + stored, stored)
        };
        let (before, (at_start, _)) = (momenta(&state), energy(&state));
        let mut most = 0.0_f64;
        for _ in 0..250 {
            leave_alone(&renderer, &mut state, 1);
            most = most.max(energy(&state).1);
        }
        hits += u32::from(most > 1e-4);
        let (after, (at_end, _)) = (momenta(&state), energy(&state));
        for i in 0..3 {
            worst[0] = worst[0].max((after[i] - before[i]).abs() / 0.05);
            worst[1] = worst[1].max((after[3 + i] - before[3 + i]).abs() / 5e-4);
        }
        worst[2] = worst[2].max((at_end / at_start - 1.0).abs());
    }
    println!(
        "24 pairs of hulls, {hits} hits: momentum {:.1e}, angular momentum {:.1e}, energy {:.1e} of what there was",
        worst[0], worst[1], worst[2]
    );
    assert!(hits > 15, "{hits}");
    assert!(worst[0] < 1e-12 && worst[1] < 1e-11, "{worst:?}");
    assert!(worst[2] < 2e-3, "{worst:?}");
}

/// A box that a tool knocks off another one, both of them boxes or hulls of the same corners; and the books of the hulls.
#[test]
fn hulls_of_boxes_move_as_boxes_and_their_books_balance() {
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
        let of_bodies = |state: &WorldState| -> f64 {
            let books = state.books().bodies.iter();
            books.map(|book| book.kinetic + book.potential).sum()
        };
        let start = of_bodies(&state);
        for sample in 0..450 {
            let x = -0.05 + 0.15 * 0.001 * f64::from(sample);
            let output = renderer.step(&mut state, &Sample::at(&[[x, 0.004, 0.034]]));
            assert_eq!(output.fault, None);
            places.extend(state.bodies()[1..].iter().map(|body| body.position));
        }
        let books = state.books();
        let sum = |of: fn(&ContactBook) -> f64| -> f64 { books.contacts.iter().map(of).sum() };
        let mut worst = 0.0_f64;
        for book in &books.contacts {
            let off = book.stored - book.observed - book.handed - book.step_error;
            worst = worst.max((off + book.work + book.dissipated).abs());
            assert!(book.dissipated >= 0.0);
        }
        let steps = sum(|book| book.step_error)
            + books.bodies.iter().map(|book| book.step_error).sum::<f64>();
        let all = of_bodies(&state) - start
            + sum(|book| book.stored)
            + sum(|book| book.dissipated)
            + sum(|book| book.work_on_avatar)
            - sum(|book| book.observed)
            - steps;
        let turned_over: f64 = books.contacts.iter().map(|book| book.work.abs()).sum();
        println!(
            "{turned_over:.3} J turned over, {:.1e} J handed from point to point, steps {steps:.1e}, books off by {worst:.1e} and {all:.1e}",
            books
                .contacts
                .iter()
                .map(|book| book.handed.abs())
                .sum::<f64>()
        );
        assert!(turned_over > 0.002, "{turned_over}");
        assert!(worst < 1e-13 && all.abs() < 1e-13, "{worst} {all}");
        places
    };
    // In which sub-step another plane takes over is another one, and with friction which of two such has the bristles.
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
