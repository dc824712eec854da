"""`Scene`, `simulate` and `compare`."""

from __future__ import annotations

import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import palpate
from conftest import ROOT

SCENES = sorted(path.relative_to(ROOT).as_posix() for path in (ROOT / "experiments").glob("*.toml"))
USERS = sorted(path.relative_to(ROOT).as_posix() for path in (ROOT / "experiments/users").glob("*.toml"))


DEVICE: dict[str, Any] = {"name": "device", "axes": ["x"], "mass_kg": 0.25, "hand": {"force_n": [np.float32(1.0), 0, 0]}}
BLOCK: dict[str, Any] = {
    "name": "block",
    "axes": ["x"],
    "mass_kg": 0.1,
    "position_m": [0.01, 0, 0],
    "force_n": [-0.981, 0, 0],
    "shape": {"half_space": {"normal": [-1, 0, 0]}},
}
LAW: dict[str, Any] = {"between": ["device", "block"], "stiffness_n_per_m": 400}


def light_block(**changes: Any) -> palpate.Scene:
    tables: dict[str, Any] = {
        "loop": {"period_s": 0.01},
        "device": DEVICE,
        "body": BLOCK,
        "contact": LAW,
        "measure": {"duration_s": 1},
    }
    return palpate.Scene("A light block", **{**tables, **changes})


@pytest.mark.parametrize("scene", SCENES)
def test_a_scene_gives_the_numbers_of_the_program_to_the_last_bit(program: Any, root: Path, scene: str) -> None:
    own = palpate.Scene.read(Path(scene))
    # The reference solution of a linkage takes a second for each run and program, so run one method only.
    method = own.method if "linkage" in own.to_dict()["device"][0] else "all"
    theirs = program.json("simulate", scene, "--method", method)
    assert palpate.simulate(scene, method=method) == theirs


def test_a_scene_is_run_by_its_own_method_and_said_in_the_words_of_the_program(program: Any, root: Path) -> None:
    ours = palpate.simulate("experiments/fig2.toml")
    assert ours == program.json("simulate", "experiments/fig2.toml")
    assert [*ours.ticks] == [palpate.Scene.read("experiments/fig2.toml").method]
    assert str(ours).strip() == repr(ours).strip() == program("simulate", "experiments/fig2.toml").strip()


def test_ticks_of_a_scene_are_those_of_the_program(program: Any, root: Path, tmp_path: Path) -> None:
    out = tmp_path / "run.csv"
    program("simulate", "experiments/fig2.toml", "--method", "coupled", "--out", out)
    lines = [line for line in out.read_text().splitlines() if not line.startswith("#")]
    place = lines[0].split(",").index("force_on_device_n")
    written = [float(line.split(",")[place]) for line in lines[1:]]
    run = palpate.simulate("experiments/fig2.toml", method=["coupled"])
    assert run.ticks["coupled"]["force_on_device_n"].tolist() == written
    assert run.ideal["t_s"][0] == 0.0 and run.ideal["force_on_object_n"].max() > 1.0


def test_scenes_are_compared_as_by_the_program(program: Any, root: Path) -> None:
    # In one scene `coupled` and other methods cannot be set up or diverge.
    scenes = [*USERS[:4], "experiments/fig2.toml"]
    theirs = program.json("compare", *scenes)
    assert palpate.compare(scenes) == theirs
    one = palpate.compare(Path(scenes[0]), method="basic")
    assert one.scenes[0].methods[0].method == "basic" and len(one.scenes) == 1
    assert str(one).strip() == program("compare", scenes[0], "--method", "basic").strip()
    assert palpate.compare([light_block()], method="basic").scenes[0].scene == "A light block"
    with pytest.raises(ValueError, match="scenes is empty, but must have 1 scene or more"):
        palpate.compare([])


