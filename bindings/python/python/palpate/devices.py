"""Devices for `palpate.Loop`: simulated devices, devices of Haply and Force Dimension, and user-defined devices.

    import palpate

    device = palpate.devices.Pointer(position=-0.01)  # simulated device, in a hand moved by the program
    device = palpate.devices.Simulated("experiments/wall.toml")  # device and hand of a scene
    device = palpate.devices.TwoDiy("/dev/ttyACM0")
    device = palpate.devices.Inverse3()
    device = palpate.devices.ForceDimension()
    device = palpate.devices.Process("python my_device.py")  # a program that moves a device

A world needs one of these for each of its devices:

    device = palpate.devices.PointerInWorld(world)  # device of the world, in a hand moved by the program
    device = palpate.devices.Simulated(world)  # device and hand of the world
    device = palpate.devices.TwoDiy(world_axes=["x", "z"])  # its plane is vertical in the world
    device = palpate.devices.Inverse3()

The constructor of a loop opens its devices.
"""

from __future__ import annotations

import math
import os
import shlex
import sys
from typing import Any, NamedTuple, Sequence

from numpy.typing import ArrayLike

from . import _palpate
from ._arrays import numbers, row
from ._scene import Scene
from ._world import World

__all__ = [
    "Capabilities",
    "Device",
    "ForceDimension",
    "Inverse3",
    "Plugin",
    "Pointer",
    "PointerInWorld",
    "Process",
    "Simulated",
    "TwoDiy",
    "Udp",
]


class Capabilities(NamedTuple):
    """Capabilities of a user-defined device. `None`: unknown, no limit."""

    name: str = "own device"
    """Name of the device, for reports and recordings."""
    axes: int = 1
    """Number of axes with a position and a force, 1 to 3."""
    torque_axes: int = 0
    """Number of axes with a torque, 0 to 3; 0 without an orientation."""
    orientation: bool = False
    """Whether `read` also returns an orientation."""
    largest_force: float | None = None
    """Largest force in every pose [N]; a larger one is shortened."""
    largest_torque: float | None = None
    """Largest torque in every pose [N m]; a larger one is shortened."""
    effective_mass: float | None = None
    """Effective mass at the end-point [kg]."""
    encoder_quantum: float | None = None
    """Quantum of the position [m]."""


class Device:
    """Device of a `palpate.Loop`. A subclass with `capabilities`, `read` and `write` is a user-defined driver.

        class Knob(palpate.devices.Device):
            def capabilities(self):
                return palpate.devices.Capabilities("knob", axes=1, largest_force=2.0)

            def read(self):
                return board.position()

            def write(self, force):
                board.command(force)

    The thread of the loop calls `read` and `write` in each tick, so a tick waits for the lock of the interpreter: keep other
    Python threads idle. Safety, supervision and recording are as for other devices. An exception ends the loop with zero
    force, and `Loop.stop` raises it as the cause of a `LoopError`. The last call of `write` has a force of 0.

    **If this process is killed or hangs, no watchdog process can reach the device**: it must remove its force by itself after
    a time without a command. A driver in a program of its own (`Process`) has a watchdog process.
    """

    origin: Sequence[float] | None = None
    """Device position at which the contact's coordinate is 0 [m], or that of the world's device; `None`: 0."""
    normal: Sequence[float] | None = None
    """Direction in which the contact's coordinate increases; `None`: the first axis. Not for a world."""
    world_axes: Sequence[str] | None = None
    """Axes of the world for those of the device, such as `["x", "-z"]`; `None`: x, y, z. For a world only."""
    _raised: BaseException | None = None

    def capabilities(self) -> Capabilities:
        """Returns what the device can do; called once, by the constructor of the loop."""
        raise NotImplementedError(f"{type(self).__name__} has no method capabilities")

    def read(self) -> Any:
        """Returns the position [m], now: a number for one axis, else one for each; `None`: there is no new sample.

        With an orientation: a tuple of the position and the unit quaternion w, x, y, z.
        """
        raise NotImplementedError(f"{type(self).__name__} has no method read")

    def write(self, force: Any, torque: Any = None) -> None:
        """Commands the force [N], until the next call: a number for one axis, else a tuple.

        Args:
            force: Force on the device, a number for one axis, else one for each [N].
            torque: A tuple of torques [N m], only for a device with `torque_axes`.
        """
        raise NotImplementedError(f"{type(self).__name__} has no method write")

    def zero(self) -> None:
        """Commands zero force from another thread, while the loop's thread hangs in `read` or `write`.

        A subclass may define it, if its hardware can be called from two threads.
        """

    def _given(self) -> dict[str, Any]:
        kind = type(self)
        lacks = [name for name in ("capabilities", "read", "write") if getattr(kind, name) is getattr(Device, name)]
        if lacks:
            raise TypeError(f"{kind.__name__} has no method {', '.join(lacks)}; a user-defined device defines it")
        can = self.capabilities()
        if not isinstance(can, Capabilities):
            raise TypeError(f"capabilities() returned {can!r}, but must return palpate.devices.Capabilities")
        self._raised = None
        return {"kind": "own", "driver": self, "has_zero": kind.zero is not Device.zero, **can._asdict(), **_placed(self)}

    def _in_scene(self) -> dict[str, Any] | None:
        """Returns the device as a table of a scene, without its hand and along x; None if its mass is unknown."""
        return None


