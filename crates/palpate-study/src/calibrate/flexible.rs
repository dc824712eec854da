//! Contact stiffness limit of a device with a flexible transmission.
//!
//! The renderer models one mass. The rendered contact has to be slower than the transmission, and slower still if a
//! period of the resonance has few samples. `docs/results/coupled.md` has the measurement.

use std::f64::consts::TAU;

use crate::calibrate::calibration::Calibration;
use crate::calibrate::quantity::Quantity;

/// Largest frequency of a contact over that of the first resonance.
const OF_RESONANCE: f64 = 0.4;
/// Largest frequency of a contact on a flexible device, in cycles per period.
const PER_PERIOD: f64 = 0.05;

impl Calibration {
    /// Returns the largest contact stiffness K `[N/m]` that the first resonance allows for an object of `object_mass`
    /// `[kg]` (infinite for a wall) in a loop of `period` `[s]`. Returns `None` if resonance or mass is unknown.
    ///
    /// ```text
    /// sqrt(K (1/m_motor + 1/M)) = 2 π min(0.4 f, 0.05 / T)
    /// ```
    ///
    /// with the resonance f and the mass m_motor on the motor's side of the transmission. If the mass distribution is
    /// unknown, m_motor is the device's mass. Below this stiffness the error E of coupled rendering is a few percent.
    /// At twice the frequency E is some ten percent or the loop gains energy.
    #[must_use]
    pub fn stiffest_contact(&self, object_mass: f64, period: f64) -> Option<f64> {
        let hertz = self.value(Quantity::Resonance)?;
        let mass = self.value(Quantity::DeviceMass)?;
        let beyond = self.value(Quantity::FlexibleMassFraction).unwrap_or(0.0);
        let of_motor = mass * (1.0 - beyond);
        let rate = TAU * (OF_RESONANCE * hertz).min(PER_PERIOD / period);
        Some(rate * rate / (1.0 / of_motor + 1.0 / object_mass))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::calibration::Known;

    #[test]
    fn the_slower_of_resonance_and_rate_bounds_the_contact() {
        let mut device = Calibration::default();
        let given = |value| Known::given(value, "given");
        assert_eq!(device.stiffest_contact(1.0, 1e-3), None);
        device.set(Quantity::Resonance, given(100.0));
        assert_eq!(device.stiffest_contact(1.0, 1e-3), None);
        device.set(Quantity::DeviceMass, given(0.2));
        let wall = f64::INFINITY;
        let at = |device: &Calibration, mass, period| {
            device.stiffest_contact(mass, period).unwrap().sqrt() / TAU
        };
        // All of 0.2 kg at 40 Hz, then half of it, then in series with an object as heavy.
        let whole = at(&device, wall, 1e-3);
        assert!((whole - 0.2_f64.sqrt() * 40.0).abs() < 1e-9, "{whole}");
        device.set(Quantity::FlexibleMassFraction, given(0.5));
        assert!((at(&device, wall, 1e-3) - 0.1_f64.sqrt() * 40.0).abs() < 1e-9);
        assert!((at(&device, 0.1, 1e-3) - 0.05_f64.sqrt() * 40.0).abs() < 1e-9);
        // 25 Hz at 500 Hz.
        assert!((at(&device, wall, 2e-3) - 0.1_f64.sqrt() * 25.0).abs() < 1e-9);
    }
}
