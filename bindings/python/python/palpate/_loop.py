"""`Loop`: a renderer or a world on a device in real time, beside Python."""

from __future__ import annotations

import atexit
import os
import sys
import weakref
from collections.abc import Mapping
from types import TracebackType
from typing import Any, ClassVar, NamedTuple, NoReturn

import numpy as np
from numpy.typing import NDArray

from . import _palpate
from ._fixed import Fixed, FixedParameters
from ._arrays import row
from ._methods import METHODS
from ._recording import BODIES, DEVICES, RECORDED, Event
from ._renderer import Renderer
from ._world import World
from .devices import Device, PointerInWorld


class LoopError(RuntimeError):
    """A loop that has ended by itself, stands still, or could not end as it should."""


class Spread(NamedTuple):
    """Times of the ticks of a loop."""

    median: float
    """Median [s]."""
    p99: float
    """What 99 % of the ticks do not exceed [s]."""
    longest: float
    """Longest [s]."""


class Granted(NamedTuple):
    """What the machine was asked for, and what came of it."""

    asked: str
    """What was asked for."""
    granted: bool
    """Whether it is so."""
    text: str
    """Both in words, with what can be done about a refusal."""


class LoopStatus(NamedTuple):
    """How a loop stands."""

    running: bool
    """Whether its thread runs."""
    ticks: int
    """Ticks that it has made, as far as was heard."""
    lost: int
    """Ticks that no `read` has given or will give: they made room for newer ones, or never came."""
    silent: float | None
    """Time since the last tick was heard [s]; `None` before the first."""
    cuts: int
    """How often the supervisor commanded no force, because the loop stood still."""
    motors_off: bool
    """Whether a safety stop of the safety kept the motors off at the end of the last tick."""
    force: tuple[float, float, float]
    """Force that the device says it holds, along its axes [N]; NaN where it did not say. Of several devices, of the first."""
    forces: tuple[tuple[float, float, float], ...] = ()
    """The same of each device, in the order of the world."""


class LoopReport(NamedTuple):
    """What a loop has left behind."""

    ending: str | None
    """Why it ended; `None` for a loop that was never started."""
    failure: str | None
    """What went wrong: a lost device, a panic, a recording that could not be written, a device that could not be let go of."""
    safety_stop: str | None
    """The safety stop of the safety that held the force at none in the end."""
    ticks: int
    """Ticks."""
    missed_deadlines: int
    """Deadlines that were missed, and skipped."""
    without_sample: int
    """Ticks that found no fresh sample."""
    refused: int
    """Ticks whose sample the renderer has refused: it asked for no force."""
    motors_off: int
    """Ticks at whose end a safety stop kept the motors off."""
    cuts: int
    """How often the supervisor commanded no force."""
    lateness: Spread
    """How long after its deadline a tick began [s]."""
    duration: Spread
    """How long a tick took, from the sample's arrival to the force's [s]."""
    recorded: int | None
    """Ticks in the recording; `None` where there is none."""
    unrecorded: int | None
    """Ticks that the recording lacks; `None` where there is none."""
    device: str | None = None
    """Of several devices the one that the safety stop is of, by its name in the world; `None` of one device, and without a safety stop."""


