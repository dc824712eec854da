//! RealtimeSanitizer's runtime, which is linked under `-Zsanitizer=realtime`.

unsafe extern "C" {
    fn __rtsan_realtime_enter();
    fn __rtsan_realtime_exit();
}

/// Runs `tick` in a context in which blocking calls end the program with a report.
pub fn watched(tick: &mut dyn FnMut()) {
    // SAFETY: the calls increment and decrement the calling thread's real-time contexts, in pairs.
    unsafe { __rtsan_realtime_enter() };
    tick();
    // SAFETY: as above.
    unsafe { __rtsan_realtime_exit() };
}
