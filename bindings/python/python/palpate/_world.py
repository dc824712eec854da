"""`World`: several devices, bodies and contacts in space."""

from __future__ import annotations

import os
from typing import Any, ClassVar, Iterable, Mapping, NoReturn, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _palpate
from ._arrays import known, numbers
from ._fixed import Fixed, question_period
from ._scene import Tables
from ._world_values import (
    BodyLedger,
    BodyState,
    EnergyLedger,
    ContactLedger,
    ContactState,
    DeviceLedger,
    Effort,
    JointLedger,
    ToolState,
    TurnState,
    WorldOutput,
)


class World(Fixed, _palpate.World):
    """Several devices, bodies and contacts, rendered by one method, sample by sample.

        world = palpate.World("experiments/worlds/paddle.toml")
        force = world.step([0.0, 0.0, 0.001])

    A file is one of format 2. Without a file the tables of one are given, with its keys and units
    (`docs/worlds.md` in palpate's repository lists them):

        world = palpate.World(
            loop={"period_s": 0.001},
            devices=[{"name": "tool", "mass_kg": 0.2, "tool": {"sphere": {"radius_m": 0.01}}}],
            bodies=[{"name": "ball", "mass_kg": 0.1, "position_m": [0, 0, 0.05],
                     "shape": {"sphere": {"radius_m": 0.03}}}],
            contacts=[{"between": ["tool", "ball"], "stiffness_n_per_m": 2000.0}],
        )

    A world is made for motors. So it has the limits of `palpate pipe`: the force on each device is limited to
    20 N as a length, and where a start or a recovery finds a tool inside a body, the force comes in over 0.2 s.
    `force_limit=math.inf, soft_start=0` switches that off.

    Args:
        path: A file. `None`: the world is in the tables.
        title: A line for tables and figures.
        loop: The loop, with `period_s`.
        devices: A table for each device, with its tool.
        bodies: A table for each body.
        contacts: A table for each law.
        joints: A table for each joint.
        render: Which method renders where none is named, its settings, and the told masses.
        told: Delay, lag and gain as the renderer is told them.
        measure: The window of `palpate.simulate`.
        method: Name of a method for worlds. `None`: that of the file, else `coupled`.
        force_limit: Largest length of the force on each device [N]; `math.inf`: no limit. `None`: that of the
            file, else 20.
        torque_limit: Largest length of the torque on each device of six axes [N m]; `math.inf`: no limit. `None`: that
            of the file, else 1, or none where the force has none.
        soft_start: Time over which a force comes in where a start or a recovery finds contact, at most 60 [s].

    Raises:
        ValueError: Everything that is wrong with the world, a line for each.
        OSError: A file that cannot be read.
    """

    def __new__(
        cls,
        path: str | os.PathLike[str] | None = None,
        *,
        title: str | None = None,
        loop: Tables | None = None,
        devices: Sequence[Tables] | None = None,
        bodies: Sequence[Tables] | None = None,
        contacts: Sequence[Tables] | None = None,
        joints: Sequence[Tables] | None = None,
        render: Tables | None = None,
        model: Tables | None = None,
        measure: Tables | None = None,
        method: str | None = None,
        force_limit: float | None = None,
        torque_limit: float | None = None,
        soft_start: float = 0.2,
    ) -> World:
        tables: dict[str, Any] = {
            "title": title,
            "loop": loop,
            "device": devices,
            "body": bodies,
            "contact": contacts,
            "joint": joints,
            "render": render,
            "model": model,
            "measure": measure,
        }
        made_by = {
            "method": method,
            "force_limit": force_limit,
            "torque_limit": torque_limit,
            "soft_start": soft_start,
        }
        if path is None:
            tables = {key: value for key, value in tables.items() if value is not None}
            return cls._of(_palpate.to_toml({"format": 2, **_as_lists(tables)}), None, "", made_by)
        given = [key for key, value in tables.items() if value is not None]
        if given:
            raise ValueError(f"{given[0]} stands in the file: give either a path or tables; replace() changes tables")
        return cls._of(*_palpate.read_scene(path), made_by)

    @classmethod
    def _of(cls, text: str, name: str | None, folder: str | os.PathLike[str], made_by: Mapping[str, Any]) -> World:
        limits = (made_by["force_limit"], made_by["torque_limit"], made_by["soft_start"])
        made = super().__new__(cls, text, name, folder, made_by["method"], limits)
        question_period(made.period, "period_s", 4)
        made._made_by = dict(made_by)
        made._devices, made._bodies = made.names()
        return made

    _way: ClassVar[str] = "make another World with that argument, or by world.replace() with that table"
    _made_by: dict[str, Any]
    _devices: list[str]
    _bodies: list[str]

    @classmethod
    def parse(cls, text: str, folder: str | os.PathLike[str] = "") -> World:
        """The world of the text of a file; files of meshes are looked for in `folder`."""
        made_by = {"method": None, "force_limit": None, "torque_limit": None, "soft_start": 0.2}
        return cls._of(text, "world", folder, made_by)

    def step(self, position: ArrayLike, elapsed: float | None = None) -> NDArray[np.float64]:
        """One tick: takes a sample of all devices, gives the forces to hold until the next.

        A device of six axes measures how it is turned and gives a torque: its sample is a pose, and its answer a
        wrench. One with `gives_torque = false` takes a pose, too, and its answer is a force.

        Args:
            position: Position of the device [m], three numbers; of a device of six axes a pose of seven: x, y, z [m], and
                the unit quaternion qw, qx, qy, qz that turns the tool's own axes into those of the world. Of several
                devices a row for each, in the order of `devices`; where one of them has six axes, all rows are poses,
                and the quaternion of a device that does not turn is not looked at.
            elapsed: Measured time since the last sample [s]; `None`: one period.

        Returns:
            The force on the device [N], three numbers; of one that gives a torque a wrench of six: fx, fy, fz [N], and the
            torque about the mass centre along the world's axes tx, ty, tz [N m]. Of several devices a row for each. It is what the
            device is to give to the hand. A sample that cannot be used gives 0, and `output.fault` says why.

        Raises:
            ValueError: Not as many numbers as a sample of these devices has.
        """
        given = numbers("position", position)
        width = self.width()
        row = "x, y, z" if width == 3 else "x, y, z, qw, qx, qy, qz"
        if len(self._devices) == 1:
            if given.shape != (width,) and given.shape != (1, width):
                raise ValueError(
                    f"position has the shape {given.shape}, but must have ({width},): {row} of {self._devices[0]}"
                )
            held = self.tick(given.reshape(1, width), elapsed)
            return held.reshape(given.shape[:-1] + held.shape[1:])
        if given.shape != (len(self._devices), width):
            names = ", ".join(self._devices)
            raise ValueError(
                f"position has the shape {given.shape}, but must have ({len(self._devices)}, {width}): "
                f"a row of {row} for each of {names}"
            )
        return self.tick(given, elapsed)

    def report_sent(self, force: ArrayLike, device: str | None = None) -> None:
        """Says what was really sent for the last sample, where that is not what `step` answered.

        Args:
            force: Force on the device [N], three numbers; where a device gives a torque a wrench of six, the torque [N m]
                behind the force.
            device: Name of the device; not needed where there is one.

        Raises:
            ValueError: No such device, not as many numbers, or one that is not finite.
        """
        if device is None and len(self._devices) == 1:
            device = self._devices[0]
        if device not in self._devices:
            raise ValueError(f"device is {device!r}, but must be one of {', '.join(self._devices)}")
        given = known("force", numbers("force", force))
        width = 6 if self.gives_torque() else 3
        if given.shape != (width,):
            raise ValueError(f"force has the shape {given.shape}, but must have ({width},)")
        torque = given[3:] if width == 6 else np.zeros(3)
        self.tell_sent(self._devices.index(device), given[:3].tolist(), torque.tolist())

    @property
    def devices(self) -> dict[str, ToolState]:
        """The tool of each device at the last sample, by its name."""
        states = {}
        for name, ((vectors, mass), turned) in zip(self._devices, _palpate.world_tools(self)):
            turn = None
            if turned is not None:
                orientations, turning, inertia = turned
                turn = TurnState._make([*map(np.array, orientations), *map(np.array, turning), _known(inertia)])
            states[name] = ToolState._make([*map(np.array, vectors), _known(mass), turn])
        return states

    @property
    def bodies(self) -> dict[str, BodyState]:
        """Each body at the last sample, by its name; fixed ones too."""
        states = zip(self._bodies, _palpate.world_bodies(self))
        return {name: BodyState(*map(np.array, state)) for name, state in states}

    @property
    def contacts(self) -> tuple[ContactState, ...]:
        """Each point at which two can touch, at the last sample, whether they do or not."""
        return tuple(
            ContactState((between[0], between[1]), mode, np.array(point), np.array(normal), depth, np.array(force), np.array(bristle))
            for between, mode, point, normal, depth, force, bristle in _palpate.world_contacts(self)
        )

    @property
    def ledger(self) -> EnergyLedger:
        """The books of energy as of the last sample."""
        contacts, bodies, devices, joints = _palpate.world_ledger(self)
        return EnergyLedger(
            tuple(ContactLedger((between[0], between[1]), *entries) for between, entries in contacts),
            {name: BodyLedger(*entries) for name, entries in zip(self._bodies, bodies)},
            {name: DeviceLedger(*entries) for name, entries in zip(self._devices, devices)},
            tuple(JointLedger((between[0], between[1]), kind, *entries) for between, kind, entries in joints),
        )

    @property
    def output(self) -> WorldOutput | None:
        """What was answered to the last sample; `None` before the first."""
        result = self.result()
        if result is None:
            return None
        forces, limited, effort, fault, faulty = result
        return WorldOutput(forces, tuple(limited), Effort(*effort), fault, faulty)

    def add(
        self,
        *,
        devices: Iterable[Tables] = (),
        bodies: Iterable[Tables] = (),
        contacts: Iterable[Tables] = (),
        joints: Iterable[Tables] = (),
    ) -> World:
        """A new world with these beside its own, at its start. Of two laws for the same pair the last counts."""
        tables = self.to_dict()
        for key, more in (("device", devices), ("body", bodies), ("contact", contacts), ("joint", joints)):
            more = list(more)
            if not more:
                continue
            tables[key] = [*tables.get(key, []), *more]
        return self._of(_palpate.to_toml(_as_lists(tables)), None, self.parts()[2], self._made_by)

    def replace(
        self,
        *,
        method: str | None = None,
        force_limit: float | None = None,
        torque_limit: float | None = None,
        soft_start: float | None = None,
        **tables: Any,
    ) -> World:
        """A new world with other values, at its start: of `title`, `loop`, `render`, `model` and `measure`, by
        key, and `devices`, `bodies`, `contacts` and `joints` as wholes; and with another method or other limits.

            world.replace(loop={"period_s": 0.004}, method="basic")
        """
        changed = self.to_dict()
        names = {"devices": "device", "bodies": "body", "contacts": "contact", "joints": "joint"}
        for key, value in tables.items():
            before = changed.get(key)
            if isinstance(value, Mapping) and isinstance(before, Mapping):
                value = {**before, **value}
            changed[names.get(key, key)] = value
        limits = {
            "method": method,
            "force_limit": force_limit,
            "torque_limit": torque_limit,
            "soft_start": soft_start,
        }
        made_by = {key: self._made_by[key] if value is None else value for key, value in limits.items()}
        return self._of(_palpate.to_toml(_as_lists(changed)), None, self.parts()[2], made_by)

    def to_dict(self) -> dict[str, Any]:
        """The tables of the world, with the keys of its file."""
        return _palpate.from_toml(self.parts()[0])

    def to_toml(self) -> str:
        """The world as the text of a file."""
        return self.parts()[0]

    def __reduce__(self) -> NoReturn:
        raise TypeError("a World has a state and is not pickled; pickle its to_toml(), and make one anew by World.parse")

    def __repr__(self) -> str:
        return f"<palpate.World {self.title!r} of {', '.join(self._devices)}: {self.method}>"


def _as_lists(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Rows of tables as lists, which TOML wants."""
    rows = ("device", "body", "contact", "joint")
    return {key: list(value) if key in rows else value for key, value in tables.items()}


def _known(numbers: list[float] | None) -> NDArray[np.float64] | None:
    return None if numbers is None else np.array(numbers)
