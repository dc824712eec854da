"""Drake in `palpate.engines.table`: its own contact of the tool, and that of palpate."""

from __future__ import annotations

from functools import partial
from importlib.metadata import version
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._rendered import by_engine, by_palpate
from ._scenes import BODY_MASS, GRAVITY, HALF, Law, Scene
from .drake import Contact

# After palpate.engines.drake, whose import error explains how to install Drake.
from pydrake.geometry import (  # noqa: E402  isort: skip
    AddContactMaterial,
    Box,
    CollisionFilterDeclaration,
    GeometryId,
    GeometrySet,
    HalfSpace,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from pydrake.math import RigidTransform  # noqa: E402  isort: skip
from pydrake.multibody.math import SpatialVelocity  # noqa: E402  isort: skip
from pydrake.multibody.plant import AddMultibodyPlant, CoulombFriction, MultibodyPlant, MultibodyPlantConfig  # noqa: E402  isort: skip
from pydrake.multibody.tree import SpatialInertia  # noqa: E402  isort: skip
from pydrake.systems.analysis import Simulator  # noqa: E402  isort: skip
from pydrake.systems.framework import Context, DiagramBuilder  # noqa: E402  isort: skip

VERSION = f"Drake {version('drake')}"
INTEGRATORS = ("sap",)
"""Contact approximation of a discrete plant with a linear spring and damper."""
_HARD = 1e12
"""Stiffness of a rigid side [N/m]: Drake adds the compliances of the two sides."""
_HEAVY = 1e6
"""Mass of the engine's own tool, which no contact moves [kg]."""


class Made(NamedTuple):
    """Scene in Drake."""

    simulator: Simulator
    plant: MultibodyPlant
    own: Context
    """Context of the plant."""
    body: Any
    tool: Any
    """Tool body of the engine; `None` if palpate renders it."""


def _material(law: Law) -> ProximityProperties:
    """Creates the contact material of a spring and a damper."""
    properties = ProximityProperties()
    AddContactMaterial(properties, point_stiffness=law.stiffness, friction=CoulombFriction(0, 0))
    # Damping over stiffness. Drake adds the values of the two bodies in contact.
    properties.AddProperty("material", "relaxation_time", law.damping / law.stiffness)
    return properties


def _apart(scene_graph: SceneGraph, some: list[GeometryId], others: list[GeometryId]) -> None:
    """Excludes contacts between two sets of shapes from the engine."""
    excluded = CollisionFilterDeclaration().ExcludeBetween(GeometrySet(some), GeometrySet(others))
    scene_graph.collision_filter_manager().Apply(excluded)


def _engine(scene: Scene, steps: int, integrator: str, damping: float | None = None) -> Made:
    """Creates the engine's bodies. `damping`: that of the engine's own contact of the tool [N s/m]; `None`: no tool."""
    h = scene.period / steps
    config = MultibodyPlantConfig(
        time_step=h,
        contact_model="point",
        discrete_contact_approximation=integrator,
        # Otherwise Drake softens contacts that are too stiff for its step.
        sap_near_rigid_threshold=0.0,
    )
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlant(config, builder)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, -GRAVITY])
    ball = scene.shape == "sphere"
    inertia = SpatialInertia.SolidSphereWithMass(BODY_MASS, HALF) if ball else SpatialInertia.SolidBoxWithMass(BODY_MASS, *[2 * HALF] * 3)
    body = plant.AddRigidBody("body", inertia)
    shape = Sphere(HALF) if ball else Box(2 * HALF, 2 * HALF, 2 * HALF)
    hard = _material(Law(_HARD, 0))
    touched = plant.RegisterCollisionGeometry(body, RigidTransform(), shape, "body", hard)
    untouched = []
    if scene.floor is not None:
        # Drake integrates a spring implicitly, which adds a damping of h K.
        damping = max(0.0, scene.floor.damping - h * scene.floor.stiffness)
        shares = 1 if ball else 4
        floor = Law(scene.floor.stiffness / shares, damping / shares)
        ground = plant.RegisterCollisionGeometry(plant.world_body(), RigidTransform(), HalfSpace(), "floor", _material(floor))
        untouched.append(ground)
    if scene.floor is not None and not ball:
        # Drake has one contact point per pair of shapes. So the box rests on spheres at its corners, which do not
        # touch the tool.
        carrier = plant.AddRigidBody("feet", SpatialInertia.Zero())
        plant.WeldFrames(body.body_frame(), carrier.body_frame())
        for number, (x, y) in enumerate([(-HALF, -HALF), (-HALF, HALF), (HALF, -HALF), (HALF, HALF)]):
            corner = RigidTransform([x, y, -HALF])
            untouched.append(plant.RegisterCollisionGeometry(carrier, corner, Sphere(0.0), f"foot {number}", hard))
        _apart(scene_graph, [touched], [ground])
    tool = None
    if damping is not None:
        # A free body that is placed at the tool, at rest, before each step. A locked body crashes Drake 1.51.1.
        weightless = plant.AddModelInstance("tool")
        plant.set_gravity_enabled(weightless, False)
        tool = plant.AddRigidBody("tool", weightless, SpatialInertia.SolidSphereWithMass(_HEAVY, scene.tool_radius))
        law = Law(scene.stiffness, damping)
        sphere = plant.RegisterCollisionGeometry(tool, RigidTransform(), Sphere(scene.tool_radius), "tool", _material(law))
        # These pairs do not touch in the scene either.
        _apart(scene_graph, [sphere], untouched)
    plant.Finalize()
    simulator = Simulator(builder.Build())
    own = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.SetFreeBodyPose(own, body, RigidTransform(scene.place))
    if tool is not None:
        plant.SetFreeBodyPose(own, tool, RigidTransform(scene.start))
    return Made(simulator, plant, own, body, tool)


def with_engine(
    scene: Scene, steps: int, integrator: str, damping: float, samples: int, moves: bool = False
) -> tuple[NDArray[np.float64], float]:
    """Computes the forces of the engine's own contact, and the time of a step [s]. `moves`: the tool continues its last
    motion over the period."""
    simulator, plant, own, body, tool = _engine(scene, steps, integrator, damping)
    results = plant.get_contact_results_output_port()
    h = scene.period / steps
    still = SpatialVelocity(np.zeros(3), np.zeros(3))
    done = 0

    def step(place: NDArray[np.float64]) -> NDArray[np.float64]:
        nonlocal done
        plant.SetFreeBodyPose(own, tool, RigidTransform(place))
        plant.SetFreeBodySpatialVelocity(own, tool, still)
        done += 1
        simulator.AdvanceTo(done * h)
        force = np.zeros(3)
        # Contacts of the last step.
        contacts = results.Eval(own)
        for number in range(contacts.num_point_pair_contacts()):
            contact = contacts.point_pair_contact_info(number)
            if {contact.bodyA_index(), contact.bodyB_index()} == {body.index(), tool.index()}:
                # The force acts on body B.
                force += contact.contact_force() if contact.bodyB_index() == tool.index() else -contact.contact_force()
        return force

    return by_engine(scene, steps, samples, moves, step)


def with_palpate(scene: Scene, steps: int, integrator: str, mass_factor: float, samples: int) -> tuple[NDArray[np.float64], float]:
    """Computes the forces of palpate's contact in the same engine, and the time of a step [s]. `mass_factor` is the
    model value of the device mass over the true mass."""
    engine = _engine(scene, steps, integrator)
    contact = partial(Contact, engine.simulator, engine.plant, tool=scene.tool_radius, bodies=["body"])
    return by_palpate(scene, steps, samples, mass_factor, contact)
