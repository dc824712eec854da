//! Byte-by-byte emulation of the boards' firmware. It is written from published descriptions and independent of the
//! driver, which is tested against it.

use crate::two_diy::Board;

/// Serial line of the firmware.
pub trait Wire {
    /// Returns the next byte, if it is available.
    fn byte_now(&mut self) -> Option<u8>;
    /// Returns the next byte within a second, as the Arduino's `readBytes` waits.
    fn byte_soon(&mut self) -> Option<u8>;
    /// Sends bytes to the host.
    fn send(&mut self, bytes: &[u8]);
}

/// Motors and encoders at the ports.
pub trait Ports {
    /// Sets the pins of a motor driver: level of the direction, and duty from 0 to 1.
    fn drive(&mut self, port: u8, level: bool, duty: f64);
    /// Returns the revolutions of an encoder since power-up, positive for a direction byte of 1.
    fn revolutions(&mut self, port: u8) -> f64;
}

/// Action of the firmware, for observers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Did {
    /// Cleared its layout.
    Reset,
    /// Received a layout.
    SetUp,
    /// Commanded torques `[N m]` to this number of motors.
    Commanded(u8),
    /// Discarded a byte that is not a command.
    Discarded(u8),
}

#[derive(Clone, Copy, Debug, Default)]
struct Encoder {
    counts_per_rev: f64,
    first: f64,
    /// Revolutions at SETUP.
    zero: f64,
}

/// State of the firmware.
#[derive(Clone, Debug)]
pub struct Firmware {
    board: Board,
    /// Whether single late bytes read as 0xFF, as on the real boards.
    strict: bool,
    motors: u8,
    motor_directions: [u8; 4],
    encoders: u8,
    encoder_directions: [u8; 4],
    calibration: [Encoder; 4],
    sensors: usize,
    pwm_pins: usize,
}

const LARGEST_TORQUE: f32 = 0.123;

impl Firmware {
    pub fn new(board: Board, strict: bool) -> Self {
        Self {
            board,
            strict,
            motors: 0,
            motor_directions: [0; 4],
            encoders: 0,
            encoder_directions: [0; 4],
            calibration: [Encoder::default(); 4],
            sensors: 0,
            pwm_pins: 0,
        }
    }

    /// Runs the main loop once: executes a command, if there is a byte.
    pub fn turn(&mut self, wire: &mut impl Wire, ports: &mut impl Ports) -> Option<Did> {
        Some(match wire.byte_now()? {
            0 => {
                self.byte(wire);
                // Clears the tables, but does not change a motor.
                *self = Self::new(self.board, self.strict);
                Did::Reset
            }
            1 => self.set_up(wire, ports),
            2 => self.state(wire, ports),
            other => Did::Discarded(other),
        })
    }

    fn byte(&self, wire: &mut impl Wire) -> u8 {
        let byte = if self.strict {
            wire.byte_now()
        } else {
            wire.byte_soon()
        };
        byte.unwrap_or(0xFF)
    }

    fn float(wire: &mut impl Wire) -> f32 {
        let mut bytes = [0; 4];
        for byte in &mut bytes {
            match wire.byte_soon() {
                Some(read) => *byte = read,
                // The firmware gives up on the rest.
                None => break,
            }
        }
        f32::from_le_bytes(bytes)
    }

    fn set_up(&mut self, wire: &mut impl Wire, ports: &mut impl Ports) -> Did {
        self.byte(wire);
        self.motors = self.byte(wire);
        // By order and not by port: a quirk without effect for ports 1 and 2.
        for slot in 0..set_bits(self.motors) {
            self.motor_directions[slot] = self.byte(wire);
        }
        self.encoders = self.byte(wire);
        for slot in 0..set_bits(self.encoders) {
            self.encoder_directions[slot] = self.byte(wire);
        }
        self.sensors = self.byte(wire).into();
        for _ in 0..self.sensors {
            self.byte(wire);
        }
        self.pwm_pins = self.byte(wire).into();
        for _ in 0..self.pwm_pins {
            self.byte(wire);
        }
        for port in of_mask(self.encoders) {
            let offset = f64::from(Self::float(wire));
            let messages = f64::from(Self::float(wire));
            let counts_per_rev = if self.board == Board::M0 {
                messages / 2.0
            } else {
                messages
            };
            self.calibration[usize::from(port) - 1] = Encoder {
                counts_per_rev,
                first: (offset * counts_per_rev / 360.0).trunc(),
                zero: self.turned(port, ports),
            };
        }
        Did::SetUp
    }

