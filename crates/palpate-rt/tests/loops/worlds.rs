//! A world in the loop: motion of a device in space, and safety of its forces.

use std::path::Path;

use palpate_device::clock::SteppedClock;
use palpate_device::{Device, ScriptedDevice, Step, Vector};
use palpate_record::recording::Flags;
use palpate_rt::safety::{OscillationParams, SafetyParams, SafetyStop};
use palpate_rt::{
    ControlLoop, Message, RenderedWorld, SetupError, Turns, WorldAxis, WorldFrame, tap,
};
use palpate_scene::world::{WorldFile, WorldScene, usual_guard};
use palpate_study::sim::device::SpatialDevice;
use palpate_study::sim::world::WorldBench;
use palpate_world::{WorldGuard, WorldGuardParams};

use crate::wide;

type InSpace = ControlLoop<SpatialDevice<SteppedClock>, SteppedClock, RenderedWorld>;
type Scripted = ControlLoop<ScriptedDevice<SteppedClock>, SteppedClock, RenderedWorld>;

/// Loads a scene of `experiments/worlds`.
pub(crate) fn scene(name: &str) -> WorldScene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../experiments/worlds")
        .join(name);
    #[allow(clippy::disallowed_methods, reason = "set-up")]
    let text = std::fs::read_to_string(&path).unwrap();
    WorldFile::parse(name, &text).unwrap().scene
}

fn rendered(scene: &WorldScene, method: &'static str, frame: WorldFrame) -> RenderedWorld {
    let renderer = scene.renderer(method).unwrap();
    RenderedWorld::new(&scene.world, renderer, method, frame).unwrap()
}

fn in_space(scene: &WorldScene, method: &'static str, limits: SafetyParams) -> InSpace {
    let clock = SteppedClock::new();
    let device = SpatialDevice::new(scene, 0, clock.clone()).unwrap();
    let world = rendered(scene, method, WorldFrame::the_same());
    ControlLoop::of_world(device, clock, world, limits).unwrap()
}

/// A table of 1000 N/m, touched from above by a point without friction: 1 N per millimetre below z = 0.
const TABLE: &str = r#"
format = 2
[loop]
period_s = 0.001
[[device]]
name = "tool"
mass_kg = 0.2
tool = { sphere = { radius_m = 0.0 } }
[[body]]
name = "table"
fixed = true
shape = { half_space = { normal = [0.0, 0.0, 1.0], offset_m = 0.0 } }
[[contact]]
between = ["tool", "table"]
stiffness_n_per_m = 1000.0
[render]
method = "basic"
"#;

fn table() -> WorldScene {
    WorldFile::parse("table.toml", TABLE).unwrap().scene
}

/// Creates a loop with the table on a device that follows `script`, with the plain spring force.
fn scripted(script: Vec<Step>, frame: WorldFrame, limits: SafetyParams) -> Scripted {
    let clock = SteppedClock::new();
    let device = ScriptedDevice::new(clock.clone(), 3, script);
    let world = rendered(&table(), "basic", frame);
    ControlLoop::of_world(device, clock, world, limits).unwrap()
}

pub(crate) fn length([x, y, z]: Vector) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

#[test]
fn it_is_the_loop_of_the_simulator_in_three_dimensions() {
    for name in [
        "pushed-block.toml",
        "paddle.toml",
        "row.toml",
        "groove-90-rough.toml",
    ] {
        let scene = scene(name);
        let bench = WorldBench::new(&scene).unwrap();
        for method in ["basic", "coupled"] {
            let expected = bench.run(method, &scene.renderer(method).unwrap()).unwrap();
            let mut control = in_space(&scene, method, wide());
            let scale = expected.delivered[0]
                .iter()
                .fold(0.1, |most: f64, force| most.max(length(*force)));
            let mut worst: f64 = 0.0;
            // A force starts with its sample: the simulator's next position results from it.
            for (sample, positions) in expected.positions.iter().enumerate().take(60) {
                let place = control.device().position();
                let tick = control.tick().tick;
                let now = control.device().position();
                let off: Vector = std::array::from_fn(|axis| now[axis] - positions[0][axis]);
                worst = worst.max(length(off));
                assert!(
                    sample == 0 || place != now,
                    "{name}: the device stands still"
                );
                assert!(length(tick.commanded_force) <= 10.0 * scale);
            }
            println!("{name}, {method}: at most {worst:.1e} m from the simulator's motion");
            assert!(worst < 1e-6, "{name}, {method}: {worst} m");
        }
    }
}

