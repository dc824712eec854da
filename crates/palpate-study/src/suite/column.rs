//! Compared methods or variants of them, each with settings.

use std::collections::HashMap;

use serde::Deserialize;

use palpate_core::{Guard, Hold};

use palpate_scene::method::{
    MethodName, SettingKey, Settings, SettingsError, deserialize_settings, method_named,
};
use palpate_scene::{GuardBounds, GuardConflict, GuardMode, Scene, SetupError, in_plain_words};

/// A method with settings and a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name in tables.
    pub name: String,
    /// The method.
    pub method: MethodName,
    /// Settings; a missing setting takes its default.
    pub settings: Settings,
    /// Candidate dampings that replace the damping of the settings: the best one on each scene is used, selected with
    /// knowledge of the ideal.
    pub dampings: Option<Dampings>,
    /// Guard that replaces the scene's guard.
    pub guard: Option<Guard<f64>>,
    /// Hold of the actuator that replaces the scene's hold.
    pub hold: Option<Hold>,
}

/// Values of a method's damping.
#[derive(Clone, Debug, PartialEq)]
pub enum Dampings {
    /// Dampings `[N s/m]`.
    Given(Vec<f64>),
    /// Dampings relative to the scene's stiffness times its period.
    OverImpedance(Vec<f64>),
}

impl Dampings {
    /// Returns the dampings on a scene `[N s/m]`.
    fn on(&self, scene: &Scene) -> Vec<f64> {
        match self {
            Self::Given(dampings) => dampings.clone(),
            Self::OverImpedance(ratios) => {
                let impedance = scene.contact.stiffness * scene.loop_params.period;
                ratios.iter().map(|ratio| ratio * impedance).collect()
            }
        }
    }
}

/// A fault in a file of columns.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ColumnError {
    /// The text is not TOML.
    #[error("{0}")]
    Syntax(String),
    /// A column is invalid.
    #[error("column {name}: {fault}")]
    Column {
        /// Name of the column.
        name: String,
        /// Fault, and the allowed values.
        fault: String,
    },
    /// There is no column.
    #[error("there is no column; add a table such as [my-variant] with method = \"hfcr\"")]
    None,
}

impl Column {
    /// Creates a column of a method with its defaults, under its own name.
    #[must_use]
    pub fn new(method: MethodName) -> Self {
        Self {
            name: method.name().into(),
            method,
            settings: Settings::default(),
            dampings: None,
            guard: None,
            hold: None,
        }
    }

    /// Returns the variants of `scene` for this column, one per candidate damping, each with that damping `[N s/m]`
    /// if there are candidates. The column uses the scene's value of every unset setting.
    pub(crate) fn candidates(&self, scene: &Scene) -> Vec<(Option<f64>, Scene)> {
        let with = |settings: Settings| {
            let mut varied = scene.clone();
            let loop_params = &mut varied.loop_params;
            loop_params.guard = self.guard.unwrap_or(loop_params.guard);
            loop_params.actuation.hold = self.hold.unwrap_or(loop_params.actuation.hold);
            let entry = varied.settings.entry(self.method).or_default();
            *entry = settings.or(*entry);
            varied
        };
        let Some(dampings) = &self.dampings else {
            return vec![(None, with(self.settings))];
        };
        let values = dampings.on(scene).into_iter();
        values
            .map(|value| {
                let settings = self.settings.with(SettingKey::DAMPING, value);
                (Some(value), with(settings))
            })
            .collect()
    }

    /// Reads columns from TOML. Each column is a table under its name, with a `method` and the keys that scenes have
    /// under `[methods.NAME]`. A list of dampings, or `damping_over_k_t` with one value or a list, can replace the
    /// damping; the best value of a list on each scene is used. `guard` has the keys of `[render]`, `hold` that of
    /// `[loop]`. The columns keep the order of the file.
    ///
    /// # Errors
    /// The text is not TOML, there is no column, a method is missing or unknown, or a key does not belong to the
    /// method.
    pub fn parse(text: &str) -> Result<Vec<Self>, ColumnError> {
        // Without spans, tables would be sorted by name.
        let tables: HashMap<toml::Spanned<String>, toml::Value> =
            toml::from_str(text).map_err(|error| ColumnError::Syntax(error.to_string()))?;
        let mut tables: Vec<_> = tables.into_iter().collect();
        tables.sort_by_key(|(name, _)| name.span().start);
        if tables.is_empty() {
            return Err(ColumnError::None);
        }
        tables
            .iter()
            .map(|(name, table)| Self::of_table(name.get_ref(), table))
            .collect()
    }

