//! Slope of the line that an actuator with a line hold gives.
//!
//! Of all lines the nearest to the contact's force f has its impulse J and its first moment about the middle of the
//! interval:
//!
//! ```text
//! f0 = J/h,   s = 12 J1/h^3,   J1 = integral of f (t - h/2)
//! ```
//!
//! Both follow from the relative motion, p'' = a - mu f, without another integral:
//!
//! ```text
//! mu J1 = p(h) - p(0) - (p'(0) + p'(h)) h/2
//! ```
//!
//! The slope amplifies an error of the predicted motion by 12/h^3. Its share therefore follows the certainty of J1,
//! with the variance of J1 from the observer's covariance: `1/(1 + (variance/J1^2)^2)`. An uncertain prediction holds a
//! constant. The share `1/(1 + variance/J1^2)`, of the least expected error, also takes a part of a slope that is known
//! well (E of 0.2 % in place of 0.0 % on the paper's experiment 2).

use super::Coupled;
use super::interval::Interval;
use crate::Scalar;
use crate::render::predict::{EstimatedMotion, Observer, Sway};

impl<S: Scalar> Coupled<S> {
    /// Returns the slope of the force over `interval` `[N/s]`, which begins `delay` `[s]` after the observer's sample.
    /// `sway`: stretch of the proxy's transmission at its beginning.
    pub(super) fn slope(
        &self,
        observer: &Observer<S>,
        device: &EstimatedMotion<S>,
        interval: &Interval<S>,
        sway: Sway<S>,
        delay: S,
    ) -> S {
        let (mu, h) = (interval.drive.mobility, interval.duration);
        if mu <= S::ZERO || interval.course.impulse <= S::ZERO {
            return S::ZERO;
        }
        let (start, end) = (interval.start, interval.course.end);
        let half = S::HALF * h;
        let moved = end.penetration - start.penetration;
        let moment = (moved - (start.speed + end.speed) * half) / mu;
        let Some(response) = self.response(interval, device, sway) else {
            return S::ZERO;
        };
        let (place, speed) = (&response.penetration, &response.speed);
        // Derivatives of the moment by the device's state at the interval's beginning.
        let by_place = (place[0] - S::ONE - half * speed[0]) / mu;
        let by_speed = (place[1] - half - half * speed[1]) / mu;
        let by_external = (place[2] - half * speed[2]) / mu;
        let by_mobility = (place[3] - half * speed[3] - moment) / mu;
        // By the state at the sample.
        let variance = observer.variance_of(&[
            by_place,
            by_speed + delay * by_place,
            by_external + delay * (by_speed + S::HALF * delay * by_place),
            by_mobility,
            S::ZERO,
        ]);
        // The moment is a difference of positions: in single precision a soft contact has only its rounding.
        let largest = start.penetration.abs() + end.penetration.abs() + start.speed.abs() * h;
        let rounding = S::EPSILON * largest / mu;
        let uncertainty = (variance + rounding * rounding) / (moment * moment);
        let share = S::ONE / (S::ONE + uncertainty * uncertainty);
        let slope = S::from_f64(12.0) * moment * share / (h * h * h);
        if slope.is_finite() { slope } else { S::ZERO }
    }
}
