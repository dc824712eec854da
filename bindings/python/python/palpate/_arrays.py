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
