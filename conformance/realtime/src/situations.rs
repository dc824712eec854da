//! What a loop gets into: every device, method, limit and fault, with somebody listening or not.
//!
//! A situation sets its loop up and looks at what came of it outside, and gives each tick to a watch.

use std::hint::black_box;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use palpate_device::clock::{Clock, MonotonicClock, SteppedClock};
use palpate_device::{Device, DeviceErrorKind, NullDevice, ReplayDevice, ScriptedDevice, Step};
use palpate_record::recording::Flags;
use palpate_rt::safety::{OscillationParams, SafetyParams, Trip};
use palpate_rt::{
    ControlLoop, Ending, Note, RenderedWorld, StopFlag, Told, WorldFrame, changing_world,
    local_world, tap,
};
use palpate_scene::method::MethodName;
use palpate_scene::world::{WorldFile, WorldScene};
use palpate_scene::{Scene, SceneFile, beside};
use palpate_sim::device::{
    PointerDevice, PointerHand, PointerParams, SimulatedDevice, SpatialDevice, SpatialHand,
    SpatialPointer,
};
use palpate_world::engine::BodyNow;
use palpate_world::engine::local::{LocalContact, LocalParams, LocalRenderer};
use palpate_world::{ContactLaw, CoupledParams, Shape, Tool, WorldLoop};

use crate::hostile::anything;
use crate::several::{a_pinch, anything_of_two, faults_of_each};

/// Runs what it is given, a tick, and watches it.
pub type Watch<'a> = dyn FnMut(&mut dyn FnMut()) + 'a;

/// A situation, by name.
pub type Situation = (&'static str, fn(&mut Watch));

/// Every situation in which the clock is moved by hand.
pub const STEPPED: [Situation; 21] = [
    ("every method on a simulated device", every_method),
    ("worlds on a device in space", worlds),
    ("six axes, on a device and in a pointer's hand", six_axes),
    (
        "worlds that take the place of each other",
        worlds_that_change,
    ),
    ("a slow host that publishes, and hangs", a_slow_host),
    ("every fault of a device in a world", faults_in_a_world),
    ("no device", no_device),
    ("a pointer that moves, lets go and takes hold", a_pointer),
    ("motion replay, past its end", replay),
    ("every fault of a device, and rearming", faults),
    ("every passing limit of safety", limits),
    ("a contact that oscillates", oscillation),
    ("every change from method to method", changes),
    ("changes on top of each other", changes_in_a_hurry),
    ("somebody listens", a_listener),
    ("nobody listens", a_full_tap),
    ("a late thread, and a supervisor that cuts", stalls),
    ("anything that a device can say", anything),
    ("a pinch on two devices", a_pinch),
    ("every fault of each of two devices", faults_of_each),
    ("anything that two devices can say", anything_of_two),
];

/// Every situation in which real time passes.
pub const MONOTONIC: [Situation; 2] = [
    ("real time, asleep and awake", real_time),
    ("a run that is stopped", a_run_that_is_stopped),
];

/// A scene of `experiments/`.
#[must_use]
pub fn scene(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../experiments")
        .join(name);
    let text = std::fs::read_to_string(&path).unwrap();
    SceneFile::parse_with(name, &text, &mut beside(&path))
        .unwrap()
        .scene
}

fn ticks<D: Device, C: Clock>(control: &mut ControlLoop<D, C>, number: u32, watch: &mut Watch) {
    for _ in 0..number {
        watch(&mut || {
            black_box(control.tick());
        });
    }
}

type Simulated = ControlLoop<SimulatedDevice<SteppedClock>, SteppedClock>;

fn simulated(scene: &Scene, method: MethodName, limits: SafetyParams) -> Simulated {
    let clock = SteppedClock::new();
    let device = SimulatedDevice::of(scene, clock.clone()).unwrap();
    let rendering = scene.rendering(method).unwrap();
    ControlLoop::new(device, clock, rendering, limits).unwrap()
}

type Scripted = ControlLoop<ScriptedDevice<SteppedClock>, SteppedClock>;

/// A wall of 1 N/mm at 1 kHz.
fn scripted(script: Vec<Step>, limits: SafetyParams) -> (Scripted, SteppedClock) {
    let clock = SteppedClock::new();
    let device = ScriptedDevice::new(clock.clone(), 1, script);
    let rendering = scene("wall.toml").rendering(MethodName::Basic).unwrap();
    let control = ControlLoop::new(device, clock.clone(), rendering, limits).unwrap();
    (control, clock)
}

fn at(millimetres: f64) -> Step {
    Step::At([millimetres * 1e-3, 0.0, 0.0])
}

fn every_method(watch: &mut Watch) {
    for name in [
        "fig2.toml",
        "fig5.toml", // a linkage
        "experiment1_in_a_hand.toml",
        "coupled/wall-1000.toml",
        "users/s05-rate-collapse.toml",
        "users/s06-bilateral-500hz.toml", // a delay
        "users/s08-hands-off.toml",
    ] {
        let scene = scene(name);
        let mut forces = 0;
        for method in MethodName::ALL {
            let mut control = simulated(&scene, method, SafetyParams::default());
            for _ in 0..400 {
                let mut force = 0.0;
                watch(&mut || force = control.tick().contact.force_on_object);
                forces += usize::from(force != 0.0);
            }
        }
        assert!(forces > 100, "{name}: {forces} ticks with a force");
    }
}

/// A world of `experiments/`.
pub(crate) fn world_scene(name: &str) -> WorldScene {
    with_points(name, 60)
}

/// A scene whose shells of 60 points have so many.
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

fn worlds(watch: &mut Watch) {
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
            let own = &scene.devices[0];
            let device = SpatialDevice::new(own, &scene.timing.actuator, clock.clone()).unwrap();
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
                |told| matches!(told, Told::Tick(_, contacts, bodies, _) if !contacts.is_empty() && bodies.len() > 1),
            );
            let told = bodies.count();
            assert!(
                told > 10 || name.contains("groove"),
                "{name}: {told} ticks with bodies"
            );
        }
        assert!(forces > 50, "{name}: {forces} ticks with a force");
    }
}