class Loop(Fixed, _palpate.Loop):
    """A renderer or a world on a device in real time: the loop of `palpate run`, in a thread that never waits for Python.

        with palpate.Loop(palpate.devices.Pointer(), palpate.Renderer(stiffness=400.0, ...)) as loop:
            ticks = loop.read(wait=1.0)

    The thread samples the device, renders, and commands the force through a safety layer (`docs/realtime.md`). Python reads
    what it did, and changes what it renders. The loop begins the renderer anew; the renderer itself is left as it is, and
    its `force_limit` and `soft_start` are the loop's. A world is begun anew likewise:

        world = palpate.World("experiments/worlds/paddle.toml")
        device = palpate.devices.PointerInWorld(world)
        with palpate.Loop(device, world) as loop:
            device.move_to([0.0, 0.0, 0.01])
            ticks, bodies = loop.read(wait=1.0), loop.bodies

    A world of several devices runs on one for each, by the names that they have there:

        world = palpate.World("experiments/worlds/pinch.toml")
        fingers = {name: palpate.devices.PointerInWorld(world, name) for name in ("left", "right")}
        with palpate.Loop(fingers, world) as loop:
            ticks, devices = loop.read(wait=1.0), loop.devices

    What a game or an engine of another rate publishes is rendered by a `palpate.engines.LowRateSimulator`.

    Where one device has no good sample, safety stops, is cut or does not take its force, no device has a force.

    The loop ends, and the device is commanded no force, when the `with` block is left by its end, by an exception or by
    Ctrl-C; by `stop`; when the interpreter exits; when nobody refers to the loop any more. A signal that ends Python at once,
    such as SIGTERM without a handler, is not among these: then a watchdog takes the force off a device that holds it.

    Args:
        device: One of `palpate.devices`; of a world with several devices one for each, by its name in the world.
        renderer: What is rendered: a `Renderer`, a `World` with devices of three or six axes, or a `palpate.engines.LowRateSimulator`, on a
            device of a `World` or a real one.
        record: A recording (MCAP) to write; a file that is there is not overwritten.
        ring: Ticks that wait for `read`; of more, the oldest make room and are counted.
        largest_speed: Speed of the device above which the motors are off [m/s].
        range: Where the device may be along the contact's axis, from and to [m]; `None`: anywhere. Not for a world.
        oscillation: Energy created within a fifth of a second that counts as oscillation [J]; `math.inf`: none does.
        stall_after: Periods from tick to tick after which a supervisor commands no force; `None`: 1.5, or a period and 3 ms
            where that is more.
        priority: Priority under SCHED_FIFO that the machine is asked for, 1 to 98; 0: none.
        lock_memory: Whether the memory of the whole process is to be kept from being moved out.
        processor: Processor to run on; `None`: any.
        spin: How long to stay awake before each deadline [s], at most 1.

    Raises:
        ValueError: A value that is not allowed, by the name of its argument.
        OSError: A device that cannot be opened; a recording that cannot be begun.
    """

    granted: list[Granted]
    """What the machine was asked for, and what it granted; empty before the start."""
    report: LoopReport | None
    """What the loop has left behind; `None` before its end."""
    bodies: NDArray[np.void]
    """The bodies of a world at the ticks that the last `read` gave: an array with the fields of `palpate.BODIES`. Those that
    move, and the proxies of the devices."""
    devices: NDArray[np.void]
    """The devices of a world with several at the ticks that the last `read` gave: an array with the fields of `palpate.DEVICES`. Of
    a loop with one device it is empty: the ticks have all of it."""
    device_names: tuple[str, ...]
    """The names that the devices have in the world, by the field `device`. Of a renderer none."""
    body_names: tuple[str, ...]
    """The names of a world's bodies by the field `body`; the last are the devices, whose proxies they are. Of a renderer none."""
    contact_names: tuple[tuple[str, str], ...]
    """Between which two each contact of a world is, by the field `pair` of its row. Of a renderer none."""

    _way: ClassVar[str] = "make another Loop; change(renderer) or change(world) changes what it renders"

    def __new__(
        cls,
        device: Device | Mapping[str, Device],
        renderer: Renderer | World | _palpate.LowRateSimulator,
        *,
        record: str | os.PathLike[str] | None = None,
        ring: int = 65536,
        largest_speed: float = 5.0,
        range: tuple[float, float] | None = None,
        oscillation: float = 0.05,
        stall_after: float | None = None,
        priority: int = 80,
        lock_memory: bool = False,
        processor: int | None = None,
        spin: float = 0.0,
    ) -> Loop:
        options: dict[str, Any] = {
            "ring": ring,
            "largest_speed": largest_speed,
            "range": None if range is None else tuple(row("range", range)),
            "oscillation": oscillation,
            "stall_after": stall_after,
            "priority": priority,
            "lock_memory": lock_memory,
            "processor": processor,
            "spin": spin,
            "record": _file(record),
            "scene": None,
        }
        if not isinstance(renderer, (Renderer, World, _palpate.LowRateSimulator)):
            raise TypeError(f"renderer is {renderer!r}, but must be a palpate.Renderer, a palpate.World or a palpate.engines.LowRateSimulator")
        for one in device.values() if isinstance(device, Mapping) else [device]:
            if not isinstance(one, Device):
                raise TypeError(f"device is {one!r}, but must be one of palpate.devices, such as palpate.devices.Pointer()")
        rendered: Any = renderer
        parameters: dict[str, Any] = {}
        if not isinstance(renderer, Renderer) and range is not None:
            kind = "World" if isinstance(renderer, World) else "LowRateSimulator"
            raise ValueError(f"range is along the axis of a Renderer's contact, which a {kind} has not")
        if not isinstance(renderer, World) and isinstance(device, Mapping):
            kind = "Renderer" if isinstance(renderer, Renderer) else "LowRateSimulator"
            raise ValueError(f"devices by their names are of a World; a {kind} runs on one device")
        if isinstance(renderer, Renderer):
            if record is not None and not isinstance(device, Mapping):
                options["scene"] = _scene(device, renderer)
            parameters = dict(renderer.parameters)
            method, given, soft_start, settings = _split(parameters)
            rendered = (method, given, soft_start, settings)
        made = super().__new__(cls, _in_order(device, renderer), rendered, options)
        made.granted = []
        made.report = None
        made.bodies = np.empty(0, BODIES)
        made.devices = np.empty(0, DEVICES)
        made.device_names, made.body_names, made.contact_names = _names(renderer)
        made._parameters = parameters
        made._world = renderer if isinstance(renderer, World) else None
        made._is_slow = isinstance(renderer, _palpate.LowRateSimulator)
        made._started = made._said = False
        return made

    _parameters: dict[str, Any]
    _world: World | None
    _is_slow: bool
    _started: bool
    _said: bool

    def start(self) -> list[Granted]:  # type: ignore[override]
        """Starts the loop's thread. A loop runs once.

        Returns:
            What the machine was asked for, and whether it granted that. The loop runs in any case.

        Raises:
            RuntimeError: A loop that was started before.
        """
        self._found(granted=[Granted(*answer) for answer in super().start()])
        self._started = True
        _RUNNING.add(self)
        return self.granted

    def stop(self) -> LoopReport:  # type: ignore[override]
        """Ends the loop and waits until the device was commanded no force, was closed, and the recording is written.

        A second call gives the same report.

        Raises:
            LoopError: Something went wrong, once; `report` has it all.
        """
        _RUNNING.discard(self)
        (ending, failure, safety_stop, device), counts, (lateness, duration), recorded = super().stop()
        made, lost = (None, None) if recorded is None else recorded
        report = LoopReport(ending, failure, safety_stop, *counts, Spread(*lateness), Spread(*duration), made, lost, device)
        self._found(report=report)
        if failure is not None and not self._said:
            self._said = True
            raise LoopError(failure)
        return report

    def read(self, wait: float = 0.0) -> NDArray[np.void]:
        """The ticks since the last `read`, oldest first: an array with the fields of `palpate.RECORDED`.

        Of a world, a tick has an element for each of its contacts, and one without a value of a contact where nothing
        touches; `contact_names` has the names, `bodies` the bodies at these ticks, and `devices` each of several devices.

        Args:
            wait: How long to wait for the first of them [s]; 0: not at all.

        Raises:
            LoopError: The loop has ended by itself and all its ticks were read; or no tick came within `wait`.
        """
        words, bodies, devices = self.take(wait)
        ticks = words.view(RECORDED)
        self._found(bodies=bodies.view(BODIES), devices=devices.view(DEVICES))
        if len(ticks) == 0:
            self._say_why(wait)
        return ticks

    def _say_why(self, wait: float) -> None:
        """Says why there is no tick, where that is not what somebody wanted."""
        now = self.status
        if self._started and self.report is None and not now.running:
            # The loop ended by itself: report the reason.
            report = self.stop()
            raise LoopError(f"the loop has ended: {report.ending}")
        if wait > 0.0 and now.running:
            silent = "none since its start" if now.silent is None else f"the last one {now.silent:.3g} s ago"
            raise LoopError(f"the loop stands still: no tick within {wait} s, {silent}")

    def events(self) -> list[Event]:  # type: ignore[override]
        """What happened beside the ticks since this was asked last: faults, safety stops, changes, missed deadlines, the end.

        The newest 1000 are kept; where older ones are gone, the first event says how many (`kind` is `"lost"`).
        """
        pending, gone = super().events()
        events = [Event(*event) for event in pending]
        if gone:
            sequence, at = (events[0].sequence, events[0].t_s) if events else (0, 0.0)
            events.insert(0, Event(sequence, at, "lost", f"events before this one that were not read in time: {gone}"))
        return events

    def change(self, world: World | None = None, **changes: Any) -> int:  # type: ignore[override]
        """Renders by other parameters from the next tick on: any of `Renderer`, its method and the method's settings; or another
        world.

            loop.change(stiffness=800.0, mass=0.2)
            loop.change(world.replace(contacts=[...]))  # of a World; loop.change(contacts=[...]) is the same

        Stiffness, mass and virtual force, and the difference that another method makes, pass over in a tenth of a second.
        Another method begins with its own defaults. The object's position and velocity are those of the start: they do not
        change. An object that becomes a wall stays where it is if the device touches it, and else goes to `object_position`.

        A world may have other masses, weights, shapes, laws of contact, joints, places and another method; the devices, the
        bodies and the pairs that may touch stay, and so do the period and the limits of the loop. A body of which the tables
        have the same place and motion as before goes on from where it is, as fast as it is; another is put where they say.
        The device is held as by the world before for three ticks, and the force passes over in a tenth of a second. The books of energy go on.

        Args:
            world: Another world, of a loop of a world.
            changes: Arguments of `Renderer`, or of a loop of a world those of `World.replace`.

        Returns:
            Number of the change: ticks have it in the field `generation` from where it is in force.

        Raises:
            ValueError: A value that is not allowed; the period, the side and the limits of the loop do not change.
            RuntimeError: The loop has ended.
            TypeError: A loop of a LowRateSimulator, which publishes what is rendered; a world for a loop that renders a contact, or not a world; an argument that there is not.
        """
        if self._is_slow:
            raise TypeError("what a LowRateSimulator publishes is rendered; its next `publish` changes that")
        limits = ("force_limit", "torque_limit", "soft_start")
        if self._world is not None:
            return self._change_world(self._world if world is None else world, changes, limits)
        if world is not None:
            raise TypeError("the loop renders a Renderer; a World runs in a Loop of its own")
        for name in limits:
            if name in changes:
                raise ValueError(f"{name} is a limit of the loop, and stays while it runs; make another Loop")
        method, before, soft_start, settings = _split(self._parameters)
        kept = settings if changes.get("method", method) == method else {}
        parameters = {"method": method, **before, "soft_start": soft_start, **kept, **changes}
        # Checked like a renderer's arguments, including unknown names.
        method, given, _, settings = _split(Renderer(**parameters).parameters)
        generation = super().change(method, given, settings)
        self._parameters = parameters
        return generation

    def _change_world(self, world: World, changes: dict[str, Any], limits: tuple[str, ...]) -> int:
        if not isinstance(world, World):
            raise TypeError(f"world is {world!r}, but must be a palpate.World")
        for name in limits:
            if name in changes:
                raise ValueError(f"{name} is a limit of the loop, and stays while it runs; make another Loop")
        if changes:
            known = ("title", "loop", "devices", "bodies", "contacts", "joints", "render", "model", "measure", "method")
            for name in changes:
                if name not in known:
                    raise TypeError(f"no table of a world is called {name}; it has {', '.join(known)}")
            world = world.replace(**changes)
        generation = self.change_world(world)
        self._world = world
        return generation

    @property
    def world(self) -> World | None:
        """The world that is rendered now, at its start; `None` of a loop that renders a contact. `loop.bodies` has how it is."""
        return self._world

    @property
    def parameters(self) -> dict[str, Any]:
        """What is rendered now, as arguments of `palpate.Renderer`; of a world none."""
        return FixedParameters(self._parameters, "change them by loop.change(NAME=VALUE)")

    @property
    def status(self) -> LoopStatus:
        """How the loop stands."""
        running, ticks, lost, silent, cuts, motors_off, held = self.now()
        forces = tuple((x, y, z) for x, y, z in held)
        return LoopStatus(running, ticks, lost, silent, cuts, motors_off, forces[0], forces)

    def __enter__(self) -> Loop:
        self.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        try:
            self.stop()
        except LoopError:
            # An exception of the `with` block takes precedence; the report has the rest.
            if error is None:
                raise

    def __reduce__(self) -> NoReturn:
        raise TypeError("a Loop runs on a device and is not pickled")

    def __repr__(self) -> str:
        state = "ended" if self.report else "running" if self.status.running else "not started"
        return f"<Loop on {self.device_name!r}, {self.period} s, {state}>"


