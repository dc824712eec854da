//! Ranges of what a scene states.

use palpate::{Allowed, LARGEST_DELAY, Mass, Parameter, ParameterError, Range, Side};
use palpate_testbed::drivetrain::Transmission;
use palpate_testbed::hold::DelayedHold;

use super::parameter::SceneParameter::{self as Of, Rendered};
use super::{HandForceAt, Measure, Scene, Wave};

/// Longest delay `[samples]`, that of the bench's hold.
const MOST_DELAY: usize = DelayedHold::LONGEST_DELAY;

/// A parameter of a scene outside its range.
pub type SceneParameterError = ParameterError<Of>;

/// Faults so far, at most one of each parameter.
#[derive(Default)]
struct Faults(Vec<SceneParameterError>);

impl Faults {
    fn add(&mut self, parameter: Of, value: f64, allowed: Allowed) {
        if self.0.iter().all(|fault| fault.parameter != parameter) {
            self.0.push(ParameterError {
                parameter,
                value,
                allowed,
            });
        }
    }

    fn not(&mut self, parameter: Of, value: f64, allowed: &'static str) {
        self.add(parameter, value, Allowed::Words(allowed));
    }

    fn within(&mut self, range: Range, values: &[(Of, Option<f64>)]) {
        for &(parameter, value) in values {
            if let Some(value) = value
                && !range.contains(value)
            {
                self.add(parameter, value, Allowed::Range(range));
            }
        }
    }
}

impl Scene {
    /// Checks what no renderer looks at.
    ///
    /// # Errors
    /// The first value outside its range.
    pub fn check(&self) -> Result<(), SceneParameterError> {
        self.faults().into_iter().next().map_or(Ok(()), Err)
    }

    /// Every value outside its range that no renderer looks at, one for each parameter.
    #[must_use]
    pub fn faults(&self) -> Vec<SceneParameterError> {
        let mut faults = Faults::default();
        self.check_finite(&mut faults);
        self.check_object_and_linkage(&mut faults);
        if self.recorded_hand.is_some() {
            self.check_beside_recorded_hand(&mut faults);
        }
        self.check_device_and_hand(&mut faults);
        self.check_actuator(&mut faults);
        self.check_drivetrain(&mut faults);
        if self.delay > MOST_DELAY {
            let allowed = "at most 1024";
            faults.not(Rendered(Parameter::Delay), self.delay as f64, allowed);
        }
        // A bad period is the renderer's to refuse.
        if Range::Positive.contains(self.loop_params.period)
            && let Err(error) = self.check_timing()
        {
            faults.add(error.parameter, error.value, error.allowed);
        }
        match self.measure {
            Measure::Collisions(0) => faults.not(Of::Collisions, 0.0, "at least 1"),
            Measure::Collisions(_) => {}
            Measure::Duration(duration) => {
                faults.within(Range::Positive, &[(Of::Duration, Some(duration))]);
            }
        }
        faults.0
    }

    fn check_finite(&self, faults: &mut Faults) {
        let amplitude = |wave: Option<Wave>| wave.map(|wave| wave.amplitude);
        let grip = self.grip.as_ref();
        faults.within(
            Range::Finite,
            &[
                (
                    Rendered(Parameter::ObjectPosition),
                    Some(self.object.position),
                ),
                (
                    Rendered(Parameter::ObjectVelocity),
                    Some(self.object.velocity),
                ),
                (Rendered(Parameter::VirtualForce), Some(self.virtual_force)),
                (Of::DevicePosition, Some(self.device.position)),
                (Of::DeviceVelocity, Some(self.device.velocity)),
                (Of::HandForce, Some(self.user_force)),
                (Of::HandPosition, grip.map(|grip| grip.position)),
                (Of::Tremor, amplitude(self.tremor)),
                (Of::Swing, amplitude(self.swing())),
            ],
        );
        let radius = (Of::ObjectRadius, Some(self.object_radius));
        faults.within(Range::NotNegative, &[radius]);
    }

    fn check_object_and_linkage(&self, faults: &mut Faults) {
        if self.user_force_at == HandForceAt::Motors && self.linkage.is_none() {
            let allowed = "that of a pantograph, whose motors give torques";
            faults.not(Of::HandForceAt, self.user_force, allowed);
        }
        let velocity = self.object.velocity;
        if self.contact.object_mass == Mass::Infinite && velocity != 0.0 {
            faults.not(
                Rendered(Parameter::ObjectVelocity),
                velocity,
                "0 for a wall",
            );
        }
        let Some(linkage) = &self.linkage else {
            return;
        };
        let position = self.device.position;
        let inside = |[low, high]: [f64; 2]| (low..=high).contains(&position);
        if linkage.safety_box.is_some_and(|bounds| !inside(bounds.y)) {
            let allowed = "inside the safety box of the device";
            faults.not(Of::DevicePosition, position, allowed);
        }
        if self.contact.side != Side::Positive {
            let side = Rendered(Parameter::Side);
            faults.not(side, -1.0, "positive for a pantograph");
        }
        if self.grip.is_some() || self.tremor.is_some() {
            let allowed = "all of the hand of a pantograph";
            faults.not(Of::HandForce, self.user_force, allowed);
        }
    }

