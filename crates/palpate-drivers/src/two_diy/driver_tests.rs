//! The driver against a simulated board; each test decides when the board answers.

use std::sync::atomic::{AtomicBool, Ordering};

use palpate_device::clock::MonotonicClock;

use super::super::packet::STATE_LENGTH;
use super::*;
use crate::emulator::port::Pty;
use crate::serial::Serial;
use crate::two_diy::Generation;

const START: [f32; 2] = [130.0, 50.0];
/// Time that the driver waits for an answer that a test does not send.
const PATIENCE: Duration = Duration::from_millis(20);
/// Time limit for expected events on a busy machine.
const LIMIT: Duration = Duration::from_secs(30);

/// A driver and the board's end of its pseudo-terminal. The kernel transfers bytes with a delay, so every method waits
/// until the sent bytes have arrived.
struct Played {
    pty: Pty,
    device: TwoDiy<MonotonicClock>,
    /// STATE packets read from the line.
    taken: u64,
}

impl Played {
    fn new() -> Self {
        let pty = Pty::open(None).unwrap();
        let layout = Generation::Three.layout();
        let line = Line::new(Serial::open(pty.path()).unwrap(), layout).unwrap();
        let device = TwoDiy::new(Ready {
            clock: MonotonicClock::new(),
            line,
            layout,
            board: Board::M0,
            patience: PATIENCE,
            capabilities: Capabilities::unknown("played", 2),
            angles: START,
        });
        Self {
            pty,
            device,
            taken: 0,
        }
    }

    fn answer(&self, angles: [f32; 2]) -> Vec<u8> {
        let layout = self.device.layout();
        let mut answer = vec![layout.device_id];
        for angle in layout.by_encoder_port(angles) {
            answer.extend(angle.to_le_bytes());
        }
        answer
    }

    fn says(&self, angles: [f32; 2]) {
        self.sends(&self.answer(angles));
    }

    /// Sends, and waits until the driver's end has the bytes. Not while the driver reads.
    fn sends(&self, bytes: &[u8]) {
        let expected = self.pty.unread().unwrap() + bytes.len() as u64;
        self.pty.write(bytes);
        let begun = Instant::now();
        while self.pty.unread().unwrap() < expected {
            assert!(begun.elapsed() < LIMIT, "the bytes do not arrive");
            std::thread::sleep(Duration::from_micros(100));
        }
    }

    /// Returns the torques on port 1 of all packets sent since the last call.
    fn received(&mut self) -> Vec<f32> {
        let begun = Instant::now();
        let mut bytes = Vec::new();
        loop {
            let is_settled = !self.device.line.cutter().is_wanted();
            let sent = self.device.line.requests() - self.taken;
            self.pty.read(&mut bytes);
            if is_settled && bytes.len() as u64 >= sent * STATE_LENGTH as u64 {
                break;
            }
            assert!(begun.elapsed() < LIMIT, "{sent} packets, {bytes:?}");
            self.pty.wait(Duration::from_millis(1));
        }
        assert_eq!(bytes.len() % STATE_LENGTH, 0);
        self.taken += (bytes.len() / STATE_LENGTH) as u64;
        bytes
            .chunks(STATE_LENGTH)
            .map(|packet| f32::from_le_bytes([packet[2], packet[3], packet[4], packet[5]]))
            .collect()
    }

    /// Reads while the board answers every request.
    fn reads(&mut self, angles: [f32; 2]) -> Result<Pose, DeviceError> {
        self.device.patience = LIMIT;
        let reading = self.reads_with(angles, usize::MAX);
        self.device.patience = PATIENCE;
        reading
    }

    /// Reads while the board sends at most `most` answers.
    fn reads_with(&mut self, angles: [f32; 2], most: usize) -> Result<Pose, DeviceError> {
        let answer = self.answer(angles);
        let pty = &self.pty;
        let device = &mut self.device;
        let has_read = AtomicBool::new(false);
        let (reading, packets) = std::thread::scope(|scope| {
            let board = scope.spawn(|| {
                let mut asked = Vec::new();
                let mut answered = 0;
                loop {
                    let is_last = has_read.load(Ordering::Acquire);
                    pty.read(&mut asked);
                    while answered < (asked.len() / STATE_LENGTH).min(most) {
                        pty.write(&answer);
                        answered += 1;
                    }
                    // A packet that has not arrived yet is answered in the next read.
                    if is_last && asked.len() % STATE_LENGTH == 0 {
                        return asked.len() / STATE_LENGTH;
                    }
                    pty.wait(Duration::from_millis(1));
                }
            });
            let reading = device.read();
            has_read.store(true, Ordering::Release);
            (reading, board.join().unwrap())
        });
        self.taken += packets as u64;
        reading
    }

