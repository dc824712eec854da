//! Coupled rendering: predicts device and object together, and holds the mean of the contact force between them.

mod interval;
mod line;
mod saturation;

use interval::{Interval, Moved, ProxyState, repaid, rule};
use saturation::Saturation;

use super::method::{Ended, Method, MethodParams, Plan, Situation};
use super::named::{FromSettings, MethodInfo, MethodName};
use super::setting::{Basis, Setting, SettingKey, SettingValues, Settings, SettingsError};
use crate::Scalar;
use crate::actuation::Hold;
use crate::actuator::Held;
use crate::contact::{Contact, LoopParams, Mass};
use crate::motion::{Displacement, ObjectMotion};
use crate::parameter::{ParameterError, ParameterValue};
use crate::relative_motion::Relative;
use crate::render::predict::{
    EstimatedMotion, Flexure, Lateness, Measurement, Observer, ObserverParams, Placed,
    SensorInterval, SensorNoise, Sway, Update,
};
use crate::response::Response;

/// Coupled rendering by name.
pub(super) const COUPLED: MethodInfo = MethodInfo {
    name: "coupled",
    summary: "device and object predicted together, mean force held",
    colour: 4,
    settings: &[PLACEMENT, CORRECTION],
};

const PLACEMENT: Setting = Setting {
    key: SettingKey::PLACEMENT,
    values: SettingValues::Switch,
    help: "shift of the object to its predicted position; without it, the object keeps its own momentum (for \
           comparison)",
    default: "true",
};

const CORRECTION: Setting = Setting {
    key: SettingKey::CORRECTION,
    values: SettingValues::Switch,
    help: "repeated prediction of an ended interval; without it, coupled keeps its first prediction (for comparison)",
    default: "true",
};

impl SettingKey {
    /// Whether coupled rendering shifts the object.
    pub const PLACEMENT: Self = Self::new("placement");
    /// Whether coupled rendering repeats the prediction of an interval when the interval has ended.
    pub const CORRECTION: Self = Self::new("correction");
}

impl<S: Scalar> FromSettings<S> for CoupledParams<S> {
    fn from_settings(
        method: MethodName,
        given: &Settings,
        basis: &Basis,
    ) -> Result<Self, SettingsError> {
        Ok(Self {
            device_mass: basis.pushed_mass(method)?,
            encoder_quantum: S::from_f64(basis.encoder_quantum),
            placement: given.switch(SettingKey::PLACEMENT).unwrap_or(true),
            correction: given.switch(SettingKey::CORRECTION).unwrap_or(true),
        })
    }
}

/// Parameters of coupled rendering.
///
/// The two steps can be switched off for comparison; both are on by default.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: Scalar + serde::Serialize",
        deserialize = "S: Scalar + serde::Deserialize<'de>"
    ))
)]
pub struct CoupledParams<S> {
    /// Effective mass of the device at its end-point, within a factor of 2 `[kg]`. The hand's share is estimated.
    /// [`Mass::Infinite`] is a device that no force moves: a recorded motion.
    pub device_mass: Mass<S>,
    /// Quantum of the position sensor `[m]`, 0 if it has no known quantum.
    #[cfg_attr(feature = "serde", serde(default))]
    pub encoder_quantum: S,
    /// Whether the object is shifted so that the relative motion of device and object is the predicted one. Without the
    /// shift the object follows its own momentum.
    #[cfg_attr(feature = "serde", serde(default = "on"))]
    pub placement: bool,
    /// Whether the prediction of an interval is repeated with the sample that ends it.
    #[cfg_attr(feature = "serde", serde(default = "on"))]
    pub correction: bool,
}

#[cfg(feature = "serde")]
fn on() -> bool {
    true
}

impl<S: Scalar> CoupledParams<S> {
    /// Creates parameters for a device of about `device_mass` `[kg]` (infinite: no force moves it) with a position
    /// sensor of unknown quantum.
    pub fn new(device_mass: S) -> Self {
        Self {
            device_mass: if device_mass == S::INFINITY {
                Mass::Infinite
            } else {
                Mass::Finite(device_mass)
            },
            encoder_quantum: S::ZERO,
            placement: true,
            correction: true,
        }
    }

