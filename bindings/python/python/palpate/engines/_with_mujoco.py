"""MuJoCo in `palpate.engines.table`: its own contact of the tool, and that of palpate."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from ._rendered import by_engine, by_palpate
from ._scenes import BODY_MASS, GRAVITY, HALF, Scene
from .mujoco import Contact

# After palpate.engines.mujoco, whose import error explains how to install MuJoCo.
import mujoco  # noqa: E402  isort: skip

VERSION = f"MuJoCo {mujoco.__version__}"
INTEGRATORS = ("RK4", "Euler", "implicitfast")
"""Integrators; the first is the default."""


def _spring(stiffness: float, damping: str, shares: int = 1) -> str:
    """Returns MuJoCo's contact parameters of a spring and a damper between a body of BODY_MASS and a fixed body. An
    impedance near 0 removes the inertia from the contact law."""
    return f'solref="{-stiffness / BODY_MASS / shares} {damping}" solimp="1e-4 1e-4 0.001 0.5 2"'


def model(scene: Scene, steps: int, integrator: str, damping: float = 0.0) -> mujoco.MjModel:
    """Creates the engine's model. `damping` is that of the engine's own contact of the tool [N s/m]."""
    floor = ""
    if scene.floor is not None:
        # The engine has one contact at each corner of a box that lies flat.
        shares = 4 if scene.shape == "box" else 1
        law = _spring(scene.floor.stiffness, str(-scene.floor.damping / BODY_MASS / shares), shares)
        floor = f'<geom type="plane" size="1 1 1" contype="0" conaffinity="1" condim="1" priority="1" {law}/>'
    size = " ".join([str(HALF)] * (1 if scene.shape == "sphere" else 3))
    where = " ".join(map(str, scene.place))
    rate = -(damping / BODY_MASS + 1e-9)
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{scene.period / steps}" integrator="{integrator}" gravity="0 0 {-GRAVITY}"><flag '
        f'eulerdamp="disable"/></option><worldbody>{floor}<body name="body" pos="{where}"><freejoint/><geom '
        f'type="{scene.shape}" size="{size}" mass="{BODY_MASS}" condim="1" contype="1" conaffinity="2"/></body><body '
        f'mocap="true"><geom name="tool" type="sphere" size="{scene.tool_radius}" contype="2" conaffinity="0" condim="1" '
        f'priority="2" {_spring(scene.stiffness, str(rate))}/></body></worldbody></mujoco>'
    )


def with_engine(
    scene: Scene, steps: int, integrator: str, damping: float, samples: int, moves: bool = False
) -> tuple[NDArray[np.float64], float]:
    """Computes the forces of the engine's own contact, and the time of a step [s]. `moves`: the tool continues its last
    motion over the period."""
    made = model(scene, steps, integrator, damping)
    data = mujoco.MjData(made)
    tool, wrench = mujoco.mj_name2id(made, mujoco.mjtObj.mjOBJ_GEOM, "tool"), np.zeros(6)

    def step(place: NDArray[np.float64]) -> NDArray[np.float64]:
        data.mocap_pos[0] = place
        mujoco.mj_step(made, data)
        force = np.zeros(3)
        for number, contact in enumerate(data.contact[: data.ncon]):
            if tool in contact.geom:
                mujoco.mj_contactForce(made, data, number, wrench)
                # The contact's x axis points from the first geom to the second, which is pushed along it.
                sign = 1.0 if contact.geom[1] == tool else -1.0
                force += sign * contact.frame[:3] * wrench[0]
        return force

    return by_engine(scene, steps, samples, moves, step)


def with_palpate(scene: Scene, steps: int, integrator: str, mass_factor: float, samples: int) -> tuple[NDArray[np.float64], float]:
    """Computes the forces of palpate's contact in the same engine, and the time of a step [s]. `mass_factor` is the
    model value of the device mass over the true mass."""
    made = model(scene, steps, integrator)
    contact = partial(Contact, made, mujoco.MjData(made), tool="tool", bodies=["body"])
    return by_palpate(scene, steps, samples, mass_factor, contact)
