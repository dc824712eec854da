"""Conversion of the caller's arrays to the memory layout of the compiled module."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray


def numbers(name: str, given: ArrayLike) -> NDArray[np.float64]:
    """Returns an argument as a C-contiguous array of native doubles. Any layout, byte order and width is accepted.

    An array that already has this layout is returned without a copy.

    Raises:
        ValueError: The argument is not an array of real numbers, or has masked values.
    """
    if isinstance(given, np.ma.MaskedArray) and np.ma.is_masked(given):
        raise ValueError(f"{name} has masked values, but every value must be known")
    try:
        array = np.asarray(given)
    except ValueError as error:
        raise ValueError(f"{name} is not an array of numbers: {error}") from None
    if array.dtype.kind not in "fiu":
        raise ValueError(f"{name} is of type {array.dtype}, but must be of numbers")
    if array.dtype == np.float64 and array.dtype.isnative and array.flags.c_contiguous and array.flags.aligned:
        return array
    return np.require(array, np.float64, ["C", "A"])


def known(name: str, given: NDArray[np.float64]) -> NDArray[np.float64]:
    """Checks that all numbers of an argument are finite, and returns the argument.

    Raises:
        ValueError: A number is not finite; the message has its index.
    """
    if not np.isfinite(given).all():
        place = tuple(int(at) for at in np.argwhere(~np.isfinite(given))[0])
        raise ValueError(f"{name}[{', '.join(map(str, place))}] is {given[place]}, but must be finite")
    return given


def result_array(out: NDArray[np.float64] | None, shape: tuple[int, ...], *given: Any) -> NDArray[np.float64]:
    """Returns the array for a result: `out` if it is one, else a new one. `given`: arrays or `None`.

    Raises:
        ValueError: `out` does not fit, or shares memory with a given array.
    """
    if out is None:
        return np.empty(shape)
    result = np.asarray(out)
    is_fit = result.dtype == np.float64 and result.dtype.isnative and result.shape == shape
    if not (is_fit and result.flags.c_contiguous and result.flags.aligned and result.flags.writeable):
        raise ValueError(f"out must be a writable array of the shape {shape}, of native doubles in a row")
    if any(np.shares_memory(result, of) for of in given if of is not None):
        raise ValueError("out shares memory with an argument, but must be another array")
    return result


def for_each(name: str, given: ArrayLike | None, count: int) -> NDArray[np.float64] | None:
    """Returns an argument that is a number for all or an array with one for each as an array; `None` for `None`.

    Raises:
        ValueError: The argument has another shape.
    """
    if given is None:
        return None
    array = numbers(name, given)
    if array.shape not in ((), (count,)):
        raise ValueError(f"{name} has the shape {array.shape}, but must be a number or have ({count},)")
    return np.ascontiguousarray(np.broadcast_to(array, count))


def chosen(mask: ArrayLike | None, count: int) -> NDArray[np.bool_] | None:
    """Returns a mask of `count` truth values as an array; `None` for `None`.

    Raises:
        ValueError: The mask has another shape or type.
    """
    if mask is None:
        return None
    array = np.asarray(mask)
    if array.dtype != np.bool_ or array.shape != (count,):
        raise ValueError(f"mask must have {count} truth values, one for each")
    return np.ascontiguousarray(array)


def row(name: str, given: ArrayLike) -> list[float]:
    """Returns the numbers of a one-dimensional argument as a list.

    Raises:
        ValueError: As for `numbers`; or the argument does not have one dimension.
    """
    array = numbers(name, given)
    if array.ndim != 1:
        raise ValueError(f"{name} has the shape {array.shape}, but must have one dimension")
    return array.tolist()  # type: ignore[no-any-return]


def plain(value: Any) -> Any:
    """Converts a NumPy scalar to a Python number, for JSON; returns other values unchanged."""
    return value.item() if isinstance(value, np.generic) or (isinstance(value, np.ndarray) and value.ndim == 0) else value
