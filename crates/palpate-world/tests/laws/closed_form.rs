//! Comparison with the closed form of the core: one body, one contact, one dimension.

use palpate_world::{
    BasicParams, Body, ContactLaw, CoupledParams, Free, Motion, Prior, Sample, Shape, SubSteps,
    WorldLoop, WorldRenderer,
};

use crate::common::{ball, leave_alone, plane, world};

const PERIOD: f64 = 0.001;
const MASS: f64 = 0.12;
const BALL: f64 = 0.08;
const STIFFNESS: f64 = 400.0;
const RADIUS: f64 = 0.02;

/// Returns the largest difference between the forces of world and core over 400 samples of a juggled ball, relative
/// to the largest force, and the number of samples with a force.
fn difference(sub_steps: SubSteps) -> (f64, usize) {
    let weight = -9.81 * BALL;
    let free = Free::of_mass(BALL).pulled_by([0.0, 0.0, weight]);
    let bodies = vec![ball("ball", RADIUS, free).at([0.0, 0.0, RADIUS + 0.01])];
    let loop_params = WorldLoop {
        sub_steps,
        ..WorldLoop::new(PERIOD)
    };
    let method = CoupledParams {
        offset_return: 0.0,
        velocity_return: f64::INFINITY,
        ..CoupledParams::new(vec![[MASS; 3]]).with_prior(Prior::of_a_known_mass())
    };
    let world = world(0.0, bodies, ContactLaw::spring(STIFFNESS));
    let renderer = WorldRenderer::new(&world, loop_params, method).unwrap();
    let mut state = renderer.start();

    let core = palpate_core::Renderer::new(
        palpate_core::Contact::object(STIFFNESS, BALL),
        palpate_core::LoopParams::new(PERIOD),
        palpate_core::CoupledParams::new(MASS),
    );
    let core = core.unwrap();
    let mut line = core
        .start(palpate_core::ObjectState::at_rest(0.01))
        .unwrap();

    let (mut position, mut velocity, push) = (0.0, 0.0, 0.9);
    let (mut worst, mut largest, mut pressed) = (0.0_f64, 0.0_f64, 0);
    for _ in 0..400 {
        let sample = palpate_core::Sample::at(position).with_virtual_force(weight);
        let on_line = core.step(&mut line, sample).force_on_device;
        let output = renderer.step(&mut state, &Sample::at(&[[0.0, 0.0, position]]));
        let [across, aside, along] = output.forces[0];
        assert_eq!([across, aside], [0.0; 2]);
        worst = worst.max((along - on_line).abs());
        largest = largest.max(on_line.abs());
        pressed += usize::from(on_line != 0.0);
        let pushed = (push + on_line) / MASS;
        position += (velocity + 0.5 * pushed * PERIOD) * PERIOD;
        velocity += pushed * PERIOD;
    }
    (worst / largest, pressed)
}

#[test]
fn along_a_line_the_forces_are_those_of_the_cores_closed_form() {
    let fine = SubSteps {
        least: 256,
        most: 4096,
        finer: 512,
        ..SubSteps::default()
    };
    let (as_it_comes, pressed) = difference(SubSteps::default());
    let (fine, _) = difference(fine);
    println!(
        "off by {as_it_comes:.1e} of the largest force, with fine sub-steps {fine:.1e}; {pressed} samples of contact"
    );
    assert!(pressed > 100, "{pressed}");
    assert!(fine < 1e-6, "{fine}");
    assert!(as_it_comes < 1e-3, "{as_it_comes}");
}

/// A block held by friction with a damped bristle: x = v/w sin(w t) exp(-g t) with g = B_t/(2m), w^2 = k_t/m - g^2.
/// The ledger has the dissipated energy.
#[test]
fn a_block_that_friction_holds_swings_by_the_damping_of_its_bristle() {
    let (mass, speed, stiffness, damping) = (0.05, 0.01, 2000.0, 2.0);
    let weight = 9.81 * mass;
    let free = Free {
        // It does not tilt.
        inertia: Some([1e6; 3]),
        velocity: [0.8 * speed, 0.6 * speed, 0.0],
        ..Free::of_mass(mass).pulled_by([0.0, 0.0, -weight])
    };
    let shape = Shape::Box {
        half_extents: [0.03, 0.02, 0.005],
    };
    let block =
        Body::new("block", shape, Motion::Free(free)).at([0.0, 0.0, 0.005 - weight / stiffness]);
    let law = ContactLaw {
        friction_damping: damping,
        ..ContactLaw::spring(stiffness).with_friction(0.4)
    };
    let world = world(0.001, vec![block, plane("floor", [0.0, 0.0, 1.0])], law);
    let method = BasicParams::default();
    let renderer = WorldRenderer::new(&world, WorldLoop::new(PERIOD), method).unwrap();
    let mut state = renderer.start();
    let rate = 0.5 * damping / mass;
    let omega = (stiffness / mass - rate * rate).sqrt();
    let mut worst = 0.0_f64;
    // The first sample begins the first interval.
    leave_alone(&renderer, &mut state, 1);
    for sample in 1..=100 {
        leave_alone(&renderer, &mut state, 1);
        let time = PERIOD * f64::from(sample);
        let way = speed / omega * (omega * time).sin() * (-rate * time).exp();
        let [x, y, _] = state.bodies()[0].position;
        worst = worst.max((x - 0.8 * way).abs().max((y - 0.6 * way).abs()));
    }
    let kinetic = 0.5 * mass * speed * speed;
    let dissipated = state.ledger().dissipated() / kinetic;
    println!(
        "off by {:.1e} of the largest way; dissipated {dissipated:.4} of the energy",
        worst * omega / speed
    );
    assert!(worst < 0.01 * speed / omega, "{worst}");
    assert!((0.97..1.0).contains(&dissipated), "{dissipated}");
}
