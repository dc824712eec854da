"""`World`, and worlds in `simulate`."""

from __future__ import annotations

import json
import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import palpate
from conftest import ROOT

WORLDS = ["paddle", "pinch", "groove-90-rough"]
PADDLE = "experiments/worlds/paddle.toml"


def ball(**changes: Any) -> palpate.World:
    tables: dict[str, Any] = {
        "loop": {"period_s": 0.001},
        "devices": [{"name": "tool", "mass_kg": 0.2, "tool": {"sphere": {"radius_m": 0.01}}}],
        "bodies": [{"name": "ball", "mass_kg": 0.1, "position_m": [0, 0, 0.039], "shape": {"sphere": {"radius_m": 0.03}}}],
        "contacts": [{"between": ["tool", "ball"], "stiffness_n_per_m": np.float32(2000.0)}],
        "force_limit": math.inf,
        "soft_start": 0,
    }
    return palpate.World(**{**tables, **changes})


@pytest.mark.parametrize("world", WORLDS)
def test_a_world_is_simulated_to_the_numbers_of_the_program(program: Any, root: Path, world: str) -> None:
    path = f"experiments/worlds/{world}.toml"
    ours = palpate.simulate(path, method="all")
    assert ours == program.json("simulate", path, "--method", "all")
    assert isinstance(ours, palpate.WorldRuns) and ours["format"] == "palpate world 1"
    again = palpate.simulate(palpate.World(path).replace(method="basic"))
    assert [*again.forces] == ["basic"]
    # E computed from the arrays equals that of the report, whose reference includes the part that a held force
    # cannot render.
    masses = np.array([device["mass_kg"] for device in palpate.World(path).to_dict()["device"]])[:, None, :]
    off, of = [np.sum(x**2 / masses) for x in (ours.forces["coupled"] - ours.ideal, ours.ideal)]
    model = ours.method("coupled").sum
    shown = 1 - (model.hold_bound_percent / 100) ** 2
    assert abs(100 * math.sqrt(shown * off / of) - model.mean_force_error_percent) < 1e-6
    assert ours.edges.shape == (ours.ideal.shape[1] + 1,)


@pytest.mark.parametrize("world", WORLDS)
@pytest.mark.parametrize("method", ["coupled", "basic"])
def test_a_world_answers_as_the_pipe_does(program: Any, root: Path, world: str, method: str) -> None:
    path = f"experiments/worlds/{world}.toml"
    own = palpate.World(path, method=method)
    start = np.array([device["position_m"] for device in own.to_dict()["device"]])
    ticks = np.arange(80)[:, None, None]
    # Move down into the groove.
    down = 2.5e-4 if "groove" in world else 2e-5
    motion = start + 1e-4 * np.sin(0.1 * ticks) * np.array([0.3, 0.2, 1.0]) - down * ticks
    lines = "".join(",".join(repr(x) for x in row) + "\n" for row in motion.reshape(80, -1).tolist())
    said = program("pipe", path, "--method", method, "--unit", "m", given=lines).splitlines()
    theirs = np.array([[float(x) for x in line.split(",")] for line in said[:80]])
    given = motion[:, 0] if len(start) == 1 else motion
    ours = np.array([own.step(position) for position in given])
    assert ours.reshape(80, -1).tolist() == theirs.tolist()
    assert np.abs(ours).max() > 0