fn six_axes(watch: &mut Watch) {
    for (name, points) in [
        ("worlds/plug.toml", 60),
        ("worlds/plug.toml", 250),
        ("worlds/box.toml", 0),
    ] {
        let scene = with_points(name, points);
        let (own, actuator) = (&scene.devices[0], &scene.timing.actuator);
        for method in ["basic", "coupled"] {
            let clock = SteppedClock::new();
            let device = SpatialDevice::new(own, actuator, clock.clone()).unwrap();
            let world = rendered(&scene, method);
            let mut control =
                ControlLoop::of_world(device, clock, world, SafetyParams::default()).unwrap();
            turn(&mut control, name, watch, |_| {});

            let clock = SteppedClock::new();
            let hand = SpatialHand::at(own.position);
            let device = SpatialPointer::new(own, actuator, &hand, clock.clone()).unwrap();
            let world = rendered(&scene, method);
            let mut control =
                ControlLoop::of_world(device, clock, world, SafetyParams::default()).unwrap();
            let [x, y, z] = own.position;
            turn(&mut control, name, watch, |tick| match tick % 100 {
                0 => hand.let_go(),
                10 => hand.move_to([x, y, z - 0.025]),
                40 => hand.turn_to([1.0, 0.05, 0.1, 0.0]),
                80 => hand.turn_back(),
                _ => {}
            });
        }
    }
}

/// Ticks of a world of six axes, in some of which there is a torque.
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

fn worlds_that_change(watch: &mut Watch) {
    for name in [
        "worlds/pushed-block.toml",
        "worlds/paddle.toml",
        "worlds/groove-90-rough.toml",
    ] {
        let scene = world_scene(name);
        let clock = SteppedClock::new();
        let own = &scene.devices[0];
        let device = SpatialDevice::new(own, &scene.timing.actuator, clock.clone()).unwrap();
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
                // Every third is overtaken before it is rendered.
                for _ in 0..1 + tick % 3 / 2 {
                    let method = ["basic", "coupled"][usize::from(tick % 20 == 5)];
                    let world = rendered(&other, method);
                    worlds.change(other.world.clone(), world).unwrap();
                }
            }
            watch(&mut || {
                let told = control.tick().tick;
                forces += usize::from(told.commanded_force != [0.0; 3]);
                seen = told.generation;
            });
        }
        assert_eq!(seen, worlds.generation(), "{name}");
        assert!(seen >= 30 && forces > 50, "{name}: {seen}, {forces}");
    }
}

