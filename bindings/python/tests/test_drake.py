"""Contacts with the bodies of Drake."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import pytest

from palpate.engines import SimulatedDevice

pytest.importorskip("pydrake", reason="pip install palpate[drake]")

from pydrake.geometry import Box, Capsule, Convex, Cylinder, Ellipsoid, HalfSpace, ProximityProperties, Sphere  # noqa: E402
from pydrake.geometry import AddContactMaterial  # noqa: E402
from pydrake.math import RigidTransform, RollPitchYaw  # noqa: E402
from pydrake.multibody.math import SpatialForce, SpatialVelocity  # noqa: E402
from pydrake.multibody.plant import (  # noqa: E402
    AddMultibodyPlant,
    CoulombFriction,
    ExternallyAppliedSpatialForce,
    ExternallyAppliedSpatialForceMultiplexer,
    MultibodyPlant,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import PdControllerGains, RevoluteJoint, SpatialInertia, UnitInertia  # noqa: E402
from pydrake.systems.analysis import Simulator  # noqa: E402
from pydrake.systems.framework import DiagramBuilder  # noqa: E402

from palpate.engines.drake import Contact  # noqa: E402

FREE: dict[str, Any] = {"force_limit": math.inf, "soft_start": 0}
TURNED = RollPitchYaw(1.2, -0.3, 0.4).ToRotationMatrix()
INERTIA = np.array([0.01, 0.02, 0.025])
CENTRE = np.array([0.1, 0.0, 0.05])


class Plant:
    """A plant that is being built, then a simulator of it."""

    def __init__(self, h: float = 0.001, gravity: float = 0.0, **config: Any) -> None:
        self.builder = DiagramBuilder()
        self.plant, self.scene_graph = AddMultibodyPlant(MultibodyPlantConfig(time_step=h, **config), self.builder)
        self.plant.mutable_gravity_field().set_gravity_vector([0, 0, -gravity])

    def body(self, name: str, inertia: Any, *shapes: Any) -> Any:
        body = self.plant.AddRigidBody(name, inertia)
        for number, (place, shape) in enumerate(shapes):
            self.shape(body, f"{name} {number}", shape, place)
        return body

    def shape(self, body: Any, name: str, shape: Any, place: Any = (0, 0, 0)) -> None:
        properties = ProximityProperties()
        AddContactMaterial(properties, point_stiffness=5e4, dissipation=5.0, friction=CoulombFriction(0, 0))
        pose = place if isinstance(place, RigidTransform) else RigidTransform(place)
        self.plant.RegisterCollisionGeometry(body, pose, shape, name, properties)

    def ball(self, name: str = "ball", mass: float = 0.1, radius: float = 0.03) -> Any:
        return self.body(name, SpatialInertia.SolidSphereWithMass(mass, radius), ((0, 0, 0), Sphere(radius)))

    def ready(self) -> Any:
        """Finalizes and builds; the plant's context."""
        if not self.plant.is_finalized():
            self.plant.Finalize()
        self.simulator = Simulator(self.builder.Build())
        self.root = self.simulator.get_mutable_context()
        self.own = self.plant.GetMyMutableContextFromRoot(self.root)
        return self.own

    def velocity(self, body: Any) -> Any:
        """Of the centre of mass, then of the rotation."""
        now = self.plant.EvalBodySpatialVelocityInWorld(self.own, body)
        return np.concatenate([body.CalcCenterOfMassTranslationalVelocityInWorld(self.own), now.rotational()])

    def centre(self, body: Any) -> Any:
        return self.plant.EvalBodyPoseInWorld(self.own, body).multiply(body.CalcCenterOfMassInBodyFrame(self.own))


class Blocked(NamedTuple):
    made: Plant
    body: Any