    /// Returns the parameters with a position sensor of `encoder_quantum` `[m]`.
    #[must_use]
    pub fn with_encoder_quantum(self, encoder_quantum: S) -> Self {
        Self {
            encoder_quantum,
            ..self
        }
    }
}

/// Coupled rendering.
///
/// A held force moves the device to another position than the continuous contact force, and the prediction of the
/// device must include that force. An observer therefore estimates the other forces on the device, and its mass. The
/// relative motion of device and object over the coming interval follows in closed form, with any number of
/// transitions. Its mean contact force is held, and the object is shifted so that the *relative* motion is the
/// predicted one although the force is held. If the device's mass and external acceleration are known exactly, the
/// rendered force is the interval mean of the ideal one, the best possible held force.
#[derive(Clone, Copy, Debug)]
pub struct Coupled<S> {
    observer: ObserverParams<S>,
    object_mobility: S,
    placement: bool,
    correction: bool,
    timing_deviation: S,
    flexure: Option<Flexure<S>>,
    saturation: Saturation<S>,
    hold: Hold,
}

/// Memory of coupled rendering.
#[derive(Clone, Copy, Debug, Default)]
pub struct CoupledMemory<S> {
    observer: Option<Observer<S>>,
    /// Impulse error: contact impulse by the current estimate minus the impulse of the corresponding held forces `[N
    /// s]`. Zero for a wall, which absorbs any momentum.
    impulse_error: S,
    /// Durations of the last intervals, the newest last `[s]`.
    periods: [Option<S>; 3],
    /// Uncertainty of the object's position.
    placed: Placed<S>,
    proxy: ProxyState<S>,
    /// Stretch of the device's transmission at the last sample.
    sway: Sway<S>,
    lateness: Lateness<S>,
    sensor_noise: SensorNoise<S>,
    /// Part of the proxy's relative speed that no force will correct `[m/s]`.
    given_up: S,
    /// Whether the force limit acts in the interval of the last force.
    is_limited: bool,
    /// Shift of the object over the last interval `[m]`.
    shift: S,
    /// Slope of the last planned force `[N/s]`; 0 with a constant hold.
    slope: S,
    /// Mean acceleration of the device over the last interval `[m/s^2]`; 0 with a constant hold.
    acceleration: S,
}

impl<S: Scalar> CoupledMemory<S> {
    /// Returns the expected duration of the next interval `[s]`: the median of the last three. A slower loop takes
    /// effect after two samples, and a single late sample has no effect.
    fn likely_period(&self, nominal: S) -> S {
        let [a, b, c] = self.periods.map(|period| period.unwrap_or(nominal));
        a.min(b).max(a.max(b).min(c))
    }

    /// Returns the estimated actuation delay minus its model value `[s]`.
    pub fn lateness(&self) -> S {
        self.lateness.mean
    }

    /// Returns the standard deviation of the position sensor's noise shown by free motion, including its rounding
    /// `[m]`: the estimate minus its standard deviation. 0 without a significant estimate.
    pub fn sensor_noise(&self) -> S {
        self.sensor_noise.deviation()
    }

    /// Returns the estimated effective mass of the device with the hand that holds it `[kg]`: infinite if no force
    /// moves it, `None` before the first sample.
    pub fn device_mass(&self) -> Option<S> {
        let observer = self.observer.as_ref()?;
        Some(S::ONE / observer.motion.mobility)
    }
}

/// The residual impulse of a free object is discarded if it would change the object's velocity by less than this
/// fraction.
const NEGLIGIBLE: f64 = 1e-7;

/// Threshold of resonance times period above which a modelled transmission is predicted. With twenty or more samples in
/// a resonance period, an observer that models the device as one mass follows the transmission's force, and performs
/// better.
const FAST_RESONANCE: f64 = 0.05;

impl<S: Scalar> MethodParams<S> for CoupledParams<S> {
    type Method = Coupled<S>;

