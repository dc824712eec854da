//! Six-axis devices, and devices with their own axes, in a hand.

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

/// Creates a device with these moments of inertia in its hand, on a clock that the test advances.
fn turned_by_a_hand(
    inertia: &str,
    hand: &SpatialHand,
) -> (SpatialPointer<SteppedClock>, SteppedClock) {
    let text = PLATE.replace("[1e-4, 2e-4, 3e-4]", inertia);
    let scene = WorldFile::parse("plate.toml", &text).unwrap().scene;
    let clock = SteppedClock::new();
    let device = SpatialPointer::new(&scene, 0, hand, clock.clone()).unwrap();
    (device, clock)
}

/// Returns the orientations after each of a number of milliseconds, under a torque.
fn turns(
    device: &mut SpatialPointer<SteppedClock>,
    clock: &SteppedClock,
    torque: Vector,
    millis: u32,
) -> Vec<[f64; 4]> {
    let wrench = Wrench {
        torque,
        ..Wrench::NONE
    };
    let tick = |_| {
        device.write(wrench).unwrap();
        clock.sleep_until(clock.now() + Duration::from_millis(1));
        device.read().unwrap().orientation.unwrap()
    };
    (0..millis).map(tick).collect()
}

/// A hand that grips the device again starts from its present orientation and turns it to the target from there.
#[test]
fn a_hand_takes_hold_of_a_turned_device_without_a_jolt() {
    let hand = SpatialHand::at([0.0; 3]);
    let (mut device, clock) = turned_by_a_hand("[1e-4, 2e-4, 3e-4]", &hand);
    turns(&mut device, &clock, [0.0; 3], 10);
    hand.disable_output();
    // Start to turn; the hand's damping then nearly stops the motion.
    turns(&mut device, &clock, [0.0, 0.03, 0.0], 200);
    let left = *turns(&mut device, &clock, [0.0; 3], 300).last().unwrap();
    let wish = [1.0, 0.0, 0.0, 0.0];
    assert!(apart(left, wish) > 0.3, "{left:?}");
    hand.move_to([0.0; 3]);
    let mut from = left;
    let mut fastest = 0.0_f64;
    let led = turns(&mut device, &clock, [0.0; 3], 600);
    for (tick, orientation) in led.iter().enumerate() {
        let step = apart(*orientation, from);
        fastest = fastest.max(step);
        // A spring of 0.3 N m/rad that was relaxed elsewhere would turn it by 0.75 mrad in the first one.
        assert!(tick > 0 || step < 2e-4, "{step} rad at once");
        from = *orientation;
    }
    assert!(apart(from, wish) < 0.02, "led to the wish: {from:?}");
    assert!(fastest < 0.03, "{fastest} rad in a millisecond");
}

/// A pen turns about its length a thousand times more easily than about the other axes. The hand is then softer, and
/// the device comes to rest.
#[test]
fn a_slender_device_comes_to_rest_in_its_hand() {
    let hand = SpatialHand::at([0.0; 3]);
    let (mut device, clock) = turned_by_a_hand("[1e-4, 1e-4, 1.4e-7]", &hand);
    let start = *turns(&mut device, &clock, [0.0; 3], 10).last().unwrap();
    turns(&mut device, &clock, [0.01, 0.0, 0.002], 50);
    let rested = turns(&mut device, &clock, [0.0; 3], 2000);
    let away = apart(*rested.last().unwrap(), start);
    assert!(away < 1e-3, "{away} rad from where it began");
}

/// After a pause of a minute the device soon comes to rest.
#[test]
fn a_long_pause_is_caught_up_in_part() {
    let hand = SpatialHand::at([0.0; 3]);
    let (mut device, clock) = turned_by_a_hand("[1e-4, 2e-4, 3e-4]", &hand);
    let aim = [0.2_f64.cos(), 0.0, 0.2_f64.sin(), 0.0];
    turns(&mut device, &clock, [0.0; 3], 10);
    hand.turn_to(aim);
    clock.advance(Duration::from_secs(3600));
    let after = turns(&mut device, &clock, [0.0; 3], 5);
    assert!(apart(*after.last().unwrap(), aim) < 1e-3, "{after:?}");
}

