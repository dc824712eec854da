//! Reads arguments from the dictionaries of the Python files and names an argument of the wrong type.

use pyo3::PyTypeInfo as _;
use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Prefix of pyo3's message for an argument of the wrong type.
const FAILED: &str = "failed to extract field ";

/// Reads a dictionary of arguments.
///
/// # Errors
/// An argument of the wrong type, by its name.
pub fn read<'py, T>(given: &Bound<'py, PyDict>) -> PyResult<T>
where
    T: for<'a> FromPyObject<'a, 'py, Error = PyErr>,
{
    given.extract().map_err(|error| named(given, error))
}

/// Adds the name, the value and the required type of the wrong argument to an error.
pub fn named(given: &Bound<'_, PyDict>, error: PyErr) -> PyErr {
    let py = given.py();
    let said = error.value(py).to_string();
    let name = said
        .strip_prefix(FAILED)
        .and_then(|field| field.rsplit('.').next());
    let Some(name) = name else {
        return error;
    };
    let value = given.get_item(name).ok().flatten();
    let value = value.and_then(|value| value.repr().ok());
    let value = value.map(|value| shortened(value.to_string()));
    let Some((value, cause)) = value.zip(error.cause(py)) else {
        return error;
    };
    let message = format!("{name} is {value}: {}", cause.value(py));
    if cause.get_type(py).is(PyTypeError::type_object(py)) {
        PyTypeError::new_err(message)
    } else if cause.is_instance_of::<PyOverflowError>(py) {
        // A number that is negative or too large for the argument.
        PyValueError::new_err(message)
    } else {
        error
    }
}

/// Returns the beginning of a long text.
fn shortened(text: String) -> String {
    match text.char_indices().nth(40) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}
