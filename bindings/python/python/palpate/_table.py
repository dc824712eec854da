"""Conversion of arrays of records to tables of other packages."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def of_records(rows: NDArray[np.void]) -> dict[str, NDArray[Any]]:
    """Returns the fields of an array of records, each as a separate array."""
    return {name: np.ascontiguousarray(rows[name]) for name in rows.dtype.names or ()}


class Table:
    """Conversion of rows to a table of pandas or Polars."""

    __slots__ = ()

    def _columns(self) -> dict[str, NDArray[Any]]:
        """Returns the columns by name."""
        raise NotImplementedError

    def to_pandas(self) -> Any:
        """Returns the rows as a `pandas.DataFrame`.

        Raises:
            ImportError: pandas is not installed.
        """
        import pandas

        return pandas.DataFrame(self._columns())

    def to_polars(self) -> Any:
        """Returns the rows as a `polars.DataFrame`.

        Raises:
            ImportError: Polars is not installed.
        """
        import polars

        return polars.DataFrame(self._columns())