    /// Reads until there is a sample, and returns the number of failed reads.
    fn comes_back(&mut self) -> usize {
        let begun = Instant::now();
        let mut failures = 0;
        while self.reads_with(START, usize::MAX).is_err() {
            failures += 1;
            assert!(begun.elapsed() < LIMIT, "never: {:?}", self.device);
            std::thread::sleep(Duration::from_millis(1));
        }
        failures
    }
}

impl Drop for Played {
    fn drop(&mut self) {
        // No board answers when the device is closed.
        self.device.closed = true;
    }
}

#[test]
fn a_late_answer_is_not_that_of_a_later_question() {
    let mut played = Played::new();
    assert!(played.device.read().is_err());
    assert_eq!(played.received(), [0.0]);
    played.says([131.0, 49.0]);
    // That answer belongs to the first request; this one has none yet.
    let error = played.device.read().unwrap_err();
    assert_eq!(error.kind, DeviceErrorKind::NothingNew);
    assert_eq!(played.received(), [0.0]);
    // Both answers arrive in order; the last one is used.
    played.says([132.0, 48.0]);
    assert!(played.reads([133.0, 47.0]).is_ok());
    assert_eq!(played.device.angles(), [133.0, 47.0]);
    assert_eq!(played.device.counts().surplus, 0);
}

/// The late answer arrives while the driver waits for the answer to the later request.
#[test]
fn one_answer_to_two_questions_is_not_that_of_the_second() {
    let mut played = Played::new();
    assert!(played.device.read().is_err());
    assert!(played.reads_with([131.0, 49.0], 1).is_err());
    assert_eq!(played.device.angles(), START);
}

#[test]
fn an_answer_that_nobody_asked_for_is_noticed_and_not_believed() {
    let mut played = Played::new();
    assert!(played.reads(START).is_ok());
    played.says([131.0, 49.0]);
    for _ in 0..3 {
        assert!(played.device.read().is_err());
    }
    assert_eq!(played.device.counts().surplus, 1);
    assert_eq!(played.device.angles(), START);
    assert!(played.comes_back() > 0);
}

/// The answer is later than the longest wait: the driver sends a test request and finds the board one answer behind.
#[test]
fn an_answer_that_was_given_up_and_comes_after_all_is_not_believed() {
    let mut played = Played::new();
    assert!(played.reads(START).is_ok());
    let begun = Instant::now();
    while !matches!(played.device.trust, Trust::Tried(None)) {
        let _ = played.device.read();
        assert!(begun.elapsed() < LIMIT);
    }
    let questions = played.received().len();
    for answer in 0..questions {
        played.says([130.0 - answer as f32, 50.0]);
    }
    assert!(played.device.read().is_err());
    assert!(matches!(played.device.trust, Trust::Astray(_)));
    assert_eq!(played.device.angles(), START);
    played.comes_back();
}

#[test]
fn an_answer_that_is_lost_is_not_waited_for_for_ever() {
    let mut played = Played::new();
    let begun = Instant::now();
    while begun.elapsed() < LOST_AFTER + QUIET + Duration::from_millis(60) {
        let error = played.device.read().unwrap_err();
        assert_eq!(error.kind, DeviceErrorKind::NothingNew, "{error}");
    }
    // The driver did not send requests continuously: each attempt takes its time.
    let tries = begun.elapsed().as_millis() / (LOST_AFTER + QUIET).as_millis();
    let messages = played.received();
    assert!(messages.len() as u128 <= 4 + tries, "{tries} {messages:?}");
    played.comes_back();
}

#[test]
fn half_an_answer_and_garbage_are_waited_out() {
    let whole = Played::new().answer(START);
    for rubbish in [&whole[..4], &[0x77], &[0xff; 30], &whole[1..]] {
        let mut played = Played::new();
        assert!(played.reads(START).is_ok());
        played.sends(rubbish);
        assert!(played.device.read().is_err(), "{rubbish:?}");
        played.comes_back();
        assert_eq!(played.device.angles(), START);
    }
}

#[test]
fn a_board_that_is_behind_gets_no_force_and_no_flood() {
    let mut played = Played::new();
    assert!(played.reads(START).is_ok());
    let given = played.device.write([0.0, 1.0, 0.0].into()).unwrap().force;
    assert!((given[1] - 1.0).abs() < 0.01, "{given:?}");
    let begun = Instant::now();
    for _ in 0..20 {
        assert!(played.device.read().is_err());
        let given = played.device.write([0.0, 0.5, 0.0].into()).unwrap().force;
        assert_eq!(given, [0.0; 3]);
    }
    // Each attempt takes at least the wait for a missing answer and a quiet line.
    let tries = begun.elapsed().as_millis() / (LOST_AFTER + QUIET).as_millis();
    let messages = played.received();
    assert!(messages.len() as u128 <= 5 + tries, "{tries} {messages:?}");
    assert!(
        messages[0] != 0.0 && messages.last() == Some(&0.0),
        "{messages:?}"
    );
}

