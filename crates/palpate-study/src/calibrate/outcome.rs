//! The parameters of a fit as quantities of the device.

use crate::calibrate::calibration::{Calibration, Known};
use crate::calibrate::fit::Fit;
use crate::calibrate::model::{self, at};
use crate::calibrate::quantity::Quantity;

/// Device parameters of a fit, in SI units.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The parameters.
    pub calibration: Calibration,
}

const FIT: &str = "fit to the motion under random force steps";

impl Fitted {
    pub(crate) fn new(fit: &Fit, period: f64, quantum: Option<f64>) -> Self {
        let mut fitted = Self {
            calibration: Calibration::default(),
        };
        let (point, sd) = (&fit.point, &fit.deviation);
        fitted.set(Quantity::Period, period, 0.0, "given".into());

        let mass = (-point[at::LN_MOBILITY]).exp();
        let of_mass = sd[at::LN_MOBILITY];
        fitted.set(
            Quantity::DeviceMass,
            mass,
            mass * of_mass,
            format!(
                "{FIT}: mass over gain, with gain 1; includes the part of the hand that moves with it"
            ),
        );
        fitted.set_delay_and_lag(fit, period);
        fitted.set_forces(fit, mass, of_mass);
        if fit.is_flexible() {
            fitted.set_resonance(fit);
        }
        if let Some(quantum) = quantum {
            fitted.set(
                Quantity::SensorQuantum,
                quantum,
                1e-3 * quantum,
                "smallest step between positions".into(),
            );
        }
        fitted.set(
            Quantity::SensorNoise,
            fit.sensor_noise,
            fit.sensor_noise / (2.0 * fit.count as f64).sqrt(),
            format!("{FIT}: uncorrelated part of the residual"),
        );
        fitted
    }

    /// Sets a quantity with its standard deviation, in the unit of its key, and its source.
    fn set(&mut self, quantity: Quantity, value: f64, deviation: f64, by: String) {
        self.calibration
            .set(quantity, Known::found(value, deviation, by));
    }

    /// Sets the delay, the lag and their sum at `period` `[s]`.
    fn set_delay_and_lag(&mut self, fit: &Fit, period: f64) {
        let (point, sd) = (&fit.point, &fit.deviation);
        let sum = point[at::DELAY_PLUS_LAG];
        let of_sum = sd[at::DELAY_PLUS_LAG];
        let lag = model::lag(point);
        let of_square = sd[at::LAG_SQUARED];
        // Neither exceeds the sum of both.
        let of_lag = (of_square / (2.0 * lag.max(1e-9)))
            .min(of_square.sqrt())
            .min(sum);
        let together = "the sum of delay and lag is more accurate: see delay_plus_lag_s";
        self.set(
            Quantity::Delay,
            (sum - lag) * period,
            of_sum.hypot(of_lag) * period,
            format!("{FIT}; {together}"),
        );
        self.set(
            Quantity::Lag,
            lag * period,
            of_lag * period,
            format!("{FIT}; {together}"),
        );
        self.set(
            Quantity::DelayPlusLag,
            sum * period,
            of_sum * period,
            FIT.into(),
        );
    }

    /// Sets friction and hand stiffness, for a `mass` `[kg]` with the relative standard deviation `of_mass`.
    fn set_forces(&mut self, fit: &Fit, mass: f64, of_mass: f64) {
        let (point, sd) = (&fit.point, &fit.deviation);
        // A force over the mass times the mass: both deviations count.
        let mut force = |quantity, at: usize, by: &str| {
            let value = point[at] * mass;
            let deviation = (sd[at] * mass).hypot(value * of_mass);
            self.set(quantity, value.max(0.0), deviation, format!("{FIT}{by}"));
        };
        force(
            Quantity::ViscousFriction,
            at::DAMPING,
            ", in commanded newtons; includes the damping of the hand",
        );
        force(
            Quantity::CoulombFriction,
            at::FRICTION,
            ", in commanded newtons",
        );
        force(
            Quantity::HandStiffness,
            at::STIFFNESS,
            ", in commanded newtons",
        );
    }

    /// Sets the resonance of a flexible device, its damping ratio and its mass fraction.
    fn set_resonance(&mut self, fit: &Fit) {
        let (point, sd) = (&fit.point, &fit.deviation);
        let fraction = fit.fraction();
        let of_fraction = sd[at::LOGIT_FRACTION] * fraction * (1.0 - fraction);
        let hertz = fit.resonance();
        // ln f = ln f_alone - ln(1 - fraction) / 2.
        let of_hertz = hertz * sd[at::LN_ANTIRESONANCE].hypot(0.5 * of_fraction / (1.0 - fraction));
        let by = format!("{FIT}; two masses fit better than one");
        self.set(Quantity::Resonance, hertz, of_hertz, by.clone());
        let ratio = point[at::FLEXIBLE_DAMPING] / (1.0 - fraction).sqrt();
        let of_ratio = sd[at::FLEXIBLE_DAMPING] / (1.0 - fraction).sqrt();
        self.set(Quantity::ResonanceDampingRatio, ratio, of_ratio, by.clone());
        self.set(Quantity::FlexibleMassFraction, fraction, of_fraction, by);
    }
}
