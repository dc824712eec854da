//! Named settings of methods in files, flags and reports: their description in the method's file, and the values given
//! by a user.

use core::fmt;

use super::named::{MAX_SETTINGS, MethodName, all_settings};
use crate::Scalar;
use crate::contact::Mass;
use crate::parameter::{Parameter, ParameterError, ParameterValue, Range, Unit};

/// Key of a setting in files and reports, with its unit as suffix. Methods may share a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SettingKey(&'static str);

impl SettingKey {
    /// Damping `[N s/m]`: B of the virtual damper, b of HFCR.
    pub const DAMPING: Self = Self("damping_n_s_per_m");

    pub(crate) const fn new(key: &'static str) -> Self {
        Self(key)
    }

    /// Returns the key, such as `damping_n_s_per_m`.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        self.0
    }

    /// Returns the names of the methods with this setting, in the order of tables, joined by commas.
    pub fn users(self) -> impl fmt::Display {
        let users = MethodName::ALL.into_iter();
        Joined(
            users
                .filter(move |method| method.uses(self))
                .map(MethodName::name),
        )
    }
}

impl fmt::Display for SettingKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.0)
    }
}

/// Description of a setting in the method's file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Setting {
    /// Key.
    pub key: SettingKey,
    /// Allowed values.
    pub values: SettingValues,
    /// Description that follows the method's name.
    pub help: &'static str,
    /// Description of the default.
    pub default: &'static str,
}

/// Word of a setting whose value is derived.
pub(super) const AUTO: &str = "auto";

/// Allowed values of a setting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SettingValues {
    /// A number.
    Number {
        /// Its unit.
        unit: Unit,
        /// Its range.
        range: Range,
    },
    /// A number, or a word that stands for a rule, such as `auto`.
    NumberOrWord {
        /// Its unit.
        unit: Unit,
        /// Its range.
        range: Range,
        /// The words.
        words: &'static [&'static str],
    },
    /// One of several words.
    Words {
        /// The words.
        words: &'static [&'static str],
        /// Words of earlier files, each with its replacement.
        earlier: &'static [(&'static str, &'static str)],
    },
    /// On or off; the default is on.
    Switch,
}

impl Setting {
    /// Returns the unit; `None` for words and switches.
    #[must_use]
    pub fn unit(&self) -> Option<Unit> {
        match self.values {
            SettingValues::Number { unit, .. } | SettingValues::NumberOrWord { unit, .. } => {
                Some(unit)
            }
            SettingValues::Words { .. } | SettingValues::Switch => None,
        }
    }

    /// Returns the range of a number; `None` for words and switches.
    #[must_use]
    pub fn range(&self) -> Option<Range> {
        match self.values {
            SettingValues::Number { range, .. } | SettingValues::NumberOrWord { range, .. } => {
                Some(range)
            }
            SettingValues::Words { .. } | SettingValues::Switch => None,
        }
    }

    /// Returns the key without the unit, such as `damping`; the flag is derived from it.
    pub fn name(&self) -> &'static str {
        let key = self.key.0;
        let suffix = self.unit().map_or("", Unit::suffix);
        key.strip_suffix(suffix).unwrap_or(key)
    }

    /// Returns the value of a word; `None` for an unknown word.
    #[must_use]
    pub fn word(&self, given: &str) -> Option<ParameterValue<f64>> {
        match self.values {
            SettingValues::Words { words, earlier } => {
                let now = earlier.iter().find(|(before, _)| *before == given);
                let given = now.map_or(given, |(_, now)| now);
                let known = words.iter().find(|word| **word == given);
                known.map(|word| ParameterValue::Word(word))
            }
            SettingValues::NumberOrWord { words, .. } => {
                let known = words.iter().find(|word| **word == given)?;
                Some(match *known {
                    AUTO => ParameterValue::ToBeDerived,
                    word => ParameterValue::Word(word),
                })
            }
            _ => None,
        }
    }

    /// Returns the allowed words; none for a plain number or a switch.
    #[must_use]
    pub const fn words(&self) -> &'static [&'static str] {
        match self.values {
            SettingValues::Words { words, .. } | SettingValues::NumberOrWord { words, .. } => words,
            SettingValues::Number { .. } | SettingValues::Switch => &[],
        }
    }

    /// Checks the value given for this setting of `method`, of which another method with the same key may accept more
    /// words.
    pub(crate) fn checked_word(
        &'static self,
        method: MethodName,
        given: &Settings,
    ) -> Result<Option<&'static str>, SettingsError> {
        let word = match given.get(self.key) {
            Some(ParameterValue::ToBeDerived) => AUTO,
            Some(ParameterValue::Word(word)) => word,
            _ => return Ok(None),
        };
        if self.words().contains(&word) {
            Ok(Some(word))
        } else {
            let setting = self;
            Err(SettingsError::NoRule {
                method,
                setting,
                word,
            })
        }
    }

    /// Checks that a number is in the setting's range.
    pub(crate) fn check<S: Scalar>(&'static self, value: S) -> Result<S, ParameterError> {
        let range = self.range().unwrap_or(Range::Finite);
        Parameter::Setting(self).within(range, value)
    }
}

/// Quantities from which the missing parameters of a method are derived.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    /// Contact stiffness `[N/m]`.
    pub stiffness: f64,
    /// Loop period `[s]`.
    pub period: f64,
    /// Effective mass of the device, if known `[kg]`.
    pub device_mass: Option<f64>,
    /// Quantum of the device's position sensor, 0 if it has no known quantum `[m]`.
    pub encoder_quantum: f64,
    /// Whether the device follows a recorded motion, which no force can change.
    pub recorded: bool,
    /// Energy the object stores at the start `[J]`.
    pub stored_energy: f64,
}

