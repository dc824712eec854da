"""`Worlds`: many worlds at once, for a loop of the caller."""

from __future__ import annotations

from typing import Any, ClassVar, Iterable, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _palpate
from ._arrays import chosen, for_each, numbers, result_array
from ._fixed import Fixed
from ._state import State
from ._world import World
from ._world_values import BodyState


class Worlds(Fixed, _palpate.Worlds):
    """Many worlds, each with its own state: an array of samples in, an array of forces out.

        worlds = palpate.Worlds(palpate.World("experiments/worlds/peg.toml"), 1000)

    Each world computes what a `World` computes, bit by bit. From 32 worlds on, a step uses several processors, without the
    interpreter's lock. The worlds begin in the states of the given ones, and `reset` returns to the start of their files.

    Args:
        world: A world, of which there are `count`; or one for each, for parameters that differ. All have the same names of
            devices and bodies, and the same axes.
        count: Number of worlds, if one is given.

    Raises:
        TypeError: `world` is no `World`.
        ValueError: The count is missing or wrong, or the worlds have different devices, bodies or axes.
    """

    _way: ClassVar[str] = "make other Worlds"
    _each: list[World]
    _count: int

    def __new__(cls, world: World | Iterable[World], count: int | None = None) -> Worlds:
        each = [world] if isinstance(world, World) else list(world)
        for place, of in enumerate(each):
            if not isinstance(of, World):
                raise TypeError(f"world {place} is a {type(of).__name__}, but must be a palpate.World")
        if isinstance(world, World):
            if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 1:
                raise ValueError(f"count is {count!r}, but must be an integer of at least 1: the number of worlds")
        elif count is not None and count != len(each):
            raise ValueError(f"count is {count}, but {len(each)} worlds are given; leave it out")
        if not each:
            raise ValueError("there is no world, but at least one is needed")
        first = _form(each[0])
        for place, of in enumerate(each):
            if _form(of) != first:
                raise ValueError(
                    f"world {place} has {_words(of)}, but world 0 has {_words(each[0])}; all need the same devices, bodies and axes"
                )
        number = len(each) if count is None else int(count)
        made = super().__new__(cls, each, number)
        # Copies: a step of a given world changes none of these.
        made._each = [of.copy() for of in each]
        made._count = number
        return made

    def __len__(self) -> int:
        return self._count

    def __getitem__(self, place: int) -> World:
        """Returns a copy of a world in its state, with its contacts, ledger and output."""
        at = range(self._count)[place]
        made = self._of(at).copy()
        made.hold_state(self.state_of(at))
        return made

    def _of(self, place: int) -> World:
        return self._each[place if len(self._each) > 1 else 0]

    @property
    def period(self) -> float:
        """Nominal sampling period of the first world [s]."""
        return self._each[0].period

    def step(
        self,
        positions: ArrayLike,
        elapsed: ArrayLike | None = None,
        out: NDArray[np.float64] | None = None,
    ) -> NDArray[np.float64]:
        """Computes one tick of each world: takes the samples of the devices and returns the forces on them.

        Args:
            positions: The argument of `World.step` for each world: (count, 3), or (count, 7) with poses; for several
                devices (count, devices, 3 or 7).
            elapsed: Measured time since the last sample [s], for all or for each; `None`: one period.
            out: Array of doubles for the result; `None`: a new one.

        Returns:
            The result of `World.step` for each world: `out`, if it is given. A rejected sample gives 0; `faults` has the
            reason.
        """
        one = self._each[0]
        devices, width = len(one.names()[0]), one.width()
        sampled = numbers("positions", positions)
        shape = (self._count, width) if devices == 1 else (self._count, devices, width)
        if sampled.shape != shape:
            raise ValueError(f"positions has the shape {sampled.shape}, but must have {shape}")
        force = (*shape[:-1], 6 if one.gives_torque() else 3)
        times = for_each("elapsed", elapsed, self._count)
        result = result_array(out, force, sampled, times)
        self.tick(sampled.reshape(self._count, devices, width), times, result.reshape(self._count, devices, force[-1]))
        return result if out is None else out

    def reset(self, mask: ArrayLike | None = None) -> None:
        """Resets the worlds at which `mask` is true to their start; `None`: all."""
        self.restart(chosen(mask, self._count))

    def set_body(
        self,
        body: str,
        position: ArrayLike | None = None,
        orientation: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        angular_velocity: ArrayLike | None = None,
        mask: ArrayLike | None = None,
    ) -> None:
        """Moves a body in the worlds at which `mask` is true, as `World.set_body` does; `None`: in all.

        Each argument has the numbers for all worlds, or a row for each world. If one cannot be moved, none is.
        """
        place = self._each[0]._body(body)
        given = (
            self._rows("position", position, 3),
            self._rows("orientation", orientation, 4),
            self._rows("velocity", velocity, 3),
            self._rows("angular_velocity", angular_velocity, 3),
        )
        self.place(place, *given, chosen(mask, self._count))

    def _rows(self, name: str, given: ArrayLike | None, width: int) -> Any:
        if given is None:
            return None
        rows = numbers(name, given)
        if rows.shape not in ((width,), (self._count, width)):
            raise ValueError(f"{name} has the shape {rows.shape}, but must have ({width},) or ({self._count}, {width})")
        return rows.reshape(-1, width).tolist()

    @property
    def bodies(self) -> dict[str, BodyState]:
        """State of each body at the last sample, by name: the fields have a row for each world."""
        states = self.bodies_now()
        return {
            name: BodyState(of[:, :3], of[:, 3:7], of[:, 7:10], of[:, 10:])
            for name, of in zip(self._each[0].names()[1], np.moveaxis(states, 1, 0))
        }

    @property
    def faults(self) -> NDArray[np.str_]:
        """Reason for which each world has rejected its last sample, one of `palpate.FAULTS`; empty if there is none."""
        return np.array(self.faults_now())

    @property
    def limited(self) -> list[tuple[str, ...]]:
        """Active limits of each world, as `WorldOutput.limited`."""
        return [tuple(names) for names in self.limits_now()]

    @property
    def created_energy_j(self) -> NDArray[np.float64]:
        """Energy generated by the held forces of each world [J]."""
        return self.created()

    def get_state(self) -> State:
        """Returns the states of all worlds, for `set_state`."""
        return State("Worlds", self._parameters(), self.held_state())

    def set_state(self, state: State) -> None:
        """Continues from `state`.

        Raises:
            ValueError: The state is of other worlds.
        """
        self.hold_state(state._for("Worlds", self._parameters()))

    def copy(self) -> Worlds:
        """Returns independent worlds in the same states."""
        made = Worlds(self._each[0], self._count) if len(self._each) == 1 else Worlds(self._each)
        made.hold_state(self.held_state())
        return made

    __copy__ = copy

    def __deepcopy__(self, memo: Any) -> Worlds:
        return self.copy()

    def _parameters(self) -> dict[str, Any]:
        each = [of._parameters() for of in self._each]
        return {"count": self._count, **{name: [of[name] for of in each] for name in each[0]}}

    def __reduce__(self) -> NoReturn:
        raise TypeError("Worlds have states and cannot be pickled; pickle to_toml() of each World, and call World.parse")

    def __repr__(self) -> str:
        one = self._each[0]
        return f"<{self._count} palpate.Worlds {one.title!r} of {', '.join(one.names()[0])}: {one.method}>"


def _form(world: World) -> tuple[Any, ...]:
    return (*world.names(), world.width(), world.gives_torque())


def _words(world: World) -> str:
    devices, bodies = world.names()
    return f"{', '.join([*devices, *bodies])} with samples of {world.width()} numbers"

