"""`render`: renders a recorded motion with several methods; `read_trace`: reads the table of such a motion."""

from __future__ import annotations

import os
from typing import Mapping, NamedTuple, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _palpate
from ._arrays import numbers
from ._fixed import question_period
from ._report import Runs


class Trace(NamedTuple):
    """A recorded motion along one axis."""

    t: NDArray[np.float64]
    """Times [s], increasing."""
    x: NDArray[np.float64]
    """Positions [m]."""
    force: NDArray[np.float64] | None
    """Force on the device from each sample until the next [N]; `None` if the table has none."""
    virtual_force: NDArray[np.float64] | None
    """Virtual force on the object from each sample until the next [N]; `None` if the table has none."""
    left_out: int
    """Number of skipped samples without a value."""


def read_trace(
    path: str | os.PathLike[str],
    *,
    columns: Mapping[str, str] | None = None,
    unit: str | None = None,
    time_unit: str | None = None,
    delimiter: str | None = None,
    decimal_comma: bool = False,
    skip_missing: bool = False,
    begin: float | None = None,
    end: float | None = None,
) -> Trace:
    """Reads the table of a recorded motion, as `palpate render` does.

        trace = palpate.read_trace("tap.csv", columns={"t": "time", "x": "X"}, unit="mm", time_unit="ms")
        palpate.render(trace.t, trace.x, stiffness=500.0, mass=math.inf, period=0.001)

    Args:
        path: Table with a header. Without `columns` the names are `t_s` and `position_m`. A column name or a row of
            units below the header can state other units.
        columns: Names of the columns of `t`, `x`, `force` and `virtual_force`; `"#2"` is the second column.
        unit: Unit of the positions: `"m"`, `"cm"`, `"mm"` or `"um"`. `None`: that of the table, else metres; an
            implausibly long or fast motion is then rejected.
        time_unit: Unit of the times: `"s"`, `"ms"`, `"us"` or `"ns"`. `None`: that of the table, else seconds; samples
            more than 0.25 s or less than 10 us apart are then rejected.
        delimiter: Separator of the columns: `","`, `";"` or `"\\t"`. `None`: that of the header.
        decimal_comma: Whether numbers have a decimal comma.
        skip_missing: Whether samples without a value are skipped; otherwise they are an error.
        begin: First time of the table to use [s].
        end: Last time of the table to use [s].

    Raises:
        ValueError: The file is not such a table.
        OSError: The file cannot be read.
    """
    layout = {
        "columns": [(str(key), str(name)) for key, name in (columns or {}).items()],
        "unit": unit,
        "time_unit": time_unit,
        "delimiter": delimiter,
        "decimal_comma": decimal_comma,
        "skip_missing": skip_missing,
        "begin": begin,
        "end": end,
    }
    return Trace(*_palpate.read_trace(path, layout))


def render(
    t: ArrayLike,
    x: ArrayLike,
    *,
    stiffness: float,
    mass: float,
    period: float,
    method: str | Sequence[str] = "coupled",
    device_mass: float | None = None,
    force: float = 0.0,
    virtual_force: ArrayLike | None = None,
    object_position: float = 0.0,
    object_velocity: float = 0.0,
    side: str = "positive",
    unilateral: bool = False,
    force_limit: float = float("inf"),
    slew_limit: float | None = None,
    speed_limit: float | None = 100.0,
    largest_gap: float | None = None,
    guard: str = "off",
    guard_speed: float = 1.0,
    guard_allowance: float | None = None,
    guard_acceleration: float | None = None,
    guard_hand_force: float | None = None,
    guard_mass: float | None = None,
    guard_learn_mass: bool = False,
    guard_recovery: float | None = None,
    delay: float = 0.0,
    delay_deviation: float = 0.0,
    lag: float = 0.0,
    lag_deviation: float = 0.0,
    gain: float = 1.0,
    gain_deviation: float = 0.0,
    encoder_quantum: float = 0.0,
    unit: str | None = None,
    time_unit: str | None = None,
    skip_missing: bool = False,
    title: str = "a motion",
    **settings: float | str | bool,
) -> Runs:
    """Renders a recorded motion, as `palpate render` does. The device follows the recording whatever the force.

    The motion is sampled at the ticks of a loop of `period`. A recorded sample at such a time is used exactly; other
    positions are interpolated linearly. The default is no force limit, because no motor is driven.

    Args:
        t: Times [s], increasing; one dimension.
        x: Positions of the device [m, or `unit`], as many as times.
        stiffness: Stiffness K of the contact [N/m].
        mass: Mass M of the object [kg]; `math.inf`: a wall.
        period: Nominal period T of the loop [s].
        method: Name of a method, of `palpate.METHODS`, several names, or `"all"`.
        virtual_force: Virtual force on the object from each time until the next, in addition to `force` [N].
        force_limit: Largest held force [N]; `math.inf`: no limit.
        unit: Unit of the positions: `"m"`, `"cm"`, `"mm"` or `"um"`. `None`: metres; an implausibly long or fast motion
            is then rejected.
        time_unit: Unit of the times: `"s"`, `"ms"`, `"us"` or `"ns"`. `None`: seconds; samples more than 0.25 s or less
            than 10 us apart are then rejected.
        skip_missing: Whether samples with a NaN time or position are skipped; otherwise they are an error.
        title: Name of the motion in the report.
        settings: Settings of the methods, such as `damping`: `palpate.METHODS[method].settings` lists them.

    The other arguments are those of `palpate.Renderer`.

    Returns:
        The report, and the ticks of each method as structured arrays.

    Raises:
        ValueError: An argument is not allowed, and the message names it; or the motion is not valid.
    """
    given = dict(locals())
    question_period(period)
    for other in ("t", "x", "virtual_force", "method", "unit", "time_unit", "skip_missing", "title", "settings"):
        del given[other]
    # A recorded motion is rendered with constants.
    given["hold"] = "constant"
    # Copy: the figure is drawn later, and the caller may change its arrays before that.
    times, positions, left_out = _of_one_dimension("t", t), _of_one_dimension("x", x), 0
    forces = _of_one_dimension("virtual_force", () if virtual_force is None else virtual_force)
    if virtual_force is not None and forces.shape != times.shape:
        raise ValueError(f"virtual_force has {len(forces)} numbers, but must have {len(times)}, one for each time")
    if times.shape == positions.shape and (missing := np.isnan(times) | np.isnan(positions)).any():
        left_out = int(missing.sum())
        if not skip_missing:
            first = int(np.argmax(~np.isfinite(times) | ~np.isfinite(positions)))
            name, unit_of, value = ("time", "s", times[first]) if not np.isfinite(times[first]) else ("position", "m", positions[first])
            said = "NaN" if np.isnan(value) else value
            raise ValueError(
                f"{name} {said} {unit_of} at index {first} is not finite; skip_missing=True skips NaN samples"
            )
        times, positions = times[~missing], positions[~missing]
        forces = forces if virtual_force is None else forces[~missing]
    motion = (times, positions, forces, title, unit, time_unit, left_out)
    arguments = (motion, method, given, settings)
    return Runs._of_runs(_palpate.render(*arguments), (_palpate.render_figure, arguments))


def _of_one_dimension(name: str, given: ArrayLike) -> NDArray[np.float64]:
    """Returns a copy of the numbers of a one-dimensional argument."""
    array = numbers(name, given)
    if array.ndim != 1:
        raise ValueError(f"{name} has the shape {array.shape}, but must have one dimension")
    return array.copy()
