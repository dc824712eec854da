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
"""Length of the state row of a body at the beginning of a step: see `EngineContact.meet`."""


class PlacedShape(NamedTuple):
    """Shape that is fixed to a body."""

    kind: str
    """`sphere`, `box`, `capsule`, `cylinder`, `half-space` (z <= 0 in the shape's frame), or `hull` (the convex hull of
    points)."""
    lengths: tuple[float, ...]
    """Radius [m] of a sphere; half lengths along the axes [m] of a box; radius and half length along z [m] of a
    capsule and a cylinder; empty for a half-space and a hull."""
    position: Sequence[float] = (0.0, 0.0, 0.0)
    """Origin of the shape's frame relative to the reference point of the body, in the body frame [m]."""
    orientation: Sequence[float] = (1.0, 0.0, 0.0, 0.0)
    """Unit quaternion [w, x, y, z] from the shape's frame to the body frame."""
    points: Sequence[Sequence[float]] = ()
    """Points of a hull in the shape's frame [m]; at most 4096 may be corners. Points that extend the hull of the others
    by at most 1e-6 of the largest coordinate are ignored."""


class EngineBody(NamedTuple):
    """Body that tools may touch."""

    name: str
    """Name, for messages."""
    shapes: Sequence[PlacedShape]
    """Collision shapes."""


class EngineOutput(NamedTuple):
    """Result for one sample."""

    forces: NDArray[np.float64]
    """Force on each device [N], a row for each."""
    limited: tuple[str, ...]
    """Active limits: `force`, `offset` of a proxy or an image, `soft-start`, and `safety-stop`: the loop has
    generated energy, and all forces stay 0 until `reset()`."""
    effort: Effort
    """Cost of the period, over all steps of the engine."""
    fault: str | None
    """Reason for rejecting the sample, one of `palpate.FAULTS`, and all forces are 0; `None` for a valid sample."""


class PointOfContact(NamedTuple):
    """State of a potential contact point of a tool and a body at the end of the last period."""

    between: tuple[str, str]
    """Names of the tool and the body."""
    mode: str
    """`free`, `sticks`, `slides`, or `parts`: tool and body overlap but do not push."""
    point: Vector
    """Point of action of the force [m]."""
    normal: Vector
    """Unit vector from the body to the tool."""
    penetration: float
    """Depth of the overlap [m], 0 without overlap."""
    force: Vector
    """Force on the tool [N]."""


class PortLedger(NamedTuple):
    """Energy at the port of a device over all completed periods [J]; positive to the hand."""

    port_work: float
    """Work of the held force over the measured motion of the device."""
    held: float
    """Work of the mean force of its contacts on the device."""