def block(h: float = 0.001, gravity: float = 0.0, **config: Any) -> Blocked:
    """A body that is turned, whose centre of mass is not where its axes begin."""
    made = Plant(h, gravity, **config)
    body = made.body("block", off_centre(), (CENTRE, Box(0.4, 0.2, 0.2)))
    made.ready()
    made.plant.SetFreeBodyPose(made.own, body, RigidTransform(TURNED, [1, 2, 3]))
    return Blocked(made, body)


def off_centre() -> Any:
    """1 kg at CENTRE, INERTIA about it."""
    central = SpatialInertia(1.0, np.zeros(3), UnitInertia(*INERTIA))
    return central.Shift(-CENTRE)


class FixedWrench(Contact):
    """Contacts that give one wrench for ever: what is tested is the way into the engine."""

    wrench: Any = None

    def meet(self, h: float, bodies: Any) -> Any:
        self.seen = bodies.copy()
        return np.array([self.wrench] * len(bodies))


def with_wrench(made: Plant, body: Any, wrench: Any) -> FixedWrench:
    contact = FixedWrench(made.simulator, made.plant, tool=0.01, bodies=[body], stiffness=100.0, device_mass=0.2, **FREE)
    assert isinstance(contact, FixedWrench)
    contact.wrench = wrench
    return contact


@pytest.mark.parametrize("sampled", [True, False])
def test_a_newton_on_a_kilogram_for_a_second_is_half_a_metre(sampled: bool) -> None:
    made, body = block(use_sampled_output_ports=sampled)
    start = made.centre(body)
    contact = with_wrench(made, body, [1, 0, 0, 0, 0, 0])
    for _ in range(1000):
        contact.step([0, 0, 0])
    assert made.root.get_time() == pytest.approx(1.0, abs=1e-12)
    # Drake integrates with the velocity at the end of a step, which adds half a step.
    np.testing.assert_allclose(made.centre(body) - start, [0.5 + 0.5 * 0.001, 0, 0], atol=1e-9)
    np.testing.assert_allclose(made.velocity(body), [1, 0, 0, 0, 0, 0], atol=1e-9)
    made.simulator.AdvanceTo(1.001)
    # Without push() palpate applies no force.
    np.testing.assert_allclose(made.velocity(body), [1, 0, 0, 0, 0, 0], atol=1e-9)


@pytest.mark.parametrize("sampled", [True, False])
def test_a_wrench_off_the_centre_turns_a_rotated_body_as_its_mobility_says(sampled: bool) -> None:
    h = 1e-4
    made, body = block(h, 9.81, use_sampled_output_ports=sampled)
    force, arm = np.array([0.3, -0.2, 1.0]), np.array([0.05, 0.1, -0.02])
    wrench = np.concatenate([force, np.cross(arm, force)])
    turning = np.array([0.4, -0.5, 0.6])
    made.plant.SetFreeBodySpatialVelocity(made.own, body, SpatialVelocity(turning, np.array([0.1, 0.2, 0.3])))
    start = made.velocity(body)
    contact = with_wrench(made, body, wrench)
    contact.step([0, 0, 0])
    row = contact.seen[0]
    mobility = row[19:].reshape(6, 6)
    inertia = TURNED.matrix() @ np.diag(INERTIA) @ TURNED.matrix().T
    expected = np.zeros((6, 6))
    expected[:3, :3], expected[3:, 3:] = np.eye(3), np.linalg.inv(inertia)
    np.testing.assert_allclose(mobility, expected, atol=1e-9)
    np.testing.assert_allclose(row[:3], TURNED.matrix() @ CENTRE + [1, 2, 3], atol=1e-12)
    np.testing.assert_allclose(row[7:13], start, atol=1e-12)
    # Weight and gyroscopic terms, which the plant predicts.
    gyroscopic = np.linalg.solve(inertia, -np.cross(turning, inertia @ turning))
    assert np.abs(gyroscopic).max() > 0.1
    np.testing.assert_allclose(row[13:19], [0, 0, -9.81, *gyroscopic], atol=1e-9)
    gained = (made.velocity(body) - start) / h
    np.testing.assert_allclose(gained, row[13:19] + mobility @ wrench, atol=0.01)


