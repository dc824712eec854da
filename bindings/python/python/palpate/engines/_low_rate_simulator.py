"""`LowRateSimulator`: an engine that steps more slowly than the loop, and what it publishes to that loop."""

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
    """A place where a sphere, the tool or a part of a body, may touch a surface, with the bodies as they are published.

    The surface is a plane or, with a curvature, a sphere. It is fixed to its body, and has no end.
    """

    place: Sequence[float]
    """A point of the surface, as a rule the one that is nearest to the sphere [m]."""
    normal: Sequence[float]
    """Unit vector out of the surface there."""
    stiffness: float
    """K of the contact [N/m]."""
    on: int | None = None
    """Number of the body whose surface it is; `None`: something that never moves."""
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
    """Number of the body whose sphere touches; `None`: the tool does. A contact between bodies is computed by the host, and by
    the loop between two models."""
    centre: Sequence[float] = (0.0, 0.0, 0.0)
    """Of a body's sphere: its centre [m]."""
    radius: float = 0.0
    """Of a body's sphere: its radius [m]; 0 for a corner."""

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
    """What the tool gave to a body since the start."""

    linear: Vector
    """Impulse [N s]."""
    angular: Vector
    """Its moment about the body's reference point [N m s]."""


class SlowProgress(NamedTuple):
    """How far a loop has come: what a host needs for its next step."""

    tick: int
    """Periods that have passed: those that the loop has rendered, and those that it has missed."""
    period: float
    """Time from sample to sample [s]."""
    position: Vector
    """Where the tool's proxy is [m]: where the host looks for what the tool may touch."""
    velocity: Vector
    """Its velocity [m/s]."""
    impulses: tuple[BodyImpulse, ...]
    """What the tool gave to each body since the start."""
    copies: tuple[Vector, ...]
    """Where the loop's copy of each body is [m]."""
    model_tick: int | None
    """Tick of the newest model; `None` before the first."""
    is_stale: bool
    """Whether the contacts fade, or have faded, because there is no model or it is too old."""
    refusal: str | None
    """Why the last model that came was not taken; `None` where it was."""

    def time_since(self, earlier: SlowProgress) -> float:
        """Time from an earlier progress to this one [s]: what the host steps over."""
        return max(self.tick - earlier.tick, 0) * self.period

    def wrench_since(self, earlier: SlowProgress, body: int) -> NDArray[np.float64]:
        """The mean force [N] and torque about the reference point [N m] of the tool on a body from an earlier progress to this
        one, six numbers: what the host holds over its step. 0 where no time has passed."""
        time = self.time_since(earlier)
        now, before = self.impulses[body], earlier.impulses[body]
        if time <= 0.0:
            return np.zeros(6)
        return np.concatenate([now.linear - before.linear, now.angular - before.angular]) / time


class LowRateSimulator(Fixed, _palpate.LowRateSimulator):
    """A game or an engine at 20 to 200 Hz, whose bodies a `palpate.Loop` at 1 kHz renders.

        host = palpate.engines.LowRateSimulator(period=0.001, device_mass=0.15, tool_radius=0.01, bodies=1, contacts=2)
        with palpate.Loop(device, host):
            before = host.progress
            while True:  # at the host's own rate
                progress = host.progress
                ...      # step over progress.time_since(before) under progress.wrench_since(before, 0), held
                host.publish(progress, [palpate.engines.body_row(...)], [palpate.engines.SlowContact(...)])
                before = progress

    Between two models the loop goes on by itself: copies of the bodies move, and meet the tool. Neither side waits for the other.
    `docs/engines.md` has what is done with each new model, how good it is, and where it fails.

    Args:
        period: Time from sample to sample of the loop [s].
        device_mass: Effective mass of the device, right within a factor of 2 [kg]: one number, or three for the axes.
        tool_radius: Radius of the tool [m]: a sphere, or a point of radius 0.
        bodies: How many bodies each model has, at most 16. They are called by their numbers, from 0.
        contacts: How many contacts a model has at most, 1 to 64.
        position: Where in the host's world a real device begins [m]; a pointer and a simulated one begin where their `World` says.
        stale_after: Age of a model from which the contacts fade [s]: 1 to 1000 periods.
        fade: Time in which they do [s].
        settle: Time in which a changed contact comes in [s].
        return_time: Time constant with which a copy goes back to the host's body [s].
        encoder_quantum: Quantum of the position sensors [m]; 0: not known to have one.
        delay: Time from a sample to the beginning of its force [s].
        lag: Time constant of the actuators [s].
        gain: Delivered over commanded force.
        force_limit: Largest length of the force [N]; `math.inf`: that of the device.
        soft_start: Time over which a force comes in where a start or a recovery finds contact, at most 60 [s].

    Raises:
        ValueError: Everything that is wrong, a line for each.
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
        """How far the loop has come, as of its last tick.

        Raises:
            RuntimeError: No loop was made with this host.
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
        """Publishes bodies and contacts that have all impulses of a progress in them. The loop renders by them from its next tick on.

        What the loop refuses of it, such as a model that is too old, the next `progress` says.

        Args:
            progress: The progress up to whose tick the host has stepped.
            bodies: A `palpate.engines.body_row` for each body.
            contacts: Where the tool may touch something, and where bodies touch each other. A place in the list that stays the same from
                model to model is the same contact, which goes over to what is new of it; `None`: nothing there.

        Raises:
            ValueError: Everything that is wrong with them, by their numbers; the model before stays then.
            RuntimeError: No loop was made with this host, or its loop has ended.
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
        raise TypeError("a LowRateSimulator belongs to a Loop and is not pickled")


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
