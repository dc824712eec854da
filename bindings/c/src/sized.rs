//! Structs that begin with their own size.

use crate::status::Refusal;

/// A struct of C that begins with `struct_size` and is valid whatever its bytes are.
///
/// # Safety
/// `#[repr(C)]`, a `usize` first, and nothing but numbers and raw pointers.
pub unsafe trait SizedStruct: Copy {
    /// What C calls it.
    const NAME: &'static str;
}

/// The struct at `given`, which may be one of a newer header if what this library does not know is 0.
///
/// # Safety
/// `given` is NULL or points to as many bytes as the `usize` there says.
#[inline]
pub unsafe fn read<'a, T: SizedStruct>(given: *const T) -> Result<T, Refusal<'a>> {
    if given.is_null() {
        return Err(Refusal::Null(T::NAME));
    }
    // SAFETY: not NULL, and a `usize` is there by the caller's word.
    let size = unsafe { given.cast::<usize>().read_unaligned() };
    let known = size_of::<T>();
    // SAFETY: `size` bytes are there by the caller's word.
    if size != known && !unsafe { is_newer(given, size) } {
        return Err(Refusal::StructSize {
            name: T::NAME,
            given: size,
            known,
        });
    }
    // SAFETY: at least `known` bytes are there, and any bytes are a `T`.
    Ok(unsafe { given.read_unaligned() })
}

/// Whether `size` bytes are a `T` of a newer header, of which nothing is used that this library does not
/// know.
///
/// # Safety
/// `given` points to `size` bytes.
#[cold]
unsafe fn is_newer<T: SizedStruct>(given: *const T, size: usize) -> bool {
    let known = size_of::<T>();
    // Nothing has megabytes of parameters: that is a struct that nobody has filled.
    (known..=1 << 16).contains(&size)
        // SAFETY: `size` bytes are there by the caller's word.
        && (known..size).all(|at| unsafe { given.cast::<u8>().add(at).read() } == 0)
}

/// Writes what `value` gives in place of the struct at `out`, as much of it as there is room for; the first
/// `usize` stays the caller's.
///
/// # Safety
/// `out` is NULL or points to as many bytes as the `usize` there says.
#[inline]
pub unsafe fn write<'a, T: SizedStruct>(
    out: *mut T,
    value: impl FnOnce() -> T,
) -> Result<(), Refusal<'a>> {
    if out.is_null() {
        return Err(Refusal::Null(T::NAME));
    }
    // SAFETY: not NULL, and a `usize` is there by the caller's word.
    let given = unsafe { out.cast::<usize>().read_unaligned() };
    let known = size_of::<T>();
    if given < known {
        return Err(Refusal::StructSize {
            name: T::NAME,
            given,
            known,
        });
    }
    // SAFETY: at least `known` bytes are there by the caller's word.
    unsafe {
        out.write_unaligned(value());
        out.cast::<usize>().write_unaligned(given);
    }
    Ok(())
}

/// Fills `size` bytes with `value`, and with 0 what is beyond it: a struct of a newer header.
///
/// # Safety
/// `out` is NULL, or `size` bytes can be written there.
pub unsafe fn fill<'a, T: SizedStruct>(
    out: *mut T,
    size: usize,
    value: T,
) -> Result<(), Refusal<'a>> {
    if out.is_null() {
        return Err(Refusal::Null(T::NAME));
    }
    let known = size_of::<T>();
    if size < known {
        return Err(Refusal::StructSize {
            name: T::NAME,
            given: size,
            known,
        });
    }
    // SAFETY: `size` bytes can be written by the caller's word, and `known` of them at least.
    unsafe {
        out.write_unaligned(value);
        out.cast::<u8>().add(known).write_bytes(0, size - known);
        out.cast::<usize>().write_unaligned(size);
    }
    Ok(())
}
