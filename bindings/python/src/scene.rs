//! Scenes from a file, a text, or tables of Python.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use palpate_scene::method::MethodName;
use palpate_scene::{ContactFile, Measure, Scene, SceneError, SceneErrors, SceneParameter, beside};
use palpate_study::sim::closed_loop::LoopError;
use palpate_testbed::reference::ReferenceError;
use pyo3::exceptions::{PyOSError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use toml::Value;

use crate::names::refused;

/// A scene that has been read and checked.
#[pyclass(frozen, subclass, name = "Scene", module = "palpate._palpate")]
pub struct PyScene {
    /// The scene, with the source location of each value.
    file: ContactFile,
    /// Name in reports: its file or its title.
    pub name: String,
    /// Whether the text is a user's file, so that messages can point at its lines.
    is_file: bool,
    text: String,
    /// Folder of the files that the scene names.
    folder: PathBuf,
}

impl PyScene {
    /// Returns the scene.
    pub fn scene(&self) -> &Scene {
        &self.file.scene
    }

    /// Returns the reason why `method` cannot run this scene, with the source location if it is known.
    pub fn wrong(&self, method: MethodName, error: &LoopError) -> PyErr {
        let at = |parameter| self.file.at(parameter, error.to_string());
        let of_window = match self.scene().measure {
            Measure::Collisions(_) => SceneParameter::Collisions,
            Measure::Duration(_) => SceneParameter::Duration,
        };
        let placed = match error {
            LoopError::Setup(setup) => self.file.locate(method, setup),
            LoopError::TooFewCollisions { .. }
            | LoopError::TooLong(_)
            | LoopError::Ideal(
                ReferenceError::TooFewCollisions { .. } | ReferenceError::NoCollisions,
            ) => at(of_window),
            LoopError::Ideal(ReferenceError::Scene(_))
            | LoopError::Bench(_)
            | LoopError::AnotherScene => self.file.as_a_whole(error.to_string()),
        };
        if self.is_file {
            refused(placed)
        } else {
            refused(placed.message)
        }
    }
}

#[pymethods]
impl PyScene {
    /// Parses a scene. `name` is its name in messages and reports; files that it names are searched in `folder`.
    #[new]
    fn new(text: String, name: Option<String>, folder: PathBuf) -> PyResult<Self> {
        let called = name.clone().unwrap_or_else(|| "scene".into());
        // `beside` takes a file path and searches in its folder.
        let file = ContactFile::parse_with(&called, &text, &mut beside(&folder.join("scene")))
            .map_err(|errors| {
                refused(if name.is_some() {
                    errors.to_string()
                } else {
                    messages(&errors)
                })
            })?;
        Ok(Self {
            is_file: name.is_some(),
            name: name.unwrap_or_else(|| file.scene.title.clone()),
            file,
            text,
            folder,
        })
    }

    /// Title for tables and figures.
    #[getter]
    fn title(&self) -> &str {
        &self.scene().title
    }

    /// Default method of the scene.
    #[getter]
    fn method(&self) -> &'static str {
        self.scene().method.name()
    }

    /// Returns text, name if the text is a file, and folder, from which the scene can be made again.
    fn parts(&self) -> (&str, Option<&str>, &Path) {
        (
            &self.text,
            self.is_file.then_some(&*self.name),
            &self.folder,
        )
    }
}

/// Returns the messages with table and key in place of a line, because the text was generated.
pub fn messages(errors: &SceneErrors) -> String {
    // A message on a key of one contact begins with the key, without the number of the only device, body or contact.
    let says = |message: &str, place: &str| {
        message.starts_with(place) || message.starts_with(&place.replacen("[0]", "", 1))
    };
    let messages = errors.iter().map(|error| match place(error) {
        Some(place) if !says(&error.message, &place) => {
            format!("{place}: {}", error.message)
        }
        _ => error.message.clone(),
    });
    messages.collect::<Vec<_>>().join("\n")
}

/// Returns the location of an error in the tables, such as `body[0].shape.sphere.radius_m`; None for the whole scene.
fn place(error: &SceneError) -> Option<String> {
    if error.span.start == 0 {
        return None;
    }
    let mut table = String::new();
    // Number of elements of each array of tables so far.
    let mut counts: HashMap<&str, usize> = HashMap::new();
    let mut key = None;
    for line in error.source_text.lines().take(error.line) {
        key = None;
        if let Some(name) = line
            .strip_prefix("[[")
            .and_then(|line| line.strip_suffix("]]"))
        {
            let count = counts.entry(name).or_default();
            table = format!("{name}[{count}]");
            *count += 1;
        } else if let Some(name) = line
            .strip_prefix('[')
            .and_then(|line| line.strip_suffix(']'))
        {
            // A table within the last element of an array of tables.
            table = match name.split_once('.') {
                Some((first, rest)) if counts.contains_key(first) => {
                    format!("{first}[{}].{rest}", counts[first] - 1)
                }
                _ => name.to_owned(),
            };
        } else {
            key = line.split_once(" = ").map(|(key, _)| key);
        }
    }
    let parts = [Some(table.as_str()).filter(|table| !table.is_empty()), key];
    let place = parts.into_iter().flatten().collect::<Vec<_>>().join(".");
    (!place.is_empty()).then_some(place)
}