impl Basis {
    /// Returns the mass that the contact force of `method` moves.
    pub(crate) fn pushed_mass<S: Scalar>(
        &self,
        method: MethodName,
    ) -> Result<Mass<S>, SettingsError> {
        match self.device_mass {
            _ if self.recorded => Ok(Mass::Infinite),
            Some(mass) => Ok(Mass::Finite(S::from_f64(mass))),
            None => Err(SettingsError::NoPushedMass(method)),
        }
    }

    /// Returns K T `[N s/m]`, the damping that a held spring force lacks in two periods.
    pub(crate) fn impedance(&self) -> f64 {
        self.stiffness * self.period
    }
}

/// Invalid settings of a method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SettingsError {
    /// The method does not have a setting.
    Unused {
        /// The method.
        method: MethodName,
        /// The unused setting, as described by another method.
        setting: &'static Setting,
    },
    /// The method does not accept this word for its setting.
    NoRule {
        /// The method.
        method: MethodName,
        /// Its setting.
        setting: &'static Setting,
        /// The word, which another method accepts.
        word: &'static str,
    },
    /// The rule of the setting requires the device's mass.
    NoDeviceMass(&'static Setting),
    /// The method predicts the device and requires the device's mass.
    NoPushedMass(MethodName),
    /// The setting requires another word of a second setting.
    OnlyBeside {
        /// The method.
        method: MethodName,
        /// The given setting.
        setting: &'static Setting,
        /// The second setting.
        other: &'static Setting,
        /// The required word.
        needed: &'static str,
        /// The actual word.
        is: &'static str,
    },
}

/// Names joined by commas.
struct Joined<I>(I);

impl<I: Iterator<Item = &'static str> + Clone> fmt::Display for Joined<I> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, name) in self.0.clone().enumerate() {
            f.write_str(if index > 0 { ", " } else { "" })?;
            f.write_str(name)?;
        }
        Ok(())
    }
}

impl fmt::Display for SettingsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unused { method, .. } => write!(f, "{method} cannot use it"),
            Self::NoRule {
                method,
                setting,
                word,
            } => {
                let accepting = MethodName::ALL.into_iter().filter(|method| {
                    let own = method.setting(setting.key);
                    own.is_some_and(|own| own.words().contains(word))
                });
                let names = Joined(accepting.map(MethodName::name));
                let name = setting.name();
                write!(
                    f,
                    "only {names} accepts \"{word}\" for its {name}; give {method} a number"
                )
            }
            Self::NoDeviceMass(setting) => {
                let name = setting.name();
                write!(f, "deriving the {name} needs the device's effective mass")
            }
            Self::NoPushedMass(method) => {
                write!(
                    f,
                    "{method} needs the device's effective mass, within a factor of 2"
                )
            }
            Self::OnlyBeside {
                method,
                setting,
                other,
                needed,
                is,
            } => {
                let (key, other) = (setting.key, other.key);
                write!(
                    f,
                    "{key} requires {other} {needed}, but that of {method} is {is}"
                )
            }
        }
    }
}

impl core::error::Error for SettingsError {}

/// Given settings; missing ones have their defaults.
#[derive(Clone, Copy, Default, PartialEq)]
pub struct Settings {
    /// The values, in the order of [`all_settings`].
    given: [Option<ParameterValue<f64>>; MAX_SETTINGS],
}

impl Settings {
    fn index(key: SettingKey) -> Option<usize> {
        all_settings().position(|setting| setting.key == key)
    }

    /// Returns the value given for `key`.
    #[must_use]
    pub fn get(&self, key: SettingKey) -> Option<ParameterValue<f64>> {
        self.given[Self::index(key)?]
    }

    /// Returns the number given for `key`, in the unit of the key.
    #[must_use]
    pub fn number(&self, key: SettingKey) -> Option<f64> {
        match self.get(key)? {
            ParameterValue::Number(number) => Some(number),
            _ => None,
        }
    }

    /// Returns the word given for `key`.
    #[must_use]
    pub fn word(&self, key: SettingKey) -> Option<&'static str> {
        match self.get(key)? {
            ParameterValue::Word(word) => Some(word),
            _ => None,
        }
    }

    /// Returns whether the switch of `key` is on; `None` if it was not given.
    #[must_use]
    pub fn switch(&self, key: SettingKey) -> Option<bool> {
        match self.get(key)? {
            ParameterValue::Switch(on) => Some(on),
            _ => None,
        }
    }

    /// Returns whether a value was given for `key`.
    #[must_use]
    pub fn has(&self, key: SettingKey) -> bool {
        self.get(key).is_some()
    }

    /// Returns the settings with a value for `key`, a number in the unit of the key.
    #[must_use]
    pub fn with(mut self, key: SettingKey, value: impl Into<ParameterValue<f64>>) -> Self {
        self.set(key, Some(value.into()));
        self
    }

    /// Sets or removes the value of `key`.
    pub fn set(&mut self, key: SettingKey, value: Option<ParameterValue<f64>>) {
        if let Some(index) = Self::index(key) {
            self.given[index] = value;
        }
    }

    /// Returns these settings, completed by those of `others`.
    #[must_use]
    pub fn or(mut self, others: Self) -> Self {
        for (own, other) in self.given.iter_mut().zip(others.given) {
            *own = own.or(other);
        }
        self
    }

    /// Iterates over the given settings with their values. For a key shared by methods, the setting is that of the
    /// first method.
    pub fn iter(&self) -> impl Iterator<Item = (&'static Setting, ParameterValue<f64>)> {
        let given = all_settings().zip(self.given);
        given.filter_map(|(setting, value)| Some((setting, value?)))
    }
}

impl fmt::Debug for Settings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let given = self.iter().map(|(setting, value)| (setting.key.0, value));
        f.debug_map().entries(given).finish()
    }
}
