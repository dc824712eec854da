//! Arrays of Python as rows of numbers, with a memory layout that Rust can read.

use numpy::ndarray::{ArrayView2, Dimension};
use numpy::{PyReadonlyArray, PyReadonlyArray2, PyUntypedArrayMethods as _};
use pyo3::prelude::*;

use crate::names::refused;

/// Returns the rows of the argument called `name`. The Python files pass aligned arrays; direct callers of the compiled
/// part may not.
///
/// # Errors
/// Misaligned 64-bit numbers.
pub fn rows<'a>(name: &str, array: &'a PyReadonlyArray2<'_, f64>) -> PyResult<ArrayView2<'a, f64>> {
    let size = isize::try_from(size_of::<f64>()).unwrap_or(isize::MAX);
    let is_even = array.strides().iter().all(|stride| stride % size == 0);
    check_aligned(name, array, is_even)?;
    Ok(array.as_array())
}

/// Returns the numbers of the argument called `name`, row after row.
///
/// # Errors
/// Misaligned 64-bit numbers, or gaps between them.
pub fn in_a_row<'a, D: Dimension>(
    name: &str,
    array: &'a PyReadonlyArray<'_, f64, D>,
) -> PyResult<&'a [f64]> {
    check_aligned(name, array, true)?;
    array
        .as_slice()
        .map_err(|error| refused(format!("{name}: {error}")))
}

/// Checks that the numbers of the argument called `name` are aligned in memory. `is_even`: each distance between them is
/// a multiple of their size.
///
/// # Errors
/// They are not.
pub fn check_aligned(name: &str, array: &Bound<'_, PyAny>, is_even: bool) -> PyResult<()> {
    if is_even && array.getattr("flags")?.getattr("aligned")?.extract()? {
        return Ok(());
    }
    Err(refused(format!(
        "{name} is not aligned in memory as 64-bit numbers; give numpy.require({name}, float, [\"C\", \"A\"])"
    )))
}
