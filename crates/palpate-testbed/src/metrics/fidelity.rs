//! Errors of the held force over the whole window.

use crate::profile::ForceProfile;

/// Errors of the held force over the window, in percent of the ideal force's root mean square.
///
/// With f_i held over interval i of length h_i, J_i = ∫ f dt and Q_i = ∫ f² dt of the ideal force
/// there, and all sums over the window:
///
/// ```text
/// force rendering error   FRE   = 100 √( Σ (f_i² h_i − 2 f_i J_i + Q_i) / Σ Q_i )
/// hold bound              floor = 100 √( Σ (Q_i − J_i²/h_i) / Σ Q_i )
/// mean-force error        E     = 100 √( Σ h_i (f_i − J_i/h_i)² / Σ Q_i )
/// ```
///
/// The intervals are those over which the loop actually holds one command; in a perfect loop each lasts one period.
///
/// A line of mean f_i and slope s_i has the first moment s_i h_i³/12. With J1_i = ∫ f (t − t₀) dt of the ideal force
/// about the middle of the interval, FRE gains s_i² h_i³/12 − 2 s_i J1_i, the bound −12 J1_i²/h_i³, and E
/// h_i³/12 (s_i − 12 J1_i/h_i³)².
///
/// The sum in FRE is the expanded form of ∫ (f_held − f)² dt and involves no sampling. Taking means is an orthogonal
/// projection, and so is the nearest line, hence FRE² = floor² + E²: the bound depends only on the loop and its hold, E
/// on the renderer. Each is computed by its own formula.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Fidelity {
    /// Force rendering error FRE `[%]`. A force of zero all the time scores 100.
    ///
    /// Infinite, as is E, if a held force is not finite or its square is not.
    pub force_rendering_error: f64,
    /// The least FRE that forces held over these intervals can have `[%]`.
    pub hold_bound: f64,
    /// Mean-force error E `[%]`, the part of the error that a renderer can avoid; with lines also that of the slopes.
    pub mean_force_error: f64,
    /// FRE over floor, 1 at best; `None` if the floor is 0.
    pub error_over_bound: Option<f64>,
}

impl Fidelity {
    /// `None` if the ideal force is 0 throughout. The lengths have been compared by the caller.
    pub(super) fn new(held: &[f64], profile: &ForceProfile) -> Option<Self> {
        let mut meter = FidelityMeter::new(profile);
        for force in held {
            meter.hold(*force);
        }
        meter.fidelity()
    }

    /// The same for lines of the means `held` and `slopes` `[N/s]`.
    pub(super) fn of_lines(held: &[f64], slopes: &[f64], profile: &ForceProfile) -> Option<Self> {
        let mut meter = FidelityMeter::new(profile);
        for (force, slope) in held.iter().zip(slopes) {
            meter.hold_line(*force, *slope);
        }
        meter.fidelity()
    }
}

/// Least share of ∫ f² along all axes that is a force along one of them: a force of 1e-6 of the whole is not felt, and
/// of bodies that settle it is rounding of the ideal.
const MIN_SHARE: f64 = 1e-12;

/// The sums from which a [`Fidelity`] follows.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ErrorSums {
    ideal: f64,
    total: f64,
    floor: f64,
    mean: f64,
}

impl ErrorSums {
    /// Adds an interval of a length `duration` `[s]` in which a `force` `[N]` was held, J and Q of the ideal.
    #[inline]
    pub(crate) fn add(
        &mut self,
        force: f64,
        impulse: f64,
        squared: f64,
        duration: f64,
        period: f64,
    ) {
        self.ideal += squared;
        // (f h − 2 J) first: a huge force then overflows to +∞ and not to a NaN.
        self.total += force * (force * duration - 2.0 * impulse) + squared;
        self.floor += squared - impulse * impulse / duration;
        // In periods: the factor is then exactly 1 in a perfect loop.
        self.mean += duration / period * (force - impulse / duration).powi(2);
    }

