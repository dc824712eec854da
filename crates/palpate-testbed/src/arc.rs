//! One arc of the relative motion: a stretch of time that is free or in contact throughout.

use std::f64::consts::TAU;

use crate::relative_motion::{RelativeMotion, RelativeState};

/// A stretch of the relative motion between two events.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Arc {
    pub motion: RelativeMotion,
    /// `[s]`
    pub start: f64,
    /// `[s]`; infinite when nothing ends the arc.
    pub end: f64,
    pub in_contact: bool,
    pub at_start: RelativeState,
    /// State at the event that ends the arc, exactly at the surface; meaningless if none does.
    pub at_end: RelativeState,
}

/// Integrals of the ideal force f over an interval.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct ForceSums {
    /// ∫ f dt `[N s]`.
    pub impulse: f64,
    /// ∫ f (t − t₀) dt about an instant t₀ `[N s²]`.
    pub moment: f64,
    /// ∫ f² dt `[N² s]`.
    pub square: f64,
}

impl ForceSums {
    /// Adds the integrals of another part of the interval, with a moment about an instant that is `later` `[s]`.
    pub fn add(&mut self, part: Self, later: f64) {
        self.impulse += part.impulse;
        self.moment += part.moment + later * part.impulse;
        self.square += part.square;
    }
}

/// Abscissae and weights of the eight-point Gauss-Legendre rule on `[−1, 1]`, positive half.
pub(crate) const GAUSS_LEGENDRE: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

impl Arc {
    /// State at an absolute time `[s]` on this arc.
    pub fn state(&self, time: f64) -> RelativeState {
        self.state_after(time - self.start)
    }

    /// Contact force `[N]` at an absolute time `[s]` on this arc.
    pub fn force(&self, time: f64) -> f64 {
        if self.in_contact {
            self.motion.stiffness * self.state(time).penetration.max(0.0)
        } else {
            0.0
        }
    }

    /// The same arc, later by `delay` `[s]`.
    pub fn delayed(&self, delay: f64) -> Self {
        Self {
            start: self.start + delay,
            end: self.end + delay,
            ..*self
        }
    }

    /// The integrals from `from` to `to`, both on this arc, with the moment about the middle.
    ///
    /// The rule is applied to spans of at most one radian, where its remainder for a harmonic and
    /// its square is below 1e-17 of the integral. Unlike the antiderivative it adds up only
    /// positive terms, so nothing cancels in short or soft contacts.
    pub fn sums(&self, from: f64, to: f64) -> ForceSums {
        if !self.in_contact || to <= from {
            return ForceSums::default();
        }
        let spans = ((to - from) * self.motion.rate).ceil().max(1.0);
        let half = 0.5 * (to - from) / spans;
        let (mut sum, mut sum_of_squares, mut moment) = (0.0, 0.0, 0.0);
        let centre = 0.5 * (from + to) - self.start;
        let mut span = 0.0;
        while span < spans {
            let middle = from - self.start + half * (2.0 * span + 1.0);
            for (abscissa, weight) in GAUSS_LEGENDRE {
                for s in [middle - half * abscissa, middle + half * abscissa] {
                    let p = self.state_after(s).penetration;
                    sum += weight * p;
                    sum_of_squares += weight * p * p;
                    moment += weight * p * (s - centre);
                }
            }
            span += 1.0;
        }
        let k = self.motion.stiffness;
        ForceSums {
            impulse: k * half * sum,
            moment: k * half * moment,
            square: k * k * half * sum_of_squares,
        }
    }

    /// Largest contact force `[N]` from `from` to `to`, both on this arc.
    pub fn peak_force(&self, from: f64, to: f64) -> f64 {
        if !self.in_contact {
            return 0.0;
        }
        let ends = self.force(from).max(self.force(to));
        match self.next_summit(from - self.start) {
            Some(s) if s <= to - self.start => {
                let summit = self.motion.stiffness * self.state_after(s).penetration;
                ends.max(summit)
            }
            _ => ends,
        }
    }

    /// First time after the start `[s]`, not before `earliest`, at which the penetration of a
    /// contact is largest.
    fn next_summit(&self, earliest: f64) -> Option<f64> {
        let (a, w) = (self.motion.acceleration, self.motion.rate);
        let RelativeState {
            penetration: p,
            velocity: v,
        } = self.at_start;
        let braking = w * w * p - a;
        if w > 0.0 {
            // p′ = v cos(ws) − (braking/w) sin(ws) passes zero downwards.
            let first = (w * v).atan2(braking).rem_euclid(TAU) / w;
            let turns = ((earliest - first) * w / TAU).ceil().max(0.0);
            Some(first + turns * TAU / w)
        } else {
            (braking > 0.0)
                .then(|| v / braking)
                .filter(|&s| s >= earliest)
        }
    }

    /// State `s` `[s]` after the start of the arc.
    ///
    /// p = p₀ cos(ωs) + v₀ sin(ωs)/ω + a (1 − cos(ωs))/ω², with ω = 0 while free.
    fn state_after(&self, s: f64) -> RelativeState {
        let RelativeState {
            penetration: p,
            velocity: v,
        } = self.at_start;
        let a = self.motion.acceleration;
        let w = if self.in_contact {
            self.motion.rate
        } else {
            0.0
        };
        let cosine = (w * s).cos();
        let sine = s * sinc(w * s); // sin(ωs)/ω
        let half = s * sinc(0.5 * w * s);
        let versine = 0.5 * half * half; // (1 − cos(ωs))/ω²
        RelativeState {
            penetration: p * cosine + v * sine + a * versine,
            velocity: v * cosine + (a - w * w * p) * sine,
        }
    }
}

/// sin(x)/x, 1 at 0.
fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { x.sin() / x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quadrature_integrates_polynomials_up_to_degree_fifteen() {
        for degree in (0..=14).step_by(2) {
            let integral: f64 = GAUSS_LEGENDRE
                .iter()
                .map(|(abscissa, weight)| 2.0 * weight * abscissa.powi(degree))
                .sum();
            assert!((integral - 2.0 / f64::from(degree + 1)).abs() < 1e-15);
        }
    }
}
