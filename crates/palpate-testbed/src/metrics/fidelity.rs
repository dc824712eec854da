//! Errors of the held force over the whole window.

use crate::profile::ForceProfile;

/// Errors of the held force over the window, in percent of the ideal force's root mean square.
///
/// With f_i held over interval i of length h_i, J_i = ∫ f dt and Q_i = ∫ f² dt of the ideal force
/// there, and all sums over the window:
///
/// ```text
/// force rendering error   FRE   = 100 √( Σ (f_i² h_i − 2 f_i J_i + Q_i) / Σ Q_i )
/// hold floor              floor = 100 √( Σ (Q_i − J_i²/h_i) / Σ Q_i )
/// mean-force error        E     = 100 √( Σ h_i (f_i − J_i/h_i)² / Σ Q_i )
/// ```
///
/// The intervals are those in which the loop really holds one command; in a perfect loop each lasts
/// one period.
///
/// The sum in FRE is ∫ (f_held − f)² dt written out, so it involves no sampling. Taking means is an
/// orthogonal projection, hence FRE² = floor² + E²: the floor belongs to the loop, E to the
/// renderer. Each is computed by its own formula.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fidelity {
    /// Force rendering error FRE \[%\]. A force of zero all the time scores 100.
    ///
    /// Infinite, as is E, if a held force is not finite or its square is not.
    pub force_rendering_error: f64,
    /// The least FRE that forces held over these intervals can have \[%\].
    pub hold_floor: f64,
    /// Mean-force error E \[%\], the part a renderer answers for.
    pub mean_force_error: f64,
    /// FRE over floor, 1 at best; `None` if the floor is 0.
    pub error_over_floor: Option<f64>,
}

impl Fidelity {
    /// `None` if the ideal force is 0 throughout. The lengths have been compared by the caller.
    pub(super) fn of(held: &[f64], profile: &ForceProfile) -> Option<Self> {
        let period = profile.period();
        let ideal: f64 = profile.squared_forces().iter().sum();
        if ideal <= 0.0 {
            return None;
        }
        let (mut total, mut floor, mut mean) = (0.0, 0.0, 0.0);
        let intervals = profile.impulses().iter().zip(profile.squared_forces());
        let intervals = intervals.zip(profile.grid().durations());
        for (force, ((impulse, squared), duration)) in held.iter().zip(intervals) {
            // (f h − 2 J) first: a huge force then overflows to +∞ and not to a NaN.
            total += force * (force * duration - 2.0 * impulse) + squared;
            floor += squared - impulse * impulse / duration;
            // In periods: the factor is then exactly 1 in a perfect loop.
            mean += duration / period * (force - impulse / duration).powi(2);
        }
        let percent = |sum: f64| {
            if sum.is_nan() {
                f64::INFINITY
            } else {
                100.0 * (sum.max(0.0) / ideal).sqrt()
            }
        };
        let force_rendering_error = percent(total);
        let hold_floor = percent(floor);
        Some(Self {
            force_rendering_error,
            hold_floor,
            mean_force_error: percent(period * mean),
            error_over_floor: (hold_floor > 0.0).then(|| force_rendering_error / hold_floor),
        })
    }
}
