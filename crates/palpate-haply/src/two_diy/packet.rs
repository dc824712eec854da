//! Bytes on the wire: little-endian, without frame, checksum or number.
//!
//! What a board is told: RESET forgets the layout (and does **not** take the torques away), SETUP
//! gives one, STATE commands torques and asks for the angles. Only STATE is answered.

use super::layout::Layout;

/// Length of a SETUP for two motors and two encoders.
pub const SETUP_LENGTH: usize = 26;
/// Length of a STATE with two torques.
pub const STATE_LENGTH: usize = 10;
/// Length of a reply with two angles.
pub const REPLY_LENGTH: usize = 9;

/// Makes the board forget its layout. Torques stay: command none first.
pub const RESET: [u8; 2] = [0, 0];
/// Enough zeros to complete any packet that the board may be in the middle of; the rest are RESETs.
pub const RECOVERY: [u8; 40] = [0; 40];

/// Length of [`release`].
pub const RELEASE_LENGTH: usize = 2 * STATE_LENGTH - 1;
/// A byte that is no command, of which a board throws away any number. As the last byte of a torque it
/// makes a number below 1e-37, which is no torque.
const FILLER: u8 = 0x80;

const SETUP_COMMAND: u8 = 1;
const STATE_COMMAND: u8 = 2;

/// Tells the board which motors and encoders the device has. The arm has to be in the start pose.
#[must_use]
pub fn setup(layout: &Layout) -> [u8; SETUP_LENGTH] {
    let mut packet = [0; SETUP_LENGTH];
    let mut at = 0;
    let mut put = |bytes: &[u8]| {
        packet[at..at + bytes.len()].copy_from_slice(bytes);
        at += bytes.len();
    };
    put(&[SETUP_COMMAND, layout.device_id]);
    let mask = |ports: [u8; 2]| ports.iter().fold(0, |mask, port| mask | 1 << (port - 1));
    let joints = layout.by_motor_port(layout.joints);
    put(&[mask(joints.map(|joint| joint.motor_port))]);
    put(&joints.map(|joint| joint.motor_direction.byte()));
    let joints = layout.by_encoder_port(layout.joints);
    put(&[mask(joints.map(|joint| joint.encoder_port))]);
    put(&joints.map(|joint| joint.encoder_direction.byte()));
    let (sensors, pwm_pins) = (0, 0);
    put(&[sensors, pwm_pins]);
    for joint in joints {
        put(&joint.start.to_le_bytes());
        put(&joint.counts_per_rev.to_le_bytes());
    }
    packet
}

/// Commands the torques of joints 1 and 2 `[N m]`, and asks for the angles.
#[must_use]
pub fn state(layout: &Layout, torques: [f32; 2]) -> [u8; STATE_LENGTH] {
    let [low, high] = layout.by_motor_port(torques).map(f32::to_le_bytes);
    let mut packet = [STATE_COMMAND, layout.device_id, 0, 0, 0, 0, 0, 0, 0, 0];
    packet[2..6].copy_from_slice(&low);
    packet[6..10].copy_from_slice(&high);
    packet
}

/// Takes off the torques of a board that may be in the middle of a STATE: enough bytes to complete that
/// one with torques that it was told already or that are none, then a STATE without a torque. To a
/// board between packets the first bytes are nothing. It does not forget its layout, whatever it was
/// in the middle of. The answers are to one STATE or two.
#[must_use]
pub fn release(layout: &Layout) -> [u8; RELEASE_LENGTH] {
    let mut packet = [FILLER; RELEASE_LENGTH];
    packet[STATE_LENGTH - 1..].copy_from_slice(&state(layout, [0.0; 2]));
    packet
}

/// What came of a byte.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Heard {
    /// A reply is not complete yet.
    Part,
    /// A reply: angles of joints 1 and 2 `[degrees]`, whatever their bits say.
    Angles([f32; 2]),
    /// A byte where a reply should begin, and none of this device's does.
    Stray,
}

/// Takes replies apart, whatever comes.
#[derive(Clone, Copy, Debug)]
pub struct Replies {
    layout: Layout,
    bytes: [u8; REPLY_LENGTH],
    filled: usize,
}

impl Replies {
    /// Of a device with this layout.
    #[must_use]
    pub fn new(layout: Layout) -> Self {
        Self {
            layout,
            bytes: [0; REPLY_LENGTH],
            filled: 0,
        }
    }

    /// Takes a byte.
    pub fn hear(&mut self, byte: u8) -> Heard {
        if self.filled == 0 && byte != self.layout.device_id {
            return Heard::Stray;
        }
        if let Some(place) = self.bytes.get_mut(self.filled) {
            *place = byte;
        }
        self.filled += 1;
        if self.filled < REPLY_LENGTH {
            return Heard::Part;
        }
        self.filled = 0;
        let [_, a, b, c, d, e, f, g, h] = self.bytes;
        let angles = [[a, b, c, d], [e, f, g, h]].map(f32::from_le_bytes);
        Heard::Angles(self.layout.by_encoder_port(angles))
    }

    /// Whether it is in the middle of a reply.
    #[must_use]
    pub fn is_partial(&self) -> bool {
        self.filled > 0
    }

    /// Forgets the beginning of a reply.
    pub fn forget(&mut self) {
        self.filled = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::two_diy::Generation;

    fn bytes(hex: &str) -> Vec<u8> {
        let byte = |pair| u8::from_str_radix(pair, 16).unwrap();
        hex.split_whitespace().map(byte).collect()
    }

    /// Worked out by hand from the published host and firmware sources.
    #[test]
    fn packets_are_the_golden_ones() {
        for (generation, hex) in [
            (
                Generation::Three,
                "01 05 03 01 01 03 01 01 00 00 00 00 40 41 00 80 98 45 00 00 28 43 00 80 98 45",
            ),
            (
                Generation::Two,
                "01 05 03 00 01 03 00 01 00 00 00 00 74 c2 00 00 28 46 00 00 71 43 00 00 28 46",
            ),
            (
                Generation::One,
                "01 03 03 00 00 03 00 00 00 00 00 00 34 43 00 00 58 46 00 00 00 00 00 00 58 46",
            ),
        ] {
            assert_eq!(
                setup(&generation.layout())[..],
                bytes(hex),
                "{generation:?}"
            );
        }
        let third = Generation::Three.layout();
        assert_eq!(RESET[..], bytes("00 00"));
        assert_eq!(
            state(&third, [0.0, 0.0])[..],
            bytes("02 05 00 00 00 00 00 00 00 00")
        );
        // Joint 1 is on port 2.
        assert_eq!(
            state(&third, [-0.02, 0.01])[..],
            bytes("02 05 0a d7 23 3c 0a d7 a3 bc")
        );
    }

    #[test]
    fn the_golden_reply_is_understood_after_strays_and_in_pieces() {
        let mut replies = Replies::new(Generation::Three.layout());
        assert_eq!(replies.hear(0x04), Heard::Stray);
        let golden = bytes("05 8f 36 3f 41 d2 e6 27 43");
        for round in 0..2 {
            for byte in &golden[..8] {
                assert_eq!(replies.hear(*byte), Heard::Part, "{round}");
            }
            assert!(replies.is_partial());
            let Heard::Angles([first, second]) = replies.hear(golden[8]) else {
                panic!("no reply");
            };
            assert!((first - 167.9016).abs() < 5e-5, "{first}");
            assert!((second - 11.9508).abs() < 5e-5, "{second}");
        }
        replies.hear(golden[0]);
        replies.forget();
        assert_eq!(replies.hear(0x8f), Heard::Stray);
    }
}
