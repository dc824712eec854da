//! moteus behind a CAN-FD adapter that takes lines of text (fdcanusb, mjcanfd-usb-1x).
//!
//! A line `can send ID HEX` carries a frame, and `rcv ID HEX` an answer. A frame has subframes that write and read
//! registers. Torque is position mode with the scales of stiffness and damping at 0 and a feed-forward torque.
//! Source: the manual of mjbots/moteus.

use std::fmt;
use std::time::Duration;

use super::axis::{Axis, AxisState, Condition, Heard};
use super::open::OpenError;
use super::text::Text;
use super::wire::Wire;

/// Sources of requests, which number them: an answer goes to the source of its request. No drive has such a number.
const FIRST_SOURCE: u8 = 0x70;
const SOURCES: u8 = 15;
/// Source of the lines for the setup.
const SETUP_SOURCE: u8 = FIRST_SOURCE + SOURCES;
/// The drive shall answer.
const ANSWER: u8 = 0x80;
/// Largest number of a drive.
pub const LARGEST_ID: u8 = FIRST_SOURCE - 1;

/// Kinds of subframes.
const WRITE_I8: u8 = 0x01;
const WRITE_F32: u8 = 0x0c;
const READ_ONE_I8: u8 = 0x11;
const READ_THREE_F32: u8 = 0x1f;
const REPLY_ONE_I8: u8 = 0x21;
const REPLY_THREE_F32: u8 = 0x2f;
const TO_CONSOLE: u8 = 0x40;
const FROM_CONSOLE: u8 = 0x41;
const POLL_CONSOLE: u8 = 0x42;
const NOTHING: u8 = 0x50;

/// Registers.
const MODE: u8 = 0x00;
const POSITION: u8 = 0x01;
const FAULT: u8 = 0x0f;
const COMMAND: u8 = 0x20;

/// Modes.
const STOPPED: u8 = 0;
const POSITION_MODE: u8 = 10;

/// Lengths that a CAN-FD frame may have.
const LENGTHS: [usize; 7] = [12, 16, 20, 24, 32, 48, 64];

/// Setting of the drive: 0 switches the motor off when the watchdog expires; its default damps the motor.
const TIMEOUT_MODE: &str = "servo.timeout_mode";
/// Longest answer of its console `[bytes]`.
const CONSOLE: u8 = 48;
const CONSOLE_WITHIN: Duration = Duration::from_millis(500);

/// A CAN-FD frame.
struct Frame {
    bytes: [u8; 64],
    length: usize,
}

impl Frame {
    fn new() -> Self {
        Self {
            bytes: [NOTHING; 64],
            length: 0,
        }
    }

    fn put(&mut self, bytes: &[u8]) {
        if let Some(place) = self.bytes.get_mut(self.length..self.length + bytes.len()) {
            place.copy_from_slice(bytes);
            self.length += bytes.len();
        }
    }
}

/// In hexadecimal, filled up to a length that a frame may have.
impl fmt::Display for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut allowed = (0..=8).chain(LENGTHS);
        let length = allowed.find(|length| *length >= self.length).unwrap_or(64);
        let mut bytes = self.bytes.iter().take(length);
        bytes.try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// A moteus.
#[derive(Debug)]
pub struct Moteus {
    id: u8,
    largest: f32,
    watchdog: Duration,
    /// Number of the last request.
    request: u8,
}

impl Moteus {
    /// Creates the protocol of the drive with the number `id`; `None` if it is not 1 to 111.
    #[must_use]
    pub fn new(id: u8) -> Option<Self> {
        (1..=LARGEST_ID).contains(&id).then_some(Self {
            id,
            largest: 0.0,
            watchdog: Duration::ZERO,
            request: 0,
        })
    }

    fn line(&self, source: u8, frame: &Frame, text: &mut Text) {
        text.put(format_args!(
            "can send {source:02x}{:02x} {frame}\n",
            self.id
        ));
    }

    /// Returns a frame that commands `torque` `[N m]` and feeds the watchdog.
    fn torque(&self, torque: f32) -> Frame {
        let mut frame = Frame::new();
        frame.put(&[WRITE_I8, MODE, POSITION_MODE, WRITE_F32, 8, COMMAND]);
        // Position (present), velocity, torque, scales of stiffness and damping, largest torque, stop position (none),
        // watchdog.
        let values = [
            f32::NAN,
            0.0,
            torque,
            0.0,
            0.0,
            self.largest,
            f32::NAN,
            self.watchdog.as_secs_f32(),
        ];
        for value in values {
            frame.put(&value.to_le_bytes());
        }
        frame
    }

    fn stopped() -> Frame {
        let mut frame = Frame::new();
        frame.put(&[WRITE_I8, MODE, STOPPED]);
        frame
    }