/// A hand that turns its device faster than a loop can follow is refused with the reason.
#[test]
fn a_hand_too_stiff_for_its_device_is_refused() {
    let hand = "inertia_kg_m2 = [1e-4, 1e-4, 1e-9]\nhand.rotational_stiffness_n_m_per_rad = 2.0";
    let text = PLATE.replace("inertia_kg_m2 = [1e-4, 2e-4, 3e-4]", hand);
    let scene = WorldFile::parse("plate.toml", &text).unwrap().scene;
    let clock = SteppedClock::new();
    let simulated = SpatialDevice::new(&scene, 0, clock.clone()).unwrap_err();
    let hand = SpatialHand::at([0.0; 3]);
    let pointer = SpatialPointer::new(&scene, 0, &hand, clock).unwrap_err();
    for wrong in [simulated, pointer] {
        let model = wrong.to_string();
        assert!(model.contains("at most 32000 rad/s"), "{model}");
        assert!(
            (wrong.value - 2.2 * 2e9_f64.sqrt()).abs() < 1.0,
            "{}",
            wrong.value
        );
    }
}

/// The hand turns the device and yields to a torque. After its release the device continues to turn. When the output is
/// cut, the device drops the torque.
#[test]
fn a_pointer_s_hand_turns_a_device_of_six_axes() {
    let scene = WorldFile::parse("plate.toml", PLATE).unwrap().scene;
    let clock = SteppedClock::new();
    let hand = SpatialHand::at([0.0; 3]);
    let mut device = SpatialPointer::new(&scene, 0, &hand, clock.clone()).unwrap();
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
    hand.disable_output();
    let free = apart(run([0.0, 0.03, 0.0], 200), start);
    assert!(free > 0.3, "nobody holds it: {free}");
}

/// A point whose mobility has its axes at 2/3, 2/3, 1/3 and so on.
const OBLIQUE: &str = r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "tool"
axes = [[2, 2, 1], [-2, 1, 2], [1, -2, 2]]
mass_kg = [0.1, 0.2, 0.4]
quantum_m = [1e-4, 0.0, 0.0]
position_m = [0.1, 0.2, 0.3]
tool = { sphere = { radius_m = 0.0 } }
[[body]]
name = "floor"
fixed = true
shape = { half_space = { normal = [0.0, 0.0, 1.0], offset_m = -1.0 } }
[[contact]]
between = "*"
stiffness_n_per_m = 1000.0
"#;

#[test]
fn a_force_moves_a_device_with_axes_of_its_own_as_its_mobility_says() {
    let scene = WorldFile::parse("oblique.toml", OBLIQUE).unwrap().scene;
    let own = scene.devices[0].clone();
    let clock = SteppedClock::new();
    let mut device = SpatialDevice::new(&scene, 0, clock.clone()).unwrap();
    device.read().unwrap();
    let force = [0.3, -0.2, 0.5];
    device.write(Wrench::of_force(force)).unwrap();
    clock.sleep_until(clock.now() + Duration::from_millis(100));
    let read = device.read().unwrap().position;
    // x = f t^2/2m along each of its axes.
    let along = own.own(force);
    let way: Vector = [0, 1, 2].map(|axis| 0.5 * along[axis] * 0.01 / own.mass[axis]);
    let way = own.out(way);
    for axis in 0..3 {
        let expected = [0.1, 0.2, 0.3][axis] + way[axis];
        assert!((device.position()[axis] - expected).abs() < 1e-12);
    }
    // The first of its axes is measured in steps.
    let [first, second, third] = own.own(read);
    assert!((first / 1e-4 - (first / 1e-4).round()).abs() < 1e-6);
    let truly = own.own(device.position());
    assert!((first - truly[0]).abs() < 0.6e-4 && (first - truly[0]).abs() > 1e-9);
    assert!((second - truly[1]).abs() < 1e-12 && (third - truly[2]).abs() < 1e-12);
}

