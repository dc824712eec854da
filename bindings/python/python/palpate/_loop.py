"""`Loop`: a renderer or a world on a device in real time, in a thread of its own."""

from __future__ import annotations

import atexit
import os
import sys
import weakref
from collections.abc import Mapping, Sequence
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
    """The loop has ended by itself, has stalled, or could not shut down properly."""


class Spread(NamedTuple):
    """Times of the ticks of a loop."""

    median: float
    """Median [s]."""
    p99: float
    """99th percentile [s]."""
    longest: float
    """Longest [s]."""


class Granted(NamedTuple):
    """A request to the operating system and its result."""

    asked: str
    """The request."""
    granted: bool
    """Whether the request was granted."""
    text: str
    """Request and result in words, with advice if the request was denied."""


class LoopStatus(NamedTuple):
    """State of a loop."""

    running: bool
    """Whether the thread of the loop runs."""
    ticks: int
    """Number of ticks received from the loop."""
    lost: int
    """Ticks that no `read` returns: newer ticks replaced them, or the loop dropped them."""
    silent: float | None
    """Time since the last received tick [s]; `None` before the first tick."""
    cuts: int
    """How often the supervisor commanded zero force because the loop had stalled."""
    motors_off: bool
    """Whether a safety stop kept the motors off at the end of the last tick."""
    force: tuple[float, float, float]
    """Force that the device reports, along its axes [N]; NaN if it reports none. With several devices: the first."""
    forces: tuple[tuple[float, float, float], ...] = ()
    """Reported force of each device [N], in the order of the world."""


class Connection(NamedTuple):
    """Messages of a loop to and from a device of another program: a `Process` or a `Udp`."""

    samples: int
    """Number of accepted samples."""
    lost: int
    """Number of samples that never arrived."""
    late: int
    """Number of samples that arrived too late."""
    reordered: int
    """Number of samples that arrived after a newer one."""
    duplicate: int
    """Number of samples that arrived again."""
    unreadable: int
    """Number of invalid messages."""
    untaken: int
    """Number of commands that the device did not take."""
    round_trip: Spread | None
    """Time from a message to its answer [s]; `None`: not measured."""


class LoopReport(NamedTuple):
    """Final report of a loop."""

    ending: str | None
    """Reason for the end; `None` for a loop that was never started."""
    failure: str | None
    """Failure, if any: a lost device, a panic, an unwritable recording, or an output that could not be disabled."""
    safety_stop: str | None
    """Safety stop that was active at the end, if any."""
    ticks: int
    """Number of ticks."""
    missed_deadlines: int
    """Number of missed deadlines; they are skipped."""
    without_sample: int
    """Number of ticks without a fresh sample."""
    refused: int
    """Number of ticks whose sample the renderer rejected; their force is 0."""
    crowded: int
    """Number of ticks at which the renderer of a world ignored triangles or shell points for lack of room: the
    furthest."""
    motors_off: int
    """Number of ticks at whose end a safety stop kept the motors off."""
    cuts: int
    """How often the supervisor commanded zero force."""
    lateness: Spread
    """Time from the deadline of a tick to its start [s]."""
    duration: Spread
    """Duration of a tick, from the arrival of the sample to the command of the force [s]."""
    recorded: int | None
    """Number of ticks in the recording; `None` without a recording."""
    unrecorded: int | None
    """Number of ticks missing from the recording; `None` without a recording."""
    device: str | None = None
    """Name of the device with the safety stop; `None` for a single device or without a safety stop."""
    connections: tuple[Connection | None, ...] = ()
    """Connection to each device, in the order of the world; `None` for a device that is not of another program."""


def _connection(counts: Sequence[int], times: Sequence[float] | None) -> Connection:
    samples, lost, late, reordered, duplicate, unreadable, untaken = counts
    round_trip = None if times is None else Spread(*times)
    return Connection(samples, lost, late, reordered, duplicate, unreadable, untaken, round_trip)


