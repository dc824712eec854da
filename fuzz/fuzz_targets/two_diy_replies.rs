//! Arbitrary output of a 2DIY's port: answers are parsed, and every angle gives a possible torque.
#![no_main]

use libfuzzer_sys::fuzz_target;
use palpate_drivers::two_diy::packet::{Heard, REPLY_LENGTH, Replies};
use palpate_drivers::two_diy::{Board, Generation, LARGEST_TORQUE, torques};

fuzz_target!(|bytes: &[u8]| {
    let Some((choice, bytes)) = bytes.split_first() else {
        return;
    };
    let generation = Generation::ALL[usize::from(*choice) % 3];
    let board = Board::ALL[usize::from(*choice) / 3 % 3];
    let layout = generation.layout();
    let mut replies = Replies::new(layout);
    let mut counted = 0;
    for byte in bytes {
        match replies.hear(*byte) {
            Heard::Part => {}
            Heard::Stray => counted += 1,
            Heard::Angles(angles) => {
                counted += REPLY_LENGTH;
                let angles = angles.map(|angle| f64::from(angle).to_radians());
                let Ok(pose) = layout.geometry.pose(angles) else {
                    continue;
                };
                assert!(pose.position.iter().all(|x| x.is_finite()));
                for force in [[1.0, 0.0], [0.0, -30.0], pose.position] {
                    let (torques, given) = torques(&pose, board, force);
                    assert!(torques.iter().all(|torque| torque.abs() <= LARGEST_TORQUE));
                    assert!(given.iter().all(|part| part.is_finite()));
                }
            }
        }
    }
    assert!(counted <= bytes.len() && bytes.len() - counted < REPLY_LENGTH);
});
