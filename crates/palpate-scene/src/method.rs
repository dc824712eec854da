//! Methods by name, and the settings each of them takes.

use serde::Deserialize;
use serde::de::{Deserializer, Error as _, MapAccess, Unexpected, Visitor};

pub use palpate_core::{
    Basis, MethodName, PredictionName, Setting, SettingKey, SettingValues, Settings, SettingsError,
};
use palpate_core::{ParameterValue, Unit, all_settings};

/// A name that no method has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no method is called \"{name}\"; {}", suggestion(.name))]
pub struct UnknownMethod {
    /// The name that was given.
    pub name: String,
}

fn suggestion(name: &str) -> String {
    let all = MethodName::ALL.map(MethodName::name);
    match nearest(name, &all) {
        Some(near) => format!("did you mean \"{near}\"?"),
        None => format!("the methods are {}", all.join(", ")),
    }
}

/// The candidate that `name` most likely meant, if any is near.
#[must_use]
pub fn nearest<'a>(name: &str, candidates: &[&'a str]) -> Option<&'a str> {
    candidates
        .iter()
        .map(|candidate| (strsim::jaro_winkler(name, candidate), *candidate))
        .filter(|(similarity, _)| *similarity > 0.8)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}

/// The method that is called `name`.
///
/// # Errors
/// No method is: the nearest name, or all of them.
pub fn method_named(name: &str) -> Result<MethodName, UnknownMethod> {
    MethodName::named(name).ok_or_else(|| UnknownMethod { name: name.into() })
}

/// Reads the name of a method.
///
/// # Errors
/// Those of [`method_named`], or the value is not a string.
pub fn deserialize_method<'de, D: Deserializer<'de>>(from: D) -> Result<MethodName, D::Error> {
    method_named(&String::deserialize(from)?).map_err(D::Error::custom)
}

/// Reads settings under their keys, such as those in the table `[methods.hfcr]` of a scene.
///
/// # Errors
/// A key that no method has; a value that no method takes under that key.
pub fn deserialize_settings<'de, D: Deserializer<'de>>(from: D) -> Result<Settings, D::Error> {
    from.deserialize_map(Keys)
}

/// The keys of settings, each with its value.
struct Keys;

impl<'de> Visitor<'de> for Keys {
    type Value = Settings;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("settings of a method")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Settings, A::Error> {
        let mut given = Settings::default();
        while let Some(Key(key)) = map.next_key()? {
            given.set(key, Some(map.next_value_seed(Value(key))?));
        }
        Ok(given)
    }
}

/// The key of a setting that some method has.
struct Key(SettingKey);

impl<'de> Deserialize<'de> for Key {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let given = String::deserialize(from)?;
        let mut keys = all_settings().map(|setting| setting.key);
        keys.find(|key| key.as_str() == given)
            .map(Self)
            .ok_or_else(|| {
                let known: Vec<_> = all_settings()
                    .map(|setting| format!("`{}`", setting.key))
                    .collect();
                let known = known.join(", ");
                // Same wording as the deserialiser's message for other tables.
                D::Error::custom(format!("unknown field `{given}`, expected one of {known}"))
            })
    }
}

/// The value of a setting: anything that some method takes under its key.
pub(crate) struct Value(pub SettingKey);

impl Value {
    /// The setting, as each method that has it takes it.
    fn settings(&self) -> impl Iterator<Item = &'static Setting> {
        let key = self.0;
        MethodName::ALL
            .into_iter()
            .filter_map(move |method| method.setting(key))
    }

    fn number<E: serde::de::Error>(
        &self,
        value: f64,
        given: Unexpected<'_>,
    ) -> Result<ParameterValue<f64>, E> {
        if self.settings().any(|setting| setting.unit().is_some()) {
            Ok(ParameterValue::Number(value))
        } else {
            Err(E::invalid_type(given, self))
        }
    }
}

impl<'de> serde::de::DeserializeSeed<'de> for Value {
    type Value = ParameterValue<f64>;

    fn deserialize<D: Deserializer<'de>>(self, from: D) -> Result<Self::Value, D::Error> {
        from.deserialize_any(self)
    }
}

impl Visitor<'_> for Value {
    type Value = ParameterValue<f64>;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Some(setting) = self.settings().next() else {
            return f.write_str("the value of a setting");
        };
        match setting.values {
            SettingValues::Number { unit, .. } | SettingValues::NumberOrWord { unit, .. } => {
                f.write_str("a number")?;
                if unit != Unit::One {
                    write!(f, " in {}", unit.symbol())?;
                }
                // The words of every method with this key.
                for word in self.settings().flat_map(Setting::words) {
                    write!(f, " or \"{word}\"")?;
                }
                Ok(())
            }
            SettingValues::Words { words, .. } => {
                write!(f, "one of \"{}\"", words.join("\", \""))
            }
            SettingValues::Switch => f.write_str("true or false"),
        }
    }

    fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<Self::Value, E> {
        self.number(value, Unexpected::Float(value))
    }

    fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<Self::Value, E> {
        #[expect(
            clippy::cast_precision_loss,
            reason = "a whole number of a file, as a number"
        )]
        self.number(value as f64, Unexpected::Signed(value))
    }

    fn visit_str<E: serde::de::Error>(self, value: &str) -> Result<Self::Value, E> {
        self.settings()
            .find_map(|setting| setting.word(value))
            .ok_or_else(|| {
                let words = self.settings().find_map(|setting| match setting.values {
                    SettingValues::Words { words, .. } => Some(words),
                    _ => None,
                });
                match words {
                    Some(words) => E::unknown_variant(value, words),
                    None => E::invalid_value(Unexpected::Str(value), &self),
                }
            })
    }

    fn visit_bool<E: serde::de::Error>(self, value: bool) -> Result<Self::Value, E> {
        let is_switch = |setting: &Setting| setting.values == SettingValues::Switch;
        if self.settings().any(is_switch) {
            Ok(ParameterValue::Switch(value))
        } else {
            Err(E::invalid_type(Unexpected::Bool(value), &self))
        }
    }
}
