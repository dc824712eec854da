//! Converts flags and a device file to the actuation of a scene and the model values of its renderer.

use palpate::{Actuation, Allowed, LARGEST_DELAY, Parameter, ParameterError, Range, Transmission};
use palpate_calibrate::Quantity;
use palpate_scene::{Delay, Scene};

use super::device_file::DeviceFile;
use super::wrong::{not_allowed, not_allowed_by};
use crate::arguments::ActuationFlags;
use crate::failure::{Failure, tell};

impl ActuationFlags {
    /// Rejects impossible values of an actuator.
    pub fn check(&self) -> Result<(), Failure> {
        let (positive, not_negative) = (Range::Positive, Range::NotNegative);
        for (flag, parameter, range, value) in [
            ("--lag", Parameter::Lag, not_negative, self.lag),
            ("--gain", Parameter::Gain, positive, self.gain),
            ("--told-lag", Parameter::Lag, not_negative, self.told_lag),
            ("--told-gain", Parameter::Gain, positive, self.told_gain),
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
        let most = LARGEST_DELAY as f64;
        if let Some(told) = self.told_delay
            && !(0.0..=most).contains(&told)
        {
            return Err(Failure::Arguments(format!(
                "--told-delay is {told} periods, but must be from 0 to {LARGEST_DELAY}"
            )));
        }
        if let Some(deviation) = self.delay_deviation
            && !not_negative.contains(deviation)
        {
            return Err(Failure::Arguments(format!(
                "--delay-deviation is {deviation} periods, but must be finite and not below 0"
            )));
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
                .and_then(|file| file.told(self).transmission)
                .or(before));
        }
        let missing = |parameter: &str, quantity: Quantity| {
            Failure::Arguments(format!(
                "a flexible transmission is told by --resonance, --resonance-damping-ratio and \
                 --flexible-mass-fraction, all three: {parameter} is missing, and neither a scene nor a device file \
                 says {}",
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
    pub fn refuse_told(&self, command: &str) -> Result<(), Failure> {
        let given = [
            ("delay", self.told_delay),
            ("lag", self.told_lag),
            ("gain", self.told_gain),
        ]
        .into_iter()
        .find(|(_, value)| value.is_some());
        given.map_or(Ok(()), |(name, _)| {
            Err(Failure::Arguments(format!(
                "--told-{name} is for simulate and tune; what {command} tells the renderer is --{name}"
            )))
        })
    }

    /// Whether any of these flags changes the simulation.
    pub fn change_a_scene(&self) -> bool {
        self.device_file.is_some()
            || self.tell_a_transmission()
            || [
                self.delay,
                self.delay_deviation,
                self.lag,
                self.lag_deviation,
                self.gain,
                self.gain_deviation,
                self.told_delay,
                self.told_lag,
                self.told_gain,
            ]
            .iter()
            .any(Option::is_some)
    }

    /// Replaces the scene's values by the flags and by the remaining values of `file`.
    pub fn change(&self, scene: &mut Scene, file: Option<&DeviceFile>) -> Result<(), Failure> {
        let period = scene.loop_params.period;
        let told = &mut scene.told;
        told.transmission = self.transmission(file, told.transmission)?;
        if let Some(file) = file {
            let known = file.told(self);
            told.delay = known.delay.or(told.delay);
            told.delay_deviation = known.delay_deviation.or(told.delay_deviation);
            told.lag = known.lag.or(told.lag);
            told.lag_deviation = known.lag_deviation.or(told.lag_deviation);
            told.gain = known.gain.or(told.gain);
            told.gain_deviation = known.gain_deviation.or(told.gain_deviation);
            told.sensor_noise = known.sensor_noise.or(told.sensor_noise);
        }
        // A flag sets the true value and the model value.
        if let Some(periods) = self.delay {
            told.delay = None;
            scene.delay = Delay::told_whole(periods, period);
        }
        if let Some(lag) = self.lag {
            told.lag = None;
            scene.actuator.lag = lag;
        }
        if let Some(gain) = self.gain {
            told.gain = None;
            scene.actuator.gain = gain;
        }
        let in_seconds = |periods: f64| periods * period;
        told.delay = self.told_delay.map(in_seconds).or(told.delay);
        told.lag = self.told_lag.or(told.lag);
        told.gain = self.told_gain.or(told.gain);
        let deviation = self.delay_deviation.map(in_seconds);
        told.delay_deviation = deviation.or(told.delay_deviation);
        told.lag_deviation = self.lag_deviation.or(told.lag_deviation);
        told.gain_deviation = self.gain_deviation.or(told.gain_deviation);
        let delay = scene.delay.whole_samples() as f64 + scene.delay.seconds() / period;
        let delay = Delay::of_periods(delay);
        let periods = delay.whole_samples() as f64 + delay.fraction();
        if told.delay.is_none() && periods > LARGEST_DELAY as f64 {
            tell_too_long(periods);
        }
        Ok(())
    }

    /// Returns the actuation from flags and `file`, without a scene's actuator, in a loop of `period` `[s]`.
    pub fn actuation(
        &self,
        period: f64,
        file: Option<&DeviceFile>,
    ) -> Result<Actuation<f64>, Failure> {
        let known = file.map(|file| file.told(self)).unwrap_or_default();
        let in_seconds = |periods: f64| periods * period;
        let perfect = Actuation::default();
        let or_known =
            |flag: Option<f64>, known: Option<f64>, perfect: f64| flag.or(known).unwrap_or(perfect);
        let delay_deviation = self.delay_deviation.map(in_seconds);
        Ok(Actuation {
            delay: or_known(self.delay.map(in_seconds), known.delay, perfect.delay),
            lag: or_known(self.lag, known.lag, perfect.lag),
            gain: or_known(self.gain, known.gain, perfect.gain),
            delay_deviation: or_known(delay_deviation, known.delay_deviation, 0.0),
            lag_deviation: or_known(self.lag_deviation, known.lag_deviation, 0.0),
            gain_deviation: or_known(self.gain_deviation, known.gain_deviation, 0.0),
            transmission: self.transmission(file, None)?,
        })
    }

    /// Returns the flag that overrides a quantity of a device file, if it was given.
    pub fn beside(&self, quantity: Quantity) -> Option<&'static str> {
        let first = |flags: &[(&'static str, Option<f64>)]| {
            let given = flags.iter().find(|(_, value)| value.is_some());
            given.map(|(flag, _)| *flag)
        };
        match quantity {
            Quantity::Delay | Quantity::DelayPlusLag => {
                first(&[("--told-delay", self.told_delay), ("--delay", self.delay)])
            }
            Quantity::Lag => first(&[("--told-lag", self.told_lag), ("--lag", self.lag)]),
            Quantity::Gain => first(&[("--told-gain", self.told_gain), ("--gain", self.gain)]),
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

fn tell_too_long(periods: f64) {
    let unknown = periods - LARGEST_DELAY as f64;
    let unit = if periods.fract() == 0.0 {
        "samples"
    } else {
        "periods"
    };
    tell(format_args!(
        "warning: a renderer can be told of {LARGEST_DELAY} {unit} of delay at most; it does not know the \
         other {unknown} of these {periods}"
    ));
}
