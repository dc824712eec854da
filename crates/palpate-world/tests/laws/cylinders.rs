//! Cylinders on half-spaces, boxes, hulls and cylinders: stiffness, rolling, twist, conservation, energy ledger.

use palpate_world::{
    Body, ContactLaw, CoupledParams, Free, Motion, Sample, Shape, Vector, WorldLoop, WorldRenderer,
    WorldState,
};

use crate::balance::{Balance, of_bodies};
use crate::common::{leave_alone, plane, world};
use crate::hulls::{box_of, stone};
use crate::tumbling::{conserves, part, renderer, thrown, turned};

const RADIUS: f64 = 0.02;
const HALF_LENGTH: f64 = 0.03;
const CAN: Shape = Shape::Cylinder {
    radius: RADIUS,
    half_length: HALF_LENGTH,
};
const K: f64 = 5000.0;
const MASS: f64 = 0.1;
const WEIGHT: f64 = 0.981;
/// A quarter turn about x.
const LYING: [f64; 4] = [
    std::f64::consts::FRAC_1_SQRT_2,
    std::f64::consts::FRAC_1_SQRT_2,
    0.0,
    0.0,
];

fn heavy() -> Free {
    Free::of_mass(MASS).pulled_by([0.0, 0.0, -WEIGHT])
}

fn can(free: Free, position: Vector) -> Body {
    Body::new("can", CAN, Motion::Free(free)).at(position)
}

/// Returns the other shape of a case.
fn other(kind: &str, case: u32) -> Shape {
    match kind {
        "boxes" => box_of([0.015, 0.025, 0.02]),
        "cylinders" => Shape::Cylinder {
            radius: 0.02,
            half_length: 0.01 + 0.01 * part(case, 0.618).abs(),
        },
        _ => stone(case + 50, 6 + case % 5),
    }
}

#[test]
fn a_cylinder_and_another_solid_conserve_momentum_angular_momentum_and_energy() {
    for kind in ["boxes", "hulls", "cylinders"] {
        let pairs = (0..10).map(|case| {
            let mut shapes = [CAN, other(kind, case)];
            // Either may be the first.
            shapes.rotate_left(case as usize % 2);
            thrown(case, shapes)
        });
        conserves(&format!("a cylinder and {kind}"), pairs, 6);
    }
}

/// Returns the mean depth to which a cylinder with this orientation sinks from first contact with a floor `[m]`.
fn sinks(orientation: [f64; 4], height: f64) -> f64 {
    let law = ContactLaw::spring(K).with_damping(60.0);
    let bodies = vec![
        plane("floor", [0.0, 0.0, 1.0]),
        can(heavy(), [0.0, 0.0, height]).turned(orientation),
    ];
    let renderer = renderer(&world(0.005, bodies, law));
    let mut state = renderer.start();
    leave_alone(&renderer, &mut state, 1500);
    let body = state.bodies()[1];
    assert!(body.velocity[2].abs() < 1e-9, "{body:?}");
    height - body.position[2]
}

#[test]
fn k_is_the_stiffness_of_a_cylinder_that_stands_and_half_of_it_of_one_that_lies() {
    let standing = sinks([1.0, 0.0, 0.0, 0.0], HALF_LENGTH);
    let lying = sinks(LYING, RADIUS);
    println!(
        "K {:.9} and {:.9} of itself",
        WEIGHT / standing / K,
        WEIGHT / lying / K
    );
    assert!((standing * K / WEIGHT - 1.0).abs() < 1e-7, "{standing}");
    assert!((lying * 0.5 * K / WEIGHT - 1.0).abs() < 1e-7, "{lying}");
}