    fn check(
        self,
        contact: &Contact<S>,
        loop_params: &LoopParams<S>,
    ) -> Result<Self::Method, ParameterError> {
        let observer = ObserverParams::new(self.device_mass, self.encoder_quantum)?;
        let transmission = loop_params.actuation.transmission;
        let is_fast = |resonance: S| resonance * loop_params.period > S::from_f64(FAST_RESONANCE);
        let transmission = transmission.filter(|model| is_fast(model.resonance));
        let flexure = transmission.as_ref().map(Flexure::new);
        let largest = match loop_params.force_limit {
            // Both the command and the delivered force are limited.
            Some(limit) => {
                let actuation = &loop_params.actuation;
                actuation.gain * limit / actuation.limit_gain()
            }
            None => S::INFINITY,
        };
        Ok(Coupled {
            observer: if flexure.is_some() {
                observer.with_flexure()
            } else {
                observer
            },
            object_mobility: match contact.object_mass {
                Mass::Finite(mass) => S::ONE / mass,
                Mass::Infinite => S::ZERO,
            },
            placement: self.placement,
            correction: self.correction,
            timing_deviation: loop_params.actuation.timing_deviation(),
            flexure,
            saturation: Saturation {
                force: largest,
                penetration: largest / contact.stiffness,
            },
            hold: loop_params.actuation.hold,
        })
    }

    fn name(&self) -> &'static str {
        COUPLED.name
    }

    fn describe(&self, take: &mut dyn FnMut(&'static str, ParameterValue<S>)) {
        let device_mass = match self.device_mass {
            Mass::Finite(mass) => ParameterValue::Number(mass),
            Mass::Infinite => ParameterValue::Word("inf"),
        };
        take("device_mass_kg", device_mass);
        let quantum = ParameterValue::Number(self.encoder_quantum);
        take("encoder_quantum_m", quantum);
        let (placement, correction) = (self.placement, self.correction);
        take(PLACEMENT.key.as_str(), ParameterValue::Switch(placement));
        take(CORRECTION.key.as_str(), ParameterValue::Switch(correction));
    }
}

impl<S: Scalar> Method<S> for Coupled<S> {
    type Memory = CoupledMemory<S>;

    fn conclude(
        &self,
        motion: &ObjectMotion<S>,
        ended: &Ended<S>,
        memory: &mut CoupledMemory<S>,
    ) -> Displacement<S> {
        let Some(observer) = &mut memory.observer else {
            return ended.as_planned(motion);
        };
        let before = observer.motion;
        let (measurement, behind) =
            self.measured(ended, before.mobility, &memory.lateness, &mut memory.sway);
        let variance = self.sensor_variance(ended, &before, &mut memory.sensor_noise);
        let (smoothed, lesson) = observer.update(&self.observer, &measurement, variance);
        if let Some(lesson) = lesson.as_ref().filter(|_| self.timing_deviation > S::ZERO) {
            let (held, elapsed, model) = (&ended.held, ended.elapsed, self.timing_deviation);
            let learned = memory
                .lateness
                .learn(lesson, &smoothed, held, elapsed, model);
            observer.shift(learned);
        }
        let certainty = observer.damping_certainty();
        let device = if self.correction { smoothed } else { before };
        if self.hold == Hold::Line {
            memory.acceleration = smoothed.under(&ended.held, ended.elapsed).1 / ended.elapsed;
        }
        // The position of a wall is exact.
        let lesson = lesson
            .as_ref()
            .filter(|_| self.correction && self.placement && !motion.is_wall());
        let [object_off, object_slow] =
            lesson.map_or([S::ZERO; 2], |lesson| memory.placed.correction(lesson));
        // No force corrects this part of the speed: the object takes it over, and a wall and its proxy converge.
        let given_up = core::mem::take(&mut memory.given_up);
        memory.proxy.speed -= given_up;
        let mut object_velocity = ended.start.object_velocity + object_slow;
        if !motion.is_wall() {
            object_velocity -= given_up;
        }
        let start = Relative {
            penetration: ended.start.penetration + behind + device.offset - object_off,
            speed: device.velocity + memory.proxy.speed - object_velocity,
        };
        let (interval, response) =
            self.interval_past(motion, &device, start, memory.proxy.sway, ended, certainty);
        // A limited force gives no information on the object's position.
        let response = response.as_ref().filter(|_| !interval.is_saturated);
        memory.placed = placed_after(
            &memory.placed,
            lesson.zip(response),
            &device,
            &interval,
            ended.held.mean,
        );
        memory.proxy.learn_whether_whole(ended, &interval);
        let Moved {
            object: mut moved,
            shift,
            proxy,
        } = self.object_moved(
            &interval,
            &device,
            object_velocity,
            ended.start.virtual_force,
            &ended.held,
            &memory.proxy,
        );
        moved.by += object_off;
        if !motion.is_wall() {
            memory.impulse_error += interval.course.impulse - ended.intended_force * ended.elapsed;
        }
        memory.periods = [memory.periods[1], memory.periods[2], Some(ended.elapsed)];
        memory.shift = shift;
        memory.proxy = proxy;
        moved
    }

