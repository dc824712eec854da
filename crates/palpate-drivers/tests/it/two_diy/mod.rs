//! Driver of the 2DIY with an emulated board and arm.

#![cfg(unix)]

mod disabling;
mod faults;
mod motors;
mod opening;
mod replies;
mod wall;

use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use palpate_core::{AlongAxis, AnyParams, Contact, LoopParams, ObjectState};
use palpate_device::clock::MonotonicClock;
use palpate_device::{Device, DeviceErrorKind, Pose};
use palpate_drivers::emulator::port::PortSettings;
use palpate_drivers::emulator::two_diy::{Did, Emulator, Hand, Seen, Settings};
use palpate_drivers::two_diy::{Board, Calibration, Generation, OpenError, Options, TwoDiy};
use palpate_rt::safety::SafetyParams;
use palpate_rt::{ControlLoop, Rendering};

/// Centre of the third generation's workspace `[degrees]`, and the end-point there `[m]`.
const MIDDLE: [f32; 2] = [130.0, 50.0];
const THERE: [f64; 2] = [0.019, 0.1169];

/// A period that even a busy machine keeps.
const SLOW: Duration = Duration::from_millis(40);
/// Period of the loops with faults: at 1 kHz a busy machine has faults of its own.
const PERIOD: Duration = Duration::from_millis(10);

/// Serialises the tests: boards and loops run in real time and need a processor each.
fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(PoisonError::into_inner)
}

fn in_the_middle(hand: Hand) -> Settings {
    Settings {
        angles: Some(MIDDLE.map(f64::from)),
        hand,
        ..Settings::new(Generation::Three, Board::M0)
    }
}

/// The same board on a socket. A kernel worker transfers the bytes of a terminal and may be delayed by seconds beside
/// busy loops, which the test would take for a fault of the board.
fn on_a_socket(settings: Settings) -> Settings {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    // The emulator removes it.
    let name = format!("palpate-two-diy-{}-{number}", std::process::id());
    let path = std::env::temp_dir().join(name);
    let port = PortSettings::Socket { path };
    Settings { port, ..settings }
}

/// Common clock of every loop and its device, so that their time stamps are comparable.
fn clock() -> MonotonicClock {
    static CLOCK: LazyLock<MonotonicClock> = LazyLock::new(MonotonicClock::new);
    *CLOCK
}

fn open_in_the_middle(emulator: &Emulator, period: Duration) -> TwoDiy<MonotonicClock> {
    open_at(&emulator.path(), period).unwrap()
}

fn open_at(port: &Path, period: Duration) -> Result<TwoDiy<MonotonicClock>, OpenError> {
    let calibration = Calibration::At(MIDDLE);
    let options = Options::new(Generation::Three, calibration, period).unwrap();
    TwoDiy::open(port, &options, clock())
}

/// Opens a device on a terminal, and retries if the kernel delivers its answers too late.
fn open_on_a_terminal(port: &Path, options: &Options) -> TwoDiy<MonotonicClock> {
    let mut opened = TwoDiy::open(port, options, clock());
    wait_until("an answer over a terminal", || {
        let is_late = matches!(
            opened,
            Err(OpenError::NoAnswer(_)
                | OpenError::WrongAnswer { .. }
                | OpenError::BrokenAnswer(_)
                | OpenError::NotInPose { .. })
        );
        if is_late {
            opened = TwoDiy::open(port, options, clock());
        }
        !is_late
    });
    opened.unwrap()
}

/// Returns the device's next sample; on a busy machine an answer may be too late for its read.
fn sample(device: &mut impl Device) -> Pose {
    let mut read = device.read();
    wait_until("a sample", || {
        let is_late = matches!(&read, Err(error) if error.kind == DeviceErrorKind::NothingNew);
        if is_late {
            read = device.read();
        }
        !is_late
    });
    read.unwrap()
}

/// Wall into which a hand at [`THERE`] presses by about 4 mm.
fn wall<D: Device>(
    device: D,
    stiffness: f64,
    period: Duration,
    stall_after_periods: f64,
) -> ControlLoop<D, MonotonicClock> {
    let rendering = Rendering {
        contact: Contact::object(stiffness, f64::INFINITY),
        loop_params: LoopParams::new(period.as_secs_f64()),
        params: AnyParams::Basic,
        virtual_force: 0.0,
        object: ObjectState::at_rest(0.0),
    };
    let limits = SafetyParams {
        soft_start: 0.0,
        stall_after_periods,
        ..SafetyParams::for_device(device.capabilities())
    };
    let origin = [THERE[0], THERE[1] - 0.008, 0.0];
    let axis = AlongAxis::new(origin, [0.0, 1.0, 0.0]).unwrap();
    ControlLoop::new(device, clock(), rendering, limits)
        .unwrap()
        .along(axis)
}

fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(
            begun.elapsed() < Duration::from_secs(120),
            "waiting for {what}"
        );
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn is_none(torques: [f64; 2]) -> bool {
    torques == [0.0; 2]
}

/// Checks that only complete packets arrived, and no layout was cleared while a torque was on.
fn came_whole_and_without_torque_at_resets(seen: &[Seen]) {
    for seen in seen {
        match seen.did {
            Did::Reset | Did::SetUp => assert!(is_none(seen.torques), "{seen:?}"),
            Did::Commanded(_) => {}
            Did::Discarded(byte) => panic!("a byte that is no command: {byte:#x}"),
        }
    }
}
