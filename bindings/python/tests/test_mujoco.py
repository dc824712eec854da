"""Contacts with the bodies of MuJoCo."""

from __future__ import annotations

import contextlib
import math
import runpy
import subprocess
import sys
import types
import warnings
from typing import Any

import numpy as np
import pytest

import palpate
from conftest import ROOT
from palpate.engines import EngineContact, SimulatedDevice

mujoco = pytest.importorskip("mujoco", reason="pip install palpate[mujoco]")

from palpate.engines import _scenes, _with_mujoco, table  # noqa: E402
from palpate.engines.mujoco import Contact  # noqa: E402

FREE: dict[str, Any] = {"force_limit": math.inf, "soft_start": 0}


def load(world: str, h: float = 0.001, integrator: str = "RK4", gravity: str = "0 0 0") -> tuple[Any, Any]:
    xml = (
        f'<mujoco><option timestep="{h}" integrator="{integrator}" gravity="{gravity}"><flag eulerdamp="disable"/></option>'
        f"<worldbody>{world}</worldbody></mujoco>"
    )
    model = mujoco.MjModel.from_xml_string(xml)
    return model, mujoco.MjData(model)


BLOCK = (
    '<body name="block" pos="1 2 3" quat="0.8 0.6 0 0"><freejoint/><inertial pos="0.1 0 0.05" mass="1" diaginertia="0.01 0.02 '
    '0.025"/><geom type="box" size="0.2 0.1 0.1"/></body>'
)


class FixedWrench(Contact):
    """Contacts that give one wrench for ever: what is tested is the way into the engine."""

    wrench: Any = None

    def meet(self, h: float, bodies: Any) -> Any:
        self.seen = bodies.copy()
        return np.array([self.wrench])


def with_wrench(model: Any, data: Any, wrench: Any, body: str = "block") -> FixedWrench:
    contact = FixedWrench(model, data, tool=0.01, bodies=[body], stiffness=100.0, device_mass=0.2, **FREE)
    assert isinstance(contact, FixedWrench)
    contact.wrench = wrench
    return contact


def test_a_newton_on_a_kilogram_for_a_second_is_half_a_metre() -> None:
    model, data = load(BLOCK)
    contact = with_wrench(model, data, [1, 0, 0, 0, 0, 0])
    mujoco.mj_forward(model, data)
    start = data.xipos[1].copy()
    for _ in range(1000):
        contact.step([0, 0, 0])
    np.testing.assert_allclose(data.xipos[1] - start, [0.5, 0, 0], atol=1e-9)
    np.testing.assert_allclose(data.qvel, [1, 0, 0, 0, 0, 0], atol=1e-9)
    # The user's forces stay, and palpate's are removed.
    assert (data.xfrc_applied == 0).all()


def test_a_wrench_off_the_centre_turns_a_rotated_body_as_its_mobility_says() -> None:
    model, data = load(BLOCK, h=1e-4)
    force, arm = np.array([0.3, -0.2, 1.0]), np.array([0.05, 0.1, -0.02])
    wrench = np.concatenate([force, np.cross(arm, force)])
    data.qvel[:] = [0.1, 0.2, 0.3, 0.4, -0.5, 0.6]
    contact = with_wrench(model, data, wrench)
    contact.step([0, 0, 0])
    row = contact.seen[0]
    before, acceleration, mobility = row[7:13], row[13:19], row[19:].reshape(6, 6)
    np.testing.assert_allclose(mobility, mobility.T, atol=1e-9)
    turned = data.ximat[1].reshape(3, 3)
    inverse = turned @ np.diag(1 / model.body_inertia[1]) @ turned.T
    np.testing.assert_allclose(mobility[3:, 3:], inverse, rtol=1e-3, atol=0.1)
    np.testing.assert_allclose(mobility[:3, :3], np.eye(3), atol=1e-9)
    jacobian = np.zeros((6, model.nv))
    mujoco.mj_forward(model, data)
    mujoco.mj_jacBodyCom(model, data, jacobian[:3], jacobian[3:], 1)
    gained = jacobian @ data.qvel - before
    np.testing.assert_allclose(gained / 1e-4, acceleration + mobility @ wrench, rtol=2e-3, atol=2e-2)