def _placed(device: Device) -> dict[str, Any]:
    """Returns the position of a contact or a world in the device."""
    return {
        "origin": None if device.origin is None else row("origin", device.origin),
        "normal": None if device.normal is None else row("normal", device.normal),
        "world_axes": None if device.world_axes is None else list(device.world_axes),
    }


class Pointer(Device):
    """Simulated device in a hand that the program moves, like the mouse device of `palpate live`.

    The hand follows its target through a critically damped filter of 100 rad/s and holds the device by a spring and a
    damper. After a release the device moves freely until its friction stops it.

    Args:
        mass: Mass of the device [kg].
        position: Initial position of device and hand [m].
        viscous_friction: Viscous friction of the device [N s/m].
        dry_friction: Dry friction of the device while the hand has released it [N].
        encoder_quantum: Quantum of the position [m]; 0: none.
        largest_force: Force limit of the motor [N]; `None`: no limit.
        hand_mass: Mass of the hand, which moves with the device while it holds it [kg].
        hand_stiffness: Stiffness of the hand [N/m].
        hand_damping: Damping of the hand [N s/m].
    """

    def __init__(
        self,
        *,
        mass: float = 0.25,
        position: float = 0.0,
        viscous_friction: float = 1.0,
        dry_friction: float = 1.5,
        encoder_quantum: float = 0.0,
        largest_force: float | None = None,
        hand_mass: float = 0.1,
        hand_stiffness: float = 400.0,
        hand_damping: float = 20.0,
    ) -> None:
        values = dict(locals())
        del values["self"]
        self._values = values
        self._hand = _palpate.Hand(position)

    def move_to(self, target: float) -> None:
        """Moves the hand to `target` [m], along the contact's axis. After a release it grasps the device again.

        Raises:
            ValueError: The target is not finite.
        """
        self._hand.move_to(target)

    def disable_output(self) -> None:
        """Releases the device."""
        self._hand.disable_output()

    @property
    def target(self) -> float | None:
        """Target of the hand [m]; `None` after a release."""
        return self._hand.target

    def _given(self) -> dict[str, Any]:
        return {"kind": "pointer", "hand": self._hand, **self._values}

    def _in_scene(self) -> dict[str, Any]:
        values = self._values
        return {
            "name": "device",
            "axes": ["x"],
            "mass_kg": values["mass"],
            "position_m": [values["position"], 0.0, 0.0],
            "quantum_m": values["encoder_quantum"],
            "drivetrain": {
                "viscous_friction_n_s_per_m": values["viscous_friction"],
                "motor_limit_n": values["largest_force"],
            },
        }


