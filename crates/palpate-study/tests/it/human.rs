//! Replay of recorded hands: sums of absolute leaks of the held force.
//!
//! The recordings are not part of the repository. If they are missing, the test prints a note and checks nothing.

use crate::common::{lifted_object, recorded_hands};
use palpate_scene::method::{MethodName, Settings};

/// mJ, of the basic model and of the modified force with smooth transition.
const LEAKS: [(f64, f64); 6] = [
    (113.0, 0.557),
    (122.0, 0.307),
    (76.9, 0.597),
    (210.0, 2.29),
    (143.0, 6.47),
    (215.0, 3.49),
];

#[test]
fn smooth_transitions_leak_less_than_a_twentieth_on_recorded_hands() {
    let hands = recorded_hands("the leak on recorded hands");
    for (hand, (basic, smooth)) in hands.iter().zip(LEAKS) {
        let replay = lifted_object(hand, 0.01, false);
        let leak = |method| {
            let run = replay.run(method, &Settings::default()).unwrap();
            assert_eq!(run.faults(), 0);
            1e3 * run.last().ledger.held_leak.absolute
        };
        let given = (leak(MethodName::Basic), leak(MethodName::HfcrModSt));
        eprintln!(
            "{}: basic {:.3} mJ, hfcr-mod-st {:.4} mJ, ratio {:.1}",
            hand.name,
            given.0,
            given.1,
            given.0 / given.1
        );
        for (given, expected) in [(given.0, basic), (given.1, smooth)] {
            assert!(
                (given / expected - 1.0).abs() < 0.01,
                "{given} for {expected}"
            );
        }
    }
}
