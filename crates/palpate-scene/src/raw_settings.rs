//! Table `[methods.NAME]` of a scene file. Which keys it may have depends on the renderer.

use std::collections::HashMap;
use std::fmt;
use std::ops::Range;

use palpate_core::{ParameterValue, SettingKey, Settings, all_settings};
use serde::Deserialize;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use toml::Spanned;

use crate::fault::{in_plain_words, unknown_key};
use crate::method::Value;
use crate::recover::Fault;
use crate::toml_reader::ReadError;

/// Settings of one method, in the order of the file.
pub(crate) struct RawSettings(pub Vec<(Spanned<String>, Spanned<RawSetting>)>);

/// Value of a setting.
#[derive(Clone, Debug)]
pub(crate) enum RawSetting {
    Integer(i64),
    Number(f64),
    Switch(bool),
    Word(String),
}

impl<'de> Deserialize<'de> for RawSettings {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Table;

        impl<'de> Visitor<'de> for Table {
            type Value = RawSettings;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("settings of a method")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<RawSettings, A::Error> {
                let mut settings = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    settings.push(entry);
                }
                Ok(RawSettings(settings))
            }
        }

        from.deserialize_map(Table)
    }
}

impl<'de> Deserialize<'de> for RawSetting {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Any;

        impl Visitor<'_> for Any {
            type Value = RawSetting;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, a word, true or false")
            }

            fn visit_i64<E: Error>(self, value: i64) -> Result<RawSetting, E> {
                Ok(RawSetting::Integer(value))
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<RawSetting, E> {
                Ok(RawSetting::Number(value))
            }

            fn visit_bool<E: Error>(self, value: bool) -> Result<RawSetting, E> {
                Ok(RawSetting::Switch(value))
            }

            fn visit_str<E: Error>(self, value: &str) -> Result<RawSetting, E> {
                Ok(RawSetting::Word(value.to_owned()))
            }
        }

        from.deserialize_any(Any)
    }
}

/// Source spans of a method's settings.
#[derive(Clone, Debug)]
pub(crate) struct MethodPlaces {
    pub name: Range<usize>,
    /// Key and value of each setting.
    pub settings: HashMap<String, (Range<usize>, Range<usize>)>,
}

impl RawSettings {
    /// Returns the settings of a method of one contact, with the fault of each key that no method has and of each value
    /// that no method takes.
    pub fn of_one_contact(&self) -> (Settings, Vec<Fault>) {
        let (mut settings, mut faults) = (Settings::default(), Vec::new());
        for (key, value) in &self.0 {
            let mut keys = all_settings().map(|setting| setting.key);
            let Some(known) = keys.find(|known| known.as_str() == key.get_ref()) else {
                let keys: Vec<_> = all_settings().map(|setting| setting.key.as_str()).collect();
                faults.push((key.span(), unknown_key(key.get_ref(), &keys)));
                continue;
            };
            match value.get_ref().of(known) {
                Ok(value) => settings.set(known, Some(value)),
                Err(error) => faults.push((value.span(), in_plain_words(error.message()))),
            }
        }
        (settings, faults)
    }

    /// Returns the spans of the settings of a method whose name has the span `name`.
    pub fn places(&self, name: Range<usize>) -> MethodPlaces {
        let spans = self.0.iter().map(|(key, value)| {
            let spans = (key.span(), value.span());
            (key.get_ref().clone(), spans)
        });
        MethodPlaces {
            name,
            settings: spans.collect(),
        }
    }
}

impl RawSetting {
    /// Returns the value of the setting with this key, if some method takes it.
    fn of(&self, key: SettingKey) -> Result<ParameterValue<f64>, ReadError> {
        match self {
            Self::Integer(value) => Value(key).visit_i64(*value),
            Self::Number(value) => Value(key).visit_f64(*value),
            Self::Switch(value) => Value(key).visit_bool(*value),
            Self::Word(value) => Value(key).visit_str(value),
        }
    }

    /// Returns the number, if it is one.
    pub fn number(&self) -> Option<f64> {
        match *self {
            #[expect(
                clippy::cast_precision_loss,
                reason = "a whole number of a file, as a number"
            )]
            Self::Integer(value) => Some(value as f64),
            Self::Number(value) => Some(value),
            Self::Switch(_) | Self::Word(_) => None,
        }
    }
}