class PointerInWorld(Device):
    """Simulated device of a world in a hand that the program moves in space.

    Along each axis of the world it is a `Pointer` with the mass and the sensor of the world's device. It starts at the
    initial position of that device; its motors have the world's delay, lag and gain. The hand rotates a device of six
    axes with the stiffness and damping of the world's hand, or 0.3 N m/rad.

    Args:
        world: A world with devices of three or six axes.
        device: Name of the device in the world; `None`: the only one.

    Raises:
        ValueError: The world does not have the device; or it has several, and none is named.
    """

    def __init__(self, world: World, device: str | None = None) -> None:
        self._world = world
        devices = dict(zip(world.names()[0], world.to_dict()["device"]))
        if device is None and len(devices) == 1:
            [device] = devices
        if device not in devices:
            given = "device is not given" if device is None else f"device is {device!r}"
            raise ValueError(f"{given}, but must be one of the world's: {', '.join(devices)}")
        self._device: str = device
        self._hand = _palpate.HandInWorld(devices[device].get("position_m", [0.0, 0.0, 0.0]))

    @property
    def device(self) -> str:
        """Name of the device in the world."""
        return self._device

    def move_to(self, target: ArrayLike) -> None:
        """Moves the hand to `target`, in the world frame [m]. After a release it grasps the device again.

        Raises:
            ValueError: The target is not three finite numbers.
        """
        given = numbers("target", target)
        if given.shape != (3,):
            raise ValueError(f"target has the shape {given.shape}, but must have (3,): x, y, z")
        self._hand.move_to(given.tolist())

    def disable_output(self) -> None:
        """Releases the device."""
        self._hand.disable_output()

    @property
    def target(self) -> tuple[float, float, float] | None:
        """Target of the hand in the world frame [m]; `None` after a release."""
        target = self._hand.target
        return None if target is None else (target[0], target[1], target[2])

    def turn_to(self, orientation: ArrayLike | None) -> None:
        """Turns the hand of a device of six axes to `orientation`, a quaternion w, x, y, z; `None`: the initial one.

        After a release the orientation takes effect when `move_to` grasps the device again.

        Raises:
            ValueError: The orientation is not four finite numbers, or has the length 0.
        """
        if orientation is None:
            self._hand.turn_to(None)
            return
        given = numbers("orientation", orientation)
        if given.shape != (4,):
            raise ValueError(f"orientation has the shape {given.shape}, but must have (4,): w, x, y, z")
        self._hand.turn_to(given.tolist())

    @property
    def orientation(self) -> tuple[float, float, float, float] | None:
        """Target orientation of the hand, a unit quaternion w, x, y, z; `None`: the initial orientation."""
        turned = self._hand.orientation
        return None if turned is None else (turned[0], turned[1], turned[2], turned[3])

    def _given(self) -> dict[str, Any]:
        return {"kind": "pointer-in-world", "world": self._world, "hand": self._hand, "device": self._device}


class Simulated(Device):
    """Device and hand of a scene or of a world, in real time. Its contacts and its loop are not used.

    Args:
        scene: A `palpate.Scene`, the path of a file of one, or a `palpate.World`. In a world with several devices, the
            loop assigns the name of the device.
    """

    def __init__(self, scene: Scene | World | str | os.PathLike[str]) -> None:
        self._scene = scene if isinstance(scene, (Scene, World)) else Scene.read(scene)

    def _given(self) -> dict[str, Any]:
        if isinstance(self._scene, World):
            return {"kind": "simulated-in-world", "world": self._scene}
        return {"kind": "simulated", "scene": self._scene}

    def _in_scene(self) -> dict[str, Any] | None:
        if not isinstance(self._scene, Scene):
            return None
        [table] = self._scene.to_dict()["device"]
        if "linkage" in table:
            return None
        [axis] = table["axes"]
        made = {key: table[key] for key in ("mass_kg", "quantum_m", "noise_m", "drivetrain") if key in table}
        for key in ("position_m", "velocity_m_per_s"):
            if key in table:
                made[key] = [_along(axis, table[key]), 0.0, 0.0]
        return {"name": "device", "axes": ["x"], **made}


class TwoDiy(Device):
    """Haply 2DIY on a serial port, or `palpate devices emulate haply-2diy`.

    The board holds its last torque until the next command. A watchdog process removes this torque if the program is
    killed or hangs. Read `docs/devices/haply-2diy.md` first.

    Args:
        port: Serial port; `None`: the port that looks like a 2DIY.
        generation: 1, 2 or 3.
        board: `"m0"`, `"m3"` or `"dev"`; `None`: detected from the first angles, if possible.
        start_pose: Pose of the arm while the device is opened: `"retracted"`, `"extended"`, or two angles [degrees]. In
            another pose, forces have wrong directions.
        origin: Device position at which the contact's coordinate is 0 [m]; for a world, device position that
            corresponds to the initial position of the world's device. `None`: the default position.
        normal: Direction in which the contact's coordinate increases; `None`: away from the base. Not for a world.
        world_axes: Axes of the world for the two device axes, such as `["x", "-z"]`; "-" reverses the direction.
            `None`: x and y. Along the third axis the tool stays at its initial position. For a world only.
        watchdog: Whether to start a watchdog process.
    """

    def __init__(
        self,
        port: str | os.PathLike[str] | None = None,
        *,
        generation: int = 3,
        board: str | None = None,
        start_pose: str | tuple[float, float] = "retracted",
        origin: Sequence[float] | None = None,
        normal: Sequence[float] | None = None,
        world_axes: Sequence[str] | None = None,
        watchdog: bool = True,
    ) -> None:
        self._values: dict[str, Any] = {
            "port": port,
            "generation": generation,
            "board": board,
            "start_pose": start_pose if isinstance(start_pose, str) else tuple(row("start_pose", start_pose)),
            "origin": None if origin is None else row("origin", origin),
            "normal": None if normal is None else row("normal", normal),
            "world_axes": None if world_axes is None else list(world_axes),
            "watchdog": _watchdog_command() if watchdog else None,
        }

    def _given(self) -> dict[str, Any]:
        return {"kind": "haply-2diy", **self._values}