#[test]
fn what_is_repeated_after_a_cut_is_no_torque() {
    let mut played = Played::new();
    assert!(played.reads(START).is_ok());
    played.device.write([0.0, 1.0, 0.0].into()).unwrap();
    let mut zero = played.device.zero_writer().unwrap();
    zero.write_zero();
    let messages = played.received();
    assert!(messages[0] != 0.0 && messages[1..] == [0.0], "{messages:?}");
    let _ = played.device.read();
    assert!(played.received().iter().all(|torque| *torque == 0.0));
    // A force commanded afterwards is sent.
    played.comes_back();
    played.device.write([0.0, 1.0, 0.0].into()).unwrap();
    assert!(played.received().iter().any(|torque| *torque != 0.0));
}

/// The force's own packet sends the pending zero first, so the board holds the force.
#[test]
fn a_force_behind_a_cut_that_was_waiting_is_taken_off() {
    let mut played = Played::new();
    assert!(played.reads(START).is_ok());
    played.device.line.cutter().want();
    played.device.write([0.0, 1.0, 0.0].into()).unwrap();
    let messages = played.received();
    assert!(
        messages.last().is_some_and(|torque| *torque != 0.0),
        "{messages:?}"
    );
    played.device.go_astray();
    assert_eq!(played.device.write(Wrench::NONE).unwrap(), Wrench::NONE);
    assert_eq!(played.received(), [0.0]);
}

/// The thread that holds the line may already have found that nothing was pending.
#[test]
fn no_force_that_finds_the_line_busy_goes_out_after_all() {
    let mut played = Played::new();
    assert!(played.reads(START).is_ok());
    played.device.write([0.0, 1.0, 0.0].into()).unwrap();
    assert!(played.received()[0] != 0.0);
    let cutter = played.device.line.cutter();
    let busy = cutter.hold();
    assert_eq!(played.device.write(Wrench::NONE).unwrap(), Wrench::NONE);
    drop(busy);
    assert_eq!(played.received().last(), Some(&0.0));
}

#[test]
fn a_silent_board_is_gone_after_a_second_and_a_dead_port_at_once() {
    let begun = Instant::now();
    let mut played = Played::new();
    let error = loop {
        let error = played.device.read().unwrap_err();
        if error.kind != DeviceErrorKind::NothingNew {
            break error;
        }
        assert!(begun.elapsed() < LIMIT);
        std::thread::sleep(Duration::from_millis(5));
    };
    assert_eq!(error, SILENT);
    assert!(begun.elapsed() >= GONE_AFTER);

    let mut played = Played::new();
    let other = Pty::open(None).unwrap();
    drop(std::mem::replace(&mut played.pty, other));
    assert_eq!(played.device.read().unwrap_err(), GONE);
    assert_eq!(played.device.write([0.0; 3].into()).unwrap_err(), GONE);
}

/// Jump that is implausible after any time between two reads, which a busy machine makes long `[degrees]`.
const SLIP: f32 = 160.0;

/// Either the encoders keep slipping and no two samples agree, or they slipped once and answers are sometimes late.
#[test]
fn a_board_whose_encoders_slip_is_not_gone_and_says_so() {
    for slips_on in [true, false] {
        let mut played = Played::new();
        played.reads(START).unwrap();
        let begun = Instant::now();
        let mut slips = 0;
        let mut error = None;
        // Until well after a silent board would be reported as gone.
        while begun.elapsed() < 2 * GONE_AFTER || error.is_none_or(is_passing) {
            slips += 1;
            let by = if slips_on {
                40.0 * (slips % 6) as f32
            } else {
                0.0
            };
            error = played.reads([START[0] - SLIP - by, START[1]]).err();
            let kind = error.map(|error| error.kind);
            assert!(
                kind.is_some_and(|kind| kind != DeviceErrorKind::Disconnected),
                "{error:?}"
            );
            assert!(begun.elapsed() < LIMIT, "{error:?}");
        }
        let error = error.unwrap();
        assert_eq!(error.kind, DeviceErrorKind::Refused);
        assert!(error.what.contains("lost counts"), "{}", error.what);
        // Missing answers do not make the device gone before one second has passed.
        for _ in 0..GONE_AFTER_READS {
            played.reads([START[0] - SLIP, START[1]]).unwrap_err();
            let missing = played.device.read().unwrap_err();
            assert_ne!(missing.kind, DeviceErrorKind::Disconnected, "{missing:?}");
        }
    }
}