def test_a_door_answers_at_its_handle_by_its_moment_of_inertia() -> None:
    model, data = load(
        '<body name="door"><joint type="hinge" axis="0 0 1"/><geom type="box" pos="0.4 0 0" size="0.4 0.02 1" mass="3"/></body>'
    )
    contact = with_wrench(model, data, [0, 0, 0, 0, 0, 0], "door")
    contact.step([0, 0, 0])
    mobility = contact.seen[0][19:].reshape(6, 6)
    # At the handle, 0.4 m beyond the centre of mass, along y.
    at = np.array([0, 1, 0, 0, 0, 0.4])
    moment = 3 * (0.8**2 + 0.04**2) / 12 + 3 * 0.4**2
    assert abs(at @ mobility @ at / (0.8**2 / moment) - 1) < 1e-9
    assert np.linalg.matrix_rank(mobility) == 1


def test_bodies_and_devices_are_given_the_same_impulse_whatever_the_joint() -> None:
    """A tool pushes a door near its edge."""
    model, data = load(
        '<body name="door"><joint type="hinge" axis="0 0 1"/><geom type="box" pos="0.4 0 0" size="0.4 0.02 1" mass="0.3"/></body>',
        h=0.0005,
    )
    contact = Contact(model, data, tool=0.01, bodies=["door"], stiffness=2000.0, device_mass=0.3, period=0.002, **FREE)
    device = SimulatedDevice([0.3] * 3, [0.7, -0.04, 0], 0.0, 0.0, [0, 0, 0], [0, 2.0, 0], 0.002)
    torque = 0.0
    for _ in range(150):
        force = contact.step(device.position)
        [point] = contact.contacts
        torque -= 0.002 * np.cross([device.position[0], device.position[1], 0], force)[2]
        device.hold(force)
    moment = 0.3 * (0.8**2 + 0.04**2) / 12 + 0.3 * 0.4**2
    assert data.qvel[0] > 1.0 and abs(torque / (moment * data.qvel[0]) - 1) < 0.03, (torque, moment * data.qvel[0])


def test_tool_rests_on_fixed_geoms_and_follows_the_proxy() -> None:
    model, data = load(
        '<geom name="floor" type="plane" size="1 1 1"/><geom name="wall" type="box" pos="0.3 0 0" size="0.1 1 1"/>'
        '<body name="hand" mocap="true" pos="0 0 1"><geom name="tip" type="sphere" size="0.02"/></body>'
    )
    contact = Contact(model, data, tool="tip", bodies=["world"], stiffness=1000.0, device_mass=0.2, **FREE)
    assert model.geom_contype[2] == model.geom_conaffinity[2] == 0
    assert [point.between for point in contact.contacts] == [("tip", "body 'world'")] * 2
    device = SimulatedDevice([0.2] * 3, [0.17, 0, 0.021], 0.0, 3.0, [0, 0, 0], [1.0, 0, -2.0], 0.001)
    for _ in range(1500):
        force = contact.step(device.position)
        device.hold(force)
    np.testing.assert_allclose(force, [-1, 0, 2], atol=0.01)
    np.testing.assert_allclose(data.mocap_pos[0], device.position, atol=1e-4)
    assert contact.devices["tip"].mass is not None and contact.output is not None and contact.output.fault is None


def test_what_stands_in_xfrc_applied_stays_there() -> None:
    model, data = load('<body name="ball"><freejoint/><geom type="sphere" size="0.02" mass="0.1"/></body>')
    contact = Contact(model, data, tool=0.01, bodies=["ball"], stiffness=1000.0, device_mass=0.2, **FREE)
    own = [0, 0, 0.5, 0, 0, 0]
    data.xfrc_applied[1] = own
    for _ in range(20):
        contact.step([0, 0, 0.029])
        assert data.xfrc_applied[1].tolist() == own
    assert data.qvel[2] < 0  # 1 N of the tool against it at first
    contact.sample([0, 0, 0.029])
    with pytest.raises(ValueError, match="call pull\\(\\) after push"):
        contact.pull()
    contact.push()
    with pytest.raises(ValueError, match="call push\\(\\) once"):
        contact.push()
    mujoco.mj_step(model, data)
    contact.pull()
    contact.hold()
    with pytest.raises(ValueError, match="call sample\\(\\) before"):
        contact.hold()


