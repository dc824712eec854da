//! `set NAME=VALUE ...`: changes while the pipe runs.

use std::fmt;

use palpate_core::{Contact, Parameter};
use palpate_rt::{ChangeError, Parameters, Rendering};
use palpate_scene::method::{MethodName, SettingKey, Settings, nearest};
use palpate_scene::{SceneParameter, SceneParameterError, SetupError, check_sizes};
use palpate_study::sim::replay::ReplaySetup;

use palpate_study::text::exactly;

/// Names of the parameters that can be set.
const NAMES: [&str; 4] = [
    "stiffness_n_per_m",
    "mass_kg",
    "virtual_force_n",
    SettingKey::DAMPING.as_str(),
];

/// New values; `None` for unchanged parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change {
    /// Stiffness `[N/m]`.
    stiffness: Option<f64>,
    /// Mass of the object `[kg]`; infinite: a wall.
    mass: Option<f64>,
    /// Virtual force on the object `[N]`.
    virtual_force: Option<f64>,
    /// Damping of the method: B of the virtual damper, b of HFCR `[N s/m]`.
    damping: Option<f64>,
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let values = [self.stiffness, self.mass, self.virtual_force, self.damping];
        let set: Vec<_> = NAMES
            .iter()
            .zip(values)
            .filter_map(|(name, value)| value.map(|value| format!("{name}={}", exactly(value))))
            .collect();
        f.write_str(&set.join(" "))
    }
}

impl TryFrom<&[&str]> for Change {
    type Error = String;

    /// Parses the words after `set`.
    fn try_from(words: &[&str]) -> Result<Self, String> {
        if words.is_empty() {
            return Err(format!("`set` has no values; {}", allowed()));
        }
        let mut change = Self::default();
        for word in words {
            let Some((name, text)) = word.split_once('=') else {
                return Err(format!(
                    "\"{}\" is not NAME=VALUE; {}",
                    word.escape_debug(),
                    allowed()
                ));
            };
            let value = match name {
                "stiffness_n_per_m" => &mut change.stiffness,
                "mass_kg" => &mut change.mass,
                "virtual_force_n" => &mut change.virtual_force,
                "damping_n_s_per_m" => &mut change.damping,
                _ => {
                    let near = nearest(name, &NAMES)
                        .map(|near| format!("did you mean {near}? "))
                        .unwrap_or_default();
                    let name = name.escape_debug();
                    return Err(format!("unknown name \"{name}\"; {near}{}", allowed()));
                }
            };
            if value.is_some() {
                return Err(format!("{name} is set twice"));
            }
            *value = Some(text.parse().map_err(|_| {
                format!(
                    "{name} is \"{}\", but must be a number, such as 800 or 1e-2",
                    text.escape_debug()
                )
            })?);
        }
        Ok(change)
    }
}

fn allowed() -> String {
    format!("allowed: `set NAME=VALUE ...` of {}", NAMES.join(", "))
}

/// Current rendering of the pipe, for changing it.
#[derive(Debug)]
pub struct Changeable {
    /// Sending end of the renderer's parameters.
    pub parameters: Parameters,
    /// Current contact, loop and object.
    pub setup: ReplaySetup,
    /// The method, which does not change.
    pub method: MethodName,
    /// Its settings, of which a line can change the damping.
    pub settings: Settings,
}

impl Changeable {
    /// Renders with the new values from the next sample on. They are reached over a tenth of a second.
    ///
    /// # Errors
    /// A value is outside its range, reported by its name. Nothing changes.
    pub fn make(&mut self, change: &Change) -> Result<(), String> {
        let mut setup = self.setup;
        let contact = &mut setup.contact;
        contact.stiffness = change.stiffness.unwrap_or(contact.stiffness);
        if let Some(mass) = change.mass {
            contact.object_mass = Contact::object(contact.stiffness, mass).object_mass;
        }
        if let Some(force) = change.virtual_force {
            if !force.is_finite() {
                return Err(format!("virtual_force_n is {force} N, but must be finite"));
            }
            setup.virtual_force = force;
        }
        let mut settings = self.settings;
        if let Some(damping) = change.damping {
            if !self.method.uses(SettingKey::DAMPING) {
                let users = SettingKey::DAMPING.users();
                return Err(format!(
                    "{} is for {users}, not for {}",
                    SettingKey::DAMPING,
                    self.method
                ));
            }
            settings = settings.with(SettingKey::DAMPING, damping);
        }
        check_sizes(&setup.contact, setup.loop_params.period).map_err(|error| named(&error))?;
        let rendering =
            rendering(&setup, self.method, &settings).map_err(|error| in_words(&error))?;
        self.parameters
            .change(rendering)
            .map_err(|error| match error {
                ChangeError::Parameter(error) => named(&error.map(SceneParameter::Rendered)),
                other => other.to_string(),
            })?;
        self.setup = setup;
        self.settings = settings;
        Ok(())
    }
}

/// Creates a rendering by `method`.
///
/// # Errors
/// A setting is invalid for the method.
pub fn rendering(
    setup: &ReplaySetup,
    method: MethodName,
    settings: &Settings,
) -> Result<Rendering, SetupError> {
    Ok(Rendering {
        contact: setup.contact,
        loop_params: setup.known_loop(),
        // The first line contains the position of the device; until then the object is untouched.
        params: setup.params(method, settings, setup.object.position, false)?,
        virtual_force: setup.virtual_force,
        object: setup.object,
    })
}

fn in_words(error: &SetupError) -> String {
    match error {
        SetupError::Parameter(error) => named(error),
        SetupError::Settings(error) => error.to_string(),
        SetupError::HoldsConstant(_) => error.to_string(),
    }
}

/// Formats a parameter error with the name that sets the parameter.
fn named(error: &SceneParameterError) -> String {
    match error.parameter {
        SceneParameter::Rendered(Parameter::Stiffness) => error.called(NAMES[0]).to_string(),
        SceneParameter::Rendered(Parameter::ObjectMass) => error.called(NAMES[1]).to_string(),
        SceneParameter::Rendered(Parameter::Setting(setting)) => {
            error.called(setting.key.as_str()).to_string()
        }
        _ => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Change, String> {
        let words: Vec<_> = text.split_whitespace().collect();
        Change::try_from(words.as_slice())
    }

    #[test]
    fn a_change_is_said_as_a_line_would_set_it() {
        for line in [
            "stiffness_n_per_m=800 mass_kg=inf virtual_force_n=-0.25 damping_n_s_per_m=0.5",
            "mass_kg=1e-300",
            "stiffness_n_per_m=1.5e300",
            "virtual_force_n=0",
        ] {
            assert_eq!(read(line).unwrap().to_string(), line);
        }
    }

    #[test]
    fn several_values_are_read_at_once() {
        let change = read("stiffness_n_per_m=800 mass_kg=inf").unwrap();
        assert_eq!(change.stiffness, Some(800.0));
        assert_eq!(change.mass, Some(f64::INFINITY));
        assert_eq!(change.virtual_force, None);
    }

    #[test]
    fn what_cannot_be_set_is_answered_by_what_can() {
        for (text, said) in [
            ("", "`set` has no values"),
            ("stiffness_n_per_m", "not NAME=VALUE"),
            ("stiffness=800", "did you mean stiffness_n_per_m?"),
            ("damping=1", "did you mean damping_n_s_per_m?"),
            (
                "colour=3",
                "stiffness_n_per_m, mass_kg, virtual_force_n, damping_n_s_per_m",
            ),
            ("mass_kg=1 mass_kg=2", "set twice"),
            ("mass_kg=0,1", "mass_kg is \"0,1\", but must be a number"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
