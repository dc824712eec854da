"""Simulated device for examples, tests and mouse input."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._arrays import known, numbers
from .._fixed import Fixed, question_period


class SimulatedDevice(Fixed):
    """Point mass along each axis, held by a hand: m x'' = hand_force + F - stiffness (x - rest) - damping x'.

    F is held from sample to sample; the motion between samples is exact.

    Args:
        mass: Masses along x, y and z, or one for all [kg].
        position: Initial position, at rest [m].
        stiffness: Stiffness of the hand's spring [N/m].
        damping: Damping of the hand [N s/m].
        rest: Rest position of the spring [m]. Assign `device.rest` to move the hand.
        hand_force: Constant force of the hand [N].
        period: Time from sample to sample [s].

    Raises:
        ValueError: An argument is not finite, has the wrong shape or is negative; the message names it.
    """

    _settable: ClassVar[frozenset[str]] = frozenset({"position", "velocity", "rest", "hand_force"})
    _way: ClassVar[str] = "make another one; position, velocity, rest and hand_force may be set"

    position: NDArray[np.float64]
    """Position [m]."""
    velocity: NDArray[np.float64]
    """Velocity [m/s]."""
    rest: NDArray[np.float64]
    """Rest position of the hand's spring [m]."""
    hand_force: NDArray[np.float64]
    """Constant force of the hand [N]."""

    def __init__(
        self,
        mass: ArrayLike,
        position: ArrayLike,
        stiffness: float,
        damping: float,
        rest: ArrayLike,
        hand_force: ArrayLike,
        period: float,
    ) -> None:
        masses = known("mass", numbers("mass", mass))
        if masses.shape not in [(), (3,)] or (masses <= 0).any():
            raise ValueError(f"mass is {mass!r}, but must be one number above 0, or three: along x, y and z")
        for name, value, is_allowed in [
            ("stiffness", stiffness, stiffness >= 0),
            ("damping", damping, damping >= 0),
            ("period", period, period > 0),
        ]:
            if not (is_allowed and math.isfinite(value)):
                raise ValueError(f"{name} is {value!r}, but must be finite and {'above 0' if name == 'period' else 'at least 0'}")
        question_period(period)
        self.position = position  # type: ignore[assignment]
        self.velocity = np.zeros(3)
        self.rest = rest  # type: ignore[assignment]
        self.hand_force = hand_force  # type: ignore[assignment]
        self._over = np.array(
            [
                _exponential([[0, 1, 0], [-stiffness / m, -damping / m, 1 / m], [0, 0, 0]], period)
                for m in np.broadcast_to(masses, 3)
            ]
        )

    def __setattr__(self, name: str, value: Any) -> None:
        super().__setattr__(name, _three(name, value).copy() if name in self._settable else value)

    def hold(self, force: ArrayLike) -> None:
        """Advances the device by a period under a held force [N].

        Raises:
            ValueError: The force is not three finite numbers.
        """
        given = self.hand_force + _three("force", force)
        state = np.stack([self.position - known("rest", self.rest), self.velocity, given], axis=1)
        after = np.einsum("aij,aj->ai", self._over, state)
        self.position = after[:, 0] + self.rest
        self.velocity = after[:, 1]


def _three(name: str, given: ArrayLike) -> NDArray[np.float64]:
    vector = known(name, numbers(name, given))
    if vector.shape != (3,):
        raise ValueError(f"{name} has the shape {vector.shape}, but must have (3,): x, y, z")
    return vector


def _exponential(rates: ArrayLike, h: float) -> NDArray[np.float64]:
    """Computes exp(rates h) by its series for a fraction of h and repeated squaring."""
    halvings = 8
    part = np.asarray(rates, dtype=np.float64) * (h / 2**halvings)
    sum_, term = np.eye(3), np.eye(3)
    for k in range(1, 13):
        term = term @ part / k
        sum_ = sum_ + term
    for _ in range(halvings):
        sum_ = sum_ @ sum_
    return sum_
