//! Structs that begin with their own size.

use crate::status::Refusal;

/// A C struct that begins with `struct_size` and is valid for any bit pattern.
///
/// # Safety
/// The type is `#[repr(C)]`, begins with a `usize`, and contains only numbers and raw pointers.
pub unsafe trait SizedStruct: Copy {
    /// Name of the struct in C.
    const NAME: &'static str;
}

/// Reads the struct at `given`. A larger struct of a newer header is accepted if the unknown bytes are 0.
///
/// # Safety
/// `given` is NULL or points to as many bytes as its leading `usize` states.
#[inline]
pub unsafe fn read<'a, T: SizedStruct>(given: *const T) -> Result<T, Refusal<'a>> {
    if given.is_null() {
        return Err(Refusal::Null(T::NAME));
    }
    // SAFETY: not NULL, and the caller guarantees a leading `usize`.
    let size = unsafe { given.cast::<usize>().read_unaligned() };
    let known = size_of::<T>();
    // SAFETY: the caller guarantees `size` bytes.
    if size != known && !unsafe { is_newer(given, size) } {
        return Err(Refusal::StructSize {
            name: T::NAME,
            given: size,
            known,
        });
    }
    // SAFETY: at least `known` bytes exist, and any bit pattern is a valid `T`.
    Ok(unsafe { given.read_unaligned() })
}

/// Whether `size` bytes are a `T` of a newer header whose additional fields are all 0.
///
/// # Safety
/// `given` points to `size` bytes.
#[cold]
unsafe fn is_newer<T: SizedStruct>(given: *const T, size: usize) -> bool {
    let known = size_of::<T>();
    // A size of megabytes means an uninitialised struct.
    (known..=1 << 16).contains(&size)
        // SAFETY: the caller guarantees `size` bytes.
        && (known..size).all(|at| unsafe { given.cast::<u8>().add(at).read() } == 0)
}

/// Checked output memory for a C struct: writing to it cannot fail.
pub struct Room<T> {
    out: *mut T,
    /// Size set by the caller, which is preserved.
    size: usize,
}

impl<T: SizedStruct> Room<T> {
    /// Checks the memory at `out`.
    ///
    /// # Safety
    /// `out` is NULL or points to as many bytes as its leading `usize` states; they stay valid until written.
    #[inline]
    pub unsafe fn at<'a>(out: *mut T) -> Result<Self, Refusal<'a>> {
        if out.is_null() {
            return Err(Refusal::Null(T::NAME));
        }
        // SAFETY: not NULL, and the caller guarantees a leading `usize`.
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

    /// Checks the memory at `out`; NULL means no output.
    ///
    /// # Safety
    /// As for [`at`](Self::at).
    #[inline]
    pub unsafe fn if_asked<'a>(out: *mut T) -> Result<Option<Self>, Refusal<'a>> {
        if out.is_null() {
            return Ok(None);
        }
        // SAFETY: guaranteed by the caller.
        unsafe { Self::at(out) }.map(Some)
    }

    /// Writes `value` except its leading `usize`.
    #[inline]
    pub fn write(self, value: T) {
        // SAFETY: the creator of this `Room` guarantees the size of a `T`.
        unsafe {
            self.out.write_unaligned(value);
            self.out.cast::<usize>().write_unaligned(self.size);
        }
    }
}

/// Writes the result of `value` to the struct at `out` and preserves its leading `usize`.
///
/// # Safety
/// `out` is NULL or points to as many bytes as its leading `usize` states.
#[inline]
pub unsafe fn write<'a, T: SizedStruct>(
    out: *mut T,
    value: impl FnOnce() -> T,
) -> Result<(), Refusal<'a>> {
    // SAFETY: guaranteed by the caller.
    unsafe { Room::at(out) }?.write(value());
    Ok(())
}

/// Writes `value` and sets the remaining bytes of `size`, fields of a newer header, to 0.
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
    // SAFETY: the caller guarantees `size` writable bytes, which are at least `known`.
    unsafe {
        out.write_unaligned(value);
        out.cast::<u8>().add(known).write_bytes(0, size - known);
        out.cast::<usize>().write_unaligned(size);
    }
    Ok(())
}