@pytest.mark.parametrize("method", ["coupled", "basic"])
def test_a_device_of_six_axes_answers_as_the_pipe_does(program: Any, root: Path, tmp_path: Path, method: str) -> None:
    peg = "experiments/worlds/peg.toml"
    path = tmp_path / "peg.toml"
    path.write_text(Path(peg).read_text().replace("[render]", "[render]\ntorque_limit_n_m = 0.002"))
    own = palpate.World(peg, method=method, torque_limit=0.002)
    turn = 0.004 * np.sin(0.05 * np.arange(80))
    # Move down into the hole and tilt until the peg jams.
    place = np.array([0.00003, 0.0, 0.006]) + np.outer(np.arange(80), [0.0, 0.0, -1.1e-4])
    poses = np.column_stack([place, np.cos(turn / 2), np.sin(turn / 2), 0.8 * turn, np.zeros(80)])
    poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1)[:, None]
    lines = "".join(",".join(map(repr, row)) + "\n" for row in poses.tolist())
    said = program("pipe", path, "--method", method, "--unit", "m", given=lines).splitlines()
    theirs = [[float(x) for x in line.split(",")] for line in said[:80]]
    limited = set()
    ours = []
    for pose in poses:
        wrench = own.step(pose)
        assert wrench.shape == (6,) and own.output is not None
        limited |= set(own.output.limited)
        ours.append(wrench.tolist())
    assert ours == theirs
    torques = np.linalg.norm(np.array(ours)[:, 3:], axis=1)
    assert torques.max() == pytest.approx(0.002, rel=1e-9) and "torque" in limited
    state = own.devices["tool"].turn
    assert state is not None and state.orientation == pytest.approx(poses[-1, 3:], abs=1e-3)
    assert own.output is not None and own.output.forces.tolist() == [ours[-1]]
    # A reported wrench needs its torque.
    own.report_sent(np.zeros(6))
    for wrong in (np.zeros(3), np.zeros((2, 7))):
        with pytest.raises(ValueError, match=r"must have \(7,\): x, y, z, qw, qx, qy, qz of tool"):
            own.step(wrong)
    with pytest.raises(ValueError, match=r"must have \(6,\)"):
        own.report_sent(np.zeros(3))
    not_unit = own.step([*place[-1], 2.0, 0.0, 0.0, 0.0])
    assert not_unit.tolist() == [0.0] * 6 and own.output.fault is not None


def test_a_stylus_that_its_hand_turns_is_answered_with_a_force() -> None:
    stylus = palpate.World(ROOT / "experiments/worlds/stylus.toml", soft_start=0.0)
    most = 0.0
    for tick in range(100):
        half = -0.25 + 2e-3 * tick
        force = stylus.step([0.0, 0.0, 0.055, math.cos(half), 0.0, math.sin(half), 0.0])
        assert force.shape == (3,) and stylus.output is not None and stylus.output.fault is None
        most = max(most, float(force[2]))
    assert most > 1.0
    turn = stylus.devices["tool"].turn
    assert turn is not None and turn.torque.tolist() == [0.0] * 3 and turn.inertia is None
    stylus.report_sent(np.zeros(3))
    with pytest.raises(ValueError, match=r"must have \(3,\)"):
        stylus.report_sent(np.zeros(6))
    with pytest.raises(ValueError, match="gives_torque needs a device of six axes"):
        ball(devices=[{"name": "tool", "gives_torque": False, "mass_kg": 0.2, "tool": {"sphere": {"radius_m": 0.01}}}])


def test_rows_of_several_devices_are_poses_where_one_of_them_turns() -> None:
    tool = {"mass_kg": 0.2, "tool": {"sphere": {"radius_m": 0.01}}}
    devices = [{"name": "point", **tool}, {"name": "body", "inertia_kg_m2": [1e-4] * 3, "position_m": [0.1, 0, 0], **tool}]
    world = ball(devices=devices, contacts=[{"between": ["*", "ball"], "stiffness_n_per_m": 2000.0}])
    rows = [[0, 0, 0, math.nan, 0, 0, 0], [0.1, 0, 0, 1, 0, 0, 0]]
    for _ in range(3):
        wrenches = world.step(rows)
    assert wrenches.shape == (2, 6) and wrenches[0, 2] < 0 and (wrenches[:, 3:] == 0).all()
    assert world.output is not None and world.output.fault is None
    states = world.devices
    assert states["point"].turn is None and states["body"].turn is not None
    with pytest.raises(ValueError, match=r"must have \(2, 7\)"):
        world.step([[0, 0, 0], [0, 0, 0]])


