//! What a call answers, and the errors behind it in words.

use core::fmt;

use palpate::{ChangeError, ParameterError, Setting, SettingValues, SettingsError};

/// What a call answers. `palpate_last_error` says the rest in words, palpate_status_name has the names of these.
///
/// A status says where the error is, whatever was called: NULL, STRUCT_SIZE and MEMORY at a pointer and what it points to,
/// PARAMETER at a number, SETTING at a text, COUNT at a place or a number of things, SCENE at what a scene has, CHANGE at what
/// runs already, RECORDING at a file of ticks. Of several errors it is that of the first one.
///
/// A call that is refused changes nothing. There are three exceptions: a call that makes something puts NULL in place of it,
/// palpate_recorder_close frees the recorder whatever it answers, and after INTERNAL everything that was used can only be freed.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// A pointer is NULL that may not be.
    Null = 1,
    /// A struct_size is too small, or larger than the library knows and the rest is not 0.
    StructSize = 2,
    /// A number of the call, or of a struct or an array of it, is outside its range: one that stands for a choice or a switch, too,
    /// and a reserved one that is not 0.
    Parameter = 3,
    /// A text is not UTF-8, or none of the methods, settings and words that there are; a setting is given twice, or is missing.
    Setting = 4,
    /// What runs cannot change to that: another period, another side of the device, other devices, a fixed body that is to move.
    Change = 5,
    /// The memory that was given is too small or not aligned, an array cannot have so many elements, or the system has no memory
    /// for what was asked.
    Memory = 6,
    /// A defect in the library, which has been caught. Report it, please.
    Internal = 7,
    /// A scene cannot be read, is none of a world, or cannot be rendered; it has no such name, or has that name already.
    Scene = 8,
    /// A place, or a number of devices or bodies, is another one than there are.
    Count = 9,
    /// A recording cannot be begun or written, or a tick is of something else than what is recorded.
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
    /// A setting with a word that it does not take; no word: a number where it takes words.
    SettingValue {
        setting: &'static Setting,
        given: Option<&'a str>,
    },
    /// The key of a setting that is there already.
    SettingTwice(&'static str),
    /// A text that is not UTF-8.
    NotText(&'static str),
    /// A number that stands for a choice.
    Choice {
        name: &'static str,
        given: u32,
        allowed: &'static str,
    },
    /// A number that is outside its range.
    Number {
        name: &'static str,
        given: f64,
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
    /// What is wrong with the numbers of a call, in words.
    #[cfg(feature = "worlds")]
    Numbers(std::string::String),
    /// A method that renders no worlds, or not this one, in words.
    #[cfg(feature = "worlds")]
    WorldMethod(std::string::String),
    /// What the system has no memory for, in words.
    #[cfg(feature = "worlds")]
    NoMemory(std::string::String),
    /// What is wrong with a recording, in words.
    #[cfg(feature = "worlds")]
    Recording(std::string::String),
    /// Another number of things than there are.
    #[cfg(feature = "worlds")]
    Count {
        name: &'static str,
        given: usize,
        needed: usize,
        /// What has the others, and what they are.
        of: (&'static str, &'static str),
    },
    /// A world of so many devices where one is needed.
    #[cfg(feature = "worlds")]
    NotOneDevice(usize),
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
            Self::Parameter(_)
            | Self::Choice { .. }
            | Self::Number { .. }
            | Self::Change(ChangeError::Parameter(_)) => Status::Parameter,
            Self::Change(_) => Status::Change,
            Self::Settings(_)
            | Self::UnknownMethod(_)
            | Self::UnknownSetting { .. }
            | Self::SettingValue { .. }
            | Self::SettingTwice(_)
            | Self::NotText(_) => Status::Setting,
            Self::TooSmall { .. } | Self::NotAligned { .. } => Status::Memory,
            #[cfg(feature = "worlds")]
            Self::Scene(_) => Status::Scene,
            #[cfg(feature = "worlds")]
            Self::WorldChange(_) => Status::Change,
            #[cfg(feature = "worlds")]
            Self::Recording(_) => Status::Recording,
            #[cfg(feature = "worlds")]
            Self::Numbers(_) => Status::Parameter,
            #[cfg(feature = "worlds")]
            Self::WorldMethod(_) => Status::Setting,
            #[cfg(feature = "worlds")]
            Self::Array { .. } | Self::NoMemory(_) => Status::Memory,
            #[cfg(feature = "worlds")]
            Self::Count { .. } | Self::Index { .. } | Self::NotOneDevice(_) => Status::Count,
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
            Self::SettingValue { setting, given } => {
                let key = setting.key.as_str();
                match given {
                    Some(word) => write!(f, "{key} is \"{}\"", word.escape_debug())?,
                    None => write!(f, "{key} is a number")?,
                }
                f.write_str(", but must be ")?;
                write_allowed(f, setting.values)
            }
            Self::SettingTwice(key) => write!(f, "{key} is given twice"),
            Self::NotText(name) => write!(f, "{name} is not UTF-8"),
            Self::Choice {
                name,
                given,
                allowed,
            } => write!(f, "{name} is {given}, but must be {allowed}"),
            Self::Number {
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
            | Self::Numbers(words)
            | Self::WorldMethod(words)
            | Self::NoMemory(words)
            | Self::Recording(words) => f.write_str(words),
            #[cfg(feature = "worlds")]
            Self::Count {
                name,
                given,
                needed,
                of: (owner, things),
            } => write!(f, "{name} is {given}, but {owner} has {needed} {things}"),
            #[cfg(feature = "worlds")]
            Self::NotOneDevice(count) => write!(
                f,
                "the world has {count} devices, but a recording has one: palpate_recorder_of_device records each in a file of its own"
            ),
            #[cfg(feature = "worlds")]
            Self::Array { name, count } => write!(f, "{name} is no array of {count} elements"),
            #[cfg(feature = "worlds")]
            Self::Index { name, given, count } => {
                write!(f, "{name} is {given}, but must be less than {count}")
            }
        }
    }
}

/// What a setting may be, with all its words.
fn write_allowed(f: &mut fmt::Formatter<'_>, values: SettingValues) -> fmt::Result {
    match values {
        SettingValues::Number { .. } => f.write_str("a number"),
        SettingValues::NumberOrAuto { .. } => f.write_str("a number or \"auto\""),
        SettingValues::Words { words, .. } => {
            for (index, word) in words.iter().enumerate() {
                let between = match index {
                    0 => "",
                    last if last + 1 == words.len() => " or ",
                    _ => ", ",
                };
                write!(f, "{between}\"{word}\"")?;
            }
            Ok(())
        }
        SettingValues::Switch => f.write_str("\"true\" or \"false\""),
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