fn a_slow_host(watch: &mut Watch) {
    let scene = world_scene("worlds-on-devices/ball-on-table.toml");
    let clock = SteppedClock::new();
    let own = &scene.devices[0];
    let device = SpatialDevice::new(own, &scene.timing.actuator, clock.clone()).unwrap();
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
            // Two millimetres into it, wherever it is; every third time one contact less.
            let (at, up) = (progress.positions[0], [0.0, 0.0, 1.0]);
            let contact = LocalContact::at_gap((0, at, 0.01), Some(0), -0.002, up, law);
            let contacts = [Some(contact), (tick % 60 != 0).then_some(contact)];
            host.publish(progress.tick, &[body], &contacts).unwrap();
        }
        watch(&mut || {
            let told = control.tick().tick;
            forces += usize::from(told.commanded_force != [0.0; 3]);
        });
        stale += usize::from(host.progress().is_stale);
    }
    assert!(forces > 500 && stale > 100, "{forces}, {stale}");
}

fn faults_in_a_world(watch: &mut Watch) {
    let scene = world_scene("worlds-on-devices/ball-on-table.toml");
    let limits = SafetyParams {
        workspace: Some([[-0.2; 3], [0.2; 3]]),
        ..SafetyParams::default()
    };
    let pressed = Step::At([0.0, 0.0, 0.048]);
    for (fault, trip) in [
        (Step::At([0.0, f64::NAN, 0.0]), Trip::NotANumber),
        (Step::Stale, Trip::StaleSample),
        (Step::At([0.0, 0.0, 0.3]), Trip::OutsideWorkspace),
        (Step::At([0.1, 0.0, 0.048]), Trip::TooFast),
        (Step::Fails(DeviceErrorKind::Refused), Trip::DeviceRefused),
    ] {
        let mut script = vec![pressed; 20];
        script.extend([fault; 5]);
        script.push(pressed);
        let clock = SteppedClock::new();
        let device = ScriptedDevice::new(clock.clone(), 3, script);
        let world = rendered(&scene, "coupled");
        let mut control = ControlLoop::of_world(device, clock, world, limits).unwrap();
        let mut tripped = false;
        for _ in 0..60 {
            watch(&mut || {
                black_box(control.tick());
            });
            tripped |= control.trip() == Some(trip);
        }
        assert!(tripped, "{fault:?}: {:?}", control.trip());
    }
}

fn no_device(watch: &mut Watch) {
    let clock = SteppedClock::new();
    let rendering = scene("wall.toml").rendering(MethodName::Coupled).unwrap();
    let device = NullDevice::new(clock.clone());
    let mut control = ControlLoop::new(device, clock, rendering, SafetyParams::default()).unwrap();
    ticks(&mut control, 1000, watch);
    assert_eq!(control.statistics().ticks, 1000);
}

fn replay(watch: &mut Watch) {
    let clock = SteppedClock::new();
    let samples = (0..300)
        .map(|i| {
            let at = 2e-3 * (0.05 * f64::from(i)).sin();
            (Duration::from_micros(1700) * i, [at, 0.0, 0.0])
        })
        .collect();
    let device = ReplayDevice::new(clock.clone(), 1, samples).unwrap();
    let rendering = scene("wall.toml").rendering(MethodName::Hfcr).unwrap();
    let mut control = ControlLoop::new(device, clock, rendering, SafetyParams::default()).unwrap();
    ticks(&mut control, 600, watch);
    assert_eq!(control.trip(), Some(Trip::DeviceLost));
}