@pytest.mark.parametrize(("name", "kind"), [("drawer", "slider"), ("lever", "hinge")])
def test_ledger_of_joint_closes(root: Path, name: str, kind: str) -> None:
    world = palpate.World(f"experiments/worlds/{name}.toml")
    assert [joint.kind for joint in world.ledger.joints] == [kind]
    start = np.array(world.to_dict()["device"][0]["position_m"])
    first = world.ledger.joints[0].stored
    towards = world.bodies[world.ledger.joints[0].between[0]].position - start
    for tick in range(150):
        world.step(start + towards * min(1.0, tick / 100))
    [joint] = world.ledger.joints
    assert joint.between[1] == "world" and joint.dissipated > 0
    turned_over = abs(joint.work) + joint.dissipated + joint.stored
    assert turned_over > 1e-9
    assert joint.stored == pytest.approx(first - joint.work - joint.dissipated + joint.step_error, abs=1e-9 * turned_over)
    # A world from tables has joints as a file does.
    again = palpate.World(
        **{key: world.to_dict()[table] for key, table in
           {"loop": "loop", "devices": "device", "bodies": "body", "contacts": "contact", "joints": "joint"}.items()}
    )
    assert [joint.kind for joint in again.ledger.joints] == [kind]


def test_ignored_triangles_are_counted() -> None:
    # 400 triangles meet at the centre of the plate.
    profile = [[0.0, -0.02], [0.02, -0.02], [0.02, 0.0], [0.0, 0.0]]
    plate = {"mesh": {"revolved": {"profile_m": profile, "segments": 400}}}
    world = ball(
        devices=[{"name": "tool", "mass_kg": 0.2, "tool": {"sphere": {"radius_m": 0.003}}}],
        bodies=[{"name": "plate", "fixed": True, "shape": plate}],
        contacts=[{"between": "*", "stiffness_n_per_m": 500.0}],
    )
    world.step((0.0, 0.0, 0.002))
    assert world.output is not None and world.output.effort.left_out > 100


def test_what_a_world_has_can_be_read_after_a_sample() -> None:
    world = ball()
    assert world.output is None and world.period == 0.001 and world.method == "coupled"
    assert [*world.devices] == ["tool"] and world.bodies["ball"].position.tolist() == [0, 0, 0.039]
    for _ in range(5):
        force = world.step((0.0, 0.0, 0.0))
    assert force.shape == (3,) and force.dtype == np.float64
    body, [contact] = world.bodies["ball"], world.contacts
    assert body.velocity[2] > 0 and body.orientation.tolist() == [1, 0, 0, 0] and (body.angular_velocity == 0).all()
    assert contact.between == ("tool", "ball") and contact.normal.tolist() == [0, 0, -1]
    output = world.output
    assert output is not None and output.fault is None and output.limited == () and output.effort.sub_steps >= 16
    ledger = world.ledger
    [entry] = ledger.contacts
    # The contact starts at a sample, so its stored energy starts at 0.
    assert abs(entry.stored - (entry.observed - entry.work - entry.dissipated + entry.step_error)) < 1e-12
    assert abs(entry.leak - (entry.held - entry.work_on_proxy)) < 1e-15 and entry.stored > 0
    assert abs(ledger.bodies["ball"].kinetic - 0.5 * 0.1 * body.velocity @ body.velocity) < 1e-15
    # The device did not move, so the work at its port is 0.
    assert ledger.devices["tool"].port_work == 0.0
    world.reset()
    assert world.output is None and world.bodies["ball"].velocity.tolist() == [0, 0, 0]


def test_forces_are_limited_as_the_pipe_limits_them() -> None:
    deep = ball(force_limit=None, soft_start=0.2)
    first = deep.step([0, 0, 0.03])
    assert np.linalg.norm(first) < 1 and deep.output is not None and "soft-start" in deep.output.limited
    at_once = ball(force_limit=5).step([0, 0, 0.02])
    assert abs(np.linalg.norm(at_once) - 5) < 1e-9
    assert np.linalg.norm(ball().step([0, 0, 0.02])) > 20


def test_a_sample_that_cannot_be_used_gives_no_force() -> None:
    world = ball()
    world.step([0, 0, 0])
    assert world.step([0, math.nan, 0]).tolist() == [0, 0, 0]
    assert world.output is not None and (world.output.fault, world.output.fault_device) == ("position-not-finite", "tool")
    assert world.output.fault in palpate.FAULTS
    assert world.step([0, 1e300, 0]).tolist() == [0, 0, 0]
    assert (world.output.fault, world.output.fault_device) == ("overflow", "tool")
    for wrong in ([0, 0], [[0, 0, 0], [0, 0, 0]], 0.0):
        with pytest.raises(ValueError, match="must have"):
            world.step(wrong)
    with pytest.raises(ValueError, match="device is 'other', but must be one of tool"):
        world.report_sent([0, 0, 0], "other")
    world.report_sent([0, 0, 0])