def test_several_tools_and_several_contacts_share_a_body() -> None:
    """Two fingers pinch a ball of 50 g, as two tools of one contact and as two contacts: it stays."""
    ball = '<body name="ball"><freejoint/><geom type="sphere" size="0.02" mass="0.05"/></body>'
    law: dict[str, Any] = {"bodies": ["ball"], "stiffness": 2000.0, "device_mass": 0.2, "friction": 0.8, "damping": 1.0, **FREE}
    for is_one in (True, False):
        model, data = load(ball, gravity="0 0 -9.81", integrator="implicitfast")
        fingers = [SimulatedDevice([0.2] * 3, [x, 0, 0], 60.0, 3.0, [x, 0, 0], [-30 * x, 0, 0.25], 0.001) for x in (-0.0299, 0.0299)]
        together = Contact(model, data, tool=[0.01, 0.01], **law) if is_one else None
        apart = [] if is_one else [Contact(model, data, tool=0.01, **law) for _ in fingers]
        for _ in range(500):
            places = [finger.position for finger in fingers]
            if together is not None:
                forces = together.step(places)
            else:
                for one, place in zip(apart, places):
                    one.sample(place)
                for one in apart:
                    one.push()
                mujoco.mj_step(model, data)
                for one in reversed(apart):
                    one.pull()
                forces = np.array([one.hold() for one in apart])
            for finger, force in zip(fingers, forces):
                finger.hold(force)
        assert (data.xfrc_applied == 0).all()
        # The body yields by the friction bristles and the fingers, but does not fall.
        assert abs(data.qpos[2]) < 0.02 and np.abs(data.qvel[:3]).max() < 0.02, (is_one, data.qpos, data.qvel)
        assert abs(forces[0][0]) > 0.5 and abs(forces[0][0] + forces[1][0]) < 0.05


def test_bad_samples_give_no_force_and_the_engine_goes_on() -> None:
    model, data = load('<body name="ball"><freejoint/><geom type="sphere" size="0.02" mass="0.1"/></body>')
    contact = Contact(model, data, tool=0.01, bodies=["ball"], stiffness=1000.0, device_mass=0.2)
    contact.step([0, 0, 0.0299])
    assert contact.step([0, math.nan, 0]).tolist() == [0, 0, 0]
    assert contact.output is not None and contact.output.fault == "position-not-finite"
    assert abs(data.time - 0.002) < 1e-12 and (data.xfrc_applied == 0).all()
    # Afterwards the soft start ramps the force, within its limit.
    assert np.linalg.norm(contact.step([0, 0, 0.0299])) < 0.1
    for _ in range(400):
        data.qpos[:3] = 0
        data.qvel[:] = 0
        force = contact.step([0, 0, 0.001])
    assert abs(np.linalg.norm(force) - 20) < 1e-6 and contact.output.limited == ("force",)
    contact.reset()
    assert contact.output is None and contact.step([0, 0, 1.0]).tolist() == [0, 0, 0]
    ledger, ports = contact.ledger
    assert ledger[0].between == ("tool", "body 'ball'") and ports["tool"].port_work == 0


def test_an_engine_that_was_put_back_is_met_anew(tmp_path: Any, monkeypatch: Any) -> None:
    # MuJoCo writes a log to the working directory.
    monkeypatch.chdir(tmp_path)
    model, data = load('<body name="ball"><freejoint/><geom type="sphere" size="0.02" mass="0.1"/></body>')
    contact = Contact(model, data, tool=0.01, bodies=["ball"], stiffness=1000.0, device_mass=0.2, period=0.002)
    for _ in range(50):
        contact.step([0, 0, 0.025])
    assert data.time > 0.09 and data.qpos[2] < -1e-3
    mujoco.mj_resetData(model, data)
    # The reset gives a sudden penetration of 5 mm, and the soft start ramps the force.
    force = contact.step([0, 0, 0.025])
    assert contact.output is not None and contact.output.limited == ("soft-start",) and 0 <= force[2] < 0.2
    # MuJoCo resets itself after a non-finite state: no contact in that period.
    contact.sample([0, 0, 0.025])
    contact.push()
    data.qvel[2] = math.nan
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        mujoco.mj_step(model, data)
    contact.pull()
    contact.push()
    mujoco.mj_step(model, data)
    contact.pull()
    assert contact.hold().tolist() == [0, 0, 0] and contact.output.fault == "overflow"
    assert np.isfinite(contact.step([0, 0, 0.1])).all() and contact.output.fault is None


