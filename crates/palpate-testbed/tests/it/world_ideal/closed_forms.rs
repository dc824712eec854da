//! Motions that are known on paper.

use palpate_testbed::hand::Sinusoid;
use palpate_testbed::world::{ContactLaw, Member, Shape, WorldBody, WorldScene};

use super::{body, device, half_space, motion, pair, solve};

/// A mass hits a spring with a damper that cannot pull: p = (v/ω) e^(−δ t) sin ω t until K p + B p′ = 0.
#[test]
fn a_damped_bounce_ends_where_its_force_is_zero() {
    let (mass, stiffness, speed) = (0.2, 3000.0, 0.7);
    for damping in [0.5, 4.0, 20.0] {
        let mut device = device(mass, [0.0, 0.0, 0.01]);
        device.velocity[2] = -speed;
        let scene = WorldScene {
            joints: Vec::new(),
            fields: Vec::new(),
            devices: vec![device],
            bodies: vec![half_space([0.0, 0.0, 1.0], 0.0)],
            pairs: vec![pair(
                Member::Device(0),
                Member::Body(0),
                ContactLaw::spring(stiffness).damped(damping),
            )],
        };
        let ideal = solve(&scene, 0.01, 10);
        let delta = damping / (2.0 * mass);
        let omega = (stiffness / mass - delta * delta).sqrt();
        // K sin + B (ω cos − δ sin) = 0
        let end = (-damping * omega).atan2(stiffness - damping * delta) / omega
            + std::f64::consts::PI / omega;
        let decay = (-delta * end).exp();
        let out = -speed * decay * ((omega * end).cos() - delta / omega * (omega * end).sin());
        let state = ideal.states.last().unwrap();
        assert!((state.devices[0].velocity[2] - out).abs() < 1e-10);
        let [encounter] = &ideal.encounters[..] else {
            panic!("one contact");
        };
        let impulse = mass * (speed + out);
        assert!((encounter.normal_impulse - impulse).abs() < 1e-11);
        let lost = 0.5 * mass * (speed * speed - out * out);
        assert!((encounter.dissipated - lost).abs() < 1e-11);
        // Its geometry ends later, when the surfaces part.
        let depth = speed / omega * decay * (omega * end).sin();
        let parted = 0.01 / speed + end + depth / out;
        assert!((encounter.end.unwrap() - parted).abs() < 1e-10);
        println!("B = {damping} N s/m: {speed} m/s in, {out:.4} m/s out");
    }
}

/// m x″ + b x′ + k x = A sin ω t, far from any contact.
#[test]
fn a_hand_with_a_tremor_moves_its_device_as_a_driven_oscillator() {
    let (k, b) = (60.0_f64, 1.5);
    let tremor = Sinusoid {
        amplitude: 0.1,
        frequency_hz: 9.0,
        phase: 0.4,
    };
    let mut device = device(0.25, [0.01, 0.0, 0.02]);
    device.mass = [0.1, 0.16, 0.25];
    device.hand.stiffness = k;
    device.hand.damping = b;
    device.hand.rest = [0.0, 0.0, 0.01];
    device.hand.force = [0.0, 0.0, 0.3];
    device.hand.tremor = [vec![tremor], vec![], vec![tremor, tremor]];
    let masses = device.mass;
    let scene = WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        devices: vec![device],
        ..WorldScene::default()
    };
    let ideal = solve(&scene, 0.01, 40);
    let w = std::f64::consts::TAU * 9.0;
    for (axis, sines, start, push) in [(0, 1.0, 0.01, 0.0), (2, 2.0, 0.01 - 0.3 / k, 0.3)] {
        let m: f64 = masses[axis];
        let (real, imaginary) = (k - m * w * w, b * w);
        let amplitude = sines * 0.1 / real.hypot(imaginary);
        let lag = imaginary.atan2(real);
        let forced = |t: f64| amplitude * (w * t + 0.4 - lag).sin();
        let forced_rate = |t: f64| amplitude * w * (w * t + 0.4 - lag).cos();
        let delta = b / (2.0 * m);
        let own = (k / m - delta * delta).sqrt();
        let from = start - forced(0.0);
        let across = (-forced_rate(0.0) + delta * from) / own;
        let rest = push / k + if axis == 2 { 0.01 } else { 0.0 };
        for state in &ideal.states {
            let t = state.time;
            let free = (-delta * t).exp() * (from * (own * t).cos() + across * (own * t).sin());
            let expected = rest + free + forced(t);
            assert!((state.devices[0].position[axis] - expected).abs() < 1e-11);
        }
    }
    assert_eq!(ideal.devices[0].impulses[7], [0.0; 3]);
}

