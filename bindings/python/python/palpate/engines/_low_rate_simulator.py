"""`LowRateSimulator`: an engine at a lower rate than the loop, and the local model that it publishes."""

from __future__ import annotations

from typing import Any, NamedTuple, NoReturn, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _palpate
from .._fixed import Fixed
from .._arrays import known, numbers, row
from .._world_values import Vector
from ._contact import BODY_COLUMNS, bristle_damping


class SlowContact(NamedTuple):
    """Potential contact of a sphere (the tool, or a part of a body) with a surface, for the published body states.

    The surface is an unbounded plane or, with a curvature, a sphere. It is fixed to its body.
    """

    place: Sequence[float]
    """Point on the surface, usually the one nearest to the sphere [m]."""
    normal: Sequence[float]
    """Outward unit normal of the surface at this point."""
    stiffness: float
    """K of the contact [N/m]."""
    on: int | None = None
    """Number of the body with the surface; `None`: a fixed surface."""
    curvature: float = 0.0
    """Curvature of the surface [1/m]: 1/r of a ball of radius r, -1/r of the inside of one, 0 of a plane."""
    damping: float = 0.0
    """Material damping B [N s/m]."""
    friction: float = 0.0
    """Coefficient of friction."""
    friction_stiffness: float | None = None
    """Stiffness of the bristle of friction [N/m]; `None`: that of the contact."""
    friction_damping: float | None = None
    """Damping of the bristle of friction [N s/m]; `None`: `damping` times `friction_stiffness` over `stiffness`."""
    body: int | None = None
    """Number of the body with the sphere; `None`: the tool. The host computes a contact between bodies; the loop
    computes it between two models."""
    centre: Sequence[float] = (0.0, 0.0, 0.0)
    """Centre of a body's sphere [m]."""
    radius: float = 0.0
    """Radius of a body's sphere [m]; 0 for a corner."""

    def _values(self, number: int) -> tuple[Any, ...]:
        for name, body in (("on", self.on), ("body", self.body)):
            if body is not None and (not isinstance(body, (int, np.integer)) or body < 0):
                raise ValueError(f"contact {number}: {name} is {body!r}, but must be the number of a body, from 0, or None")
        bristle = self.stiffness if self.friction_stiffness is None else self.friction_stiffness
        of = f"contact {number}: "
        laws: list[tuple[str, float]] = [
            ("stiffness", self.stiffness),
            ("damping", self.damping),
            ("friction", self.friction),
            ("friction_stiffness", bristle),
            ("friction_damping", bristle_damping(self.stiffness, self.damping, bristle, self.friction_damping)),
        ]
        law = [_one(of + name, value) for name, value in laws]
        surface = (_three(of + "place", self.place), _three(of + "normal", self.normal), _one(of + "curvature", self.curvature))
        return (self.body, self.on), surface, (_three(of + "centre", self.centre), _one(of + "radius", self.radius)), law


class BodyImpulse(NamedTuple):
    """Impulse of the tool on a body since the start."""

    linear: Vector
    """Linear impulse [N s]."""
    angular: Vector
    """Angular impulse about the body's reference point [N m s]."""


class SlowProgress(NamedTuple):
    """Progress of a loop: the input of the host's next step."""

    tick: int
    """Number of elapsed periods, rendered and missed."""
    period: float
    """Time from sample to sample [s]."""
    position: Vector
    """Position of the tool's proxy [m]; the host searches for contacts around it."""
    velocity: Vector
    """Velocity of the tool's proxy [m/s]."""
    impulses: tuple[BodyImpulse, ...]
    """Impulse of the tool on each body since the start."""
    copies: tuple[Vector, ...]
    """Position of the loop's copy of each body [m]."""
    model_tick: int | None
    """Tick of the newest model; `None` before the first."""
    is_stale: bool
    """Whether the contacts fade, or have faded, because the model is missing or too old."""
    refusal: str | None
    """Reason for rejecting the last published model; `None` if it was accepted."""

    def time_since(self, earlier: SlowProgress) -> float:
        """Returns the time from an earlier progress to this one [s], which is the host's next step."""
        return max(self.tick - earlier.tick, 0) * self.period

    def wrench_since(self, earlier: SlowProgress, body: int) -> NDArray[np.float64]:
        """Returns the mean force [N] and the mean torque about the reference point [N m] of the tool on a body from an
        earlier progress to this one, six numbers, for the host to hold over its step. 0 if no time has passed."""
        time = self.time_since(earlier)
        now, before = self.impulses[body], earlier.impulses[body]
        if time <= 0.0:
            return np.zeros(6)
        return np.concatenate([now.linear - before.linear, now.angular - before.angular]) / time