def pressed(shape: str, turned: str) -> tuple[Any, Any]:
    """Forces on a device that is pressed for 0.4 s onto a block of this geom, at a place beside its centre, and where the
    block then is."""
    half = (0.03, 0.02, 0.01)
    corners = " ".join(f"{0.01 + x} {y} {0.02 + z}" for x in (-0.03, 0.03) for y in (-0.02, 0.02) for z in (-0.01, 0.01))
    geom = {
        "box": f'<geom type="box" size="{half[0]} {half[1]} {half[2]}" pos="0.01 0 0.02" mass="0.1"/>',
        "mesh": '<geom type="mesh" mesh="block" mass="0.1"/>',
    }[shape]
    xml = (
        f'<mujoco><option timestep="0.001" integrator="RK4" gravity="0 0 0"/><asset><mesh name="block" vertex="{corners}"/></asset>'
        f'<worldbody><body name="block" quat="{turned}"><freejoint/>{geom}</body></worldbody></mujoco>'
    )
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    contact = Contact(
        model, data, tool=0.005, bodies=["block"], stiffness=500.0, friction=0.3, device_mass=0.2, period=0.004, **FREE
    )
    start = data.xipos[1] + [0.012, 0.004, 0.03]
    device = SimulatedDevice([0.2] * 3, start, 0, 0, [0, 0, 0], [0, 0, -0.4], 0.004)
    forces = []
    for _ in range(100):
        forces.append(contact.step(device.position))
        device.hold(forces[-1])
    return np.array(forces), data.xipos[1].copy()


@pytest.mark.parametrize("turned", ["1 0 0 0", "0.9 0.3 -0.2 0.1"])
def test_a_mesh_is_touched_as_the_box_that_it_is(turned: str) -> None:
    """The engine puts a mesh into axes of its own, and the shape is still where the box is."""
    of_box, box_at = pressed("box", turned)
    of_mesh, mesh_at = pressed("mesh", turned)
    assert np.abs(of_box).max() > 0.1
    # The engine stores the corners in single precision.
    np.testing.assert_allclose(of_mesh, of_box, atol=2e-4)
    np.testing.assert_allclose(mesh_at, box_at, atol=1e-5)


def test_what_a_tool_cannot_touch_is_said_by_its_name() -> None:
    model, data = load(
        '<geom name="floor" type="plane" size="1 1 1"/><body name="egg"><freejoint/><geom name="shell" type="ellipsoid" '
        'size="0.1 0.1 0.2"/></body><body name="ghost"><freejoint/><geom size="0.1" contype="0" conaffinity="0"/></body>'
        '<body name="ball"><freejoint/><geom name="rubber" size="0.1"/></body>'
    )
    good: dict[str, Any] = {"tool": 0.01, "bodies": ["ball"], "stiffness": 100.0, "device_mass": 0.2}
    assert repr(Contact(model, data, **good)) == "<Contact of tool with body 'ball'>"
    for changed, said in [
        ({"bodies": ["bal"]}, "the model has no body 'bal'; it has 'world', 'egg', 'ghost', 'ball'"),
        ({"bodies": "ball"}, "bodies is 'ball', but must be a list"),
        ({"bodies": ["ball", 3]}, "bodies names body 'ball' twice"),
        ({"bodies": [7]}, "bodies has 7, but the model's bodies are 0 to 3"),
        ({"bodies": []}, "there is no body to touch"),
        ({"bodies": ["egg"]}, "body 'egg': geom 'shell' is of type ellipsoid"),
        ({"bodies": ["ghost"]}, "body 'ghost' has no geom that can collide"),
        ({"tool": "rubber"}, "geom 'rubber' must belong to a mocap body"),
        ({"tool": "floor"}, "geom 'floor' is not a sphere"),
        ({"tool": -0.1}, 'tool is -0.1, but must be a radius in metres from 0 to 1'),
        ({"period": 0.0015}, "period is 0.0015 s, but must be a whole number of the model's time steps of 0.001 s"),
        ({"stiffness": 0}, "stiffness is 0, and has to be above 0"),
        ({"device_mass": [0.1, 0.2]}, r"device_mass has the shape \(2,\)"),
        ({"device_mass": 0}, "device_mass is 0, and has to be above 0"),
        ({"soft_start": -1}, "soft_start is -1 s, but must be 0 to 60"),
    ]:
        with pytest.raises(ValueError, match=said):
            Contact(model, data, **{**good, **changed})
    with pytest.raises(ValueError, match=r"position has the shape \(2,\), but must have \(3,\)"):
        Contact(model, data, **good).step([0, 0])


