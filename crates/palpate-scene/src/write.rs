//! Scenes of one contact as files.

use std::fmt::Write;

use palpate_core::{
    Contact, Guard, HandLimit, Hold, LoopParams, Mass, ObjectState, ParameterValue,
};
use palpate_testbed::actuator::ActuatorParams;
use palpate_testbed::pantograph::SafetyBox;

use super::{
    Delay, Dropped, Grip, Hand, HandForceAt, Intention, Jitter, Measure, Model, PantographDevice,
    PointMassDevice, Scene, SceneDevice, Timing, Wave,
};
use crate::guard::OF_DEVICE;
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
        let axis = device.pantograph().map_or("x", |_| "y");
        let mut file = File {
            text: String::new(),
            axis,
        };
        file.line("format", "2");
        file.line("title", &toml::Value::from(title.as_str()).to_string());
        file.loop_table(loop_params, *delay, timing, *actuator);
        file.device_tables(device)?;
        let object = (*object, *object_radius, *virtual_force);
        file.body_tables(*contact, object);
        file.model(model, *model_device_mass);
        file.render_table(*method, contact.unilateral, *loop_params);
        file.measure_table(measure);
        for method in MethodName::ALL {
            if let Some(settings) = settings.get(&method) {
                file.table(&format!("[methods.{method}]"));
                file.settings(method, settings);
            }
        }
        Ok(file.text)
    }
}

/// The text so far.
struct File {
    text: String,
    /// Name of the axis of device and object.
    axis: &'static str,
}

/// Tables of a scene.
impl File {
    /// Writes `[[body]]` and `[[contact]]`, with the object's state, its radius `[m]` and the virtual force on it
    /// `[N]`.
    fn body_tables(
        &mut self,
        contact: Contact<f64>,
        (object, radius, force): (ObjectState<f64>, f64, f64),
    ) {
        let Contact {
            stiffness,
            object_mass,
            side,
            // In `[render]`.
            unilateral: _,
        } = contact;
        let sign = side.sign::<f64>();
        self.table("[[body]]");
        let name = match object_mass {
            Mass::Finite(mass) => {
                self.line("name", "\"object\"");
                self.axes();
                self.number("mass_kg", mass);
                "object"
            }
            Mass::Infinite => {
                self.line("name", "\"wall\"");
                self.line("fixed", "true");
                "wall"
            }
        };
        self.vector("position_m", object.position);
        if object_mass != Mass::Infinite {
            self.vector_unless_zero("velocity_m_per_s", object.velocity);
            self.vector_unless_zero("force_n", force);
        }
        if radius.to_bits() != 0 {
            self.vector("centre_m", if sign > 0.0 { radius } else { -radius });
        }
        let normal = self.along(-sign);
        self.line(
            "shape",
            &format!("{{ half_space = {{ normal = {normal} }} }}"),
        );
        self.table("[[contact]]");
        self.line("between", &format!("[\"device\", \"{name}\"]"));
        self.number("stiffness_n_per_m", stiffness);
    }

    /// Writes `[[device]]` with its drivetrain and its hand.
    fn device_tables(&mut self, device: &SceneDevice) -> Result<(), Unwritable> {
        match device {
            SceneDevice::PointMass(device) => {
                self.point_mass(device);
                self.hand(&device.hand)
            }
            SceneDevice::Pantograph(device) => self.pantograph(device),
            SceneDevice::Recorded { .. } => Err(Unwritable("the motion of a recorded hand")),
        }
    }

    /// Writes `[loop]`, with period and hold.
    fn loop_table(
        &mut self,
        loop_params: &LoopParams<f64>,
        delay: Delay,
        timing: &Timing,
        actuator: ActuatorParams,
    ) {
        self.table("[loop]");
        self.number("period_s", loop_params.period);
        self.delay(delay);
        self.timing(timing);
        self.unless_zero("lag_s", actuator.lag);
        if actuator.gain != 1.0 {
            self.number("gain", actuator.gain);
        }
        let hold = loop_params.actuation.hold;
        if hold != Hold::Constant {
            self.line("hold", &format!("\"{}\"", hold.name()));
        }
    }

    /// Writes `[measure]`.
    fn measure_table(&mut self, measure: &Measure) {
        self.table("[measure]");
        match measure {
            Measure::Collisions(count) => self.line("collisions", &count.to_string()),
            Measure::Duration(duration) => self.number("duration_s", *duration),
        }
    }