fn faults(watch: &mut Watch) {
    use DeviceErrorKind::{Disconnected, NothingNew, Refused};
    let limits = SafetyParams {
        workspace: Some([[-0.05; 3], [0.05; 3]]),
        largest_speed: 2.0,
        ..SafetyParams::default()
    };
    let faults = [
        (Step::At([f64::NAN; 3]), Trip::NotANumber),
        (Step::At([f64::INFINITY; 3]), Trip::NotANumber),
        (Step::Stale, Trip::StaleSample),
        (Step::Fails(NothingNew), Trip::StaleSample),
        (at(60.0), Trip::OutsideWorkspace),
        (at(40.0), Trip::TooFast),
        (Step::Fails(Refused), Trip::DeviceRefused),
        (Step::Fails(Disconnected), Trip::DeviceLost),
        (Step::RefusesForce([1e-3, 0.0, 0.0]), Trip::DeviceRefused),
    ];
    for (fault, trip) in faults {
        let mut script = vec![at(1.0); 20];
        script.extend([fault; 5]);
        script.push(at(1.0));
        let (control, _) = scripted(script, limits);
        let (tap, listener) = tap(1000);
        let mut control = control.tapped(tap);
        ticks(&mut control, 50, watch);
        control.rearm().store(true, Ordering::Release);
        ticks(&mut control, 300, watch);
        let notes: Vec<Note> = listener
            .filter_map(|told| match told {
                Told::Note(noted) => Some(noted.note),
                Told::Tick(..) => None,
            })
            .collect();
        assert!(notes.contains(&Note::Tripped(trip)), "{fault:?}: {notes:?}");
        let rearmed = notes.contains(&Note::Rearmed);
        assert_eq!(rearmed, !trip.is_passing(), "{fault:?}: {notes:?}");
        assert_eq!(control.trip(), None, "{fault:?}");
    }
}

fn limits(watch: &mut Watch) {
    let all = SafetyParams {
        largest_force: 0.7,
        slew_limit: 100.0,
        ..SafetyParams::default()
    };
    let (control, _) = scripted(vec![at(1.0)], all);
    let (tap, listener) = tap(1000);
    let mut control = control.tapped(tap);
    ticks(&mut control, 400, watch);
    let limited = listener.filter(|told| match told {
        Told::Tick(tick, ..) => tick.flags.has(Flags::SAFETY_LIMITED),
        Told::Note(_) => false,
    });
    assert_eq!(limited.count(), 400);
}

fn oscillation(watch: &mut Watch) {
    let mut buzzing = scene("experiment2.toml");
    buzzing.contact.stiffness *= 4.0;
    let mut control = simulated(&buzzing, MethodName::Basic, SafetyParams::default());
    ticks(&mut control, 2000, watch);
    assert_eq!(control.trip(), Some(Trip::Oscillation));
}

/// Limits that nothing here reaches.
fn wide() -> SafetyParams {
    SafetyParams {
        largest_force: 1e6,
        largest_speed: 1e6,
        oscillation: OscillationParams {
            energy: f64::INFINITY,
            window: 1.0,
        },
        ..SafetyParams::default()
    }
}

fn changes(watch: &mut Watch) {
    for name in ["experiment1_in_a_hand.toml", "coupled/wall-1000.toml"] {
        let mut scene = scene(name);
        scene.loop_params.period = 0.001;
        for from in MethodName::ALL {
            for to in MethodName::ALL {
                let mut control = simulated(&scene, from, wide());
                let mut parameters = control.parameters().unwrap();
                ticks(&mut control, 200, watch);
                let mut next = scene.rendering(to).unwrap();
                next.contact.stiffness *= 1.5;
                next.virtual_force -= 0.1;
                parameters.change(next).unwrap();
                ticks(&mut control, 120, watch);
            }
        }
    }
}

/// Another thread changes the parameters as fast as it can.
fn changes_in_a_hurry(watch: &mut Watch) {
    let scene = scene("experiment1_in_a_hand.toml");
    let mut control = simulated(&scene, MethodName::Coupled, wide());
    let mut parameters = control.parameters().unwrap();
    let mut generation = 0;
    let ended = AtomicBool::new(false);
    thread::scope(|scope| {
        scope.spawn(|| {
            let mut next = *parameters.current();
            while !ended.load(Ordering::Acquire) {
                next.contact.stiffness = 300.0 + f64::from(generation % 7) * 50.0;
                generation = parameters.change(next).unwrap();
                thread::yield_now();
            }
        });
        let mut taken = 0;
        // On few processors the other thread may wait for its turn.
        for _ in 0..1_000_000 {
            let mut tick = None;
            watch(&mut || tick = Some(control.tick()));
            taken = tick.unwrap().tick.generation;
            if taken > 100 && control.statistics().ticks > 2000 {
                break;
            }
        }
        ended.store(true, Ordering::Release);
        assert!(taken > 100, "{taken} changes");
    });
}