/// On a slope a cylinder rolls with two thirds of the acceleration of frictionless sliding.
#[test]
fn a_cylinder_rolls_down_a_slope() {
    let (sine, cosine) = (0.2_f64, 0.96_f64.sqrt());
    let law = ContactLaw::spring(K).with_damping(4.0).with_friction(0.8);
    // The floor is level and the weight leans along y, the rolling direction of the can.
    let leaning = Free::of_mass(MASS).pulled_by([0.0, WEIGHT * sine, -WEIGHT * cosine]);
    let at_rest = RADIUS - WEIGHT * cosine / (0.5 * K);
    let bodies = vec![
        plane("floor", [0.0, 0.0, 1.0]),
        // Axis along x.
        can(leaning, [0.0, 0.0, at_rest]).turned([LYING[0], 0.0, LYING[0], 0.0]),
    ];
    let renderer = renderer(&world(0.005, bodies, law));
    let mut state = renderer.start();
    let speed = |state: &WorldState| state.bodies()[1].velocity[1];
    // The bristles oscillate until the can rolls.
    leave_alone(&renderer, &mut state, 300);
    let before = speed(&state);
    leave_alone(&renderer, &mut state, 700);
    let rate = (speed(&state) - before) / 0.7;
    let wanted = 2.0 / 3.0 * WEIGHT / MASS * sine;
    let body = state.bodies()[1];
    println!("rolls at {:.5} of 2/3 g sin", rate / wanted);
    assert!((rate / wanted - 1.0).abs() < 5e-3, "{rate} {wanted}");
    // Several turns without a sideways displacement.
    assert!(body.position[1] > 8.0 * RADIUS, "{body:?}");
    assert!(body.position[0].abs() < 1e-9, "{body:?}");
}

/// A standing cylinder sticks under a twist: it rotates by the deflection of the bristles, and back.
#[test]
fn a_standing_cylinder_holds_a_twist() {
    let law = ContactLaw::spring(K).with_damping(20.0).with_friction(0.5);
    let twisted = Free {
        angular_velocity: [0.0, 0.0, 1.0],
        ..heavy()
    };
    let bodies = vec![
        plane("floor", [0.0, 0.0, 1.0]),
        can(twisted, [0.0, 0.0, HALF_LENGTH - WEIGHT / K]).turned(turned(1e-9, -2e-9, 0.3)),
    ];
    let renderer = renderer(&world(0.005, bodies, law));
    let mut state = renderer.start();
    let angle = |state: &WorldState| {
        let [w, _, _, z] = state.bodies()[1].orientation;
        2.0 * z.atan2(w)
    };
    let start = angle(&state);
    let (mut most, mut least) = (0.0_f64, 0.0_f64);
    for _ in 0..400 {
        leave_alone(&renderer, &mut state, 1);
        most = most.max(angle(&state) - start);
        least = least.min(angle(&state) - start);
    }
    // Inertia m r^2/2 on bristles K r^2: an oscillation with amplitude w sqrt(m/2K).
    let swing = (MASS / (2.0 * K)).sqrt();
    println!("a twist of 1 rad/s: from {least:.5} to {most:.5}, a swing of {swing:.5} rad");
    assert!((most / swing - 1.0).abs() < 0.02, "{most} {swing}");
    assert!((least / -swing - 1.0).abs() < 0.02, "{least} {swing}");
}

/// A cylinder that falls, tips and rolls on a large fixed box moves as on a half-space: K has the same meaning.
#[test]
fn a_large_box_bears_a_cylinder_as_a_half_space_does() {
    let law = ContactLaw::spring(K).with_damping(4.0).with_friction(0.4);
    let free = Free {
        angular_velocity: [1.0, -2.0, 4.0],
        velocity: [0.2, 0.1, -0.3],
        ..heavy()
    };
    let falls = can(free, [0.0, 0.0, 0.04]).turned(turned(0.02, 0.05, 0.05));
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
    let (mut apart, mut pushed) = (0.0_f64, [0; 9]);
    for _ in 0..600 {
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
        "a cylinder on a box against one on a half-space: {apart:.1e} m apart, {pushed:?} samples on so many points"
    );
    assert!(apart < 1e-9, "{apart}");
    assert!(
        [1, 3, 4].iter().all(|&count| pushed[count] > 20),
        "{pushed:?}"
    );
}

