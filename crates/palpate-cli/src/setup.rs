//! Converts flags to the setup of a command: required values, defaults, and errors that name the flag.

mod actuation;
mod device_file;
mod wrong;

use palpate_core::{
    Allowed, BasicParams, Contact, Hold, LoopParams, Mass, ObjectState, Parameter, Range, Renderer,
};
use palpate_scene::method::{MethodName, Setting, Settings};
use palpate_scene::{Delay, Dropped, GuardBounds, Jitter, Scene, SceneParameter, check_sizes};
use palpate_study::sim::replay::ReplaySetup;

use crate::arguments::{Flags, TimingFlags, flag_of_setting};
use crate::failure::Failure;
use crate::values::AnyMethods;
pub(crate) use actuation::tell_too_long;
pub use device_file::read_calibration;
use device_file::{DeviceFile, warn_of_resonance};
use wrong::not_allowed;
pub use wrong::{wrong_flag, wrong_on_bench, wrong_rendered, wrong_setup};

impl TimingFlags {
    /// Replaces the scene's values by the given flags.
    ///
    /// # Errors
    /// A fraction of a period is combined with a delay in seconds.
    pub fn change(&self, scene: &mut Scene) -> Result<(), Failure> {
        if let Some(given) = self.delay_fraction {
            let Delay::Periods { fraction, .. } = &mut scene.delay else {
                return Err(Failure::Arguments(format!(
                    "--delay-fraction {given}: the delay is {} s; a fraction requires a delay in whole samples, such \
                     as `--delay-periods 1`",
                    scene.delay.seconds()
                )));
            };
            *fraction = given;
        }
        let timing = &mut scene.timing;
        if let Some(bound) = self.jitter {
            timing.jitter = Jitter::Uniform { bound };
        }
        if let Some(probability) = self.drop {
            timing.dropped = Dropped::Probability(probability);
        }
        timing.seed = self.seed.unwrap_or(timing.seed);
        Ok(())
    }
}

/// Explains that a method cannot render one contact.
pub fn only_for_worlds(name: &str) -> Failure {
    Failure::Arguments(format!(
        "--method: {name} renders worlds only, and this is one contact; the methods are {}",
        MethodName::ALL.map(MethodName::name).join(", ")
    ))
}

impl Flags {
    /// Returns the methods to run, `default` if none is named.
    pub fn methods(&self, default: MethodName) -> Vec<MethodName> {
        self.method
            .as_ref()
            .map_or_else(|| vec![default], AnyMethods::of_contact)
    }

    /// Returns the given settings.
    pub fn settings(&self) -> Settings {
        self.settings.0
    }

    /// Whether a setting was given, so that errors of settings name flags.
    pub fn explain_settings(&self) -> bool {
        self.settings() != Settings::default()
    }

    /// Rejects a method that renders worlds only, a setting that one of the methods does not use, or a setting with a
    /// different meaning for two of them.
    pub fn check_settings(&self, methods: &[MethodName]) -> Result<(), Failure> {
        if let Some(name) = self.method.as_ref().and_then(AnyMethods::of_worlds_only) {
            return Err(only_for_worlds(name));
        }
        for (setting, _) in self.settings().iter() {
            let flag = flag_of_setting(setting);
            if let Some(method) = methods.iter().find(|method| !method.uses(setting.key)) {
                return Err(Failure::Arguments(format!(
                    "{flag} cannot be used by method {method}; it is for {}",
                    setting.key.users()
                )));
            }
            let of = |method: &MethodName| Some((method.setting(setting.key)?, *method));
            let mut said = methods.iter().filter_map(of);
            if let Some((first, one)) = said.next()
                && let Some((second, other)) = said.find(|(second, _)| *second != first)
            {
                return Err(Failure::Arguments(format!(
                    "{flag} has two meanings: for {one} {}, for {other} {}; name one of them with --method",
                    first.help, second.help
                )));
            }
        }
        Ok(())
    }

    /// Rejects impossible properties of the device, whether a method uses them or not.
    fn check_device(&self) -> Result<(), Failure> {
        for (parameter, range, value) in [
            (Parameter::DeviceMass, Range::Positive, self.device_mass),
            (
                Parameter::EncoderQuantum,
                Range::NotNegative,
                self.encoder_quantum,
            ),
        ] {
            if let Some(value) = value
                && !range.contains(value)
            {
                return Err(not_allowed(parameter, value, Allowed::Range(range)));
            }
        }
        self.actuation.check()
    }

    /// Reads the device file, if one was given.
    fn device_file(&self, period: f64) -> Result<Option<DeviceFile>, Failure> {
        let path = self.actuation.device_file.as_deref();
        path.map(|path| DeviceFile::read(path, self, period))
            .transpose()
    }

