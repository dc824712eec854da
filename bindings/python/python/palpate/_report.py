"""Reports: dictionaries with the fields of the program's `--json`, also as attributes."""

from __future__ import annotations

import html
import json
from typing import Any, Callable, Mapping, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from . import _palpate
from ._table import Table, of_records

_NUMBERS, _CODES, (_PHASES, _LIMITS, _FAULTS) = _palpate.columns()

PHASES: tuple[str, ...] = tuple(_PHASES)
"""Meaning of the field `phase` of a tick: `PHASES[code]`."""
LIMITS: tuple[str, ...] = tuple(_LIMITS)
"""Meaning of the field `limited` of a tick: `LIMITS[bit]` changed the force if the bit is set;
`beyond-guard` changes none: the device accelerated beyond the guard's bound, and the guard used its bound by speed."""
FAULTS: tuple[str, ...] = tuple(_FAULTS)
"""Meaning of the field `fault` of a tick: `FAULTS[code]`; the first means no fault."""

TICK: np.dtype[np.void] = np.dtype(
    {
        "names": [*_NUMBERS, *_CODES],
        "formats": [*("f8" for _ in _NUMBERS), *("u1" for _ in _CODES)],
        "offsets": [*(8 * place for place in range(len(_NUMBERS))), *(8 * len(_NUMBERS) + place for place in range(len(_CODES)))],
        "itemsize": 8 * (len(_NUMBERS) + 1),
    }
)
"""Fields of a tick of a run."""
IDEAL: np.dtype[np.void] = np.dtype([(name, "f8") for name in _palpate.ideal_columns()])
"""Fields of a point of the reference solution."""


class Fields(dict[str, Any]):
    """Dictionary whose keys are also attributes. A key with the name of a dictionary method, such as `values`, is only
    an item."""

    __slots__ = ()

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"there is no field {name}; the fields are {', '.join(self)}") from None

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self]


Figure = Union[str, Tuple[Callable[..., str], Tuple[Any, ...]], None]
"""Figure as SVG, or a function that draws it and its arguments."""


class Report(Fields):
    """Dictionary with the fields of the program's `--json`, also as attributes.

    `docs/schema` in palpate's repository lists the fields of each report; their names end with the units.
    `print(report)` prints the program's table. A notebook shows the program's figure if there is one, otherwise the
    table.
    """

    __slots__ = ("_figure", "_text")

    def __init__(self, fields: Mapping[str, Any] = {}, text: str = "", figure: Figure = None) -> None:
        super().__init__(fields)
        self._text = text
        self._figure = figure

    @classmethod
    def _of(cls, made: tuple[str, str], figure: Figure = None) -> Report:
        """Creates the report from its JSON and its text."""
        return cls(json.loads(made[0], object_hook=Fields), made[1], figure)

    def to_svg(self) -> str:
        """Returns the figure of the program's `--plot` as SVG.

        Figures of runs and of advice are drawn at the first call, which repeats the runs.

        Raises:
            ValueError: The report has no figure.
        """
        if self._figure is None:
            raise ValueError("this report has no figure: the program draws none, or a method is user-defined")
        if not isinstance(self._figure, str):
            draw, given = self._figure
            self._figure = draw(*given)
        return self._figure

    def to_json(self) -> str:
        """Returns the report as JSON."""
        return json.dumps(self, indent=2)

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return self._text

    def _repr_svg_(self) -> str | None:
        return None if self._figure is None else self.to_svg()

    def _repr_html_(self) -> str | None:
        # Notebooks prefer HTML to a figure.
        return f"<pre>{html.escape(self._text)}</pre>" if self._figure is None else None

    def __reduce__(self) -> Any:
        return (type(self), (dict(self), self._text, self._figure))


