"""Devices for `palpate.Loop`: simulated ones, and Haply's.

    import palpate

    device = palpate.devices.Pointer(position=-0.01)  # a device in a hand that this program leads
    device = palpate.devices.Simulated("experiments/wall.toml")  # device and hand of a scene
    device = palpate.devices.TwoDiy("/dev/ttyACM0")
    device = palpate.devices.Inverse3()

A world runs on these, one for each of its devices:

    device = palpate.devices.PointerInWorld(world)  # the world's device in a hand that this program leads
    device = palpate.devices.Simulated(world)  # device and hand of the world
    device = palpate.devices.TwoDiy(world_axes=["x", "z"])  # its plane stands upright in the world
    device = palpate.devices.Inverse3()

A device is opened when a loop is made with it.
"""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING, Any, Sequence

from numpy.typing import ArrayLike

from . import _palpate
from ._arrays import numbers, row
from ._scene import Scene
from ._world import World

if TYPE_CHECKING:
    from typing_extensions import Self

__all__ = ["Device", "Inverse3", "Pointer", "PointerInWorld", "Simulated", "TwoDiy"]


class Device:
    """Device of a `palpate.Loop`: one of the devices here.

    A driver in Python cannot be a subclass: the loop's thread runs no Python. Call `Renderer.step` or `World.step` from your
    own loop, or implement the trait `Device` of palpate-device in Rust.
    """

    def __new__(cls, *_: Any, **__: Any) -> Self:
        if Device in cls.__bases__ and cls.__module__ != __name__:
            raise TypeError(
                f"{cls.__name__} cannot be a device of a palpate.Loop: the loop's thread runs no Python, so that it takes "
                "Pointer, PointerInWorld, Simulated, TwoDiy and Inverse3 only. For a device of your own, call step() of a "
                "palpate.Renderer or palpate.World from your own loop (docs/python.md), or implement the trait Device of "
                "palpate-device in Rust"
            )
        return super().__new__(cls)

    def _given(self) -> dict[str, Any]:
        raise TypeError("a Device is one of palpate.devices: Pointer, PointerInWorld, Simulated, TwoDiy or Inverse3")

    def _in_scene(self) -> dict[str, Any] | None:
        """The device as a table of a scene; None where nobody knows its mass."""
        return None