PUSH = np.array([0.4, -2.0, 0.7, 0.1, 0.2, -0.3])
HINGE = np.array([0.0, 0.6, 0.8])


def swung(wrench: Any, post: bool, **config: Any) -> tuple[Any, Any, Any]:
    """A door on a hinge that damps, perhaps against a post, for a step: acceleration without the wrench and mobility as
    its row has them, and the acceleration that it had."""
    h = 0.002
    made = Plant(h, 9.81, contact_model="point", **config)
    door = made.body("door", off_centre(), (CENTRE, Box(0.4, 0.2, 0.2)))
    frames = made.plant.world_frame(), door.body_frame()
    hinge = made.plant.AddJoint(RevoluteJoint("hinge", *frames, HINGE, -math.inf, math.inf, 2.0))
    if post:
        made.shape(made.plant.world_body(), "post", Sphere(0.05), (0.2, 0.14, 0.05))
    made.ready()
    hinge.set_angular_rate(made.own, 0.5)
    contact = with_wrench(made, door, wrench)
    before = made.velocity(door)
    assert before[3:] @ HINGE == pytest.approx(0.5)
    contact.step([0, 0, 0])
    row = contact.seen[0]
    np.testing.assert_allclose(row[7:13], before, atol=1e-12)
    return row[13:19], row[19:].reshape(6, 6), (made.velocity(door) - before) / h


def test_a_body_on_a_hinge_answers_as_its_mobility_says() -> None:
    others, mobility, swings = swung(np.zeros(6), False)
    same, _, pushed = swung(PUSH, False)
    np.testing.assert_allclose(same, others, atol=1e-9)
    # A hinge has one degree of freedom for any force.
    assert np.linalg.matrix_rank(mobility, tol=1e-6) == 1
    by_push = mobility @ PUSH
    assert np.abs(by_push).max() > 1
    # Includes joint damping and weight; the body rotates by 1 mrad meanwhile.
    np.testing.assert_allclose(HINGE @ swings[3:], HINGE @ others[3:], atol=1e-9)
    np.testing.assert_allclose(HINGE @ (pushed - swings)[3:], HINGE @ by_push[3:], atol=1e-9)
    np.testing.assert_allclose(swings, others, atol=0.01 * np.abs(others).max())
    np.testing.assert_allclose(pushed - swings, by_push, atol=0.01 * np.abs(by_push).max())


@pytest.mark.parametrize("sampled", [True, False])
@pytest.mark.parametrize("approximation", ["sap", "lagged", "similar"])
def test_a_row_says_what_the_other_contacts_will_do(approximation: str, sampled: bool) -> None:
    config = {"discrete_contact_approximation": approximation, "use_sampled_output_ports": sampled}
    leans, _, swings = swung(np.zeros(6), True, **config)
    alone, _, _ = swung(np.zeros(6), False, **config)
    assert abs(HINGE @ (leans - alone)[3:]) > 10
    np.testing.assert_allclose(HINGE @ swings[3:], HINGE @ leans[3:], rtol=1e-9)


def test_a_locked_joint_does_not_give_way() -> None:
    made, body = block()
    contact = with_wrench(made, body, [1, 0, 0, 0, 0, 0])
    body.Lock(made.own)
    contact.step([0, 0, 0])
    assert (contact.seen[0][19:] == 0).all()
    np.testing.assert_array_equal(made.velocity(body), np.zeros(6))
    body.Unlock(made.own)
    contact.step([0, 0, 0])
    np.testing.assert_allclose(made.velocity(body), [0.001, 0, 0, 0, 0, 0], atol=1e-9)