def test_an_adapter_of_ones_own_needs_no_engine_of_ours() -> None:
    """A ball that a loop of Python moves: the same momentum on both sides."""
    contact = EngineContact(
        tools={"tip": 0.0},
        bodies=[palpate.engines.EngineBody("ball", [palpate.engines.PlacedShape("sphere", (0.02,))])],
        period=0.004,
        device_mass=0.2,
        stiffness=800.0,
        **FREE,
    )
    mobility = np.diag([10.0] * 3 + [1e4] * 3)
    place, speed, device = 0.025, 0.0, SimulatedDevice([0.2] * 3, [0, 0, 0], 0, 0, [0, 0, 0], [0, 0, 1.0], 0.004)
    given = taken = 0.0
    for _ in range(60):
        contact.sample(device.position)
        for _ in range(2):
            row = palpate.engines.body_row([0, 0, place], [1, 0, 0, 0], [0, 0, speed], [0] * 3, [0] * 3, [0] * 3, mobility)
            [wrench] = contact.meet(0.002, row[None])
            speed += 0.002 * 10 * wrench[2]
            place += 0.002 * speed
            given += 0.002 * wrench[2]
        force = contact.hold()
        taken += 0.004 * force[2]
        device.hold(force)
    assert given > 0.02 and abs(given + taken) < 0.01 * given
    assert contact.contacts[0].between == ("tip", "ball")


def test_without_mujoco_the_message_says_how_to_get_it() -> None:
    code = "import sys; sys.modules['mujoco'] = None; import palpate.engines; import palpate.engines.mujoco"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 1 and "palpate.engines.mujoco needs MuJoCo: pip install 'palpate[mujoco]'" in done.stderr


def example(name: str) -> dict[str, Any]:
    return runpy.run_path(str(ROOT / "bindings/python/examples" / name))


def test_the_example_without_a_window_opens_the_door() -> None:
    found = example("mujoco_headless.py")["main"]()
    assert found["angle of the door [rad]"] > 0.2 and found["displacement of the box along y [m]"] > 0.03
    assert abs(found["energy beyond the contacts' work [J]"]) < 1e-3


def test_the_example_with_a_window_follows_the_mouse() -> None:
    """With a window that is none: the mouse drags the tool down onto the ball."""
    names = example("mujoco_mouse.py")
    model, data, contact, device = names["set_up"]()

    class Window:
        frames = 0
        texts: Any = None
        perturb = types.SimpleNamespace(select=mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "hand"), active=1, refpos=None)
        lock = contextlib.nullcontext

        def is_running(self) -> bool:
            self.frames += 1
            self.perturb.refpos = [-0.06, -0.1 + 0.1 * min(1, self.frames / 20), 0.06]
            return self.frames < 60

        def set_texts(self, texts: Any) -> None:
            self.texts = texts

        def sync(self) -> None:
            pass

    window = Window()
    names["drive"](window, model, data, contact, device)
    np.testing.assert_allclose(data.mocap_pos[0], device.position, atol=2e-3)
    assert device.position[1] > -0.03 and window.texts[3].endswith(" N")
    assert contact.output is not None and contact.output.fault is None