fn is_passing(error: DeviceError) -> bool {
    error.kind == DeviceErrorKind::NothingNew
}

/// The watchdog process's end of the socket, used by the test.
fn guarded(played: &Played) -> std::os::unix::net::UnixStream {
    use palpate_rt::watchdog::Watchdog;
    let (driver, socket) = std::os::unix::net::UnixStream::pair().unwrap();
    socket.set_nonblocking(true).unwrap();
    let watchdog = Watchdog::beside(driver, std::sync::Arc::default()).unwrap();
    played.device.line.guard(watchdog);
    socket
}

/// Returns the messages that the watchdog process received, one letter each.
fn heard(mut socket: &std::os::unix::net::UnixStream) -> String {
    use std::io::Read;
    let mut bytes = [0; 900];
    let read = socket.read(&mut bytes).unwrap_or(0);
    assert_eq!(read % 9, 0);
    bytes[..read]
        .chunks(9)
        .map(|word| char::from(word[0]))
        .collect()
}

#[test]
fn a_watchdog_hears_of_every_torque_and_once_of_none() {
    let mut played = Played::new();
    let socket = guarded(&played);
    assert!(played.reads(START).is_ok());
    assert_eq!(heard(&socket), "");
    played.device.write([0.0, 1.0, 0.0].into()).unwrap();
    assert_eq!(heard(&socket), "F");
    assert!(played.reads(START).is_ok());
    assert_eq!(heard(&socket), "F", "a torque is repeated");
    played.device.write([0.0; 3].into()).unwrap();
    assert!(played.reads(START).is_ok());
    assert_eq!(heard(&socket), "0");
}

/// The packet of the watchdog process may interrupt a packet of the driver, so the driver commands zero torque again
/// with a packet that the board accepts in any state. The device then recovers.
#[test]
fn a_loop_that_a_watchdog_has_cut_drops_what_it_had_begun_and_comes_back() {
    use std::io::Write;
    let mut played = Played::new();
    let mut socket = guarded(&played);
    assert!(played.reads(START).is_ok());
    played.device.write([0.0, 1.0, 0.0].into()).unwrap();
    socket.write_all(b"C").unwrap();
    let mut bytes = Vec::new();
    played.pty.wait(Duration::from_secs(5));
    played.pty.read(&mut bytes);
    bytes.clear();
    assert!(played.device.read().is_err());
    while bytes.len() < 19 {
        played.pty.wait(Duration::from_secs(5));
        played.pty.read(&mut bytes);
    }
    let release = super::super::packet::release(played.device.layout());
    assert_eq!(bytes[..19], release);
    assert_eq!(played.device.counts().watchdog_cuts, 1);
    assert_eq!(heard(&socket), "F");
    played.comes_back();
    played.device.write([0.0, 1.0, 0.0].into()).unwrap();
    assert!(heard(&socket).ends_with('F'));
}

#[test]
fn without_its_watchdog_a_device_gives_no_torque_and_says_so() {
    let mut played = Played::new();
    let socket = guarded(&played);
    assert!(played.reads(START).is_ok());
    played.device.write([0.0, 1.0, 0.0].into()).unwrap();
    drop(socket);
    let ended = unguarded(Unguarded::Ended);
    assert!(ended.what.contains("has ended"), "{ended}");
    assert_eq!(played.reads(START).unwrap_err(), ended);
    assert_eq!(
        played.device.write([0.0, 1.0, 0.0].into()).unwrap_err(),
        ended
    );
    assert!(played.device.write([0.0; 3].into()).is_ok());
    let mut bytes = Vec::new();
    played.pty.wait(Duration::from_secs(5));
    played.pty.read(&mut bytes);
    let last = &bytes[bytes.len() - STATE_LENGTH..];
    assert_eq!(last, state_of_none(&played));
}

/// A stopped watchdog process: its socket fills up.
#[test]
fn unresponsive_watchdog_is_distinguished_from_ended_watchdog() {
    let mut played = Played::new();
    let _socket = guarded(&played);
    assert!(played.reads(START).is_ok());
    let mut words = 0;
    let refused = loop {
        match played.device.write([0.0, 1.0, 0.0].into()) {
            Ok(_) => words += 1,
            Err(error) => break error,
        }
        assert!(words < 1_000_000, "somebody listens");
        // Either the board answers, or the command is refused for another reason.
        let _ = played.reads(START);
    };
    assert_eq!(refused, unguarded(Unguarded::NotListening));
    assert!(refused.what.contains("does not respond"), "{refused}");
}

fn state_of_none(played: &Played) -> [u8; STATE_LENGTH] {
    super::super::packet::state(played.device.layout(), [0.0; 2])
}