class Loop(Fixed, _palpate.Loop):
    """Real-time loop that renders a renderer or a world on a device, as `palpate run` does, in a thread without Python.

        with palpate.Loop(palpate.devices.Pointer(), palpate.Renderer(stiffness=400.0, ...)) as loop:
            ticks = loop.read(wait=1.0)

    The thread samples the device, renders, and commands the force through a safety layer (`docs/realtime.md`). Only a
    user-defined `palpate.devices.Device` runs Python in that thread. Python
    reads the ticks and can change the rendering. The loop renders a copy of the renderer or world, from its initial
    state; `force_limit` and `soft_start` of the renderer apply to the loop.

        world = palpate.World("experiments/worlds/paddle.toml")
        device = palpate.devices.PointerInWorld(world)
        with palpate.Loop(device, world) as loop:
            device.move_to([0.0, 0.0, 0.01])
            ticks, bodies = loop.read(wait=1.0), loop.bodies

    A world with several devices needs one device for each name:

        world = palpate.World("experiments/worlds/pinch.toml")
        fingers = {name: palpate.devices.PointerInWorld(world, name) for name in ("left", "right")}
        with palpate.Loop(fingers, world) as loop:
            ticks, devices = loop.read(wait=1.0), loop.devices

    A `palpate.engines.LowRateSimulator` renders the bodies of a game or an engine that runs at a lower rate.

    If one device has no valid sample, has a safety stop, is cut off by the supervisor or rejects its force, all devices
    get zero force.

    The loop ends and commands zero force when the `with` block ends, normally, by an exception or by Ctrl-C; on `stop`;
    when the interpreter exits; and when the loop is garbage-collected. A signal that ends Python immediately, such as
    SIGTERM without a handler, does not end the loop properly. In this case a watchdog process removes the force of a
    device that holds its last command.

    Args:
        device: One of `palpate.devices`; for a world with several devices a mapping from their names to devices.
        renderer: A `Renderer`, a `World` with devices of three or six axes, or a `palpate.engines.LowRateSimulator`,
            which runs on a device of a `World` or on a real device.
        record: Path of the recording (MCAP) to write; an existing file is not overwritten.
        ring: Capacity of the buffer for `read` [ticks]; if it is full, the oldest ticks are dropped and counted.
        largest_speed: Device speed above which a safety stop switches the motors off [m/s].
        range: Allowed positions of the device along the contact's axis, from and to [m]; `None`: any. Not for a world.
        oscillation: Energy generated within 0.2 s that counts as oscillation [J]; `math.inf`: no check.
        stall_after_periods: Periods from tick to tick after which a supervisor commands zero force; `None`: 1.5, or a period
            and 3 ms if that is longer.
        priority: Requested priority under SCHED_FIFO, 1 to 98; 0: none.
        lock_memory: Whether to lock the memory of the whole process in RAM.
        processor: Processor to run on; `None`: any.
        spin: Time of busy waiting before each deadline [s], at most 1.

    Raises:
        ValueError: An argument is not allowed; the message names it.
        OSError: A device cannot be opened, or a recording cannot be created.
    """

    granted: list[Granted]
    """Requests to the operating system and their results; empty before the start."""
    report: LoopReport | None
    """Final report; `None` before the end."""
    bodies: NDArray[np.void]
    """Bodies of a world at the ticks of the last `read`: an array with the fields of `palpate.BODIES`. It contains the
    moving bodies and the proxies of the devices."""
    devices: NDArray[np.void]
    """Devices of a world at the ticks of the last `read`: an array with the fields of `palpate.DEVICES`. It is empty
    for a loop with one device, whose data are in the ticks."""
    device_names: tuple[str, ...]
    """Names of the devices, indexed by the field `device`. Empty for a renderer."""
    body_names: tuple[str, ...]
    """Names of the bodies of a world, indexed by the field `body`; the last are the devices, for their proxies. Empty
    for a renderer."""
    contact_names: tuple[tuple[str, str], ...]
    """Names of the two sides of each contact of a world, indexed by the field `pair`. Empty for a renderer."""

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
        stall_after_periods: float | None = None,
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
            "stall_after_periods": stall_after_periods,
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
            raise ValueError(f"range is for a Renderer, whose contact has one axis; a {kind} has no range")
        if not isinstance(renderer, World) and isinstance(device, Mapping):
            kind = "Renderer" if isinstance(renderer, Renderer) else "LowRateSimulator"
            raise ValueError(f"device is a mapping of names, which is for a World; a {kind} runs on one device")
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
        made._drivers = list(device.values()) if isinstance(device, Mapping) else [device]
        return made

    _parameters: dict[str, Any]
    _world: World | None
    _is_slow: bool
    _started: bool
    _said: bool
    _drivers: list[Device]

    def start(self) -> list[Granted]:  # type: ignore[override]
        """Starts the thread of the loop. A loop runs once.

        Returns:
            Requests to the operating system and their results. The loop runs in any case.

        Raises:
            RuntimeError: The loop was started before.
        """
        self._found(granted=[Granted(*answer) for answer in super().start()])
        self._started = True
        _RUNNING.add(self)
        return self.granted

    def stop(self) -> LoopReport:  # type: ignore[override]
        """Ends the loop. Waits until zero force is commanded, the device is closed, and the recording is written.

        A second call returns the same report.

        Raises:
            LoopError: The loop or its shutdown failed. It is raised once; `report` has the details.
        """
        _RUNNING.discard(self)
        (ending, failure, safety_stop, device), counts, (lateness, duration), recorded, connections = super().stop()
        made, lost = (None, None) if recorded is None else recorded
        times = (Spread(*lateness), Spread(*duration))
        with_each = tuple(None if values is None else _connection(*values) for values in connections)
        report = LoopReport(ending, failure, safety_stop, *counts, *times, made, lost, device, with_each)
        self._found(report=report)
        if failure is not None and not self._said:
            self._said = True
            raised = next((device._raised for device in self._drivers if device._raised is not None), None)
            raise LoopError(failure if raised is None else f"{failure}: {raised!r}") from raised
        return report

    def read(self, wait: float = 0.0) -> NDArray[np.void]:
        """Returns the ticks since the last `read`, oldest first: an array with the fields of `palpate.RECORDED`.

        For a world, a tick has one element per contact, or one element without contact values if nothing touches.
        `contact_names` has the names. `bodies` and, with several devices, `devices` have the states at these ticks.

        Args:
            wait: Longest time to wait for the first tick [s]; 0: no wait.

        Raises:
            LoopError: The loop has ended by itself and all its ticks were read; or no tick arrived within `wait`.
        """
        words, bodies, devices = self.take(wait)
        ticks = words.view(RECORDED)
        self._found(bodies=bodies.view(BODIES), devices=devices.view(DEVICES))
        if len(ticks) == 0:
            self._say_why(wait)
        return ticks

    def _say_why(self, wait: float) -> None:
        """Raises the reason for missing ticks, if the loop has ended by itself or has stalled."""
        now = self.status
        if self._started and self.report is None and not now.running:
            # The loop ended by itself: report the reason.
            report = self.stop()
            raise LoopError(f"the loop has ended: {report.ending}")
        if wait > 0.0 and now.running:
            silent = "none since its start" if now.silent is None else f"the last one {now.silent:.3g} s ago"
            raise LoopError(f"the loop has stalled: no tick within {wait} s, {silent}")

    def events(self) -> list[Event]:  # type: ignore[override]
        """Returns the events since the last call: faults, safety stops, changes, missed deadlines and the end.

        The newest 1000 events are kept. If older ones were dropped, the first event has their number and the kind
        `"lost"`.
        """
        pending, gone = super().events()
        events = [Event(*event) for event in pending]
        if gone:
            sequence, at = (events[0].sequence, events[0].t_s) if events else (0, 0.0)
            events.insert(0, Event(sequence, at, "lost", f"earlier events that were not read in time: {gone}"))
        return events

    def change(self, world: World | None = None, **changes: Any) -> int:  # type: ignore[override]
        """Changes the rendering from the next tick on: any argument of `Renderer`, or the world.

            loop.change(stiffness=800.0, mass=0.2)
            loop.change(world.replace(contacts=[...]))  # of a World; loop.change(contacts=[...]) is the same

        Changes of stiffness, mass, virtual force and method are blended over 0.1 s. A new method starts with its own
        default settings. `object_position` and `object_velocity` are initial values: a change does not move the object.
        An object that becomes a wall stays at its position if the device touches it; otherwise it moves to
        `object_position`.

        The new world may have other masses, weights, shapes, contact laws, joints, positions and another method. The
        devices, the bodies, the pairs in contact, the period and the limits of the loop must stay. A body whose tables
        have the same initial position and velocity keeps its current state; another body moves to the state of the
        tables. The force of the old world continues for three ticks, then it is blended into the new one over 0.1 s.
        The energy ledger continues.

        Args:
            world: New world, for a loop of a world.
            changes: Arguments of `Renderer`; for a loop of a world, arguments of `World.replace`.

        Returns:
            Number of the change. The field `generation` of the ticks has it from the tick at which the change applies.

        Raises:
            ValueError: An argument is not allowed; the period, the side and the limits of the loop cannot change.
            RuntimeError: The loop has ended.
            TypeError: The loop renders a LowRateSimulator, which publishes its own contacts; a world is given to a loop
                of a renderer; `world` is not a world; or an argument is unknown.
        """
        if self._is_slow:
            raise TypeError("the loop renders the contacts of a LowRateSimulator; its next `publish` changes them")
        limits = ("force_limit", "torque_limit", "soft_start")
        if self._world is not None:
            return self._change_world(self._world if world is None else world, changes, limits)
        if world is not None:
            raise TypeError("the loop renders a Renderer; make another Loop for a World")
        for name in limits:
            if name in changes:
                raise ValueError(f"{name} is a limit of the loop and cannot change while it runs; make another Loop")
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
                raise ValueError(f"{name} is a limit of the loop and cannot change while it runs; make another Loop")
        if changes:
            known = ("title", "loop", "devices", "bodies", "contacts", "joints", "fields", "render", "model", "methods", "measure", "method")
            for name in changes:
                if name not in known:
                    raise TypeError(f"a world has no table {name}; the tables are {', '.join(known)}")
            world = world.replace(**changes)
        generation = self.change_world(world)
        self._world = world
        return generation

    @property
    def world(self) -> World | None:
        """Rendered world, in its initial state; `None` for a renderer. `loop.bodies` has the current states."""
        return self._world

    @property
    def parameters(self) -> dict[str, Any]:
        """Current arguments of `palpate.Renderer`; empty for a world."""
        return FixedParameters(self._parameters, "change them by loop.change(NAME=VALUE)")

    @property
    def status(self) -> LoopStatus:
        """State of the loop."""
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
        raise TypeError("a Loop runs on a device and cannot be pickled")

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
    """Returns the parameters of each device, in the order of the world."""
    names = renderer.names()[0] if isinstance(renderer, World) else []
    listed = " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))
    if not isinstance(device, Mapping):
        if len(names) > 1:
            raise ValueError(f"the world has the devices {listed}; give one for each, as {{name: device}}")
        return [device._given()]
    for name in device:
        if name not in names:
            raise ValueError(f"the world has no device {name!r}; it has {listed}")
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
    """Returns the names of devices, bodies and contacts, indexed by their numbers in the rows."""
    if not isinstance(renderer, World):
        return (), (), ()
    devices, bodies = renderer.names()
    return tuple(devices), (*bodies, *devices), tuple(contact.between for contact in renderer.contacts)