def test_a_scene_of_python_is_that_of_its_file(program: Any, tmp_path: Path) -> None:
    scene = light_block(methods={"hfcr": {"damping_n_s_per_m": 0.5}}, render={"method": "hfcr", "unilateral": True})
    path = tmp_path / "scene.toml"
    path.write_text(scene.to_toml())
    ours = palpate.simulate(scene, method=["hfcr", "coupled"])
    assert ours == program.json("simulate", path, "--method", "hfcr,coupled")
    assert ours.unilateral is True and ours.method("hfcr").parameters.damping_n_s_per_m == 0.5
    assert scene.method == "hfcr" and palpate.Scene.read(path).to_dict() == scene.to_dict()
    wall = scene.replace(body={"fixed": True, "axes": None, "mass_kg": None, "force_n": None}, loop={"period_s": 0.002})
    assert wall.to_dict()["body"] == [{"name": "block", "fixed": True, "position_m": [0.01, 0, 0], "shape": BLOCK["shape"]}]
    assert palpate.simulate(wall).object_mass_kg == "inf" and wall.title == scene.title


def test_a_table_is_an_array_of_one_and_changes_by_key() -> None:
    scene = light_block()
    assert light_block(device=[DEVICE], body=(BLOCK,), contact=[LAW]) == scene
    assert "[[device]]" in scene.to_toml() and scene.to_toml().startswith("format = 2\n")
    stiffer = scene.replace(contact={"stiffness_n_per_m": 800.0}, device={"hand": {"release_s": 0.3}})
    assert stiffer.to_dict()["contact"] == [{**LAW, "stiffness_n_per_m": 800.0}]
    assert stiffer.to_dict()["device"][0]["hand"] == {"force_n": [1.0, 0, 0], "release_s": 0.3}
    assert stiffer.replace(contact=[LAW], device=[DEVICE]) == scene
    rubbed = scene.replace(device={"drivetrain": {"viscous_friction_n_s_per_m": 0.2}})
    assert rubbed.to_dict()["device"][0]["drivetrain"] == {"viscous_friction_n_s_per_m": 0.2}
    walls = [{"name": name, "fixed": True, "shape": BLOCK["shape"]} for name in ("block", "other")]
    with pytest.raises(ValueError, match="^one contact along one axis is needed here, but the scene has 2 bodies$"):
        scene.replace(body=walls)
    assert scene.replace(body=walls[:1]).to_dict()["body"] == walls[:1]


def test_what_a_scene_names_is_looked_for_in_its_folder(program: Any, root: Path) -> None:
    [named] = [scene for scene in USERS if "hand_intention.csv" in (ROOT / scene).read_text()]
    read = palpate.Scene.read(named)
    assert palpate.simulate(read, method="basic") == program.json("simulate", named, "--method", "basic")
    again = palpate.Scene.parse(read.to_toml(), folder="experiments/users")
    assert palpate.simulate(again, method="basic") == palpate.simulate(read, method="basic")
    assert palpate.simulate(read.replace(loop={"period_s": 0.004}), method="basic").period_s == 0.004
    with pytest.raises(ValueError, match="hand_intention.csv"):
        palpate.Scene.parse(read.to_toml())


def test_every_fault_is_said_by_its_key() -> None:
    with pytest.raises(ValueError) as raised:
        light_block(body={**BLOCK, "mass_kg": -1, "colour": "red"}, contact={**LAW, "stiffness_n_per_m": math.nan})
    said = str(raised.value).splitlines()
    assert "body.mass_kg is -1 kg, but must be finite and greater than 0" in said
    assert "contact.stiffness_n_per_m is NaN N/m, but must be finite and greater than 0" in said
    assert any(line.startswith("body[0].colour: unknown key colour") for line in said), said
    with pytest.raises(ValueError, match=r"^device.hand.force_n is \[?1"):
        light_block(device={**DEVICE, "hand": {"force_n": [1, 1, 0]}})
    with pytest.raises(ValueError, match="the key shape is missing"):
        light_block(body={"name": "block", "mass_kg": 1})
    with pytest.raises(TypeError, match=r"scene.body.mass_kg is <object object at .*>, but must be a number"):
        light_block(body={"mass_kg": object()})
    with pytest.raises(TypeError, match="scene.body: a key must be a text"):
        light_block(body={1: 2})
    with pytest.raises(TypeError, match="device"):
        palpate.Scene("a", loop={}, body={}, contact={})  # type: ignore[call-arg]