#[test]
fn a_force_limit_is_the_length_of_a_vector() {
    // In a corner: 9 N along each axis would be 15.6 N.
    let mut corner = table();
    for (axis, name) in ["wall-x", "wall-y"].iter().enumerate() {
        let mut wall = corner.world.bodies[0].clone();
        wall.name = (*name).into();
        let mut normal = [0.0; 3];
        normal[axis] = 1.0;
        wall.shape = palpate_world::Shape::HalfSpace {
            normal,
            offset: 0.0,
        };
        corner.world.bodies.push(wall);
    }
    for contact in &mut corner.world.contacts {
        contact.between = [palpate_world::Party::Any, palpate_world::Party::Any];
    }
    let limits = SafetyParams {
        largest_force: 5.0,
        soft_start: 0.0,
        ..wide()
    };
    let pressed = |limits| {
        let clock = SteppedClock::new();
        let script = vec![Step::At([-9e-3, -9e-3, -9e-3])];
        let device = ScriptedDevice::new(clock.clone(), 3, script);
        let world = rendered(&corner, "basic", WorldFrame::the_same());
        let mut control = ControlLoop::of_world(device, clock, world, limits).unwrap();
        control.tick().tick
    };
    let free = pressed(SafetyParams {
        largest_force: 1e3,
        ..limits
    });
    let [x, y, z] = free.commanded_force;
    assert!(
        [x, y, z].iter().all(|force| (force - 9.0).abs() < 1e-9),
        "{x} {y} {z} N"
    );
    let limited = pressed(limits);
    let force = limited.commanded_force;
    assert!((length(force) - 5.0).abs() < 1e-12, "{force:?}");
    // The direction is kept.
    assert!(force.iter().all(|part| (part - force[0]).abs() < 1e-12));
    assert!(limited.flags.has(Flags::SAFETY_LIMITED));
}

#[test]
fn force_ramps_up_and_every_safety_stop_removes_it() {
    let pressed = Step::At([0.0, 0.0, -2e-3]);
    let nan = Step::At([0.0, f64::NAN, 0.0]);
    let far = Step::At([0.0, 0.0, 0.3]);
    let box_of = SafetyParams {
        workspace: Some([[-0.1; 3], [0.1; 3]]),
        largest_speed: 1e4,
        oscillation: OscillationParams {
            energy: f64::INFINITY,
            window: 0.2,
        },
        ..SafetyParams::default()
    };
    for (fault, safety_stop, comes_back) in [
        (nan, SafetyStop::NotANumber, true),
        (far, SafetyStop::OutsideWorkspace, false),
        (Step::Stale, SafetyStop::StaleSample, true),
        (
            Step::Fails(palpate_device::DeviceErrorKind::Refused),
            SafetyStop::DeviceRefused,
            false,
        ),
    ] {
        let mut script = vec![pressed; 400];
        script.extend([fault; 4]);
        script.push(pressed);
        let mut control = scripted(script, WorldFrame::the_same(), box_of);
        let first = control.tick().tick.commanded_force;
        assert_eq!(length(first), 0.0, "the force comes in from 0");
        let forces: Vec<f64> = (1..400)
            .map(|_| length(control.tick().tick.commanded_force))
            .collect();
        assert!(forces.is_sorted() && (forces[398] - 2.0).abs() < 1e-9);
        control.tick();
        for _ in 0..3 {
            let tick = control.tick().tick;
            assert_eq!(tick.delivered_force, [0.0; 3], "{safety_stop}");
            assert_eq!(control.safety_stop(), Some(safety_stop));
        }
        for _ in 0..400 {
            control.tick();
        }
        let last = length(control.tick().tick.commanded_force);
        let expected = if comes_back { 2.0 } else { 0.0 };
        assert!((last - expected).abs() < 1e-9, "{safety_stop}: {last} N");
    }
}

#[test]
fn a_device_in_the_plane_pushes_along_its_own_axes() {
    // Upright: its y is the world's z, and its origin is 20 mm above the table.
    let axes = [Some(WorldAxis::along(0)), Some(WorldAxis::along(2)), None];
    let frame = WorldFrame::new(axes, [0.0, 0.1, 0.0], [0.0, 0.3, 0.02]).unwrap();
    let script = vec![Step::At([0.0, 0.1 - 0.023, 0.0])];
    let mut control = scripted(script, frame, wide());
    let tick = control.tick().tick;
    assert!((tick.commanded_force[1] - 3.0).abs() < 1e-9);
    assert!(tick.commanded_force[0] == 0.0 && tick.commanded_force[2] == 0.0);
}