class EngineContact(Fixed, _palpate.EngineContact):
    """Contacts of tools with bodies of another engine: the base class of engine adapters.

    One period:

        contact.sample(position)
        for _ in range(steps):
            wrenches = contact.meet(h, rows)  # a row for each body, with its current state
            ...                               # the engine holds each wrench on its body over a step of h
        force = contact.hold()

    Args:
        tools: Radius of each tool [m], at most 1, by name: a sphere, or a point of radius 0.
        bodies: Bodies that the tools may touch.
        period: Time from sample to sample [s].
        device_mass: Effective mass of each device, accurate within a factor of 2 [kg]: one number for all, or three
            for the axes, or a row of three for each device.
        stiffness: K of every contact [N/m].
        damping: Material damping B [N s/m].
        friction: Coefficient of friction.
        friction_stiffness: Stiffness of the bristle of friction [N/m]; `None`: that of the contact.
        friction_damping: Damping of the bristle of friction [N s/m]; `None`: `damping` times `friction_stiffness` over
            `stiffness`.
        end_velocity: Whether the engine integrates positions with the velocity at the end of a step, as semi-implicit
            Euler does, instead of the mean of start and end.
        encoder_quantum: Quantum of the position sensors [m]; 0: unknown or none.
        delay: Time from a sample to the beginning of its force [s].
        lag: Time constant of the actuators [s].
        gain: Ratio of delivered to commanded force.
        force_limit: Largest magnitude of the force on each device [N]; `math.inf`: no limit.
        soft_start: Duration of the force ramp if a start or a recovery begins in contact [s], at most 60.

    Raises:
        ValueError: Arguments are not allowed; the message has a line for each.
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
        """Begins a period: takes a sample of all devices.

        Args:
            position: Position of the device [m], three numbers; for several devices a row for each.
            elapsed: Measured time since the last sample [s]; `None`: one period.

        Raises:
            ValueError: The position is not three numbers for each device.
        """
        given = numbers("position", position)
        count = len(self._tools)
        if given.shape != (count, 3) and not (count == 1 and given.shape == (3,)):
            needed = "(3,): x, y, z" if count == 1 else f"({count}, 3): a row for each of {', '.join(self._tools)}"
            raise ValueError(f"position has the shape {given.shape}, but must have {needed}")
        self.take(given.reshape(count, 3), elapsed)

    def meet(self, h: float, bodies: ArrayLike) -> NDArray[np.float64]:
        """Computes the contact wrenches for one step of the engine.

        Args:
            h: Length of the step [s]. The steps of a period add up to the time until the next sample.
            bodies: A `body_row` for each body, with its state at the beginning of the step. NaN in a row marks an
                unknown state: `hold` then returns 0 and sets a fault.

        Returns:
            A row for each body: the force [N] and the torque about its centre of mass [N m] to hold over the step.

        Raises:
            ValueError: The period has no sample, the step is not finite and above 0, or `bodies` has the wrong shape.
        """
        return super().meet(h, numbers("bodies", bodies))

    def hold(self) -> NDArray[np.float64]:
        """Ends the period and returns the force on the device to hold until the next [N], three numbers; for several
        devices a row for each. After an invalid sample or state it is 0, and `output.fault` has the reason."""
        forces = self.answer()
        return forces[0] if len(self._tools) == 1 else forces

    def report_sent(self, force: ArrayLike, tool: str | None = None) -> None:
        """Reports the force that was actually sent for the last sample, if it differs from the result of `hold`.

        Args:
            force: Force on the device [N], three numbers.
            tool: Name of the tool; optional for a single tool.

        Raises:
            ValueError: The tool does not exist, or the force is not three finite numbers.
        """
        name = self._tools[0] if tool is None and len(self._tools) == 1 else tool
        if name not in self._tools:
            raise ValueError(f"tool is {tool!r}, but must be one of {', '.join(self._tools)}")
        given = known("force", numbers("force", force))
        if given.shape != (3,):
            raise ValueError(f"force has the shape {given.shape}, but must have (3,)")
        self.tell_sent(self._tools.index(name), given.tolist())

    def reset(self) -> None:
        """Resets samples, contacts and energy ledger. Call it after a reset of the engine."""
        self.forget()

    @property
    def output(self) -> EngineOutput | None:
        """Result of the last sample; `None` before the first."""
        result = self.result()
        if result is None:
            return None
        forces, limited, effort, fault = result
        return EngineOutput(forces, tuple(limited), Effort(*effort), fault)

    @property
    def devices(self) -> dict[str, ToolState]:
        """Estimated state of the device of each tool at the last sample, by the name of the tool."""
        states = {}
        for name, (vectors, mass) in zip(self._tools, self.tools_now()):
            known = None if mass is None else np.array(mass)
            states[name] = ToolState._make([*map(np.array, vectors), known, None])
        return states

    @property
    def contacts(self) -> tuple[PointOfContact, ...]:
        """State of each potential contact point: each tool with each shape."""
        return tuple(
            PointOfContact(
                (self._tools[tool], self._bodies[body]), mode, np.array(point), np.array(normal), depth, np.array(force)
            )
            for tool, body, mode, point, normal, depth, force in self.contacts_now()
        )

    @property
    def ledger(self) -> tuple[tuple[ContactLedger, ...], dict[str, PortLedger]]:
        """Energy ledger: of each contact point, in the order of `contacts`, and of each device."""
        contacts, devices = self.ledger_now()
        between = (contact.between for contact in self.contacts)
        return (
            tuple(ContactLedger(sides, *entries) for sides, entries in zip(between, contacts)),
            {name: PortLedger(*entries) for name, entries in zip(self._tools, devices)},
        )

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {', '.join(self._tools)} with {', '.join(self._bodies)}>"

    def __reduce__(self) -> NoReturn:
        raise TypeError("contacts with an engine have a state and cannot be pickled")


def bristle_damping(stiffness: float, damping: float, friction_stiffness: float, given: float | None) -> float:
    """Returns the damping of the bristle of friction [N s/m]. Default: that of a material with isotropic damping."""
    if given is not None:
        return given
    try:
        return damping * friction_stiffness / stiffness if stiffness > 0.0 else 0.0
    except TypeError:
        return 0.0  # the check of each argument rejects a non-number by name


LARGEST_RADIUS = 1.0
"""Largest plausible radius of a tool [m]."""


def radius(given: Any, way: str = "") -> float:
    """Checks the radius of a tool [m]. A whole number is rejected: it is probably the number of a geom or a body.

    Raises:
        ValueError: The value is not a radius; `way` names the alternative.
    """
    if isinstance(given, np.ndarray) and given.ndim == 0:
        given = given.item()
    allowed = f"must be a radius in metres from 0 to {LARGEST_RADIUS:g}, such as 0.01{way}"
    if isinstance(given, (bool, np.bool_)) or not isinstance(given, (int, float, np.integer, np.floating)):
        raise ValueError(f"tool is {given!r}, but {allowed}")
    if isinstance(given, (int, np.integer)) and given != 0:
        raise ValueError(f"tool is {given!r}, a whole number like that of a geom or a body, but {allowed}")
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
    """Creates the state row of a body for `EngineContact.meet`, in the world frame.

    Args:
        position: Position of the reference point [m], to which the engine refers torques.
        orientation: Unit quaternion [w, x, y, z].
        velocity: Velocity of the reference point [m/s].
        angular_velocity: Angular velocity [rad/s].
        acceleration: Acceleration of the reference point without the contacts [m/s^2].
        angular_acceleration: Angular acceleration without the contacts [rad/s^2].
        mobility: Derivative of these accelerations by a wrench: 6 rows of 6, columns force [N] and torque [N m].

    Raises:
        ValueError: An argument has the wrong length.
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
