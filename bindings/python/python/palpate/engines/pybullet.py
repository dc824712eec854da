"""Contacts with the bodies of PyBullet: `pip install palpate[pybullet]`.

    import pybullet
    from palpate.engines.pybullet import Contact

    client = pybullet.connect(pybullet.DIRECT)
    ...
    contact = Contact(client, tool=0.01, bodies=[ball], stiffness=400.0, device_mass=0.25, period=0.01)
    while True:
        force = contact.step(position)  # reads your device, steps the engine, and gives the force to command

The engine simulates the bodies and its other contacts. palpate renders only the contacts of the tool, which is unknown
to the engine. Their wrenches are external forces of one step.
"""

from __future__ import annotations

from typing import Any, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._contact import EngineBody, EngineContact, PlacedShape, body_row, radius

try:
    import pybullet
except ImportError as _missing:
    raise ImportError("palpate.engines.pybullet needs PyBullet: pip install 'palpate[pybullet]'") from _missing

__all__ = ["Contact"]

_BASE = -1
"""Link index of a body without joints."""


class Contact(EngineContact):
    """Contacts of a tool with bodies of a PyBullet client.

    The contact steps the engine: a period is one or more of its steps. First the engine is stepped with the wrenches
    between proxies and bodies. This yields the force that the device holds during the same time. PyBullet does not
    report the other accelerations of a body, by its weight and its other contacts, before a step. They are extrapolated
    linearly from the last two steps.

    Args:
        client: Number of the client, from `pybullet.connect`.
        tool: Radius of the tool [m], a sphere unknown to PyBullet; 0 for a point. For several devices a sequence.
        bodies: Numbers of the bodies that the tool touches: without joints, free or fixed (mass 0), consisting of
            spheres, boxes, capsules, cylinders, planes and convex meshes.
        stiffness: K of the contacts [N/m].
        device_mass: Effective mass of the device [kg], accurate within a factor of 2: one number, or one per axis; for
            several devices a row of three for each.
        period: Time from sample to sample [s], a whole number of the engine's steps. `None`: one step. Call
            `pybullet.setTimeStep` first.
        others: Arguments of `palpate.engines.EngineContact`: `damping`, `friction`, `friction_stiffness`,
            `friction_damping`, `encoder_quantum`, `delay`, `lag`, `gain`, `force_limit`, `soft_start`.

    Raises:
        ValueError: An argument is not allowed; the message has the numbers of the bodies.
        pybullet.error: The client or a body does not exist.
    """

    client: int
    steps: int
    """Steps of the engine in a period."""

    def __new__(
        cls,
        client: int,
        *,
        tool: float | Sequence[float],
        bodies: Sequence[int],
        stiffness: float,
        device_mass: ArrayLike,
        period: float | None = None,
        **others: float,
    ) -> Contact:
        h = _time_step(client)
        steps = 1 if period is None else round(period / h) if np.isfinite(period) else 0
        if steps < 1 or (period is not None and abs(period / h - steps) > 1e-6 * steps):
            raise ValueError(
                f"period is {period} s, but must be a whole number of the engine's steps of {h} s: see pybullet.setTimeStep"
            )
        if np.ndim(bodies) != 1 or not all(isinstance(body, (int, np.integer)) for body in bodies):
            raise ValueError(f"bodies is {bodies!r}, but must be a list of the numbers of bodies, such as [1]")
        numbers = [int(body) for body in bodies]
        for number in numbers:
            if numbers.count(number) > 1:
                raise ValueError(f"bodies names {number} twice")
        several: list[Any] = [tool] if np.ndim(tool) == 0 else [*tool]  # type: ignore[misc]
        radii = [radius(given) for given in several]
        names = ["tool"] if len(radii) == 1 else [f"tool {number}" for number in range(len(radii))]
        made = super().__new__(
            cls,
            tools=dict(zip(names, radii)),
            bodies=[_described(client, number) for number in numbers],
            period=steps * h,
            device_mass=device_mass,
            stiffness=stiffness,
            # Bullet integrates positions with the velocity at the end of a step.
            end_velocity=True,
            **others,
        )
        assert isinstance(made, Contact)
        made.client, made.steps, made._numbers, made._h = client, steps, numbers, h
        made._start()
        return made

    _numbers: list[int]
    _h: float
    """Initial step of the engine [s]."""
    _wrenches: NDArray[np.float64]
    """Last applied wrenches, a row for each body: force [N], torque about the centre of mass [N m]."""
    _others: list[tuple[NDArray[np.float64], NDArray[np.float64]] | None]
    """Acceleration of each body without the contacts, in the last step and in the previous one [m/s^2], [rad/s^2];
    `None` before the first."""
    _before: list[NDArray[np.float64]]
    _pushes: bool

    def _start(self) -> None:
        self._wrenches = np.zeros((len(self._numbers), 6))
        self._others = [None] * len(self._numbers)
        self._before = []
        self._pushes = False

    def step(self, position: ArrayLike, elapsed: float | None = None) -> NDArray[np.float64]:
        """Computes one period: takes a sample of the devices, steps the engine through the period, and returns the
        force on the device [N] to hold over it.

        Args:
            position: Position of the device in the world frame [m], three numbers; for several devices a row for each.
            elapsed: Measured time since the last sample [s]; `None`: one period.

        Returns:
            Three numbers; for several devices a row for each. After an invalid sample they are 0, and `output.fault`
            has the reason; the engine is still stepped.

        Raises:
            ValueError: The position is not three numbers for each device, or the engine's step has changed.
        """
        self.sample(position, elapsed)
        for _ in range(self.steps):
            self.push()
            pybullet.stepSimulation(physicsClientId=self.client)
            self.pull()
        return self.hold()

    def push(self) -> None:
        """Applies the wrenches of the contacts, in addition to other forces, before a step of the engine. For a program
        that steps the engine itself, between `sample` and `hold`:

            contact.sample(position)
            for _ in range(contact.steps):
                contact.push()
                pybullet.stepSimulation()
                contact.pull()
            force = contact.hold()
        """
        if self._pushes:
            raise ValueError("call push() once before each step of the engine, and pull() after it")
        h = _time_step(self.client)
        if h != self._h:
            raise ValueError(f"the engine's step is {h} s, but was {self._h} s when this Contact was made: make another Contact")
        looked = [self._look(place) for place in range(len(self._numbers))]
        self._wrenches[:] = self.meet(h, np.array([row for row, _, _ in looked]))
        for number, wrench, (row, _, mobility) in zip(self._numbers, self._wrenches, looked):
            if mobility.any():
                force, torque, place = wrench[:3].tolist(), wrench[3:].tolist(), row[:3].tolist()
                world = pybullet.WORLD_FRAME
                if wrench.any():
                    # A sleeping body ignores forces and would feel like a wall.
                    awake = pybullet.ACTIVATION_STATE_WAKE_UP
                    pybullet.changeDynamics(number, _BASE, activationState=awake, physicsClientId=self.client)
                pybullet.applyExternalForce(number, _BASE, force, place, world, physicsClientId=self.client)
                pybullet.applyExternalTorque(number, _BASE, torque, world, physicsClientId=self.client)
        # Velocities after the wrenches alone; the remaining change in the step has other causes.
        self._before = [
            velocity + h * mobility @ wrench for (_, velocity, mobility), wrench in zip(looked, self._wrenches)
        ]
        self._pushes = True

    def pull(self) -> None:
        """Determines the other accelerations of the bodies, after a step of the engine."""
        if not self._pushes:
            raise ValueError("call pull() after push() and a step of the engine")
        self._pushes = False
        h = _time_step(self.client)
        for place, (number, before) in enumerate(zip(self._numbers, self._before)):
            last = (self._velocity(number) - before) / h
            known = self._others[place]
            self._others[place] = (last, last if known is None else known[0])

    def reset(self) -> None:
        """Resets samples, contacts and energy ledger. Call it after a body was moved."""
        super().reset()
        self._start()

    def _velocity(self, number: int) -> NDArray[np.float64]:
        return np.concatenate(pybullet.getBaseVelocity(number, physicsClientId=self.client))

    def _look(self, place: int) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Returns the row of a body, its velocity, and its mobility."""
        number, client = self._numbers[place], self.client
        position, turned = pybullet.getBasePositionAndOrientation(number, physicsClientId=client)
        x, y, z, w = turned
        velocity = self._velocity(number)
        mass, _, inertia, *_ = pybullet.getDynamicsInfo(number, _BASE, physicsClientId=client)
        mobility = np.zeros((6, 6))
        other = np.zeros(6)
        if mass > 0:
            axes = np.reshape(pybullet.getMatrixFromQuaternion(turned), (3, 3))
            mobility[:3, :3] = np.eye(3) / mass
            # An inertia of 0 means that the body does not rotate.
            mobility[3:, 3:] = axes @ np.diag([1.0 / i if i > 0 else 0.0 for i in inertia]) @ axes.T
            known = self._others[place]
            other = self._weight() if known is None else 2 * known[0] - known[1]
        row = body_row(position, (w, x, y, z), velocity[:3], velocity[3:], other[:3], other[3:], mobility)
        return row, velocity, mobility

    def _weight(self) -> NDArray[np.float64]:
        said = pybullet.getPhysicsEngineParameters(physicsClientId=self.client)
        return np.array([*(said[f"gravityAcceleration{axis}"] for axis in "XYZ"), 0.0, 0.0, 0.0])


def _time_step(client: int) -> float:
    said = pybullet.getPhysicsEngineParameters(physicsClientId=client)
    if said["numSubSteps"] > 1:
        raise ValueError(f"the engine takes {said['numSubSteps']} sub-steps in a step, but must take none: set numSubSteps=0")
    return float(said["fixedTimeStep"])


def _described(client: int, number: int) -> EngineBody:
    name = f"body {number}"
    if pybullet.getNumJoints(number, physicsClientId=client):
        raise ValueError(f"{name} has joints, but must be a single fixed or free body")
    shapes = []
    for index, shape in enumerate(pybullet.getCollisionShapeData(number, _BASE, physicsClientId=client)):
        _, _, kind, lengths, _, place, (x, y, z, w) = shape
        if kind == pybullet.GEOM_MESH:
            shapes.append(PlacedShape("hull", (), points=_corners(client, number, index)))
            continue
        word, own = _shape(name, kind, lengths)
        shapes.append(PlacedShape(word, own, place, (w, x, y, z)))
    if not shapes:
        raise ValueError(f"{name} has no collision shape, so a tool cannot touch it")
    return EngineBody(name, shapes)


def _shape(name: str, kind: int, lengths: Any) -> tuple[str, tuple[float, ...]]:
    """Returns the kind and the lengths of a shape, for `PlacedShape`."""
    if kind == pybullet.GEOM_SPHERE:
        return "sphere", (lengths[0],)
    if kind == pybullet.GEOM_BOX:
        return "box", tuple(0.5 * length for length in lengths)
    if kind in (pybullet.GEOM_CAPSULE, pybullet.GEOM_CYLINDER):
        height, radius = lengths[:2]
        return "capsule" if kind == pybullet.GEOM_CAPSULE else "cylinder", (radius, 0.5 * height)
    if kind == pybullet.GEOM_PLANE:
        if tuple(lengths) != (0.0, 0.0, 1.0):
            raise ValueError(f"{name} is a plane with the normal {tuple(lengths)}, but must have (0, 0, 1); turn the body instead")
        return "half-space", ()
    raise ValueError(
        f"{name} has a shape of PyBullet's kind {kind}; a tool can touch planes, spheres, capsules, cylinders, boxes and meshes"
    )


def _corners(client: int, number: int, index: int) -> list[list[float]]:
    """Returns the corners of the hull of a mesh, in the body frame, relative to the centre of mass [m]."""
    count, corners = pybullet.getMeshData(number, _BASE, collisionShapeIndex=index, physicsClientId=client)
    if count == 0:
        raise ValueError(
            f"body {number} has a concave mesh (GEOM_FORCE_CONCAVE_TRIMESH), but a tool can touch convex hulls only"
        )
    return [list(corner) for corner in corners]
