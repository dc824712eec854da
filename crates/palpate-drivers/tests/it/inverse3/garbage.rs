//! Parser with invalid input: it returns without a panic and accepts no implausible values.

use palpate_drivers::inverse3::Frame;
use proptest::prelude::*;
use serde_json::Value;

use crate::inverse3::believed::read;
use crate::inverse3::samples::{full_3_1, full_3_5};

fn any_json() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::from),
        any::<i64>().prop_map(Value::from),
        any::<f64>().prop_map(Value::from),
        "[a-z_0-9]{0,12}".prop_map(Value::from),
    ];
    leaf.prop_recursive(4, 32, 4, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..4).prop_map(Value::from),
            prop::collection::btree_map("[a-z_0-9]{0,12}", inner, 0..4)
                .prop_map(|map| Value::Object(map.into_iter().collect())),
        ]
    })
}

/// Paths in a frame that a test replaces by other values.
const PLACES: [&str; 12] = [
    "/session_id",
    "/inverse3",
    "/inverse3/0",
    "/inverse3/0/device_id",
    "/inverse3/0/config",
    "/inverse3/0/config/type",
    "/inverse3/0/config/device_info",
    "/inverse3/0/state",
    "/inverse3/0/state/cursor_position",
    "/inverse3/0/state/cursor_position/x",
    "/inverse3/0/state/cursor_velocity/y",
    "/inverse3/0/status/ready",
];

proptest! {
    #[test]
    fn bytes_of_any_kind(bytes in prop::collection::vec(any::<u8>(), 0..512)) {
        read(&bytes);
    }

    #[test]
    fn a_frame_cut_anywhere_is_no_frame(part in 0.0..1.0f64) {
        for whole in [full_3_1(), full_3_5()] {
            let text = whole.to_string();
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let cut = (text.len() as f64 * part) as usize;
            prop_assert!(Frame::parse(&text[..cut]).is_err());
            let more = text.clone() + &text[..cut.max(1)];
            prop_assert!(Frame::parse(&more).is_err());
        }
    }

    #[test]
    fn a_frame_with_bytes_changed(changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8)) {
        let mut bytes = full_3_5().to_string().into_bytes();
        for (index, byte) in changes {
            let at = index.index(bytes.len());
            bytes[at] = byte;
        }
        read(&bytes);
    }

    #[test]
    fn a_frame_with_anything_anywhere(place in prop::sample::select(PLACES.to_vec()), thing in any_json()) {
        let mut frame = full_3_5();
        *frame.pointer_mut(place).unwrap() = thing;
        read(frame.to_string().as_bytes());
    }
}

#[test]
fn a_frame_as_deep_as_memory_is_refused() {
    let deep = format!("{{\"new\":{}", "[".repeat(100_000));
    assert!(Frame::parse(&deep).is_err());
}
