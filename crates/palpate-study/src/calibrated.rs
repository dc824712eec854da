//! What a calibration tells a renderer, and calibrating the device of a scene in simulated time.

use std::time::Duration;

use palpate::Transmission;
use palpate_calibrate::{
    Calibration, Declined, ExcitationError, ExcitationParams, Phase, Quantity, Stop, measure,
};
use palpate_device::clock::SteppedClock;
use palpate_device::{Device, DeviceError, Wrench};
use palpate_scene::{Scene, Told};
use palpate_sim::device::SimulatedDevice;
use palpate_testbed::InvalidParameter;

use crate::calibration::ExcitedMotion;

/// Why the device of a scene has no calibration.
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
    /// The fit says nothing of the motion.
    #[error(transparent)]
    Declined(#[from] Declined),
}

/// Calibrates the device of `scene` as `palpate calibrate` does a real one, in simulated time, on the motion
/// of [`excite`].
///
/// # Errors
/// A device that cannot be simulated, an excitation that stops, a motion that says nothing.
pub fn calibrate(scene: &Scene, params: &ExcitationParams) -> Result<Calibration, NotCalibrated> {
    let motion = excite(scene, params, || {})?;
    let measured = measure(params, motion.excited(), &motion.positions, &motion.forces)?;
    Ok(measured.fitted.calibration)
}

/// Excites the device of `scene` in simulated time: its hand holds it, does not push, and trembles as it
/// does in the scene; there is no object. The jitter of commands is left out. `sampled` hears of each
/// sample.
///
/// # Errors
/// A device that cannot be simulated, an excitation that stops.
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
    let mut device = SimulatedDevice::of(&at_rest, clock.clone())?;
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

/// What a calibration says of delay, lag, gain, sensor and transmission, of the quantities that are `taken` from it.
#[must_use]
pub fn told(calibration: &Calibration, taken: impl Fn(Quantity) -> bool) -> Told {
    let known = |quantity: Quantity| {
        let known = calibration.known.get(&quantity);
        known.filter(|_| taken(quantity))
    };
    // Where the two are known only together, the sum is the better delay.
    let delay = known(Quantity::Delay).or_else(|| known(Quantity::DelayPlusLag));
    let [lag, gain] = [Quantity::Lag, Quantity::Gain].map(known);
    // Delay and lag of one fit err against each other. What counts is when the impulse arrives, which
    // their sum says.
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
    Told {
        delay: delay.map(|delay| delay.value),
        delay_deviation: of_delay,
        lag: lag.map(|lag| lag.value),
        lag_deviation: of_lag,
        gain: gain.map(|gain| gain.value),
        gain_deviation: gain.and_then(|gain| gain.standard_deviation),
        sensor_noise: known(Quantity::SensorNoise).map(|noise| noise.value),
        transmission: transmission(calibration, &taken),
    }
}

/// Model values for a simulated loop whose delay, lag and sensor quantum are the calibrated ones: the deviations, and the noise of
/// the sensor. The simulated device is rigid and its gain is 1, so the gain's deviation is relative.
#[must_use]
pub fn deviations(calibration: &Calibration, taken: impl Fn(Quantity) -> bool) -> Told {
    let told = told(calibration, taken);
    Told {
        delay_deviation: told.delay_deviation,
        lag_deviation: told.lag_deviation,
        gain_deviation: told
            .gain_deviation
            .map(|deviation| deviation / told.gain.unwrap_or(1.0)),
        sensor_noise: told.sensor_noise,
        ..Told::default()
    }
}

/// What a calibration says of a flexible transmission, where it has found all of it and all of it is taken.
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