_RUNNING: weakref.WeakSet[Loop] = weakref.WeakSet()


def _stop_all() -> None:
    for loop in list(_RUNNING):
        try:
            loop.stop()
        except RuntimeError as error:
            print(f"palpate: {error}", file=sys.stderr)


atexit.register(_stop_all)


def _in_order(device: Device | Mapping[str, Device], renderer: Renderer | World | _palpate.LowRateSimulator) -> list[dict[str, Any]]:
    """What is said of each device, in the order of the world's."""
    names = renderer.names()[0] if isinstance(renderer, World) else []
    listed = " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))
    if not isinstance(device, Mapping):
        if len(names) > 1:
            raise ValueError(f"the world has the devices {listed}; a Loop of it takes one for each, as {{name: device}}")
        return [device._given()]
    for name in device:
        if name not in names:
            raise ValueError(f"no device of the world is called {name!r}; it has {listed}")
    for name in names:
        if name not in device:
            raise ValueError(f"there is no device for {name!r}; the world has {listed}")
        own = device[name]
        if isinstance(own, PointerInWorld) and own.device != name and len(names) > 1:
            raise ValueError(f"the device for {name!r} is a PointerInWorld of {own.device!r}")
    return [device[name]._given() for name in names]


def _names(
    renderer: Renderer | World | _palpate.LowRateSimulator,
) -> tuple[tuple[str, ...], tuple[str, ...], tuple[tuple[str, str], ...]]:
    """The names of devices, of bodies and of contacts, by their numbers in rows."""
    if not isinstance(renderer, World):
        return (), (), ()
    devices, bodies = renderer.names()
    return tuple(devices), (*bodies, *devices), tuple(contact.between for contact in renderer.contacts)


