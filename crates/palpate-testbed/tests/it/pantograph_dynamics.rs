//! The links' motion: against a Lagrangian worked out by differences, and against its energy.

use palpate_testbed::device::DevicePlant;
use palpate_testbed::pantograph::{
    Actuation, Dynamics, Geometry, Link, Pantograph, PantographParams,
};

fn deg(angles: [f64; 2]) -> [f64; 2] {
    angles.map(f64::to_radians)
}

/// Four different links, so that nothing cancels by symmetry.
fn lopsided() -> PantographParams {
    let link = |mass, centre, inertia| Link {
        mass,
        centre,
        inertia,
    };
    PantographParams {
        proximal: [link(0.03, 0.4, 2e-5), link(0.05, 0.6, 1e-5)],
        distal: [link(0.02, 0.3, 3e-5), link(0.04, 0.7, 4e-5)],
        rotor_inertia: 5e-6,
        end_point_mass: 0.07,
        gravity: [0.8, -2.0],
        actuation: Actuation::Ideal,
        counts_per_rev: None,
        ..crate::pantographs::haply(3).frictionless()
    }
}

/// Derivative at 0 by differences of order 4.
fn slope(f: impl Fn(f64) -> f64, step: f64) -> f64 {
    (8.0 * (f(step) - f(-step)) - (f(2.0 * step) - f(-2.0 * step))) / (12.0 * step)
}

/// Positions of the five masses and angles of the four links, from circles alone.
fn bodies(p: &PantographParams, angles: [f64; 2]) -> ([[f64; 2]; 5], [f64; 4]) {
    let (l, big, d) = (p.geometry.proximal, p.geometry.distal, p.geometry.base);
    let on = |from: [f64; 2], to: [f64; 2], part: f64| {
        [
            from[0] + part * (to[0] - from[0]),
            from[1] + part * (to[1] - from[1]),
        ]
    };
    let motors = [[0.0, 0.0], [d, 0.0]];
    let elbows = [0, 1].map(|i| {
        [
            motors[i][0] + l * angles[i].cos(),
            motors[i][1] + l * angles[i].sin(),
        ]
    });
    let h = [elbows[1][0] - elbows[0][0], elbows[1][1] - elbows[0][1]];
    let beta = (0.5 * h[0].hypot(h[1]) / big).acos();
    let phi = h[1].atan2(h[0]) + beta;
    let end = [
        elbows[0][0] + big * phi.cos(),
        elbows[0][1] + big * phi.sin(),
    ];
    let other = (end[1] - elbows[1][1]).atan2(end[0] - elbows[1][0]);
    let at = |i: usize, lower: bool| {
        if lower {
            on(elbows[i], end, p.distal[i].centre)
        } else {
            on(motors[i], elbows[i], p.proximal[i].centre)
        }
    };
    (
        [at(0, false), at(1, false), at(0, true), at(1, true), end],
        [angles[0], angles[1], phi, other],
    )
}

fn masses(p: &PantographParams) -> [f64; 5] {
    [
        p.proximal[0].mass,
        p.proximal[1].mass,
        p.distal[0].mass,
        p.distal[1].mass,
        p.end_point_mass,
    ]
}

/// Kinetic energy from the bodies' velocities, by differences along the motion.
fn kinetic(p: &PantographParams, angles: [f64; 2], rates: [f64; 2]) -> f64 {
    let at = |t: f64| bodies(p, [angles[0] + t * rates[0], angles[1] + t * rates[1]]);
    let step = 1e-3;
    let inertias = [
        p.proximal[0].inertia + p.rotor_inertia,
        p.proximal[1].inertia + p.rotor_inertia,
        p.distal[0].inertia,
        p.distal[1].inertia,
    ];
    let mut energy = 0.0;
    for (i, mass) in masses(p).into_iter().enumerate() {
        for k in 0..2 {
            energy += 0.5 * mass * slope(|t| at(t).0[i][k], step).powi(2);
        }
    }
    for (i, inertia) in inertias.into_iter().enumerate() {
        energy += 0.5 * inertia * slope(|t| at(t).1[i], step).powi(2);
    }
    energy
}

fn potential(p: &PantographParams, angles: [f64; 2]) -> f64 {
    let (places, _) = bodies(p, angles);
    -(0..5)
        .map(|i| masses(p)[i] * (places[i][0] * p.gravity[0] + places[i][1] * p.gravity[1]))
        .sum::<f64>()
}

fn along(angles: [f64; 2], i: usize, offset: f64) -> [f64; 2] {
    let mut moved = angles;
    moved[i] += offset;
    moved
}