#[test]
fn a_pointer_s_hand_leads_a_device_with_axes_of_its_own() {
    let scene = WorldFile::parse("oblique.toml", OBLIQUE).unwrap().scene;
    let clock = SteppedClock::new();
    let hand = SpatialHand::at(scene.devices[0].position);
    let mut device = SpatialPointer::new(&scene, 0, &hand, clock.clone()).unwrap();
    let near = |one: Vector, other: Vector| {
        one.iter()
            .zip(other)
            .all(|(one, other)| (one - other).abs() < 2e-4)
    };
    assert!(near(device.read().unwrap().position, [0.1, 0.2, 0.3]));
    let target = [0.12, 0.19, 0.28];
    hand.move_to(target);
    assert!(near(hand.target().unwrap(), target));
    for _ in 0..2000 {
        device.write(Wrench::NONE).unwrap();
        clock.sleep_until(clock.now() + Duration::from_millis(1));
        device.read().unwrap();
    }
    assert!(near(device.read().unwrap().position, target));
    let sent = device.write(Wrench::of_force([0.3, -0.2, 0.5])).unwrap();
    assert!(near(sent.force, [0.3, -0.2, 0.5]));
}

/// Two devices whose sensors are noisy and whose motors are weak.
const TWO: &str = r#"
format = 2
[loop]
period_s = 0.001
seed = 7
[[device]]
name = "left"
axes = ["z"]
mass_kg = 0.1
position_m = [0.0, 0.0, 0.1]
noise_m = 1e-4
tool = { sphere = { radius_m = 0.0 } }
[[device]]
name = "right"
mass_kg = 0.1
position_m = [0.1, 0.2, 0.3]
noise_m = 1e-4
drivetrain.motor_limit_n = 2.0
drivetrain.viscous_friction_n_s_per_m = 3.0
tool = { sphere = { radius_m = 0.0 } }
[[body]]
name = "floor"
fixed = true
shape = { half_space = { normal = [0.0, 0.0, 1.0], offset_m = -1.0 } }
[[contact]]
between = "*"
stiffness_n_per_m = 1000.0
"#;

/// A device in a loop measures with the noise that its plant has on the bench: the numbers of the scene's seed, each
/// axis of each device with its own. A pointer's device has that noise, too.
#[test]
fn noise_follows_the_seed_and_the_number_of_the_device() {
    let mut first_noises = Vec::new();
    for seed in [7, 8] {
        let text = TWO.replace("seed = 7", &format!("seed = {seed}"));
        let scene = WorldFile::parse("two.toml", &text).unwrap().scene;
        let params = palpate_testbed::world::PlantParams {
            seed,
            ..palpate_testbed::world::PlantParams::perfect(0.001)
        };
        let evaluated = crate::sim::world::as_evaluated(&scene);
        let mut plant = palpate_testbed::world::WorldPlant::new(&evaluated, params).unwrap();
        let expected = plant.measure();
        for (number, expected) in expected.iter().enumerate() {
            let clock = SteppedClock::new();
            let mut device = SpatialDevice::new(&scene, number, clock.clone()).unwrap();
            assert_eq!(device.read().unwrap().position, *expected);
            let hand = SpatialHand::at(scene.devices[number].position);
            let mut device = SpatialPointer::new(&scene, number, &hand, clock).unwrap();
            let read = device.read().unwrap().position;
            let off = |axis: usize| read[axis] - expected[axis];
            assert!((0..3).all(|axis| off(axis).abs() < 1e-12), "{read:?}");
            first_noises.push(expected[2] - scene.devices[number].position[2]);
        }
    }
    assert!(first_noises.iter().all(|noise| *noise != 0.0));
    let is_new = |index: usize| !first_noises[..index].contains(&first_noises[index]);
    assert!((1..4).all(is_new), "{first_noises:?}");
    let scene = WorldFile::parse("two.toml", TWO).unwrap().scene;
    let wrong = SpatialDevice::new(&scene, 2, SteppedClock::new()).unwrap_err();
    assert_eq!((wrong.name, wrong.value), ("device", 2.0));
}

