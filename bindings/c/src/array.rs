//! Arrays passed from C.

use core::slice;

use crate::status::Refusal;

/// Returns a C array as a slice.
///
/// # Safety
/// `first` is NULL or points to `count` elements that are not modified during `'a`.
pub unsafe fn array<'a, T>(
    first: *const T,
    count: usize,
    name: &'static str,
) -> Result<&'a [T], Refusal<'static>> {
    if count == 0 {
        return Ok(&[]);
    }
    checked(first, count, name)?;
    // SAFETY: not NULL, aligned, at most `isize::MAX` bytes; the caller guarantees `count` elements.
    Ok(unsafe { slice::from_raw_parts(first, count) })
}

/// Returns a C output array as a mutable slice.
///
/// # Safety
/// `first` is NULL or points to `count` elements that are not accessed otherwise during `'a`.
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

/// Rejects a NULL or misaligned pointer and a count that exceeds the address space.
fn checked<T>(first: *const T, count: usize, name: &'static str) -> Result<(), Refusal<'static>> {
    if first.is_null() {
        return Err(Refusal::Null(name));
    }
    if !first.is_aligned() || count > isize::MAX as usize / size_of::<T>() {
        return Err(Refusal::Array { name, count });
    }
    Ok(())
}
