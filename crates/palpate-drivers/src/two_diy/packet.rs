//! Bytes on the wire: little-endian, without frame, checksum or sequence number.
//!
//! Packets to the board: RESET clears the layout (and does **not** remove the torques), SETUP sets the layout, STATE
//! commands torques and requests the angles. The board answers only STATE.

use super::layout::Layout;

/// Length of a SETUP for two motors and two encoders.
pub const SETUP_LENGTH: usize = 26;
/// Length of a STATE with two torques.
pub const STATE_LENGTH: usize = 10;
/// Length of a reply with two angles.
pub const REPLY_LENGTH: usize = 9;

/// Clears the layout of the board. Torques stay on: command zero first.
pub const RESET: [u8; 2] = [0, 0];
/// Enough zeros to complete any packet that the board may be in the middle of; the rest are RESETs.
pub const RECOVERY: [u8; 40] = [0; 40];

/// Length of the packet of [`release`].
pub const RELEASE_LENGTH: usize = 2 * STATE_LENGTH - 1;
/// A byte that is not a command; a board discards any number of them. As the last byte of a torque it makes a number
/// below 1e-37, which is zero torque.
const FILLER: u8 = 0x80;

const SETUP_COMMAND: u8 = 1;
const STATE_COMMAND: u8 = 2;

/// Returns the packet that sets motors and encoders of the board. The arm must be in the start pose.
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

/// Returns the packet that commands the torques of joints 1 and 2 `[N m]` and requests the angles.
#[must_use]
pub fn state(layout: &Layout, torques: [f32; 2]) -> [u8; STATE_LENGTH] {
    let [low, high] = layout.by_motor_port(torques).map(f32::to_le_bytes);
    let mut packet = [STATE_COMMAND, layout.device_id, 0, 0, 0, 0, 0, 0, 0, 0];
    packet[2..6].copy_from_slice(&low);
    packet[6..10].copy_from_slice(&high);
    packet
}

/// Returns the packet that removes the torques of a board that may be in the middle of a STATE. Its first bytes
/// complete that STATE with torques that were already sent or are zero; a STATE without torque follows. A board between
/// packets ignores the first bytes. The board keeps its layout in any case, and answers one or two STATEs.
#[must_use]
pub fn release(layout: &Layout) -> [u8; RELEASE_LENGTH] {
    let mut packet = [FILLER; RELEASE_LENGTH];
    packet[STATE_LENGTH - 1..].copy_from_slice(&state(layout, [0.0; 2]));
    packet
}

/// Result of a received byte.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Heard {
    /// A reply is still incomplete.
    Part,
    /// A reply: angles of joints 1 and 2 `[degrees]`, unchecked.
    Angles([f32; 2]),
    /// An unexpected byte at the start of a reply.
    Stray,
}

/// Parser of replies; accepts any input.
#[derive(Clone, Copy, Debug)]
pub struct Replies {
    layout: Layout,
    bytes: [u8; REPLY_LENGTH],
    filled: usize,
}

impl Replies {
    /// Creates a parser for a device with this layout.
    #[must_use]
    pub fn new(layout: Layout) -> Self {
        Self {
            layout,
            bytes: [0; REPLY_LENGTH],
            filled: 0,
        }
    }

    /// Parses a byte.
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

    /// Returns whether a reply is incomplete.
    #[must_use]
    pub fn is_partial(&self) -> bool {
        self.filled > 0
    }

    /// Discards an incomplete reply.
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

    /// Computed by hand from the published host and firmware sources.
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
