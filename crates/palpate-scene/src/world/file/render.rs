//! The tables `[render]`, `[model]` and `[methods]` of a world.

use std::collections::HashMap;

use palpate_core::{Actuation, Range};
use palpate_world::{Vector, WorldField as Field, WorldGuard, WorldPart};
use toml::Spanned;

use super::Reading;
use crate::fault::unknown_key;
use crate::method::{method_named, nearest};
use crate::model::{RawModel, quantum_of};
use crate::raw_settings::RawSettings;
use crate::render_key::RawRender;
use crate::world::per_axis::PerAxis;
use crate::world::{WorldDevice, WorldRender, WorldScene, WorldSettings};

impl Reading {
    /// Returns the renderer's method and model values, those of `devices` and `known` by default, without settings.
    pub(super) fn render(
        &mut self,
        raw: RawRender,
        model: RawModel,
        devices: &[WorldDevice],
        known: Actuation<f64>,
    ) -> WorldRender {
        if let Some(mass) = &model.device_mass_kg {
            self.places
                .take(WorldPart::Method, Field::DeviceMass, mass.clone());
        }
        let model_mass = model.device_mass_kg.as_ref();
        let masses = self.device_masses(model_mass, model.device_mass_factor.clone(), devices);
        let model_inertia = model.device_inertia_kg_m2.clone().map(|inertia| {
            self.places
                .take(WorldPart::Method, Field::DeviceInertia, inertia.clone());
            let key = "device_inertia_kg_m2";
            self.numbers(key, inertia.span(), inertia.get_ref(), Range::Positive);
            inertia.into_inner()
        });
        let inertia = devices.iter().map(|device| {
            let turning = device.turning.as_ref();
            turning.map(|turning| model_inertia.unwrap_or(turning.inertia))
        });
        for (field, value) in [
            (Field::SpeedLimit, &raw.speed_limit_m_per_s),
            (Field::LargestGap, &raw.largest_gap_s),
        ] {
            if let Some(value) = value {
                self.places.take(WorldPart::Loop, field, value.clone());
            }
        }
        let mut positive = |key: &str, value: Option<Spanned<f64>>| {
            value.map(|value| self.number(key, value, Range::Positive))
        };
        let torque_limit = positive("torque_limit_n_m", raw.torque_limit_n_m);
        let force_limit = positive("force_limit_n", raw.force_limit_n);
        let speed_limit = positive("speed_limit_m_per_s", raw.speed_limit_m_per_s);
        let largest_gap = positive("largest_gap_s", raw.largest_gap_s);
        WorldRender {
            method: raw.method.map_or_else(
                || "coupled".into(),
                |method| self.places.take(WorldPart::Method, Field::Method, method),
            ),
            device_mass: masses,
            device_inertia: inertia.collect(),
            sensor_quantum: self.sensor_quantum(&model, devices),
            settings: HashMap::new(),
            speed_limit,
            largest_gap,
            torque_limit,
            force_limit,
            actuation: self.actuation(&model, known),
            guard: raw
                .guard
                .map_or(WorldGuard::Off, |guard| self.guard(guard, devices)),
        }
    }

    /// Returns the model value of the position quantum `[m]`, if the model has one or has noise.
    fn sensor_quantum(&mut self, model: &RawModel, devices: &[WorldDevice]) -> Option<f64> {
        let mut given = |key: &str, value: &Option<Spanned<f64>>| {
            let value = value.clone()?;
            Some(self.number(key, value, Range::NotNegative))
        };
        let quantum = given("sensor_quantum_m", &model.sensor_quantum_m);
        let noise = given("sensor_noise_m", &model.sensor_noise_m);
        let Some(noise) = noise else {
            return quantum;
        };
        let own = devices.iter().flat_map(|device| device.quantum);
        let quantum = quantum.unwrap_or(own.fold(0.0, f64::max));
        Some(quantum_of(noise).max(quantum))
    }

    /// Returns the model of the actuators: that of the file, by default `known`.
    fn actuation(&mut self, model: &RawModel, known: Actuation<f64>) -> Actuation<f64> {
        let mut or = |key: &str, value: &Option<Spanned<f64>>, known: f64, range| {
            let value = value.clone();
            value.map_or(known, |value| self.number(key, value, range))
        };
        let least = Range::NotNegative;
        let deviations = ["delay_deviation_s", "lag_deviation_s", "gain_deviation"];
        Actuation {
            delay: or("delay_s", &model.delay_s, known.delay, least),
            lag: or("lag_s", &model.lag_s, known.lag, least),
            gain: or("gain", &model.gain, known.gain, Range::Positive),
            delay_deviation: or(deviations[0], &model.delay_deviation_s, 0.0, least),
            lag_deviation: or(deviations[1], &model.lag_deviation_s, 0.0, least),
            gain_deviation: or(deviations[2], &model.gain_deviation, 0.0, least),
            ..known
        }
    }

