//! Scenes as files.

use std::fmt::Write;

use palpate_core::{Contact, Guard, LoopParams, Mass, ObjectState, ParameterValue, Side};
use palpate_testbed::actuator::ActuatorParams;
use palpate_testbed::pantograph::SafetyBox;

use super::{
    Delay, Dropped, Grip, Hand, HandForceAt, Intention, Jitter, Measure, Model, PantographDevice,
    PointMassDevice, Scene, SceneDevice, Timing, Wave,
};
use crate::method::{MethodName, Settings};

/// Part of a scene for which scene files have no key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a scene file cannot contain {0}")]
pub struct Unwritable(&'static str);

impl Scene {
    /// Returns the scene as a file that reads back to the same bits.
    ///
    /// # Errors
    /// The hand follows a recording, or the linkage is not a preset; these need separate files.
    pub fn to_toml(&self) -> Result<String, Unwritable> {
        // Taken apart, so that what is added to a scene cannot be forgotten here.
        let Self {
            title,
            contact,
            loop_params,
            object,
            object_radius,
            virtual_force,
            device,
            model_device_mass,
            delay,
            timing,
            actuator,
            model,
            measure,
            method,
            settings,
        } = self;
        let mut file = File::default();
        file.line("scene_format", "1");
        file.line("title", &toml::Value::from(title.as_str()).to_string());
        file.object_table(*contact, *object, *object_radius, *virtual_force);
        file.device_tables(device)?;
        file.loop_table(loop_params.period, *delay, timing, *actuator);
        file.model(model);
        file.measure_table(measure);
        let unilateral = contact.unilateral;
        file.renderer_table(*method, *model_device_mass, unilateral, *loop_params);
        for method in MethodName::ALL {
            if let Some(settings) = settings.get(&method) {
                file.table(&format!("methods.{method}"));
                file.settings(method, settings);
            }
        }
        Ok(file.0)
    }
}

/// The text so far.
#[derive(Default)]
struct File(String);

/// Tables of a scene.
impl File {
    /// Writes `[object]`, with its radius `[m]` and the virtual force on it `[N]`.
    fn object_table(
        &mut self,
        contact: Contact<f64>,
        object: ObjectState<f64>,
        radius: f64,
        force: f64,
    ) {
        let Contact {
            stiffness,
            object_mass,
            side,
            // In `[renderer]`.
            unilateral: _,
        } = contact;
        self.table("object");
        self.number(
            "mass_kg",
            match object_mass {
                Mass::Finite(mass) => mass,
                Mass::Infinite => f64::INFINITY,
            },
        );
        self.number("stiffness_n_per_m", stiffness);
        self.number("position_m", object.position);
        self.unless_zero("velocity_m_per_s", object.velocity);
        self.unless_zero("radius_m", radius);
        self.unless_zero("force_n", force);
        if side == Side::Negative {
            self.line("side", "\"negative\"");
        }
    }

    /// Writes `[device]` and `[hand]`.
    fn device_tables(&mut self, device: &SceneDevice) -> Result<(), Unwritable> {
        match device {
            SceneDevice::PointMass(device) => {
                self.table("device");
                self.point_mass(device);
                self.table("hand");
                self.hand(&device.hand)
            }
            SceneDevice::Pantograph(device) => self.pantograph(device),
            SceneDevice::Recorded { .. } => Err(Unwritable("the motion of a recorded hand")),
        }
    }

    /// Writes `[loop]`, with its period `[s]`.
    fn loop_table(&mut self, period: f64, delay: Delay, timing: &Timing, actuator: ActuatorParams) {
        self.table("loop");
        self.number("period_s", period);
        self.delay(delay);
        self.timing(timing);
        self.unless_zero("lag_s", actuator.lag);
        if actuator.gain != 1.0 {
            self.number("gain", actuator.gain);
        }
    }

    /// Writes `[measure]`.
    fn measure_table(&mut self, measure: &Measure) {
        self.table("measure");
        match measure {
            Measure::Collisions(count) => self.line("collisions", &count.to_string()),
            Measure::Duration(duration) => self.number("duration_s", *duration),
        }
    }

    /// Writes `[renderer]`, with the device mass that it assumes `[kg]`.
    fn renderer_table(
        &mut self,
        method: MethodName,
        device_mass: Option<f64>,
        unilateral: bool,
        loop_params: LoopParams<f64>,
    ) {
        let LoopParams {
            // In `[loop]`.
            period: _,
            largest_gap,
            speed_limit,
            force_limit,
            slew_limit,
            // In a scene: `delay`, `timing`, `actuator` and `model`.
            actuation: _,
            guard,
        } = loop_params;
        self.table("renderer");
        self.line("method", &format!("\"{method}\""));
        self.if_given("device_mass_kg", device_mass);
        if unilateral {
            self.line("unilateral", "true");
        }
        self.if_given("force_limit_n", force_limit);
        self.if_given("slew_limit_n_per_s", slew_limit);
        self.if_given("speed_limit_m_per_s", speed_limit);
        self.if_given("largest_gap_s", largest_gap);
        self.guard(guard);
    }
}

/// Parts of tables.
impl File {
    fn table(&mut self, name: &str) {
        self.line_of(format_args!("\n[{name}]"));
    }

    fn line(&mut self, key: &str, value: &str) {
        self.line_of(format_args!("{key} = {value}"));
    }

    /// The fewest digits that read back to the same bits.
    fn number(&mut self, key: &str, value: f64) {
        self.line_of(format_args!("{key} = {value:?}"));
    }

    /// A value whose default is 0. That of -0 is not.
    fn unless_zero(&mut self, key: &str, value: f64) {
        if value.to_bits() != 0 {
            self.number(key, value);
        }
    }

    fn if_given(&mut self, key: &str, value: Option<f64>) {
        if let Some(value) = value {
            self.number(key, value);
        }
    }

    fn wave(&mut self, keys: [&str; 2], wave: Option<Wave>) {
        if let Some(wave) = wave {
            self.number(keys[0], wave.amplitude);
            self.number(keys[1], wave.frequency_hz);
        }
    }

    fn point_mass(&mut self, device: &PointMassDevice) {
        self.line("kind", "\"point-mass\"");
        self.number("mass_kg", device.mass);
        self.unless_zero("position_m", device.position);
        self.unless_zero("velocity_m_per_s", device.velocity);
        self.unless_zero("encoder_quantum_m", device.encoder_quantum);
        self.unless_zero("viscous_n_s_per_m", device.viscous_friction);
        self.unless_zero("coulomb_n", device.coulomb_friction);
        self.if_given("motor_limit_n", device.largest_force);
        if let Some(transmission) = device.transmission {
            self.number("resonance_hz", transmission.resonance_hz);
            self.number("resonance_damping_ratio", transmission.damping_ratio);
            self.number("motor_mass_share", transmission.motor_share);
            self.unless_zero("backlash_m", transmission.backlash);
        }
        if let Some(cogging) = device.cogging {
            self.number("cogging_n", cogging.amplitude);
            self.number("cogging_pitch_m", cogging.pitch);
        }
        self.unless_zero("noise_m", device.noise);
    }

    fn hand(&mut self, hand: &Hand) -> Result<(), Unwritable> {
        let Hand {
            force,
            tremor,
            grip,
            release,
        } = hand;
        match grip {
            Some(grip) => self.grip(grip)?,
            None => self.line("kind", "\"constant-force\""),
        }
        self.number("force_n", *force);
        self.wave(["tremor_n", "tremor_hz"], *tremor);
        self.if_given("release_s", *release);
        Ok(())
    }

    fn grip(&mut self, grip: &Grip) -> Result<(), Unwritable> {
        let Intention::Place { position, swing } = grip.intention else {
            return Err(Unwritable("the recorded intention of a hand"));
        };
        self.line("kind", "\"impedance\"");
        self.number("mass_kg", grip.mass);
        self.number("stiffness_n_per_m", grip.stiffness);
        self.number("damping_n_s_per_m", grip.damping);
        self.number("position_m", position);
        self.wave(["swing_m", "swing_hz"], swing);
        Ok(())
    }

    fn pantograph(&mut self, device: &PantographDevice) -> Result<(), Unwritable> {
        let PantographDevice {
            linkage,
            position,
            // The linkage gives it.
            mass: _,
            // A file has no key for it.
            encoder_quantum: _,
            force,
            force_at,
        } = device;
        let (preset, safety_box) = linkage
            .as_preset()
            .ok_or(Unwritable("the values of a separate device file"))?;
        self.table("device");
        self.line("kind", "\"pantograph\"");
        self.line("preset", &format!("\"{preset}\""));
        if let Some(SafetyBox { x, y }) = safety_box {
            let bounds = format!("{{ x_m = {x:?}, y_m = {y:?} }}");
            self.line("safety_box", &bounds);
        }
        self.unless_zero("position_m", *position);
        self.table("hand");
        self.line("kind", "\"constant-force\"");
        self.number("force_n", *force);
        if *force_at != HandForceAt::default() {
            self.line("force_at", &format!("\"{}\"", force_at.name()));
        }
        Ok(())
    }

    fn delay(&mut self, delay: Delay) {
        match delay {
            Delay::Periods { samples, fraction } => {
                if samples > 0 {
                    self.line("delay_samples", &samples.to_string());
                }
                self.unless_zero("delay_fraction", fraction);
            }
            Delay::Seconds(seconds) => self.number("delay_s", seconds),
        }
    }

    fn timing(&mut self, timing: &Timing) {
        let Timing {
            command_jitter,
            jitter,
            dropped,
            collapse,
            seed,
        } = timing;
        self.unless_zero("command_jitter_s", *command_jitter);
        match *jitter {
            Jitter::None => {}
            Jitter::Uniform { bound } => self.number("jitter_s", bound),
            Jitter::Normal { deviation, bound } => {
                self.number("jitter_s", bound);
                self.number("jitter_deviation_s", deviation);
            }
        }
        match dropped {
            Dropped::None => {}
            Dropped::Probability(probability) => self.number("drop_probability", *probability),
            Dropped::Listed(samples) => self.line("dropped_samples", &format!("{samples:?}")),
        }
        if let Some(collapse) = collapse {
            let (from, until, period) = (collapse.from, collapse.until, collapse.period);
            self.line(
                "collapse",
                &format!("{{ from_s = {from:?}, until_s = {until:?}, period_s = {period:?} }}"),
            );
        }
        if *seed > 0 {
            self.line("seed", &seed.to_string());
        }
    }

    fn model(&mut self, model: &Model) {
        let Model {
            delay,
            delay_deviation,
            lag,
            lag_deviation,
            gain,
            gain_deviation,
            sensor_noise,
            transmission,
        } = *model;
        if *model == Model::default() {
            return;
        }
        self.table("model");
        self.if_given("delay_s", delay);
        self.if_given("delay_deviation_s", delay_deviation);
        self.if_given("lag_s", lag);
        self.if_given("lag_deviation_s", lag_deviation);
        self.if_given("gain", gain);
        self.if_given("gain_deviation", gain_deviation);
        self.if_given("sensor_noise_m", sensor_noise);
        if let Some(transmission) = transmission {
            self.number("resonance_hz", transmission.resonance);
            self.number("resonance_damping_ratio", transmission.damping_ratio);
            self.number(
                "flexible_mass_fraction",
                transmission.flexible_mass_fraction,
            );
        }
    }

    fn guard(&mut self, guard: Guard<f64>) {
        let (mode, params) = match guard {
            Guard::Off => return,
            Guard::Report(params) => ("report", params),
            Guard::Limit(params) => ("limit", params),
        };
        let (speed, allowance) = (params.largest_speed, params.allowance);
        self.line(
            "guard",
            &format!(
                "{{ mode = \"{mode}\", speed_m_per_s = {speed:?}, allowance_j = {allowance:?} }}"
            ),
        );
    }

    fn settings(&mut self, method: MethodName, given: &Settings) {
        let own = method.info().settings.iter();
        let own = own.filter_map(|setting| Some((setting, given.get(setting.key)?)));
        // Reading refuses what the method cannot use; it is not for the writer to drop it.
        let unused = given
            .iter()
            .filter(|(setting, _)| !method.uses(setting.key));
        for (setting, value) in own.chain(unused) {
            let key = setting.key.as_str();
            match value {
                ParameterValue::Number(number) => self.number(key, number),
                ParameterValue::Switch(on) => self.line(key, &on.to_string()),
                ParameterValue::Word(_) | ParameterValue::ToBeDerived => {
                    self.line(key, &format!("\"{value}\""));
                }
            }
        }
    }

    fn line_of(&mut self, line: std::fmt::Arguments) {
        // A string takes every character.
        let _ = writeln!(self.0, "{line}");
    }
}
