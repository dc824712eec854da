//! Methods by name, and their settings, from the list of the core.

use palpate_core::{
    MethodName, ParameterValue, Setting, SettingValues, Settings, Unit, all_settings,
};
use palpate_scene::method::{method_named, nearest};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyList, PyString};

use crate::names::{refused, unused};
use crate::own_method::OwnMethod;

/// Returns every method in the order of tables and figures: name, summary and settings, each with name, key, unit,
/// allowed words, help and default.
#[pyfunction]
pub fn methods(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let all = PyList::empty(py);
    for method in MethodName::ALL {
        let settings = PyList::empty(py);
        for setting in method.info().settings {
            let said = PyDict::new(py);
            said.set_item("name", setting.name())?;
            said.set_item("key", setting.key.as_str())?;
            said.set_item("unit", setting.unit().map(Unit::symbol))?;
            said.set_item("allowed", allowed(setting))?;
            said.set_item("help", setting.help)?;
            said.set_item("default", setting.default)?;
            settings.append(said)?;
        }
        let said = PyDict::new(py);
        said.set_item("name", method.name())?;
        said.set_item("summary", method.summary())?;
        said.set_item("settings", settings)?;
        all.append(said)?;
    }
    Ok(all)
}

/// Returns the allowed values of a setting as text.
fn allowed(setting: &Setting) -> String {
    match setting.values {
        SettingValues::Number { range, .. } => range.allowed().to_owned(),
        SettingValues::NumberOrWord { range, words, .. } => {
            format!("{}, or \"{}\"", range.allowed(), words.join("\", \""))
        }
        SettingValues::Words { words, .. } => format!("\"{}\"", words.join("\", \"")),
        SettingValues::Switch => "True or False".to_owned(),
    }
}

/// Returns the built-in methods of an argument `method`: one name, several names, or `all`.
pub fn chosen(method: &Bound<'_, PyAny>) -> PyResult<Vec<MethodName>> {
    let several = chosen_or_own(method)?.into_iter();
    let built_in = several.map(|method| match method {
        Chosen::BuiltIn(method) => Ok(method),
        Chosen::Own(own) => Err(PyTypeError::new_err(format!(
            "method {} is a function, and only simulate takes one",
            own.name
        ))),
    });
    built_in.collect()
}

/// A selected method.
pub enum Chosen {
    /// A built-in method.
    BuiltIn(MethodName),
    /// A Python function.
    Own(OwnMethod),
}

impl Chosen {
    /// Returns its name.
    pub fn name(&self) -> &'static str {
        match self {
            Self::BuiltIn(method) => method.name(),
            Self::Own(own) => own.name,
        }
    }
}

/// Returns the methods of an argument `method`, which may include Python functions.
pub fn chosen_or_own(method: &Bound<'_, PyAny>) -> PyResult<Vec<Chosen>> {
    if let Ok(name) = method.cast::<PyString>() {
        return match name.to_str()? {
            "all" => Ok(MethodName::ALL.map(Chosen::BuiltIn).into()),
            name => Ok(vec![Chosen::BuiltIn(named(name)?)]),
        };
    }
    if method.is_callable() {
        return Ok(vec![Chosen::Own(OwnMethod::new(method)?)]);
    }
    let mut methods: Vec<Chosen> = Vec::new();
    let no_method = |given: &Bound<'_, PyAny>| {
        let given = given
            .repr()
            .map_or_else(|_| "something else".into(), |said| said.to_string());
        PyTypeError::new_err(format!(
            "method is {given}, but must be the name of a method, a function, or a list of these"
        ))
    };
    for item in method.try_iter().map_err(|_| no_method(method))? {
        let item = item?;
        let method = if item.is_callable() {
            Chosen::Own(OwnMethod::new(&item)?)
        } else {
            let name: String = item.extract().map_err(|_| no_method(method))?;
            Chosen::BuiltIn(named(&name)?)
        };
        if methods.iter().any(|other| other.name() == method.name()) {
            return Err(refused(format!("{} is named twice", method.name())));
        }
        methods.push(method);
    }
    if methods.is_empty() {
        return Err(refused("method is empty; name a method"));
    }
    Ok(methods)
}

fn named(name: &str) -> PyResult<MethodName> {
    method_named(name).map_err(refused)
}

/// Reads settings for all of `methods` from arguments, named without units.
pub fn settings(given: &Bound<'_, PyDict>, methods: &[MethodName]) -> PyResult<Settings> {
    let mut settings = Settings::default();
    for (name, value) in given.iter() {
        let name: String = name.extract()?;
        let Some(setting) = all_settings().find(|setting| setting.name() == name) else {
            return Err(unknown(&name));
        };
        if let Some(method) = methods.iter().find(|method| !method.uses(setting.key)) {
            return Err(unused(setting, method));
        }
        let of = |method: &MethodName| Some((method.setting(setting.key)?, *method));
        let mut said = methods.iter().filter_map(of);
        if let Some((first, one)) = said.next()
            && let Some((second, other)) = said.find(|(second, _)| *second != first)
        {
            return Err(refused(format!(
                "{name} has two meanings: for {one} {}, for {other} {}; select one with method",
                first.help, second.help
            )));
        }
        settings.set(setting.key, Some(self::value(setting, &name, &value)?));
    }
    Ok(settings)
}

fn unknown(name: &str) -> PyErr {
    let known: Vec<_> = all_settings().map(Setting::name).collect();
    let near = nearest(name, &known).map_or_else(
        || format!("the settings are {}", known.join(", ")),
        |near| format!("did you mean {near}?"),
    );
    PyTypeError::new_err(format!("no parameter is called {name}; {near}"))
}

/// Reads the value of a setting: any value that some method accepts for this key.
fn value(
    setting: &'static Setting,
    name: &str,
    given: &Bound<'_, PyAny>,
) -> PyResult<ParameterValue<f64>> {
    let all = || {
        MethodName::ALL
            .into_iter()
            .filter_map(|method| method.setting(setting.key))
    };
    let is_switch = all().any(|setting| setting.values == SettingValues::Switch);
    if let Ok(on) = given.cast::<PyBool>()
        && is_switch
    {
        return Ok(ParameterValue::Switch(on.is_true()));
    }
    if let Ok(word) = given.cast::<PyString>() {
        let word = word.to_str()?;
        if let Some(value) = all().find_map(|setting| setting.word(word)) {
            return Ok(value);
        }
    } else if setting.unit().is_some()
        && let Ok(number) = given.extract::<f64>()
    {
        return Ok(ParameterValue::Number(number));
    }
    let what = match setting.values {
        SettingValues::Words { .. } => format!("one of {}", allowed(setting)),
        SettingValues::Switch => allowed(setting),
        _ => {
            let unit = setting.unit().map_or("", Unit::symbol);
            let words = all().flat_map(Setting::words);
            let words: String = words.map(|word| format!(" or \"{word}\"")).collect();
            format!("a number [{unit}]{words}")
        }
    };
    Err(refused(format!(
        "{name} is {}, but must be {what}",
        given.repr()?
    )))
}