def test_bodies_and_devices_are_given_the_same_impulse() -> None:
    """A tool pushes a turned box off its centre; nothing else acts."""
    made = Plant()
    body = made.body("box", SpatialInertia.SolidBoxWithMass(0.1, 0.04, 0.06, 0.04), ((0, 0, 0), Box(0.04, 0.06, 0.04)))
    made.ready()
    made.plant.SetFreeBodyPose(made.own, body, RigidTransform(RollPitchYaw(0, 0, 0.4), [0, 0, 0]))
    contact = Contact(
        made.simulator, made.plant, tool=0.01, bodies=["box"], stiffness=2000.0, device_mass=0.2, period=0.004, **FREE
    )
    device = SimulatedDevice([0.2] * 3, [-0.05, 0.004, 0], 0.0, 0.0, [0, 0, 0], [0.5, 0, 0], 0.004)
    impulse, strongest = np.zeros(3), 0.0
    for _ in range(60):
        force = contact.step(device.position)
        impulse -= 0.004 * force
        strongest = max(strongest, float(np.linalg.norm(force)))
        device.hold(force)
    gained = 0.1 * made.velocity(body)
    assert strongest > 0.2 and abs(gained[3:]).max() > 1e-3, (strongest, gained)
    np.testing.assert_allclose(gained[:3], impulse, atol=0.03 * np.linalg.norm(impulse))


@pytest.mark.parametrize("approximation", ["sap", "lagged", "similar"])
def test_a_ball_on_a_floor_is_held_down_with_what_the_hand_gives(approximation: str) -> None:
    made = Plant(gravity=9.81, discrete_contact_approximation=approximation)
    ball = made.ball()
    made.shape(made.plant.world_body(), "floor", HalfSpace())
    made.ready()
    made.plant.SetFreeBodyPose(made.own, ball, RigidTransform([0, 0, 0.03]))
    contact = Contact(
        made.simulator, made.plant, tool=0.01, bodies=["ball", "world"], stiffness=1000.0, device_mass=0.25, period=0.004, damping=2.0
    )
    device = SimulatedDevice([0.25] * 3, [0, 0, 0.072], 60.0, 3.0, [0, 0, 0.072], [0, 0, -1.5], 0.004)
    for _ in range(300):
        force = contact.step(device.position)
        device.hold(force)
    # The hand's spring is slightly deflected.
    pressed = 1.5 - 60.0 * (0.072 - device.position[2])
    assert 1.0 < pressed < 1.5
    np.testing.assert_allclose(force, [0, 0, pressed], atol=0.02)
    assert abs(made.centre(ball)[2] - 0.03) < 1e-3
    # The bare floor supports the tool, too.
    contact.reset()
    device = SimulatedDevice([0.25] * 3, [0.2, 0, 0.011], 0.0, 3.0, [0, 0, 0], [0, 0, -2.0], 0.004)
    for _ in range(300):
        force = contact.step(device.position)
        device.hold(force)
    np.testing.assert_allclose(force, [0, 0, 2], atol=0.02)


BLOCK = np.array([[x, y, z] for x in (-0.1, 0.1) for y in (-0.2, 0.2) for z in (-0.3, 0.3)]).T


@pytest.mark.parametrize(
    ("shape", "height"),
    [
        (Sphere(0.3), 0.3),
        (Box(0.2, 0.4, 0.6), 0.3),
        (Convex(BLOCK, "block"), 0.3),
        (Cylinder(0.1, 0.5), 0.25),
        (Capsule(0.1, 0.5), 0.35),
        (HalfSpace(), 0.0),
    ],
)
def test_a_shape_begins_where_drake_has_it(shape: Any, height: float) -> None:
    """Drake's distance of a point from the shape is 0 where the tool begins to touch it."""
    made = Plant()
    carrier = made.body("thing", SpatialInertia.SolidSphereWithMass(1.0, 0.1).Shift([-0.2, 0.1, 0.3]))
    made.shape(carrier, "shape", shape, RigidTransform(RollPitchYaw(0.3, 0.5, -0.2), [0.02, 0.03, 0.05]))
    pose = RigidTransform(RollPitchYaw(-0.7, 0.1, 0.2), [0.5, 0, 1.0])
    made.plant.WeldFrames(made.plant.world_frame(), carrier.body_frame(), pose)
    made.ready()
    upright = pose.multiply(RigidTransform(RollPitchYaw(0.3, 0.5, -0.2), [0.02, 0.03, 0.05]))
    query = made.plant.get_geometry_query_input_port().Eval(made.own)
    for above, depth in ((0.001, 0.0), (-0.001, 0.001)):
        place = upright.multiply(np.array([0.0, 0.0, height + above]))
        [near] = query.ComputeSignedDistanceToPoint(place)
        assert near.distance == pytest.approx(above, abs=1e-9)
        contact = Contact(made.simulator, made.plant, tool=0.0, bodies=["thing"], stiffness=100.0, device_mass=0.2, **FREE)
        contact.step(place)
        assert max(point.penetration for point in contact.contacts) == pytest.approx(depth, abs=1e-5)


