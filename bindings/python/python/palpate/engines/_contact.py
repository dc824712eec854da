"""`EngineContact`: contacts with the bodies of any engine."""

from __future__ import annotations

from typing import Any, Mapping, NamedTuple, NoReturn, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _palpate
from .._arrays import known, numbers
from .._fixed import Fixed, question_period
from .._world_values import ContactLedger, Effort, ToolState, Vector

BODY_COLUMNS = 55
"""Numbers that say a body at the beginning of a step: see `EngineContact.meet`."""


class PlacedShape(NamedTuple):
    """A shape that is fixed to a body."""

    kind: str
    """`sphere`, `box`, `capsule`, `cylinder`, `half-space`: all z <= 0 of its own axes, or `hull`: the least convex solid
    around points."""
    lengths: tuple[float, ...]
    """Radius [m] of a sphere; half lengths along the axes [m] of a box; radius and half length along z [m] of a
    capsule and a cylinder; none of a half-space and a hull."""
    position: Sequence[float] = (0.0, 0.0, 0.0)
    """Where the shape's own axes begin, in the axes of the body, from its reference point [m]."""
    orientation: Sequence[float] = (1.0, 0.0, 0.0, 0.0)
    """Unit quaternion [w, x, y, z] that turns the shape's axes into those of the body."""
    points: Sequence[Sequence[float]] = ()
    """Of a hull: points in the shape's own axes [m], of which at most 4096 may be its corners. Those that are outside of
    the others' hull by no more than 1e-6 of the largest coordinate are left out."""


class EngineBody(NamedTuple):
    """A body that tools may touch."""

    name: str
    """Its name, in messages."""
    shapes: Sequence[PlacedShape]
    """What tools touch of it."""


class EngineOutput(NamedTuple):
    """The answer to one sample."""

    forces: NDArray[np.float64]
    """Force on each device [N], a row for each."""
    limited: tuple[str, ...]
    """Limits that acted: `force`, `offset` of a proxy or an image, `soft-start`, and `safety-stop`: the loop has
    created energy, and all forces stay 0 until `reset()`."""
    effort: Effort
    """What the period has cost, over all steps of the engine."""
    fault: str | None
    """Why there was no contact, one of `palpate.FAULTS`; `None` where there was. All forces are then 0."""


class PointOfContact(NamedTuple):
    """A point at which a tool may touch a body, at the end of the last period."""

    between: tuple[str, str]
    """Names of the tool and the body."""
    mode: str
    """`free`, `sticks`, `slides`, or `parts`: they overlap but do not push."""
    point: Vector
    """Where the force acts [m]."""
    normal: Vector
    """Unit vector from the body to the tool."""
    penetration: float
    """How far they overlap [m], 0 where they do not."""
    force: Vector
    """Force on the tool [N]."""


class PortLedger(NamedTuple):
    """Energy at the port of a device over all periods that have ended [J]; positive to the hand."""

    port_work: float
    """Work of the held force on the device as it was measured."""
    held: float
    """Work of the mean force of its contacts on the device."""


