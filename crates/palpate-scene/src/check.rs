//! Range checks of scene parameters.

use palpate_core::{
    Allowed, Contact, Hold, LARGEST_DELAY, Mass, Parameter, ParameterError, Range, Side,
};
use palpate_testbed::drivetrain::Transmission;

use super::parameter::SceneParameter::{self as Of, Rendered};
use super::{
    Dropped, Hand, Intention, Jitter, Measure, PantographDevice, PointMassDevice, Scene,
    SceneDevice, Wave,
};

/// Largest number, of either sign and in whatever unit: the squares and products of larger ones may not be finite.
pub const LARGEST: f64 = 1e12;

/// Smallest number that has to be above 0, in whatever unit: the inverses of smaller ones may not be finite.
const SMALLEST: f64 = 1e-20;

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
            let Some(value) = value else {
                continue;
            };
            if !range.contains(value) {
                self.add(parameter, value, Allowed::Range(range));
            } else if range == Range::Positive && value < SMALLEST {
                self.not(parameter, value, "at least 1e-20");
            } else if value > LARGEST {
                self.not(parameter, value, "at most 1e12");
            } else if value < -LARGEST {
                self.not(parameter, value, "at least -1e12");
            }
        }
    }
}

/// Returns the errors of finite values of a contact and of its `period` `[s]` beyond their upper limits.
fn sizes(contact: &Contact<f64>, period: f64) -> impl Iterator<Item = SceneParameterError> {
    let mass = match contact.object_mass {
        Mass::Finite(mass) => mass,
        Mass::Infinite => 0.0,
    };
    let values = [
        (Parameter::Stiffness, contact.stiffness),
        (Parameter::ObjectMass, mass),
        (Parameter::Period, period),
    ];
    let beyond = values.into_iter();
    let beyond = beyond.filter(|(_, value)| value.is_finite() && *value > LARGEST);
    beyond.map(|(parameter, value)| ParameterError {
        parameter: Rendered(parameter),
        value,
        allowed: Allowed::Words("at most 1e12"),
    })
}

/// Checks the upper limits of a contact without a scene, and of its `period` `[s]`; those of a scene are the same.
///
/// # Errors
/// The first value beyond its limit.
pub fn check_sizes(contact: &Contact<f64>, period: f64) -> Result<(), SceneParameterError> {
    sizes(contact, period).next().map_or(Ok(()), Err)
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
        self.check_size(&mut faults);
        self.check_object(&mut faults);
        self.check_device(&mut faults);
        self.check_actuator(&mut faults);
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

    /// Checks the upper limits of contact and loop; their own checks cover sign and finiteness.
    fn check_size(&self, faults: &mut Faults) {
        for error in sizes(&self.contact, self.loop_params.period) {
            faults.add(error.parameter, error.value, error.allowed);
        }
    }

    fn check_object(&self, faults: &mut Faults) {
        let velocity = self.object.velocity;
        faults.within(
            Range::Finite,
            &[
                (
                    Rendered(Parameter::ObjectPosition),
                    Some(self.object.position),
                ),
                (Rendered(Parameter::ObjectVelocity), Some(velocity)),
                (Rendered(Parameter::VirtualForce), Some(self.virtual_force)),
            ],
        );
        let radius = (Of::ObjectRadius, Some(self.object_radius));
        faults.within(Range::NotNegative, &[radius]);
        if self.contact.object_mass == Mass::Infinite && velocity != 0.0 {
            faults.not(
                Rendered(Parameter::ObjectVelocity),
                velocity,
                "0 for a wall",
            );
        }
    }

    /// Checks the parameters of every device.
    fn check_device(&self, faults: &mut Faults) {
        let device = &self.device;
        faults.within(
            Range::Finite,
            &[
                (Of::DevicePosition, Some(device.position())),
                (Of::DeviceVelocity, Some(device.velocity())),
                (Of::HandForce, Some(device.hand_force())),
            ],
        );
        let mass = (Rendered(Parameter::DeviceMass), Some(device.mass()));
        let model = (Of::ModelDeviceMass, self.model_device_mass);
        faults.within(Range::Positive, &[mass, model]);
        let quantum = Rendered(Parameter::EncoderQuantum);
        let quantum = (quantum, Some(device.encoder_quantum()));
        faults.within(Range::NotNegative, &[quantum]);
        match device {
            SceneDevice::PointMass(device) => {
                check_hand(&device.hand, faults);
                check_point_mass(device, faults);
            }
            SceneDevice::Pantograph(device) => self.check_pantograph(device, faults),
            // A recorded hand has been checked where it was estimated.
            SceneDevice::Recorded { .. } => {}
        }
    }

    fn check_pantograph(&self, device: &PantographDevice, faults: &mut Faults) {
        let position = device.position;
        let inside = |[low, high]: [f64; 2]| (low..=high).contains(&position);
        let bounds = device.linkage.safety_box;
        if bounds.is_some_and(|bounds| !inside(bounds.y)) {
            let allowed = "inside the safety box of the device";
            faults.not(Of::DevicePosition, position, allowed);
        }
        if self.contact.side != Side::Positive {
            let side = Rendered(Parameter::Side);
            faults.not(side, 1.0, "-1 along y on a linkage");
        }
    }

    /// Checks lag and gain, and their model values.
    fn check_actuator(&self, faults: &mut Faults) {
        faults.within(Range::NotNegative, &[(Of::Lag, Some(self.actuator.lag))]);
        faults.within(Range::Positive, &[(Of::Gain, Some(self.actuator.gain))]);
        for (range, parameter, value) in self.model.checked() {
            faults.within(range, &[(parameter, value)]);
        }
        if self.hold() == Hold::Line {
            self.check_line(faults);
        }
        let longest = LARGEST_DELAY as f64 * self.loop_params.period;
        if let Some(delay) = self.model.delay
            && !(0.0..=longest * (1.0 + 1e-9)).contains(&delay)
        {
            faults.not(Of::ModelDelay, delay, "from 0 s to 8 periods");
        }
    }
}