    fn plan(
        &self,
        motion: &ObjectMotion<S>,
        now: &Situation<'_, S>,
        memory: &mut CoupledMemory<S>,
    ) -> Plan<S> {
        let period = memory.likely_period(motion.period());
        let observer = memory
            .observer
            .get_or_insert_with(|| Observer::new(&self.observer));
        let mut device = observer.motion;
        let virtual_force = now.start.virtual_force;
        let mut object_velocity = now.start.object_velocity;
        if memory.periods[2].is_none() {
            memory.proxy.comes_in &= motion.is_wall() && now.start.penetration > S::ZERO;
        }
        let mut proxy = memory.proxy;
        let behind = self.flexure.map_or(S::ZERO, |it| it.behind(&memory.sway));
        let mut relative = Relative {
            penetration: now.start.penetration + behind + device.offset,
            speed: device.velocity + proxy.speed - object_velocity,
        };
        let at_sample = (device, relative, object_velocity, proxy);
        let mut first = None;
        let mut residual = memory.impulse_error;
        let governed = now.ahead.until_own(period, |piece| {
            let h = piece.duration;
            let interval = self.interval(motion, &device, relative, proxy.sway, virtual_force, h);
            let moved = self.object_moved(
                &interval,
                &device,
                object_velocity,
                virtual_force,
                &piece.held,
                &proxy,
            );
            if !motion.is_wall() {
                residual += interval.course.impulse - piece.intended * h;
            }
            let (travel, gained) = device.under(&piece.held, h);
            first = first.or(Some((
                moved.object,
                rule(&interval, now.start.device_velocity),
            )));
            relative.penetration += travel - moved.object.by;
            device.velocity += gained;
            object_velocity = moved.object.velocity;
            proxy = moved.proxy;
            relative.speed = device.velocity + proxy.speed - object_velocity;
        });
        let interval = self.interval(motion, &device, relative, proxy.sway, virtual_force, period);
        let residual = repaid(motion, &device, &proxy, &interval, residual);
        memory.is_limited = interval.is_saturated;
        let mut mean = ((interval.course.impulse + residual) / period).max(S::ZERO);
        let apart = interval.course.impulse == S::ZERO;
        let least = S::from_f64(NEGLIGIBLE) * object_velocity.abs();
        if apart && residual * self.object_mobility <= least {
            // An excess impulse is not pulled back, and rounding errors are not corrected.
            mean = S::ZERO;
            memory.impulse_error = S::ZERO;
            memory.given_up = proxy.speed;
        }
        let mut force = governed.with_mean(mean, period);
        let mut held = Held::constant(mean);
        if self.hold == Hold::Line {
            memory.slope = self.slope(observer, &device, &interval, proxy.sway, now.ahead.delay());
            force -= now.ahead.line_off(memory.slope, period);
            held = Held::line(mean, memory.slope, period);
        }
        let planned = first.filter(|_| now.ahead.is_whole());
        let (moved, rule) = planned.unwrap_or_else(|| {
            let mut from = interval;
            if !now.ahead.is_whole() {
                // A command begins between this sample and the next.
                (device, relative, object_velocity, proxy) = at_sample;
                from = self.interval(motion, &device, relative, proxy.sway, virtual_force, period);
                held = now.ahead.over_next(force, memory.slope, period);
            }
            let velocity = object_velocity;
            let moved = self.object_moved(&from, &device, velocity, virtual_force, &held, &proxy);
            (moved.object, rule(&from, now.start.device_velocity))
        });
        Plan { force, rule, moved }
    }