#[test]
fn the_terms_are_those_of_a_lagrangian_made_of_the_bodies_velocities() {
    let p = lopsided();
    let dynamics = Pantograph::new(p).unwrap().dynamics().to_owned();
    for (angles, rates) in [
        ([130.0, 50.0], [1.0, -0.7]),
        ([168.0, 12.0], [-0.3, 0.9]),
        ([90.0, -20.0], [0.8, 0.6]),
        ([210.0, 120.0], [-0.5, -1.0]),
    ] {
        let angles = deg(angles);
        let pose = p.geometry.forward(angles).unwrap();
        let direct = dynamics.kinetic_energy(&pose, rates);
        let independent = kinetic(&p, angles, rates);
        assert!((direct - independent).abs() < 1e-8 * direct);

        // M from energies: T is a quadratic form of the rates.
        let mass = dynamics.mass_matrix(&pose);
        let sum = kinetic(&p, angles, [1.0, 1.0]);
        let (first, second) = (
            kinetic(&p, angles, [1.0, 0.0]),
            kinetic(&p, angles, [0.0, 1.0]),
        );
        for (value, expected) in [
            (mass[0][0], 2.0 * first),
            (mass[1][1], 2.0 * second),
            (mass[0][1], sum - first - second),
            (mass[1][0], sum - first - second),
        ] {
            assert!(
                (value - expected).abs() < 1e-8 * mass[0][0],
                "{value} {expected}"
            );
        }

        // Without acceleration, d/dt ∂T/∂θ′ − ∂T/∂θ is the Coriolis torque.
        let coriolis = dynamics.coriolis(&pose, rates);
        let gravity = dynamics.gravity_torques(&pose);
        for i in 0..2 {
            let momentum = |t: f64| {
                let moved = [angles[0] + t * rates[0], angles[1] + t * rates[1]];
                slope(|e| kinetic(&p, moved, along(rates, i, e)), 0.1)
            };
            let expected =
                slope(momentum, 2e-3) - slope(|e| kinetic(&p, along(angles, i, e), rates), 2e-3);
            assert!(
                (coriolis[i] - expected).abs() < 1e-6 * direct,
                "{coriolis:?} {expected}"
            );
            let pull = -slope(|e| potential(&p, along(angles, i, e)), 1e-3);
            assert!((gravity[i] - pull).abs() < 1e-9, "{gravity:?} {pull}");
        }
    }
}

#[test]
fn a_short_motion_has_the_accelerations_of_the_equation() {
    let p = lopsided();
    let (angles, rates, force) = (deg([120.0, 40.0]), [1.5, -0.5], [0.4, -1.1]);
    let device = Pantograph::new(p)
        .and_then(|device| device.with_user_force(force))
        .and_then(|device| device.starting_at(angles, rates))
        .unwrap();
    let pose = *device.pose();
    let dynamics: &Dynamics = device.dynamics();
    let (m, c, g) = (
        dynamics.mass_matrix(&pose),
        dynamics.coriolis(&pose, rates),
        dynamics.gravity_torques(&pose),
    );
    // 0.3 N on the device along −y beside the user's force.
    let external = pose.torques([force[0], force[1] - 0.3]);
    let step = 1e-5;
    let mut moved = device;
    moved.advance(0.3, step);
    let mid = [0, 1].map(|i| (moved.rates()[i] - rates[i]) / step);
    for i in 0..2 {
        let left = m[i][0] * mid[0] + m[i][1] * mid[1] + c[i];
        let right = external[i] + g[i];
        assert!((left - right).abs() < 1e-3 * right.abs(), "{left} {right}");
    }
}

#[test]
fn motion_without_torque_and_friction_conserves_its_energy_for_ten_seconds() {
    // Free arms meet at the elbows before long, where the model ends. The first two motions do not
    // within ten seconds; motors further apart than 2l keep the others from it for good.
    let wide = PantographParams {
        geometry: Geometry::new(0.05, 0.12, 0.11).unwrap(),
        ..lopsided()
    };
    let flat = PantographParams {
        gravity: [0.0, 0.0],
        ..wide
    };
    let paper = crate::pantographs::desktop();
    for (name, params, rates) in [
        ("paper", paper, [1.0, 1.4]),
        ("paper, round and round", paper, [3.0, 3.0]),
        ("wide", flat, [12.0, -7.0]),
        ("wide, gravity", wide, [5.0, 9.0]),
    ] {
        let mut device = Pantograph::new(params.frictionless())
            .and_then(|device| device.starting_at(deg([130.0, 50.0]), rates))
            .unwrap();
        let start = device.stored_energy();
        let kinetic = |device: &Pantograph| {
            device
                .dynamics()
                .kinetic_energy(device.pose(), device.rates())
        };
        let scale = kinetic(&device);
        let (mut worst, mut least, mut most) = (0.0_f64, f64::INFINITY, 0.0_f64);
        for _ in 0..10_000 {
            device.advance(0.0, 1e-3);
            worst = worst.max((device.stored_energy() - start).abs() / scale);
            let fast = device.rates()[0].abs();
            (least, most) = (least.min(fast), most.max(fast));
        }
        assert!(!device.is_jammed(), "{name}");
        assert!(worst < 1e-9, "{name} {worst:e}");
        // The energy went to and fro between the joints.
        assert!(most > 1.2 * least, "{name} {least} {most}");
    }
}