/// A body that is symmetrical about its z axis and turns freely nods at the rate L/I.
#[test]
fn a_free_top_precesses_about_its_angular_momentum() {
    let shape = Shape::Cylinder {
        radius: 0.03,
        half_length: 0.01,
    };
    let mut top = body(shape.clone(), 0.2, [0.0; 3]);
    let turning = [2.0, 0.0, 30.0];
    motion(&mut top).angular_velocity = turning;
    let inertia = shape.inertia(0.2);
    let scene = WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        bodies: vec![top],
        ..WorldScene::default()
    };
    let ideal = solve(&scene, 0.01, 50);
    let momentum: [f64; 3] = std::array::from_fn(|i| inertia[i] * turning[i]);
    let length = momentum[0].hypot(momentum[2]);
    let rate = length / inertia[0];
    for state in &ideal.states {
        let body = &state.bodies[0];
        for (kept, at_start) in body.angular_momentum.iter().zip(momentum) {
            assert!((kept - at_start).abs() < 1e-15);
        }
        // The body's axis goes round L; its part along y is sin(angle) sin(rate t).
        let [w, x, y, z] = body.orientation;
        let axis = [2.0 * (x * z + w * y), 2.0 * (y * z - w * x)];
        let tilt = momentum[0] / length;
        let expected = tilt * (rate * state.time).sin();
        // It starts along z, so with L along x and z it goes out towards −y first.
        assert!((axis[1] + expected).abs() < 1e-9, "{axis:?} {expected}");
    }
}

/// A light body pressed by its weight into the ground sinks by F/K, whatever its shape.
#[test]
fn a_box_that_lies_flat_has_the_whole_law() {
    let shape = Shape::Box {
        half_extents: [0.02, 0.03, 0.01],
    };
    let mut block = body(shape, 0.05, [0.0, 0.0, 0.01 - 0.4905 / 2000.0]);
    motion(&mut block).force[2] = -0.4905;
    let scene = WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        bodies: vec![block, half_space([0.0, 0.0, 1.0], 0.0)],
        pairs: vec![pair(
            Member::Body(0),
            Member::Body(1),
            ContactLaw::spring(2000.0).damped(1.0),
        )],
        ..WorldScene::default()
    };
    let ideal = solve(&scene, 0.01, 20);
    let state = ideal.states.last().unwrap();
    assert!((state.bodies[0].position[2] - 0.01 + 0.4905 / 2000.0).abs() < 1e-12);
    let held: f64 = state
        .contacts
        .iter()
        .map(|contact| contact.normal_force)
        .sum();
    assert!((held - 0.4905).abs() < 1e-9);
    assert_eq!(ideal.encounters.len(), 4);
}

/// A point that is thrown at a plane and pulled back touches it for 0.9 ms, far shorter than a free step.
#[test]
fn a_graze_within_one_step_is_seen() {
    let (mass, pull, depth, turn) = (0.1, 1.0, 1e-6, 0.053);
    let acceleration: f64 = pull / mass;
    let mut tool = device(mass, [0.0, 0.0, 0.5 * acceleration * turn * turn - depth]);
    tool.velocity[2] = -acceleration * turn;
    tool.hand.force[2] = pull;
    let scene = WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        devices: vec![tool],
        bodies: vec![half_space([0.0, 0.0, 1.0], 0.0)],
        // So soft that it changes nothing of the parabola.
        pairs: vec![pair(
            Member::Device(0),
            Member::Body(0),
            ContactLaw::spring(1.0),
        )],
    };
    let ideal = solve(&scene, 0.02, 5);
    let [graze] = &ideal.encounters[..] else {
        panic!("{} contacts in place of one", ideal.encounters.len());
    };
    let half = (2.0 * depth / acceleration).sqrt();
    assert!((graze.start - (turn - half)).abs() < 1e-8);
    assert!((graze.end.unwrap() - (turn + half)).abs() < 1e-8);
    assert!((graze.normal_impulse / (4.0 / 3.0 * depth * half) - 1.0).abs() < 1e-3);
    println!("{} steps", ideal.steps);
}