    fn check_beside_recorded_hand(&self, faults: &mut Faults) {
        let grip = self.grip.as_ref();
        for (parameter, value) in [
            (Of::HandForce, self.user_force),
            (Of::ViscousFriction, self.device.viscous_friction),
            (Of::CoulombFriction, self.device.coulomb_friction),
            (Of::MotorLimit, self.device.largest_force.unwrap_or(0.0)),
            (Of::Tremor, self.tremor.map_or(0.0, |wave| wave.amplitude)),
            (Of::Release, self.release.map_or(0.0, f64::abs)),
            (Of::HandStiffness, grip.map_or(0.0, |grip| grip.stiffness)),
            (
                Of::Resonance,
                self.device.transmission.map_or(0.0, |one| one.resonance_hz),
            ),
            (
                Of::Cogging,
                self.device.cogging.map_or(0.0, |one| one.amplitude),
            ),
        ] {
            if value != 0.0 {
                faults.not(parameter, value, "left out beside a recorded hand");
            }
        }
        if self.linkage.is_some() {
            let allowed = "that of a point mass beside a recorded hand";
            faults.not(Rendered(Parameter::DeviceMass), self.device.mass, allowed);
        }
    }

    fn check_device_and_hand(&self, faults: &mut Faults) {
        if let Some(release) = self.release
            && self.linkage.is_some()
        {
            faults.not(Of::Release, release, "left out for a pantograph");
        }
        faults.within(Range::NotNegative, &[(Of::Release, self.release)]);
        let (grip, device) = (self.grip.as_ref(), &self.device);
        let mass = (Rendered(Parameter::DeviceMass), Some(device.mass));
        faults.within(Range::Positive, &[mass]);
        faults.within(
            Range::NotNegative,
            &[
                (
                    Rendered(Parameter::EncoderQuantum),
                    Some(device.encoder_quantum),
                ),
                (Of::ViscousFriction, Some(device.viscous_friction)),
                (Of::CoulombFriction, Some(device.coulomb_friction)),
                (Of::HandMass, grip.map(|grip| grip.mass)),
                (Of::HandStiffness, grip.map(|grip| grip.stiffness)),
                (Of::HandDamping, grip.map(|grip| grip.damping)),
            ],
        );
        let frequency = |wave: Option<Wave>| wave.map(|wave| wave.frequency_hz);
        faults.within(
            Range::Positive,
            &[
                (Of::ToldDeviceMass, self.told_device_mass),
                (Of::MotorLimit, device.largest_force),
                (Of::TremorFrequency, frequency(self.tremor)),
                (Of::SwingFrequency, frequency(self.swing())),
            ],
        );
    }

    /// Lag and gain, and what the renderer is told of them.
    fn check_actuator(&self, faults: &mut Faults) {
        faults.within(Range::NotNegative, &[(Of::Lag, Some(self.actuator.lag))]);
        faults.within(Range::Positive, &[(Of::Gain, Some(self.actuator.gain))]);
        for (range, parameter, value) in self.told.checked() {
            faults.within(range, &[(parameter, value)]);
        }
        let longest = LARGEST_DELAY as f64 * self.loop_params.period;
        if let Some(delay) = self.told.delay
            && !(0.0..=longest * (1.0 + 1e-9)).contains(&delay)
        {
            faults.not(Of::ToldDelay, delay, "from 0 s to 8 periods");
        }
    }

    /// What is not rigid about the device, or not exact about its sensor.
    fn check_drivetrain(&self, faults: &mut Faults) {
        let device = &self.device;
        faults.within(Range::NotNegative, &[(Of::SensorNoise, Some(device.noise))]);
        if let Some(cogging) = device.cogging {
            faults.within(
                Range::NotNegative,
                &[(Of::Cogging, Some(cogging.amplitude))],
            );
            faults.within(Range::Positive, &[(Of::CoggingPitch, Some(cogging.pitch))]);
        }
        if let Some(transmission) = device.transmission {
            let backlash = (Of::Backlash, Some(transmission.backlash));
            faults.within(Range::NotNegative, &[backlash]);
            for (parameter, value, holds, allowed) in [
                (
                    Of::Resonance,
                    transmission.resonance_hz,
                    transmission.resonance_hz > 0.0
                        && transmission.resonance_hz <= Transmission::HIGHEST_RESONANCE,
                    "above 0 and at most 5000",
                ),
                (
                    Of::ResonanceDamping,
                    transmission.damping_ratio,
                    (0.0..=1.0).contains(&transmission.damping_ratio),
                    "from 0 to 1",
                ),
                (
                    Of::MotorMassShare,
                    transmission.motor_share,
                    transmission.motor_share > 0.0 && transmission.motor_share < 1.0,
                    "above 0 and below 1",
                ),
            ] {
                if !holds {
                    faults.not(parameter, value, allowed);
                }
            }
        }
        if !device.is_rigid()
            && let Some(release) = self.release
        {
            let allowed = "left out of a device with a transmission or cogging";
            faults.not(Of::Release, release, allowed);
        }
    }

    /// Swing of the hand's intended position.
    fn swing(&self) -> Option<Wave> {
        self.grip.as_ref().and_then(|grip| grip.swing)
    }
}
