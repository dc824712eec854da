//! Scenes, and a deliberately plain numerical integration to compare closed forms with.

use palpate_testbed::device::{DevicePlant, PointMass};
use palpate_testbed::ideal::{Ideal, PointMassScene};
use palpate_testbed::profile::{ForceProfile, Snapshot};

/// A block falls onto a device of its own mass that a hand pushes up.
pub const FALLING_BLOCK: PointMassScene = PointMassScene {
    stiffness: 100.0,
    device_mass: 0.1,
    object_mass: 0.1,
    user_force: 0.981,
    virtual_force: -0.981,
    device_position: 0.0,
    device_velocity: 0.0,
    object_position: 0.1,
    object_velocity: 0.0,
};

/// A heavier device at a lower rate.
pub const HEAVY_DEVICE: PointMassScene = PointMassScene {
    device_mass: 0.25,
    user_force: 1.0,
    object_position: 0.05,
    ..FALLING_BLOCK
};

/// The same with a contact four times as stiff.
pub const STIFF_CONTACT: PointMassScene = PointMassScene {
    stiffness: 400.0,
    ..HEAVY_DEVICE
};

/// A device pushed against a wall.
pub const WALL: PointMassScene = PointMassScene {
    stiffness: 900.0,
    device_mass: 0.3,
    object_mass: f64::INFINITY,
    user_force: 1.3,
    virtual_force: -5.0,
    device_position: -0.01,
    device_velocity: 0.2,
    object_position: 0.02,
    object_velocity: 0.0,
};

/// Forces that pull apart: one collision, then none.
pub const REPELLED: PointMassScene = PointMassScene {
    user_force: -0.4,
    virtual_force: 0.3,
    device_velocity: 1.5,
    object_velocity: -0.2,
    ..FALLING_BLOCK
};

/// No forces at all.
pub const COASTING: PointMassScene = PointMassScene {
    user_force: 0.0,
    virtual_force: 0.0,
    device_velocity: 0.7,
    ..FALLING_BLOCK
};

/// Device and object begin inside each other, one moving in.
pub const BEGINS_INSIDE: PointMassScene = PointMassScene {
    object_position: -0.015,
    device_velocity: 0.3,
    object_velocity: -0.1,
    ..HEAVY_DEVICE
};

pub const ALL_SCENES: [(&str, PointMassScene); 7] = [
    ("falling block", FALLING_BLOCK),
    ("heavy device", HEAVY_DEVICE),
    ("stiff contact", STIFF_CONTACT),
    ("wall", WALL),
    ("repelled", REPELLED),
    ("coasting", COASTING),
    ("begins inside", BEGINS_INSIDE),
];

/// Velocity Verlet with a small fixed step, recorded every `every` steps.
pub fn verlet(scene: &PointMassScene, step: f64, every: usize, records: usize) -> Vec<Snapshot> {
    let force = |xi: f64, eta: f64| scene.stiffness * (xi - eta).max(0.0);
    let (mut xi, mut u) = (scene.device_position, scene.device_velocity);
    let (mut eta, mut w) = (scene.object_position, scene.object_velocity);
    let mut f = force(xi, eta);
    let mut recorded = Vec::with_capacity(records + 1);
    for i in 0..=records * every {
        if i % every == 0 {
            recorded.push(Snapshot {
                time: i as f64 * step,
                device_position: xi,
                device_velocity: u,
                object_position: eta,
                object_velocity: w,
                force_on_object: f,
            });
        }
        u += 0.5 * step * (scene.user_force - f) / scene.device_mass;
        w += 0.5 * step * (scene.virtual_force + f) / scene.object_mass;
        xi += step * u;
        eta += step * w;
        f = force(xi, eta);
        u += 0.5 * step * (scene.user_force - f) / scene.device_mass;
        w += 0.5 * step * (scene.virtual_force + f) / scene.object_mass;
    }
    recorded
}

/// Composite Simpson rule on an even number of equal pieces.
pub fn simpson(from: f64, to: f64, pieces: u32, f: impl Fn(f64) -> f64) -> f64 {
    let h = (to - from) / f64::from(pieces);
    let inner: f64 = (1..pieces)
        .map(|i| {
            let weight = if i % 2 == 1 { 4.0 } else { 2.0 };
            weight * f(from + f64::from(i) * h)
        })
        .sum();
    h / 3.0 * (f(from) + inner + f(to))
}

/// The midpoint rule: robust to kinks and edges of the integrand.
pub fn midpoint(from: f64, to: f64, pieces: u32, f: impl Fn(f64) -> f64) -> f64 {
    let h = (to - from) / f64::from(pieces);
    h * (0..pieces)
        .map(|i| f(from + (f64::from(i) + 0.5) * h))
        .sum::<f64>()
}

#[track_caller]
pub fn assert_close(what: &str, given: f64, expected: f64, tolerance: f64) {
    assert!(
        (given - expected).abs() <= tolerance,
        "{what}: {given} differs from {expected} by {:e}",
        (given - expected).abs()
    );
}

/// Name, scene, period, collisions in the window, hold bound in percent.
pub const PAPER: [(&str, PointMassScene, f64, usize, f64); 3] = [
    ("falling block", FALLING_BLOCK, 0.01, 3, 11.03),
    ("heavy device", HEAVY_DEVICE, 0.02, 3, 17.32),
    ("stiff contact", STIFF_CONTACT, 0.02, 6, 35.01),
];

pub fn windowed(scene: PointMassScene, period: f64, collisions: usize) -> (Ideal, ForceProfile) {
    let ideal = Ideal::new(scene).unwrap();
    let window = ideal.window(collisions, period).unwrap();
    (ideal, ideal.profile(period, window).unwrap())
}

/// A loop that holds the spring's force as sampled, plus a damper on the relative velocity, against
/// an object integrated with that same held force. A negative damper drives it unstable.
pub fn spring_loop(ideal: &Ideal, profile: &ForceProfile, damping: f64) -> Vec<Snapshot> {
    let scene = ideal.scene();
    let period = profile.period();
    let mut device = PointMass::new(scene.device_mass, scene.user_force)
        .and_then(|device| device.starting_at(scene.device_position, scene.device_velocity))
        .unwrap();
    let mut object = PointMass::new(scene.object_mass.min(1e30), scene.virtual_force)
        .and_then(|object| object.starting_at(scene.object_position, scene.object_velocity))
        .unwrap();
    (0..=profile.intervals())
        .map(|i| {
            let p = device.position() - object.position();
            let force = if p > 0.0 {
                scene.stiffness * p + damping * (device.velocity() - object.velocity())
            } else {
                0.0
            };
            let now = Snapshot {
                time: i as f64 * period,
                device_position: device.position(),
                device_velocity: device.velocity(),
                object_position: object.position(),
                object_velocity: object.velocity(),
                force_on_object: force,
            };
            device.advance(force, period);
            object.advance(-force, period);
            now
        })
        .collect()
}

/// The record of a loop that behaves like the ideal itself.
pub fn ideal_loop(ideal: &Ideal, profile: &ForceProfile) -> Vec<Snapshot> {
    let mut held: Vec<f64> = profile.mean_forces().collect();
    held.push(0.0);
    held.iter()
        .enumerate()
        .map(|(i, &force_on_object)| Snapshot {
            force_on_object,
            ..ideal.at(i as f64 * profile.period())
        })
        .collect()
}