def test_a_fault_of_a_file_has_its_place(tmp_path: Path) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text(light_block().to_toml().replace("mass_kg = 0.25", "mass_kg = 0"))
    with pytest.raises(ValueError, match=r"wrong.toml:\d+:\d+: device.mass_kg is 0 kg, but must be"):
        palpate.simulate(path)
    with pytest.raises(FileNotFoundError):
        palpate.simulate(tmp_path / "none.toml")
    path.write_bytes(b"\xff")
    with pytest.raises(ValueError, match="not UTF-8"):
        palpate.simulate(path)
    with pytest.raises(TypeError):
        palpate.simulate(3)  # type: ignore[arg-type]


def test_a_scene_that_cannot_be_run_says_why() -> None:
    with pytest.raises(ValueError, match="^the window has [0-9e]+ periods; at most 2000000 fit$"):
        palpate.simulate(light_block(measure={"duration_s": 1e9}))
    # The object flies away from the device and touches it at most once.
    away = {**BLOCK, "force_n": None, "velocity_m_per_s": [-1.0, 0, 0]}
    with pytest.raises(ValueError, match="requires 50 collisions, but the ideal has only"):
        palpate.simulate(light_block(measure={"collisions": 50}, device={**DEVICE, "hand": None}, body=away))
    with pytest.raises(ValueError, match='no method is called "hfc"'):
        palpate.simulate(light_block(), method="hfc")


def test_scenes_and_reports_are_pickled() -> None:
    scene = light_block()
    again = pickle.loads(pickle.dumps(scene))
    assert again == scene and hash(again) == hash(scene) and repr(again) == "<palpate.Scene 'A light block'>"
    assert again != scene.replace("Another") and type(again) is palpate.Scene
    report = palpate.compare([scene], method="basic")
    again = pickle.loads(pickle.dumps(report))
    assert again == report and str(again) == str(report) and type(again) is palpate.Report
    assert again.to_json() == report.to_json()


def test_a_table_that_contains_itself_is_refused_by_its_place() -> None:
    itself: dict[str, Any] = {}
    itself["x"] = itself
    deep: Any = 0.0
    for _ in range(50_000):
        deep = [deep]
    rows: list[Any] = []
    rows.append(rows)
    for given, place in (({"body": itself}, "scene.body.x.x"), ({"body": {"mass_kg": deep}}, "scene.body.mass_kg")):
        tables: dict[str, Any] = {"loop": {}, "device": {}, "body": {}, "contact": {}, **given}
        with pytest.raises(ValueError, match=f"{place} has tables or lists nested more than 32 deep"):
            palpate.Scene("itself", **tables)
    with pytest.raises(ValueError, match="more than 32 deep, for example one that contains itself"):
        palpate.World(bodies=[{"name": rows}])
    # Free each list before the next: freeing nested lists is recursive, too.
    while isinstance(deep, list):
        deep = deep.pop()


def test_a_world_is_no_scene(root: Path) -> None:
    world = "experiments/worlds/paddle.toml"
    with pytest.raises(ValueError, match=f"^{world}.*one contact along one axis is needed here, but the device has 3 axes$"):
        palpate.Scene.read(world)
    with pytest.raises(ValueError, match="one contact along one axis is needed here"):
        palpate.Scene.parse((ROOT / world).read_text())
    with pytest.raises(ValueError, match="one contact along one axis is needed here"):
        palpate.Bench(world)
    # One friction coefficient decides which renderer a scene has.
    scene = light_block().replace(body={"fixed": True, "axes": None, "mass_kg": None, "force_n": None})
    rough = scene.to_dict()
    rough["contact"] = [{**rough["contact"][0], "friction": 0.3, "friction_stiffness_n_per_m": 200.0}]
    with pytest.raises(ValueError, match="needed here, but the contact has friction$"):
        scene.replace(contact=rough["contact"])


def test_a_file_that_is_missing_is_named(tmp_path: Path) -> None:
    missing = tmp_path / "missing.toml"
    for read in (palpate.World, palpate.Scene.read, palpate.simulate):
        with pytest.raises(FileNotFoundError, match="missing.toml") as raised:
            read(missing)
        assert raised.value.filename == str(missing)
    with pytest.raises(IsADirectoryError, match=tmp_path.name):
        palpate.World(tmp_path)
