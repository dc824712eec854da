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


def light_block(**changes: Any) -> palpate.Scene:
    tables: dict[str, Any] = {
        "object": {"mass_kg": 0.1, "stiffness_n_per_m": 400, "position_m": 0.01, "force_n": -0.981},
        "device": {"kind": "point-mass", "mass_kg": 0.25},
        "hand": {"kind": "constant-force", "force_n": np.float32(1.0)},
        "loop": {"period_s": 0.01},
        "measure": {"duration_s": 1},
    }
    return palpate.Scene("A light block", **{**tables, **changes})


@pytest.mark.parametrize("scene", SCENES)
def test_a_scene_gives_the_numbers_of_the_program_to_the_last_bit(program: Any, root: Path, scene: str) -> None:
    own = palpate.Scene.read(Path(scene))
    # The reference solution of a linkage takes a second for each run and program, so run one method only.
    method = own.method if own.to_dict()["device"]["kind"] == "pantograph" else "all"
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
    scene = light_block(methods={"hfcr": {"damping_n_s_per_m": 0.5}}, renderer={"method": "hfcr", "unilateral": True})
    path = tmp_path / "scene.toml"
    path.write_text(scene.to_toml())
    ours = palpate.simulate(scene, method=["hfcr", "coupled"])
    assert ours == program.json("simulate", path, "--method", "hfcr,coupled")
    assert ours.unilateral is True and ours.method("hfcr").parameters.damping_n_s_per_m == 0.5
    assert scene.method == "hfcr" and palpate.Scene.read(path).to_dict() == scene.to_dict()
    wall = scene.replace(object={"mass_kg": math.inf, "force_n": None}, loop={"period_s": 0.002})
    assert wall.to_dict()["object"] == {"mass_kg": math.inf, "stiffness_n_per_m": 400, "position_m": 0.01}
    assert palpate.simulate(wall).object_mass_kg == "inf" and wall.title == scene.title


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
        light_block(object={"mass_kg": -1, "stiffness_n_per_m": math.nan, "position_m": 0, "colour": "red"})
    said = str(raised.value).splitlines()
    assert "object.mass_kg is -1 kg, but must be finite and greater than 0" in said
    assert "object.stiffness_n_per_m is NaN N/m, but must be finite and greater than 0" in said
    assert any(line.startswith("object.colour: unknown key colour") for line in said), said
    with pytest.raises(ValueError, match="the key position_m is missing"):
        light_block(object={"mass_kg": 1, "stiffness_n_per_m": 1})
    with pytest.raises(TypeError, match=r"scene.object.mass_kg is <object object at .*>, but must be a number"):
        light_block(object={"mass_kg": object()})
    with pytest.raises(TypeError, match="scene.object: a key must be a text"):
        light_block(object={1: 2})
    with pytest.raises(TypeError, match="device"):
        palpate.Scene("a", object={}, loop={}, measure={})  # type: ignore[call-arg]


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
    away = {"mass_kg": 0.1, "stiffness_n_per_m": 400, "position_m": 0.01, "velocity_m_per_s": -1.0}
    with pytest.raises(ValueError, match="requires 50 collisions, but the ideal has only"):
        palpate.simulate(light_block(measure={"collisions": 50}, hand={"force_n": 0.0}, object=away))
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
    for given, place in (({"object": itself}, "scene.object.x.x"), ({"object": {"mass_kg": deep}}, "scene.object.mass_kg")):
        tables: dict[str, Any] = {"object": {}, "device": {}, "loop": {}, "measure": {}, **given}
        with pytest.raises(ValueError, match=f"{place} has tables or lists nested more than 32 deep"):
            palpate.Scene("itself", **tables)
    with pytest.raises(ValueError, match="more than 32 deep, for example one that contains itself"):
        palpate.World(bodies=[{"name": rows}])
    # Free each list before the next: freeing nested lists is recursive, too.
    while isinstance(deep, list):
        deep = deep.pop()


def test_a_file_that_is_missing_is_named(tmp_path: Path) -> None:
    missing = tmp_path / "missing.toml"
    for read in (palpate.World, palpate.Scene.read, palpate.simulate):
        with pytest.raises(FileNotFoundError, match="missing.toml") as raised:
            read(missing)
        assert raised.value.filename == str(missing)
    with pytest.raises(IsADirectoryError, match=tmp_path.name):
        palpate.World(tmp_path)