#[test]
fn tick_reports_its_contacts_and_moving_bodies() {
    let (tap, mut listener) = tap(1000);
    let mut control = in_space(&scene("pushed-block.toml"), "coupled", wide()).tapped(tap);
    let mut row = control.tick();
    for _ in 0..99 {
        row = control.tick();
    }
    // The block on the table by four corners, and possibly the tool.
    assert!(
        (4..=9).contains(&row.tick.contacts),
        "{}",
        row.tick.contacts
    );
    assert_eq!(row.tick.bodies, 2, "the block, and the tool's proxy");
    let Some(Message::Tick(tick, contacts, bodies, _)) = listener.by_ref().last() else {
        panic!("the last thing told is a tick");
    };
    assert_eq!(tick.sequence, 99);
    assert_eq!(contacts.len(), row.tick.contacts as usize);
    let lifted: f64 = contacts
        .iter()
        .map(|contact| contact.force[2] * contact.normal[2].signum())
        .sum();
    assert!((lifted.abs() - 0.4905).abs() < 0.2, "{lifted} N");
    let numbers: Vec<u32> = bodies.iter().map(|body| body.body).collect();
    // The table is fixed; the proxy state follows both bodies.
    assert_eq!(numbers, [0, 2]);
    let place = control.device().position();
    assert!(
        length(std::array::from_fn(
            |axis| bodies[1].position[axis] - place[axis]
        )) < 1e-3
    );
}

#[test]
fn coupled_runs_without_safety_stop_and_basic_generates_more_energy() {
    // A ball on a paddle with the spring force of the sample gains energy at every bounce.
    let mut juggled = scene("paddle.toml");
    juggled.timing.period = 0.004;
    let runs = |method| {
        let mut control = in_space(&juggled, method, SafetyParams::default());
        let mut most: f64 = 0.0;
        for _ in 0..750 {
            let tick = control.tick().tick;
            most = most.max(tick.created_energy);
            if control.safety_stop().is_some() {
                break;
            }
        }
        println!("{method}: created up to {:.2} mJ", 1e3 * most);
        (control.safety_stop(), most)
    };
    let (safety_stop, created) = runs("coupled");
    assert_eq!(safety_stop, None);
    assert!(created < 0.05, "{created} J");
    let (_, by_basic) = runs("basic");
    assert!(by_basic > 4.0 * created.max(1e-4), "{by_basic} J");
    let _ = SafetyStop::Oscillation;
}

#[test]
fn a_loop_of_two_devices_is_refused() {
    let pinch = scene("pinch.toml");
    let renderer = pinch.renderer("coupled").unwrap();
    let refused = RenderedWorld::new(&pinch.world, renderer, "coupled", WorldFrame::the_same());
    assert_eq!(
        refused.unwrap_err(),
        SetupError::Devices { world: 2, given: 1 }
    );
}

#[test]
fn spatial_device_returns_the_written_force() {
    let scene = scene("paddle.toml");
    let clock = SteppedClock::new();
    let mut device = SpatialDevice::new(&scene, 0, clock).unwrap();
    let held = device.write([1.0, -2.0, 0.5].into()).unwrap();
    assert_eq!(held.force, [1.0, -2.0, 0.5]);
}

/// A six-axis device in the loop moves and rotates like the simulator's.
#[test]
fn six_axes_in_the_loop_are_those_of_the_simulator() {
    for (name, torque) in [("box.toml", 1e-2), ("peg.toml", 1e-3)] {
        let scene = scene(name);
        let bench = WorldBench::new(&scene).unwrap();
        let expected = bench
            .run("coupled", &scene.renderer("coupled").unwrap())
            .unwrap();
        let mut control = in_space(&scene, "coupled", wide());
        let (mut worst, mut most): (f64, f64) = (0.0, 0.0);
        let samples = expected.positions.iter().zip(&expected.orientations);
        for (positions, turns) in samples.take(150) {
            let tick = control.tick().tick;
            let now = control.device().position();
            let off: Vector = std::array::from_fn(|axis| now[axis] - positions[0][axis]);
            worst = worst.max(length(off));
            let turned = control.device().orientation().unwrap();
            let parts = turned.iter().zip(turns[0]);
            worst = parts.fold(worst, |worst, (now, then)| worst.max((now - then).abs()));
            most = most.max(length(tick.commanded_torque));
            assert_eq!(tick.delivered_torque, tick.commanded_torque, "{name}");
            let measured = tick.device_orientation;
            assert!((measured[0] - turned[0]).abs() < 1e-3, "{measured:?}");
        }
        println!(
            "{name}: {worst:.1e} m or quaternion parts from the simulator's motion, torques up to {most:.4} N m"
        );
        assert!(worst < 1e-6 && most > torque, "{name}: {worst} {most}");
    }
}