    /// Returns the settings of the methods of worlds, by their names.
    pub(super) fn settings(
        &mut self,
        raw: &HashMap<Spanned<String>, RawSettings>,
    ) -> HashMap<&'static str, WorldSettings> {
        let mut settings = HashMap::new();
        for (name, given) in raw {
            let mut known = WorldScene::METHODS.into_iter();
            match known.find(|known| known == name.get_ref()) {
                Some(method) => {
                    settings.insert(method, self.settings_of(method, given));
                }
                // Without the other faults, the closed form might render the scene.
                None if method_named(name.get_ref()).is_ok() && !self.damaged.is_empty() => {}
                None => self.fault(name.span(), not_of_worlds(name.get_ref())),
            }
        }
        settings
    }

    fn settings_of(&mut self, method: &str, given: &RawSettings) -> WorldSettings {
        let mut settings = WorldSettings::default();
        for (key, value) in &given.0 {
            let Some(setting) = SETTINGS.iter().find(|setting| setting.key == key.get_ref()) else {
                // Without the other faults, the closed form might render the scene.
                if !self.damaged.is_empty() && method_named(method).is_ok() {
                    continue;
                }
                let known = SETTINGS.map(|setting| setting.key);
                self.fault(key.span(), unknown_key(key.get_ref(), &known));
                continue;
            };
            if !setting.methods.contains(&method) {
                let users = setting.methods.join(", ");
                let message = format!("{method} does not use {}; it is for {users}", setting.key);
                self.fault(key.span(), message);
                continue;
            }
            match value.get_ref().number() {
                Some(number) => {
                    let place = Spanned::new(value.span(), number);
                    if setting.key == "damping_n_s_per_m" {
                        self.places
                            .take(WorldPart::Method, Field::Damping, place.clone());
                    }
                    let number = self.number(setting.key, place, setting.range);
                    *(setting.field)(&mut settings) = Some(number);
                }
                None => {
                    let message = format!("{} needs a number", setting.key);
                    self.fault(value.span(), message);
                }
            }
        }
        settings
    }

    /// Returns the mass of each device in the model, along each axis `[kg]`: the device's own or `model_mass`, times
    /// the factor.
    fn device_masses(
        &mut self,
        model_mass: Option<&Spanned<PerAxis>>,
        factor: Option<Spanned<f64>>,
        devices: &[WorldDevice],
    ) -> Vec<Vector> {
        // Values along the axes of each device.
        let mut masses: Vec<_> = devices.iter().map(|device| device.mass).collect();
        for (number, mass) in masses.iter_mut().enumerate() {
            if let Some(model) = model_mass {
                let axes = self
                    .has_its_axes(number)
                    .then_some(mass.map(f64::is_finite));
                *mass = self.per_axis(
                    "device_mass_kg",
                    model,
                    Range::Positive,
                    (axes, f64::INFINITY),
                );
            }
        }
        if let Some(factor) = factor {
            if model_mass.is_some() {
                let message = "give either device_mass_kg or device_mass_factor, not both";
                self.fault(factor.span(), message);
            }
            let factor = self.number("device_mass_factor", factor, Range::Positive);
            for mass in masses.iter_mut().flatten() {
                *mass *= factor;
            }
        }
        masses
    }
}

/// A setting of a method of worlds.
struct WorldSetting {
    key: &'static str,
    range: Range,
    /// The methods that use it.
    methods: &'static [&'static str],
    field: fn(&mut WorldSettings) -> &mut Option<f64>,
}

const DAMPER: &str = "virtual-damper";
const COUPLING: &str = "virtual-coupling";
const GOD_OBJECT: &str = "god-object";
const HFCR: &str = "hfcr";
const POPC: [&str; 2] = ["popc", "popc-ref"];

const SETTINGS: [WorldSetting; 9] = [
    WorldSetting {
        key: "damping_n_s_per_m",
        range: Range::NotNegative,
        methods: &[DAMPER, HFCR, COUPLING, GOD_OBJECT],
        field: |settings| &mut settings.damping,
    },
    WorldSetting {
        key: "rotational_damping_n_m_s_per_rad",
        range: Range::NotNegative,
        methods: &[DAMPER, COUPLING],
        field: |settings| &mut settings.rotational_damping,
    },
    WorldSetting {
        key: "coupling_stiffness_n_per_m",
        range: Range::Positive,
        methods: &[COUPLING, GOD_OBJECT],
        field: |settings| &mut settings.coupling.stiffness,
    },
    WorldSetting {
        key: "coupling_mass_kg",
        range: Range::Positive,
        methods: &[COUPLING],
        field: |settings| &mut settings.coupling.mass,
    },
    WorldSetting {
        key: "coupling_rotational_stiffness_n_m_per_rad",
        range: Range::Positive,
        methods: &[COUPLING],
        field: |settings| &mut settings.coupling.rotational_stiffness,
    },
    WorldSetting {
        key: "coupling_inertia_kg_m2",
        range: Range::Positive,
        methods: &[COUPLING],
        field: |settings| &mut settings.coupling.inertia,
    },
    WorldSetting {
        key: "damping_cap_n_s_per_m",
        range: Range::Positive,
        methods: &POPC,
        field: |settings| &mut settings.damping_cap,
    },
    WorldSetting {
        key: "speed_threshold_m_per_s",
        range: Range::NotNegative,
        methods: &POPC,
        field: |settings| &mut settings.speed_threshold,
    },
    WorldSetting {
        key: "initial_energy_j",
        range: Range::NotNegative,
        methods: &[POPC[0]],
        field: |settings| &mut settings.initial_energy,
    },
];

/// Returns the error message for a name of a method that cannot render worlds.
fn not_of_worlds(name: &str) -> String {
    if method_named(name).is_ok() {
        return format!("{name} renders one contact along one axis; this scene is a world");
    }
    let all = WorldScene::METHODS;
    let meant = nearest(name, &all);
    let meant = meant.map_or_else(|| ".".into(), |near| format!(", did you mean {near}?"));
    format!(
        "there is no method {name:?} for worlds{meant} Known here: {}",
        all.join(", ")
    )
}