def test_a_tool_that_drake_knows_touches_everything_but_its_bodies() -> None:
    """The tool's sphere lies deep in the ball and in a post: the post pushes it, the ball does not."""
    for rendered in (False, True):
        made = Plant()
        ball = made.ball()
        finger = made.body("finger", SpatialInertia.SolidSphereWithMass(1.0, 0.01), ((0, 0, 0), Sphere(0.01)))
        made.shape(made.plant.world_body(), "post", Sphere(0.03), (0.0, 0.08, 0.0))
        made.ready()
        made.plant.SetFreeBodyPose(made.own, finger, RigidTransform([0, 0.045, 0]))
        made.plant.SetFreeBodyPose(made.own, ball, RigidTransform([0, 0.01, 0]))
        if rendered:
            law: dict[str, Any] = {"tool": "finger", "bodies": [ball], "stiffness": 100.0, "device_mass": 0.2, **FREE}
            contact = Contact(made.simulator, made.plant, **law)
            # The device is elsewhere, so palpate applies no force.
            contact.step([0, 0, 1])
            assert [point.between for point in contact.contacts] == [("finger", "body 'ball'")]
            np.testing.assert_array_equal(made.velocity(ball), np.zeros(6))
            assert made.velocity(finger)[1] < -1e-3
        else:
            made.simulator.AdvanceTo(0.001)
            assert made.velocity(ball)[1] < -1e-3
    # The tool radius is that of the sphere.
    contact = Contact(made.simulator, made.plant, **law)
    contact.step([0, 0.01 + 0.03 + 0.009, 0])
    assert contact.contacts[0].penetration == pytest.approx(0.001, abs=1e-5)


def test_drake_gets_its_own_contacts_of_a_tool_back_and_no_number_is_a_radius() -> None:
    for number_of_steps in (0, 3):
        made = Plant()
        ball = made.ball()
        finger = made.body("finger", SpatialInertia.SolidSphereWithMass(1.0, 0.01), ((0, 0, 0), Sphere(0.01)))
        made.ready()
        made.plant.SetFreeBodyPose(made.own, finger, RigidTransform([0, 0.035, 0]))
        law: dict[str, Any] = {"bodies": [ball], "stiffness": 100.0, "device_mass": 0.2, **FREE}
        with Contact(made.simulator, made.plant, tool="finger", **law) as contact:
            for _ in range(number_of_steps):
                contact.step([0, 0, 1])
            np.testing.assert_array_equal(made.velocity(ball), np.zeros(6))
        made.simulator.AdvanceTo(made.root.get_time() + 0.001)
        assert made.velocity(ball)[1] < -1e-3
        with pytest.raises(ValueError, match="closed"):
            contact.sample([0, 0, 1])
        with pytest.raises(ValueError, match="tool is 21, a whole number"):
            Contact(made.simulator, made.plant, tool=21, **law)


