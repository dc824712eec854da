"""Arrays of records as tables of other packages."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def of_records(rows: NDArray[np.void]) -> dict[str, NDArray[Any]]:
    """The fields of an array of records, each as an array of its own."""
    return {name: np.ascontiguousarray(rows[name]) for name in rows.dtype.names or ()}


class Table:
    """What has rows, as a table of pandas or of Polars."""

    __slots__ = ()

    def _columns(self) -> dict[str, NDArray[Any]]:
        """The columns by their names."""
        raise NotImplementedError

    def to_pandas(self) -> Any:
        """The rows as a `pandas.DataFrame`.

        Raises:
            ImportError: pandas is not there.
        """
        import pandas

        return pandas.DataFrame(self._columns())

    def to_polars(self) -> Any:
        """The rows as a `polars.DataFrame`.

        Raises:
            ImportError: Polars is not there.
        """
        import polars

        return polars.DataFrame(self._columns())
