//! Arrays of Python as rows of numbers, with a memory layout that Rust can read.

use numpy::ndarray::ArrayView2;
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods as _};
use pyo3::prelude::*;

use crate::names::refused;

/// Returns the rows of the argument called `name`. The Python files pass aligned arrays; direct callers of the compiled
/// part may not.
///
/// # Errors
/// Misaligned 64-bit numbers.
pub fn rows<'a>(name: &str, array: &'a PyReadonlyArray2<'_, f64>) -> PyResult<ArrayView2<'a, f64>> {
    let is_aligned: bool = array.getattr("flags")?.getattr("aligned")?.extract()?;
    let size = isize::try_from(size_of::<f64>()).unwrap_or(isize::MAX);
    if is_aligned && array.strides().iter().all(|stride| stride % size == 0) {
        return Ok(array.as_array());
    }
    Err(refused(format!(
        "{name} is not aligned in memory as 64-bit numbers; give numpy.require({name}, float, [\"C\", \"A\"])"
    )))
}

/// Returns the numbers of the argument called `name`, row after row.
///
/// # Errors
/// Another layout than rows of native 64-bit numbers without gaps.
pub fn in_a_row<'a>(name: &str, array: &'a PyReadonlyArray2<'_, f64>) -> PyResult<&'a [f64]> {
    array.as_slice().map_err(|_| {
        refused(format!(
            "{name} is not in a row in memory; give numpy.require({name}, float, [\"C\", \"A\"])"
        ))
    })
}
