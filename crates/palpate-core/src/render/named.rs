//! Methods by the names used in programs.

use core::fmt;

use super::any::AnyParams;
use super::basic::{BASIC, BasicParams};
use super::list::for_all_methods;
use super::method::MethodParams;
use super::setting::{Basis, Setting, SettingKey, Settings, SettingsError};
use crate::Scalar;

/// Description of a method for programs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MethodInfo {
    /// Name in files, flags and reports, in kebab case.
    pub name: &'static str,
    /// Summary in a few words.
    pub summary: &'static str,
    /// Colour in figures: an index of the palette for comparisons.
    pub colour: u8,
    /// Settings of the method.
    pub settings: &'static [Setting],
}

/// Parameters that can be created from named settings, with defaults for missing ones.
pub(super) trait FromSettings<S: Scalar>: MethodParams<S> + Sized {
    /// Creates the parameters of the method offered as `method`: computed in `f64` and rounded once. All given settings
    /// are in its [`MethodInfo`].
    fn from_settings(
        method: MethodName,
        settings: &Settings,
        basis: &Basis,
    ) -> Result<Self, SettingsError>;
}

macro_rules! named {
    ($(
        $Variant:ident($Params:ty, $Method:ty)
        $(shares $shared:ident)?
        $(remembers $own:ident: $Memory:ty)?,
        named $($Name:ident = $file:ident::$INFO:ident),+;
    )*) => {
        /// A method of the program, by its name.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[allow(missing_docs)] // the summary of each says what it is
        #[non_exhaustive]
        pub enum MethodName {
            Basic,
            $($($Name,)+)*
        }

        impl MethodName {
            const COUNT: usize = [Self::Basic, $($(Self::$Name,)+)*].len();

            /// Every method, in the order of tables and figures.
            pub const ALL: [Self; Self::COUNT] = [Self::Basic, $($(Self::$Name,)+)*];

            /// Returns the description of the method.
            pub const fn info(self) -> &'static MethodInfo {
                match self {
                    Self::Basic => &BASIC,
                    $($(Self::$Name => &super::$file::$INFO,)+)*
                }
            }

            /// Returns the method's parameters, with defaults for missing settings: computed in `f64`, and rounded once
            /// to `S`.
            ///
            /// # Errors
            /// A setting that the method does not have, or that cannot be derived from `basis`.
            pub fn params<S: Scalar>(
                self,
                settings: &Settings,
                basis: &Basis,
            ) -> Result<AnyParams<S>, SettingsError> {
                #[allow(clippy::wildcard_imports)] // the list names types of every method
                use super::any::*;
                if let Some(setting) = self.unused(settings) {
                    return Err(SettingsError::Unused { method: self, setting });
                }
                Ok(match self {
                    Self::Basic => AnyParams::Basic,
                    $($(Self::$Name)|+ => {
                        AnyParams::$Variant(<$Params as FromSettings<S>>::from_settings(self, settings, basis)?)
                    })*
                })
            }
        }
    };
}
for_all_methods!(named);

/// Number of settings of all methods; shared keys count several times.
pub(super) const MAX_SETTINGS: usize = {
    let mut most = 0;
    let mut index = 0;
    while index < MethodName::ALL.len() {
        most += MethodName::ALL[index].info().settings.len();
        index += 1;
    }
    most
};

/// Iterates over every setting once; for a key shared by methods, the setting is that of the first method.
pub fn all_settings() -> impl Iterator<Item = &'static Setting> + Clone {
    let of = |method: MethodName| method.info().settings.iter();
    let all = MethodName::ALL.into_iter().flat_map(of).enumerate();
    all.filter(move |(index, setting)| {
        let mut before = MethodName::ALL.into_iter().flat_map(of).take(*index);
        before.all(|earlier| earlier.key != setting.key)
    })
    .map(|(_, setting)| setting)
}

impl MethodName {
    /// Returns the name on the command line and in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.info().name
    }

    /// Returns the summary in a few words.
    #[must_use]
    pub fn summary(self) -> &'static str {
        self.info().summary
    }

    /// Returns the method with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|method| method.name() == name)
    }

    /// Returns the method's setting with this key, if it has one.
    #[must_use]
    pub fn setting(self, key: SettingKey) -> Option<&'static Setting> {
        let mut settings = self.info().settings.iter();
        settings.find(|setting| setting.key == key)
    }

    /// Returns whether the method has a setting with this key.
    #[must_use]
    pub fn uses(self, key: SettingKey) -> bool {
        self.setting(key).is_some()
    }

    /// Returns the first of the settings that this method does not have.
    #[must_use]
    pub fn unused(self, settings: &Settings) -> Option<&'static Setting> {
        let given = settings.iter().map(|(setting, _)| setting);
        given.into_iter().find(|setting| !self.uses(setting.key))
    }
}

/// Coupled rendering, the default method.
impl Default for MethodName {
    fn default() -> Self {
        Self::Coupled
    }
}

impl fmt::Display for MethodName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl<S: Scalar> FromSettings<S> for BasicParams {
    fn from_settings(_: MethodName, _: &Settings, _: &Basis) -> Result<Self, SettingsError> {
        Ok(Self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameter::Unit;

    #[test]
    fn method_names_colours_and_setting_keys_are_unique() {
        for (index, method) in MethodName::ALL.into_iter().enumerate() {
            assert_eq!(MethodName::named(method.name()), Some(method));
            for other in &MethodName::ALL[..index] {
                assert_ne!(other.info().colour, method.info().colour, "{method}");
            }
            for (index, setting) in method.info().settings.iter().enumerate() {
                let earlier = &method.info().settings[..index];
                assert!(earlier.iter().all(|other| other.key != setting.key));
            }
        }
    }

    #[test]
    fn a_key_ends_with_its_unit_and_has_the_same_unit_in_every_method() {
        for method in MethodName::ALL {
            for setting in method.info().settings {
                let key = setting.key.as_str();
                assert!(
                    key.ends_with(setting.unit().map_or("", Unit::suffix)),
                    "{key}"
                );
                let first = all_settings().find(|other| other.key == setting.key);
                assert_eq!(first.unwrap().unit(), setting.unit(), "{key}");
            }
        }
    }
}