def _split(parameters: dict[str, Any]) -> tuple[Any, dict[str, Any], float, dict[str, Any]]:
    """Method, the arguments that every renderer has, soft start, and settings of the method."""
    rest = dict(parameters)
    method, soft_start = rest.pop("method"), rest.pop("soft_start")
    given = {name: rest.pop(name) for name in _SHARED}
    return method, given, soft_start, rest


_SHARED = tuple(
    name
    for name in (Renderer.__new__.__kwdefaults__ or {}).keys() | {"stiffness", "mass", "period"}
    if name not in ("method", "soft_start")
)


def _scene(device: Device, renderer: Renderer) -> str | None:
    """The text of the scene that a recording of this loop holds; `None` where nobody knows the device's mass."""
    method, given, _, settings = _split(renderer.parameters)
    table = device._in_scene()
    if table is None and given["device_mass"] is not None:
        table = {"kind": "point-mass", "mass_kg": given["device_mass"]}
    if table is None:
        return None
    period = given["period"]
    guard = None
    if given["guard"] != "off":
        guard = {"mode": given["guard"], "speed_m_per_s": given["guard_speed"], "allowance_j": given["guard_allowance"]}
    limit = given["force_limit"]
    keys = {setting.name: setting.key for setting in METHODS[method].settings}
    tables: dict[str, Any] = {
        "scene_format": 1,
        "title": "a loop of Python",
        "object": {
            "mass_kg": given["mass"],
            "stiffness_n_per_m": given["stiffness"],
            "position_m": given["object_position"],
            "velocity_m_per_s": given["object_velocity"],
            "force_n": given["force"],
            "side": given["side"],
        },
        "device": table,
        "loop": {"period_s": period},
        "model": {
            "delay_s": given["delay"] * period,
            "lag_s": given["lag"],
            "gain": given["gain"],
            "delay_deviation_s": given["delay_deviation"] * period,
            "lag_deviation_s": given["lag_deviation"],
            "gain_deviation": given["gain_deviation"],
        },
        "measure": {"duration_s": 1.0},
        "renderer": {
            "method": method,
            "device_mass_kg": given["device_mass"],
            "unilateral": given["unilateral"],
            "force_limit_n": None if limit == float("inf") else limit,
            "slew_limit_n_per_s": given["slew_limit"],
            "speed_limit_m_per_s": given["speed_limit"],
            "largest_gap_s": given["largest_gap"],
            "guard": guard,
        },
        "methods": {method: {keys[name]: value for name, value in settings.items()}} if settings else None,
    }
    return _palpate.to_toml(tables)


def _file(path: str | os.PathLike[str] | None) -> str | os.PathLike[str] | None:
    """A path that names a file, or none."""
    if path is not None and not os.fspath(path):
        raise ValueError("record is an empty path, but must name a file")
    return path
