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

/// Room for a struct of C's, which has been looked at: what is written into it finds its place.
pub struct Room<T> {
    out: *mut T,
    /// Its size, which stays the caller's.
    size: usize,
}

impl<T: SizedStruct> Room<T> {
    /// The room at `out`.
    ///
    /// # Safety
    /// `out` is NULL or points to as many bytes as the `usize` there says, which stay until they are written.
    #[inline]
    pub unsafe fn at<'a>(out: *mut T) -> Result<Self, Refusal<'a>> {
        if out.is_null() {
            return Err(Refusal::Null(T::NAME));
        }
        // SAFETY: not NULL, and a `usize` is there by the caller's word.
        let size = unsafe { out.cast::<usize>().read_unaligned() };
        let known = size_of::<T>();
        if size < known {
            return Err(Refusal::StructSize {
                name: T::NAME,
                given: size,
                known,
            });
        }
        Ok(Self { out, size })
    }

    /// The same, where NULL asks for nothing.
    ///
    /// # Safety
    /// As for [`at`](Self::at).
    #[inline]
    pub unsafe fn if_asked<'a>(out: *mut T) -> Result<Option<Self>, Refusal<'a>> {
        if out.is_null() {
            return Ok(None);
        }
        // SAFETY: as the caller says.
        unsafe { Self::at(out) }.map(Some)
    }

    /// Writes `value` but for its first `usize`.
    #[inline]
    pub fn write(self, value: T) {
        // SAFETY: as many bytes as a `T` has are there by the word of who has made the room.
        unsafe {
            self.out.write_unaligned(value);
            self.out.cast::<usize>().write_unaligned(self.size);
        }
    }
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
    // SAFETY: as the caller says.
    unsafe { Room::at(out) }?.write(value());
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
