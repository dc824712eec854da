//! Settings of a session that a page can change.

use palpate_core::{LARGEST_DELAY, Mass, MethodParams as _, Parameter, ParameterValue, Side};
use palpate_rt::Rendering;
use palpate_scene::method::{MethodName, SettingKey};
use palpate_scene::named_parameters::named_parameters;
use palpate_scene::{Model, Scene, SceneParameter, SceneParameterError, SetupError};
use serde::Serialize;

use crate::message::{LaneChoice, ModelState, Set};

/// Limits of the settings: the least and the greatest value of each.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Limits {
    /// Stiffness `[N/m]`.
    pub stiffness_n_per_m: [f64; 2],
    /// Mass `[kg]`.
    pub mass_kg: [f64; 2],
    /// Virtual force `[N]`.
    pub virtual_force_n: [f64; 2],
    /// Period `[s]`.
    pub period_s: [f64; 2],
    /// Damping of a method `[N s/m]`.
    pub damping_n_s_per_m: [f64; 2],
    /// Model value of the device mass `[kg]`.
    pub model_device_mass_kg: [f64; 2],
    /// Model value of the delay `[s]`; at most the largest number of periods that a renderer supports.
    pub model_delay_s: [f64; 2],
    /// Model value of the lag `[s]`.
    pub model_lag_s: [f64; 2],
    /// Model value of the gain.
    pub model_gain: [f64; 2],
}

impl Limits {
    /// Returns limits for a desktop device and a hand, extended to contain `settings` and `scene`.
    #[must_use]
    pub fn around(settings: &Settings, scene: &Scene) -> Self {
        let model = settings.model(scene);
        let with = |[least, most]: [f64; 2], value: f64| [least.min(value), most.max(value)];
        let dampings = settings.lanes.iter();
        Self {
            stiffness_n_per_m: with([10.0, 10_000.0], settings.stiffness),
            mass_kg: with([0.005, 5.0], settings.mass.unwrap_or(1.0)),
            virtual_force_n: with([-10.0, 10.0], settings.virtual_force),
            period_s: with([0.000_25, 0.05], settings.period),
            damping_n_s_per_m: dampings
                .filter_map(|lane| lane.damping_n_s_per_m)
                .fold([0.0, 50.0], with),
            model_device_mass_kg: with([0.01, 5.0], model.model_device_mass_kg),
            model_delay_s: with([0.0, 0.02], model.model_delay_s),
            model_lag_s: with([0.0, 0.02], model.model_lag_s),
            model_gain: with([0.2, 2.0], model.model_gain),
        }
    }
}

/// Settings of a session.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Stiffness `[N/m]`.
    pub stiffness: f64,
    /// Mass of the object `[kg]`; none is a wall.
    pub mass: Option<f64>,
    /// Virtual force on the object `[N]`.
    pub virtual_force: f64,
    /// Period of the loop `[s]`.
    pub period: f64,
    /// Model value of the device mass `[kg]`; `None`: as in the scene.
    pub model_device_mass: Option<f64>,
    /// Model values of delay, lag and gain, if they differ from the scene.
    pub model: Model,
    /// Methods, one for each rendering.
    pub lanes: Vec<LaneChoice>,
}

impl Settings {
    /// Returns the settings of `scene` with `methods`, one for each rendering.
    #[must_use]
    pub fn new(scene: &Scene, methods: &[MethodName]) -> Self {
        Self {
            stiffness: scene.contact.stiffness,
            mass: match scene.contact.object_mass {
                Mass::Finite(mass) => Some(mass),
                Mass::Infinite => None,
            },
            virtual_force: scene.virtual_force,
            period: scene.loop_params.period,
            model_device_mass: None,
            model: Model::default(),
            lanes: methods
                .iter()
                .map(|method| LaneChoice {
                    method: *method,
                    damping_n_s_per_m: damping(scene, *method),
                })
                .collect(),
        }
    }

