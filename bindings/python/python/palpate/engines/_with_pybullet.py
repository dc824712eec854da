"""PyBullet in `palpate.engines.table`: its own contact of the tool, and that of palpate."""

from __future__ import annotations

from contextlib import contextmanager
from functools import partial
from typing import Iterator

import numpy as np
from numpy.typing import NDArray

from ._rendered import by_engine, by_palpate
from ._scenes import BODY_MASS, GRAVITY, HALF, Scene
from .pybullet import Contact

# After palpate.engines.pybullet, whose import error explains how to install PyBullet.
import pybullet  # noqa: E402  isort: skip

VERSION = f"PyBullet, API version {pybullet.getAPIVersion()}"
INTEGRATORS = ("Euler",)
"""Bullet has one integrator, semi-implicit Euler."""
_BASE = -1


@contextmanager
def _engine(scene: Scene, steps: int) -> Iterator[tuple[int, int]]:
    """Creates a client with body and floor, and yields the client and the number of the body."""
    client = pybullet.connect(pybullet.DIRECT)
    try:
        pybullet.setTimeStep(scene.period / steps, physicsClientId=client)
        pybullet.setGravity(0, 0, -GRAVITY, physicsClientId=client)
        # Iterate to convergence, so that the comparison does not depend on the solver's tolerance. A spring has no
        # slop.
        pybullet.setPhysicsEngineParameter(
            numSolverIterations=200, solverResidualThreshold=0, contactSlop=0, physicsClientId=client
        )
        size = {"radius": HALF} if scene.shape == "sphere" else {"halfExtents": [HALF] * 3}
        kind = pybullet.GEOM_SPHERE if scene.shape == "sphere" else pybullet.GEOM_BOX
        shape = pybullet.createCollisionShape(kind, **size, physicsClientId=client)
        body = pybullet.createMultiBody(BODY_MASS, shape, basePosition=scene.place, physicsClientId=client)
        smooth = {"lateralFriction": 0, "rollingFriction": 0, "spinningFriction": 0, "restitution": 0}
        still = {"linearDamping": 0, "angularDamping": 0}
        # Bullet adds the dampings of the two sides and the inverses of their stiffnesses.
        hard = {"contactStiffness": 1e12, "contactDamping": 0}
        pybullet.changeDynamics(body, _BASE, **smooth, **still, **hard, physicsClientId=client)
        if scene.floor is not None:
            # A Bullet plane touches a flat box at two of its corners only; a Bullet box touches it at all four.
            slab = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[1, 1, 0.1], physicsClientId=client)
            floor = pybullet.createMultiBody(0, slab, basePosition=(0, 0, -0.1), physicsClientId=client)
            shares = 4 if scene.shape == "box" else 1
            # Bullet integrates a spring implicitly, which adds a damping of h K.
            damping = max(0.0, scene.floor.damping - scene.period / steps * scene.floor.stiffness)
            law = {"contactStiffness": scene.floor.stiffness / shares, "contactDamping": damping / shares}
            pybullet.changeDynamics(floor, _BASE, **smooth, **law, physicsClientId=client)
        yield client, body
    finally:
        pybullet.disconnect(client)


def with_engine(
    scene: Scene, steps: int, integrator: str, damping: float, samples: int, moves: bool = False
) -> tuple[NDArray[np.float64], float]:
    """Computes the forces of the engine's own contact, and the time of a step [s]. `moves`: the tool continues its last
    motion over the period."""
    with _engine(scene, steps) as (client, body):
        shape = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=scene.tool_radius, physicsClientId=client)
        tool = pybullet.createMultiBody(0, shape, basePosition=scene.start, physicsClientId=client)
        law = {"contactStiffness": scene.stiffness, "contactDamping": damping}
        pybullet.changeDynamics(tool, _BASE, lateralFriction=0, restitution=0, **law, physicsClientId=client)

        def step(place: NDArray[np.float64]) -> NDArray[np.float64]:
            pybullet.resetBasePositionAndOrientation(tool, place.tolist(), (0, 0, 0, 1), physicsClientId=client)
            pybullet.stepSimulation(physicsClientId=client)
            force = np.zeros(3)
            for contact in pybullet.getContactPoints(bodyA=tool, bodyB=body, physicsClientId=client):
                # The normal points from the second body to the first, the tool.
                force += np.array(contact[7]) * contact[9]
            return force

        return by_engine(scene, steps, samples, moves, step)


def with_palpate(scene: Scene, steps: int, integrator: str, mass_factor: float, samples: int) -> tuple[NDArray[np.float64], float]:
    """Computes the forces of palpate's contact in the same engine, and the time of a step [s]. `mass_factor` is the
    model value of the device mass over the true mass."""
    with _engine(scene, steps) as (client, body):
        contact = partial(Contact, client, tool=scene.tool_radius, bodies=[body])
        return by_palpate(scene, steps, samples, mass_factor, contact)
