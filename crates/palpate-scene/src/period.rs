//! Times that are likely to be in another unit.

/// Period above which its unit is likely to be milliseconds `[s]`.
const LONGEST_USUAL: f64 = 0.25;

/// The question whether a period `[s]`, called `name`, is in milliseconds; none if a haptic loop may have it. `usual`
/// is how a period of 1 ms is written.
#[must_use]
pub fn period_question(name: &str, usual: &str, period: f64) -> Option<String> {
    (period > LONGEST_USUAL && period.is_finite()).then(|| {
        let rate = (1e3 / period).round() / 1e3;
        format!(
            "{name} is {period} s, a loop of {rate} Hz; is it in milliseconds? A period of 1 ms is {usual}"
        )
    })
}

/// Lag above which its unit is likely to be milliseconds `[s]`.
const LONGEST_USUAL_LAG: f64 = 0.1;

/// The question whether a lag `[s]`, called `name`, is in milliseconds; none if an actuator of a haptic device may have
/// it. `usual` is how a lag of 1 ms is written.
#[must_use]
pub fn lag_question(name: &str, usual: &str, lag: f64) -> Option<String> {
    (lag > LONGEST_USUAL_LAG && lag.is_finite())
        .then(|| format!("{name} is {lag} s; is it in milliseconds? A lag of 1 ms is {usual}"))
}