class EngineContact(Fixed, _palpate.EngineContact):
    """Contacts of tools with bodies that another engine moves: what an adapter for an engine is made of.

    A period is

        contact.sample(position)
        for _ in range(steps):
            wrenches = contact.meet(h, rows)  # a row for each body, as it is now
            ...                               # the engine holds each wrench on its body over a step of h
        force = contact.hold()

    Args:
        tools: Radius of each tool [m], at most 1, by its name: a sphere, or a point of radius 0.
        bodies: What may be touched.
        period: Time from sample to sample [s].
        device_mass: Effective mass of each device, right within a factor of 2 [kg]: one number for all, or three
            for the axes, or a row of three for each device.
        stiffness: K of every contact [N/m].
        damping: Material damping B [N s/m].
        friction: Coefficient of friction.
        friction_stiffness: Stiffness of the bristle of friction [N/m]; `None`: that of the contact.
        friction_damping: Damping of the bristle of friction [N s/m]; `None`: `damping` times `friction_stiffness` over
            `stiffness`.
        end_velocity: Whether a step moves a body by the velocity at its end, as semi-implicit Euler does, and not by
            the mean of start and end.
        encoder_quantum: Quantum of the position sensors [m]; 0: not known to have one.
        delay: Time from a sample to the beginning of its force [s].
        lag: Time constant of the actuators [s].
        gain: Delivered over commanded force.
        force_limit: Largest length of the force on each device [N]; `math.inf`: no limit.
        soft_start: Time over which a force comes in where a start or a recovery finds contact, at most 60 [s].

    Raises:
        ValueError: Everything that is wrong, a line for each.
    """

    _tools: list[str]
    _bodies: list[str]

    def __new__(
        cls,
        *,
        tools: Mapping[str, float],
        bodies: Sequence[EngineBody],
        period: float,
        device_mass: ArrayLike,
        stiffness: float,
        damping: float = 0.0,
        friction: float = 0.0,
        friction_stiffness: float | None = None,
        friction_damping: float | None = None,
        end_velocity: bool = True,
        encoder_quantum: float = 0.0,
        delay: float = 0.0,
        lag: float = 0.0,
        gain: float = 1.0,
        force_limit: float = 20.0,
        soft_start: float = 0.2,
    ) -> EngineContact:
        bristle = stiffness if friction_stiffness is None else friction_stiffness
        question_period(period)
        made = super().__new__(
            cls,
            {
                "tools": [(name, radius(given)) for name, given in tools.items()],
                "bodies": [
                    (
                        name,
                        [
                            (kind, list(lengths), list(place), list(turn), list(points))
                            for kind, lengths, place, turn, points in shapes
                        ],
                    )
                    for name, shapes in bodies
                ],
                "stiffness": stiffness,
                "damping": damping,
                "friction": friction,
                "friction_stiffness": bristle,
                "friction_damping": bristle_damping(stiffness, damping, bristle, friction_damping),
                "end_velocity": end_velocity,
                "period": period,
                "device_mass": _masses(device_mass, len(tools)),
                "encoder_quantum": encoder_quantum,
                "delay": delay,
                "lag": lag,
                "gain": gain,
                "force_limit": force_limit,
                "soft_start": soft_start,
            },
        )
        made._tools = list(tools)
        made._bodies = [name for name, _ in bodies]
        return made

    def sample(self, position: ArrayLike, elapsed: float | None = None) -> None:
        """A period begins: takes a sample of all devices.

        Args:
            position: Position of the device [m], three numbers; of several devices a row for each.
            elapsed: Measured time since the last sample [s]; `None`: one period.

        Raises:
            ValueError: Not three numbers for each device.
        """
        given = numbers("position", position)
        count = len(self._tools)
        if given.shape != (count, 3) and not (count == 1 and given.shape == (3,)):
            needed = "(3,): x, y, z" if count == 1 else f"({count}, 3): a row for each of {', '.join(self._tools)}"
            raise ValueError(f"position has the shape {given.shape}, but must have {needed}")
        self.take(given.reshape(count, 3), elapsed)

    def meet(self, h: float, bodies: ArrayLike) -> NDArray[np.float64]:
        """A step of the engine.

        Args:
            h: Length of the step [s]. The steps of a period add up to the time until the next sample.
            bodies: A row for each body, as `body_row` makes it, as the body is at the beginning of the step. A row with
                NaN says that nothing is known of the state: `hold` then answers 0 and names a fault.

        Returns:
            A row for each body: the force and the torque about its mass centre to hold on it over the step [N], [N m].

        Raises:
            ValueError: No sample of this period, a step that is not finite and above 0, or not a row for each body.
        """
        return super().meet(h, numbers("bodies", bodies))

    def hold(self) -> NDArray[np.float64]:
        """The period ends: the force on the device [N], three numbers, to hold until the next; of several devices
        a row for each. After a sample or a state that cannot be used it is 0, and `output.fault` says why."""
        forces = self.answer()
        return forces[0] if len(self._tools) == 1 else forces

    def report_sent(self, force: ArrayLike, tool: str | None = None) -> None:
        """Says what was really sent for the last sample, where that is not what `hold` answered.

        Args:
            force: Force on the device [N], three numbers.
            tool: Name of the tool; not needed where there is one.

        Raises:
            ValueError: No such tool, not three numbers, or one that is not finite.
        """
        name = self._tools[0] if tool is None and len(self._tools) == 1 else tool
        if name not in self._tools:
            raise ValueError(f"tool is {tool!r}, but must be one of {', '.join(self._tools)}")
        given = known("force", numbers("force", force))
        if given.shape != (3,):
            raise ValueError(f"force has the shape {given.shape}, but must have (3,)")
        self.tell_sent(self._tools.index(name), given.tolist())

    def reset(self) -> None:
        """Begins anew: nothing sampled, nothing touched, the books empty. For after the engine was reset."""
        self.forget()

    @property
    def output(self) -> EngineOutput | None:
        """What was answered to the last sample; `None` before the first."""
        result = self.result()
        if result is None:
            return None
        forces, limited, effort, fault = result
        return EngineOutput(forces, tuple(limited), Effort(*effort), fault)

    @property
    def devices(self) -> dict[str, ToolState]:
        """What is known of each tool's device at the last sample, by the tool's name."""
        states = {}
        for name, (vectors, mass) in zip(self._tools, self.tools_now()):
            known = None if mass is None else np.array(mass)
            states[name] = ToolState._make([*map(np.array, vectors), known, None])
        return states

    @property
    def contacts(self) -> tuple[PointOfContact, ...]:
        """Each point at which a tool may touch a body, whether it does or not: a tool with each shape."""
        return tuple(
            PointOfContact(
                (self._tools[tool], self._bodies[body]), mode, np.array(point), np.array(normal), depth, np.array(force)
            )
            for tool, body, mode, point, normal, depth, force in self.contacts_now()
        )

    @property
    def ledger(self) -> tuple[tuple[ContactLedger, ...], dict[str, PortLedger]]:
        """The books of energy: of each point of contact, in the order of `contacts`, and of each device."""
        contacts, devices = self.ledger_now()
        between = (contact.between for contact in self.contacts)
        return (
            tuple(ContactLedger(sides, *entries) for sides, entries in zip(between, contacts)),
            {name: PortLedger(*entries) for name, entries in zip(self._tools, devices)},
        )

    def __reduce__(self) -> NoReturn:
        raise TypeError("contacts with an engine have a state, and are not pickled")