class LowRateSimulator(Fixed, _palpate.LowRateSimulator):
    """Game or engine at 20 to 200 Hz whose bodies a `palpate.Loop` renders at 1 kHz.

        host = palpate.engines.LowRateSimulator(period=0.001, device_mass=0.15, tool_radius=0.01, bodies=1, contacts=2)
        with palpate.Loop(device, host):
            before = host.progress
            while True:  # at the host's own rate
                progress = host.progress
                ...      # step over progress.time_since(before) under progress.wrench_since(before, 0), held
                host.publish(progress, [palpate.engines.body_row(...)], [palpate.engines.SlowContact(...)])
                before = progress

    Between two models the loop simulates copies of the bodies and their contact with the tool. Neither side waits for
    the other. `docs/engines.md` describes the handling of a new model, its accuracy and its limits.

    Args:
        period: Time from sample to sample of the loop [s].
        device_mass: Effective mass of the device [kg], accurate within a factor of 2: one number, or one per axis.
        tool_radius: Radius of the tool [m]: a sphere, or a point of radius 0.
        bodies: Number of bodies of each model, at most 16. Bodies are numbered from 0.
        contacts: Largest number of contacts of a model, 1 to 64.
        position: Initial position of a real device in the host's world [m]. Pointers and simulated devices start at the
            position in their `World`.
        stale_after: Age of a model at which the contacts begin to fade [s]: 1 to 1000 periods.
        fade: Duration of the fading [s].
        settle: Time over which a changed contact is blended in [s].
        return_time: Time constant with which a copy returns to the host's body [s].
        encoder_quantum: Quantum of the position sensors [m]; 0: unknown or none.
        delay: Time from a sample to the beginning of its force [s].
        lag: Time constant of the actuators [s].
        gain: Ratio of delivered to commanded force.
        force_limit: Largest magnitude of the force [N]; `math.inf`: that of the device.
        soft_start: Duration of the force ramp if a start or a recovery begins in contact [s], at most 60.

    Raises:
        ValueError: Arguments are not allowed; the message has a line for each.
    """

    def __new__(
        cls,
        *,
        period: float,
        device_mass: ArrayLike,
        tool_radius: float,
        bodies: int,
        contacts: int,
        position: ArrayLike = (0.0, 0.0, 0.0),
        stale_after: float = 0.2,
        fade: float = 0.1,
        settle: float = 0.01,
        return_time: float = 1.0,
        encoder_quantum: float = 0.0,
        delay: float = 0.0,
        lag: float = 0.0,
        gain: float = 1.0,
        force_limit: float = 20.0,
        soft_start: float = 0.2,
    ) -> LowRateSimulator:
        given = {name: value for name, value in locals().items() if name not in ("cls", "__class__")}
        masses = numbers("device_mass", device_mass)
        if masses.shape not in [(), (3,)]:
            raise ValueError(f"device_mass has the shape {masses.shape}, but must be one number, or have (3,)")
        given["device_mass"] = np.broadcast_to(masses, (3,)).tolist()
        given["position"] = _three("position", known("position", numbers("position", position)))
        for name, count in (("bodies", bodies), ("contacts", contacts)):
            if not isinstance(count, (int, np.integer)):
                raise TypeError(f"{name} is {count!r}, but must be a whole number")
            if count < 0:
                raise ValueError(f"{name} is {count}, but must not be below 0")
        return super().__new__(cls, given)

    @property
    def progress(self) -> SlowProgress:
        """Progress of the loop at its last tick.

        Raises:
            RuntimeError: The simulator is not in a loop.
        """
        (tick, period, is_stale, model_tick, refusal), (position, velocity), bodies = self.progress_now()
        return SlowProgress(
            tick,
            period,
            np.array(position),
            np.array(velocity),
            tuple(BodyImpulse(np.array(linear), np.array(angular)) for linear, angular, _ in bodies),
            tuple(np.array(copy) for _, _, copy in bodies),
            model_tick,
            is_stale,
            refusal,
        )

    def publish(
        self,
        progress: SlowProgress,
        bodies: Sequence[ArrayLike],
        contacts: Sequence[SlowContact | None],
    ) -> None:
        """Publishes bodies and contacts that include all impulses of a progress, for use from the next tick on.

        If the loop rejects the model, for example because it is too old, the next `progress` has the reason.

        Args:
            progress: The progress up to whose tick the host has stepped.
            bodies: A `palpate.engines.body_row` for each body.
            contacts: Potential contacts of the tool, and contacts between bodies. A contact is identified by its index;
                changes from model to model are blended. `None`: no contact.

        Raises:
            ValueError: Bodies or contacts are not valid; the message has their numbers, and the previous model stays.
            RuntimeError: The simulator is not in a loop, or its loop has ended.
        """
        for number, contact in enumerate(contacts):
            if contact is not None and not isinstance(contact, SlowContact):
                raise TypeError(f"contacts[{number}] is {contact!r}, but must be a SlowContact or None, in a list")
        rows = [np.ravel(numbers("bodies", body)) for body in bodies]
        for number, given_row in enumerate(rows):
            if given_row.size != BODY_COLUMNS:
                raise ValueError(
                    f"bodies[{number}] has {given_row.size} numbers, but must have {BODY_COLUMNS}: palpate.engines.body_row"
                )
        given = np.array(rows, float) if rows else np.empty((0, BODY_COLUMNS))
        given_contacts = [None if contact is None else contact._values(number) for number, contact in enumerate(contacts)]
        self.publish_model(progress.tick, np.require(given, float, ["C", "A"]), given_contacts)

    def __reduce__(self) -> NoReturn:
        raise TypeError("a LowRateSimulator belongs to a Loop and cannot be pickled")


def _one(name: str, given: float) -> float:
    try:
        return float(given)
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {given!r}, but must be a number") from None


def _three(name: str, given: ArrayLike) -> list[float]:
    numbers_given = row(name, given)
    if len(numbers_given) != 3:
        raise ValueError(f"{name} has {len(numbers_given)} numbers, but must have three: x, y, z")
    return list(numbers_given)
