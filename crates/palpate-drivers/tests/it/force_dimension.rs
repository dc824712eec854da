//! Force Dimension's devices, behind an emulated library.

use std::path::Path;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use palpate_device::clock::{Clock, SteppedClock};
use palpate_device::{Device, DeviceErrorKind, Wrench};
use palpate_drivers::emulator::force_dimension::{Emulator, EmulatorOptions};
use palpate_drivers::force_dimension::{ForceDimension, Kind, OpenError, Options, Part};

const MS: Duration = Duration::from_millis(1);

struct Bench {
    clock: SteppedClock,
    emulator: Emulator,
    /// Contains the library and the socket.
    _folder: tempfile::TempDir,
}

fn bench(options: &EmulatorOptions) -> Bench {
    let (folder, clock) = (tempfile::tempdir().unwrap(), SteppedClock::new());
    let emulator = Emulator::start(folder.path(), options, &clock).unwrap();
    Bench {
        clock,
        emulator,
        _folder: folder,
    }
}

fn of_kind(name: &str) -> EmulatorOptions {
    EmulatorOptions {
        kind: Kind::of_name(name).unwrap(),
        ..EmulatorOptions::default()
    }
}

impl Bench {
    fn options(&self) -> Options {
        Options {
            library: Some(self.emulator.library().to_owned()),
            ..Options::new(MS, 4 * MS)
        }
    }

    fn try_open(
        &self,
        options: &Options,
    ) -> Result<(ForceDimension<SteppedClock>, Receiver<String>), OpenError> {
        let (tell, told) = channel();
        let tell = move |text| tell.send(text).unwrap();
        ForceDimension::open(options, self.clock.clone(), tell).map(|device| (device, told))
    }

    fn open(&self) -> (ForceDimension<SteppedClock>, Receiver<String>) {
        self.try_open(&self.options()).unwrap()
    }

    /// Returns the words of a refusal.
    #[track_caller]
    fn refused(&self, options: &Options) -> String {
        self.try_open(options).unwrap_err().to_string()
    }

    fn force(&self) -> [f64; 3] {
        self.emulator.held(&self.clock).0
    }
}

fn pushed(x: f64) -> Wrench {
    Wrench::of_force([x, 0.0, 0.0])
}

#[test]
fn a_force_moves_the_handle_and_the_end_takes_it_off() {
    let bench = bench(&EmulatorOptions::default());
    let (mut device, told) = bench.open();
    let can = device.capabilities().clone();
    assert_eq!(
        (can.name.as_str(), can.axes, can.torque_axes),
        ("omega.3", 3, 0)
    );
    assert_eq!(can.largest_force, Some(12.0));
    assert!((can.effective_mass.unwrap() - 0.2).abs() < 1e-12);
    let mass = device.mass().unwrap();
    assert_eq!(mass.matrix, [0.2, 0.2, 0.2, 0.0, 0.0, 0.0]);
    assert_eq!(mass.position, [0.0; 3]);
    assert!(!can.holds_last_force && !can.measures_orientation);
    assert_eq!(device.watchdog(), Some(4 * MS));
    assert_eq!(bench.emulator.limits()[0], 12.0);
    assert!(bench.emulator.has_gravity_compensation() && bench.emulator.is_open());
    for _ in 0..200 {
        bench.clock.advance(MS);
        device.read().unwrap();
        assert_eq!(device.write(pushed(1.0)).unwrap(), pushed(1.0));
    }
    // 1 N against a spring of 100 N/m, within its oscillation.
    let there = device.read().unwrap();
    assert_eq!(there.position, bench.emulator.position());
    assert!((0.005..0.015).contains(&there.position[0]), "{there:?}");
    assert_eq!(there.time, bench.clock.now());
    // Larger than the device can.
    assert_eq!(device.write(pushed(-30.0)).unwrap(), pushed(-12.0));
    assert_eq!(bench.force(), [-12.0, 0.0, 0.0]);
    assert_eq!(device.connection().unwrap().samples, 201);
    drop(device);
    assert_eq!(bench.force(), [0.0; 3]);
    assert!(!bench.emulator.is_open() && told.try_recv().is_err());
}

#[test]
fn the_firmware_takes_the_force_of_a_stalled_loop_off_and_the_next_command_has_one_again() {
    let bench = bench(&EmulatorOptions::default());
    let (mut device, _told) = bench.open();
    // The loop starts later than the watchdog.
    bench.clock.advance(100 * MS);
    device.read().unwrap();
    assert!(!device.was_cut());
    device.write(pushed(2.0)).unwrap();
    bench.clock.advance(4 * MS);
    assert_eq!(bench.force(), [2.0, 0.0, 0.0]);
    assert!(!bench.emulator.was_cut());
    bench.clock.advance(MS);
    assert_eq!(bench.force(), [0.0; 3]);
    assert!(bench.emulator.was_cut());
    device.read().unwrap();
    assert!(device.was_cut() && !device.was_cut());
    device.write(pushed(1.0)).unwrap();
    assert_eq!(bench.force(), [1.0, 0.0, 0.0]);
}