def _split(parameters: dict[str, Any]) -> tuple[Any, dict[str, Any], float, dict[str, Any]]:
    """Splits parameters into method, common arguments, soft start and settings of the method."""
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
    """Returns the scene text for a recording of this loop, along x; `None` if the mass of the device is unknown."""
    method, given, _, settings = _split(renderer.parameters)
    table = device._in_scene()
    if table is None and given["device_mass"] is not None:
        table = {"name": "device", "axes": ["x"], "mass_kg": given["device_mass"]}
    if table is None:
        return None
    period = given["period"]
    guard = None
    if given["guard"] != "off":
        guard = {
            "mode": given["guard"],
            "speed_m_per_s": given["guard_speed"],
            "allowance_j": given["guard_allowance"],
            "acceleration_m_per_s2": given["guard_acceleration"],
            "hand_force_n": given["guard_hand_force"],
            "least_mass_kg": given["guard_mass"],
            "learn_mass": given["guard_learn_mass"] or None,
            "recovery_w": given["guard_recovery"],
        }
        guard = {key: value for key, value in guard.items() if value is not None}
    limit = given["force_limit"]
    keys = {setting.name: setting.key for setting in METHODS[method].settings}
    is_wall = given["mass"] == float("inf")
    sign = 1.0 if given["side"] == "negative" else -1.0
    body: dict[str, Any] = {
        "name": "wall" if is_wall else "object",
        "position_m": [given["object_position"], 0.0, 0.0],
        "shape": {"half_space": {"normal": [sign, 0.0, 0.0]}},
    }
    if is_wall:
        body["fixed"] = True
    else:
        body["axes"] = ["x"]
        body["mass_kg"] = given["mass"]
        body["velocity_m_per_s"] = [given["object_velocity"], 0.0, 0.0]
        body["force_n"] = [given["force"], 0.0, 0.0]
    tables: dict[str, Any] = {
        "format": 2,
        "title": "a loop of Python",
        "loop": {"period_s": period, "hold": None if given["hold"] == "constant" else given["hold"]},
        "device": [table],
        "body": [body],
        "contact": [{"between": ["device", body["name"]], "stiffness_n_per_m": given["stiffness"]}],
        "model": {
            "device_mass_kg": given["device_mass"],
            "delay_s": given["delay"],
            "lag_s": given["lag"],
            "gain": given["gain"],
            "delay_deviation_s": given["delay_deviation"],
            "lag_deviation_s": given["lag_deviation"],
            "gain_deviation": given["gain_deviation"],
        },
        "measure": {"duration_s": 1.0},
        "render": {
            "method": method,
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
    """Returns the path of a recording, if any, after a check that it is not empty."""
    if path is not None and not os.fspath(path):
        raise ValueError("record is an empty path, but must name a file")
    return path