    /// Sends a line to the drive's console, and returns its answer.
    fn console(&self, wire: &mut Wire, words: &str) -> Result<String, OpenError> {
        let mut frame = Frame::new();
        // The lines of this module are shorter than a frame.
        let length = u8::try_from(words.len() + 1).unwrap_or(u8::MAX);
        frame.put(&[TO_CONSOLE, 1, length]);
        frame.put(words.as_bytes());
        frame.put(b"\n");
        let mut poll = Frame::new();
        poll.put(&[POLL_CONSOLE, 1, CONSOLE]);
        let source = ANSWER | SETUP_SOURCE;
        let mut said = String::new();
        let mut is_first = true;
        let begun = std::time::Instant::now();
        while begun.elapsed() < CONSOLE_WITHIN && !said.contains('\n') {
            let write = |text: &mut Text| {
                if is_first {
                    self.line(SETUP_SOURCE, &frame, text);
                }
                self.line(source, &poll, text);
            };
            let answer = wire.exchange(write, CONSOLE_WITHIN, |line| {
                let (to, bytes) = received(line, self.id)?;
                let [FROM_CONSOLE, 1, length, rest @ ..] = bytes.bytes() else {
                    return None;
                };
                let words = rest.get(..usize::from(*length))?;
                (to == SETUP_SOURCE).then(|| String::from_utf8_lossy(words).into_owned())
            })?;
            is_first = false;
            match answer {
                Some(words) => said.push_str(&words),
                None => break,
            }
        }
        if said.is_empty() {
            return Err(OpenError::Silent(self.name()));
        }
        Ok(said.trim().to_owned())
    }
}

/// Bytes of a received frame.
struct Received {
    bytes: [u8; 64],
    length: usize,
}

impl Received {
    fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }
}

/// Returns the destination and the bytes of a line `rcv ID HEX` from the drive `id`.
fn received(line: &[u8], id: u8) -> Option<(u8, Received)> {
    let mut words = std::str::from_utf8(line).ok()?.split_ascii_whitespace();
    if words.next() != Some("rcv") {
        return None;
    }
    let [from, to] = u16::from_str_radix(words.next()?, 16).ok()?.to_be_bytes();
    let hex = words.next()?.as_bytes();
    let mut bytes = [0; 64];
    let (pairs, odd) = hex.as_chunks::<2>();
    if from != id || !odd.is_empty() || pairs.len() > bytes.len() {
        return None;
    }
    for (byte, pair) in bytes.iter_mut().zip(pairs) {
        *byte = u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok()?;
    }
    Some((
        to,
        Received {
            bytes,
            length: pairs.len(),
        },
    ))
}

/// Returns the reason of a fault.
fn reason(fault: u8) -> &'static str {
    match fault {
        32 => "the drive has fault 32: its encoder sensed no magnet when it was calibrated",
        33 => "the drive has fault 33 of its motor driver: check its supply",
        34 => "the drive has fault 34: its supply has too much voltage",
        35 => "the drive has fault 35: its encoder senses no magnet",
        36 => "the drive has fault 36: its motor is not calibrated (moteus_tool --calibrate)",
        38 => "the drive has fault 38: it is too hot",
        39 => {
            "the drive has fault 39: its position is outside servopos.position_min and position_max"
        }
        40 => "the drive has fault 40: its supply has too little voltage",
        41 => "the drive has fault 41: another program has changed its configuration",
        42 => "the drive has fault 42: it has no encoder for commutation",
        43 => "the drive has fault 43: it has no encoder for the position",
        44 => "the drive has fault 44: its gate driver does not start",
        _ => "the drive has a fault: its manual names the code that moteus_tool shows",
    }
}

impl Axis for Moteus {
    const MOST_UNANSWERED: u32 = 3;

    fn name(&self) -> String {
        format!("moteus {}", self.id)
    }

    fn prepare(
        &mut self,
        wire: &mut Wire,
        largest: f32,
        watchdog: Duration,
    ) -> Result<(), OpenError> {
        (self.largest, self.watchdog) = (largest, watchdog);
        // The configuration changes only while the drive is stopped.
        let mut stopped = None;
        for _ in 0..5 {
            let mut frame = Self::stopped();
            frame.put(&[READ_ONE_I8, MODE]);
            stopped = wire.exchange(
                |text| self.line(ANSWER | SETUP_SOURCE, &frame, text),
                Duration::from_millis(100),
                |line| {
                    let (to, frame) = received(line, self.id)?;
                    let is_stopped = frame.bytes().starts_with(&[REPLY_ONE_I8, MODE, STOPPED]);
                    (to == SETUP_SOURCE && is_stopped).then_some(())
                },
            )?;
            if stopped.is_some() {
                break;
            }
        }
        if stopped.is_none() {
            return Err(OpenError::Silent(self.name()));
        }
        self.console(wire, &format!("conf set {TIMEOUT_MODE} 0"))?;
        let found = self.console(wire, &format!("conf get {TIMEOUT_MODE}"))?;
        if found != "0" {
            return Err(OpenError::NotReady {
                name: self.name(),
                why: format!(
                    "does not take {TIMEOUT_MODE} = 0, by which its watchdog switches the motor off: it answers {found:?}"
                ),
            });
        }
        Ok(())
    }

    fn watchdog(&self) -> Duration {
        self.watchdog
    }