class Runs(Table, Report):
    """Runs of methods in one scene or on one motion: the report, and every tick.

    The fields are those of `palpate simulate --json` and `palpate render --json`; `methods` lists the results of each
    method.
    """

    __slots__ = ("ideal", "ticks")

    ticks: dict[str, NDArray[np.void]]
    """Ticks of each method, by name: arrays with the fields of `palpate.TICK`. Leaks and works are accumulated over the
    intervals before the sample. `force_on_device_n` is the force to command, `held_force_on_object_n` the force that
    acts from the sample on."""
    ideal: NDArray[np.void]
    """Reference solution on a fine grid: an array with the fields of `palpate.IDEAL`."""

    def __init__(
        self,
        fields: Mapping[str, Any] = {},
        text: str = "",
        ticks: Mapping[str, NDArray[np.void]] = {},
        ideal: NDArray[np.void] | None = None,
        figure: Figure = None,
    ) -> None:
        super().__init__(fields, text, figure)
        self.ticks = dict(ticks)
        self.ideal = np.empty(0, IDEAL) if ideal is None else ideal

    @classmethod
    def _of_runs(
        cls, made: tuple[str, str, Sequence[tuple[str, NDArray[np.uint64]]], NDArray[np.uint64]], figure: Figure
    ) -> Runs:
        fields, text, ticks, ideal = made
        return cls(
            json.loads(fields, object_hook=Fields),
            text,
            {method: words.view(TICK) for method, words in ticks},
            ideal.view(IDEAL),
            figure,
        )

    def method(self, name: str) -> Fields:
        """Returns the results of one method."""
        return _named(self["methods"], name)

    def _columns(self) -> dict[str, NDArray[Any]]:
        methods = np.concatenate([np.full(len(ticks), method) for method, ticks in self.ticks.items()])
        rows = np.concatenate([*self.ticks.values()])
        return {"method": methods, **of_records(rows)}

    def plot(self, ax: Any = None) -> Any:
        """Plots the held force of each method and the reference solution over time with matplotlib.

        Args:
            ax: Axes to draw in. `None`: new ones.

        Returns:
            The axes.

        Raises:
            ImportError: matplotlib is not installed.
        """
        if ax is None:
            from matplotlib import pyplot

            ax = pyplot.subplots()[1]
        force = "force_on_object_n"
        ax.plot(self.ideal["t_s"], self.ideal[force], color="0.7", linewidth=4, label="ideal")
        for method, ticks in self.ticks.items():
            ax.step(ticks["t_s"], ticks[f"held_{force}"], where="post", label=method)
        ax.set(title=self["title"], xlabel="time [s]", ylabel="force on the object [N]")
        ax.legend()
        return ax

    def __reduce__(self) -> Any:
        return (type(self), (dict(self), str(self), self.ticks, self.ideal, self._figure))


class WorldRuns(Report):
    """Runs of methods in a world: the report, and every force.

    The fields are those of `palpate simulate --json` for a world: `methods` lists the results of each method, in total
    and for each device and axis.
    """

    __slots__ = ("edges", "forces", "ideal")

    edges: NDArray[np.float64]
    """Edges of the intervals with constant held forces [s], one more than intervals."""
    forces: dict[str, NDArray[np.float64]]
    """Force on each device over each interval [N], by method name: arrays of the shape (devices, intervals, 3)."""
    ideal: NDArray[np.float64]
    """Mean force of the reference solution over each interval [N], in the same shape."""

    def __init__(
        self,
        fields: Mapping[str, Any] = {},
        text: str = "",
        edges: NDArray[np.float64] | None = None,
        forces: Mapping[str, NDArray[np.float64]] = {},
        ideal: NDArray[np.float64] | None = None,
        figure: Figure = None,
    ) -> None:
        super().__init__(fields, text, figure)
        self.edges = np.empty(0) if edges is None else edges
        self.forces = dict(forces)
        self.ideal = np.empty((0, 0, 3)) if ideal is None else ideal

    @classmethod
    def _of_worlds(
        cls,
        made: tuple[str, str, str | None, list[float], list[tuple[str, NDArray[np.float64]]], NDArray[np.float64]],
    ) -> WorldRuns:
        fields, text, figure, edges, forces, ideal = made
        return cls(json.loads(fields, object_hook=Fields), text, np.array(edges), dict(forces), ideal, figure)

    def method(self, name: str) -> Fields:
        """Returns the results of one method."""
        return _named(self["methods"], name)

    def plot(self, ax: Any = None, device: int = 0) -> Any:
        """Plots the magnitude of the force on a device and the mean force of the reference solution with matplotlib.

        Args:
            ax: Axes to draw in. `None`: new ones.
            device: Index of the device.

        Returns:
            The axes.

        Raises:
            ImportError: matplotlib is not installed.
        """
        if ax is None:
            from matplotlib import pyplot

            ax = pyplot.subplots()[1]
        starts = self.edges[:-1]
        ideal = np.linalg.norm(self.ideal[device], axis=1)
        ax.step(starts, ideal, where="post", color="0.7", linewidth=4, label="ideal, means")
        for method, forces in self.forces.items():
            ax.step(starts, np.linalg.norm(forces[device], axis=1), where="post", label=method)
        ax.set(title=self["title"], xlabel="time [s]", ylabel="force on the device [N]")
        ax.legend()
        return ax

    def __reduce__(self) -> Any:
        return (type(self), (dict(self), str(self), self.edges, self.forces, self.ideal, self._figure))


def _named(methods: Sequence[Fields], name: str) -> Fields:
    for method in methods:
        if method["method"] == name:
            return method
    names = ", ".join(method["method"] for method in methods)
    raise KeyError(f"there is no run of {name}; there are {names}")
