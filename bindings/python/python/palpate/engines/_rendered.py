"""Closed loops of `palpate.engines.table`: a tool with the engine's own contact, or with that of palpate."""

from __future__ import annotations

import math
import time
from typing import Any, Callable, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._scenes import DEVICE_MASS, Scene

Vector = NDArray[np.float64]


class Stepped(Protocol):
    """palpate's contact with the bodies of an engine; it steps the engine."""

    def step(self, position: ArrayLike, elapsed: float | None = None) -> Vector:
        """Steps the engine through a period and returns the force on the device to hold over it [N]."""


def by_engine(
    scene: Scene, steps: int, samples: int, moves: bool, step: Callable[[Vector], Vector]
) -> tuple[NDArray[np.float64], float]:
    """Computes the forces of the engine's own contact on the tool [N], one per sample, and the time of a step [s].

    `step` moves the tool to a position [m], steps the engine and returns the force on the tool in this step [N]; the
    force of a sample is the mean over its steps. `moves`: the tool continues its last motion over the period."""
    device = scene.device()
    forces, times = np.zeros((samples, 3)), []
    last = device.position
    for sample in range(samples):
        begin = time.perf_counter()
        way = device.position - last if moves else np.zeros(3)
        last = device.position
        for part in range(steps):
            forces[sample] += step(device.position + way * (part / steps)) / steps
        times.append(time.perf_counter() - begin)
        device.hold(forces[sample])
        if not np.abs(device.position).max() < 1e3:
            forces[sample:] = math.inf
            break
    return forces, float(np.median(times)) / steps


def by_palpate(
    scene: Scene, steps: int, samples: int, model: float, contact: Callable[..., Stepped]
) -> tuple[NDArray[np.float64], float]:
    """Computes the forces of palpate's contact on the tool [N], one per sample, and the time of an engine step [s].

    `contact` creates the contact from its law; `model` is the model mass of the device over the true mass."""
    law: dict[str, Any] = {
        "stiffness": scene.stiffness,
        "device_mass": model * np.array(DEVICE_MASS),
        "period": scene.period,
        "force_limit": math.inf,
        "soft_start": 0,
    }
    made = contact(**law)
    device = scene.device()
    forces, times = np.zeros((samples, 3)), []
    for sample in range(samples):
        begin = time.perf_counter()
        forces[sample] = made.step(device.position)
        times.append(time.perf_counter() - begin)
        device.hold(forces[sample])
    return forces, float(np.median(times)) / steps
