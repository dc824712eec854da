//! Motor drives on emulated ones, in real time.

use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use palpate_device::clock::MonotonicClock;
use palpate_device::{Device, DeviceError, DeviceErrorKind, Pose, Wrench};
use palpate_drivers::drive::{Drive, Moteus, Odrive, OpenError, Options};
use palpate_drivers::emulator::drive::{Emulator, Fault, Maker, Settings};
use palpate_drivers::emulator::port::PortSettings;

const MAKERS: [Maker; 2] = [Maker::Moteus, Maker::Odrive];
const RADIUS: f64 = 0.02;

struct Bench {
    emulator: Emulator,
    maker: Maker,
    _folder: tempfile::TempDir,
}

/// A drive behind a socket, whose lines a busy machine does not delay.
fn bench(maker: Maker) -> Bench {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("port");
    let settings = Settings {
        port: PortSettings::Socket { path },
        ..Settings::new(maker)
    };
    Bench {
        emulator: Emulator::start(&settings).unwrap(),
        maker,
        _folder: folder,
    }
}

type Opened = (Box<dyn Device>, Receiver<String>);

impl Bench {
    /// A watchdog of 0.2 s, and answers for which a busy machine has time.
    fn options(&self) -> Options {
        Options {
            patience: Duration::from_millis(100),
            silence: Duration::from_millis(200),
            ..Options::new(&self.emulator.path(), RADIUS, 0.1, Duration::from_millis(1))
        }
    }

    fn try_open(&self, options: &Options, number: u8) -> Result<Opened, OpenError> {
        let (tell, messages) = channel();
        let tell = move |text| tell.send(text).unwrap();
        let clock = MonotonicClock::new();
        let device: Box<dyn Device> = match self.maker {
            Maker::Moteus => {
                let axis = Moteus::new(number).unwrap();
                Box::new(Drive::open(axis, options, clock, tell)?)
            }
            Maker::Odrive => {
                let axis = Odrive::new(number).unwrap();
                Box::new(Drive::open(axis, options, clock, tell)?)
            }
        };
        Ok((device, messages))
    }

    fn open(&self) -> Opened {
        let number = Settings::new(self.maker).number;
        self.try_open(&self.options(), number).unwrap()
    }

