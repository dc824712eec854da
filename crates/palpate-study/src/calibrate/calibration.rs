//! Known parameters of a loop, each with its standard deviation and origin.

use std::collections::BTreeMap;

use crate::calibrate::quantity::Quantity;

/// A value with its uncertainty and origin.
#[derive(Clone, Debug, PartialEq)]
pub struct Known {
    /// The value, in the unit of the quantity's key.
    pub value: f64,
    /// Standard deviation in the same unit; `None` if unknown.
    pub standard_deviation: Option<f64>,
    /// Origin of the value, in plain words; `None` if unknown.
    pub found_by: Option<String>,
}

impl Known {
    /// Creates a measured value, rounded to a hundredth of its standard deviation.
    pub fn found(value: f64, standard_deviation: f64, by: impl Into<String>) -> Self {
        let step = if standard_deviation > 0.0 && standard_deviation.is_finite() {
            10f64.powi(power_of_ten(standard_deviation) - 2)
        } else {
            0.0
        };
        Self {
            value: rounded(value, step),
            standard_deviation: Some(rounded(standard_deviation, step)),
            found_by: Some(by.into()),
        }
    }

    /// Creates a value that was given, not measured.
    pub fn given(value: f64, by: impl Into<String>) -> Self {
        Self {
            value,
            standard_deviation: None,
            found_by: Some(by.into()),
        }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "the logarithm of a finite number is within 309"
)]
fn power_of_ten(value: f64) -> i32 {
    value.log10().floor() as i32
}

/// Rounds `value` to the nearest multiple of `step`, a power of ten, without digits beyond it.
fn rounded(value: f64, step: f64) -> f64 {
    if step == 0.0 {
        return value;
    }
    // Dividing by a whole power of ten gives the shortest decimal; multiplying by a fraction does not.
    if step < 1.0 {
        let per_unit = (1.0 / step).round();
        (value * per_unit).round() / per_unit
    } else {
        (value / step).round() * step
    }
}

/// Known parameters of a loop along one axis. A missing quantity is unknown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Calibration {
    /// Values by quantity.
    pub known: BTreeMap<Quantity, Known>,
    /// The axis along which the values were measured, in the words of the device.
    pub axis: Option<String>,
    /// Date of the measurement.
    pub date: Option<String>,
    /// Source of the values: a command or a person.
    pub command: Option<String>,
}

impl Calibration {
    /// Returns the value of a quantity, in the unit of its key, or `None` if it is unknown.
    #[must_use]
    pub fn value(&self, quantity: Quantity) -> Option<f64> {
        self.known.get(&quantity).map(|known| known.value)
    }

    /// Returns the standard deviation of a quantity, in the unit of its key, or `None` if it is unknown.
    #[must_use]
    pub fn standard_deviation(&self, quantity: Quantity) -> Option<f64> {
        self.known.get(&quantity)?.standard_deviation
    }

    /// Returns the sum of delay and lag `[s]`: the measured sum, or the sum of both values if both are known.
    #[must_use]
    pub fn delay_plus_lag(&self) -> Option<f64> {
        self.value(Quantity::DelayPlusLag)
            .or_else(|| Some(self.value(Quantity::Delay)? + self.value(Quantity::Lag)?))
    }

    /// Sets the value of a quantity.
    pub fn set(&mut self, quantity: Quantity, known: Known) {
        self.known.insert(quantity, known);
    }

    /// Returns a copy in which the stated values replace the measured ones.
    #[must_use]
    pub fn stating(mut self, stated: impl IntoIterator<Item = (Quantity, Option<f64>)>) -> Self {
        for (quantity, value) in stated {
            if let Some(value) = value {
                self.set(quantity, Known::given(value, "given"));
            }
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_found_value_has_as_many_digits_as_its_deviation_warrants() {
        let mass = Known::found(0.253_846_153_8, 0.001_234_5, "fit");
        assert_eq!(mass.value.to_string(), "0.25385");
        assert_eq!(
            mass.standard_deviation.map(|sd| sd.to_string()),
            Some("0.00123".into())
        );
        let stiffness = Known::found(4321.987, 3456.0, "fit");
        assert_eq!(stiffness.value.to_string(), "4320");
        let exact = Known::found(0.1 + 0.2, 0.0, "given");
        assert_eq!(exact.value.to_bits(), (0.1_f64 + 0.2).to_bits());
    }
}