def test_a_servo_of_the_plant_answers_as_its_gains_say() -> None:
    """The velocity after a step is the row's, also where the plant's own controller pushes."""
    made = Plant()
    arm = made.body("arm", SpatialInertia(0.1, [0.1, 0, 0], UnitInertia(0.001, 0.011, 0.011)), ((0.1, 0, 0), Sphere(0.02)))
    joint = made.plant.AddJoint(RevoluteJoint("hinge", made.plant.world_frame(), arm.body_frame(), [0, 0, 1], 0.3))
    made.plant.AddJointActuator("servo", joint).set_controller_gains(PdControllerGains(p=40.0, d=2.0))
    made.ready()
    made.plant.get_desired_state_input_port(arm.model_instance()).FixValue(made.own, [0.2, 0.0])
    seen: list[tuple[Any, Any]] = []

    class Seen(Contact):
        def meet(self, h: float, bodies: Any) -> Any:
            wrench = super().meet(h, bodies)
            seen.append((bodies[0].copy(), wrench[0].copy()))
            return wrench

    contact = Seen(made.simulator, made.plant, tool=0.01, bodies=[arm], stiffness=500.0, device_mass=0.2, **FREE)
    for number in range(200):
        before = made.velocity(arm)[1]
        contact.step([0.1, -0.0299 + 1e-4 * number, 0])
        row, wrench = seen[-1]
        foreseen = row[14] + row[19:55].reshape(6, 6)[1] @ wrench
        assert (made.velocity(arm)[1] - before) / 0.001 == pytest.approx(foreseen, abs=2e-2)
    assert wrench[1] > 0.1


def test_what_else_stands_in_the_port_stays_and_several_contacts_share_it() -> None:
    made = Plant()
    left, right = made.ball("left", 1.0), made.ball("right", 1.0)
    made.ready()
    made.plant.SetFreeBodyPose(made.own, right, RigidTransform([1, 0, 0]))
    port = made.plant.get_applied_spatial_force_input_port()
    theirs = ExternallyAppliedSpatialForce()
    theirs.body_index, theirs.F_Bq_W = left.index(), SpatialForce(np.zeros(3), np.array([0.0, 3.0, 0.0]))
    value = port.Allocate()
    value.set_value([theirs])
    port.FixValue(made.own, value)
    one, other = with_wrench(made, left, [1, 0, 0, 0, 0, 0]), with_wrench(made, right, [0, 0, 2, 0, 0, 0])
    for first, second in ((one, other), (other, one)):
        one.sample([0, 0, 0])
        other.sample([0, 0, 0])
        until = one.push()
        assert other.push() == until
        assert len(port.Eval(made.own)) == 3
        made.simulator.AdvanceTo(until)
        first.pull()
        second.pull()
        [kept] = port.Eval(made.own)
        assert kept.body_index == left.index()
        np.testing.assert_array_equal(kept.F_Bq_W.translational(), [0, 3, 0])
        one.hold()
        other.hold()
    np.testing.assert_allclose(made.velocity(left)[:3], [0.002, 0.006, 0], atol=1e-12)
    np.testing.assert_allclose(made.velocity(right)[:3], [0, 0, 0.004], atol=1e-12)
    # Forces of the other contact appear in the acceleration, not in the wrench.
    np.testing.assert_allclose(one.seen[0][13:16], [0, 3, 0], atol=1e-9)


