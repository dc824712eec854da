//! Real-time loop that renders a wall on an emulated Inverse3.

use std::path::Path;
use std::time::{Duration, Instant};

use palpate_device::Device;
use palpate_device::clock::MonotonicClock;
use palpate_drivers::emulator::inverse3::{
    Body, Emulator, EmulatorOptions, Fault, Latency, holding,
};
use palpate_drivers::inverse3::{Form, Inspector, Inverse3};
use palpate_rt::realtime::Request;
use palpate_rt::safety::{SafetyParams, SafetyStop};
use palpate_rt::{
    ControlLoop, Ending, Listener, LoopEnd, LoopThread, Message, Note, Rendering, StopFlag,
};
use palpate_scene::ContactFile;
use palpate_scene::method::MethodName;

use crate::inverse3::{ID, ms, options, wait_until};

/// 500 N/m at 1 kHz, at x = 0.
fn wall(method: MethodName) -> Rendering {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments/wall.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let mut scene = ContactFile::parse("wall.toml", &text).unwrap().scene;
    scene.contact.stiffness = 500.0;
    scene.object.position = 0.0;
    scene.loop_params.period = 0.001;
    scene.virtual_force = 0.0;
    scene.rendering(method).unwrap()
}

/// Device that a hand of 100 N/m and 5 N s/m pulls 10 mm into the wall, starting 10 mm outside.
fn pressed(form: Form, latency: Latency) -> Emulator {
    let mut body = Body {
        start: [-0.01, 0.0, 0.0],
        ..Body::default()
    };
    body.hands[0] = holding(0.01, 100.0, 5.0);
    Emulator::start(&EmulatorOptions {
        form,
        body,
        latency,
        ..EmulatorOptions::default()
    })
    .unwrap()
}

struct Run {
    running: LoopThread<Inverse3<MonotonicClock>, MonotonicClock>,
    inspector: Inspector,
    listener: Listener,
}

/// Messages of a loop.
struct Heard {
    /// Whether a sample was missing, and the sent force `[N]`.
    ticks: Vec<(bool, f64)>,
    notes: Vec<Note>,
    end: LoopEnd<Inverse3<MonotonicClock>, MonotonicClock>,
}

impl Run {
    fn on(emulator: &Emulator) -> Self {
        let clock = MonotonicClock::new();
        let device = Inverse3::open(&options(emulator), clock).unwrap();
        let inspector = device.inspector();
        let limits = SafetyParams {
            soft_start: 0.05,
            ..SafetyParams::for_device(device.capabilities())
        };
        let control = ControlLoop::new(device, clock, wall(MethodName::Basic), limits).unwrap();
        let (tap, listener) = palpate_rt::tap(1 << 16);
        let control = control.tapped(tap);
        let stop = StopFlag::new();
        let running = LoopThread::start(control, Request::nothing(), &stop, None).unwrap();
        Self {
            running,
            inspector,
            listener,
        }
    }

    /// Waits until the wall pushes back.
    fn until_it_pushes(&self, emulator: &Emulator) {
        wait_until("the wall pushes back", || {
            assert!(!self.running.has_ended());
            emulator.force(ID).unwrap()[0] < -0.5
        });
    }

    fn end(self) -> Heard {
        self.running.stop();
        let end = self.running.join();
        println!("{:?}", self.inspector.counts());
        let (mut ticks, mut notes) = (Vec::new(), Vec::new());
        for messages in self.listener {
            match messages {
                Message::Tick(tick, contacts, _, _) => {
                    let missing = tick
                        .flags
                        .has(palpate_record::recording::Flags::DEVICE_FAULT);
                    ticks.push((missing, contacts[0].force_on_device));
                }
                Message::Note(noted) => notes.push(noted.note),
            }
        }
        Heard { ticks, notes, end }
    }
}

impl Heard {
    /// Checks that of two successive ticks without a sample the second commanded zero force.
    fn no_force_after_two_periods_without_a_sample(&self) {
        for (index, pair) in self.ticks.windows(2).enumerate() {
            if let [(true, _), (true, force)] = pair {
                assert_eq!(*force, 0.0, "tick {}", index + 1);
            }
        }
    }
}

/// Returns the median force `[N]` and position `[m]` along x of 31 observations within 60 ms.
fn at_the_median(emulator: &Emulator) -> (f64, f64) {
    let (mut forces, mut places) = (Vec::new(), Vec::new());
    for _ in 0..31 {
        forces.push(emulator.force(ID).unwrap()[0]);
        places.push(emulator.position(ID).unwrap()[0]);
        std::thread::sleep(ms(2));
    }
    forces.sort_unstable_by(f64::total_cmp);
    places.sort_unstable_by(f64::total_cmp);
    (forces[15], places[15])
}

