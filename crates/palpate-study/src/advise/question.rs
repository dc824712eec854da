//! Input of an advice.

use crate::calibrate::{Calibration, Quantity};
use palpate_scene::Model;

use crate::calibrated;
use crate::map::{Bounce, BounceDevice, MapParams, SEARCHED};

/// A device and a contact on it. Unstated values come from the device file.
#[derive(Clone, Copy, Debug)]
pub struct Question<'a> {
    /// The device file.
    pub file: Option<&'a Calibration>,
    /// Effective mass of the device `[kg]`.
    pub device_mass: Option<f64>,
    /// Viscous friction of the device `[N s/m]`.
    pub viscous_friction: f64,
    /// Coulomb friction of the device `[N]`.
    pub coulomb_friction: f64,
    /// Quantum of its position sensor `[m]`; 0 if neither source states it.
    pub encoder_quantum: Option<f64>,
    /// Period of the loop `[s]`.
    pub period: f64,
    /// Time from a sample to the start of its force `[s]`; 0 if neither source states it.
    pub delay: Option<f64>,
    /// Time constant of the following first-order lag `[s]`; 0 if neither source states it.
    pub lag: Option<f64>,
    /// Standard deviation of the delay `[s]`; 0 if neither source states it.
    pub delay_deviation: Option<f64>,
    /// Standard deviation of the lag `[s]`; 0 if neither source states it.
    pub lag_deviation: Option<f64>,
    /// Contact stiffness `[N/m]`; `None` requests only limits.
    pub stiffness: Option<f64>,
    /// Object mass `[kg]`; infinite for a wall.
    pub object_mass: f64,
}

impl Question<'_> {
    /// Returns the scene, with unchecked values; `None` if the device mass is unknown. Without a requested stiffness
    /// the scene gets the softest one of the search.
    #[must_use]
    pub fn bounce(&self) -> Option<Bounce> {
        let known = |quantity| self.file.and_then(|file| file.value(quantity));
        let mass = self.device_mass.or(known(Quantity::DeviceMass))?;
        let quantum = known(Quantity::SensorQuantum);
        // If only the sum of delay and lag is known, the sum is the better delay.
        let delay = known(Quantity::Delay).or(known(Quantity::DelayPlusLag));
        let defaults = MapParams::default();
        Some(Bounce {
            device: BounceDevice {
                mass,
                viscous_friction: self.viscous_friction,
                coulomb_friction: self.coulomb_friction,
                encoder_quantum: self.encoder_quantum.or(quantum).unwrap_or(0.0),
                model_mass: 1.0,
            },
            stiffness: self
                .stiffness
                .unwrap_or(SEARCHED.0 * mass / (self.period * self.period)),
            object_mass: self.object_mass,
            forces: defaults.forces,
            gap: defaults.gap,
            period: self.period,
            model_period: 1.0,
            delay: self.delay.or(delay).unwrap_or(0.0) / self.period,
            lag: self.lag.or(known(Quantity::Lag)).unwrap_or(0.0),
            model: self.deviations(),
        })
    }

    /// Returns the deviations of the renderer's model: a stated value uses only a stated deviation.
    fn deviations(&self) -> Model {
        let taken = |quantity: Quantity| match quantity {
            Quantity::Delay | Quantity::DelayPlusLag => self.delay.is_none(),
            Quantity::Lag => self.lag.is_none(),
            Quantity::SensorNoise => self.encoder_quantum.is_none(),
            _ => true,
        };
        let of_file = self.file.map(|file| calibrated::deviations(file, taken));
        let of_file = of_file.unwrap_or_default();
        Model {
            delay_deviation: self.delay_deviation.or(of_file.delay_deviation),
            lag_deviation: self.lag_deviation.or(of_file.lag_deviation),
            ..of_file
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::calibrate::Known;

    use super::*;

    /// Creates the input for a device without stated values.
    fn asked(file: &Calibration) -> Question<'_> {
        Question {
            file: Some(file),
            device_mass: None,
            viscous_friction: 0.0,
            coulomb_friction: 0.0,
            encoder_quantum: None,
            period: 1e-3,
            delay: None,
            lag: None,
            delay_deviation: None,
            lag_deviation: None,
            stiffness: None,
            object_mass: 0.1,
        }
    }

    #[test]
    fn what_is_stated_counts_before_what_the_file_says() {
        let mut file = Calibration::default();
        assert_eq!(asked(&file).bounce(), None);
        for (quantity, value) in [
            (Quantity::DeviceMass, 0.2),
            (Quantity::SensorQuantum, 1e-5),
            (Quantity::DelayPlusLag, 2e-3),
        ] {
            file.set(quantity, Known::given(value, "given"));
        }
        let found = asked(&file).bounce().unwrap();
        assert_eq!(found.device.mass, 0.2);
        assert_eq!(found.device.encoder_quantum, 1e-5);
        assert_eq!((found.delay, found.lag), (2.0, 0.0));
        // A deviation in the file applies to the renderer's model; a stated deviation replaces it.
        file.set(
            Quantity::DelayPlusLag,
            Known::found(2e-3, 2e-5, "least squares"),
        );
        file.set(Quantity::CommandJitter, Known::given(1.5e-5, "given"));
        file.set(Quantity::Gain, Known::found(2.0, 0.1, "a spring"));
        file.set(Quantity::SensorNoise, Known::given(4e-6, "given"));
        let model = asked(&file).bounce().unwrap().model;
        assert_eq!(model.delay_deviation, Some(2.5e-5));
        assert_eq!(
            (model.lag_deviation, model.gain_deviation),
            (None, Some(0.05))
        );
        assert_eq!((model.delay, model.gain), (None, None));
        assert_eq!(model.sensor_noise, Some(4e-6));
        let other = Question {
            delay: Some(2e-3),
            lag_deviation: Some(1e-5),
            ..asked(&file)
        };
        let model = other.bounce().unwrap().model;
        assert_eq!(model.delay_deviation, None);
        assert_eq!(model.lag_deviation, Some(1e-5));
        // The sum is ignored once the delay itself is known.
        file.set(Quantity::Delay, Known::given(1e-3, "given"));
        assert_eq!(asked(&file).bounce().unwrap().delay, 1.0);
        let stated = Question {
            device_mass: Some(0.3),
            delay: Some(0.5e-3),
            lag: Some(1e-4),
            stiffness: Some(100.0),
            ..asked(&file)
        };
        let bounce = stated.bounce().unwrap();
        assert_eq!((bounce.device.mass, bounce.delay), (0.3, 0.5));
        assert_eq!((bounce.lag, bounce.stiffness), (1e-4, 100.0));
    }
}