fn a_listener(watch: &mut Watch) {
    let (tap, mut listener) = tap(256);
    let scene = scene("coupled/wall-1000.toml");
    let mut control = simulated(&scene, MethodName::Coupled, SafetyParams::default()).tapped(tap);
    let heard = thread::spawn(move || {
        let mut heard = 0;
        loop {
            let is_last = listener.is_closed();
            heard += listener.by_ref().count() as u64;
            if is_last {
                return heard + listener.lost();
            }
            thread::yield_now();
        }
    });
    ticks(&mut control, 5000, watch);
    drop(control);
    assert!(heard.join().unwrap() >= 5000);
}

fn a_full_tap(watch: &mut Watch) {
    let (tap, listener) = tap(4);
    let scene = scene("coupled/wall-1000.toml");
    let mut control = simulated(&scene, MethodName::Coupled, SafetyParams::default()).tapped(tap);
    ticks(&mut control, 500, watch);
    assert!(listener.lost() >= 496);
    // Nor when the listener has gone.
    drop(listener);
    ticks(&mut control, 500, watch);
}

fn a_pointer(watch: &mut Watch) {
    let scene = scene("live.toml");
    for method in [MethodName::Basic, MethodName::Coupled] {
        let clock = SteppedClock::new();
        let hand = PointerHand::at(0.0);
        let device = PointerDevice::new(PointerParams::of(&scene), &hand, clock.clone()).unwrap();
        let rendering = scene.rendering(method).unwrap();
        let mut control =
            ControlLoop::new(device, clock, rendering, SafetyParams::default()).unwrap();
        for number in 0..60 {
            match number % 6 {
                5 => hand.let_go(),
                place => hand.move_to(0.01 * f64::from(place)),
            }
            ticks(&mut control, 10, watch);
        }
        assert_ne!(control.device().position(), 0.0);
        assert_eq!(hand.target(), None);
    }
}

fn stalls(watch: &mut Watch) {
    let limits = SafetyParams {
        tolerated_lateness: 0.0,
        ..SafetyParams::default()
    };
    let (mut control, clock) = scripted(vec![at(-1.0), at(0.0), at(1.0)], limits);
    let mut supervisor = control.supervisor().unwrap();
    for number in 0..100 {
        ticks(&mut control, 10, watch);
        if number % 3 == 0 {
            clock.oversleep_once(Duration::from_micros(3400));
        }
        if number % 5 == 0 {
            clock.advance(Duration::from_millis(2));
            assert!(supervisor.look(clock.now()));
        }
    }
    assert_eq!(control.cuts(), 20);
    assert!(control.statistics().missed_deadlines > 20);
}

fn real_time(watch: &mut Watch) {
    let scene = scene("wall.toml");
    for spin in [Duration::ZERO, Duration::from_micros(300)] {
        let clock = MonotonicClock::new().with_spin(spin);
        let device = SimulatedDevice::of(&scene, clock).unwrap();
        let rendering = scene.rendering(MethodName::Coupled).unwrap();
        let (tap, listener) = tap(1000);
        let mut control = ControlLoop::new(device, clock, rendering, SafetyParams::default())
            .unwrap()
            .tapped(tap);
        ticks(&mut control, 300, watch);
        assert!(listener.count() >= 300);
        assert!(clock.now() >= Duration::from_millis(299));
    }
}

fn a_run_that_is_stopped(watch: &mut Watch) {
    let clock = MonotonicClock::new();
    let device = SimulatedDevice::of(&scene("wall.toml"), clock).unwrap();
    let rendering = scene("wall.toml").rendering(MethodName::Hfcr).unwrap();
    let mut control = ControlLoop::new(device, clock, rendering, SafetyParams::default()).unwrap();
    let stop = StopFlag::new();
    let raised = stop.clone();
    let stopper = thread::spawn(move || {
        thread::sleep(Duration::from_millis(100));
        raised.raise();
    });
    let mut ending = None;
    watch(&mut || ending = Some(control.run(&stop, None)));
    stopper.join().unwrap();
    assert_eq!(ending, Some(Ending::Stopped));
}
