use palpate_device::clock::Clock;
use palpate_device::{Capabilities, DeviceError, Wrench, ZeroWriter};
use palpate_rt::realtime::Request;
use palpate_rt::{Ending, LoopThread, StopFlag};

use super::*;

/// Device that panics or stalls on demand in the loop's own thread.
struct Spoilt<D> {
    device: D,
    reads: u32,
    panics_at: Option<u32>,
    stands_still_at: Option<u32>,
}

impl<D: Device> Device for Spoilt<D> {
    fn capabilities(&self) -> &Capabilities {
        self.device.capabilities()
    }
    fn read(&mut self) -> Result<Pose, DeviceError> {
        self.reads += 1;
        assert!(self.panics_at != Some(self.reads), "so it was told");
        if self.stands_still_at == Some(self.reads) {
            std::thread::sleep(Duration::from_millis(300));
        }
        self.device.read()
    }
    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        self.device.write(wrench)
    }
    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        self.device.zero_writer()
    }
}

fn spoilt(emulator: &Emulator) -> Spoilt<TwoDiy<MonotonicClock>> {
    Spoilt {
        device: open_in_the_middle(emulator, 2 * PERIOD),
        reads: 0,
        panics_at: None,
        stands_still_at: None,
    }
}

fn pressing(emulator: &Emulator) {
    wait_until("a force", || !is_none(emulator.torques()));
}

/// Loop in its own thread, with the device pressed into a wall.
fn pressed_wall<D: Device + Send + 'static>(
    device: D,
    emulator: &Emulator,
    stop: &StopFlag,
) -> LoopThread<D, MonotonicClock> {
    let control = wall(device, 150.0, PERIOD, 1.5);
    let running = LoopThread::start(control, Request::nothing(), stop, None).unwrap();
    pressing(emulator);
    running
}

#[test]
fn dropped_or_closed_it_holds_no_torque() {
    let _alone = alone();
    for closed in [true, false] {
        let emulator = Emulator::start(&on_a_socket(in_the_middle(Hand::at(THERE)))).unwrap();
        let mut device = open_in_the_middle(&emulator, SLOW);
        sample(&mut device);
        device.write([0.3, -0.8, 0.0].into()).unwrap();
        pressing(&emulator);
        if closed {
            device.close().unwrap();
        } else {
            drop(device);
        }
        assert!(is_none(emulator.torques()));
        came_whole_and_without_torque_at_resets(&emulator.seen());
    }
}

#[test]
fn a_loop_that_is_stopped_or_panics_leaves_no_torque() {
    let _alone = alone();
    for panics in [true, false] {
        let emulator = Emulator::start(&on_a_socket(in_the_middle(Hand::at(THERE)))).unwrap();
        let mut device = spoilt(&emulator);
        device.panics_at = panics.then_some(60);
        let stop = StopFlag::new();
        let running = pressed_wall(device, &emulator, &stop);
        if !panics {
            // As SIGTERM does.
            stop.raise();
        }
        wait_until("the end", || running.has_ended());
        wait_until("no force", || is_none(emulator.torques()));
        let end = running.join();
        let expected = if panics {
            Ending::Panicked
        } else {
            Ending::Stopped
        };
        assert_eq!(end.ending, expected);
    }
}

/// The loop's thread stalls with a force on. The supervisor removes the force, and the loop then repeats zero torque.
#[test]
fn a_loop_that_stands_still_is_cut_off() {
    let _alone = alone();
    let emulator = Emulator::start(&on_a_socket(in_the_middle(Hand::at(THERE)))).unwrap();
    let mut device = spoilt(&emulator);
    device.stands_still_at = Some(60);
    let stop = StopFlag::new();
    let running = pressed_wall(device, &emulator, &stop);
    let begun = Instant::now();
    // 300 ms in which only the supervisor could have done it.
    let mut none_since = None;
    wait_until("a long time without a force", || {
        if is_none(emulator.torques()) {
            let since = none_since.get_or_insert_with(Instant::now);
            since.elapsed() > Duration::from_millis(150)
        } else {
            none_since = None;
            false
        }
    });
    assert!(begun.elapsed() < Duration::from_secs(15));
    // The force returns through the soft start, and only complete packets are sent.
    wait_until("the force again", || !is_none(emulator.torques()));
    stop.raise();
    let end = running.join();
    assert!(end.cuts >= 1);
    came_whole_and_without_torque_at_resets(&emulator.seen());
}

/// `write_zero` returns at once, and the torque is zero in the end although the board stalls.
#[test]
fn the_zero_writer_waits_for_nobody() {
    let _alone = alone();
    use palpate_drivers::emulator::two_diy::Fault;
    let emulator = Emulator::start(&on_a_socket(in_the_middle(Hand::at(THERE)))).unwrap();
    let mut device = open_in_the_middle(&emulator, SLOW);
    let mut zero = device.zero_writer().unwrap();
    sample(&mut device);
    device.write([0.0, -1.0, 0.0].into()).unwrap();
    pressing(&emulator);
    emulator.inject_faults(Fault::Stall(Duration::from_millis(200)));
    std::thread::sleep(Duration::from_millis(5));
    let clock = crate::two_diy::clock();
    let begun = clock.now();
    for _ in 0..100 {
        zero.write_zero();
    }
    assert!(clock.now() - begun < Duration::from_millis(100));
    wait_until("no force", || is_none(emulator.torques()));
    // The device has noticed the cut and repeats zero torque.
    let _ = device.read();
    std::thread::sleep(Duration::from_millis(20));
    assert!(is_none(emulator.torques()));
    came_whole_and_without_torque_at_resets(&emulator.seen());
}

/// Without its watchdog process a device is not opened: it is closed again, holds zero torque and frees its port.
#[test]
fn a_device_whose_watchdog_cannot_be_started_is_closed_again() {
    let _alone = alone();
    let emulator = Emulator::start(&on_a_socket(in_the_middle(Hand::at(THERE)))).unwrap();
    for (program, words) in [
        ("/there/is/no/watchdog", "cannot be started"),
        ("true", "does not answer"),
    ] {
        let device = open_in_the_middle(&emulator, SLOW);
        let command = std::process::Command::new(program);
        let error = device
            .guarded_by(command, Duration::from_millis(100), Default::default())
            .unwrap_err();
        assert!(error.to_string().contains(words), "{program}: {error}");
        assert!(is_none(emulator.torques()), "{program}");
    }
    // The port is free, and the board is in its earlier state.
    sample(&mut open_in_the_middle(&emulator, SLOW));
    came_whole_and_without_torque_at_resets(&emulator.seen());
}