#[test]
fn a_device_without_a_watchdog_says_that_it_holds_its_force() {
    let bench = bench(&EmulatorOptions {
        has_watchdog: false,
        ..of_kind("Falcon")
    });
    let (mut device, _told) = bench.open();
    assert!(device.capabilities().holds_last_force);
    assert_eq!(device.capabilities().largest_force, Some(8.0));
    device.write(pushed(2.0)).unwrap();
    bench.clock.advance(1000 * MS);
    assert_eq!(bench.force(), [2.0, 0.0, 0.0]);
    device.read().unwrap();
    assert!(!device.was_cut());
}

#[test]
fn a_wrist_is_an_orientation_and_its_motors_hold_torques() {
    let bench = bench(&EmulatorOptions {
        wrist: [0.0, 0.0, 0.6],
        ..of_kind("sigma.7-right")
    });
    let (mut device, _told) = bench.open();
    let can = device.capabilities().clone();
    assert_eq!((can.torque_axes, can.largest_torque), (3, Some(0.4)));
    let turned = device.read().unwrap().orientation.unwrap();
    for (found, expected) in turned.iter().zip([0.3_f64.cos(), 0.0, 0.0, 0.3_f64.sin()]) {
        assert!((found - expected).abs() < 1e-12, "{turned:?}");
    }
    let asked = Wrench {
        force: [0.0, 1.0, 0.0],
        torque: [0.0, 0.0, 0.1],
    };
    for _ in 0..100 {
        assert_eq!(device.write(asked).unwrap(), asked);
        bench.clock.advance(MS);
    }
    let (force, torque, grip) = bench.emulator.held(&bench.clock);
    assert_eq!((force, torque, grip), (asked.force, asked.torque, 0.0));
    // 0.1 N m against a spring of 0.5 N m/rad.
    let [w, _, _, z] = device.read().unwrap().orientation.unwrap();
    let angle = 2.0 * z.atan2(w);
    assert!((0.65..0.95).contains(&angle), "{angle}");
    drop(device);
    assert_eq!(bench.emulator.held(&bench.clock).1, [0.0; 3]);
}

/// Its wrist has no motors.
#[test]
fn an_omega_6_turns_by_hand_and_has_no_torque() {
    let bench = bench(&of_kind("omega.6-left"));
    let (mut device, _told) = bench.open();
    let can = device.capabilities().clone();
    assert!(can.measures_orientation);
    assert_eq!(can.torque_axes, 0);
    let torque = Wrench {
        torque: [0.0, 0.1, 0.0],
        ..pushed(1.0)
    };
    assert_eq!(device.write(torque).unwrap(), pushed(1.0));
}

#[test]
fn the_gripper_is_a_device_of_one_axis() {
    let bench = bench(&of_kind("omega.7-right"));
    let options = Options {
        part: Part::Gripper,
        ..bench.options()
    };
    let (mut device, _told) = bench.try_open(&options).unwrap();
    let can = device.capabilities().clone();
    assert_eq!((can.name.as_str(), can.axes), ("omega.7-right gripper", 1));
    assert_eq!((can.largest_force, can.effective_mass), (Some(8.0), None));
    let open = device.read().unwrap().position;
    assert_eq!(open, [0.015, 0.0, 0.0]);
    for _ in 0..100 {
        assert_eq!(device.write(pushed(1.0)).unwrap(), pushed(1.0));
        bench.clock.advance(MS);
    }
    assert_eq!(bench.emulator.held(&bench.clock), ([0.0; 3], [0.0; 3], 1.0));
    // 1 N against a spring of 200 N/m.
    let wider = device.read().unwrap().position[0] - open[0];
    assert!((0.003..0.009).contains(&wider), "{wider}");
}

#[test]
fn devices_that_cannot_be_used_say_why() {
    let bench = bench(&EmulatorOptions::default());
    let options = bench.options();
    let none = Options {
        library: Some("/no/such/libdrd.so".into()),
        ..options.clone()
    };
    let said = bench.refused(&none);
    assert!(said.contains("/no/such/libdrd.so"), "{said}");
    let slow = Options {
        period: 22 * MS,
        ..options.clone()
    };
    let said = bench.refused(&slow);
    assert!(said.contains("22 ms; allowed: at most 21.25 ms"), "{said}");
    let grips = Options {
        part: Part::Gripper,
        ..options.clone()
    };
    assert!(bench.refused(&grips).contains("omega.3 has no gripper"));
    let other = Options {
        serial: Some(99),
        ..options.clone()
    };
    assert!(bench.refused(&other).contains("cannot be opened"));
    for (entry, value, words) in [
        (0, 0, "no power"),
        (1, 0, "not connected"),
        (2, 0, "not started"),
        (3, 1, "not calibrated"),
        (9, 1, "reports an error"),
    ] {
        let mut before = 0;
        bench
            .emulator
            .set_status(|status| before = std::mem::replace(&mut status[entry], value));
        let said = bench.refused(&options);
        assert!(said.contains(words), "{words}: {said}");
        assert_eq!(bench.force(), [0.0; 3]);
        assert!(!bench.emulator.is_open(), "{words}");
        bench.emulator.set_status(|status| status[entry] = before);
    }
    bench
        .emulator
        .trouble(|trouble| trouble.is_unplugged = true);
    assert!(bench.refused(&options).contains("plug one in"));
    bench
        .emulator
        .trouble(|trouble| trouble.is_unplugged = false);
    let named = Options {
        serial: Some(1234),
        ..options
    };
    bench.try_open(&named).unwrap();
}