/// A can on a table stands upright if its mass centre is above the table, and tips over the edge if it is beyond it.
#[test]
fn a_cylinder_tips_over_an_edge_only_where_its_mass_centre_is_beyond_it() {
    let law = ContactLaw::spring(K).with_damping(20.0).with_friction(0.5);
    let upright = |x: f64| {
        let bodies = vec![
            Body::new("table", box_of([0.15, 0.1, 0.05]), Motion::Fixed).at([0.0, 0.0, -0.05]),
            // Slightly tilted, so that it has to return.
            can(heavy(), [x, 0.03, HALF_LENGTH - WEIGHT / K]).turned(turned(3e-4, 4e-4, 0.0)),
        ];
        let renderer = renderer(&world(0.005, bodies, law));
        let mut state = renderer.start();
        leave_alone(&renderer, &mut state, 500);
        let [_, x, y, _] = state.bodies()[1].orientation;
        1.0 - 2.0 * (x * x + y * y)
    };
    for x in [0.0, 0.02, -0.1, 0.139, 0.149] {
        let cosine = upright(x);
        println!(
            "mass centre at {x} m of 0.15 m: cosine of the tilt 1 - {:.1e}",
            1.0 - cosine
        );
        assert!(1.0 - cosine < 1e-9, "{x} {cosine}");
    }
    assert!(upright(0.151) < 0.9, "{}", upright(0.151));
}

/// The same test for a cylinder that lies across a narrow post.
#[test]
fn a_cylinder_across_a_post_tips_only_where_its_mass_centre_is_beyond_it() {
    let law = ContactLaw::spring(K).with_damping(20.0).with_friction(0.5);
    let tilt = |x: f64| {
        let bodies = vec![
            Body::new("post", box_of([0.01, 0.02, 0.05]), Motion::Fixed).at([0.0, 0.0, -0.05]),
            can(heavy(), [x, 0.0, RADIUS - WEIGHT / (0.5 * K)])
                .turned([LYING[0], 0.0, LYING[0], 0.0]),
        ];
        let renderer = renderer(&world(0.005, bodies, law));
        let mut state = renderer.start();
        leave_alone(&renderer, &mut state, 400);
        let [w, x, y, z] = state.bodies()[1].orientation;
        // Rise of the axis relative to its length.
        (w * w - x * x - y * y + z * z).abs()
    };
    for x in [0.0, 0.005, -0.009] {
        let rises = tilt(x);
        println!("across a post of 10 mm, mass centre at {x} m: the axis rises by {rises:.1e}");
        assert!(rises < 1e-4, "{x} {rises}");
    }
    // Falling, after 0.4 s.
    assert!(tilt(0.011) > 0.05, "{}", tilt(0.011));
}

/// A tool pushes cans around: ledgers of each contact and of the world.
#[test]
fn ledger_of_pushed_cylinders_closes() {
    let law = ContactLaw::spring(4000.0)
        .with_damping(2.0)
        .with_friction(0.4);
    let free = |mass: f64| Motion::Free(Free::of_mass(mass).pulled_by([0.0, 0.0, -9.81 * mass]));
    let bodies = vec![
        plane("table", [0.0, 0.0, 1.0]),
        Body::new("lies", CAN, free(0.05))
            .at([0.0, 0.0, 0.02])
            .turned(turned(1.0, 0.0, 0.0)),
        Body::new("stands", CAN, free(0.06)).at([0.0, 0.06, 0.03]),
        Body::new("stone", stone(3, 8), free(0.03))
            .at([0.0, 0.06, 0.09])
            .balanced(),
    ];
    let renderer = renderer(&world(0.005, bodies, law));
    let mut state = renderer.start();
    let start = of_bodies(&state);
    for sample in 0..500 {
        let y = -0.08 + 0.2 * 0.001 * f64::from(sample);
        let output = renderer.step(&mut state, &Sample::at(&[[0.002, y, 0.033]]));
        assert_eq!(output.fault, None);
    }
    let balance = Balance::since(start, &state);
    println!("cylinders: {balance}");
    assert!(balance.turned_over > 0.01, "{}", balance.turned_over);
    balance.holds_to(1e-13, 2e-3);
}