/// A motor holds at most its largest force along each axis, and that is what a device reports.
#[test]
fn the_reported_force_is_the_one_that_a_motor_holds() {
    let scene = WorldFile::parse("two.toml", TWO).unwrap().scene;
    let clock = SteppedClock::new();
    let hand = SpatialHand::at(scene.devices[1].position);
    let devices: [Box<dyn Device>; 2] = [
        Box::new(SpatialDevice::new(&scene, 1, clock.clone()).unwrap()),
        Box::new(SpatialPointer::new(&scene, 1, &hand, clock).unwrap()),
    ];
    for mut device in devices {
        let held = device.write(Wrench::of_force([5.0, -0.5, -3.0])).unwrap();
        assert_eq!(held.force, [2.0, -0.5, -2.0]);
        assert_eq!(device.last_sent().unwrap().wrench.force, held.force);
    }
}

/// A free pointer's device glides in the friction of the scene, which is more than a pointer's own.
#[test]
fn a_pointer_s_device_has_the_friction_of_the_scene() {
    let scene = WorldFile::parse("two.toml", TWO).unwrap().scene;
    let clock = SteppedClock::new();
    let hand = SpatialHand::at(scene.devices[1].position);
    hand.disable_output();
    let mut device = SpatialPointer::new(&scene, 1, &hand, clock.clone()).unwrap();
    let mut moved = |force: f64, millis: u64| {
        device.read().unwrap();
        device.write(Wrench::of_force([force, 0.0, 0.0])).unwrap();
        clock.advance(Duration::from_millis(millis));
        device.read().unwrap();
        let PointerAxis::Moves(axis) = &device.axes[0] else {
            panic!("it moves")
        };
        axis.velocity()
    };
    // 2 N against 1.5 N of a pointer's dry friction, and 3 N s/m: (2 - 1.5)/3 m/s in the end.
    let fastest = moved(2.0, 1000);
    assert!((fastest - 0.5 / 3.0).abs() < 1e-9, "{fastest} m/s");
}

/// The hand releases the rotation and the position at the same time: the device then turns as on the bench.
#[test]
fn a_hand_releases_the_rotation_too() {
    let hand = "mass_kg = 0.15\nhand.rotational_stiffness_n_m_per_rad = 0.3\nhand.release_s = 0.0505\n\
                hand.torque_n_m = [0.0, 0.03, 0.0]";
    let text = PLATE.replace("mass_kg = 0.15", hand);
    let scene = WorldFile::parse("plate.toml", &text).unwrap().scene;
    let evaluated = crate::sim::world::as_evaluated(&scene);
    let params = palpate_testbed::world::PlantParams::perfect(0.001);
    let mut plant = palpate_testbed::world::WorldPlant::new(&evaluated, params).unwrap();
    let clock = SteppedClock::new();
    let mut device = SpatialDevice::new(&scene, 0, clock.clone()).unwrap();
    device.read().unwrap();
    for _ in 0..200 {
        plant.hold(&[[0.0; 3]]);
        clock.advance(Duration::from_millis(1));
        device.read().unwrap();
    }
    let (bench, own) = (plant.orientations()[0], device.orientation().unwrap());
    assert!(apart(bench, own) < 1e-7, "{bench:?} {own:?}");
    assert!(apart(own, [1.0, 0.0, 0.0, 0.0]) > 0.1, "{own:?}");
}