    fn begin_anew(&self, memory: &mut CoupledMemory<S>, device_known: bool, object_known: bool) {
        let observer = memory.observer.filter(|_| device_known);
        // The estimated delay of the loop remains valid.
        let mut lateness = memory.lateness;
        lateness.begin_anew();
        let mut sensor_noise = memory.sensor_noise;
        sensor_noise.interrupted();
        *memory = CoupledMemory {
            observer,
            lateness,
            sensor_noise,
            // A wall that waited for a sample still has to return to its position.
            proxy: ProxyState {
                comes_in: !device_known,
                ..if object_known {
                    memory.proxy
                } else {
                    ProxyState::default()
                }
            },
            ..CoupledMemory::default()
        };
    }

    #[inline]
    fn lateness(&self, memory: &CoupledMemory<S>) -> S {
        memory.lateness.mean
    }

    #[inline]
    fn is_limited(&self, memory: &CoupledMemory<S>) -> bool {
        memory.is_limited
    }

    #[inline]
    fn plans_lines(&self) -> bool {
        true
    }

    #[inline]
    fn slope(&self, memory: &CoupledMemory<S>) -> S {
        memory.slope
    }

    #[inline]
    fn device_acceleration(&self, memory: &CoupledMemory<S>) -> S {
        memory.acceleration
    }

    #[inline]
    fn yields_to_limit(&self) -> bool {
        true
    }

    #[inline]
    fn proxy_shift(&self, memory: &CoupledMemory<S>) -> S {
        memory.shift
    }
}

impl<S: Scalar> Coupled<S> {
    /// Returns the measurement at the end of an interval as the motion of the device's centre of mass, and the distance
    /// of the motor behind it at the interval's beginning `[m]`. `mobility`: estimated 1/m `[1/kg]`. `stretch`: that of
    /// the transmission, advanced to the interval's end.
    #[inline(always)]
    fn measured(
        &self,
        ended: &Ended<S>,
        mobility: S,
        lateness: &Lateness<S>,
        stretch: &mut Sway<S>,
    ) -> (Measurement<S>, S) {
        let sway = *stretch;
        let mut measurement = ended.measurement();
        if self.timing_deviation > S::ZERO {
            // An estimated delay is certain.
            measurement.held.impulse_deviation =
                measurement.held.impulse_deviation * lateness.remaining(self.timing_deviation);
        }
        let mut behind = S::ZERO;
        if let Some(flexure) = &self.flexure {
            // Motion of the centre of mass, from the motor position and the stretch of the transmission.
            *stretch = flexure.under(sway, mobility, &ended.held, ended.elapsed);
            behind = flexure.behind(&sway);
            measurement.moved += flexure.behind(stretch) - behind;
        }
        (measurement, behind)
    }

    /// Returns the variance of the position sensor `[m^2]` after the interval that a sample ends. `before`: device
    /// motion at its beginning.
    #[inline(always)]
    fn sensor_variance(
        &self,
        ended: &Ended<S>,
        before: &EstimatedMotion<S>,
        sensor_noise: &mut SensorNoise<S>,
    ) -> S {
        let model = self.observer.measurement_variance;
        let interval = SensorInterval {
            moved: ended.device_moved,
            elapsed: ended.elapsed,
            pushed: before.mobility * ended.held.mean * ended.elapsed * ended.elapsed,
            expected: before.velocity * ended.elapsed,
        };
        // Without a force the device's mass is not estimated, so the observer need not restart.
        let _ = sensor_noise.take(&interval, model);
        sensor_noise.variance(model)
    }
}

/// Returns the uncertainty of the object's position after an interval under `held_force` `[N]`. `seen`: update of the
/// observer and response of the relative motion, if both give information on it.
#[inline(always)]
fn placed_after<S: Scalar>(
    placed: &Placed<S>,
    seen: Option<(&Update<S>, &Response<S>)>,
    device: &EstimatedMotion<S>,
    interval: &Interval<S>,
    held_force: S,
) -> Placed<S> {
    let Some((lesson, response)) = seen else {
        return Placed::default();
    };
    let touched = interval.course.impulse > S::ZERO;
    let placed = if touched && interval.start.penetration <= S::ZERO {
        // A new collision: the remaining error of the previous one has been observed by now.
        Placed::default()
    } else {
        *placed
    };
    let touched = touched || held_force != S::ZERO;
    placed.after(lesson, device, response, touched, held_force)
}