    fn ask(&mut self, torque: f32, text: &mut Text) {
        self.request = (self.request + 1) % SOURCES;
        let mut frame = self.torque(torque);
        frame.put(&[
            READ_ONE_I8,
            MODE,
            READ_THREE_F32,
            POSITION,
            READ_ONE_I8,
            FAULT,
        ]);
        self.line(ANSWER | (FIRST_SOURCE + self.request), &frame, text);
    }

    fn command(&mut self, torque: f32, text: &mut Text) {
        self.line(SETUP_SOURCE, &self.torque(torque), text);
    }

    fn resume(&mut self, text: &mut Text) {
        self.line(SETUP_SOURCE, &Self::stopped(), text);
    }

    fn stop(&mut self, text: &mut Text) {
        self.line(SETUP_SOURCE, &Self::stopped(), text);
    }

    fn hear(&mut self, line: &[u8]) -> Heard {
        if line.starts_with(b"OK") {
            return Heard::Part;
        }
        let Some((to, frame)) = received(line, self.id) else {
            return Heard::Unreadable;
        };
        if to == SETUP_SOURCE {
            return Heard::Part;
        }
        let [
            REPLY_ONE_I8,
            MODE,
            mode,
            REPLY_THREE_F32,
            POSITION,
            a,
            b,
            c,
            d,
            _,
            _,
            _,
            _,
            _,
            _,
            _,
            _,
            REPLY_ONE_I8,
            FAULT,
            fault,
            ..,
        ] = *frame.bytes()
        else {
            return Heard::Unreadable;
        };
        if to != FIRST_SOURCE + self.request {
            return Heard::Late;
        }
        let condition = match mode {
            POSITION_MODE => Condition::Ready,
            0 | 2..=4 => Condition::Starting,
            11 => Condition::TimedOut,
            1 => Condition::Failed(reason(fault)),
            _ => Condition::Failed(
                "the drive is in another mode: end the other program that commands it",
            ),
        };
        Heard::State(AxisState {
            position: f64::from(f32::from_le_bytes([a, b, c, d])),
            condition,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(write: impl FnOnce(&mut Text)) -> String {
        let mut text = Text::default();
        write(&mut text);
        String::from_utf8(text.bytes().to_vec()).unwrap()
    }

    /// Values by the manual's register table: NaN, 0, 0.25 N m, 0, 0, 1 N m, NaN, 0.03125 s.
    #[test]
    fn frames_are_those_of_the_manual() {
        let mut axis = Moteus::new(1).unwrap();
        (axis.largest, axis.watchdog) = (1.0, Duration::from_micros(31_250));
        let values = "0000c07f000000000000803e00000000000000000000803f0000c07f0000003d";
        assert_eq!(
            written(|text| axis.ask(0.25, text)),
            format!("can send f101 01000a0c0820{values}11001f01110f50505050\n")
        );
        assert_eq!(
            written(|text| axis.command(0.25, text)),
            format!("can send 7f01 01000a0c0820{values}50505050505050505050\n")
        );
        assert_eq!(written(|text| axis.stop(text)), "can send 7f01 010000\n");
        assert!(Moteus::new(0).is_none() && Moteus::new(112).is_none());
    }

    #[test]
    fn an_answer_is_that_of_the_last_request_or_late_or_unreadable() {
        let mut axis = Moteus::new(1).unwrap();
        written(|text| axis.ask(0.0, text));
        // Mode, then -0.5 turns.
        let answer = |mode: &str, fault: &str| {
            format!("2100{mode}2f01000000bf000000000000000021 0f{fault}").replace(' ', "")
        };
        let mut heard = |line: &str| axis.hear(line.as_bytes());
        let state = |condition| {
            Heard::State(AxisState {
                position: -0.5,
                condition,
            })
        };
        for (mode, fault, condition) in [
            ("0a", "00", Condition::Ready),
            ("0a", "63", Condition::Ready),
            ("02", "00", Condition::Starting),
            ("0b", "00", Condition::TimedOut),
            ("01", "23", Condition::Failed(reason(35))),
        ] {
            let line = format!("rcv 171 {} E B F", answer(mode, fault));
            assert_eq!(heard(&line), state(condition), "{line}");
        }
        assert!(matches!(
            heard(&format!("rcv 0171 {}", answer("09", "00"))),
            Heard::State(AxisState {
                condition: Condition::Failed(_),
                ..
            })
        ));
        assert_eq!(
            heard(&format!("rcv 172 {}", answer("0a", "00"))),
            Heard::Late
        );
        assert_eq!(heard("OK"), Heard::Part);
        for line in [
            "",
            "rcv",
            "rcv 171",
            "rcv 171 2",
            "rcv 171 21000a",
            "rcv x 00",
            "rcv 171 zz",
            "ERR",
            "\u{e9}",
        ] {
            assert_eq!(heard(line), Heard::Unreadable, "{line}");
        }
        // Another drive.
        let other = format!("rcv 271 {}", answer("0a", "00"));
        assert_eq!(heard(&other), Heard::Unreadable);
    }
}