    /// Rejects model values if nothing is simulated that could differ from them.
    fn refuse_model(&self, command: &str) -> Result<(), Failure> {
        self.actuation.refuse_model(command)?;
        if self.model_device_mass.is_none() {
            return Ok(());
        }
        Err(Failure::Arguments(format!(
            "--model-device-mass is for simulate and tune; the model value of {command} is --device-mass"
        )))
    }

    /// Returns contact, loop, object and settings of `method` for a real device, from a scene and overriding flags. The
    /// device's mass is the scene's model value.
    pub fn live_setup(
        &self,
        mut scene: Scene,
        method: MethodName,
    ) -> Result<(ReplaySetup, Settings), Failure> {
        self.refuse_model("pipe")?;
        self.change(&mut scene, &[method])?;
        let model = self.device_mass.or(scene.model_device_mass);
        // Unlike a simulated device, a real one can glitch.
        let of_real_devices = LoopParams::new(scene.loop_params.period).speed_limit;
        let setup = ReplaySetup {
            contact: scene.contact,
            loop_params: LoopParams {
                speed_limit: scene.loop_params.speed_limit.or(of_real_devices),
                ..scene.loop_params
            },
            object: scene.object,
            virtual_force: scene.virtual_force,
            actuation: ReplaySetup::of_scene(&scene).actuation,
            device_mass: model.or(Some(scene.device.mass())),
            encoder_quantum: scene.device.encoder_quantum(),
        };
        scene.check().map_err(|error| wrong_flag(&error))?;
        let settings = scene.settings.remove(&method).unwrap_or_default();
        Ok((setup, settings))
    }

    /// Returns contact, loop and object of `command`, which needs stiffness, mass and period.
    pub fn replay_setup(&self, command: &str) -> Result<ReplaySetup, Failure> {
        let needed = |value: Option<f64>, flag: &str, unit: &str| {
            value.ok_or_else(|| Failure::Arguments(format!("{command} needs {flag} <{unit}>")))
        };
        self.edits.refuse(&format!(
            "{command} without a scene file has no such keys; give --stiffness, --mass and the other flags"
        ))?;
        self.check_device()?;
        self.refuse_model(command)?;
        let mut contact = Contact::object(
            needed(self.stiffness, "--stiffness", "N/m")?,
            needed(self.mass, "--mass", "kg|inf")?,
        );
        contact.side = self.side.unwrap_or_default();
        contact.unilateral = self.unilateral;
        let virtual_force = self.force.unwrap_or(0.0);
        if !virtual_force.is_finite() {
            let allowed = Allowed::Range(Range::Finite);
            return Err(not_allowed(Parameter::VirtualForce, virtual_force, allowed));
        }
        let velocity = self.object_velocity.unwrap_or(0.0);
        if contact.object_mass == Mass::Infinite && velocity != 0.0 {
            let allowed = Allowed::Words("0 for a wall");
            return Err(not_allowed(Parameter::ObjectVelocity, velocity, allowed));
        }
        let period = needed(self.period, "--period", "s")?;
        let file = self.device_file(period)?;
        let file = file.as_ref();
        let device_mass = self.device_mass.or_else(|| file?.device_mass());
        let actuation = self.actuation.actuation(period, file)?;
        warn_of_resonance(file, &self.actuation, device_mass, &contact, period);
        let quantum = || file?.model_quantum();
        Ok(ReplaySetup {
            contact,
            loop_params: self.limits(LoopParams::new(period)),
            object: ObjectState {
                position: self.object_position.unwrap_or(0.0),
                velocity,
            },
            virtual_force,
            actuation,
            device_mass,
            encoder_quantum: self.encoder_quantum.or_else(quantum).unwrap_or(0.0),
        })
    }

    fn limits(&self, others: LoopParams<f64>) -> LoopParams<f64> {
        LoopParams {
            period: others.period,
            largest_gap: self.largest_gap.or(others.largest_gap),
            speed_limit: self.speed_limit.or(others.speed_limit),
            // An infinite limit disables the limit of a scene.
            force_limit: self.force_limit.map_or(others.force_limit, |limit| {
                (limit != f64::INFINITY).then_some(limit)
            }),
            slew_limit: self.slew_limit.or(others.slew_limit),
            guard: self.guard.map_or(others.guard, |mode| {
                mode.guard(GuardBounds {
                    speed: self.guard_speed,
                    allowance: self.guard_allowance,
                    acceleration: self.guard_acceleration,
                    hand_force: self.guard_hand_force,
                    least_mass: self.guard_mass,
                    learns_mass: self.guard_learn_mass,
                    recovery: self.guard_recovery,
                })
            }),
            ..others
        }
    }

