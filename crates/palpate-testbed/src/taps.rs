//! The motion of a hand that taps on something, for a demonstration without a recording.

/// Recording step `[s]`, as of a 2 kHz encoder.
const STEP: f64 = 0.0005;
/// Position quantum of that encoder `[m]`.
const QUANTUM: f64 = 2e-6;
/// The hand reaches from one of these positions to the next `[m]`, taking these times `[s]`.
const REACHES: [(f64, f64); 10] = [
    (-0.030, 0.25),
    (0.012, 0.30),
    (-0.025, 0.22),
    (0.018, 0.26),
    (0.018, 0.35),
    (-0.020, 0.28),
    (0.006, 0.18),
    (-0.015, 0.16),
    (0.022, 0.40),
    (-0.030, 0.40),
];

/// Minimum-jerk reaches with an 8 Hz tremor of 0.2 mm, seen through an encoder of 2 um at 2 kHz: times `[s]` from 0 on,
/// and positions `[m]` from -0.03 to 0.022.
#[must_use]
pub fn taps() -> (Vec<f64>, Vec<f64>) {
    let (mut times, mut positions) = (Vec::new(), Vec::new());
    let mut begin = REACHES[0].0;
    let mut start = 0_u32;
    for (end, duration) in REACHES {
        let steps = steps(duration);
        for i in 0..steps {
            let s = f64::from(i) / f64::from(steps);
            let reach = s * s * s * (10.0 + s * (6.0 * s - 15.0));
            let t = f64::from(start + i) * STEP;
            let tremor = 2e-4 * (2.0 * std::f64::consts::PI * 8.0 * t).sin();
            let position = begin + (end - begin) * reach + tremor;
            times.push(t);
            positions.push((position / QUANTUM).round() * QUANTUM);
        }
        begin = end;
        start += steps;
    }
    (times, positions)
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "durations are constants of less than a second"
)]
fn steps(duration: f64) -> u32 {
    (duration / STEP).round() as u32
}
