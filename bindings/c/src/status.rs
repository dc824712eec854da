//! What a call answers, and the errors behind it in words.

use core::fmt;

use palpate_core::{ChangeError, ParameterError, SettingsError};

/// What a call answers. `palpate_last_error` says the rest in words.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// A pointer is NULL.
    Null = 1,
    /// A struct_size is too small, or larger than the library knows and the rest is not 0.
    StructSize = 2,
    /// A parameter is outside its range.
    Parameter = 3,
    /// A method or a setting has another name or another value than there are.
    Setting = 4,
    /// What runs cannot change to that: another period, another side of the device, other devices, a body that cannot be so.
    Change = 5,
    /// The memory that was given is too small or not aligned.
    Memory = 6,
    /// A defect in the library, which has been caught. Report it, please.
    Internal = 7,
    /// A scene cannot be read, is none of a world, or cannot be rendered.
    Scene = 8,
    /// A place or a number of devices or bodies is another one than there are.
    Count = 9,
    /// A recording cannot be begun or written, or is of something else.
    Recording = 10,
}

/// Why a call is refused.
pub enum Refusal<'a> {
    /// What is NULL.
    Null(&'static str),
    /// A struct of another size.
    StructSize {
        name: &'static str,
        given: usize,
        known: usize,
    },
    Parameter(ParameterError),
    Change(ChangeError),
    /// Settings that do not make a method, with the setting where the words do not name it.
    Settings(SettingsError),
    UnknownMethod(&'a str),
    UnknownSetting {
        method: &'static str,
        key: &'a str,
    },
    SettingValue {
        key: &'static str,
        given: &'a str,
        allowed: &'static str,
    },
    /// A text that is not UTF-8.
    NotText(&'static str),
    /// A number that stands for a choice.
    Choice {
        name: &'static str,
        given: u32,
        allowed: &'static str,
    },
    TooSmall {
        given: usize,
        needed: usize,
    },
    NotAligned {
        needed: usize,
    },
    /// What is wrong with a scene, in words.
    #[cfg(feature = "worlds")]
    Scene(std::string::String),
    /// What a world that runs cannot change to, in words.
    #[cfg(feature = "worlds")]
    WorldChange(std::string::String),
    /// What is wrong with a local model, in words.
    #[cfg(feature = "worlds")]
    LocalModel(std::string::String),
    /// What is wrong with a recording, in words.
    #[cfg(feature = "worlds")]
    Recording(std::string::String),
    /// A number that says how a world is rendered.
    #[cfg(feature = "worlds")]
    WorldNumber {
        name: &'static str,
        given: f64,
        allowed: &'static str,
    },
    /// Another number of things than there are devices.
    #[cfg(feature = "worlds")]
    Count {
        name: &'static str,
        given: usize,
        needed: usize,
    },
    /// An array that cannot be one of so many elements.
    #[cfg(feature = "worlds")]
    Array {
        name: &'static str,
        count: usize,
    },
    /// A place where there is none of them.
    #[cfg(feature = "worlds")]
    Index {
        name: &'static str,
        given: usize,
        count: usize,
    },
}

impl Refusal<'_> {
    pub fn status(&self) -> Status {
        match self {
            Self::Null(_) => Status::Null,
            Self::StructSize { .. } => Status::StructSize,
            Self::Parameter(_) | Self::Choice { .. } | Self::Change(ChangeError::Parameter(_)) => {
                Status::Parameter
            }
            Self::Change(_) => Status::Change,
            Self::Settings(_)
            | Self::UnknownMethod(_)
            | Self::UnknownSetting { .. }
            | Self::SettingValue { .. }
            | Self::NotText(_) => Status::Setting,
            Self::TooSmall { .. } | Self::NotAligned { .. } => Status::Memory,
            #[cfg(feature = "worlds")]
            Self::Scene(_) => Status::Scene,
            #[cfg(feature = "worlds")]
            Self::WorldChange(_) => Status::Change,
            #[cfg(feature = "worlds")]
            Self::Recording(_) => Status::Recording,
            #[cfg(feature = "worlds")]
            Self::WorldNumber { .. } | Self::LocalModel(_) => Status::Parameter,
            #[cfg(feature = "worlds")]
            Self::Array { .. } => Status::Memory,
            #[cfg(feature = "worlds")]
            Self::Count { .. } | Self::Index { .. } => Status::Count,
        }
    }
}

impl fmt::Display for Refusal<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Null(name) => write!(f, "{name} is NULL"),
            Self::StructSize { name, given, known } if given < known => write!(
                f,
                "struct_size of {name} is {given}, but must be at least {known}: the function that the header names at this field sets it"
            ),
            Self::StructSize { name, given, known } => write!(
                f,
                "struct_size of {name} is {given}, of which this library knows {known}; what is beyond \
                 must be 0"
            ),
            Self::Parameter(error) => error.fmt(f),
            Self::Change(error) => error.fmt(f),
            Self::Settings(SettingsError::Unused { method, setting }) => {
                write!(f, "{} is set, but {method} cannot use it", setting.key)
            }
            Self::Settings(error) => error.fmt(f),
            Self::UnknownMethod(name) => {
                write!(
                    f,
                    "no method is called \"{}\"; there are ",
                    name.escape_debug()
                )?;
                crate::methods::write_names(f)
            }
            Self::UnknownSetting { method, key } => {
                let key = key.escape_debug();
                write!(f, "{method} has no setting \"{key}\"; it has ")?;
                crate::methods::write_keys(f, method)
            }
            Self::SettingValue {
                key,
                given,
                allowed,
            } => write!(
                f,
                "{key} is \"{}\", but must be {allowed}",
                given.escape_debug()
            ),
            Self::NotText(name) => write!(f, "{name} is not UTF-8"),
            Self::Choice {
                name,
                given,
                allowed,
            } => write!(f, "{name} is {given}, but must be {allowed}"),
            Self::TooSmall { given, needed } => {
                write!(f, "the memory has {given} bytes, but must have {needed}")
            }
            Self::NotAligned { needed } => {
                write!(f, "the memory must begin at a multiple of {needed} bytes")
            }
            #[cfg(feature = "worlds")]
            Self::Scene(words)
            | Self::WorldChange(words)
            | Self::LocalModel(words)
            | Self::Recording(words) => f.write_str(words),
            #[cfg(feature = "worlds")]
            Self::WorldNumber {
                name,
                given,
                allowed,
            } => write!(f, "{name} is {given}, but must be {allowed}"),
            #[cfg(feature = "worlds")]
            Self::Count {
                name,
                given,
                needed,
            } => write!(f, "{name} is {given}, but the world has {needed} devices"),
            #[cfg(feature = "worlds")]
            Self::Array { name, count } => write!(f, "{name} is no array of {count} elements"),
            #[cfg(feature = "worlds")]
            Self::Index { name, given, count } => {
                write!(f, "{name} is {given}, but must be less than {count}")
            }
        }
    }
}

impl From<ParameterError> for Refusal<'_> {
    fn from(error: ParameterError) -> Self {
        Self::Parameter(error)
    }
}

impl From<ChangeError> for Refusal<'_> {
    fn from(error: ChangeError) -> Self {
        Self::Change(error)
    }
}

impl From<SettingsError> for Refusal<'_> {
    fn from(error: SettingsError) -> Self {
        Self::Settings(error)
    }
}
