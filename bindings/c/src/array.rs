//! Arrays that C hands over.

use core::slice;

use crate::status::Refusal;

/// The elements of an array of C's.
///
/// # Safety
/// `first` is NULL or to `count` elements, which nobody changes during `'a`.
pub unsafe fn array<'a, T>(
    first: *const T,
    count: usize,
    name: &'static str,
) -> Result<&'a [T], Refusal<'static>> {
    if count == 0 {
        return Ok(&[]);
    }
    checked(first, count, name)?;
    // SAFETY: not NULL, aligned, no longer than memory is, and as many elements are there by the caller's word.
    Ok(unsafe { slice::from_raw_parts(first, count) })
}

/// The elements of an array of C's that is to be filled.
///
/// # Safety
/// `first` is NULL or to `count` elements, which nobody else looks at during `'a`.
pub unsafe fn array_mut<'a, T>(
    first: *mut T,
    count: usize,
    name: &'static str,
) -> Result<&'a mut [T], Refusal<'static>> {
    if count == 0 {
        return Ok(&mut []);
    }
    checked(first, count, name)?;
    // SAFETY: as in `array`.
    Ok(unsafe { slice::from_raw_parts_mut(first, count) })
}

/// Refuses what can be no array of so many.
fn checked<T>(first: *const T, count: usize, name: &'static str) -> Result<(), Refusal<'static>> {
    if first.is_null() {
        return Err(Refusal::Null(name));
    }
    if !first.is_aligned() || count > isize::MAX as usize / size_of::<T>() {
        return Err(Refusal::Array { name, count });
    }
    Ok(())
}
