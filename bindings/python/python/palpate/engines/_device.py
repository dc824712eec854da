"""A device that is simulated: for examples, tests, and where a mouse takes its place."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._arrays import numbers


class SimulatedDevice:
    """A mass along each axis in a hand: m x'' = hand_force + F - stiffness (x - rest) - damping x'.

    F is held from sample to sample; the motion between them is exact.

    Args:
        mass: Along x, y and z [kg].
        position: At the start, where the device is at rest [m].
        stiffness: Of the hand's spring [N/m].
        damping: Of the hand [N s/m].
        rest: Where the spring pulls to [m]. It may be changed, as `device.rest`: that is where a hand goes.
        hand_force: Constant force of the hand [N].
        period: Time from sample to sample [s].
    """

    position: NDArray[np.float64]
    """Where it is [m]."""
    velocity: NDArray[np.float64]
    """Its velocity [m/s]."""
    rest: NDArray[np.float64]
    """Where the hand's spring pulls to [m]."""
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
        self.position = numbers("position", position).copy()
        self.velocity = np.zeros(3)
        self.rest = numbers("rest", rest).copy()
        self.hand_force = numbers("hand_force", hand_force).copy()
        self._over = np.array(
            [_exponential([[0, 1, 0], [-stiffness / m, -damping / m, 1 / m], [0, 0, 0]], period) for m in numbers("mass", mass)]
        )

    def hold(self, force: ArrayLike) -> None:
        """Moves on by a period under a held force [N]."""
        state = np.stack([self.position - self.rest, self.velocity, self.hand_force + numbers("force", force)], axis=1)
        after = np.einsum("aij,aj->ai", self._over, state)
        self.position = after[:, 0] + self.rest
        self.velocity = after[:, 1]


def _exponential(rates: ArrayLike, h: float) -> NDArray[np.float64]:
    """exp(rates h), by its series over a small part of h, squared."""
    halvings = 8
    part = np.asarray(rates, dtype=np.float64) * (h / 2**halvings)
    sum_, term = np.eye(3), np.eye(3)
    for k in range(1, 13):
        term = term @ part / k
        sum_ = sum_ + term
    for _ in range(halvings):
        sum_ = sum_ @ sum_
    return sum_
