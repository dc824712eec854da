//! The gain of a motor from a known spring or a known mass; motion alone does not determine it.

use crate::calibrate::calibration::{Calibration, Known};
use crate::calibrate::quantity::Quantity;

/// Relative standard deviation above which a gain is not reported.
const MAX_DEVIATION: f64 = 0.2;

/// Quantities measured in commanded newtons, converted to newtons once the gain is known.
const COMMANDED: [Quantity; 4] = [
    Quantity::DeviceMass,
    Quantity::ViscousFriction,
    Quantity::CoulombFriction,
    Quantity::HandStiffness,
];

impl Calibration {
    /// Returns the gain of a device that was fixed to a spring of `stiffness` `[N/m]`, without a hand: the stiffness
    /// over the one measured in commanded newtons. Returns `None` if the relative standard deviation exceeds 20 %.
    #[must_use]
    pub fn gain_by_spring(&self, stiffness: f64) -> Option<Known> {
        let found = self.known.get(&Quantity::HandStiffness)?;
        let of_found = found.standard_deviation? / found.value;
        gain(
            stiffness / found.value,
            of_found,
            format!("a spring of {stiffness} N/m"),
        )
    }

    /// Returns the gain if this device has `mass` `[kg]` more than `before`, both without a hand: the mass over the
    /// difference of the measured masses. Returns `None` if the relative standard deviation exceeds 20 %.
    #[must_use]
    pub fn gain_by_added_mass(&self, before: &Self, mass: f64) -> Option<Known> {
        // The earlier calibration may be in newtons already.
        let over_gain = |of: &Self| {
            let found = of.known.get(&Quantity::DeviceMass)?;
            let gain = of.value(Quantity::Gain).unwrap_or(1.0);
            Some((found.value / gain, found.standard_deviation? / gain))
        };
        let (after, of_after) = over_gain(self)?;
        let (less, of_less) = over_gain(before)?;
        let difference = after - less;
        let of_difference = of_after.hypot(of_less) / difference;
        gain(
            mass / difference,
            of_difference,
            format!("an added mass of {mass} kg"),
        )
    }

    /// Sets the gain and converts mass, friction and stiffness from commanded newtons to newtons.
    pub fn set_gain(&mut self, gain: Known) {
        let of_gain = gain.standard_deviation.unwrap_or(0.0) / gain.value;
        for quantity in COMMANDED {
            if let Some(known) = self.known.get(&quantity).cloned() {
                let value = known.value * gain.value;
                let own = known.standard_deviation.unwrap_or(0.0) * gain.value;
                let by = known.found_by.unwrap_or_default();
                let by = by
                    .replace(
                        "mass over gain, with gain 1",
                        "mass over gain, times the gain",
                    )
                    .replace("in commanded newtons", "times the gain");
                self.set(
                    quantity,
                    Known::found(value, own.hypot(value * of_gain), by),
                );
            }
        }
        self.set(Quantity::Gain, gain);
    }
}

fn gain(value: f64, relative: f64, by: String) -> Option<Known> {
    let is_known = value > 0.0 && value.is_finite() && (0.0..MAX_DEVIATION).contains(&relative);
    is_known.then(|| Known::found(value, value * relative, by))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(mass: f64, stiffness: f64) -> Calibration {
        let mut calibration = Calibration::default();
        calibration.set(
            Quantity::DeviceMass,
            Known::found(mass, 1e-4, "mass over gain, with gain 1"),
        );
        calibration.set(
            Quantity::HandStiffness,
            Known::found(stiffness, 1.0, "fit, in commanded newtons"),
        );
        calibration
    }

    #[test]
    fn a_known_spring_and_a_known_mass_give_the_gain() {
        // A motor that gives 0.8 N for 1 N moves 0.2 kg as if they were 0.25 kg, and 100 N/m seem 125 N/m.
        let before = found(0.25, 125.0);
        let by_spring = before.gain_by_spring(100.0).unwrap();
        assert!((by_spring.value - 0.8).abs() < 1e-3, "{by_spring:?}");
        let by_mass = found(0.375, 0.0).gain_by_added_mass(&before, 0.1).unwrap();
        assert!((by_mass.value - 0.8).abs() < 1e-3, "{by_mass:?}");
        let mut known = before.clone();
        known.set_gain(by_spring);
        assert!((known.value(Quantity::DeviceMass).unwrap() - 0.2).abs() < 1e-3);
        assert!((known.value(Quantity::HandStiffness).unwrap() - 100.0).abs() < 0.2);
        // Values in newtons are not divided by the gain again.
        let again = found(0.375, 0.0).gain_by_added_mass(&known, 0.1).unwrap();
        assert!((again.value - 0.8).abs() < 2e-3, "{again:?}");
    }

    #[test]
    fn a_gain_that_is_hardly_known_is_not_said() {
        assert_eq!(found(0.25, 3.0).gain_by_spring(100.0), None);
        assert_eq!(
            found(0.25, 0.0).gain_by_added_mass(&found(0.2502, 0.0), 0.1),
            None
        );
    }
}