    fn state(&mut self, wire: &mut impl Wire, ports: &mut impl Ports) -> Did {
        let id = self.byte(wire);
        for _ in 0..self.pwm_pins {
            self.byte(wire);
        }
        let mut messages = 0;
        for port in of_mask(self.motors) {
            let torque = Self::float(wire);
            if port <= self.board.ports() {
                let direction = self.motor_directions[usize::from(port) - 1];
                let (level, duty) = pins(self.board, port, direction, torque);
                ports.drive(port, level, duty);
            }
            messages += 1;
        }
        let mut reply = vec![id];
        for _ in 0..self.sensors {
            reply.extend(0.0_f32.to_le_bytes());
        }
        for port in of_mask(self.encoders) {
            let Encoder {
                counts_per_rev,
                first,
                zero,
            } = self.calibration[usize::from(port) - 1];
            let counts = first + ((self.turned(port, ports) - zero) * counts_per_rev).floor();
            #[expect(clippy::cast_possible_truncation, reason = "the wire has f32")]
            let degrees = (360.0 * counts / counts_per_rev) as f32;
            reply.extend(degrees.to_le_bytes());
        }
        wire.send(&reply);
        Did::Commanded(messages)
    }

    /// Returns the revolutions in the positive direction set by SETUP.
    fn turned(&self, port: u8, ports: &mut impl Ports) -> f64 {
        let turned = ports.revolutions(port);
        if self.encoder_directions[usize::from(port) - 1] == 0 {
            -turned
        } else {
            turned
        }
    }
}

/// Returns the level of the direction pin and the duty for a torque `[N m]`.
pub fn pins(board: Board, port: u8, direction: u8, torque: f32) -> (bool, f64) {
    let steps: f32 = if board == Board::M0 { 1023.0 } else { 4095.0 };
    let clamped = torque.abs().min(LARGEST_TORQUE);
    // NaN gives zero duty.
    let duty = (steps * clamped / LARGEST_TORQUE).floor().max(0.0);
    let mut level = (torque > 0.0) ^ (direction != 0);
    if board == Board::DevKit {
        // The default level differs, and the even ports are wired in the opposite direction.
        level ^= true ^ port.is_multiple_of(2);
    }
    (level, f64::from(duty / steps))
}

fn set_bits(mask: u8) -> usize {
    of_mask(mask).count()
}

