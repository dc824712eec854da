//! RealtimeSanitizer's runtime, which is linked under `-Zsanitizer=realtime`.

unsafe extern "C" {
    fn __rtsan_realtime_enter();
    fn __rtsan_realtime_exit();
}

/// Runs `tick` where calls that may block end the program with a report.
pub fn watched(tick: &mut dyn FnMut()) {
    // SAFETY: they count the calling thread's real-time contexts up and down, in pairs.
    unsafe { __rtsan_realtime_enter() };
    tick();
    // SAFETY: as above.
    unsafe { __rtsan_realtime_exit() };
}