class Pointer(Device):
    """A simulated device in a hand that a program leads, as `palpate live` has for the mouse.

    The hand follows its target through a critically damped filter of 100 rad/s, and holds the device by a spring and a
    damper. Let go of, the device moves by itself until its friction stops it.

    Args:
        mass: Mass of the device [kg].
        position: Where device and hand are at the start [m].
        viscous_friction: Viscous friction of the device [N s/m].
        dry_friction: Dry friction of the device while nobody holds it [N].
        encoder_quantum: Quantum of the position [m]; 0: none.
        largest_force: What the motor gives at most [N]; `None`: whatever is commanded.
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
        """Leads the hand to `target` [m], along the contact's axis; a hand that has let go takes hold again.

        Raises:
            ValueError: A target that is not finite.
        """
        self._hand.move_to(target)

    def disable_output(self) -> None:
        """Lets go of the device."""
        self._hand.disable_output()

    @property
    def target(self) -> float | None:
        """Where the hand wants to be [m]; `None`: it has let go."""
        return self._hand.target

    def _given(self) -> dict[str, Any]:
        return {"kind": "pointer", "hand": self._hand, **self._values}

    def _in_scene(self) -> dict[str, Any]:
        values = self._values
        return {
            "kind": "point-mass",
            "mass_kg": values["mass"],
            "position_m": values["position"],
            "viscous_n_s_per_m": values["viscous_friction"],
            "encoder_quantum_m": values["encoder_quantum"],
            "motor_limit_n": values["largest_force"],
        }


class PointerInWorld(Device):
    """The device of a world in a hand that a program leads through space.

    Along each axis of the world it is a `Pointer` with the mass and the sensor that the world's device has along it. It
    begins where that device does; its motors have the world's delay, lag and gain. The hand turns a device of six axes with the
    stiffness and damping of the world's hand, or 0.3 N m/rad.

    Args:
        world: A world with devices of three or six axes.
        device: Name of the device in the world; `None`: the only one.

    Raises:
        ValueError: A name that the world has not, or none where it has several devices.
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
        """Leads the hand to `target`, three coordinates in the world [m]; a hand that has let go takes hold again.

        Raises:
            ValueError: Not three numbers that are finite.
        """
        given = numbers("target", target)
        if given.shape != (3,):
            raise ValueError(f"target has the shape {given.shape}, but must have (3,): x, y, z")
        self._hand.move_to(given.tolist())

    def disable_output(self) -> None:
        """Lets go of the device."""
        self._hand.disable_output()

    @property
    def target(self) -> tuple[float, float, float] | None:
        """Where the hand wants to be in the world [m]; `None`: it has let go."""
        target = self._hand.target
        return None if target is None else (target[0], target[1], target[2])

    def turn_to(self, orientation: ArrayLike | None) -> None:
        """Turns the hand of a device of six axes to `orientation`, a quaternion w, x, y, z; `None`: as the device begins.

        A hand that has let go turns nothing until `move_to` takes hold again, and leads the device to this then.

        Raises:
            ValueError: Not four numbers that are finite, or all of them 0.
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
        """How the hand wants the device to be turned, a unit quaternion w, x, y, z; `None`: as the device begins."""
        turned = self._hand.orientation
        return None if turned is None else (turned[0], turned[1], turned[2], turned[3])

    def _given(self) -> dict[str, Any]:
        return {"kind": "pointer-in-world", "world": self._world, "hand": self._hand, "device": self._device}


class Simulated(Device):
    """The device and the hand of a scene or of a world, in real time. Contacts and loop of it are not used.

    Args:
        scene: A `palpate.Scene`, the path of a scene file, or a `palpate.World`; of a world with several devices, it is the one
            that has the name for which the loop takes it.
    """

    def __init__(self, scene: Scene | World | str | os.PathLike[str]) -> None:
        self._scene = scene if isinstance(scene, (Scene, World)) else Scene.read(scene)

    def _given(self) -> dict[str, Any]:
        if isinstance(self._scene, World):
            return {"kind": "simulated-in-world", "world": self._scene}
        return {"kind": "simulated", "scene": self._scene}

    def _in_scene(self) -> dict[str, Any] | None:
        table = self._scene.to_dict()["device"]
        return table if isinstance(self._scene, Scene) and table["kind"] == "point-mass" else None


class TwoDiy(Device):
    """A Haply 2DIY on a serial port, or `palpate emulate haply-2diy`.

    The board holds its last torque until it is told another one. A watchdog, a process beside this one, takes that torque
    off when this process is killed or hangs. Read `docs/devices/haply-2diy.md` first.

    Args:
        port: Serial port; `None`: the one that looks like a 2DIY.
        generation: 1, 2 or 3.
        board: `"m0"`, `"m3"` or `"dev"`; `None`: found out where its first angles tell.
        start_pose: Pose of the arm while it is opened: `"retracted"`, `"extended"`, or two angles [degrees]. Elsewhere
            forces point in wrong directions.
        origin: Where the contact's coordinate is 0, along the device's two axes [m]; of a world, what place of the device is
            that at which the world's device begins. `None`: the usual place.
        normal: Direction in which the contact's coordinate grows; `None`: away from the base. Not for a world.
        world_axes: Which axis of the world each of its two is, such as `["x", "-z"]`, with - where it points the other
            way; `None`: x and y. Along the third the tool stays where it begins. For a world only.
        watchdog: Whether there is a watchdog.
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
            "watchdog": __watchdog() if watchdog else None,
        }

    def _given(self) -> dict[str, Any]:
        return {"kind": "haply-2diy", **self._values}


class Inverse3(Device):
    """A Haply Inverse3 behind its Inverse Service, or `palpate emulate inverse3`.

    Args:
        service: URL of the service's simulation channel; `None`: `ws://localhost:10001`.
        events: URL of its events channel, which tells why a device is gone; `None`: not listened to.
        device_id: Which Inverse3 of the service; `None`: the only one.
        origin: Where the contact's coordinate is 0 [m]; of a world, what place of the device is that at which the world's
            device begins. `None`: where the cursor is when the device is opened.
        normal: Direction in which the contact's coordinate grows; `None`: along x. Not for a world.
        world_axes: Which axis of the world each of its three is, such as `["x", "-z", "y"]`; `None`: x, y and z. For a
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


def __watchdog() -> list[str]:
    """The command that serves as a watchdog."""
    if not sys.executable or _palpate.__file__ is None:
        return []
    return [sys.executable, "-I", "-S", "-c", _SERVE, _palpate.__file__]