impl Scene {
    /// Checks what a line hold excludes: a line lasts one nominal period, without a lag.
    fn check_line(&self, faults: &mut Faults) {
        let mut refuse = |parameter: Of, value: f64| {
            if value != 0.0 {
                faults.not(parameter, value, "0 with loop.hold = \"line\"");
            }
        };
        let timing = &self.timing;
        refuse(Of::Lag, self.actuator.lag);
        refuse(Of::CommandJitter, timing.command_jitter);
        match timing.jitter {
            Jitter::None => {}
            Jitter::Uniform { bound } | Jitter::Normal { bound, .. } => refuse(Of::Jitter, bound),
        }
        match &timing.dropped {
            Dropped::None => {}
            Dropped::Probability(probability) => refuse(Of::DropProbability, *probability),
            Dropped::Listed(samples) => refuse(Of::DroppedSamples, samples.len() as f64),
        }
        if let Some(collapse) = &timing.collapse {
            let allowed = "absent with loop.hold = \"line\"";
            faults.not(Of::CollapsePeriod, collapse.period, allowed);
        }
        if self.device.pantograph().is_some() {
            let allowed = "0, \"constant\", for a linkage: its motors hold torques";
            faults.not(Rendered(Parameter::HoldOrder), 1.0, allowed);
        }
    }
}

fn check_hand(hand: &Hand, faults: &mut Faults) {
    let amplitude = |wave: Option<Wave>| wave.map(|wave| wave.amplitude);
    let frequency = |wave: Option<Wave>| wave.map(|wave| wave.frequency_hz);
    let grip = hand.grip.as_ref();
    let (position, swing) = match grip.map(|grip| &grip.intention) {
        Some(Intention::Place { position, swing }) => (Some(*position), *swing),
        Some(Intention::Recorded(_)) | None => (None, None),
    };
    faults.within(
        Range::Finite,
        &[
            (Of::HandPosition, position),
            (Of::Tremor, amplitude(hand.tremor)),
            (Of::Swing, amplitude(swing)),
        ],
    );
    faults.within(
        Range::NotNegative,
        &[
            (Of::Release, hand.release),
            (Of::HandMass, grip.map(|grip| grip.mass)),
            (Of::HandStiffness, grip.map(|grip| grip.stiffness)),
            (Of::HandDamping, grip.map(|grip| grip.damping)),
        ],
    );
    faults.within(
        Range::Positive,
        &[
            (Of::TremorFrequency, frequency(hand.tremor)),
            (Of::SwingFrequency, frequency(swing)),
        ],
    );
}

/// Friction, motor, transmission and sensor of a point mass.
fn check_point_mass(device: &PointMassDevice, faults: &mut Faults) {
    faults.within(
        Range::NotNegative,
        &[
            (Of::ViscousFriction, Some(device.viscous_friction)),
            (Of::CoulombFriction, Some(device.coulomb_friction)),
            (Of::SensorNoise, Some(device.noise)),
        ],
    );
    faults.within(Range::Positive, &[(Of::MotorLimit, device.largest_force)]);
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
                Of::MotorMassFraction,
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
}
