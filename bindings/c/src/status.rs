//! Status of a call, and its error messages.

use core::fmt;

use palpate_core::{ChangeError, ParameterError, Setting, SettingValues, SettingsError};

/// Result of a call. `palpate_last_error` returns the message, palpate_status_name the name.
///
/// A status names the kind of the wrong argument, for every function: NULL, STRUCT_SIZE and MEMORY a pointer and its
/// target, PARAMETER a number, SETTING a text, COUNT an index or a number of elements, SCENE the content of a scene,
/// CHANGE an active contact or world, RECORDING a file of ticks. Of several errors the first one is returned.
///
/// A rejected call changes nothing, with three exceptions: a function that creates an object sets its output to NULL,
/// palpate_recorder_close always frees the recorder, and after INTERNAL all objects involved can only be freed.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Success.
    Ok = 0,
    /// A required pointer is NULL.
    Null = 1,
    /// A struct_size is too small, or larger than this library knows and an unknown field is not 0.
    StructSize = 2,
    /// A number of the call, of a struct or of an array is outside its range, including choices, switches and nonzero
    /// reserved fields.
    Parameter = 3,
    /// A text is not UTF-8 or is not a known method, setting or word; a setting is given twice or is missing.
    Setting = 4,
    /// An active contact or world cannot change to this: another period, side or set of devices, or motion of a
    /// fixed body.
    Change = 5,
    /// The given memory is too small or misaligned, an array cannot have this many elements, or the system is out of
    /// memory.
    Memory = 6,
    /// A defect in the library was caught. Please report it.
    Internal = 7,
    /// A scene cannot be read, is not a world or cannot be rendered; a name is unknown or exists already.
    Scene = 8,
    /// An index, or a number of devices or bodies, is out of range.
    Count = 9,
    /// A recording cannot be started or written, or a tick belongs to another object than the recorded one.
    Recording = 10,
}

/// Reason for rejecting a call.
pub enum Refusal<'a> {
    /// Name of the argument that is NULL.
    Null(&'static str),
    /// A struct of the wrong size.
    StructSize {
        name: &'static str,
        given: usize,
        known: usize,
    },
    Parameter(ParameterError),
    Change(ChangeError),
    /// Settings that do not form a valid method, with the setting if the message does not name it.
    Settings(SettingsError),
    UnknownMethod(&'a str),
    UnknownSetting {
        method: &'static str,
        key: &'a str,
    },
    /// A setting with a word that it does not accept; `None`: a number for a setting that accepts words.
    SettingValue {
        setting: &'static Setting,
        given: Option<&'a str>,
    },
    /// Key of a setting that is given twice.
    SettingTwice(&'static str),
    /// A text that is not UTF-8.
    NotText(&'static str),
    /// An invalid number for a choice.
    Choice {
        name: &'static str,
        given: u32,
        allowed: &'static str,
    },
    /// A number outside its range.
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
    /// Error message of a scene.
    #[cfg(feature = "worlds")]
    Scene(std::string::String),
    /// Error message of a change that a running world cannot make.
    #[cfg(feature = "worlds")]
    WorldChange(std::string::String),
    /// Error message about the numbers of a call.
    #[cfg(feature = "worlds")]
    Numbers(std::string::String),
    /// Error message about a method that cannot render this world or any world.
    #[cfg(feature = "worlds")]
    WorldMethod(std::string::String),
    /// Error message about a failed memory allocation.
    #[cfg(feature = "worlds")]
    NoMemory(std::string::String),
    /// Error message of a recording.
    #[cfg(feature = "worlds")]
    Recording(std::string::String),
    /// A wrong number of elements.
    #[cfg(feature = "worlds")]
    Count {
        name: &'static str,
        given: usize,
        needed: usize,
        /// Owner of the needed elements, and their name.
        of: (&'static str, &'static str),
    },
    /// A world with this number of devices where exactly one is required.
    #[cfg(feature = "worlds")]
    NotOneDevice(usize),
    /// An array that cannot have this many elements.
    #[cfg(feature = "worlds")]
    Array {
        name: &'static str,
        count: usize,
    },
    /// An index out of range.
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
                "struct_size of {name} is {given}, but this library knows {known} bytes; the bytes beyond \
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
                "the world has {count} devices, but a recording has one: palpate_recorder_of_device records each in a \
                 separate file"
            ),
            #[cfg(feature = "worlds")]
            Self::Array { name, count } => write!(f, "{name} is not an array of {count} elements"),
            #[cfg(feature = "worlds")]
            Self::Index { name, given, count } => {
                write!(f, "{name} is {given}, but must be less than {count}")
            }
        }
    }
}

/// Writes the allowed values of a setting, with all its words.
fn write_allowed(f: &mut fmt::Formatter<'_>, values: SettingValues) -> fmt::Result {
    match values {
        SettingValues::Number { .. } => f.write_str("a number"),
        SettingValues::NumberOrWord { words, .. } => {
            f.write_str("a number")?;
            for word in words {
                write!(f, " or \"{word}\"")?;
            }
            Ok(())
        }
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