    /// Returns these settings with the changes of `set`.
    ///
    /// # Errors
    /// A value is outside its limits, a method takes no damping, or there are more renderings than the device supports.
    /// The message states the allowed values.
    pub fn with(&self, set: &Set, limits: &Limits, most_lanes: usize) -> Result<Self, String> {
        let mut new = self.clone();
        if let Some(value) = set.stiffness_n_per_m {
            new.stiffness = inside("stiffness_n_per_m", value, limits.stiffness_n_per_m)?;
        }
        if let Some(mass) = set.mass_kg {
            new.mass = mass
                .map(|mass| inside("mass_kg", mass, limits.mass_kg))
                .transpose()?;
        }
        if let Some(value) = set.virtual_force_n {
            new.virtual_force = inside("virtual_force_n", value, limits.virtual_force_n)?;
        }
        if let Some(value) = set.period_s {
            new.period = inside("period_s", value, limits.period_s)?;
        }
        if let Some(value) = set.model_device_mass_kg {
            let limits = limits.model_device_mass_kg;
            new.model_device_mass = Some(inside("model_device_mass_kg", value, limits)?);
        }
        if let Some(value) = set.model_delay_s {
            let [least, most] = limits.model_delay_s;
            let most = most.min(LARGEST_DELAY as f64 * new.period);
            new.model.delay = Some(inside("model_delay_s", value, [least, most])?);
        }
        if let Some(value) = set.model_lag_s {
            new.model.lag = Some(inside("model_lag_s", value, limits.model_lag_s)?);
        }
        if let Some(value) = set.model_gain {
            new.model.gain = Some(inside("model_gain", value, limits.model_gain)?);
        }
        if let Some(lanes) = &set.lanes {
            check_lanes(lanes.len(), most_lanes)?;
            for lane in lanes {
                if let Some(value) = lane.damping_n_s_per_m {
                    if !lane.method.uses(SettingKey::DAMPING) {
                        return Err(format!(
                            "{} has no damping; allowed: null",
                            lane.method.name()
                        ));
                    }
                    inside("damping_n_s_per_m", value, limits.damping_n_s_per_m)?;
                }
            }
            new.lanes.clone_from(lanes);
        }
        Ok(new)
    }

    /// Returns the model values of the device for the renderer of `scene`.
    #[must_use]
    pub fn model(&self, scene: &Scene) -> ModelState {
        let mut scene = scene.clone();
        scene.loop_params.period = self.period;
        self.tell(&mut scene);
        let model = scene.model_actuation();
        ModelState {
            model_device_mass_kg: scene.model_device_mass.unwrap_or(scene.device.mass()),
            model_delay_s: model.delay,
            model_lag_s: model.lag,
            model_gain: model.gain,
        }
    }

    fn tell(&self, scene: &mut Scene) {
        scene.model_device_mass = self.model_device_mass.or(scene.model_device_mass);
        scene.model.delay = self.model.delay.or(scene.model.delay);
        scene.model.lag = self.model.lag.or(scene.model.lag);
        scene.model.gain = self.model.gain.or(scene.model.gain);
    }

    /// Returns `scene` with the settings of a rendering.
    #[must_use]
    pub fn scene(&self, scene: &Scene, lane: LaneChoice) -> Scene {
        let mut scene = scene.clone();
        self.tell(&mut scene);
        scene.contact.stiffness = self.stiffness;
        scene.contact.object_mass = self.mass.map_or(Mass::Infinite, Mass::Finite);
        if self.mass.is_none() {
            scene.object.velocity = 0.0;
        }
        scene.virtual_force = self.virtual_force;
        scene.loop_params.period = self.period;
        scene.method = lane.method;
        if lane.method.uses(SettingKey::DAMPING) {
            let settings = scene.settings.entry(lane.method).or_default();
            let damping = lane.damping_n_s_per_m.map(ParameterValue::Number);
            settings.set(SettingKey::DAMPING, damping);
        }
        scene
    }

    /// Returns the renderings.
    ///
    /// # Errors
    /// A message if the renderer rejects the settings.
    pub fn renderings(&self, scene: &Scene) -> Result<Vec<Rendering>, String> {
        self.lanes
            .iter()
            .map(|lane| {
                let scene = self.scene(scene, *lane);
                scene.check().map_err(|error| by_field(&error))?;
                scene.rendering(lane.method).map_err(|error| match error {
                    SetupError::Parameter(error) => by_field(&error),
                    SetupError::Settings(error) => error.to_string(),
                    SetupError::HoldsConstant(_) => error.to_string(),
                })
            })
            .collect()
    }
}

