//! Model values of a renderer from a calibration, and simulated calibration of a scene's device.

use std::time::Duration;

use crate::calibrate::{
    Calibration, Declined, ExcitationError, ExcitationParams, Phase, Quantity, Stop, measure,
};
use crate::sim::device::SimulatedDevice;
use palpate_core::Transmission;
use palpate_device::clock::SteppedClock;
use palpate_device::{Device, DeviceError, Wrench};
use palpate_scene::{Model, Scene};
use palpate_testbed::InvalidParameter;

use crate::calibration::ExcitedMotion;

/// Reason why the device of a scene has no calibration.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NotCalibrated {
    /// A parameter of the excitation is out of its range.
    #[error(transparent)]
    Params(#[from] ExcitationError),
    /// A quantity of the device or the hand is out of its range.
    #[error(transparent)]
    Plant(#[from] InvalidParameter),
    /// The device does not answer.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The excitation stopped before its end.
    #[error("the excitation stopped: {0}")]
    Stopped(Stop),
    /// The fit cannot identify the motion.
    #[error(transparent)]
    Declined(#[from] Declined),
}

/// Calibrates the device of `scene` as `palpate calibrate` calibrates a real one, in simulated time, on the motion of
/// [`excite`].
///
/// # Errors
/// The device cannot be simulated, the excitation stops, or the fit declines the motion.
pub fn calibrate(scene: &Scene, params: &ExcitationParams) -> Result<Calibration, NotCalibrated> {
    let motion = excite(scene, params, || {})?;
    let measured = measure(params, motion.excited(), &motion.positions, &motion.forces)?;
    Ok(measured.fitted.calibration)
}

/// Excites the device of `scene` in simulated time. Its hand holds it without pushing and trembles as in the scene;
/// there is no object. The jitter of commands is not simulated. Calls `sampled` after each sample.
///
/// # Errors
/// The device cannot be simulated, or the excitation stops.
pub fn excite(
    scene: &Scene,
    params: &ExcitationParams,
    mut sampled: impl FnMut(),
) -> Result<ExcitedMotion, NotCalibrated> {
    let mut at_rest = scene.clone();
    match &mut at_rest.device {
        palpate_scene::SceneDevice::PointMass(device) => device.hand.force = 0.0,
        palpate_scene::SceneDevice::Pantograph(device) => device.force = 0.0,
        palpate_scene::SceneDevice::Recorded { .. } => {}
    }
    let clock = SteppedClock::new();
    let mut device = SimulatedDevice::new(&at_rest, clock.clone())?;
    let mut motion = ExcitedMotion::new(*params)?;
    let period = Duration::from_secs_f64(params.period);
    loop {
        match motion.phase() {
            Phase::Running => {}
            Phase::Done => return Ok(motion),
            Phase::Stopped(why) => return Err(NotCalibrated::Stopped(why)),
        }
        let [position, ..] = device.read()?.position;
        let force = motion.take(None, position);
        device.write(Wrench::of_force([force, 0.0, 0.0]))?;
        clock.advance(period);
        sampled();
    }
}

/// Returns the model values of delay, lag, gain, sensor and transmission from a calibration, for the quantities that
/// `taken` selects.
#[must_use]
pub fn model(calibration: &Calibration, taken: impl Fn(Quantity) -> bool) -> Model {
    let known = |quantity: Quantity| {
        let known = calibration.known.get(&quantity);
        known.filter(|_| taken(quantity))
    };
    // If only the sum of delay and lag is known, the sum is the better delay.
    let delay = known(Quantity::Delay).or_else(|| known(Quantity::DelayPlusLag));
    let [lag, gain] = [Quantity::Lag, Quantity::Gain].map(known);
    // The errors of delay and lag from one fit compensate each other. Their sum determines the arrival of the
    // impulse, so only its deviation counts.
    let of_sum = calibration
        .standard_deviation(Quantity::DelayPlusLag)
        .filter(|_| delay.is_some() && lag.is_some());
    let of_delay = of_sum.or_else(|| delay?.standard_deviation);
    let of_lag = match of_sum {
        Some(_) => Some(0.0),
        None => lag.and_then(|lag| lag.standard_deviation),
    };
    let jitter = calibration.value(Quantity::CommandJitter);
    let of_delay = match (of_delay, jitter.filter(|_| delay.is_some())) {
        (Some(deviation), Some(jitter)) => Some(deviation.hypot(jitter)),
        (deviation, jitter) => deviation.or(jitter),
    };
    Model {
        delay: delay.map(|delay| delay.value),
        delay_deviation: of_delay,
        lag: lag.map(|lag| lag.value),
        lag_deviation: of_lag,
        gain: gain.map(|gain| gain.value),
        gain_deviation: gain.and_then(|gain| gain.standard_deviation),
        sensor_quantum: None,
        sensor_noise: known(Quantity::SensorNoise).map(|noise| noise.value),
        transmission: transmission(calibration, &taken),
    }
}

/// Returns the model values for a simulated loop with the calibrated delay, lag and sensor quantum: the deviations
/// and the sensor noise. The simulated device is rigid and its gain is 1, so the deviation of the gain is relative.
#[must_use]
pub fn deviations(calibration: &Calibration, taken: impl Fn(Quantity) -> bool) -> Model {
    let model = model(calibration, taken);
    Model {
        delay_deviation: model.delay_deviation,
        lag_deviation: model.lag_deviation,
        gain_deviation: model
            .gain_deviation
            .map(|deviation| deviation / model.gain.unwrap_or(1.0)),
        sensor_noise: model.sensor_noise,
        ..Model::default()
    }
}

/// Returns the flexible transmission of a calibration, if all its values are known and `taken`.
fn transmission(
    calibration: &Calibration,
    taken: impl Fn(Quantity) -> bool,
) -> Option<Transmission<f64>> {
    let value = |quantity| calibration.value(quantity).filter(|_| taken(quantity));
    Some(Transmission {
        resonance: value(Quantity::Resonance)?,
        damping_ratio: value(Quantity::ResonanceDampingRatio)?,
        flexible_mass_fraction: value(Quantity::FlexibleMassFraction)?,
    })
}
