//! Converts flags and a device file to the actuation of a scene and the model values of its renderer.

use palpate_core::{
    Actuation, Allowed, Hold, LARGEST_DELAY, Parameter, ParameterError, Range, Transmission,
};
use palpate_scene::{Delay, Scene};
use palpate_study::calibrate::Quantity;
use palpate_testbed::hold::DelayedHold;

use super::device_file::DeviceFile;
use super::wrong::{not_allowed, not_allowed_by};
use crate::arguments::ActuationFlags;
use crate::failure::{Failure, tell};

impl ActuationFlags {
    /// Rejects impossible values of an actuator.
    pub fn check(&self) -> Result<(), Failure> {
        let (positive, not_negative) = (Range::Positive, Range::NotNegative);
        for (flag, parameter, range, value) in [
            ("--delay", Parameter::Delay, not_negative, self.delay),
            (
                "--delay-deviation",
                Parameter::DelayDeviation,
                not_negative,
                self.delay_deviation,
            ),
            (
                "--model-delay",
                Parameter::Delay,
                not_negative,
                self.model_delay,
            ),
            ("--lag", Parameter::Lag, not_negative, self.lag),
            ("--gain", Parameter::Gain, positive, self.gain),
            ("--model-lag", Parameter::Lag, not_negative, self.model_lag),
            ("--model-gain", Parameter::Gain, positive, self.model_gain),
            (
                "--lag-deviation",
                Parameter::LagDeviation,
                not_negative,
                self.lag_deviation,
            ),
            (
                "--gain-deviation",
                Parameter::GainDeviation,
                not_negative,
                self.gain_deviation,
            ),
        ] {
            if let Some(value) = value
                && !range.contains(value)
            {
                let allowed = Allowed::Range(range);
                return Err(not_allowed_by(
                    flag,
                    ParameterError {
                        parameter,
                        value,
                        allowed,
                    },
                ));
            }
        }
        self.check_transmission()
    }

    /// Rejects impossible values of a transmission.
    fn check_transmission(&self) -> Result<(), Failure> {
        type IsAllowed = fn(f64) -> bool;
        let of: [(Parameter, IsAllowed, Allowed, Option<f64>); 3] = [
            (
                Parameter::Resonance,
                |value| Range::Positive.contains(value),
                Allowed::Range(Range::Positive),
                self.resonance,
            ),
            (
                Parameter::ResonanceDampingRatio,
                |value| (0.0..=1.0).contains(&value),
                Allowed::Words("from 0 to 1"),
                self.resonance_damping_ratio,
            ),
            (
                Parameter::FlexibleMassFraction,
                |value| (0.0..1.0).contains(&value),
                Allowed::Words("from 0 to below 1"),
                self.flexible_mass_fraction,
            ),
        ];
        for (parameter, is_allowed, allowed, value) in of {
            if let Some(value) = value
                && !is_allowed(value)
            {
                return Err(not_allowed(parameter, value, allowed));
            }
        }
        Ok(())
    }

    /// Whether a flag sets a parameter of a flexible transmission.
    pub fn tell_a_transmission(&self) -> bool {
        self.resonance.is_some()
            || self.resonance_damping_ratio.is_some()
            || self.flexible_mass_fraction.is_some()
    }

    /// Returns the model of the flexible transmission: values of `file` override `before`, and flags override both. If
    /// a flag sets a part of it, the rest must be known.
    fn transmission(
        &self,
        file: Option<&DeviceFile>,
        before: Option<Transmission<f64>>,
    ) -> Result<Option<Transmission<f64>>, Failure> {
        if !self.tell_a_transmission() {
            return Ok(file
                .and_then(|file| file.model(self).transmission)
                .or(before));
        }
        let missing = |parameter: &str, quantity: Quantity| {
            Failure::Arguments(format!(
                "a flexible transmission needs --resonance, --resonance-damping-ratio and --flexible-mass-fraction: \
                 {parameter} is missing, and neither a scene nor a device file has {}",
                quantity.key()
            ))
        };
        let value = |given: Option<f64>,
                     flag: &str,
                     quantity: Quantity,
                     of: fn(Transmission<f64>) -> f64| {
            given
                .or_else(|| file.and_then(|file| file.value(quantity)))
                .or_else(|| before.map(of))
                .ok_or_else(|| missing(flag, quantity))
        };
        Ok(Some(Transmission {
            resonance: value(self.resonance, "--resonance", Quantity::Resonance, |it| {
                it.resonance
            })?,
            damping_ratio: value(
                self.resonance_damping_ratio,
                "--resonance-damping-ratio",
                Quantity::ResonanceDampingRatio,
                |it| it.damping_ratio,
            )?,
            flexible_mass_fraction: value(
                self.flexible_mass_fraction,
                "--flexible-mass-fraction",
                Quantity::FlexibleMassFraction,
                |it| it.flexible_mass_fraction,
            )?,
        }))
    }