/// Describes a parameter that is out of range by its field on the page.
fn by_field(error: &SceneParameterError) -> String {
    let SceneParameter::Rendered(parameter) = error.parameter else {
        return error.to_string();
    };
    let field = match parameter {
        Parameter::Stiffness => "stiffness_n_per_m",
        Parameter::ObjectMass => "mass_kg",
        Parameter::VirtualForce => "virtual_force_n",
        Parameter::Period => "period_s",
        Parameter::Setting(setting) => setting.key.as_str(),
        // No field of the page: the scene's.
        _ => return error.to_string(),
    };
    error.called(field).to_string()
}

/// Returns the damping of `method` in `scene`; a derived value is returned as the resulting damping.
fn damping(scene: &Scene, method: MethodName) -> Option<f64> {
    if !scene.settings.get(&method)?.has(SettingKey::DAMPING) {
        return None;
    }
    let renderer = scene.renderer(method).ok()?;
    let derived = scene.params(method).ok()?.derived(renderer.method());
    let key = SettingKey::DAMPING.as_str();
    named_parameters(&derived)
        .into_iter()
        .find_map(|(name, value)| match value {
            ParameterValue::Number(number) if name == key => Some(number),
            _ => None,
        })
}

/// Checks whether a device that supports `most` renderings can have `lanes` of them.
///
/// # Errors
/// A message if it cannot.
pub fn check_lanes(lanes: usize, most: usize) -> Result<(), String> {
    let allowed = match most {
        _ if (1..=most).contains(&lanes) => return Ok(()),
        1 => "1: this device can be in one loop only",
        _ => "1 or 2",
    };
    Err(format!("{lanes} lanes; allowed: {allowed}"))
}

/// An object that would begin inside the device begins where the two touch. A wall stays. `device`: where the
/// device is `[m]`.
pub fn make_room(rendering: &mut Rendering, device: f64) {
    if rendering.contact.object_mass == Mass::Infinite {
        return;
    }
    let place = &mut rendering.object.position;
    *place = match rendering.contact.side {
        Side::Positive => place.max(device),
        Side::Negative => place.min(device),
    };
}

fn inside(name: &str, value: f64, [least, most]: [f64; 2]) -> Result<f64, String> {
    if (least..=most).contains(&value) {
        Ok(value)
    } else {
        let value = written(value);
        Err(format!("{name} is {value}; allowed: {least} to {most}"))
    }
}

