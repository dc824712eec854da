"""`render`: a motion that was recorded, rendered by some methods."""

from __future__ import annotations

from typing import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _palpate
from ._arrays import numbers
from ._report import Runs


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
    guard_allowance: float = 1e-3,
    delay: float = 0.0,
    delay_deviation: float = 0.0,
    lag: float = 0.0,
    lag_deviation: float = 0.0,
    gain: float = 1.0,
    gain_deviation: float = 0.0,
    encoder_quantum: float = 0.0,
    unit: str | None = None,
    title: str = "a motion",
    **settings: float | str | bool,
) -> Runs:
    """Renders a recorded motion: the device moves as it did, whatever the force, as in `palpate render`.

    The motion is taken at the instants of a loop of `period`. Where such an instant is a recorded one, the
    recorded position is taken exactly; others are interpolated on straight lines. No force is limited
    unless `force_limit` says so: nothing moves here.

    Args:
        t: Times [s], increasing; one dimension.
        x: Positions of the device [m, or `unit`], as many as times.
        stiffness: Stiffness K of the contact [N/m].
        mass: Mass M of the object [kg]; `math.inf`: a wall.
        period: Nominal period T of the loop [s].
        method: Name of a method, of `palpate.METHODS`, several names, or `"all"`.
        force_limit: Largest force that is held [N]; `math.inf`: no limit.
        unit: Unit of the positions: `"m"`, `"cm"`, `"mm"` or `"um"`. `None`: metres, and a motion that is too
            long or too fast for a hand is refused.
        title: What the report calls the motion.
        settings: Settings of the methods, such as `damping`: `palpate.METHODS[method].settings` lists them.

    The other arguments are those of `palpate.Renderer`.

    Returns:
        The report, and the ticks of each method as structured arrays.

    Raises:
        ValueError: A value that is not allowed, by the name of its argument; a motion that is none.
    """
    given = dict(locals())
    for other in ("t", "x", "method", "unit", "title", "settings"):
        del given[other]
    # Copies: the figure is drawn later, and the arrays of the caller may have changed by then.
    motion = (_of_one_dimension("t", t), _of_one_dimension("x", x), title, unit)
    arguments = (motion, method, given, settings)
    return Runs._of_runs(_palpate.render(*arguments), (_palpate.render_figure, arguments))


def _of_one_dimension(name: str, given: ArrayLike) -> NDArray[np.float64]:
    """A copy of the numbers of an argument."""
    array = numbers(name, given)
    if array.ndim != 1:
        raise ValueError(f"{name} has the shape {array.shape}, but must have one dimension")
    return array.copy()
