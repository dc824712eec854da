"""`Renderers`: many contacts at once, for a loop of the caller."""

from __future__ import annotations

from typing import Any, ClassVar, Mapping, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _palpate
from ._arrays import chosen, for_each, numbers, result_array
from ._fixed import Fixed, FixedParameters, question_lag, question_period
from ._renderer import Renderer
from ._report import TICK
from ._state import State

_DEFAULTS: Mapping[str, Any] = Renderer.__new__.__kwdefaults__ or {}
_NEEDED = ("stiffness", "mass", "period")
_OWN = ("method", "soft_start")

OUTPUT: np.dtype[np.void] = np.dtype(
    [
        ("force_on_device_n", "f8"),
        ("slope_on_device_n_per_s", "f8"),
        ("object_position_m", "f8"),
        ("object_velocity_m_per_s", "f8"),
        ("penetration_m", "f8"),
        ("transition_after_s", "f8"),
        ("proxy_shift_m", "f8"),
        *((name, TICK[name]) for name in ("phase", "limited", "fault")),
        ("soft_start", "?"),
        ("safety_stop", "?"),
        ("unused", "V3"),
    ]
)
"""Fields of a result of `Renderers`; `palpate.PHASES`, `LIMITS` and `FAULTS` have the meaning of the codes."""


class Renderers(Fixed, _palpate.Renderers):
    """Many contacts, each with its own state, rendered by one method: an array of positions in, an array of forces out.

    Each contact computes what a `Renderer` with its parameters computes, bit by bit. From 2048 contacts on, a
    step uses several processors, without the interpreter's lock.

    Args:
        count: Number of contacts.
        method: Name of the method, of `palpate.METHODS`.
        parameters: Arguments of `Renderer`: a value for all contacts, or an array of one value for each.

    Raises:
        TypeError: An argument is missing.
        ValueError: An argument is not allowed; the message names it, and its row if the rows differ.
    """

    _way: ClassVar[str] = "make others by Renderers(len(renderers), **{**renderers.parameters, NAME: VALUE})"
    parameters: dict[str, Any]
    """Arguments of the constructor except the count, read-only."""

    def __new__(cls, count: int, *, method: str = "coupled", **parameters: Any) -> Renderers:
        if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 1:
            raise ValueError(f"count is {count!r}, but must be an integer of at least 1")
        missing = [name for name in _NEEDED if name not in parameters]
        if missing:
            raise TypeError(f"Renderers needs {' and '.join(missing)}, as Renderer does")
        # Copies: a later change of an array changes no parameter.
        parameters = {name: _unchanging(value) for name, value in parameters.items()}
        columns = {name: _column(name, value, int(count)) for name, value in parameters.items()}
        is_one = not any(isinstance(column, list) for column in columns.values())
        rows = [_row(columns, place) for place in range(1 if is_one else int(count))]
        question_period(float(np.max(parameters["period"])))
        question_lag(float(np.max(parameters.get("lag", 0.0))))
        made = super().__new__(cls, method, int(count), rows)
        made._count = int(count)
        made.parameters = FixedParameters({"method": method, **parameters}, cls._way)
        return made

    _count: int

    def __len__(self) -> int:
        return self._count

    def step(
        self,
        positions: ArrayLike,
        elapsed: ArrayLike | None = None,
        force: ArrayLike | None = None,
        out: NDArray[np.float64] | None = None,
    ) -> NDArray[np.float64]:
        """Computes one tick of each contact: takes the positions of the devices and returns the forces on them.

        Args:
            positions: Position of each device [m]. Arrays of other libraries in the memory of the processor, such as
                tensors of PyTorch, are read without a copy if they have doubles in a row.
            elapsed: Measured time since the last sample [s], for all or for each; `None`: one period.
            force: Virtual force on the objects [N], for all or for each; `None`: that of the constructor.
            out: Array of doubles for the result; `None`: a new one.

        Returns:
            The force on each device [N], to hold until the next sample: `out`, if it is given.
        """
        sampled = numbers("positions", positions)
        if sampled.shape != (self._count,):
            raise ValueError(f"positions has the shape {sampled.shape}, but must have ({self._count},), one for each contact")
        given = (for_each("elapsed", elapsed, self._count), for_each("force", force, self._count))
        result = result_array(out, (self._count,), sampled, *given)
        self.tick(sampled, *given, result)
        return result if out is None else out

    def reset(self, mask: ArrayLike | None = None) -> None:
        """Resets the contacts at which `mask` is true to their initial state; `None`: all."""
        self.restart(chosen(mask, self._count))

    @property
    def output(self) -> NDArray[np.void]:
        """Results of the last sample: an array with the fields of `palpate.OUTPUT`; NaN before the first."""
        return self.results().view(OUTPUT)

    @property
    def leak_held_j(self) -> NDArray[np.float64]:
        """Energy generated by the held forces of each contact [J], as `Renderer.ledger.held_leak.accumulated`."""
        return self.created()

    def get_state(self) -> State:
        """Returns the states of all contacts, for `set_state`."""
        return State("Renderers", {"count": self._count, **self.parameters}, self.held_state())

    def set_state(self, state: State) -> None:
        """Continues from `state`.

        Raises:
            ValueError: The state is of contacts with other parameters.
        """
        self.hold_state(state._for("Renderers", {"count": self._count, **self.parameters}))

    def copy(self) -> Renderers:
        """Returns independent contacts with the same parameters in the same states."""
        made = Renderers(self._count, **self.parameters)
        made.hold_state(self.held_state())
        return made

    __copy__ = copy

    def __deepcopy__(self, memo: Any) -> Renderers:
        return self.copy()

    def __reduce__(self) -> NoReturn:
        raise TypeError(
            "Renderers have states and cannot be pickled; pickle their `parameters`, and make new ones by "
            "Renderers(count, **parameters)"
        )

    def __repr__(self) -> str:
        return f"<{self._count} palpate.Renderers: {self.parameters['method']}>"


def _unchanging(value: Any) -> Any:
    if np.ndim(value) == 0:
        return value
    held = np.array(value)
    held.flags.writeable = False
    return held


def _column(name: str, value: Any, count: int) -> Any:
    """Returns a value for all contacts, or a list of one for each."""
    shape = np.shape(value)
    if shape == ():
        return value.item() if isinstance(value, (np.generic, np.ndarray)) else value
    if shape != (count,):
        raise ValueError(f"{name} has the shape {shape}, but must be one value or have ({count},), one for each contact")
    return np.asarray(value).tolist()


def _row(columns: Mapping[str, Any], place: int) -> tuple[dict[str, Any], float, dict[str, Any]]:
    """Returns the arguments of a contact: parameters, soft start and settings of the method."""
    row = {name: column[place] if isinstance(column, list) else column for name, column in columns.items()}
    known = {name: value for name, value in _DEFAULTS.items() if name not in _OWN}
    parameters = {**known, **{name: value for name, value in row.items() if name in known or name in _NEEDED}}
    settings = {name: value for name, value in row.items() if name not in parameters and name not in _OWN}
    return parameters, row.get("soft_start", _DEFAULTS["soft_start"]), settings
