//! Accepted values for arbitrary bytes. The fuzzer generates millions of inputs (`fuzz/`), the tests a few.

use palpate_drivers::inverse3::{FARTHEST, FASTEST, Frame};

/// Checks that the values accepted from any `bytes` are within bounds.
pub fn read(bytes: &[u8]) {
    let Ok(text) = str::from_utf8(bytes) else {
        return;
    };
    let Ok(frame) = Frame::parse(text) else {
        return;
    };
    for device in frame.devices() {
        assert_eq!(frame.device(&device.device_id), Some(device));
        let Ok(sample) = device.sample() else {
            continue;
        };
        assert!(sample.position.iter().all(|x| x.abs() <= FARTHEST));
        let velocity = sample.velocity.unwrap_or_default();
        assert!(velocity.iter().all(|v| v.abs() <= FASTEST));
        let force = sample.force.unwrap_or_default();
        assert!(force.iter().all(|f| f.is_finite()));
    }
}
