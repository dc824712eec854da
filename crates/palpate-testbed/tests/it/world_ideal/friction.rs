//! Friction: bodies that roll, slide and stick.

use palpate_testbed::world::{ContactLaw, Member, Shape, WorldScene};

use super::{body, device, half_space, motion, pair, solve};

const GRAVITY: f64 = 9.81;

/// A ball on a slope of angle α gains 5/7 g sin α while it rolls, and g (sin α − μ cos α) while it slides.
#[test]
fn a_ball_rolls_or_slides_down_a_slope() {
    let (mass, radius, alpha, stiffness) = (0.1, 0.02, 0.3_f64, 1e5);
    // Rolling needs μ of at least 2/7 tan α = 0.088.
    for (friction, expected) in [
        (0.5, 5.0 / 7.0 * GRAVITY * alpha.sin()),
        (0.05, GRAVITY * (alpha.sin() - 0.05 * alpha.cos())),
    ] {
        let weight = mass * GRAVITY;
        let sunk = weight * alpha.cos() / stiffness;
        let shape = Shape::Sphere { radius };
        let mut ball = body(shape, mass, [0.0, 0.0, radius - sunk]);
        motion(&mut ball).force = [weight * alpha.sin(), 0.0, -weight * alpha.cos()];
        let law = ContactLaw::spring(stiffness)
            .damped(20.0)
            .rough(friction, stiffness);
        let scene = WorldScene {
            joints: Vec::new(),
            fields: Vec::new(),
            bodies: vec![ball, half_space([0.0, 0.0, 1.0], 0.0)],
            pairs: vec![pair(Member::Body(1), Member::Body(0), law)],
            ..WorldScene::default()
        };
        let ideal = solve(&scene, 0.01, 50);
        let end = ideal.states.last().unwrap();
        let gained = end.bodies[0].velocity[0] / end.time;
        println!("mu = {friction}: {gained:.5} m/s2, stiff limit {expected:.5}");
        assert!((gained / expected - 1.0).abs() < 2e-3);
        let spin = end.bodies[0].angular_velocity[1] * radius;
        let ratio = spin / end.bodies[0].velocity[0];
        if friction > 0.1 {
            assert!((ratio - 1.0).abs() < 2e-3, "rolls: {ratio}");
        } else {
            let expected = 2.5 * friction * GRAVITY * alpha.cos() / expected;
            assert!((ratio - expected).abs() < 2e-3, "slides: {ratio}");
        }
        let balance = end.ledger.balance() - ideal.states[0].ledger.balance();
        assert!(balance.abs() < 1e-10);
    }
}

/// A block that slides with v stops after v²/(2 μ g), and has then lost its kinetic energy to friction.
#[test]
fn a_sliding_block_stops_where_friction_has_taken_its_energy() {
    let (mass, speed, friction, stiffness) = (0.05, 0.4, 0.4, 2e5);
    let shape = Shape::Box {
        half_extents: [0.03, 0.02, 0.005],
    };
    let weight = mass * GRAVITY;
    let mut block = body(shape, mass, [0.0, 0.0, 0.005 - weight / stiffness]);
    motion(&mut block).velocity = [0.8 * speed, 0.6 * speed, 0.0];
    motion(&mut block).force[2] = -weight;
    let law = ContactLaw::spring(stiffness)
        .damped(100.0)
        .rough(friction, stiffness);
    let scene = WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        bodies: vec![block, half_space([0.0, 0.0, 1.0], 0.0)],
        pairs: vec![pair(Member::Body(0), Member::Body(1), law)],
        ..WorldScene::default()
    };
    let ideal = solve(&scene, 0.01, 20);
    let end = ideal.states.last().unwrap();
    let [x, y, _] = end.bodies[0].position;
    let travel = x.hypot(y);
    let expected = speed * speed / (2.0 * friction * GRAVITY);
    println!(
        "stops after {travel:.6} m, stiff limit {expected:.6} m; {} steps",
        ideal.steps
    );
    assert!((travel / expected - 1.0).abs() < 5e-3);
    assert!((y / x - 0.75).abs() < 1e-2);
    let kinetic = 0.5 * mass * speed * speed;
    assert!((end.ledger.dissipated / kinetic - 1.0).abs() < 1e-2);
    for pair in ideal.states.windows(2) {
        assert!(pair[1].ledger.dissipated >= pair[0].ledger.dissipated - 1e-15);
        assert!((pair[1].ledger.balance() - pair[0].ledger.balance()).abs() < 1e-11);
    }
}