def bristle_damping(stiffness: float, damping: float, friction_stiffness: float, given: float | None) -> float:
    """Damping of the bristle of friction [N s/m]: the given one, or that of a material that damps both directions alike."""
    if given is not None:
        return given
    try:
        return damping * friction_stiffness / stiffness if stiffness > 0.0 else 0.0
    except TypeError:
        return 0.0  # the check of each argument rejects a non-number by name


LARGEST_RADIUS = 1.0
"""Radius of a tool that is taken for a mistake above this [m]."""


def radius(given: Any, way: str = "") -> float:
    """The radius of a tool [m]. A whole number is refused, since it is the number of a geom or a body.

    Raises:
        ValueError: The value is not a radius; `way` names the alternative.
    """
    if isinstance(given, np.ndarray) and given.ndim == 0:
        given = given.item()
    allowed = f"must be a radius in metres from 0 to {LARGEST_RADIUS:g}, such as 0.01{way}"
    if isinstance(given, (bool, np.bool_)) or not isinstance(given, (int, float, np.integer, np.floating)):
        raise ValueError(f"tool is {given!r}, but {allowed}")
    if isinstance(given, (int, np.integer)) and given != 0:
        raise ValueError(f"tool is {given!r}, a whole number as a geom or a body has, but {allowed}")
    if not 0 <= given <= LARGEST_RADIUS:
        raise ValueError(f"tool is {given!r}, but {allowed}")
    return float(given)


def _masses(given: ArrayLike, count: int) -> list[list[float]]:
    masses = numbers("device_mass", given)
    if masses.shape not in [(), (3,), (count, 3)]:
        raise ValueError(
            f"device_mass has the shape {masses.shape}, but must be one number, or have (3,), or ({count}, 3): a row for "
            "each device"
        )
    rows: list[list[float]] = np.broadcast_to(masses, (count, 3)).tolist()
    return rows


def body_row(
    position: Any,
    orientation: Any,
    velocity: Any,
    angular_velocity: Any,
    acceleration: Any,
    angular_acceleration: Any,
    mobility: Any,
) -> NDArray[np.float64]:
    """The row of a body for `EngineContact.meet`, along the axes of the world.

    Args:
        position: Of the reference point [m], about which the engine takes torques.
        orientation: Unit quaternion [w, x, y, z].
        velocity: Of the reference point [m/s].
        angular_velocity: [rad/s].
        acceleration: Of the reference point by everything but the contacts [m/s^2].
        angular_acceleration: By everything but the contacts [rad/s^2].
        mobility: What a wrench does to these accelerations: 6 rows of 6, columns force [N] and torque [N m].

    Raises:
        ValueError: An argument with another number of numbers.
    """
    parts = [position, orientation, velocity, angular_velocity, acceleration, angular_acceleration, mobility]
    made = [np.ravel(part) for part in parts]
    for (name, count), part in zip(_BODY_PARTS, made):
        if part.size != count:
            raise ValueError(f"{name} has {part.size} numbers, but must have {count}")
    return np.concatenate(made)


_BODY_PARTS = (
    ("position", 3),
    ("orientation", 4),
    ("velocity", 3),
    ("angular_velocity", 3),
    ("acceleration", 3),
    ("angular_acceleration", 3),
    ("mobility", 36),
)