    /// Rejects model values if no actuator is simulated that could differ from them.
    pub fn refuse_model(&self, command: &str) -> Result<(), Failure> {
        let given = [
            ("delay", self.model_delay),
            ("lag", self.model_lag),
            ("gain", self.model_gain),
        ]
        .into_iter()
        .find(|(_, value)| value.is_some());
        given.map_or(Ok(()), |(name, _)| {
            Err(Failure::Arguments(format!(
                "--model-{name} is for simulate and tune; the model value of {command} is --{name}"
            )))
        })
    }

    /// Returns the flag that gives the delay: `--delay-periods` if it was given.
    pub fn delay_flag(&self) -> &'static str {
        if self.delay_periods.is_some() {
            "--delay-periods"
        } else {
            "--delay"
        }
    }

    /// Rejects a delay of more than `most` periods of `period` `[s]`, given by these flags or known otherwise `[s]`.
    pub fn check_delay(&self, delay: f64, period: f64, most: usize) -> Result<(), Failure> {
        periods_of(self.delay_flag(), delay, period, most).map(drop)
    }

    /// Returns the given delay `[s]` in a loop of `period` `[s]`.
    fn given_delay(&self, period: f64) -> Result<Option<f64>, Failure> {
        if let Some(delay) = self.delay {
            periods_of("--delay", delay, period, DelayedHold::LONGEST_DELAY)?;
        }
        Ok(self
            .delay
            .or(self.delay_periods.map(|periods| periods * period)))
    }

    /// Whether any of these flags changes the simulation.
    pub fn change_a_scene(&self) -> bool {
        self.device_file.is_some()
            || self.tell_a_transmission()
            || [
                self.delay,
                self.delay_periods,
                self.delay_deviation,
                self.lag,
                self.lag_deviation,
                self.gain,
                self.gain_deviation,
                self.model_delay,
                self.model_lag,
                self.model_gain,
            ]
            .iter()
            .any(Option::is_some)
    }

    /// Replaces the scene's values by the flags and by the remaining values of `file`.
    pub fn change(&self, scene: &mut Scene, file: Option<&DeviceFile>) -> Result<(), Failure> {
        let period = scene.loop_params.period;
        let model = &mut scene.model;
        model.transmission = self.transmission(file, model.transmission)?;
        if let Some(file) = file {
            let known = file.model(self);
            model.delay = known.delay.or(model.delay);
            model.delay_deviation = known.delay_deviation.or(model.delay_deviation);
            model.lag = known.lag.or(model.lag);
            model.lag_deviation = known.lag_deviation.or(model.lag_deviation);
            model.gain = known.gain.or(model.gain);
            model.gain_deviation = known.gain_deviation.or(model.gain_deviation);
            model.sensor_noise = known.sensor_noise.or(model.sensor_noise);
        }
        // A flag sets the true value and the model value.
        if let Some(delay) = self.given_delay(period)? {
            model.delay = None;
            scene.delay = Delay::from_seconds(delay, period);
        }
        if let Some(lag) = self.lag {
            model.lag = None;
            scene.actuator.lag = lag;
        }
        if let Some(gain) = self.gain {
            model.gain = None;
            scene.actuator.gain = gain;
        }
        if let Some(delay) = self.model_delay {
            check_model_delay(delay, period)?;
            model.delay = Some(delay);
        }
        model.lag = self.model_lag.or(model.lag);
        model.gain = self.model_gain.or(model.gain);
        model.delay_deviation = self.delay_deviation.or(model.delay_deviation);
        model.lag_deviation = self.lag_deviation.or(model.lag_deviation);
        model.gain_deviation = self.gain_deviation.or(model.gain_deviation);
        let delay = scene.delay.whole_samples() as f64 + scene.delay.seconds() / period;
        let delay = Delay::of_periods(delay);
        let periods = delay.whole_samples() as f64 + delay.fraction();
        if model.delay.is_none() && periods > LARGEST_DELAY as f64 {
            tell_too_long(self.delay.map(|_| "--delay"), periods);
        }
        Ok(())
    }

    /// Returns the actuation from flags and `file`, without a scene's actuator, in a loop of `period` `[s]`.
    pub fn actuation(
        &self,
        period: f64,
        file: Option<&DeviceFile>,
    ) -> Result<Actuation<f64>, Failure> {
        let known = file.map(|file| file.model(self)).unwrap_or_default();
        let perfect = Actuation::default();
        let or_known =
            |flag: Option<f64>, known: Option<f64>, perfect: f64| flag.or(known).unwrap_or(perfect);
        Ok(Actuation {
            delay: or_known(self.given_delay(period)?, known.delay, perfect.delay),
            lag: or_known(self.lag, known.lag, perfect.lag),
            gain: or_known(self.gain, known.gain, perfect.gain),
            delay_deviation: or_known(self.delay_deviation, known.delay_deviation, 0.0),
            lag_deviation: or_known(self.lag_deviation, known.lag_deviation, 0.0),
            gain_deviation: or_known(self.gain_deviation, known.gain_deviation, 0.0),
            transmission: self.transmission(file, None)?,
            hold: Hold::Constant,
        })
    }

    /// Returns the flag that overrides a quantity of a device file, if it was given.
    pub fn beside(&self, quantity: Quantity) -> Option<&'static str> {
        let first = |flags: &[(&'static str, Option<f64>)]| {
            let given = flags.iter().find(|(_, value)| value.is_some());
            given.map(|(flag, _)| *flag)
        };
        match quantity {
            Quantity::Delay | Quantity::DelayPlusLag => first(&[
                ("--model-delay", self.model_delay),
                (self.delay_flag(), self.delay.or(self.delay_periods)),
            ]),
            Quantity::Lag => first(&[("--model-lag", self.model_lag), ("--lag", self.lag)]),
            Quantity::Gain => first(&[("--model-gain", self.model_gain), ("--gain", self.gain)]),
            Quantity::Resonance => first(&[("--resonance", self.resonance)]),
            Quantity::ResonanceDampingRatio => {
                first(&[("--resonance-damping-ratio", self.resonance_damping_ratio)])
            }
            Quantity::FlexibleMassFraction => {
                first(&[("--flexible-mass-fraction", self.flexible_mass_fraction)])
            }
            _ => None,
        }
    }
}

