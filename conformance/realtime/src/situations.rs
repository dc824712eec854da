//! Situations of a loop: every device, method, limit and fault, with and without a listener.
//!
//! A situation sets up its loop and checks the outcome outside the watch, and passes each tick to a watch.

use std::hint::black_box;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use palpate_device::clock::{Clock, MonotonicClock, SteppedClock};
use palpate_device::{Device, DeviceErrorKind, NullDevice, ReplayDevice, ScriptedDevice, Step};
use palpate_record::recording::Flags;
use palpate_rt::safety::{OscillationParams, SafetyParams, SafetyStop};
use palpate_rt::{ControlLoop, Ending, Message, Note, StopFlag, tap};
use palpate_scene::method::MethodName;
use palpate_scene::{ContactFile, Scene, beside};
use palpate_study::sim::device::{PointerDevice, PointerHand, PointerParams, SimulatedDevice};

use crate::hostile::anything;
use crate::in_worlds::{a_slow_host, faults_in_a_world, six_axes, worlds, worlds_that_change};
use crate::several::{a_pinch, anything_of_two, faults_of_each};

/// Runs a tick and monitors it.
pub type Watch<'a> = dyn FnMut(&mut dyn FnMut()) + 'a;

/// A named situation.
pub type Situation = (&'static str, fn(&mut Watch));

/// Every situation in which the clock is advanced by hand.
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

/// Every situation in real time.
pub const MONOTONIC: [Situation; 2] = [
    ("real time, asleep and awake", real_time),
    ("a run that is stopped", a_run_that_is_stopped),
];

/// Loads a scene of `experiments/`.
#[must_use]
pub fn scene(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../experiments")
        .join(name);
    let text = std::fs::read_to_string(&path).unwrap();
    ContactFile::parse_with(name, &text, &mut beside(&path))
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
    let device = SimulatedDevice::new(scene, clock.clone()).unwrap();
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
    assert_eq!(control.safety_stop(), Some(SafetyStop::DeviceLost));
}

fn faults(watch: &mut Watch) {
    use DeviceErrorKind::{Disconnected, NothingNew, Refused};
    let limits = SafetyParams {
        workspace: Some([[-0.05; 3], [0.05; 3]]),
        largest_speed: 2.0,
        ..SafetyParams::default()
    };
    let faults = [
        (Step::At([f64::NAN; 3]), SafetyStop::NotANumber),
        (Step::At([f64::INFINITY; 3]), SafetyStop::NotANumber),
        (Step::Stale, SafetyStop::StaleSample),
        (Step::Fails(NothingNew), SafetyStop::StaleSample),
        (at(60.0), SafetyStop::OutsideWorkspace),
        (at(40.0), SafetyStop::TooFast),
        (Step::Fails(Refused), SafetyStop::DeviceRefused),
        (Step::Fails(Disconnected), SafetyStop::DeviceLost),
        (
            Step::FailsForce(Refused, [1e-3, 0.0, 0.0]),
            SafetyStop::DeviceRefused,
        ),
    ];
    for (fault, safety_stop) in faults {
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
            .filter_map(|messages| match messages {
                Message::Note(noted) => Some(noted.note),
                Message::Tick(..) => None,
            })
            .collect();
        assert!(
            notes.contains(&Note::Stopped(safety_stop)),
            "{fault:?}: {notes:?}"
        );
        let rearmed = notes.contains(&Note::Rearmed);
        assert_eq!(rearmed, !safety_stop.is_passing(), "{fault:?}: {notes:?}");
        assert_eq!(control.safety_stop(), None, "{fault:?}");
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
    let limited = listener.filter(|messages| match messages {
        Message::Tick(tick, ..) => tick.flags.has(Flags::SAFETY_LIMITED),
        Message::Note(_) => false,
    });
    assert_eq!(limited.count(), 400);
}

fn oscillation(watch: &mut Watch) {
    let mut buzzing = scene("experiment2.toml");
    buzzing.contact.stiffness *= 4.0;
    let mut control = simulated(&buzzing, MethodName::Basic, SafetyParams::default());
    ticks(&mut control, 2000, watch);
    assert_eq!(control.safety_stop(), Some(SafetyStop::Oscillation));
}

/// Returns limits that are never reached here.
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

/// Another thread changes the parameters as fast as possible.
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
        // On few processors the other thread may have to wait.
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
    // Nor after the listener has been dropped.
    drop(listener);
    ticks(&mut control, 500, watch);
}

fn a_pointer(watch: &mut Watch) {
    let scene = scene("live.toml");
    for method in [MethodName::Basic, MethodName::Coupled] {
        let clock = SteppedClock::new();
        let hand = PointerHand::at(0.0);
        let device = PointerDevice::new(PointerParams::new(&scene), &hand, clock.clone()).unwrap();
        let rendering = scene.rendering(method).unwrap();
        let mut control =
            ControlLoop::new(device, clock, rendering, SafetyParams::default()).unwrap();
        for number in 0..60 {
            match number % 6 {
                5 => hand.disable_output(),
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
        let device = SimulatedDevice::new(&scene, clock).unwrap();
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
    let device = SimulatedDevice::new(&scene("wall.toml"), clock).unwrap();
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
