//! Situations of a loop that renders a world on one device.

use std::hint::black_box;
use std::path::Path;

use palpate_device::clock::SteppedClock;
use palpate_device::{Device, DeviceErrorKind, ScriptedDevice, Step};
use palpate_rt::safety::{SafetyParams, SafetyStop};
use palpate_rt::{
    ControlLoop, Message, RenderedWorld, WorldFrame, changing_world, local_world, tap,
};
use palpate_scene::world::{WorldFile, WorldScene};
use palpate_study::sim::device::{SpatialDevice, SpatialHand, SpatialPointer};
use palpate_world::engine::BodyNow;
use palpate_world::engine::local::{LocalContact, LocalParams, LocalRenderer};
use palpate_world::{ContactLaw, CoupledParams, Shape, Tool, WorldLoop};

use crate::situations::Watch;

/// Loads a world of `experiments/`.
pub(crate) fn world_scene(name: &str) -> WorldScene {
    with_points(name, 60)
}

/// Loads a scene and sets the number of points of its shells with 60 points.
fn with_points(name: &str, points: usize) -> WorldScene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../experiments")
        .join(name);
    let text = std::fs::read_to_string(path).unwrap();
    let text = text.replace("points = 60", &format!("points = {points}"));
    WorldFile::parse(name, &text).unwrap().scene
}

fn rendered(scene: &WorldScene, method: &'static str) -> RenderedWorld {
    let renderer = scene.renderer(method).unwrap();
    RenderedWorld::new(&scene.world, renderer, method, WorldFrame::the_same()).unwrap()
}

pub fn worlds(watch: &mut Watch) {
    for name in [
        "worlds/pushed-block.toml",
        "worlds/paddle.toml",
        "worlds/row.toml",
        "worlds/groove-90-rough.toml",
    ] {
        let scene = world_scene(name);
        let mut forces = 0;
        for method in ["basic", "coupled"] {
            let clock = SteppedClock::new();
            let device = SpatialDevice::new(&scene, 0, clock.clone()).unwrap();
            let world = rendered(&scene, method);
            let limits = SafetyParams::default();
            let (tap, mut listener) = tap(1000);
            let mut control = ControlLoop::of_world(device, clock, world, limits)
                .unwrap()
                .tapped(tap);
            for _ in 0..300 {
                let mut force = [0.0; 3];
                watch(&mut || force = control.tick().tick.commanded_force);
                forces += usize::from(force != [0.0; 3]);
            }
            let bodies = listener.by_ref().filter(
                |messages| matches!(messages, Message::Tick(_, contacts, bodies, _) if !contacts.is_empty() && bodies.len() > 1),
            );
            let messages = bodies.count();
            assert!(
                messages > 10 || name.contains("groove"),
                "{name}: {messages} ticks with bodies"
            );
        }
        assert!(forces > 50, "{name}: {forces} ticks with a force");
    }
}

pub fn six_axes(watch: &mut Watch) {
    for (name, points) in [
        ("worlds/plug.toml", 60),
        ("worlds/plug.toml", 250),
        ("worlds/box.toml", 0),
    ] {
        let scene = with_points(name, points);
        let at = scene.devices[0].position;
        for method in ["basic", "coupled"] {
            let clock = SteppedClock::new();
            let device = SpatialDevice::new(&scene, 0, clock.clone()).unwrap();
            let world = rendered(&scene, method);
            let mut control =
                ControlLoop::of_world(device, clock, world, SafetyParams::default()).unwrap();
            turn(&mut control, name, watch, |_| {});

            let clock = SteppedClock::new();
            let hand = SpatialHand::at(at);
            let device = SpatialPointer::new(&scene, 0, &hand, clock.clone()).unwrap();
            let world = rendered(&scene, method);
            let mut control =
                ControlLoop::of_world(device, clock, world, SafetyParams::default()).unwrap();
            let [x, y, z] = at;
            turn(&mut control, name, watch, |tick| match tick % 100 {
                0 => hand.disable_output(),
                10 => hand.move_to([x, y, z - 0.025]),
                40 => hand.turn_to([1.0, 0.05, 0.1, 0.0]),
                80 => hand.turn_back(),
                _ => {}
            });
        }
    }
}

/// Ticks of a world of six axes, some of them with a torque.
fn turn<D: Device>(
    control: &mut ControlLoop<D, SteppedClock, RenderedWorld>,
    name: &str,
    watch: &mut Watch,
    lead: impl Fn(u32),
) {
    let mut torques = 0;
    for tick in 0..400 {
        lead(tick);
        let mut torque = [0.0; 3];
        watch(&mut || torque = control.tick().tick.commanded_torque);
        torques += usize::from(torque != [0.0; 3]);
    }
    assert!(torques > 20, "{name}: {torques} ticks with a torque");
}

