//! A calibrated device file: model values of a device.

use std::path::{Path, PathBuf};

use palpate_core::{Contact, LARGEST_DELAY, Mass};
use palpate_record::files::bounded::DEVICE;
use palpate_scene::{Model, quantum_of};
use palpate_study::calibrate::{Calibration, Quantity};
use palpate_study::calibrated;
use palpate_study::text::digits;

use crate::arguments::{ActuationFlags, Flags};
use crate::failure::{Failure, tell};

/// Reads a device file.
pub fn read_calibration(path: &Path) -> Result<Calibration, Failure> {
    let name = path.display().to_string();
    let text = DEVICE
        .text(path)
        .map_err(|error| Failure::System(format!("{name}: {error}")))?;
    Calibration::parse(&name, &text).map_err(|error| {
        Failure::input_at(&error, &error.file, &error.source_text, error.span.clone())
    })
}

/// Warns of a contact that is stiffer than the first resonance from `file` or `flags` allows, in a loop of `period`
/// `[s]`. `device_mass` is used if the file has none `[kg]`.
pub fn warn_of_resonance(
    file: Option<&DeviceFile>,
    flags: &ActuationFlags,
    device_mass: Option<f64>,
    contact: &Contact<f64>,
    period: f64,
) {
    let known = file.map_or_else(Calibration::default, |file| file.calibration.clone());
    let device_mass = known.value(Quantity::DeviceMass).or(device_mass);
    let known = known.stating([
        (Quantity::Resonance, flags.resonance),
        (Quantity::FlexibleMassFraction, flags.flexible_mass_fraction),
        (Quantity::DeviceMass, device_mass),
    ]);
    let object_mass = match contact.object_mass {
        Mass::Finite(mass) => mass,
        Mass::Infinite => f64::INFINITY,
    };
    let Some(stiffest) = known.stiffest_contact(object_mass, period) else {
        return;
    };
    if contact.stiffness <= stiffest {
        return;
    }
    let hertz = known.value(Quantity::Resonance).unwrap_or_default();
    let who = match (flags.resonance, file) {
        (None, Some(file)) => format!("{} has a resonance of {hertz} Hz", file.path.display()),
        _ => format!("--resonance is {hertz} Hz"),
    };
    tell(format_args!(
        "warning: {who}, which allows {} N/m with this object at a period of {period} s; at {} N/m the force can be \
         wrong, or the loop can gain energy",
        digits(stiffest),
        contact.stiffness
    ));
}

/// A parsed device file.
pub struct DeviceFile {
    path: PathBuf,
    calibration: Calibration,
}

impl DeviceFile {
    /// Reads the file at `path` for a loop of `period` `[s]`, and reports the values that `flags` do not override.
    pub fn read(path: &Path, flags: &Flags, period: f64) -> Result<Self, Failure> {
        let name = path.display().to_string();
        let file = Self {
            path: path.to_owned(),
            calibration: read_calibration(path)?,
        };
        if let Some(delay) = file.model(&flags.actuation).delay
            && delay > LARGEST_DELAY as f64 * period
        {
            return Err(Failure::input(format!(
                "{name}: the delay is {delay} s, {} periods of {period} s, but the renderer models at most \
                 {LARGEST_DELAY}",
                (delay / period * 1e6).round() / 1e6
            )));
        }
        file.tell(flags, period);
        Ok(file)
    }

    /// Returns the mass of the device `[kg]`.
    pub fn device_mass(&self) -> Option<f64> {
        self.calibration.value(Quantity::DeviceMass)
    }

    /// Returns the value of a `quantity`.
    pub fn value(&self, quantity: Quantity) -> Option<f64> {
        self.calibration.value(quantity)
    }

    /// Returns the quantum of the position sensor `[m]`.
    pub fn sensor_quantum(&self) -> Option<f64> {
        self.calibration.value(Quantity::SensorQuantum)
    }

    /// Returns the model value of the quantum `[m]`: the sensor's quantum, or the quantum with the same noise as the
    /// measured one, whichever is larger.
    pub fn model_quantum(&self) -> Option<f64> {
        let noise = self.calibration.value(Quantity::SensorNoise);
        let quantum = self.sensor_quantum();
        noise
            .map(quantum_of)
            .into_iter()
            .chain(quantum)
            .reduce(f64::max)
    }

    /// Returns delay, lag, gain, sensor and transmission, without quantities that `flags` override.
    pub fn model(&self, flags: &ActuationFlags) -> Model {
        calibrated::model(&self.calibration, |quantity| {
            flags.beside(quantity).is_none()
        })
    }

    /// Reports on standard error the values from the file and those replaced by flags.
    fn tell(&self, flags: &Flags, period: f64) {
        let name = self.path.display();
        let (mut taken, mut replaced) = (Vec::new(), Vec::new());
        let model = self.model(&flags.actuation);
        let has_delay = self.calibration.value(Quantity::Delay).is_some();
        for (quantity, known) in &self.calibration.known {
            let beside = match quantity {
                Quantity::DeviceMass if flags.model_device_mass.is_some() => {
                    Some("--model-device-mass")
                }
                Quantity::DeviceMass => flags.device_mass.map(|_| "--device-mass"),
                Quantity::SensorQuantum => flags.encoder_quantum.map(|_| "--encoder-quantum"),
                Quantity::SensorNoise => None,
                // Only its deviation is used.
                Quantity::DelayPlusLag if has_delay => continue,
                Quantity::Delay | Quantity::DelayPlusLag | Quantity::Lag | Quantity::Gain => {
                    flags.actuation.beside(*quantity)
                }
                Quantity::Resonance
                | Quantity::ResonanceDampingRatio
                | Quantity::FlexibleMassFraction
                    if model.transmission.is_some() || flags.actuation.tell_a_transmission() =>
                {
                    flags.actuation.beside(*quantity)
                }
                _ => continue,
            };
            if let Some(flag) = beside {
                replaced.push(format!("{flag} overrides {}", quantity.key()));
                continue;
            }
            let deviation = known.standard_deviation;
            let deviation = deviation.map_or_else(String::new, |sd| format!(" ± {sd}"));
            taken.push(format!("{} {}{deviation}", quantity.key(), known.value));
        }
        let taken = if taken.is_empty() {
            "no model values".to_owned()
        } else {
            taken.join(", ")
        };
        let replaced = replaced.iter().map(|text| format!("; {text}"));
        tell(format_args!(
            "taken from {name}: {taken}{}",
            replaced.collect::<String>()
        ));
        if let Some(found) = self.calibration.value(Quantity::Period)
            && (found / period - 1.0).abs() > 1e-6
        {
            tell(format_args!(
                "warning: {name} was measured at a period of {found} s, but this loop has {period} s; a delay can \
                 depend on the period"
            ));
        }
    }
}