def test_a_line_hold_gives_the_slopes_of_the_pipe(program: Any, root: Path, tmp_path: Path) -> None:
    path = tmp_path / "groove.toml"
    text = (root / "experiments/worlds/groove-90-rough.toml").read_text()
    path.write_text(text.replace("period_s = 0.001\n", 'period_s = 0.001\nhold = "line"\n', 1))
    world = palpate.World(path)
    motion = np.array([[0.0, 0.0, 2e-4 - 4e-5 * tick] for tick in range(60)])
    lines = "".join(",".join(map(repr, row)) + "\n" for row in motion.tolist())
    said = program("pipe", path, "--unit", "m", "--columns", "force,slope", given=lines).splitlines()
    theirs = [[float(x) for x in line.split(",")] for line in said[:60]]
    ours = []
    for position in motion:
        force = world.step(position)
        assert world.output is not None
        ours.append([*force.tolist(), *world.output.slopes[0].tolist()])
    assert ours == theirs
    assert np.abs(np.array(ours)[:, 3:]).max() > 10.0
    world.report_sent([0.0, 0.0, 1.0], slope=[0.0, 0.0, 10.0])
    with pytest.raises(ValueError, match=r"slope has the shape \(1,\), but must have \(3,\)"):
        world.report_sent([0.0, 0.0, 1.0], slope=[1.0])
    assert ball().step([0, 0, 0.0]).shape == (3,)


def test_a_world_is_made_of_tables_step_by_step(root: Path) -> None:
    world = ball(title="two").add(
        bodies=({"name": "floor", "fixed": True, "shape": {"half_space": {"normal": [0, 0, 1], "offset_m": 0.0}}} for _ in [0]),
        contacts=[{"between": ["*", "floor"], "stiffness_n_per_m": 4000}],
    )
    assert [*world.bodies] == ["ball", "floor"] and len(world.contacts) == 3 and world.title == "two"
    read = palpate.World.parse(world.to_toml())
    assert read.to_dict() == world.to_dict() and repr(read) == "<palpate.World 'two' of tool: coupled>"
    slower = world.replace(loop={"period_s": 0.004, "delay_s": 0.001}, method="basic")
    assert slower.period == 0.004 and slower.method == "basic" and slower.title == "two"
    pinched = palpate.World("experiments/worlds/pinch.toml")
    assert pinched.step(np.zeros((2, 3), np.float32)).shape == (2, 3)
    with pytest.raises(TypeError, match="to_toml"):
        pickle.dumps(world)


def test_every_fault_of_a_world_is_said(root: Path, tmp_path: Path) -> None:
    with pytest.raises(ValueError) as raised:
        ball(loop={"period_s": -1}, contacts=[{"between": ["tool", "bal"], "stiffness_n_per_m": 0}])
    said = str(raised.value)
    for part in ["period_s is -1, and has to be above 0", '"bal" is neither a tool nor a body', "stiffness is 0, and has to be above 0"]:
        assert part in said
    path = tmp_path / "wrong.toml"
    path.write_text((ROOT / PADDLE).read_text().replace("mass_kg = 0.1\n", "mass_kg = 0.0\n"))
    for use in (palpate.World, palpate.simulate):
        with pytest.raises(ValueError, match=r"wrong.toml:\d+:\d+: body \"ball\": mass is 0"):
            use(path)
    with pytest.raises(ValueError, match='no method "pmi" for worlds'):
        palpate.World(PADDLE, method="pmi")
    with pytest.raises(ValueError, match="virtual-damper needs damping_n_s_per_m"):
        palpate.simulate(PADDLE, method=["basic", "virtual-damper"])
    with pytest.raises(TypeError, match="runs on scenes of one contact"):
        palpate.simulate(PADDLE, method=lambda now: 0.0)
    with pytest.raises(ValueError, match="path and title are given"):
        palpate.World(PADDLE, title="a")
    with pytest.raises(FileNotFoundError):
        palpate.World(tmp_path / "none.toml")