pub fn worlds_that_change(watch: &mut Watch) {
    for name in [
        "worlds/pushed-block.toml",
        "worlds/paddle.toml",
        "worlds/groove-90-rough.toml",
    ] {
        let scene = world_scene(name);
        let clock = SteppedClock::new();
        let device = SpatialDevice::new(&scene, 0, clock.clone()).unwrap();
        let (mut worlds, world) = changing_world(scene.world.clone(), rendered(&scene, "coupled"));
        let limits = SafetyParams::default();
        let mut control = ControlLoop::of_changing_world(device, clock, world, limits).unwrap();
        let (mut seen, mut forces) = (0, 0);
        for tick in 0..300 {
            if tick % 10 == 5 {
                let mut other = scene.clone();
                for contact in &mut other.world.contacts {
                    contact.law.stiffness *= 1.0 + 0.1 * f64::from(tick % 7);
                }
                // Every third one is superseded before it is rendered.
                for _ in 0..1 + tick % 3 / 2 {
                    let method = ["basic", "coupled"][usize::from(tick % 20 == 5)];
                    let world = rendered(&other, method);
                    worlds.change(other.world.clone(), world).unwrap();
                }
            }
            watch(&mut || {
                let messages = control.tick().tick;
                forces += usize::from(messages.commanded_force != [0.0; 3]);
                seen = messages.generation;
            });
        }
        assert_eq!(seen, worlds.generation(), "{name}");
        assert!(seen >= 30 && forces > 50, "{name}: {seen}, {forces}");
    }
}

pub fn a_slow_host(watch: &mut Watch) {
    let scene = world_scene("worlds-on-devices/ball-on-table.toml");
    let clock = SteppedClock::new();
    let own = &scene.devices[0];
    let device = SpatialDevice::new(&scene, 0, clock.clone()).unwrap();
    let tool = Tool::new("tool", Shape::Sphere { radius: 0.01 });
    let renderer = LocalRenderer::new(
        &[tool],
        LocalParams {
            stale_after: 0.05,
            ..LocalParams::new(1, 4)
        },
        WorldLoop::new(0.001),
        CoupledParams::new(vec![own.mass]),
    );
    let frame = WorldFrame::the_same();
    let (mut host, world) = local_world(renderer.unwrap(), frame).unwrap();
    let limits = SafetyParams::default();
    let mut control = ControlLoop::of_local_world(device, clock, world, limits).unwrap();
    let (mut forces, mut stale) = (0, 0);
    for tick in 0..2000 {
        let is_hanging = (1000..1300).contains(&tick);
        if tick % 20 == 0 && !is_hanging {
            let progress = host.progress().clone();
            let mut body = BodyNow::fixed(own.position);
            body.mobility[2][2] = 10.0;
            let law = ContactLaw::spring(1000.0).with_friction(0.5);
            // Two millimetres inside, relative to its position; every third time one contact less.
            let (at, up) = (progress.positions[0], [0.0, 0.0, 1.0]);
            let contact = LocalContact::at_gap((0, at, 0.01), Some(0), -0.002, up, law);
            let contacts = [Some(contact), (tick % 60 != 0).then_some(contact)];
            host.publish(progress.tick, &[body], &contacts).unwrap();
        }
        watch(&mut || {
            let messages = control.tick().tick;
            forces += usize::from(messages.commanded_force != [0.0; 3]);
        });
        stale += usize::from(host.progress().is_stale);
    }
    assert!(forces > 500 && stale > 100, "{forces}, {stale}");
}

pub fn faults_in_a_world(watch: &mut Watch) {
    let scene = world_scene("worlds-on-devices/ball-on-table.toml");
    let limits = SafetyParams {
        workspace: Some([[-0.2; 3], [0.2; 3]]),
        ..SafetyParams::default()
    };
    let pressed = Step::At([0.0, 0.0, 0.048]);
    for (fault, safety_stop) in [
        (Step::At([0.0, f64::NAN, 0.0]), SafetyStop::NotANumber),
        (Step::Stale, SafetyStop::StaleSample),
        (Step::At([0.0, 0.0, 0.3]), SafetyStop::OutsideWorkspace),
        (Step::At([0.1, 0.0, 0.048]), SafetyStop::TooFast),
        (
            Step::Fails(DeviceErrorKind::Refused),
            SafetyStop::DeviceRefused,
        ),
    ] {
        let mut script = vec![pressed; 20];
        script.extend([fault; 5]);
        script.push(pressed);
        let clock = SteppedClock::new();
        let device = ScriptedDevice::new(clock.clone(), 3, script);
        let world = rendered(&scene, "coupled");
        let mut control = ControlLoop::of_world(device, clock, world, limits).unwrap();
        let mut stopped = false;
        for _ in 0..60 {
            watch(&mut || {
                black_box(control.tick());
            });
            stopped |= control.safety_stop() == Some(safety_stop);
        }
        assert!(stopped, "{fault:?}: {:?}", control.safety_stop());
    }
}