/// A point in a box is pushed out through the nearest face; where two are equally near, the force changes at once.
#[test]
fn a_point_in_a_box_leaves_it_through_the_nearest_face() {
    let block = Shape::Box {
        half_extents: [0.01, 0.02, 0.01],
    };
    let mut fixed = body(block, 1.0, [0.0; 3]);
    fixed.motion = None;
    let mut tool = device(0.1, [0.009, 0.0, 0.0085]);
    tool.velocity[2] = 0.05;
    let law = ContactLaw::spring(1.0);
    let scene = WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        devices: vec![tool],
        bodies: vec![fixed],
        pairs: vec![pair(Member::Device(0), Member::Body(0), law)],
    };
    let ideal = solve(&scene, 0.001, 40);
    let force = |index: usize| ideal.states[index].devices[0].force;
    // 1 mm below the side and 1.5 mm below the top; after 10 ms it is nearer to the top.
    assert!((force(9)[0] - 1e-3).abs() < 1e-5 && force(9)[2] == 0.0);
    assert!((force(11)[2] - 0.95e-3).abs() < 1e-5 && force(11)[0] == 0.0);
    let [encounter] = &ideal.encounters[..] else {
        panic!("one contact, whatever the face");
    };
    assert!((encounter.end.unwrap() - 0.03).abs() < 1e-4);
    let start = ideal.states[0].ledger.balance();
    let change = ideal.states.last().unwrap().ledger.balance() - start;
    // p is the same on both sides of the change, so no energy comes or goes.
    assert!(change.abs() < 1e-15);
}

/// A half-space lies in the axes of its body: one that stands turned about at a place is one with another normal and
/// offset.
#[test]
fn a_half_space_lies_where_its_body_does() {
    // A turn of 60 degrees about an axis between x and y: z points to (s, -s, 1/2) with s = sin 60°/√2.
    let half = (std::f64::consts::PI / 6.0).sin() / 2.0_f64.sqrt();
    let orientation = [(std::f64::consts::PI / 6.0).cos(), half, half, 0.0];
    let s = (std::f64::consts::PI / 3.0).sin() / 2.0_f64.sqrt();
    let normal = [s, -s, 0.5];
    let position = [0.03, -0.01, 0.02];
    let along = normal.iter().zip(position).map(|(n, x)| n * x).sum::<f64>();
    let placed = WorldBody {
        position,
        orientation,
        ..half_space([0.0, 0.0, 1.0], 0.004)
    };
    let law = ContactLaw::spring(2000.0).damped(1.0).rough(0.4, 1000.0);
    let [of_pose, of_normal] = [placed, half_space(normal, along + 0.004)].map(|plane| {
        let mut tool = device(0.2, [0.0; 3]);
        // 2 mm above the surface, at rest.
        tool.position = [0, 1, 2].map(|axis| (along + 0.006) * normal[axis]);
        tool.hand.force = [0.0, 0.0, -3.0];
        let mut block = body(
            Shape::Box {
                half_extents: [0.01, 0.015, 0.005],
            },
            0.1,
            [0, 1, 2].map(|axis| (along + 0.0089) * normal[axis] + 0.1 * [0.5, 0.5, 0.0][axis]),
        );
        block.orientation = orientation;
        motion(&mut block).force = [0.0, 0.0, -0.981];
        let scene = WorldScene {
            joints: Vec::new(),
            fields: Vec::new(),
            devices: vec![tool],
            bodies: vec![plane, block],
            pairs: vec![
                pair(Member::Device(0), Member::Body(0), law),
                pair(Member::Body(0), Member::Body(1), law),
            ],
        };
        solve(&scene, 0.01, 20)
    });
    let touched = of_pose.devices[0].impulses.iter().flatten();
    assert!(touched.map(|impulse| impulse.abs()).sum::<f64>() > 0.1);
    for (one, other) in of_pose.states.iter().zip(&of_normal.states) {
        for axis in 0..3 {
            let apart = |one: [f64; 3], other: [f64; 3]| (one[axis] - other[axis]).abs();
            assert!(apart(one.devices[0].position, other.devices[0].position) < 1e-12);
            assert!(apart(one.bodies[1].position, other.bodies[1].position) < 1e-12);
        }
    }
}