@pytest.mark.parametrize("period, stiffness", table.RATES)
def test_model_delay_removes_the_error_of_late_forces(period: float, stiffness: float) -> None:
    """Each force acts a period late. Told, the engine is ahead by that; not told, the error is that of the delay."""
    scene = table.scenes(period, stiffness)[0]
    ideal = palpate.simulate(scene.world)
    errors = []
    for delay in (period, 0.0):
        model = _with_mujoco.model(scene, 4, "RK4")
        data = mujoco.MjData(model)
        while data.time < delay - 1e-9:
            mujoco.mj_step(model, data)
        contact = Contact(
            model,
            data,
            tool="tool",
            bodies=["body"],
            stiffness=stiffness,
            device_mass=_scenes.DEVICE_MASS,
            period=period,
            delay=delay,
            **FREE,
        )
        device, late, forces = scene.device(), np.zeros(3), []
        for _ in range(ideal.ideal.shape[1]):
            answer = contact.step(device.position)
            forces.append(late)
            device.hold(late)
            late = answer
        errors.append(table.evaluated(np.array(forces), ideal)[0])
    assert errors[0] < 2 and errors[1] > 50, errors


def test_a_model_that_changes_under_a_contact_is_refused() -> None:
    def of_time_step(model: Any) -> None:
        model.opt.timestep = 0.002

    def of_integrator(model: Any) -> None:
        model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER

    def of_size(model: Any) -> None:
        model.geom_size[0][0] *= 0.5

    def of_place(model: Any) -> None:
        model.geom_pos[0][2] += 0.01

    for change in (of_time_step, of_integrator, of_size, of_place):
        model, data = load(BLOCK)
        contact = Contact(model, data, tool=0.01, bodies=["block"], stiffness=100.0, device_mass=0.2, period=0.004)
        contact.step([0, 0, 0])
        change(model)
        with pytest.raises(ValueError, match="has changed since this Contact was made: make another Contact"):
            contact.step([0, 0, 0])


def test_tools_of_one_name_numbers_that_are_none_and_data_of_another_model_are_refused() -> None:
    hand = '<body name="hand" mocap="true"><geom name="tool" size="0.01"/></body>'
    model, data = load(BLOCK + hand)
    good: dict[str, Any] = {"tool": 0.01, "bodies": ["block"], "stiffness": 100.0, "device_mass": 0.2}
    for changed, said in [
        ({"tool": ["tool", "tool"]}, "tool names 'tool' twice"),
        ({"bodies": [1.5]}, "bodies has 1.5, but must have names or whole numbers"),
        ({"bodies": [None]}, "bodies has None, but must have names or whole numbers"),
    ]:
        with pytest.raises(ValueError, match=said):
            Contact(model, data, **{**good, **changed})
    with pytest.raises(ValueError, match="data belongs to another model"):
        Contact(model, load(BLOCK)[1], **good)


ARM = (
    '<body name="arm" pos="0 0 0.1"><joint name="a" axis="0 1 0" damping="{damping}"/><geom type="capsule" fromto="0 0 0 .2 0 0" size=".02" '
    'mass=".05"/><body name="hand" pos=".2 0 0"><joint name="b" axis="0 1 0" damping="{damping}"/><geom name="palm" type="sphere" size=".03" '
    'pos=".05 0 0" mass=".01"/></body></body>'
)


def arm(integrator: str, damping: float | str, actuators: str = "", h: float = 0.001, flag: str = "enable") -> tuple[Any, Any]:
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{h}" integrator="{integrator}" gravity="0 0 -9.81"><flag eulerdamp="{flag}"/></option>'
        f"<worldbody>{ARM.format(damping=damping)}</worldbody>{actuators}</mujoco>"
    )
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = [0.3, -0.5], [2.0, -5.0]
    return model, data


SERVO = (
    '<actuator><position joint="a" kp="20" kv="2"/><velocity joint="b" kv="0.5"/><general joint="b" gaintype="affine" gainprm="1 0 -0.3" '
    'biastype="affine" biasprm="0 -3 -0.4"/></actuator>'
)


POLYNOMIAL = [("0 0.001 0.0001", "")] if hasattr(mujoco.MjModel, "dof_dampingpoly") else []
"""Damping that grows with the speed, from MuJoCo 4 on."""