    /// Adds what the slope `[N/s]` of a line changes in an interval whose mean was [added](Self::add); `moment` is J₁.
    #[inline]
    pub(crate) fn add_slope(&mut self, slope: f64, moment: f64, duration: f64, period: f64) {
        let of_line = duration.powi(3) / 12.0;
        self.total += slope * (slope * of_line - 2.0 * moment);
        self.floor -= moment * moment / of_line;
        self.mean += of_line / period * (slope - moment / of_line).powi(2);
    }

    /// The errors; `None` if the ideal force is 0 throughout.
    pub(crate) fn fidelity(&self, period: f64) -> Option<Fidelity> {
        self.fidelity_beside(period, 0.0)
    }

    /// ∫ f² of the ideal.
    pub(crate) fn ideal(&self) -> f64 {
        self.ideal
    }

    /// The errors along an axis of a force whose ∫ f² along all axes is `all`; `None` if the ideal force along this
    /// axis is 0 or rounding, below [`MIN_SHARE`] of `all`.
    pub(crate) fn fidelity_beside(&self, period: f64, all: f64) -> Option<Fidelity> {
        let ideal = self.ideal;
        if ideal <= MIN_SHARE * all || ideal <= 0.0 {
            return None;
        }
        let percent = |sum: f64| {
            if sum.is_nan() {
                f64::INFINITY
            } else {
                100.0 * (sum.max(0.0) / ideal).sqrt()
            }
        };
        let force_rendering_error = percent(self.total);
        let hold_bound = percent(self.floor);
        Some(Fidelity {
            force_rendering_error,
            hold_bound,
            mean_force_error: percent(period * self.mean),
            error_over_bound: (hold_bound > 0.0).then(|| force_rendering_error / hold_bound),
        })
    }
}

/// The [`Fidelity`] of forces that come one after the other, without a record of them.
#[derive(Debug, Clone)]
pub struct FidelityMeter<'a> {
    profile: &'a ForceProfile,
    interval: usize,
    sums: ErrorSums,
}

impl<'a> FidelityMeter<'a> {
    /// A meter at the start of the window of `profile`.
    #[must_use]
    pub fn new(profile: &'a ForceProfile) -> Self {
        Self {
            profile,
            interval: 0,
            sums: ErrorSums::default(),
        }
    }

    /// The force `[N]` held over the next interval; those after the window are not looked at.
    #[inline]
    pub fn hold(&mut self, force: f64) {
        let (impulses, squares) = (self.profile.impulses(), self.profile.squared_forces());
        let (Some(impulse), Some(squared)) =
            (impulses.get(self.interval), squares.get(self.interval))
        else {
            return;
        };
        let duration = self.profile.grid().duration(self.interval);
        self.interval += 1;
        self.sums
            .add(force, *impulse, *squared, duration, self.profile.period());
    }

    /// The line of mean `force` `[N]` and `slope` `[N/s]` held over the next interval, as [`hold`](Self::hold). Use one
    /// of the two throughout: the bound is that of the hold.
    #[inline]
    pub fn hold_line(&mut self, force: f64, slope: f64) {
        if let Some(moment) = self.profile.moments().get(self.interval) {
            let duration = self.profile.grid().duration(self.interval);
            let period = self.profile.period();
            self.sums.add_slope(slope, *moment, duration, period);
        }
        self.hold(force);
    }

    /// Whether every interval of the window has had its force.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.interval == self.profile.intervals()
    }

    /// The errors of the forces so far, over the intervals they were held; `None` if the ideal
    /// force is 0 in all of them.
    #[must_use]
    pub fn fidelity(&self) -> Option<Fidelity> {
        self.sums.fidelity(self.profile.period())
    }
}

#[cfg(test)]
mod axis_tests {
    use super::*;

    /// An axis whose force is `share` of the force along another axis, and is rendered as 0.
    fn along(share: f64) -> Option<Fidelity> {
        let mut sums = ErrorSums::default();
        sums.add(0.0, share * 1e-3, share * share * 1e-3, 1e-3, 1e-3);
        sums.fidelity_beside(1e-3, 1e-3 + sums.ideal())
    }

    #[test]
    fn an_axis_with_nothing_but_rounding_on_it_has_no_error() {
        assert_eq!(along(1e-7), None);
        let error = along(1e-5).unwrap().mean_force_error;
        assert!((error - 100.0).abs() < 1e-6, "{error}");
    }
}