def test_a_port_that_is_connected_is_shared_through_a_multiplexer() -> None:
    made = Plant()
    ball = made.ball(mass=1.0)
    made.plant.Finalize()
    both = made.builder.AddSystem(ExternallyAppliedSpatialForceMultiplexer(2))
    made.builder.Connect(both.get_output_port(), made.plant.get_applied_spatial_force_input_port())
    made.builder.ExportInput(both.get_input_port(0), "theirs")
    made.ready()
    law: dict[str, Any] = {"tool": 0.01, "bodies": [ball], "stiffness": 1000.0, "device_mass": 0.2}
    with pytest.raises(ValueError, match="'applied_spatial_force' of 'plant' is connected"):
        Contact(made.simulator, made.plant, **law)
    with pytest.raises(ValueError, match="is exported as 'theirs'"):
        Contact(made.simulator, made.plant, port=both.get_input_port(0), **law)
    outer = made.simulator.get_system().get_input_port(0)
    theirs = ExternallyAppliedSpatialForce()
    theirs.body_index, theirs.F_Bq_W = ball.index(), SpatialForce(np.zeros(3), np.array([0.0, 3.0, 0.0]))
    value = outer.Allocate()
    value.set_value([theirs])
    outer.FixValue(made.root, value)
    contact = FixedWrench(made.simulator, made.plant, port=both.get_input_port(1), **law)
    assert isinstance(contact, FixedWrench)
    contact.wrench = [1, 0, 0, 0, 0, 0]
    contact.step([0, 0, 0])
    np.testing.assert_allclose(made.velocity(ball)[:3], [0.001, 0.003, 0], atol=1e-12)


def test_time_that_goes_back_begins_anew() -> None:
    made = Plant()
    ball = made.ball()
    made.ready()
    contact = Contact(made.simulator, made.plant, tool=0.01, bodies=[ball], stiffness=1000.0, device_mass=0.2, **FREE)
    for _ in range(5):
        contact.step([0, 0, 0.039])
    assert np.abs(contact.output.forces).max() > 0.1  # type: ignore[union-attr]
    made.root.SetTime(0.0)
    made.plant.SetFreeBodyPose(made.own, ball, RigidTransform([0, 0, -1]))
    made.plant.SetFreeBodySpatialVelocity(made.own, ball, SpatialVelocity(np.zeros(3), np.zeros(3)))
    made.simulator.Initialize()
    np.testing.assert_array_equal(contact.step([0, 0, 0.039]), np.zeros(3))
    assert all(entry == 0 for entry in contact.ledger[1].values() for entry in entry)


def test_another_context_begins_anew() -> None:
    made = Plant()
    ball = made.ball()
    finger = made.body("finger", SpatialInertia.SolidSphereWithMass(1.0, 0.01), ((0, 0, 0), Sphere(0.01)))
    made.ready()
    contact = Contact(made.simulator, made.plant, tool=finger, bodies=[ball], stiffness=1000.0, device_mass=0.2, **FREE)
    for _ in range(5):
        contact.step([0, 0, 0.039])
    contact.sample([0, 0, 0.039])
    another = made.simulator.get_system().CreateDefaultContext()
    made.simulator.reset_context(another)
    with pytest.raises(ValueError, match="another context within a period"):
        contact.push()
    contact.step([0, 0, 1])
    own = made.plant.GetMyContextFromRoot(made.simulator.get_context())
    # The tool's sphere lies within the ball here, too, but without force.
    np.testing.assert_array_equal(made.plant.GetVelocities(own), np.zeros(12))
    assert made.simulator.get_context().get_time() == pytest.approx(0.001)


def test_a_step_that_ends_with_an_error_leaves_nothing_in_the_port() -> None:
    made = Plant()
    ball = made.ball()
    made.ready()
    contact = with_wrench(made, ball, [1, 0, 0, 0, 0, 0])

    def stop(_: Any) -> Any:
        raise RuntimeError("enough")

    made.simulator.set_monitor(stop)
    with pytest.raises(RuntimeError, match="enough"):
        contact.step([0, 0, 1])
    assert not made.plant.get_applied_spatial_force_input_port().Eval(made.own)