/// Returns the ports of a mask in ascending order; no board has more than four.
fn of_mask(mask: u8) -> impl Iterator<Item = u8> {
    (1..=4).filter(move |port| mask & (1 << (port - 1)) != 0)
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;

    use super::*;

    #[derive(Default)]
    struct Memory {
        incoming: VecDeque<u8>,
        /// Bytes that arrive only after the firmware has waited for them.
        late: VecDeque<u8>,
        sent: Vec<u8>,
    }

    impl Wire for Memory {
        fn byte_now(&mut self) -> Option<u8> {
            self.incoming.pop_front()
        }
        fn byte_soon(&mut self) -> Option<u8> {
            if self.incoming.is_empty() {
                self.incoming = std::mem::take(&mut self.late);
            }
            self.incoming.pop_front()
        }
        fn send(&mut self, bytes: &[u8]) {
            self.sent.extend(bytes);
        }
    }

    #[derive(Default)]
    struct Bench {
        driven: [(bool, f64); 2],
        turned: [f64; 2],
    }

    impl Ports for Bench {
        fn drive(&mut self, port: u8, level: bool, duty: f64) {
            self.driven[usize::from(port) - 1] = (level, duty);
        }
        fn revolutions(&mut self, port: u8) -> f64 {
            self.turned[usize::from(port) - 1]
        }
    }

    fn bytes(hex: &str) -> VecDeque<u8> {
        let byte = |pair| u8::from_str_radix(pair, 16).unwrap();
        hex.split_whitespace().map(byte).collect()
    }

    const SETUP: &str =
        "01 05 03 01 01 03 01 01 00 00 00 00 40 41 00 80 98 45 00 00 28 43 00 80 98 45";

    #[test]
    fn the_golden_setup_and_state_are_answered_by_the_golden_reply() {
        let mut wire = Memory {
            incoming: bytes(&format!("00 00 {SETUP} 02 05 0a d7 23 3c 0a d7 a3 bc")),
            ..Memory::default()
        };
        let mut bench = Bench::default();
        let mut firmware = Firmware::new(Board::M0, true);
        let did: Vec<_> = std::iter::from_fn(|| firmware.turn(&mut wire, &mut bench)).collect();
        assert_eq!(did, [Did::Reset, Did::SetUp, Did::Commanded(2)]);
        assert_eq!(wire.sent, Vec::from(bytes("05 8f 36 3f 41 d2 e6 27 43")));
        // 0.01 and -0.02 N m of 0.123, in steps of 1/1023.
        assert_eq!(bench.driven[0], (false, f64::from(83.0_f32 / 1023.0)));
        assert_eq!(bench.driven[1], (true, f64::from(166.0_f32 / 1023.0)));
    }

    #[test]
    fn a_reset_leaves_the_motors_as_they_are_and_the_layout_forgotten() {
        let mut wire = Memory {
            incoming: bytes(&format!(
                "{SETUP} 02 05 0a d7 23 3c 0a d7 23 3c 00 00 02 05"
            )),
            ..Memory::default()
        };
        let mut bench = Bench::default();
        let mut firmware = Firmware::new(Board::M3, true);
        while firmware.turn(&mut wire, &mut bench).is_some() {}
        assert!(bench.driven[0].1 > 0.08 && bench.driven[1].1 > 0.08);
        // An id, two angles; then an id alone.
        assert_eq!(wire.sent.len(), 9 + 1);
    }

    #[test]
    fn a_late_byte_spoils_a_setup_on_a_strict_board_only() {
        for strict in [true, false] {
            let mut whole = bytes(SETUP);
            let late = whole.split_off(6);
            let mut wire = Memory {
                incoming: whole,
                late,
                ..Memory::default()
            };
            let mut bench = Bench::default();
            let mut firmware = Firmware::new(Board::M0, strict);
            firmware.turn(&mut wire, &mut bench);
            let is_spoilt = firmware.sensors == 0xFF;
            assert_eq!(is_spoilt, strict);
        }
    }

    /// For any part of a STATE that the loop had sent when it was killed.
    #[test]
    fn a_release_takes_the_torque_off_from_anywhere_and_leaves_the_layout() {
        use crate::two_diy::packet::{release, state};
        let layout = crate::two_diy::Generation::Three.layout();
        for (strict, late) in [(true, true), (true, false), (false, true), (false, false)] {
            for sent in 0..=10 {
                let mut incoming = bytes(&format!("{SETUP} 02 05 0a d7 23 3d 0a d7 a3 bd"));
                // Bytes that are commands at the start of a packet.
                incoming.extend(&state(&layout, [-0.123, 0.02])[..sent]);
                let mut rest = VecDeque::from(release(&layout).to_vec());
                if !late {
                    incoming.append(&mut rest);
                }
                let mut wire = Memory {
                    incoming,
                    late: rest,
                    ..Memory::default()
                };
                let mut bench = Bench::default();
                let mut firmware = Firmware::new(Board::M3, strict);
                while firmware.turn(&mut wire, &mut bench).is_some() {}
                wire.incoming.append(&mut wire.late);
                while firmware.turn(&mut wire, &mut bench).is_some() {}
                let duties = bench.driven.map(|(_, duty)| duty);
                assert_eq!(duties, [0.0; 2], "{sent} bytes, strict: {strict}");
                wire.incoming.extend(state(&layout, [0.1, 0.1]));
                while firmware.turn(&mut wire, &mut bench).is_some() {}
                assert!(bench.driven.iter().all(|(_, duty)| *duty > 0.5), "{sent}");
            }
        }
    }

    #[test]
    fn what_is_no_command_goes_a_byte_at_a_time() {
        let mut wire = Memory {
            incoming: bytes("77 fe"),
            ..Memory::default()
        };
        let mut firmware = Firmware::new(Board::M0, true);
        let mut turn = || firmware.turn(&mut wire, &mut Bench::default());
        assert_eq!(turn(), Some(Did::Discarded(0x77)));
        assert_eq!(turn(), Some(Did::Discarded(0xfe)));
        assert_eq!(turn(), None);
    }
}
