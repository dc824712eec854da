"""Arrays of numbers, as callers have them and as the compiled part takes them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray


def numbers(name: str, given: ArrayLike) -> NDArray[np.float64]:
    """The numbers of an argument in double precision, side by side in memory: whatever layout, byte order and width they had.

    Where they are so already, this is the caller's own array.

    Raises:
        ValueError: What is no array of real numbers, or has numbers that are masked.
    """
    if isinstance(given, np.ma.MaskedArray) and np.ma.is_masked(given):
        raise ValueError(f"{name} has numbers that are masked, but each must be known")
    try:
        array = np.asarray(given)
    except ValueError as error:
        raise ValueError(f"{name} is no array of numbers: {error}") from None
    if array.dtype.kind not in "fiu":
        raise ValueError(f"{name} is of type {array.dtype}, but must be of numbers")
    if array.dtype == np.float64 and array.dtype.isnative and array.flags.c_contiguous and array.flags.aligned:
        return array
    return np.require(array, np.float64, ["C", "A"])


def known(name: str, given: NDArray[np.float64]) -> NDArray[np.float64]:
    """The numbers of an argument, each of which has to be finite.

    Raises:
        ValueError: One that is not, with its place.
    """
    if not np.isfinite(given).all():
        place = tuple(int(at) for at in np.argwhere(~np.isfinite(given))[0])
        raise ValueError(f"{name}[{', '.join(map(str, place))}] is {given[place]}, but must be finite")
    return given


def row(name: str, given: ArrayLike) -> list[float]:
    """The numbers of an argument that is one row.

    Raises:
        ValueError: As those of `numbers`; a shape that is not of one dimension.
    """
    array = numbers(name, given)
    if array.ndim != 1:
        raise ValueError(f"{name} has the shape {array.shape}, but must have one dimension")
    return array.tolist()  # type: ignore[no-any-return]


def plain(value: Any) -> Any:
    """A number of NumPy as Python's own, which JSON can write; other values as they are."""
    return value.item() if isinstance(value, np.generic) or (isinstance(value, np.ndarray) and value.ndim == 0) else value