def test_what_cannot_be_touched_is_refused() -> None:
    made = Plant()
    ball = made.ball()
    egg = made.body("egg", SpatialInertia.SolidSphereWithMass(1.0, 0.1), ((0, 0, 0), Ellipsoid(0.1, 0.2, 0.3)))
    made.body("nothing", SpatialInertia.SolidSphereWithMass(1.0, 0.1))
    for model in ("a", "b"):
        made.plant.AddRigidBody("twin", made.plant.AddModelInstance(model), SpatialInertia.SolidSphereWithMass(1.0, 0.1))
    law: dict[str, Any] = {"tool": 0.01, "stiffness": 1000.0, "device_mass": 0.2}
    made.plant.set_name("mine")
    made.ready()
    other = Plant()
    stranger = other.ball()
    other.ready()
    for given, said in [
        ({"bodies": [ball], "period": 0.0015}, "period is 0.0015 s, but must be a whole number of the plant's time steps of 0.001 s"),
        ({"bodies": [ball], "period": math.nan}, "period is nan s, but must be a whole number"),
        ({"bodies": "ball"}, r"bodies is 'ball', but must be a list, such as \['ball'\]"),
        ({"bodies": ["ball", ball]}, "bodies names body 'ball' twice"),
        ({"bodies": ["cube"]}, "the plant has no body 'cube'; it has 'world', 'ball', 'egg', 'nothing'"),
        ({"bodies": ["twin"]}, "the plant has 2 bodies 'twin', in several models: give the RigidBody itself"),
        ({"bodies": [stranger]}, "body 'ball' belongs to another plant"),
        ({"bodies": [3]}, "3 is not a body"),
        ({"bodies": [egg]}, "body 'egg': its shape .*egg 0' is of type Ellipsoid; a tool can touch half-spaces, spheres"),
        ({"bodies": ["nothing"]}, "body 'nothing' has no collision shape"),
        ({"bodies": [ball], "tool": "egg"}, "tool: body 'egg' must have one sphere as collision shape, but has Ellipsoid"),
        ({"bodies": [ball], "tool": "nothing"}, "tool: body 'nothing' must have one sphere as collision shape, but has none"),
        ({"bodies": [ball], "tool": "ball"}, "bodies names body 'ball', which is the tool"),
        ({"bodies": [ball], "stiffness": -1.0}, "stiffness"),
    ]:
        with pytest.raises(ValueError, match=said):
            Contact(made.simulator, made.plant, **{**law, **given})
    with pytest.raises(ValueError, match="has no plant 'mine'"):
        Contact(other.simulator, made.plant, bodies=[ball], **law)
    for plant, said in [(Plant(0.0), "is continuous, but must be discrete"), (Plant(), "is not finalized: call Finalize")]:
        sphere = plant.ball()
        if "continuous" in said:
            plant.ready()
        with pytest.raises(ValueError, match=said):
            Contact(made.simulator, plant.plant, bodies=[sphere], **law)
    bare = MultibodyPlant(0.001)
    lone = bare.AddRigidBody("lone", SpatialInertia.SolidSphereWithMass(1.0, 0.1))
    bare.Finalize()
    with pytest.raises(ValueError, match="has no scene graph, so its bodies have no shapes"):
        Contact(Simulator(bare), bare, bodies=[lone], **law)


def test_steps_that_are_not_the_plants_are_refused() -> None:
    made = Plant()
    ball = made.ball()
    made.ready()
    contact = Contact(made.simulator, made.plant, tool=0.01, bodies=[ball], stiffness=1000.0, device_mass=0.2, **FREE)
    contact.sample([0, 0, 1])
    with pytest.raises(ValueError, match="call pull\\(\\) after push"):
        contact.pull()
    until = contact.push()
    with pytest.raises(ValueError, match="call push\\(\\) once"):
        contact.push()
    with pytest.raises(ValueError, match="advance the simulator to 0.001 s after push\\(\\); its time is 0.0 s"):
        contact.pull()
    assert not made.plant.get_applied_spatial_force_input_port().Eval(made.own)
    contact.sample([0, 0, 1])
    assert contact.push() == until
    made.simulator.AdvanceTo(until)
    contact.pull()
    contact.hold()
    made.simulator.AdvanceTo(0.0015)
    contact.sample([0, 0, 1])
    with pytest.raises(ValueError, match="time is 0.0015 s, but must be a whole number of the plant's time steps"):
        contact.push()
