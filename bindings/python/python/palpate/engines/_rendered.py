"""The tool of a scene in a loop, in `palpate.engines.table`: what pushes it is an engine's own contact, or palpate's."""

from __future__ import annotations

import math
import time
from typing import Any, Callable, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._scenes import DEVICE_MASS, Scene

Vector = NDArray[np.float64]


class Stepped(Protocol):
    """palpate's contact with the bodies of an engine, with the engine's own loop."""

    def step(self, position: ArrayLike, elapsed: float | None = None) -> Vector:
        """Steps the engine through a period; the force on the device at `position` [m] to hold over it [N]."""


def by_engine(
    scene: Scene, steps: int, samples: int, moves: bool, step: Callable[[Vector], Vector]
) -> tuple[NDArray[np.float64], float]:
    """Forces of the engine's own contact on the tool [N], one for each sample, and the time of a step [s]. `step` puts the
    tool at a place [m], makes a step of the engine and gives the force on the tool in it [N]; a sample's force is their
    mean. `moves`: over a period the tool goes on as it did over the last."""
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
    """Forces of palpate's contact on the tool [N], one for each sample, and the time of a step of the engine [s]. `contact`
    makes the contact of its law; `model` is the mass of the device as palpate is told, over the true one."""
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
