"""Scenes of `palpate.engines.table`, and the evaluation of forces."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._report import WorldRuns
from .._world import World
from ._device import SimulatedDevice

BODY_MASS = 0.1
HALF = 0.02
"""Half of the body's size [m]."""
DEVICE_MASS = (0.1, 0.16, 0.25)
HAND = (60.0, 1.5)
GRAVITY = 9.81
DURATION = 0.4
RATES = ((0.01, 400.0), (0.004, 1500.0), (0.001, 4000.0))
"""Periods [s], each with a stiffness [N/m]."""


class Law(NamedTuple):
    """Spring and damper of a contact."""

    stiffness: float
    """[N/m]"""
    damping: float
    """[N s/m]"""


class Scene(NamedTuple):
    """Scene: the world of the reference solution, and the parameters of the engine's model."""

    name: str
    world: World
    shape: str
    """Shape of the body: a `sphere` of the radius HALF, or a `box` of that half-extent."""
    place: tuple[float, float, float]
    """Initial position of the body [m]."""
    floor: Law | None
    """Contact law of body and floor, the plane z = 0, if there is a floor."""
    tool_radius: float
    start: tuple[float, float, float]
    hand_force: tuple[float, float, float]
    rest: tuple[float, float, float]
    stiffness: float
    """Stiffness of tool and body [N/m]."""
    period: float

    def device(self) -> SimulatedDevice:
        """Creates the device in its hand."""
        return SimulatedDevice(DEVICE_MASS, self.start, *HAND, self.rest, self.hand_force, self.period)


def scenes(period: float, stiffness: float) -> list[Scene]:
    """Returns the scenes for a period [s] and a stiffness of the tool's contact [N/m]."""
    floor_stiffness = 2 * stiffness
    floor_damping = 0.3 * math.sqrt(floor_stiffness * BODY_MASS)
    resting = HALF - GRAVITY * BODY_MASS / floor_stiffness
    made = []
    for name, place, radius, start, hand, shape in [
        ("ball", (0.002, -0.001, 0.075), 0.04, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), "sphere"),
        ("ball on floor", (0.0, 0.0, resting), 0.01, (0.003, 0.001, resting + 0.032), (0.0, 0.0, -2.0), "sphere"),
        ("box on floor", (0.0, 0.0, resting), 0.01, (0.003, 0.001, resting + 0.032), (0.0, 0.0, -2.0), "box"),
    ]:
        bodies: list[dict[str, Any]] = [
            {
                "name": "body",
                "mass_kg": BODY_MASS,
                "position_m": place,
                "force_n": (0.0, 0.0, -GRAVITY * BODY_MASS),
                "shape": {"sphere": {"radius_m": HALF}} if shape == "sphere" else {"box": {"size_m": (2 * HALF,) * 3}},
            }
        ]
        contacts: list[dict[str, Any]] = [{"between": ("tool", "body"), "stiffness_n_per_m": stiffness}]
        floor = None
        if name != "ball":
            bodies.append({"name": "floor", "fixed": True, "shape": {"half_space": {"normal": (0, 0, 1), "offset_m": 0.0}}})
            contacts.append(
                {"between": ("body", "floor"), "stiffness_n_per_m": floor_stiffness, "damping_n_s_per_m": floor_damping}
            )
            floor = Law(floor_stiffness, floor_damping)
        rest = (start[0], start[1], start[2])
        world = World(
            title=name,
            loop={"period_s": period},
            devices=[
                {
                    "name": "tool",
                    "mass_kg": DEVICE_MASS,
                    "position_m": start,
                    "tool": {"sphere": {"radius_m": radius}},
                    "hand": {
                        "force_n": hand,
                        "stiffness_n_per_m": HAND[0],
                        "damping_n_s_per_m": HAND[1],
                        "rest_m": rest,
                    },
                }
            ],
            bodies=bodies,
            contacts=contacts,
            measure={"duration_s": DURATION},
        )
        made.append(Scene(name, world, shape, place, floor, radius, start, hand, rest, stiffness, period))
    return made


def evaluated(forces: NDArray[np.float64], ideal: WorldRuns) -> tuple[float, float]:
    """Returns E [%] and FRE over the hold bound of the held forces on the device, which have a row per period."""
    floor = ideal["methods"][0].sum.hold_bound_percent / 100
    weight = 1 / np.array(DEVICE_MASS)
    means = ideal.ideal[0]
    off = np.sum((forces - means) ** 2 * weight) / np.sum(means**2 * weight)
    error = math.sqrt(off * (1 - floor**2)) if np.isfinite(off) else math.inf
    return 100 * error, math.hypot(error, floor) / floor