#[test]
fn a_tool_that_turns_needs_a_device_that_turns_with_the_axes_of_the_world() {
    let scene = scene("box.toml");
    let renderer = scene.renderer("coupled").unwrap();
    let clock = SteppedClock::new();
    let world = rendered(&scene, "coupled", WorldFrame::the_same());
    let device = ScriptedDevice::new(clock.clone(), 3, Vec::new());
    let refused = ControlLoop::of_world(device, clock, world, wide());
    assert_eq!(refused.err(), Some(SetupError::SixAxes));
    let axes = [1, 0, 2].map(|axis| Some(WorldAxis::along(axis)));
    let frame = WorldFrame::new(axes, [0.0; 3], [0.0; 3]).unwrap();
    let refused = RenderedWorld::new(&scene.world, renderer, "coupled", frame);
    assert_eq!(refused.unwrap_err(), SetupError::TurnedFrame);
}

/// Most devices with a stylus measure six axes and give a force along three. This is sufficient for a tool that only
/// the hand rotates.
#[test]
fn a_stylus_needs_a_device_that_measures_how_it_is_turned() {
    let scene = scene("stylus.toml");
    let clock = SteppedClock::new();
    let device = ScriptedDevice::new(clock.clone(), 3, Vec::new());
    let world = rendered(&scene, "coupled", WorldFrame::the_same());
    assert_eq!(world.turns(), [Turns::ByHand]);
    let refused = ControlLoop::of_world(device, clock, world, wide());
    assert_eq!(refused.err(), Some(SetupError::Orientation));

    let mut control = in_space(&scene, "coupled", wide());
    let can = control.device().capabilities();
    assert_eq!((can.torque_axes, can.measures_orientation), (0, true));
    let start = control.device().orientation().unwrap();
    let (mut force, mut turned) = (0.0_f64, 0.0_f64);
    for _ in 0..300 {
        let tick = control.tick().tick;
        assert_eq!(tick.commanded_torque, [0.0; 3]);
        assert_eq!(tick.delivered_torque, [0.0; 3]);
        force = force.max(length(tick.commanded_force));
        let parts = control.device().orientation().unwrap();
        let apart = parts
            .iter()
            .zip(start)
            .map(|(now, then)| (now - then).abs());
        turned = apart.fold(turned, f64::max);
    }
    assert!(force > 1.0 && turned > 0.1, "{force} {turned}");

    // The same device is rejected for a tool with a torque.
    let mut felt = scene.clone();
    felt.world.tools[0].gives_torque = true;
    let clock = SteppedClock::new();
    let device = SpatialDevice::new(&scene, 0, clock.clone()).unwrap();
    let world = rendered(&felt, "coupled", WorldFrame::the_same());
    let refused = ControlLoop::of_world(device, clock, world, wide());
    assert_eq!(refused.err(), Some(SetupError::SixAxes));
}

/// The loop commands the force limited by the guard, and the recording contains it.
#[test]
fn the_guard_of_a_world_acts_in_the_loop() {
    let mut scene = scene("box.toml");
    let forces = |scene: &WorldScene| {
        let mut control = in_space(scene, "coupled", wide());
        let ticks: Vec<_> = (0..100).map(|_| control.tick().tick).collect();
        let guarded = ticks
            .iter()
            .position(|tick| tick.flags.has(Flags::LIMITED_GUARD));
        let power = ticks
            .iter()
            .map(|tick| length(tick.commanded_force) + 10.0 * length(tick.commanded_torque));
        (guarded, power.collect::<Vec<f64>>())
    };
    let (guarded, open) = forces(&scene);
    assert_eq!(guarded, None);
    scene.render.guard = WorldGuard::Limit(WorldGuardParams {
        allowance: 5e-4,
        ..usual_guard()
    });
    let (guarded, kept) = forces(&scene);
    let first = guarded.unwrap();
    // Both loops agree up to there. No energy has been put in yet: 0.5 mJ over 1 ms, against 1 m/s and 10 rad/s.
    assert_eq!(open[..first], kept[..first]);
    println!("{} W in place of {} W", kept[first], open[first]);
    assert!(open[first] > 0.5 && kept[first] < 0.55, "{kept:?}");
}