/// A block that friction holds and F pulls from t = 0 on, with a damped bristle: x = F/k_t (1 − exp(−γt) (cos ωt + γ/ω
/// sin ωt)) with γ = B_t/(2m), ω² = k_t/m − γ². In the end the damper has taken F²/(2 k_t).
#[test]
fn a_block_that_friction_holds_swings_by_the_damping_of_its_bristle() {
    let (mass, pull, stiffness, damping) = (0.05, 0.05, 2000.0, 2.0);
    let shape = Shape::Box {
        half_extents: [0.03, 0.02, 0.005],
    };
    let weight = mass * GRAVITY;
    let mut block = body(shape, mass, [0.0, 0.0, 0.005 - weight / stiffness]);
    motion(&mut block).force = [0.8 * pull, 0.6 * pull, -weight];
    // It does not tilt.
    motion(&mut block).inertia = [1e6; 3];
    let law = ContactLaw {
        friction_damping: damping,
        ..ContactLaw::spring(stiffness).rough(0.4, stiffness)
    };
    let scene = WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        bodies: vec![block, half_space([0.0, 0.0, 1.0], 0.0)],
        pairs: vec![pair(Member::Body(0), Member::Body(1), law)],
        ..WorldScene::default()
    };
    let ideal = solve(&scene, 0.001, 300);
    let rate = 0.5 * damping / mass;
    let omega = (stiffness / mass - rate * rate).sqrt();
    for state in &ideal.states {
        let phase = omega * state.time;
        let swing = (-rate * state.time).exp() * (phase.cos() + rate / omega * phase.sin());
        let way = pull / stiffness * (1.0 - swing);
        let [x, y, _] = state.bodies[0].position;
        assert!((x - 0.8 * way).abs() < 1e-10 && (y - 0.6 * way).abs() < 1e-10);
        let balance = state.ledger.balance() - ideal.states[0].ledger.balance();
        assert!(balance.abs() < 1e-13, "{balance}");
    }
    let expected = 0.5 * pull * pull / stiffness;
    let dissipated = ideal.states.last().unwrap().ledger.dissipated;
    assert!((dissipated / expected - 1.0).abs() < 1e-3, "{dissipated}");
}

/// A point pressed with N and pulled at once with less than half of μ N, so that it does not overshoot, is held by the
/// bristle, z = F/k_t; with more it slides.
#[test]
fn a_point_sticks_up_to_the_limit_and_slides_beyond_it() {
    for (pull, sticks) in [([0.08, 0.1, -1.0], true), ([0.4, 0.3, -1.0], false)] {
        let mut tool = device(0.1, [0.0, 0.0, -1.0 / 4000.0]);
        tool.hand.force = pull;
        tool.hand.damping = 15.0;
        let law = ContactLaw::spring(4000.0).rough(0.3, 2000.0);
        let scene = WorldScene {
            joints: Vec::new(),
            fields: Vec::new(),
            devices: vec![tool],
            bodies: vec![half_space([0.0, 0.0, 1.0], 0.0)],
            pairs: vec![pair(Member::Device(0), Member::Body(0), law)],
        };
        let ideal = solve(&scene, 0.01, 80);
        let end = ideal.states.last().unwrap();
        let device = &end.devices[0];
        let [fx, fy] = [device.force[0], device.force[1]];
        if sticks {
            for (position, force) in device.position.iter().zip(pull).take(2) {
                assert!((position - force / 2000.0).abs() < 1e-8);
            }
            assert!((fx + 0.08).abs() < 1e-4 && (fy + 0.1).abs() < 1e-4);
        } else {
            // Against the motion, of the size μ N; the damper takes the rest: b v = 0.5 − 0.3.
            assert!((fx.hypot(fy) - 0.3).abs() < 1e-9);
            assert!((fx / fy - 4.0 / 3.0).abs() < 1e-6);
            let speed = device.velocity[0].hypot(device.velocity[1]);
            assert!((speed - 0.2 / 15.0).abs() < 1e-6, "{speed}");
        }
        let balance = end.ledger.balance() - ideal.states[0].ledger.balance();
        assert!(balance.abs() < 1e-11, "{balance}");
    }
}
