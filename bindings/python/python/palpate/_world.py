"""`World`: several devices, bodies and contacts in space."""

from __future__ import annotations

import os
from typing import Any, ClassVar, Iterable, Mapping, NoReturn, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _palpate
from ._arrays import known, numbers, row
from ._fixed import Fixed, question_period
from ._scene import Tables
from ._state import State
from ._world_values import (
    BodyLedger,
    BodyState,
    EnergyLedger,
    ContactLedger,
    ContactState,
    DeviceLedger,
    Effort,
    FieldLedger,
    JointLedger,
    ToolState,
    TurnState,
    WorldOutput,
)


class World(Fixed, _palpate.World):
    """World of devices, bodies and contacts in space, rendered by one method, sample by sample.

        world = palpate.World("experiments/worlds/paddle.toml")
        force = world.step([0.0, 0.0, 0.001])

    The world comes from a scene file, or from tables with the keys and units of such a file (`docs/worlds.md` in palpate's
    repository lists them):

        world = palpate.World(
            loop={"period_s": 0.001},
            devices=[{"name": "tool", "mass_kg": 0.2, "tool": {"sphere": {"radius_m": 0.01}}}],
            bodies=[{"name": "ball", "mass_kg": 0.1, "position_m": [0, 0, 0.05],
                     "shape": {"sphere": {"radius_m": 0.03}}}],
            contacts=[{"between": ["tool", "ball"], "stiffness_n_per_m": 2000.0}],
        )

    A world is meant to drive motors and has the limits of `palpate pipe`: the magnitude of the force on each device is
    limited to 20 N, and if a tool is inside a body at a start or a recovery, the force ramps up over 0.2 s.
    `force_limit=math.inf, soft_start=0` disables these limits.

    Args:
        path: Path of a scene file. `None`: the world is in the tables.
        title: Title for tables and figures, one line.
        loop: The loop, with `period_s`.
        devices: A table for each device, with its tool and its hand.
        bodies: A table for each body.
        contacts: A table for each contact law.
        joints: A table for each joint.
        fields: A table for each force field.
        render: The default method, the limits and the guard.
        model: Model values of delay, lag, gain, and of masses and inertias of the devices.
        methods: Settings of methods, by method name.
        measure: The evaluation window of `palpate.simulate`.
        method: Name of a method for worlds. `None`: that of the file, else `coupled`.
        force_limit: Largest magnitude of the force on each device [N]; `math.inf`: no limit. `None`: that of the file,
            else 20.
        torque_limit: Largest magnitude of the torque on each device of six axes [N m]; `math.inf`: no limit. `None`:
            that of the file, else 1, or no limit if the force has none.
        soft_start: Duration of the force ramp if a start or a recovery begins in contact [s], at most 60.

    Raises:
        ValueError: The world is not valid; the message has a line for each error.
        OSError: A file cannot be read.
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
        fields: Sequence[Tables] | None = None,
        render: Tables | None = None,
        model: Tables | None = None,
        methods: Mapping[str, Tables] | None = None,
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
            "field": fields,
            "render": render,
            "model": model,
            "methods": methods,
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
            raise ValueError(f"path and {given[0]} are given: give either a path or tables; replace() changes tables")
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
        """Parses the text of a world file; `folder` has the mesh files."""
        made_by = {"method": None, "force_limit": None, "torque_limit": None, "soft_start": 0.2}
        return cls._of(text, "world", folder, made_by)

    def step(self, position: ArrayLike, elapsed: float | None = None) -> NDArray[np.float64]:
        """Computes one tick: takes a sample of all devices and returns the forces to hold until the next sample.

        The sample of a device of six axes is a pose, and its result is a wrench. With `gives_torque = false` the sample
        is a pose and the result is a force.

        Args:
            position: Position of the device [m], three numbers; for a device of six axes a pose of seven: x, y, z [m],
                and the unit quaternion qw, qx, qy, qz from the tool frame to the world frame. For several devices a row
                for each, in the order of `devices`. If one of them has six axes, all rows are poses, and the
                quaternion of a device without rotation is ignored.
            elapsed: Measured time since the last sample [s]; `None`: one period.

        Returns:
            The force that the device has to exert on the hand [N], three numbers; for a device with torque a wrench of
            six: fx, fy, fz [N], and the torque about the centre of mass tx, ty, tz [N m], in the world frame. For
            several devices a row for each. An invalid sample gives 0, and `output.fault` has the reason. With a line
            hold it is the mean, and `output.slopes` has the slope of each force.

        Raises:
            ValueError: The sample has the wrong shape.
        """
        given = numbers("position", position)
        width = self.width()
        named = "x, y, z" if width == 3 else "x, y, z, qw, qx, qy, qz"
        if len(self._devices) == 1:
            if given.shape != (width,) and given.shape != (1, width):
                raise ValueError(
                    f"position has the shape {given.shape}, but must have ({width},): {named} of {self._devices[0]}"
                )
            held = self.tick(given.reshape(1, width), elapsed)
            return held.reshape(given.shape[:-1] + held.shape[1:])
        if given.shape != (len(self._devices), width):
            names = ", ".join(self._devices)
            raise ValueError(
                f"position has the shape {given.shape}, but must have ({len(self._devices)}, {width}): "
                f"a row of {named} for each of {names}"
            )
        return self.tick(given, elapsed)

    def set_body(
        self,
        body: str,
        position: ArrayLike | None = None,
        orientation: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        angular_velocity: ArrayLike | None = None,
    ) -> None:
        """Moves a body between two samples. What is not given stays.

        The devices hold their forces for three samples and then change over to the new ones without a step; before the
        first sample there is nothing to change over from. The energy ledger has the change as work from outside.

        Args:
            body: Name of the body.
            position: Position of the centre of mass [m].
            orientation: Unit quaternion [w, x, y, z] from the body frame to the world frame.
            velocity: Velocity of the centre of mass [m/s].
            angular_velocity: Angular velocity [rad/s].

        Raises:
            ValueError: The body does not exist, a number is not finite, the quaternion has another length than 1, or a
                fixed body is given a velocity. Nothing changes then.
        """
        place = self._body(body)
        given = (("position", position, 3), ("orientation", orientation, 4), ("velocity", velocity, 3), ("angular_velocity", angular_velocity, 3))
        self.place(place, *(_row(*each) for each in given))

    def _body(self, name: str) -> int:
        """Returns the number of a body."""
        if name not in self._bodies:
            raise ValueError(f"body is {name!r}, but must be one of {', '.join(self._bodies)}")
        return self._bodies.index(name)

    def report_sent(self, force: ArrayLike, device: str | None = None, slope: ArrayLike = (0.0, 0.0, 0.0)) -> None:
        """Reports the force that was actually sent for the last sample, if it differs from the result of `step`.

        Args:
            force: Force on the device [N], three numbers; if a device has a torque, a wrench of six numbers: the force,
                then the torque [N m].
            device: Name of the device; optional for a single device.
            slope: Slope of the force [N/s], three numbers, for a line hold.

        Raises:
            ValueError: The device does not exist, or the force or the slope has the wrong shape or is not finite.
        """
        if device is None and len(self._devices) == 1:
            device = self._devices[0]
        if device not in self._devices:
            raise ValueError(f"device is {device!r}, but must be one of {', '.join(self._devices)}")
        given = known("force", numbers("force", force))
        width = 6 if self.gives_torque() else 3
        if given.shape != (width,):
            raise ValueError(f"force has the shape {given.shape}, but must have ({width},)")
        slopes = known("slope", numbers("slope", slope))
        if slopes.shape != (3,):
            raise ValueError(f"slope has the shape {slopes.shape}, but must have (3,)")
        torque = given[3:] if width == 6 else np.zeros(3)
        self.tell_sent(self._devices.index(device), given[:3].tolist(), torque.tolist(), slopes.tolist())

    @property
    def devices(self) -> dict[str, ToolState]:
        """Tool state of each device at the last sample, by name."""
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
        """State of each body at the last sample, by name, including fixed bodies."""
        states = zip(self._bodies, _palpate.world_bodies(self))
        return {name: BodyState(*map(np.array, state)) for name, state in states}

    @property
    def contacts(self) -> tuple[ContactState, ...]:
        """State of each potential contact point at the last sample."""
        return tuple(
            ContactState((between[0], between[1]), mode, np.array(point), np.array(normal), depth, np.array(force), np.array(bristle))
            for between, mode, point, normal, depth, force, bristle in _palpate.world_contacts(self)
        )

    @property
    def ledger(self) -> EnergyLedger:
        """Energy ledger at the last sample."""
        contacts, bodies, devices, joints, fields = _palpate.world_ledger(self)
        return EnergyLedger(
            tuple(ContactLedger((between[0], between[1]), *entries) for between, entries in contacts),
            {name: BodyLedger(*entries) for name, entries in zip(self._bodies, bodies)},
            {name: DeviceLedger(*entries) for name, entries in zip(self._devices, devices)},
            tuple(JointLedger((between[0], between[1]), kind, *entries) for between, kind, entries in joints),
            tuple(FieldLedger(device, *entries) for device, entries in fields),
        )

    @property
    def output(self) -> WorldOutput | None:
        """Result of the last sample; `None` before the first."""
        result = self.result()
        if result is None:
            return None
        forces, slopes, limited, effort, fault, faulty = result
        return WorldOutput(forces, slopes, tuple(limited), Effort(*effort), fault, faulty)

    def add(
        self,
        *,
        devices: Iterable[Tables] = (),
        bodies: Iterable[Tables] = (),
        contacts: Iterable[Tables] = (),
        joints: Iterable[Tables] = (),
        fields: Iterable[Tables] = (),
    ) -> World:
        """Returns a new world in its initial state with these parts added. The last law for a pair applies."""
        tables = self.to_dict()
        parts = {"device": devices, "body": bodies, "contact": contacts, "joint": joints, "field": fields}
        for key, more in parts.items():
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
        """Returns a new world in its initial state with other values, another method or other limits. `loop`, `render`,
        `model`, `methods` and `measure` are replaced by key; `title`, `devices`, `bodies`, `contacts`, `joints` and
        `fields` as a whole.

            world.replace(loop={"period_s": 0.004}, method="basic")
        """
        changed = self.to_dict()
        names = {"devices": "device", "bodies": "body", "contacts": "contact", "joints": "joint", "fields": "field"}
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
        """Returns the tables of the world, with the keys of its file."""
        return _palpate.from_toml(self.parts()[0])

    def to_toml(self) -> str:
        """Returns the text of the world file."""
        return self.parts()[0]

    def get_state(self) -> State:
        """Returns the state at the last sample, for `set_state`."""
        return State("World", self._parameters(), self.held_state())

    def set_state(self, state: State) -> None:
        """Continues from `state`.

        Raises:
            ValueError: The state is of another world, or of one with another method or other limits.
        """
        self.hold_state(state._for("World", self._parameters()))

    def copy(self) -> World:
        """Returns an independent world in the same state."""
        made = World._of(*self.parts(), self._made_by)
        made.hold_state(self.held_state())
        return made

    __copy__ = copy

    def __deepcopy__(self, memo: Any) -> World:
        return self.copy()

    def _parameters(self) -> dict[str, Any]:
        text, _, folder = self.parts()
        return {"scene": text, "folder": str(folder), **self._made_by}

    def __reduce__(self) -> NoReturn:
        raise TypeError("a World has a state and cannot be pickled; pickle its to_toml(), and call World.parse")

    def __repr__(self) -> str:
        return f"<palpate.World {self.title!r} of {', '.join(self._devices)}: {self.method}>"


def _as_lists(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Converts arrays of tables to lists, for TOML."""
    rows = ("device", "body", "contact", "joint", "field")
    return {key: list(value) if key in rows else value for key, value in tables.items()}


def _row(name: str, given: ArrayLike | None, width: int) -> Any:
    if given is None:
        return None
    numbers = row(name, given)
    if len(numbers) != width:
        raise ValueError(f"{name} has {len(numbers)} numbers, but must have {width}")
    return numbers


def _known(numbers: list[float] | None) -> NDArray[np.float64] | None:
    return None if numbers is None else np.array(numbers)