    /// Replaces the scene's values by the given flags, for `methods`.
    pub fn change(&self, scene: &mut Scene, methods: &[MethodName]) -> Result<(), Failure> {
        self.check_device()?;
        let before = scene.clone();
        let stiffness = self.stiffness.unwrap_or(scene.contact.stiffness);
        scene.contact.stiffness = stiffness;
        if let Some(mass) = self.mass {
            scene.contact.object_mass = Contact::object(stiffness, mass).object_mass;
        }
        scene.contact.side = self.side.unwrap_or(scene.contact.side);
        scene.contact.unilateral |= self.unilateral;
        scene.loop_params.period = self.period.unwrap_or(scene.loop_params.period);
        scene.loop_params = self.limits(scene.loop_params);
        let object = &mut scene.object;
        object.position = self.object_position.unwrap_or(object.position);
        object.velocity = self.object_velocity.unwrap_or(object.velocity);
        scene.virtual_force = self.force.unwrap_or(scene.virtual_force);
        let file = self.device_file(scene.loop_params.period)?;
        let file = file.as_ref();
        self.actuation.change(scene, file)?;
        if self.device_mass.is_none() {
            let found = file.and_then(DeviceFile::device_mass);
            scene.model_device_mass = found.or(scene.model_device_mass);
        }
        scene.model_device_mass = self.model_device_mass.or(scene.model_device_mass);
        let model_mass = scene.model_device_mass.or(self.device_mass);
        warn_of_resonance(
            file,
            &self.actuation,
            model_mass.or(Some(scene.device.mass())),
            &scene.contact,
            scene.loop_params.period,
        );
        let quantum = file.and_then(DeviceFile::sensor_quantum);
        let quantum = self.encoder_quantum.or(quantum);
        if let Some(given) = self.device_mass {
            let Some(mass) = scene.device.mass_mut() else {
                let message =
                    "--device-mass: the recorded hand of the scene defines the device mass";
                return Err(Failure::Arguments(message.into()));
            };
            *mass = given;
        }
        if let Some(given) = quantum {
            *scene.device.encoder_quantum_mut() = given;
            scene.model.sensor_quantum = None;
        }
        for &method in methods {
            let settings = scene.settings.entry(method).or_default();
            *settings = self.settings().or(*settings);
        }
        retitle(scene, &before);
        Ok(())
    }

    /// Whether any flag changes the simulation.
    pub fn change_a_scene(&self) -> bool {
        let rendered = [
            Parameter::Stiffness,
            Parameter::ObjectMass,
            Parameter::VirtualForce,
            Parameter::ObjectPosition,
            Parameter::ObjectVelocity,
            Parameter::Side,
            Parameter::Period,
            Parameter::ForceLimit,
            Parameter::SlewLimit,
            Parameter::SpeedLimit,
            Parameter::LargestGap,
            Parameter::GuardSpeed,
            Parameter::GuardAllowance,
            Parameter::GuardAcceleration,
            Parameter::GuardHandForce,
            Parameter::GuardMass,
            Parameter::GuardRecovery,
            Parameter::DeviceMass,
            Parameter::EncoderQuantum,
        ];
        let is_number = |(setting, _): (&Setting, _)| setting.unit().is_some();
        rendered.into_iter().any(|given| self.gives(given.into()))
            || self.gives(SceneParameter::ModelDeviceMass)
            || self.actuation.change_a_scene()
            || self.settings().iter().any(is_number)
    }
}

/// Rejects a contact, a loop or an object that is invalid for all methods.
pub fn check_contact(setup: &ReplaySetup) -> Result<(), Failure> {
    // Basic plans constants for any hold.
    let mut loop_params = setup.known_loop();
    loop_params.actuation.hold = Hold::Constant;
    Renderer::new(setup.contact, loop_params, BasicParams)
        .and_then(|renderer| renderer.start(setup.object))
        .map_err(|error| wrong_rendered(&error))?;
    check_sizes(&setup.contact, loop_params.period).map_err(|error| wrong_flag(&error))
}

/// Adds values changed by flags to a title, which may name those of the file.
fn retitle(scene: &mut Scene, before: &Scene) {
    let mass = |scene: &Scene| match scene.contact.object_mass {
        palpate_core::Mass::Finite(mass) => mass,
        palpate_core::Mass::Infinite => f64::INFINITY,
    };
    let values = |scene: &Scene| {
        [
            ("stiffness", scene.contact.stiffness, " N/m"),
            ("object", mass(scene), " kg"),
            ("device", scene.device.mass(), " kg"),
            ("period", scene.loop_params.period, " s"),
            ("force on the object", scene.virtual_force, " N"),
        ]
    };
    let changed: Vec<String> = values(scene)
        .iter()
        .zip(values(before))
        .filter(|(now, then)| now.1.to_bits() != then.1.to_bits())
        .map(|(&(name, value, unit), _)| match value {
            f64::INFINITY => "a wall".into(),
            value => format!("{name} {value}{unit}"),
        })
        .collect();
    if !changed.is_empty() {
        let title = std::mem::take(&mut scene.title);
        scene.title = format!("{title} (changed: {})", changed.join(", "));
    }
}