    /// Writes `[render]`.
    fn render_table(&mut self, method: MethodName, unilateral: bool, loop_params: LoopParams<f64>) {
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
        self.table("[render]");
        self.line("method", &format!("\"{method}\""));
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
    fn table(&mut self, header: &str) {
        self.line_of(format_args!("\n{header}"));
    }

    fn line(&mut self, key: &str, value: &str) {
        self.line_of(format_args!("{key} = {value}"));
    }

    /// Writes the axes of a device or a body: one.
    fn axes(&mut self) {
        let axis = self.axis;
        self.line("axes", &format!("[\"{axis}\"]"));
    }

    /// Returns a vector with this component along the axis.
    fn along(&self, value: f64) -> String {
        let parts = ["x", "y", "z"].map(|axis| if axis == self.axis { value } else { 0.0 });
        format!("{parts:?}")
    }

    fn vector(&mut self, key: &str, value: f64) {
        let vector = self.along(value);
        self.line(key, &vector);
    }

    /// A vector whose default is 0. That of -0 is not.
    fn vector_unless_zero(&mut self, key: &str, value: f64) {
        if value.to_bits() != 0 {
            self.vector(key, value);
        }
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
        self.table("[[device]]");
        self.line("name", "\"device\"");
        self.axes();
        self.number("mass_kg", device.mass);
        self.vector_unless_zero("position_m", device.position);
        self.vector_unless_zero("velocity_m_per_s", device.velocity);
        self.unless_zero("quantum_m", device.encoder_quantum);
        self.unless_zero("noise_m", device.noise);
        if device.is_rigid()
            && device.largest_force.is_none()
            && [device.viscous_friction, device.coulomb_friction]
                .iter()
                .all(|friction| friction.to_bits() == 0)
        {
            return;
        }
        self.table("[device.drivetrain]");
        self.unless_zero("viscous_friction_n_s_per_m", device.viscous_friction);
        self.unless_zero("coulomb_friction_n", device.coulomb_friction);
        self.if_given("motor_limit_n", device.largest_force);
        if let Some(transmission) = device.transmission {
            self.number("resonance_hz", transmission.resonance_hz);
            self.number("resonance_damping_ratio", transmission.damping_ratio);
            self.number("motor_mass_fraction", transmission.motor_share);
            self.unless_zero("backlash_m", transmission.backlash);
        }
        if let Some(cogging) = device.cogging {
            self.number("cogging_n", cogging.amplitude);
            self.number("cogging_pitch_m", cogging.pitch);
        }
    }

    fn hand(&mut self, hand: &Hand) -> Result<(), Unwritable> {
        let Hand {
            force,
            tremor,
            grip,
            release,
        } = hand;
        self.table("[device.hand]");
        self.vector("force_n", *force);
        if let Some(grip) = grip {
            self.grip(grip)?;
        }
        self.wave(["tremor_n", "tremor_hz"], *tremor);
        self.if_given("release_s", *release);
        Ok(())
    }

    fn grip(&mut self, grip: &Grip) -> Result<(), Unwritable> {
        let Intention::Place { position, swing } = grip.intention else {
            return Err(Unwritable("the recorded intention of a hand"));
        };
        self.number("mass_kg", grip.mass);
        self.number("stiffness_n_per_m", grip.stiffness);
        self.number("damping_n_s_per_m", grip.damping);
        self.vector("rest_m", position);
        if let Some(swing) = swing {
            self.vector("swing_m", swing.amplitude);
            self.number("swing_hz", swing.frequency_hz);
        }
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
        self.table("[[device]]");
        self.line("name", "\"device\"");
        self.axes();
        self.line("linkage", &format!("{{ preset = \"{preset}\" }}"));
        if let Some(SafetyBox { x, y }) = safety_box {
            let bounds = format!("{{ x_m = {x:?}, y_m = {y:?} }}");
            self.line("safety_box", &bounds);
        }
        self.vector_unless_zero("position_m", *position);
        self.table("[device.hand]");
        self.vector("force_n", *force);
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

    fn model(&mut self, model: &Model, device_mass: Option<f64>) {
        let Model {
            delay,
            delay_deviation,
            lag,
            lag_deviation,
            gain,
            gain_deviation,
            sensor_quantum,
            sensor_noise,
            transmission,
        } = *model;
        if *model == Model::default() && device_mass.is_none() {
            return;
        }
        self.table("[model]");
        self.if_given("delay_s", delay);
        self.if_given("delay_deviation_s", delay_deviation);
        self.if_given("lag_s", lag);
        self.if_given("lag_deviation_s", lag_deviation);
        self.if_given("gain", gain);
        self.if_given("gain_deviation", gain_deviation);
        self.if_given("sensor_quantum_m", sensor_quantum);
        self.if_given("sensor_noise_m", sensor_noise);
        self.if_given("device_mass_kg", device_mass);
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
        let mut table = format!(
            "mode = \"{mode}\", speed_m_per_s = {speed:?}, allowance_j = {allowance:?}, recovery_w = {:?}",
            params.recovery
        );
        if let Some(hand) = params.hand {
            table += &match hand.limit {
                HandLimit::Acceleration(most) => format!(", acceleration_m_per_s2 = {most:?}"),
                HandLimit::Force(most) => format!(", hand_force_n = {most:?}"),
            };
            if hand.least_mass != OF_DEVICE {
                table += &format!(", least_mass_kg = {:?}", hand.least_mass);
            }
            if hand.learns_mass {
                table += ", learn_mass = true";
            }
        }
        self.line("guard", &format!("{{ {table} }}"));
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
        let _ = writeln!(self.text, "{line}");
    }
}
