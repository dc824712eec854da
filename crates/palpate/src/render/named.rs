//! Methods by the names that programs offer them under.

use core::fmt;

use super::any::AnyParams;
use super::basic::{BASIC, BasicParams};
use super::list::for_all_methods;
use super::method::MethodParams;
use super::setting::{Basis, Setting, SettingKey, Settings, SettingsError};
use crate::Scalar;

/// What a method's own file says of it to programs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MethodInfo {
    /// Its name in files, flags and reports, in kebab case.
    pub name: &'static str,
    /// What it is, in a few words.
    pub summary: &'static str,
    /// Its colour in figures: a place among the colours of things that are compared.
    pub colour: u8,
    /// What a user can set.
    pub settings: &'static [Setting],
}

/// Parameters that a user can give by name: with settings, and defaults for those that are missing.
pub(super) trait FromSettings<S: Scalar>: MethodParams<S> + Sized {
    /// The parameters of the method offered as `method`: computed in `f64` and rounded once. No setting
    /// is given that its [`MethodInfo`] does not have.
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

            /// What the method's own file says of it.
            pub const fn info(self) -> &'static MethodInfo {
                match self {
                    Self::Basic => &BASIC,
                    $($(Self::$Name => &super::$file::$INFO,)+)*
                }
            }

            /// The method's parameters, with defaults for all settings that are missing: computed in
            /// `f64`, and rounded once to `S`.
            ///
            /// # Errors
            /// A setting the method cannot use, or one that cannot be derived from `basis`.
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

/// Settings of all methods, more than have keys of their own.
pub(super) const MOST_SETTINGS: usize = {
    let mut most = 0;
    let mut index = 0;
    while index < MethodName::ALL.len() {
        most += MethodName::ALL[index].info().settings.len();
        index += 1;
    }
    most
};

/// Every setting of every method once: of a key that methods share, that of the first of them.
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
    /// The name on the command line and in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.info().name
    }

    /// What it is, in a few words.
    #[must_use]
    pub fn summary(self) -> &'static str {
        self.info().summary
    }

    /// The method that is called `name`.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|method| method.name() == name)
    }

    /// The method's setting of that key, if it has one.
    #[must_use]
    pub fn setting(self, key: SettingKey) -> Option<&'static Setting> {
        let mut settings = self.info().settings.iter();
        settings.find(|setting| setting.key == key)
    }

    /// Whether the method can use a setting of that key.
    #[must_use]
    pub fn uses(self, key: SettingKey) -> bool {
        self.setting(key).is_some()
    }

    /// The first of the settings that this method has no use for.
    #[must_use]
    pub fn unused(self, settings: &Settings) -> Option<&'static Setting> {
        let given = settings.iter().map(|(setting, _)| setting);
        given.into_iter().find(|setting| !self.uses(setting.key))
    }
}

/// Coupled rendering: what renders where no method is named.
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
    fn names_keys_and_colours_tell_methods_and_settings_apart() {
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
