"""Contacts with the bodies of PyBullet."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Iterator

import numpy as np
import pytest

from palpate.engines import SimulatedDevice

pybullet = pytest.importorskip("pybullet", reason="pip install palpate[pybullet]")

from palpate.engines.pybullet import Contact  # noqa: E402

FREE: dict[str, Any] = {"force_limit": math.inf, "soft_start": 0}


@pytest.fixture
def client() -> Iterator[int]:
    client = pybullet.connect(pybullet.DIRECT)
    pybullet.setTimeStep(0.001, physicsClientId=client)
    yield client
    pybullet.disconnect(client)


def body(client: int, mass: float, place: Any = (0, 0, 0), inertia: Any = None, turned: Any = (0, 0, 0, 1), **shape: Any) -> int:
    centre = shape.pop("centre", (0, 0, 0))
    kind = pybullet.createCollisionShape(physicsClientId=client, **shape)
    number = pybullet.createMultiBody(
        mass, kind, basePosition=place, baseOrientation=turned, baseInertialFramePosition=centre, physicsClientId=client
    )
    beside = {} if inertia is None else {"localInertiaDiagonal": inertia}
    pybullet.changeDynamics(number, -1, linearDamping=0, angularDamping=0, physicsClientId=client, **beside)
    return int(number)


def block(client: int) -> int:
    """A body that is turned, whose centre of mass is not where its frame is."""
    half = [0.2, 0.1, 0.1]
    turned = (0.6, 0, 0, 0.8)
    shape: dict[str, Any] = {"shapeType": pybullet.GEOM_BOX, "halfExtents": half, "centre": (0.1, 0, 0.05)}
    return body(client, 1.0, (1, 2, 3), [0.01, 0.02, 0.025], turned, **shape)


class FixedWrench(Contact):
    """Contacts that give one wrench for ever: what is tested is the way into the engine."""

    wrench: Any = None

    def meet(self, h: float, bodies: Any) -> Any:
        self.seen = bodies.copy()
        return np.array([self.wrench])


def with_wrench(client: int, number: int, wrench: Any) -> FixedWrench:
    contact = FixedWrench(client, tool=0.01, bodies=[number], stiffness=100.0, device_mass=0.2, **FREE)
    assert isinstance(contact, FixedWrench)
    contact.wrench = wrench
    return contact


def test_a_newton_on_a_kilogram_for_a_second_is_half_a_metre(client: int) -> None:
    number = block(client)
    start = np.array(pybullet.getBasePositionAndOrientation(number, physicsClientId=client)[0])
    contact = with_wrench(client, number, [1, 0, 0, 0, 0, 0])
    for _ in range(1000):
        contact.step([0, 0, 0])
    moved = np.array(pybullet.getBasePositionAndOrientation(number, physicsClientId=client)[0]) - start
    # Bullet integrates with the velocity at the end of a step, which adds half a step.
    np.testing.assert_allclose(moved, [0.5 + 0.5 * 0.001, 0, 0], atol=1e-9)
    np.testing.assert_allclose(contact._velocity(number), [1, 0, 0, 0, 0, 0], atol=1e-9)
    pybullet.stepSimulation(physicsClientId=client)
    # Without push() palpate applies no force.
    np.testing.assert_allclose(contact._velocity(number), [1, 0, 0, 0, 0, 0], atol=1e-9)


def test_a_wrench_off_the_centre_turns_a_rotated_body_as_its_mobility_says(client: int) -> None:
    h = 1e-4
    pybullet.setTimeStep(h, physicsClientId=client)
    pybullet.setGravity(0, 0, -9.81, physicsClientId=client)
    number = block(client)
    force, arm = np.array([0.3, -0.2, 1.0]), np.array([0.05, 0.1, -0.02])
    wrench = np.concatenate([force, np.cross(arm, force)])
    start = [0.1, 0.2, 0.3], [0.4, -0.5, 0.6]
    pybullet.resetBaseVelocity(number, *start, physicsClientId=client)
    contact = with_wrench(client, number, wrench)
    contact.step([0, 0, 0])
    mobility = contact.seen[0][19:].reshape(6, 6)
    orientation = pybullet.getBasePositionAndOrientation(number, physicsClientId=client)[1]
    turned = np.reshape(pybullet.getMatrixFromQuaternion(orientation), (3, 3))
    inverse = turned @ np.diag(1 / np.array([0.01, 0.02, 0.025])) @ turned.T
    np.testing.assert_allclose(mobility[3:, 3:], inverse, rtol=1e-3, atol=0.1)
    np.testing.assert_allclose(contact.seen[0][7:13], np.concatenate(start), atol=1e-12)
    np.testing.assert_allclose(contact.seen[0][13:19], [0, 0, -9.81, 0, 0, 0], atol=1e-12)
    gained = contact._velocity(number) - np.concatenate(start)
    by_all = mobility @ wrench + [0, 0, -9.81, 0, 0, 0]
    # The rest is gyroscopic, and the next row includes it.
    np.testing.assert_allclose(gained[:3] / h, by_all[:3], atol=1e-6)
    np.testing.assert_allclose(gained[3:] / h, by_all[3:], atol=0.5)
    left = gained / h - mobility @ wrench
    contact.step([0, 0, 0])
    np.testing.assert_allclose(contact.seen[0][13:19], left, atol=1e-9)


def test_bodies_and_devices_are_given_the_same_impulse(client: int) -> None:
    """A tool pushes a turned box off its centre; nothing else acts."""
    number = body(
        client, 0.1, inertia=[2e-5, 3e-5, 4e-5], turned=(0, 0, 0.2, 0.98), shapeType=pybullet.GEOM_BOX, halfExtents=[0.02, 0.03, 0.02]
    )
    contact = Contact(client, tool=0.01, bodies=[number], stiffness=2000.0, device_mass=0.2, period=0.004, **FREE)
    device = SimulatedDevice([0.2] * 3, [-0.05, 0.004, 0], 0.0, 0.0, [0, 0, 0], [0.5, 0, 0], 0.004)
    impulse, strongest = np.zeros(3), 0.0
    for _ in range(60):
        force = contact.step(device.position)
        impulse -= 0.004 * force
        strongest = max(strongest, float(np.linalg.norm(force)))
        device.hold(force)
    gained = 0.1 * contact._velocity(number)
    assert strongest > 0.2 and abs(gained[3:]).max() > 1e-3, (strongest, gained)
    np.testing.assert_allclose(gained[:3], impulse, atol=0.03 * np.linalg.norm(impulse))


def test_a_ball_on_a_plane_is_held_down_with_what_the_hand_gives(client: int) -> None:
    pybullet.setGravity(0, 0, -9.81, physicsClientId=client)
    floor = body(client, 0.0, shapeType=pybullet.GEOM_PLANE)
    ball = body(client, 0.1, (0, 0, 0.03), shapeType=pybullet.GEOM_SPHERE, radius=0.03)
    contact = Contact(client, tool=0.01, bodies=[ball, floor], stiffness=1000.0, device_mass=0.25, period=0.004, damping=2.0)
    device = SimulatedDevice([0.25] * 3, [0, 0, 0.072], 60.0, 3.0, [0, 0, 0.072], [0, 0, -1.5], 0.004)
    for _ in range(300):
        force = contact.step(device.position)
        device.hold(force)
    # The hand's spring is slightly deflected.
    pressed = 1.5 - 60.0 * (0.072 - device.position[2])
    assert 1.0 < pressed < 1.5
    np.testing.assert_allclose(force, [0, 0, pressed], atol=0.02)
    place = pybullet.getBasePositionAndOrientation(ball, physicsClientId=client)[0]
    assert abs(place[2] - 0.03) < 1e-3
    # The bare plane supports the tool, too.
    contact.reset()
    device = SimulatedDevice([0.25] * 3, [0.2, 0, 0.011], 0.0, 3.0, [0, 0, 0], [0, 0, -2.0], 0.004)
    for _ in range(300):
        force = contact.step(device.position)
        device.hold(force)
    np.testing.assert_allclose(force, [0, 0, 2], atol=0.02)


BLOCK = [[x, y, z] for x in (-0.1, 0.1) for y in (-0.2, 0.2) for z in (-0.3, 0.3)]
SIDES = [0, 1, 2, 1, 3, 2, 4, 6, 5, 5, 6, 7, 0, 4, 1, 1, 4, 5, 2, 3, 6, 3, 7, 6, 0, 2, 4, 2, 6, 4, 1, 5, 3, 3, 5, 7]


@pytest.mark.parametrize(
    ("shape", "height"),
    [
        ({"shapeType": "GEOM_SPHERE", "radius": 0.3}, 0.3),
        ({"shapeType": "GEOM_BOX", "halfExtents": [0.1, 0.2, 0.3]}, 0.3),
        ({"shapeType": "GEOM_CYLINDER", "radius": 0.1, "height": 0.5}, 0.25),
        ({"shapeType": "GEOM_CAPSULE", "radius": 0.1, "height": 0.5}, 0.35),
        ({"shapeType": "GEOM_PLANE"}, 0.0),
        ({"shapeType": "GEOM_MESH", "vertices": BLOCK}, 0.3),
        ({"shapeType": "GEOM_MESH", "vertices": BLOCK, "collisionFramePosition": [0, 0, 0.05], "centre": (0.01, 0, 0.02)}, 0.35),
    ],
)
def test_a_shape_begins_where_pybullet_has_it(client: int, shape: dict[str, Any], height: float) -> None:
    """A ray from above meets the shape where the tool does."""
    shape = {**shape, "shapeType": getattr(pybullet, shape["shapeType"])}
    number = body(client, 0.0, (0.5, 0, 1.0), **shape)
    [ray] = pybullet.rayTest([0.5, 0, 3.0], [0.5, 0, -3.0], physicsClientId=client)
    # Bullet adds a margin of 1 mm to hulls.
    assert abs(ray[3][2] - (1.0 + height)) < 1.1e-3
    for above, depth in ((0.001, 0.0), (-0.001, 0.001)):
        contact = Contact(client, tool=0.0, bodies=[number], stiffness=100.0, device_mass=0.2, **FREE)
        contact.step([0.5, 0, 1.0 + height + above])
        assert max(point.penetration for point in contact.contacts) == pytest.approx(depth, abs=1e-5)


def test_each_mesh_of_a_body_is_where_pybullet_has_it(client: int, tmp_path: Path) -> None:
    """A ball and two blocks beside it, of a file."""
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in BLOCK)
    faces = "".join("f {} {} {}\n".format(*(corner + 1 for corner in SIDES[at : at + 3])) for at in range(0, len(SIDES), 3))
    (tmp_path / "block.obj").write_text(corners + faces)
    file = str(tmp_path / "block.obj")
    kind = pybullet.createCollisionShapeArray(
        shapeTypes=[pybullet.GEOM_SPHERE, pybullet.GEOM_MESH, pybullet.GEOM_MESH],
        radii=[0.1, 0, 0],
        halfExtents=[[0, 0, 0]] * 3,
        lengths=[0] * 3,
        fileNames=["", file, file],
        meshScales=[[1, 1, 1], [1, 1, 1], [1, 1, 0.5]],
        planeNormals=[[0, 0, 1]] * 3,
        flags=[0] * 3,
        collisionFramePositions=[[0, 0, 0], [1, 0, 0], [2, 0, 0]],
        collisionFrameOrientations=[[0, 0, 0, 1]] * 3,
        physicsClientId=client,
    )
    number = pybullet.createMultiBody(0, kind, basePosition=[0, 0, 1], physicsClientId=client)
    contact = Contact(client, tool=0.0, bodies=[number], stiffness=100.0, device_mass=0.2, **FREE)
    for place, height in ((0.0, 0.1), (1.0, 0.3), (2.0, 0.15)):
        [ray] = pybullet.rayTest([place, 0, 3], [place, 0, -3], physicsClientId=client)
        # Bullet adds a margin of 1 mm to hulls.
        assert abs(ray[3][2] - (1 + height)) < 2e-3
        contact.reset()
        contact.step([place, 0, 1 + height - 0.001])
        assert max(point.penetration for point in contact.contacts) == pytest.approx(0.001, abs=1e-5)


def test_what_cannot_be_touched_is_refused(client: int) -> None:
    ball = body(client, 0.1, shapeType=pybullet.GEOM_SPHERE, radius=0.03)
    tilted = body(client, 0.0, shapeType=pybullet.GEOM_PLANE, planeNormal=[0, 1, 0])
    nothing = pybullet.createMultiBody(1.0, physicsClientId=client)
    hollow = body(
        client, 0.0, shapeType=pybullet.GEOM_MESH, vertices=BLOCK, indices=SIDES, flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH
    )
    links: dict[str, Any] = {
        f"link{name}": [value]
        for name, value in {
            "Masses": 1.0, "CollisionShapeIndices": -1, "VisualShapeIndices": -1, "Positions": [0, 0, 1],
            "Orientations": [0, 0, 0, 1], "InertialFramePositions": [0, 0, 0], "InertialFrameOrientations": [0, 0, 0, 1],
            "ParentIndices": 0, "JointTypes": pybullet.JOINT_REVOLUTE, "JointAxis": [0, 0, 1],
        }.items()
    }  # fmt: skip
    door = pybullet.createMultiBody(1.0, physicsClientId=client, **links)
    law: dict[str, Any] = {"tool": 0.01, "stiffness": 1000.0, "device_mass": 0.2}
    for given, said in [
        ({"bodies": [ball], "period": 0.0015}, "period is 0.0015 s, but must be a whole number of the engine's steps of 0.001 s"),
        ({"bodies": [ball, ball]}, f"bodies names {ball} twice"),
        ({"bodies": [door]}, f"body {door} has joints"),
        ({"bodies": [tilted]}, "a plane with the normal"),
        ({"bodies": [nothing]}, "has no collision shape"),
        ({"bodies": [hollow]}, "has a concave mesh"),
        ({"bodies": [ball], "stiffness": -1.0}, "stiffness"),
    ]:
        with pytest.raises(ValueError, match=said):
            Contact(client, **{**law, **given})
    contact = Contact(client, bodies=[ball], **law)
    contact.sample([0, 0, 1])
    with pytest.raises(ValueError, match="call pull\\(\\) after push"):
        contact.pull()
    contact.push()
    with pytest.raises(ValueError, match="call push\\(\\) once"):
        contact.push()
    pybullet.setPhysicsEngineParameter(numSubSteps=4, physicsClientId=client)
    with pytest.raises(ValueError, match="4 sub-steps"):
        Contact(client, bodies=[ball], **law)


def test_a_body_that_sleeps_is_woken_by_a_push(client: int) -> None:
    number = body(client, 0.1, shapeType=pybullet.GEOM_SPHERE, radius=0.03)
    asleep = pybullet.ACTIVATION_STATE_ENABLE_SLEEPING + pybullet.ACTIVATION_STATE_SLEEP
    pybullet.changeDynamics(number, -1, activationState=asleep, physicsClientId=client)
    contact = Contact(client, tool=0.01, bodies=[number], stiffness=1000.0, device_mass=0.25, period=0.004, **FREE)
    forces = [contact.step([min(-0.045 + 1e-4 * tick, -0.03), 0, 0])[0] for tick in range(300)]
    # The ball is pushed away; a wall at its position would give 10 N.
    assert -5.0 < min(forces) < -0.1
    place, _ = pybullet.getBasePositionAndOrientation(number, physicsClientId=client)
    assert place[0] > 0.01


def test_another_step_of_the_engine_than_at_the_start_is_refused(client: int) -> None:
    number = body(client, 0.1, shapeType=pybullet.GEOM_SPHERE, radius=0.03)
    contact = Contact(client, tool=0.01, bodies=[number], stiffness=1000.0, device_mass=0.25, period=0.004)
    contact.step([0, 0, 0.1])
    pybullet.setTimeStep(0.002, physicsClientId=client)
    with pytest.raises(ValueError, match="the engine's step is 0.002 s, but was 0.001 s when this Contact was made"):
        contact.step([0, 0, 0.1])


def test_bodies_are_a_list_of_whole_numbers(client: int) -> None:
    number = body(client, 0.1, shapeType=pybullet.GEOM_SPHERE, radius=0.03)
    for wrong in (number, "ball", [number + 0.5], [None]):
        with pytest.raises(ValueError, match="must be a list of the numbers of bodies"):
            Contact(client, tool=0.01, bodies=wrong, stiffness=1000.0, device_mass=0.25)  # type: ignore[arg-type]