class Inverse3(Device):
    """Haply Inverse3 behind its Inverse Service, or `palpate devices emulate inverse3`.

    Args:
        service: URL of the simulation channel of the service; `None`: `ws://localhost:10001`.
        events: URL of its events channel, which reports the reason for a lost device; `None`: not used.
        device_id: Identifier of the Inverse3; `None`: the only one.
        origin: Device position at which the contact's coordinate is 0 [m]; for a world, device position that
            corresponds to the initial position of the world's device. `None`: the position of the cursor at opening.
        normal: Direction in which the contact's coordinate increases; `None`: along x. Not for a world.
        world_axes: Axes of the world for the three device axes, such as `["x", "-z", "y"]`; `None`: x, y and z. For a
            world only.
    """

    def __init__(
        self,
        service: str | None = None,
        *,
        events: str | None = None,
        device_id: str | None = None,
        origin: Sequence[float] | None = None,
        normal: Sequence[float] | None = None,
        world_axes: Sequence[str] | None = None,
    ) -> None:
        self._values: dict[str, Any] = {
            "service": service,
            "events": events,
            "device_id": device_id,
            "origin": None if origin is None else row("origin", origin),
            "normal": None if normal is None else row("normal", normal),
            "world_axes": None if world_axes is None else list(world_axes),
        }

    def _given(self) -> dict[str, Any]:
        return {"kind": "inverse3", **self._values}


class ForceDimension(Device):
    """Omega, delta, sigma or lambda of Force Dimension, or a Falcon, by the manufacturer's library.

    Its firmware takes the force off shortly after the last command, also if this process is killed or hangs.

    Args:
        library: File of `libdrd`; `None`: that of the SDK in the folder `FDSDK`, or in the usual folders.
        serial: Serial number; `None`: the only device.
        gripper: Whether to use the gripper, along its opening, in place of the handle.
        gravity_compensation: Whether the device carries its own weight.
        origin: Device position at which the contact's coordinate is 0 [m], or that of the world's device; `None`: 0.
        normal: Direction in which the contact's coordinate increases; `None`: the first axis. Not for a world.
        world_axes: Axes of the world for those of the device, such as `["x", "-z"]`; `None`: x, y, z. For a world only.
    """

    def __init__(
        self,
        library: str | os.PathLike[str] | None = None,
        *,
        serial: int | None = None,
        gripper: bool = False,
        gravity_compensation: bool = True,
        origin: Sequence[float] | None = None,
        normal: Sequence[float] | None = None,
        world_axes: Sequence[str] | None = None,
    ) -> None:
        self._own = {
            "library": library,
            "serial": serial,
            "gripper": gripper,
            "gravity_compensation": gravity_compensation,
        }
        self.origin, self.normal, self.world_axes = origin, normal, world_axes

    def _given(self) -> dict[str, Any]:
        return {"kind": "force-dimension", **self._own, **_placed(self)}