#[test]
fn a_wall_pushes_back_through_latency_and_jitter() {
    for (form, latency) in [
        (Form::V31, Latency::NONE),
        (
            Form::V35,
            Latency {
                least: Duration::from_micros(200),
                jitter: Duration::from_micros(300),
            },
        ),
    ] {
        let emulator = pressed(form, latency);
        let run = Run::on(&emulator);
        run.until_it_pushes(&emulator);
        // 500 x = 100 (0.01 - x): 0.833 N at 1.667 mm. A busy machine sometimes releases the device, but not for 60 ms
        // in a row.
        wait_until("force and place of hand and wall together", || {
            let (force, place) = at_the_median(&emulator);
            (place - 1.667e-3).abs() < 1e-4 && (force + 0.833).abs() < 0.05
        });
        let (force, place) = at_the_median(&emulator);
        let messages = run.end();
        let missing = messages
            .ticks
            .iter()
            .filter(|(missing, _)| *missing)
            .count();
        println!(
            "{form:?}, {latency:?}: {force:.3} N at {:.3} mm; {missing} of {} ticks without a sample",
            place * 1e3,
            messages.ticks.len()
        );
        assert_eq!(messages.end.ending, Ending::Stopped);
        messages.no_force_after_two_periods_without_a_sample();
        // The last command was zero force.
        drop(messages);
        assert_eq!(emulator.received().last().unwrap().force, Some([0.0; 3]));
    }
}

#[test]
fn what_passes_takes_the_force_away_and_gives_it_back() {
    for faults in [
        vec![Fault::Stall(ms(60))],
        vec![Fault::Garbage; 40],
        vec![Fault::HalfFrame; 40],
        vec![Fault::Dropped],
    ] {
        let emulator = pressed(Form::V35, Latency::NONE);
        let run = Run::on(&emulator);
        run.until_it_pushes(&emulator);
        let before = emulator.received().len();
        for fault in &faults {
            emulator.inject(*fault);
        }
        let injected = Instant::now();
        wait_until("no force", || {
            let received = emulator.received();
            received[before..]
                .iter()
                .any(|message| message.force == Some([0.0; 3]))
        });
        println!(
            "{:?}: no force has come after {:?}",
            faults[0],
            injected.elapsed()
        );
        run.until_it_pushes(&emulator);
        let messages = run.end();
        // On a busy machine the loop itself may be late first.
        let passing = [SafetyStop::StaleSample, SafetyStop::Stalled];
        let noted = |note: fn(SafetyStop) -> Note| {
            passing
                .iter()
                .any(|safety_stop| messages.notes.contains(&note(*safety_stop)))
        };
        assert!(
            noted(Note::Stopped),
            "{:?}: {:?}",
            faults[0],
            messages.notes
        );
        assert!(
            noted(Note::Recovered),
            "{:?}: {:?}",
            faults[0],
            messages.notes
        );
        assert_eq!(messages.end.ending, Ending::Stopped);
        messages.no_force_after_two_periods_without_a_sample();
    }
}

#[test]
fn what_stays_ends_the_run_with_its_reason_and_it_can_be_run_again() {
    let emulator = pressed(Form::V35, Latency::NONE);
    for (fault, words) in [
        (Some(Fault::Disconnect), "connection"),
        (Some(Fault::HalfBytes), "connection"),
        (Some(Fault::Close), "has closed the connection"),
        (None, "no longer lists the device"),
    ] {
        emulator.set_present(ID, true);
        let run = Run::on(&emulator);
        run.until_it_pushes(&emulator);
        match fault {
            Some(fault) => emulator.inject(fault),
            None => emulator.set_present(ID, false),
        }
        wait_until("the end of the run", || run.running.has_ended());
        wait_until("no force", || emulator.force(ID) == Some([0.0; 3]));
        let messages = run.end();
        assert_eq!(messages.end.ending, Ending::DeviceLost, "{fault:?}");
        assert_eq!(messages.end.safety_stop, Some(SafetyStop::DeviceLost));
        let said = messages
            .notes
            .iter()
            .any(|note| matches!(note, Note::Device(error) if error.what.contains(words)));
        assert!(said, "{fault:?}: {:?}", messages.notes);
        messages.no_force_after_two_periods_without_a_sample();
    }
}

#[test]
fn refusing_device_stays_disabled_until_rearmed() {
    let emulator = pressed(Form::V35, Latency::NONE);
    let mut run = Run::on(&emulator);
    run.until_it_pushes(&emulator);
    emulator.set_status(ID, |status| status.ready = Some(false));
    let stopped = Note::Stopped(SafetyStop::DeviceRefused);
    wait_until("the safety stop", || {
        let messages = run.listener.by_ref();
        messages.any(|messages| matches!(messages, Message::Note(noted) if noted.note == stopped))
    });
    wait_until("no force", || emulator.force(ID) == Some([0.0; 3]));
    emulator.set_status(ID, |status| status.ready = Some(true));
    std::thread::sleep(ms(50));
    assert_eq!(emulator.force(ID), Some([0.0; 3]));
    run.running.rearm();
    run.until_it_pushes(&emulator);
    assert!(run.end().notes.contains(&Note::Rearmed));
}