@pytest.mark.parametrize("integrator", ["Euler", "implicitfast", "implicit"])
@pytest.mark.parametrize("damping, actuators", [(0.0, ""), (0.5, ""), (0.0, SERVO), (0.5, SERVO), *POLYNOMIAL])
@pytest.mark.parametrize("flag", ["enable", "disable"])
def test_a_step_answers_to_a_wrench_as_foreseen_by_any_integrator(integrator: str, damping: float | str, actuators: str, flag: str) -> None:
    """The velocity after the step is the row's: velocity + h (acceleration + mobility wrench)."""
    model, data = arm(integrator, damping, actuators, flag=flag)
    data.ctrl[:] = 0.2
    wrench = np.array([0.7, 0.0, -3.0, 0.0, 0.02, 0.0])
    contact = with_wrench(model, data, wrench, "hand")
    for _ in range(3):
        contact.sample([0.0, 0.0, 1.0])
        contact.push()
        row = contact.seen[0]
        mobility = row[19:55].reshape(6, 6)
        jacobian, rate = np.zeros((6, 2)), np.zeros((6, 2))
        number = model.body("hand").id
        mujoco.mj_jacBodyCom(model, data, jacobian[:3], jacobian[3:], number)
        mujoco.mj_jacDot(model, data, rate[:3], rate[3:], data.xipos[number], number)
        before = data.qvel.copy()
        mujoco.mj_step(model, data)
        contact.pull()
        found = jacobian @ (data.qvel - before) / model.opt.timestep + rate @ before
        np.testing.assert_allclose(found, row[13:19] + mobility @ wrench, rtol=1e-7, atol=1e-6)


def test_the_tool_is_a_radius_or_a_sphere_and_never_a_number_of_a_geom() -> None:
    tip = '<body name="hand" mocap="true"><geom name="tip" type="sphere" size="0.01"/></body>'
    model, data = load(BLOCK + tip)
    law: dict[str, Any] = {"bodies": ["block"], "stiffness": 100.0, "device_mass": 0.2}
    for wrong in (model.geom("tip").id, np.int32(1), True, 21.0, math.nan, None, [21]):
        with pytest.raises(ValueError, match="must be a radius in metres from 0 to 1.*by its name"):
            Contact(model, data, tool=wrong, **law)
    with pytest.raises(ValueError, match="must be a radius or a geom"):
        Contact(model, data, tool=model.body("hand"), **law)
    with Contact(model, data, tool=model.geom("tip"), **law) as contact:
        assert list(contact.devices) == ["tip"]
    assert Contact(model, data, tool=0, **law).steps == 1


def test_the_engine_gets_its_own_contacts_of_the_tool_back() -> None:
    tip = '<body name="hand" mocap="true"><geom name="tip" type="sphere" size="0.01" contype="2" conaffinity="3"/></body>'
    model, data = load(BLOCK + tip)
    law: dict[str, Any] = {"tool": "tip", "bodies": ["block"], "stiffness": 100.0, "device_mass": 0.2}
    geom = model.geom("tip")
    bits = lambda: (int(geom.contype[0]), int(geom.conaffinity[0]))  # noqa: E731
    with Contact(model, data, **law) as contact:
        assert bits() == (0, 0)
        other = Contact(model, data, **law)
    assert bits() == (0, 0)
    with pytest.raises(ValueError, match="closed"):
        contact.sample([0.0, 0.0, 0.0])
    other.close()
    other.close()
    assert bits() == (2, 3)
    pushing = Contact(model, data, **law)
    pushing.sample([1.0, 2.0, 3.0])
    pushing.push()
    pushing.close()
    assert bits() == (2, 3) and not data.xfrc_applied.any()
    gone = Contact(model, data, **law)
    assert bits() == (0, 0)
    del gone
    assert bits() == (2, 3)


def test_other_geoms_of_the_tools_body_are_warned_of() -> None:
    hand = (
        '<body name="hand" mocap="true"><geom name="tip" type="sphere" size="0.01"/><geom name="handle" type="capsule" size="0.01 0.05" '
        '{bits}/></body>'
    )
    law: dict[str, Any] = {"tool": "tip", "bodies": ["block"], "stiffness": 100.0, "device_mass": 0.2}
    model, data = load(BLOCK + hand.format(bits=""))
    with pytest.warns(UserWarning, match="geom 'handle': on the tool's mocap body.*without a force on the device"):
        Contact(model, data, **law)
    model, data = load(BLOCK + hand.format(bits='contype="0" conaffinity="0"'))
    Contact(model, data, **law)