class Process(Device):
    """Device that another program moves: a command that this class starts, in any language.

    The program reads lines with wrenches and answers with lines of samples (`docs/your-device.md`). A watchdog process
    commands zero force if this process is killed or hangs.

    Args:
        command: Command with its arguments, such as `"python my_device.py"`, or a sequence of its words.
        origin: Device position at which the contact's coordinate is 0 [m], or that of the world's device; `None`: 0.
        normal: Direction in which the contact's coordinate increases; `None`: the first axis. Not for a world.
        world_axes: Axes of the world for those of the device, such as `["x", "-z"]`; `None`: x, y, z. For a world only.
        watchdog: Whether to start a watchdog process.
    """

    def __init__(
        self,
        command: str | Sequence[str],
        *,
        origin: Sequence[float] | None = None,
        normal: Sequence[float] | None = None,
        world_axes: Sequence[str] | None = None,
        watchdog: bool = True,
    ) -> None:
        self._command = shlex.split(command) if isinstance(command, str) else [str(word) for word in command]
        if not self._command:
            raise ValueError("command is empty, but must name a program")
        self.origin, self.normal, self.world_axes = origin, normal, world_axes
        self._watchdog = _watchdog_command() if watchdog else None

    def _given(self) -> dict[str, Any]:
        own = {"command": self._command, "address": None, "allow_remote": False, "watchdog": self._watchdog}
        return {"kind": "external", **own, **_placed(self)}


class Plugin(Device):
    """Device of a shared library with the functions of `bindings/c/include/palpate_device.h`.

    No watchdog process can reach it: if this process is killed, only the device itself can remove its force.

    Args:
        library: File of the library.
        argument: Text that the library interprets.
        origin: Device position at which the contact's coordinate is 0 [m], or that of the world's device; `None`: 0.
        normal: Direction in which the contact's coordinate increases; `None`: the first axis. Not for a world.
        world_axes: Axes of the world for those of the device, such as `["x", "-z"]`; `None`: x, y, z. For a world only.
    """

    def __init__(
        self,
        library: str | os.PathLike[str],
        argument: str = "",
        *,
        origin: Sequence[float] | None = None,
        normal: Sequence[float] | None = None,
        world_axes: Sequence[str] | None = None,
    ) -> None:
        self._library, self._argument = library, argument
        self.origin, self.normal, self.world_axes = origin, normal, world_axes

    def _given(self) -> dict[str, Any]:
        return {"kind": "plugin", "library": self._library, "argument": self._argument, **_placed(self)}


class Udp(Device):
    """Device that another program moves, which answers packets at an address.

    A packet is a line of the protocol of `Process`. A watchdog process commands zero force if this process is killed or
    hangs; the device itself must remove its force if the packets stop.

    Args:
        address: Address of the device.
        port: Its port.
        allow_remote: Permit an address on another machine; packets are neither encrypted nor authenticated.
        origin: Device position at which the contact's coordinate is 0 [m], or that of the world's device; `None`: 0.
        normal: Direction in which the contact's coordinate increases; `None`: the first axis. Not for a world.
        world_axes: Axes of the world for those of the device, such as `["x", "-z"]`; `None`: x, y, z. For a world only.
        watchdog: Whether to start a watchdog process.
    """

    def __init__(
        self,
        address: str,
        port: int,
        *,
        allow_remote: bool = False,
        origin: Sequence[float] | None = None,
        normal: Sequence[float] | None = None,
        world_axes: Sequence[str] | None = None,
        watchdog: bool = True,
    ) -> None:
        if not 1 <= port <= 65535:
            raise ValueError(f"port is {port}, but must be 1 to 65535")
        self._address = (address, port)
        self._allow_remote = allow_remote
        self.origin, self.normal, self.world_axes = origin, normal, world_axes
        self._watchdog = _watchdog_command() if watchdog and sys.platform != "win32" else None

    def _given(self) -> dict[str, Any]:
        own = {"command": None, "address": self._address, "allow_remote": self._allow_remote, "watchdog": self._watchdog}
        return {"kind": "external", **own, **_placed(self)}


def _along(axis: str | Sequence[float], vector: Sequence[float]) -> float:
    """Returns the component of a vector along an axis of a scene: the name of an axis of the world, or a direction."""
    if isinstance(axis, str):
        return float(vector["xyz".index(axis)])
    return sum(a * b for a, b in zip(axis, vector)) / math.hypot(*axis)


# Load only the compiled part: importing NumPy takes longer than the watchdog process may take to start.
_SERVE = """\
import sys
from importlib.machinery import ExtensionFileLoader
from importlib.util import module_from_spec, spec_from_loader
loader = ExtensionFileLoader("_palpate", sys.argv[1])
module = module_from_spec(spec_from_loader("_palpate", loader))
loader.exec_module(module)
module.guard()
"""


def _watchdog_command() -> list[str]:
    """Returns the command that runs the watchdog process."""
    if not sys.executable or _palpate.__file__ is None:
        return []
    return [sys.executable, "-I", "-S", "-c", _SERVE, _palpate.__file__]
