//! A device of six axes in a pointer's hand.

use palpate_device::clock::SteppedClock;
use palpate_scene::world::WorldFile;

use super::*;

const PLATE: &str = r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "tool"
mass_kg = 0.15
inertia_kg_m2 = [1e-4, 2e-4, 3e-4]
quantum_rad = 1e-5
tool = { box = { size_m = [0.06, 0.04, 0.03] } }
[[body]]
name = "floor"
fixed = true
shape = { half_space = { normal = [0.0, 0.0, 1.0], offset_m = -1.0 } }
[[contact]]
between = "*"
stiffness_n_per_m = 1000.0
"#;

fn apart(one: [f64; 4], other: [f64; 4]) -> f64 {
    let cosine: f64 = one.iter().zip(other).map(|(a, b)| a * b).sum();
    2.0 * cosine.abs().min(1.0).acos()
}

/// The hand turns the device, gives way to a torque, and lets it turn on when it lets go; the device takes a torque off
/// when it is cut.
#[test]
fn a_pointer_s_hand_turns_a_device_of_six_axes() {
    let scene = WorldFile::parse("plate.toml", PLATE).unwrap().scene;
    let clock = SteppedClock::new();
    let hand = SpatialHand::at([0.0; 3]);
    let actuator = &scene.timing.actuator;
    let mut device =
        SpatialPointer::new(&scene.devices[0], actuator, &hand, clock.clone()).unwrap();
    assert_eq!(device.capabilities().torque_axes, 3);
    let mut run = |torque: Vector, millis: u32| {
        let mut pose = device.read().unwrap();
        for _ in 0..millis {
            let wrench = Wrench {
                torque,
                ..Wrench::NONE
            };
            assert_eq!(device.write(wrench).unwrap().torque, torque);
            clock.sleep_until(clock.now() + Duration::from_millis(1));
            pose = device.read().unwrap();
        }
        pose.orientation.unwrap()
    };
    let start = [1.0, 0.0, 0.0, 0.0];
    assert!(
        apart(run([0.0; 3], 100), start) < 1e-4,
        "it stays as it begins"
    );
    let aim = [0.2_f64.cos(), 0.0, 0.2_f64.sin(), 0.0];
    hand.turn_to(aim.map(|part| 3.0 * part));
    assert!(apart(hand.orientation().unwrap(), aim) < 1e-7);
    assert!(apart(run([0.0; 3], 600), aim) < 1e-3, "it is turned");
    // A torque of 0.03 N m against 0.3 N m/rad.
    let pushed = apart(run([0.0, 0.03, 0.0], 600), aim);
    assert!((pushed - 0.1).abs() < 1e-3, "{pushed}");
    hand.turn_to([0.0; 4]);
    hand.turn_to([f64::NAN; 4]);
    assert!(
        apart(hand.orientation().unwrap(), aim) < 1e-7,
        "no direction"
    );
    hand.turn_back();
    assert!(apart(run([0.0; 3], 600), start) < 1e-3, "it is turned back");
    hand.let_go();
    let free = apart(run([0.0, 0.03, 0.0], 200), start);
    assert!(free > 0.3, "nobody holds it: {free}");
}