def test_a_report_of_a_world_can_be_kept_and_drawn(root: Path) -> None:
    rep = palpate.simulate(PADDLE)
    again = pickle.loads(pickle.dumps(rep))
    assert again == rep and (again.forces["coupled"] == rep.forces["coupled"]).all() and again.edges.tolist() == rep.edges.tolist()
    assert json.loads(rep.to_json())["methods"][0]["method"] == "coupled"
    assert "paddle" in str(rep) and str(again) == str(rep)
    # A notebook shows the figure of the program.
    assert again.to_svg() == rep.to_svg() and rep._repr_html_() is None
    for words in ("force x [N]", "penetration", "generated energy"):
        assert words in rep.to_svg(), words
    with pytest.raises(KeyError, match="there are coupled"):
        rep.method("basic")
    pytest.importorskip("matplotlib").use("agg")
    ax = rep.plot()
    assert [line.get_label() for line in ax.lines] == ["ideal, means", "coupled"]


def test_files_of_meshes_are_looked_for_beside_the_file_of_the_world(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def corner(size: float) -> str:
        corners = [(0, 0, 0), (size, 0, 0), (0, size, 0), (0, 0, size)]
        vertices = "".join(f"v {x} {y} {z}\n" for x, y, z in corners)
        return vertices + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"

    beside, elsewhere = tmp_path / "beside", tmp_path / "elsewhere"
    for folder, size in ((beside, 10.0), (elsewhere, 100.0)):
        folder.mkdir()
        (folder / "part.obj").write_text(corner(size))
    part = {"name": "part", "fixed": True, "shape": {"mesh": {"file": "part.obj", "unit": "mm"}}}
    away = {"name": "away", "fixed": True, "position_m": [1.0, 0, 0], "shape": {"sphere": {"radius_m": 0.01}}}
    law = {"between": "*", "stiffness_n_per_m": 2000.0}
    text = ball(bodies=[away], contacts=[law]).to_toml()
    text += '[[body]]\nname = "part"\nfixed = true\nshape = { mesh = { file = "part.obj", unit = "mm" } }\n'
    (beside / "world.toml").write_text(text)
    # The working directory has a file of the same name, ten times larger.
    monkeypatch.chdir(elsewhere)
    world = palpate.World(beside / "world.toml", soft_start=0)
    outside = [0.02, 0.02, -0.005]
    for same in (
        world,
        world.replace(title="same"),
        world.add(bodies=[{**part, "name": "far", "position_m": [2.0, 0, 0]}]),
        palpate.World.parse(world.to_toml(), folder=beside),
        world.replace(method="basic").replace(method="coupled"),
    ):
        assert (same.step(outside) == 0).all()
    assert (palpate.World.parse(world.to_toml(), folder=elsewhere).replace(soft_start=0).step(outside) != 0).any()
    assert isinstance(palpate.simulate(beside / "world.toml", "basic"), palpate.WorldRuns)


def test_a_force_that_was_sent_is_finite() -> None:
    world = ball()
    world.step([0, 0, 0.0])
    with pytest.raises(ValueError, match=r"force\[2\] is nan, but must be finite"):
        world.report_sent([0.0, 0.0, math.nan])


def test_what_is_wrong_with_tables_is_said_with_its_place() -> None:
    tables: dict[str, Any] = {
        "loop": {"period_s": 0.001},
        "devices": [{"name": "tool", "mass_kg": 0.2, "tool": {"sphere": {"radius_m": 0.01}}}],
        "bodies": [
            {"name": "ball", "mass_kg": 0.1, "shape": {"sphere": {"radius_m": 0.03}}},
            {"name": "cube", "mass_kg": 0.1, "position_m": [0.1, 0, 0], "shape": {"sphere": {"radius_m": "0.03"}}},
        ],
        "contacts": [{"between": ["tool", "ball"], "stiffness_n_per_m": 2000.0}],
    }
    for changed, said in [
        ({}, r'^body\[1\].shape.sphere.radius_m: invalid type: string "0.03", expected a number$'),
        ({"bodies": [], "loop": {"period_s": "a"}}, r'^loop.period_s: invalid type: string "a", expected a number'),
        ({"bodies": [], "loop": {}}, "^loop: the key period_s is missing"),
        ({"contacts": [{"between": ["tool", "ball"], "stiffness_n_per_m": 10**30}]}, "stiffness_n_per_m is a whole number of more than 64 bits"),
    ]:
        with pytest.raises(ValueError, match=said):
            palpate.World(**{**tables, **changed})