/// Rejects a delay `[s]` of more than `most` periods of `period` `[s]`, and returns its number of periods.
fn periods_of(flag: &str, delay: f64, period: f64, most: usize) -> Result<f64, Failure> {
    let periods = delay / period;
    // A quotient of decimal times is not exact. A period that is not finite and above 0 is refused by its own check.
    if !period.is_finite() || period <= 0.0 || periods <= most as f64 + 1e-5 {
        return Ok(periods);
    }
    Err(Failure::Arguments(format!(
        "{flag} is {} s, {} periods of {period} s, but must be at most {most} periods, {} s{}",
        rounded(delay),
        rounded(periods),
        rounded(most as f64 * period),
        in_periods(flag)
    )))
}

/// Returns a value without the last digits of a quotient or product of decimal times.
fn rounded(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

/// Returns how a delay is given in periods, for a message about a flag in seconds.
fn in_periods(flag: &str) -> &'static str {
    if flag == "--delay" {
        "; --delay is in seconds, --delay-periods in periods"
    } else {
        ""
    }
}

/// Rejects a model delay `[s]` that no renderer can have.
fn check_model_delay(delay: f64, period: f64) -> Result<(), Failure> {
    periods_of("--model-delay", delay, period, LARGEST_DELAY).map(drop)
}

/// Warns of a delay of `periods`, given by `flag`, of which the renderer models a part.
pub(crate) fn tell_too_long(flag: Option<&str>, periods: f64) {
    let unknown = rounded(periods - LARGEST_DELAY as f64);
    tell(format_args!(
        "warning: the renderer models at most {LARGEST_DELAY} periods of delay; the other {unknown} of these {} are \
         unmodelled{}",
        rounded(periods),
        flag.map_or("", in_periods)
    ));
}