/// A number for a message, with an exponent where it would be mostly zeros.
pub(crate) fn written(value: f64) -> String {
    if value == 0.0 || (1e-5..1e7).contains(&value.abs()) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

#[cfg(test)]
mod tests {
    use palpate_scene::ContactFile;

    use super::*;

    fn scene() -> Scene {
        let text = include_str!("../../../experiments/fig2.toml");
        ContactFile::parse("fig2.toml", text).unwrap().scene
    }

    #[test]
    fn what_is_set_is_rendered_and_the_rest_stays() {
        let scene = scene();
        let before = Settings::new(&scene, &[MethodName::Hfcr, MethodName::Basic]);
        assert_eq!(before.lanes[0].damping_n_s_per_m, Some(0.01));
        let limits = Limits::around(&before, &scene);
        let set = Set {
            stiffness_n_per_m: Some(250.0),
            mass_kg: Some(None),
            ..Set::default()
        };
        let after = before.with(&set, &limits, 2).unwrap();
        let renderings = after.renderings(&scene).unwrap();
        assert_eq!(renderings.len(), 2);
        for rendering in renderings {
            assert_eq!(rendering.contact.stiffness, 250.0);
            assert_eq!(rendering.contact.object_mass, Mass::Infinite);
            assert_eq!(rendering.virtual_force, scene.virtual_force);
        }
        // A rendering without a given damping uses that of the method, not of the file.
        let set = Set {
            lanes: Some(vec![LaneChoice {
                method: MethodName::Hfcr,
                damping_n_s_per_m: None,
            }]),
            ..Set::default()
        };
        let after = before.with(&set, &limits, 2).unwrap();
        let scene = after.scene(&scene, after.lanes[0]);
        assert_eq!(
            scene.settings[&MethodName::Hfcr].get(SettingKey::DAMPING),
            None
        );
    }

    #[test]
    fn model_values_change_the_rendering_and_not_the_device() {
        let scene = scene();
        let before = Settings::new(&scene, &[MethodName::Coupled]);
        let limits = Limits::around(&before, &scene);
        let as_it_is = ModelState {
            model_device_mass_kg: 0.1,
            model_delay_s: 0.0,
            model_lag_s: 0.0,
            model_gain: 1.0,
        };
        assert_eq!(before.model(&scene), as_it_is);
        let set = Set {
            model_device_mass_kg: Some(0.2),
            model_delay_s: Some(0.005),
            model_lag_s: Some(0.001),
            model_gain: Some(0.9),
            ..Set::default()
        };
        let after = before.with(&set, &limits, 2).unwrap();
        let lane = after.scene(&scene, after.lanes[0]);
        assert_eq!((lane.device.mass(), lane.actuator.gain), (0.1, 1.0));
        let model = after.renderings(&scene).unwrap()[0].loop_params.actuation;
        assert_eq!((model.delay, model.lag, model.gain), (0.005, 0.001, 0.9));
        assert_eq!(after.model(&scene).model_device_mass_kg, 0.2);
        // The longest model delay is eight periods.
        let late = Set {
            period_s: Some(0.001),
            model_delay_s: Some(0.009),
            ..Set::default()
        };
        assert_eq!(
            before.with(&late, &limits, 2).unwrap_err(),
            "model_delay_s is 0.009; allowed: 0 to 0.008"
        );
    }

    #[test]
    fn what_cannot_be_is_refused_with_what_is_allowed() {
        let scene = scene();
        let before = Settings::new(&scene, &[MethodName::Coupled]);
        let limits = Limits::around(&before, &scene);
        let refused = |set: Set, most| before.with(&set, &limits, most).unwrap_err();
        let lanes = |lanes: &[(MethodName, Option<f64>)]| Set {
            lanes: Some(
                lanes
                    .iter()
                    .map(|(method, damping)| LaneChoice {
                        method: *method,
                        damping_n_s_per_m: *damping,
                    })
                    .collect(),
            ),
            ..Set::default()
        };
        let coupled = (MethodName::Coupled, None);
        assert_eq!(
            refused(
                Set {
                    period_s: Some(1.0),
                    ..Set::default()
                },
                2
            ),
            "period_s is 1; allowed: 0.00025 to 0.05"
        );
        assert_eq!(
            refused(
                Set {
                    stiffness_n_per_m: Some(1e300),
                    ..Set::default()
                },
                2
            ),
            "stiffness_n_per_m is 1e300; allowed: 10 to 10000"
        );
        assert_eq!(
            refused(lanes(&[coupled, coupled]), 1),
            "2 lanes; allowed: 1: this device can be in one loop only"
        );
        assert_eq!(refused(lanes(&[]), 2), "0 lanes; allowed: 1 or 2");
        assert_eq!(
            refused(lanes(&[(MethodName::Basic, Some(1.0))]), 2),
            "basic has no damping; allowed: null"
        );
        assert_eq!(
            refused(lanes(&[(MethodName::Hfcr, Some(-1.0))]), 2),
            "damping_n_s_per_m is -1; allowed: 0 to 50"
        );
    }

    #[test]
    fn invalid_settings_are_reported_by_page_field() {
        let scene = scene();
        let model = |change: fn(&mut Settings)| {
            let mut settings = Settings::new(&scene, &[MethodName::Hfcr]);
            change(&mut settings);
            settings.renderings(&scene).unwrap_err()
        };
        for (change, message) in [
            (
                (|settings| settings.stiffness = -1.0) as fn(&mut Settings),
                "stiffness_n_per_m is -1 N/m, but must be finite and greater than 0",
            ),
            (
                |settings| settings.mass = Some(0.0),
                "mass_kg is 0 kg, but must be finite and greater than 0",
            ),
            (
                |settings| settings.virtual_force = f64::INFINITY,
                "virtual_force_n is inf N, but must be finite",
            ),
            (
                |settings| settings.period = 0.0,
                "period_s is 0 s, but must be finite and greater than 0",
            ),
            (
                |settings| settings.lanes[0].damping_n_s_per_m = Some(-1.0),
                "damping_n_s_per_m is -1 N s/m, but must be finite and not below 0",
            ),
        ] {
            assert_eq!(model(change), message);
        }
    }
}