    #[track_caller]
    fn wait_for(&self, what: &str, mut is_so: impl FnMut(&Self) -> bool) {
        let begun = Instant::now();
        while !is_so(self) {
            assert!(
                begun.elapsed() < Duration::from_secs(30),
                "{:?}: {what}",
                self.maker
            );
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

fn pushed(x: f64) -> Wrench {
    Wrench::of_force([x, 0.0, 0.0])
}

/// Reads until a sample comes.
#[track_caller]
fn sample(device: &mut dyn Device) -> Pose {
    let begun = Instant::now();
    loop {
        match device.read() {
            Ok(pose) => return pose,
            Err(error) => assert!(begun.elapsed() < Duration::from_secs(30), "{error}"),
        }
    }
}

/// Reads until an error of this kind comes, with zero force at samples.
#[track_caller]
fn failure(device: &mut dyn Device, kind: DeviceErrorKind) -> DeviceError {
    let begun = Instant::now();
    loop {
        if let Err(error) = device.read()
            && error.kind == kind
        {
            return error;
        }
        device.write(Wrench::NONE).unwrap();
        assert!(begun.elapsed() < Duration::from_secs(30), "{kind:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_force_moves_the_handle_and_the_end_switches_the_motor_off() {
    for maker in MAKERS {
        let bench = bench(maker);
        let (mut device, messages) = bench.open();
        let can = device.capabilities().clone();
        assert_eq!((can.axes, can.holds_last_force), (1, false));
        assert!((can.largest_force.unwrap() - 5.0).abs() < 1e-9);
        assert_eq!(bench.emulator.torque(), 0.0);
        // 1 N against a spring of 100 N/m.
        bench.wait_for("the handle at 10 mm", |bench| {
            let pose = sample(&mut *device);
            let held = device.write(pushed(1.0)).unwrap();
            assert!((held.force[0] - 1.0).abs() < 1e-6, "{held:?}");
            let there = bench.emulator.position();
            (there - 0.01).abs() < 2e-4 && (pose.position[0] - there).abs() < 2e-4
        });
        assert!((bench.emulator.torque() - RADIUS).abs() < 1e-6);
        // More than the drive may.
        let held = device.write(pushed(-30.0)).unwrap();
        assert!((held.force[0] + 5.0).abs() < 1e-6, "{held:?}");
        bench.wait_for("the largest torque", |bench| {
            (bench.emulator.torque() + 0.1).abs() < 1e-6
        });
        assert!(device.write(pushed(f64::NAN)).is_err());
        assert!(device.connection().unwrap().samples > 1);
        drop(device);
        bench.wait_for("a motor that is off", |bench| bench.emulator.is_off());
        assert_eq!(bench.emulator.torque(), 0.0);
        assert_eq!(messages.try_recv().ok(), None);
    }
}

#[test]
fn the_watchdog_of_the_drive_takes_the_torque_of_a_stalled_loop_off() {
    for maker in MAKERS {
        let bench = bench(maker);
        let (mut device, _messages) = bench.open();
        sample(&mut *device);
        device.was_cut();
        device.write(pushed(1.0)).unwrap();
        bench.wait_for("a torque", |bench| bench.emulator.torque() != 0.0);
        // No command follows.
        bench.wait_for("no torque", |bench| bench.emulator.torque() == 0.0);
        assert!(bench.emulator.was_cut());
        // The position is valid, and the drive starts again.
        sample(&mut *device);
        assert!(device.was_cut() && !device.was_cut());
        assert_eq!(device.write(pushed(1.0)).unwrap(), Wrench::NONE);
        bench.wait_for("a torque again", |bench| {
            sample(&mut *device);
            device.write(pushed(1.0)).unwrap();
            bench.emulator.torque() > 0.0
        });
    }
}

/// A loss is a second of silence.
#[test]
fn a_lost_or_torn_answer_is_a_missing_sample_and_a_long_silence_a_loss() {
    for maker in MAKERS {
        let bench = bench(maker);
        let (mut device, messages) = bench.open();
        sample(&mut *device);
        bench.emulator.inject(Fault::TornLine);
        failure(&mut *device, DeviceErrorKind::NothingNew);
        sample(&mut *device);
        bench
            .emulator
            .inject(Fault::Silence(Duration::from_millis(150)));
        failure(&mut *device, DeviceErrorKind::NothingNew);
        sample(&mut *device);
        bench
            .emulator
            .inject(Fault::Silence(Duration::from_secs(600)));
        let error = failure(&mut *device, DeviceErrorKind::Disconnected);
        drop(device);
        let said = messages.try_recv().unwrap();
        assert!(said.contains(error.what), "{said}");
        bench.emulator.inject(Fault::Silence(Duration::ZERO));
        let (mut device, _messages) = bench.open();
        sample(&mut *device);
    }
}

#[test]
fn a_fault_another_mode_and_a_jump_are_refused() {
    for maker in MAKERS {
        for (fault, words) in [
            (Fault::Code(35), ["fault 35", "has an error"]),
            (Fault::Mode, ["another mode", "closed-loop"]),
            (Fault::Jump(10.0), ["has jumped"; 2]),
        ] {
            let bench = bench(maker);
            let (mut device, _messages) = bench.open();
            sample(&mut *device);
            // An ODrive may be idle for some answers after its start.
            for _ in 0..60 {
                sample(&mut *device);
                device.write(pushed(1.0)).unwrap();
            }
            bench.emulator.inject(fault);
            let error = failure(&mut *device, DeviceErrorKind::Refused);
            let words = words[usize::from(maker == Maker::Odrive)];
            assert!(error.what.contains(words), "{error}");
            // No torque until the operator has looked.
            assert_eq!(device.write(pushed(1.0)).unwrap(), Wrench::NONE);
            bench.wait_for("no torque", |bench| bench.emulator.torque() == 0.0);
            assert!(device.read().is_err());
            drop(device);
            let (mut device, _messages) = bench.open();
            sample(&mut *device);
        }
    }
}

#[test]
fn a_coordinate_has_its_zero_and_its_direction() {
    for maker in MAKERS {
        let bench = bench(maker);
        let right = bench.options();
        let options = Options {
            travel: -right.travel,
            zero: 0.25,
            ..right.clone()
        };
        let number = Settings::new(maker).number;
        let (mut device, _messages) = bench.try_open(&options, number).unwrap();
        let quarter = 0.25 * right.travel;
        let expected = |bench: &Bench| quarter - bench.emulator.position();
        bench.wait_for("the handle at 10 mm in the other direction", |bench| {
            let pose = sample(&mut *device);
            device.write(pushed(-1.0)).unwrap();
            let there = bench.emulator.position();
            (there - 0.01).abs() < 2e-4 && (pose.position[0] - expected(bench)).abs() < 2e-4
        });
    }
}

#[test]
fn what_cannot_be_opened_is_named() {
    for maker in MAKERS {
        let bench = bench(maker);
        let number = Settings::new(maker).number;
        let refused =
            |options: &Options, number| bench.try_open(options, number).err().unwrap().to_string();
        let right = bench.options();
        let words = refused(&right, number + 1);
        let expected = ["does not answer", "has no axis1.current_state"];
        assert!(
            words.contains(expected[usize::from(maker == Maker::Odrive)]),
            "{words}"
        );
        for (options, expected) in [
            (
                Options {
                    travel: 0.0,
                    ..right.clone()
                },
                "the travel per turn is 0",
            ),
            (
                Options {
                    largest_torque: f64::NAN,
                    ..right.clone()
                },
                "the largest torque is NaN",
            ),
            (
                Options {
                    silence: Duration::from_secs(2),
                    ..right.clone()
                },
                "0.002 to 1 [s]",
            ),
            (
                Options {
                    port: "no-port".into(),
                    ..right.clone()
                },
                "no-port: ",
            ),
        ] {
            let words = refused(&options, number);
            assert!(words.contains(expected), "{words}");
        }
        assert!(bench.emulator.is_off());
    }
}