/// Reads a scene file and returns its text, its name in messages, and its folder.
#[pyfunction]
pub fn read_scene(path: PathBuf) -> PyResult<(String, String, PathBuf)> {
    let name = path.display().to_string();
    let bytes = palpate_scene::scene_bytes(&path).map_err(|error| of_file(&error, &name))?;
    let text = String::from_utf8(bytes)
        .map_err(|_| refused(format!("{name}: not UTF-8; save the scene as UTF-8 text")))?;
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    Ok((text, name, folder))
}

/// Returns the question whether a period is in milliseconds, if it is implausible for a haptic loop.
#[pyfunction]
pub fn period_question(name: &str, usual: &str, period: f64) -> Option<String> {
    palpate_scene::period_question(name, usual, period)
}

/// Returns the question whether a lag is in milliseconds, if it is implausible for a haptic device.
#[pyfunction]
pub fn lag_question(name: &str, usual: &str, lag: f64) -> Option<String> {
    palpate_scene::lag_question(name, usual, lag)
}

/// Converts tables of Python to the text of a scene file.
#[pyfunction]
pub fn to_toml(tables: &Bound<'_, PyDict>) -> PyResult<String> {
    let value = table(tables, "scene", 0)?;
    toml::to_string(&value).map_err(refused)
}

/// Converts the text of a scene file to tables of Python.
#[pyfunction]
pub fn from_toml<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    let table: toml::Table = text.parse().map_err(refused)?;
    to_python(py, &Value::Table(table))
}

fn to_python<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::String(text) => PyString::new(py, text).into_any(),
        Value::Integer(number) => number.into_pyobject(py)?.into_any(),
        Value::Float(number) => PyFloat::new(py, *number).into_any(),
        Value::Boolean(on) => PyBool::new(py, *on).to_owned().into_any(),
        Value::Datetime(time) => PyString::new(py, &time.to_string()).into_any(),
        Value::Array(items) => {
            let items: PyResult<Vec<_>> = items.iter().map(|item| to_python(py, item)).collect();
            PyList::new(py, items?)?.into_any()
        }
        Value::Table(table) => {
            let made = PyDict::new(py);
            for (key, item) in table {
                made.set_item(key, to_python(py, item)?)?;
            }
            made.into_any()
        }
    })
}

/// Largest nesting depth of tables and lists: no file is deeper, and a recursive structure would not end.
const DEEPEST: usize = 32;

fn table(given: &Bound<'_, PyDict>, place: &str, depth: usize) -> PyResult<Value> {
    let mut made = toml::Table::new();
    for (key, item) in given.iter() {
        let key: String = key.extract().map_err(|_| {
            PyTypeError::new_err(format!(
                "{place}: a key must be a text, such as \"mass_kg\""
            ))
        })?;
        let place = format!("{place}.{key}");
        // A missing key takes its default.
        if !item.is_none() {
            made.insert(key, value(&item, &place, depth)?);
        }
    }
    Ok(Value::Table(made))
}

fn value(given: &Bound<'_, PyAny>, place: &str, depth: usize) -> PyResult<Value> {
    if depth == DEEPEST {
        // The first names of the path identify the location.
        let place: Vec<_> = place.split('.').take(4).collect();
        return Err(refused(format!(
            "{} has tables or lists nested more than {DEEPEST} deep, for example one that contains itself",
            place.join(".")
        )));
    }
    let depth = depth + 1;
    if let Ok(on) = given.cast::<PyBool>() {
        return Ok(Value::Boolean(on.is_true()));
    }
    if let Ok(text) = given.cast::<PyString>() {
        return Ok(Value::String(text.to_str()?.to_owned()));
    }
    if given.is_instance_of::<PyInt>() {
        let number: i64 = given.extract().map_err(|_| {
            refused(format!(
                "{place} is a whole number of more than 64 bits; give a float"
            ))
        })?;
        return Ok(Value::Integer(number));
    }
    if let Ok(dictionary) = given.cast::<PyDict>() {
        return table(dictionary, place, depth);
    }
    if given.is_instance_of::<PyList>() || given.is_instance_of::<PyTuple>() {
        let items = given.try_iter()?;
        let items: PyResult<Vec<_>> = items.map(|item| value(&item?, place, depth)).collect();
        return Ok(Value::Array(items?));
    }
    // Converts NumPy scalars to Python numbers and arrays to lists.
    if let Ok(plain) = given.call_method0("tolist")
        && !plain.get_type().is(given.get_type())
    {
        return value(&plain, place, depth);
    }
    // Integer types of other packages implement `__index__`; other number types convert to float.
    if let Ok(index) = given.call_method0("__index__") {
        return Ok(Value::Integer(index.extract()?));
    }
    if let Ok(number) = given.extract::<f64>() {
        return Ok(Value::Float(number));
    }
    Err(PyTypeError::new_err(format!(
        "{place} is {}, but must be a number, a text, True or False, a list or a dictionary",
        given.repr()?
    )))
}

/// Converts a file error to a Python exception that knows the file name.
fn of_file(error: &std::io::Error, name: &str) -> PyErr {
    match error.raw_os_error() {
        // Python derives the exception type, such as FileNotFoundError, from the number.
        Some(number) => {
            let said = error.to_string();
            let said = said.split(" (os error").next().unwrap_or(&said).to_owned();
            PyOSError::new_err((number, said, name.to_owned()))
        }
        None => PyOSError::new_err(format!("{name}: {error}")),
    }
}
