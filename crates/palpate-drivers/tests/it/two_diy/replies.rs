use palpate_drivers::two_diy::packet::{Heard, REPLY_LENGTH, Replies};
use palpate_drivers::two_diy::{Generation, torques};
use proptest::prelude::*;

use super::Board;

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::with_cases(2000)
    })]

    /// For any input, each byte is counted once, and parsing resumes after a quiet line.
    #[test]
    fn any_bytes_are_taken_apart(
        bytes in prop::collection::vec(any::<u8>(), 0..200),
        generation in prop::sample::select(Generation::ALL.to_vec()),
    ) {
        let layout = generation.layout();
        let mut replies = Replies::new(layout);
        let mut counted = 0;
        let mut parts = 0;
        for byte in &bytes {
            match replies.hear(*byte) {
                Heard::Part => parts += 1,
                Heard::Stray => {
                    prop_assert_eq!(parts, 0);
                    counted += 1;
                }
                Heard::Angles(_) => {
                    prop_assert_eq!(parts, REPLY_LENGTH - 1);
                    counted += REPLY_LENGTH;
                    parts = 0;
                }
            }
        }
        prop_assert_eq!(counted + parts, bytes.len());
        prop_assert_eq!(replies.is_partial(), parts > 0);
        replies.forget();
        let angles = [168.5_f32, -12.25];
        let mut reply = vec![layout.device_id];
        for angle in layout.by_encoder_port(angles) {
            reply.extend(angle.to_le_bytes());
        }
        let heard: Vec<_> = reply.iter().map(|byte| replies.hear(*byte)).collect();
        prop_assert_eq!(heard.last(), Some(&Heard::Angles(angles)));
    }

    /// For any angles and force, the torques are finite and within the motors' range.
    #[test]
    fn any_angles_and_any_force_make_torques_that_can_be(
        angles in [any::<f64>(), any::<f64>()],
        near in [-4.0..7.0_f64, -4.0..7.0_f64],
        force in [any::<f64>(), any::<f64>()],
        generation in prop::sample::select(Generation::ALL.to_vec()),
        board in prop::sample::select(Board::ALL.to_vec()),
    ) {
        for angles in [angles, near] {
            let Ok(pose) = generation.layout().geometry.pose(angles) else {
                continue;
            };
            for force in [force, force.map(|part| part % 10.0)] {
                let (torques, given) = torques(&pose, board, force);
                prop_assert!(torques.iter().all(|torque| torque.abs() <= 0.123));
                prop_assert!(given.iter().all(|part| part.is_finite()));
            }
        }
    }
}