#[test]
fn what_leaves_the_store_of_an_ideal_drive_went_through_the_port() {
    let mut device = Pantograph::new(lopsided())
        .and_then(|device| device.with_user_force([0.1, 0.9]))
        .and_then(|device| device.starting_at(deg([130.0, 50.0]), [0.5, -0.3]))
        .unwrap();
    for force in [0.0, 2.0, -1.5, 3.0] {
        let before = device.stored_energy();
        let work = device.advance(force, 0.013);
        let change = before - device.stored_energy();
        assert!((change - work).abs() < 1e-12, "{change} {work}");
        assert!(force == 0.0 || work.abs() > 1e-5);
    }
}

#[test]
fn one_long_step_equals_many_short_ones() {
    let device = Pantograph::new(lopsided())
        .and_then(|device| device.starting_at(deg([130.0, 50.0]), [3.0, -2.0]))
        .unwrap();
    let (mut long, mut short) = (device, device);
    long.advance(0.5, 0.1);
    for _ in 0..10_000 {
        short.advance(0.5, 1e-5);
    }
    for i in 0..2 {
        assert!((long.end_point()[i] - short.end_point()[i]).abs() < 1e-11);
        assert!((long.rates()[i] - short.rates()[i]).abs() < 1e-9);
    }
}

#[test]
fn the_effective_mass_is_the_force_over_the_acceleration() {
    let params = PantographParams {
        actuation: Actuation::Ideal,
        ..crate::pantographs::desktop().frictionless()
    };
    let mut device = Pantograph::new(params).unwrap();
    let mass = device.effective_mass_y();
    assert!((mass - 0.25).abs() < 0.02 * 0.25, "{mass}");
    device.advance(-1.0, 1e-4);
    let acceleration = device.velocity() / 1e-4;
    assert!((acceleration * mass - 1.0).abs() < 1e-4, "{acceleration}");
    // It depends on the pose.
    let elsewhere = device.starting_at(deg([110.0, 60.0]), [0.0, 0.0]).unwrap();
    assert!((elsewhere.effective_mass_y() / mass - 1.0).abs() > 0.05);
}

#[test]
fn running_into_a_singular_pose_jams_and_loses_its_energy() {
    // Both motors on one axis: equal angles put elbow on elbow.
    let mut device = Pantograph::new(crate::pantographs::haply(2).frictionless())
        .and_then(|device| device.starting_at(deg([100.0, 80.0]), [-2.0, 2.0]))
        .unwrap();
    let start = device.stored_energy();
    for _ in 0..2000 {
        device.advance(0.0, 1e-3);
        assert!(device.position().is_finite() && device.velocity().is_finite());
        assert!(device.stored_energy() <= start * (1.0 + 1e-6));
    }
    assert!(device.is_jammed());
    assert!((device.dissipated() / start - 1.0).abs() < 1e-6);
    assert_eq!(device.stored_energy(), 0.0);
    assert_eq!(device.advance(1.0, 1e-3), 0.0);
    assert!(
        !device
            .starting_at(deg([100.0, 80.0]), [0.0, 0.0])
            .unwrap()
            .is_jammed()
    );
}

#[test]
fn arms_without_distal_mass_do_not_slip_through_meeting_elbows() {
    // Nothing of the distal links shows in the accelerations here, so only their jump tells.
    let light = Link::rod(0.0, 0.09);
    let params = PantographParams {
        distal: [light; 2],
        end_point_mass: 0.0,
        ..crate::pantographs::haply(2).frictionless()
    };
    let mut device = Pantograph::new(params)
        .and_then(|device| device.starting_at(deg([100.0, 80.0]), [-2.0, 2.0]))
        .unwrap();
    device.advance(0.0, 0.2);
    assert!(device.is_jammed());
    let [first, second] = device.pose().angles;
    assert!(first > second && first - second < 1e-5);
}