#[test]
fn other_types_several_devices_and_an_uncalibrated_wrist_are_refused() {
    let mut controller = of_kind("delta.3");
    controller.kind.code = 81;
    let with = bench(&controller);
    let said = with.refused(&with.options());
    assert!(said.contains("type 81; allowed: 33 (omega.3)"), "{said}");
    let two = bench(&EmulatorOptions {
        devices: 2,
        ..EmulatorOptions::default()
    });
    assert!(two.refused(&two.options()).contains("serial number"));
    let wrist = bench(&of_kind("lambda.7-left"));
    wrist.emulator.set_status(|status| status[12] = 0);
    assert!(
        wrist
            .refused(&wrist.options())
            .contains("wrist that is not calibrated")
    );
}

#[test]
fn a_library_of_an_old_version_is_named() {
    let old = bench(&EmulatorOptions {
        without: vec!["dhdSetWatchdog".to_owned()],
        ..EmulatorOptions::default()
    });
    let said = old.refused(&old.options());
    assert!(
        said.contains("no function dhdSetWatchdog") && said.contains("3.16"),
        "{said}"
    );
    let empty = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    let options = Options {
        library: Some(empty),
        ..old.options()
    };
    assert!(old.refused(&options).contains("Cargo.toml"));
}

#[test]
fn a_device_that_is_unplugged_in_motion_is_gone() {
    let bench = bench(&EmulatorOptions::default());
    let (mut device, told) = bench.open();
    device.write(pushed(1.0)).unwrap();
    bench
        .emulator
        .trouble(|trouble| trouble.is_unplugged = true);
    bench.clock.advance(MS);
    for error in [
        device.read().unwrap_err(),
        device.write(pushed(1.0)).unwrap_err(),
    ] {
        assert_eq!(error.kind, DeviceErrorKind::Disconnected);
        assert!(error.what.contains("unplugged"), "{error}");
    }
    drop(device);
    let said = told.recv().unwrap();
    assert!(
        said.contains("unplugged") && said.contains("communication error"),
        "{said}"
    );
    // The device is on its own, and so is its watchdog.
    bench.clock.advance(10 * MS);
    assert_eq!(bench.force(), [0.0; 3]);
}

#[test]
fn a_state_that_changes_in_motion_is_refused_with_its_reason() {
    let bench = bench(&EmulatorOptions::default());
    let (mut device, told) = bench.open();
    bench.emulator.trouble(|trouble| trouble.is_nan = true);
    let error = device.read().unwrap_err();
    assert_eq!(error.kind, DeviceErrorKind::Interrupted);
    assert!(error.what.contains("no number"), "{error}");
    assert_eq!(device.connection().unwrap().unreadable, 1);
    let error = device.write(pushed(f64::NAN)).unwrap_err();
    assert_eq!(error.kind, DeviceErrorKind::Refused);
    assert_eq!(bench.force(), [0.0; 3]);
    drop(device);
    assert!(told.recv().unwrap().contains("no number"));
}

#[test]
fn saturation_and_missing_samples_are_counted() {
    let bench = bench(&EmulatorOptions::default());
    let (mut device, told) = bench.open();
    bench.emulator.trouble(|trouble| {
        trouble.saturates_above = Some(5.0);
        trouble.stale_reads = 2;
    });
    for _ in 0..2 {
        let error = device.read().unwrap_err();
        assert_eq!(error.kind, DeviceErrorKind::NothingNew);
    }
    device.read().unwrap();
    device.write(pushed(4.0)).unwrap();
    assert_eq!(device.connection().unwrap().untaken, 0);
    device.write(pushed(8.0)).unwrap();
    assert_eq!(bench.force(), [5.0, 0.0, 0.0]);
    let connection = device.connection().unwrap();
    assert_eq!(
        (connection.samples, connection.lost, connection.untaken),
        (1, 2, 1)
    );
    drop(device);
    let said = told.recv().unwrap();
    assert!(said.contains("1 of about 1 commands saturated"), "{said}");
}
