//! Methods and their settings by name, from the list of the core.

use core::ffi::c_char;
use core::fmt::{self, Display};

use palpate_core::{
    Allowed, MethodName, Parameter, ParameterError, ParameterValue, Range, Setting as Core,
    SettingValues, Settings, Unit,
};

use crate::contact_params::Setting;
use crate::edge::caught;
use crate::status::Refusal;
use crate::text;

/// Texts that palpate_method_text returns for a method.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MethodText {
    /// Name, as accepted by `method` of palpate_contact_params.
    Name = 0,
    /// Short description.
    Summary = 1,
}

/// Texts that palpate_setting_text returns for a setting.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SettingText {
    /// Key.
    Key = 0,
    /// Unit symbol; "" for words, switches and dimensionless numbers.
    Unit = 1,
    /// Short description that continues the method's name.
    Help = 2,
    /// Default value.
    Default = 3,
    /// Accepted words, separated by commas; "" if the setting accepts only numbers.
    Words = 4,
}

/// Returns the number of methods.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_method_count() -> usize {
    MethodName::ALL.len()
}

/// Returns the number of settings of the method with the 0-based index `method`; 0 if there is no such method.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_method_setting_count(method: usize) -> usize {
    let method = MethodName::ALL.get(method);
    method.map_or(0, |method| method.info().settings.len())
}

/// Writes a text about the method with the 0-based index `method` to `memory`, truncated to `size` bytes and
/// terminated by a 0. `what` is a palpate_about_method. Returns the untruncated length without the 0, or 0 if
/// there is no such method or text.
///
/// # Safety
/// `memory` is NULL, or `size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_method_text(
    method: usize,
    what: u32,
    memory: *mut c_char,
    size: usize,
) -> usize {
    let method = MethodName::ALL.get(method);
    let text = method.and_then(|method| match what {
        0 => Some(method.name()),
        1 => Some(method.summary()),
        _ => None,
    });
    // SAFETY: guaranteed by the caller.
    caught(|| unsafe { text::put_at(text.unwrap_or_default(), memory, size) }).unwrap_or(0)
}

/// Writes a text about the setting with the 0-based index `setting` of the method with the 0-based index
/// `method`, as palpate_method_text does. `what` is a palpate_about_setting.
///
/// # Safety
/// `memory` is NULL, or `size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_setting_text(
    method: usize,
    setting: usize,
    what: u32,
    memory: *mut c_char,
    size: usize,
) -> usize {
    let method = MethodName::ALL.get(method);
    let setting = method.and_then(|method| method.info().settings.get(setting));
    let text = setting.and_then(|setting| match what {
        0 => Some(Text::Whole(setting.key.as_str())),
        1 => Some(Text::Whole(setting.unit().map_or("", Unit::symbol))),
        2 => Some(Text::Whole(setting.help)),
        3 => Some(Text::Whole(setting.default)),
        4 => Some(Text::Words(words_of(setting))),
        _ => None,
    });
    let text = text.unwrap_or(Text::Whole(""));
    // SAFETY: guaranteed by the caller.
    caught(|| unsafe { text::put_at(text, memory, size) }).unwrap_or(0)
}

/// Returns the words that a setting accepts.
fn words_of(setting: &Core) -> &'static [&'static str] {
    match setting.values {
        SettingValues::Switch => &["true", "false"],
        _ => setting.words(),
    }
}

/// A text, or several texts separated by commas.
enum Text {
    Whole(&'static str),
    Words(&'static [&'static str]),
}

impl Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole(text) => f.write_str(text),
            Self::Words(words) => write_joined(f, words.iter().copied()),
        }
    }
}

/// Reads `count` settings at `given`.
///
/// # Safety
/// `given` is NULL or points to `count` settings, whose texts are NULL or terminated by a 0.
pub(crate) unsafe fn settings<'a>(
    method: MethodName,
    given: *const Setting,
    count: usize,
) -> Result<Settings, Refusal<'a>> {
    let mut settings = Settings::default();
    if count > 0 && given.is_null() {
        return Err(Refusal::Null("settings"));
    }
    for at in 0..count {
        // SAFETY: not NULL, and `at` is below the count that the caller guarantees.
        let Setting { key, number, word } = unsafe { given.add(at).read() };
        // SAFETY: guaranteed by the caller.
        let key = unsafe { text::read(key, "key of a setting") }?;
        let mut own = method.info().settings.iter();
        let Some(setting) = own.find(|setting| setting.key.as_str() == key) else {
            let method = method.name();
            return Err(Refusal::UnknownSetting { method, key });
        };
        if settings.get(setting.key).is_some() {
            return Err(Refusal::SettingTwice(setting.key.as_str()));
        }
        let value = if word.is_null() {
            of_number(setting, number)?
        } else {
            // SAFETY: guaranteed by the caller.
            of_word(setting, unsafe { text::read(word, "word of a setting") }?)?
        };
        settings.set(setting.key, Some(value));
    }
    Ok(settings)
}

fn of_number<'a>(setting: &'static Core, number: f64) -> Result<ParameterValue<f64>, Refusal<'a>> {
    match setting.range() {
        Some(range) if range.contains(number) => Ok(ParameterValue::Number(number)),
        Some(range) => Err(Refusal::Parameter(ParameterError {
            parameter: Parameter::Setting(setting),
            value: number,
            allowed: Allowed::Range(range),
        })),
        None => Err(Refusal::SettingValue {
            setting,
            given: None,
        }),
    }
}

fn of_word<'a>(setting: &'static Core, word: &'a str) -> Result<ParameterValue<f64>, Refusal<'a>> {
    let value = match (setting.values, word) {
        (SettingValues::Switch, "true") => Some(ParameterValue::Switch(true)),
        (SettingValues::Switch, "false") => Some(ParameterValue::Switch(false)),
        _ => setting.word(word),
    };
    value.ok_or(Refusal::SettingValue {
        setting,
        given: Some(word),
    })
}

/// Returns the error for a non-finite virtual force.
pub(crate) fn not_finite_virtual_force(value: f64) -> Refusal<'static> {
    Refusal::Parameter(ParameterError {
        parameter: Parameter::VirtualForce,
        value,
        allowed: Allowed::Range(Range::Finite),
    })
}

fn write_joined(
    f: &mut fmt::Formatter<'_>,
    names: impl Iterator<Item = &'static str>,
) -> fmt::Result {
    for (index, name) in names.enumerate() {
        f.write_str(if index > 0 { ", " } else { "" })?;
        name.fmt(f)?;
    }
    Ok(())
}

/// Writes the names of all methods, separated by commas.
pub(crate) fn write_names(f: &mut fmt::Formatter<'_>) -> fmt::Result {
    write_joined(f, MethodName::ALL.into_iter().map(MethodName::name))
}

/// Writes the keys of a method's settings, separated by commas.
pub(crate) fn write_keys(f: &mut fmt::Formatter<'_>, method: &str) -> fmt::Result {
    let settings = MethodName::named(method).map_or(&[][..], |method| method.info().settings);
    if settings.is_empty() {
        return f.write_str("none");
    }
    write_joined(f, settings.iter().map(|setting| setting.key.as_str()))
}