    fn of_table(name: &str, table: &toml::Value) -> Result<Self, ColumnError> {
        let wrong = |fault: String| ColumnError::Column {
            name: name.into(),
            fault,
        };
        let mut keys = table
            .as_table()
            .ok_or_else(|| wrong("a column must be a table".into()))?
            .clone();
        let method = keys
            .remove("method")
            .ok_or_else(|| wrong("it needs a method".into()))?;
        let method = method
            .as_str()
            .ok_or_else(|| wrong("its method must be a name in quotes".into()))?;
        let method = method_named(method).map_err(|error| wrong(error.to_string()))?;
        let dampings = dampings(&mut keys).map_err(wrong)?;
        if dampings.is_some() && !method.uses(SettingKey::DAMPING) {
            return Err(wrong(format!(
                "{method} has no damping; {} have",
                SettingKey::DAMPING.users()
            )));
        }
        let guard = keys
            .remove("guard")
            .map(RawGuard::deserialize)
            .transpose()
            .map_err(|error| wrong(format!("guard: {}", in_plain_words(error.message()))))?;
        let hold = keys
            .remove("hold")
            .map(Hold::deserialize)
            .transpose()
            .map_err(|error| wrong(format!("hold: {}", in_plain_words(error.message()))))?;
        if hold == Some(Hold::Line) && method != MethodName::Coupled {
            return Err(wrong(SetupError::HoldsConstant(method).to_string()));
        }
        let settings: Settings =
            deserialize_settings(keys).map_err(|error| wrong(in_plain_words(error.message())))?;
        if let Some(setting) = method.unused(&settings) {
            return Err(wrong(format!(
                "{}: {}; it is for {}",
                setting.key,
                SettingsError::Unused { method, setting },
                setting.key.users()
            )));
        }
        Ok(Self {
            name: name.into(),
            method,
            settings,
            dampings,
            guard: guard.map(RawGuard::guard).transpose().map_err(wrong)?,
            hold,
        })
    }
}

/// A guard in the format of scenes.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawGuard {
    mode: GuardMode,
    speed_m_per_s: Option<f64>,
    allowance_j: Option<f64>,
    acceleration_m_per_s2: Option<f64>,
    hand_force_n: Option<f64>,
    least_mass_kg: Option<f64>,
    #[serde(default)]
    learn_mass: bool,
    recovery_w: Option<f64>,
}

impl RawGuard {
    fn guard(self) -> Result<Guard<f64>, String> {
        let bounds = GuardBounds {
            speed: self.speed_m_per_s,
            allowance: self.allowance_j,
            acceleration: self.acceleration_m_per_s2,
            hand_force: self.hand_force_n,
            least_mass: self.least_mass_kg,
            learns_mass: self.learn_mass,
            recovery: self.recovery_w,
        };
        match bounds.conflict() {
            None => Ok(self.mode.guard(bounds)),
            Some(GuardConflict::MassAlone) => Err(
                "guard: least_mass_kg and learn_mass need acceleration_m_per_s2 or hand_force_n"
                    .into(),
            ),
            Some(GuardConflict::TwoLimits) => {
                Err("guard: hand_force_n excludes acceleration_m_per_s2; remove one".into())
            }
        }
    }
}

/// Removes the candidate dampings from the keys of a column and returns them.
fn dampings(keys: &mut toml::Table) -> Result<Option<Dampings>, String> {
    const GIVEN: &str = "damping_n_s_per_m";
    const RATIO: &str = "damping_over_k_t";
    if keys.contains_key(GIVEN) && keys.contains_key(RATIO) {
        return Err(format!(
            "{GIVEN} and {RATIO} both set its damping; keep one of them"
        ));
    }
    let numbers = |name: &str, values: &[toml::Value]| -> Result<Vec<f64>, String> {
        let number = |value: &toml::Value| {
            value
                .as_float()
                .or_else(|| value.as_integer().map(|whole| whole as f64))
                .filter(|number| number.is_finite() && *number >= 0.0)
        };
        let read: Option<Vec<f64>> = values.iter().map(number).collect();
        read.filter(|read| !read.is_empty()).ok_or_else(|| {
            format!("{name} must be a number or a list of numbers, finite and not below 0")
        })
    };
    match (keys.get(GIVEN), keys.get(RATIO)) {
        (Some(toml::Value::Array(values)), _) => {
            let values = numbers(GIVEN, values)?;
            keys.remove(GIVEN);
            Ok(Some(Dampings::Given(values)))
        }
        (_, Some(value)) => {
            let values = match value {
                toml::Value::Array(values) => numbers(RATIO, values),
                one => numbers(RATIO, std::slice::from_ref(one)),
            }?;
            keys.remove(RATIO);
            Ok(Some(Dampings::OverImpedance(values)))
        }
        // A single number is an ordinary setting.
        _ => Ok(None),
    }
}
