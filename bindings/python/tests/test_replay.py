"""`replay` of recordings, by the numbers of the program."""

from __future__ import annotations

import pickle
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import palpate
from conftest import ROOT

SCENE = "experiments/experiment1.toml"
WORLD = "experiments/worlds/paddle.toml"
HELD = {"hand_stiffness": 200.0, "hand_damping": 5.0}


@pytest.fixture(scope="module")
def tap(program: Any, tmp_path_factory: Any) -> Path:
    """A recording of one contact, made by the program without waiting."""
    path: Path = tmp_path_factory.mktemp("tap") / "tap.mcap"
    program("run", SCENE, "--record", path, "--fast", "--duration", 3, "--method", "hfcr")
    return path


@pytest.fixture(scope="module")
def world(program: Any, tmp_path_factory: Any) -> Path:
    """A recording of a world."""
    path: Path = tmp_path_factory.mktemp("world") / "world.mcap"
    program("run", WORLD, "--record", path, "--fast", "--duration", 0.3)
    return path


@pytest.mark.parametrize(
    ("flags", "arguments"),
    [
        ([], {}),
        (["--method", "all"], {"method": "all"}),
        (["--method", "basic,coupled", "--from", 0.5, "--to", 1.5], {"method": ["basic", "coupled"], "begin": 0.5, "end": 1.5}),
        (
            ["--method", "virtual-damper", "--damping", 0.5, "--stiffness", 300, "--mass", "inf", "--force-limit", 2],
            {"method": "virtual-damper", "damping": 0.5, "stiffness": 300, "mass": np.inf, "force_limit": 2},
        ),
        (
            ["--method", "coupled", "--delay", 0.03, "--lag", 0.002, "--gain", 0.9, "--object-position", 0.04],
            {"method": "coupled", "delay": 0.03, "lag": 0.002, "gain": 0.9, "object_position": 0.04},
        ),
        (
            ["--method", "basic", "--delay", 0.02, "--unilateral", "--guard", "limit", "--guard-speed", 0.5],
            {"method": "basic", "delay": 0.02, "unilateral": True, "guard": "limit", "guard_speed": 0.5},
        ),
        (["--replay", "hand"], {"replay": "hand"}),
        (
            ["--replay", "hand", "--method", "basic,coupled", "--hand-stiffness", 200, "--hand-damping", 5],
            {"replay": "hand", "method": ["basic", "coupled"], **HELD},
        ),
        (
            ["--replay", "hand", "--hand-bandwidth", 20, "--device-mass", 0.3, "--model-device-mass", 0.2],
            {"replay": "hand", "hand_bandwidth": 20, "device_mass": 0.3, "model_device_mass": 0.2},
        ),
        (["--encoder-quantum", 1e-5, "--force", -0.5, "--object-velocity", 0.1], {"encoder_quantum": 1e-5, "force": -0.5, "object_velocity": 0.1}),
    ],
    ids=lambda value: " ".join(map(str, value)) if isinstance(value, list) else "",
)
def test_the_numbers_are_those_of_the_program(program: Any, tap: Path, flags: list[Any], arguments: Any) -> None:
    ours = palpate.replay(tap, **arguments)
    assert ours == program.json("replay", tap, *flags)
    assert str(ours).strip() == program("replay", tap, *flags).strip()


def test_ticks_and_figure_are_those_of_the_program(program: Any, tap: Path, tmp_path: Path) -> None:
    for number, replay in enumerate(("motion", "hand")):
        out, plot = tmp_path / f"{number}.csv", tmp_path / f"{number}.svg"
        program("replay", tap, "--method", "coupled", "--replay", replay, "--out", out, "--plot", plot)
        run = palpate.replay(str(tap), "coupled", replay=replay)
        lines = [line for line in out.read_text().splitlines() if not line.startswith("#")]
        place = lines[0].split(",").index("force_on_device_n")
        written = [float(line.split(",")[place]) for line in lines[1:]]
        assert run.ticks["coupled"]["force_on_device_n"].tolist() == written
        sent = pickle.loads(pickle.dumps(run))
        assert sent == run and sent.ideal.tobytes() == run.ideal.tobytes()
        assert sent.ticks["coupled"].tobytes() == run.ticks["coupled"].tobytes()
        assert sent._repr_svg_() == run.to_svg() == plot.read_text()
        assert run._repr_html_() is None


def test_a_replay_is_a_table_and_is_drawn(tap: Path) -> None:
    pandas, pyplot = pytest.importorskip("pandas"), pytest.importorskip("matplotlib.pyplot")
    run = palpate.replay(tap, ["basic", "coupled"], replay="hand", **HELD)
    table = run.to_pandas()
    assert isinstance(table, pandas.DataFrame) and set(table["method"]) == {"basic", "coupled"}
    assert run.replay.kind == "hand" and len(run.replay.largest_departure_m) == 2
    figure, ax = pyplot.subplots()
    assert run.plot(ax) is ax and {line.get_label() for line in ax.lines} == {"ideal", "basic", "coupled"}
    pyplot.close(figure)


def test_a_recording_that_was_read_is_replayed(program: Any, tap: Path) -> None:
    recording = palpate.read_recording(tap)
    ours = palpate.replay(recording, "coupled")
    assert ours == program.json("replay", tap, "--method", "coupled")
    assert ours.recording.file == str(tap) and ours.recording.recorded_method == "hfcr"
    # The recorded method reproduces the recorded force.
    again = palpate.replay(recording)
    assert [*again.ticks] == ["hfcr"]
    np.testing.assert_array_equal(again.ticks["hfcr"]["device_position_m"], recording.ticks["device_position_m"])


def test_the_motion_of_a_world_is_replayed(program: Any, world: Path) -> None:
    ours = palpate.replay(world, ["basic", "coupled"])
    assert isinstance(ours, palpate.WorldRuns)
    assert ours == program.json("replay", world, "--method", "basic,coupled")
    assert ours.forces["coupled"].shape == ours.ideal.shape == (1, len(ours.edges) - 1, 3)
    assert palpate.replay(palpate.read_recording(world)) == program.json("replay", world)
    for wrong in ({"stiffness": 100.0}, {"replay": "hand"}, {"begin": 0.1}, {"damping": 1.0}):
        with pytest.raises(ValueError, match=f"^{[*wrong][0]}: .* is a recording of a world"):
            palpate.replay(world, **wrong)
    with pytest.raises(ValueError, match="pmi"):
        palpate.replay(world, "pmi")


def test_a_recording_that_was_cut_off_is_replayed_and_said(program: Any, tap: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    whole = tap.read_bytes()
    cut.write_bytes(whole[: len(whole) * 2 // 3])
    with pytest.warns(UserWarning, match=r"cut\.mcap: not complete"):
        ours = palpate.replay(cut, "coupled")
    assert ours == program.json("replay", cut, "--method", "coupled", code=4)
    assert ours.recording.complete is False


@pytest.mark.parametrize("is_refused", [True, False], ids=["of the ideal", "of a method"])
def test_a_device_that_leaves_what_an_arm_reaches_is_said(program: Any, tap: Path, is_refused: bool) -> None:
    """What the program says of it is said in the same words: where even the ideal does, an error, and else a warning."""
    hand = ["--hand-stiffness", 0, "--hand-damping", 0] if is_refused else ["--hand-stiffness", 5, "--hand-damping", 0]
    given = {"hand_stiffness": hand[1], "hand_damping": 0}
    contact = {"force": -5.0} if is_refused else {"stiffness": 2000.0}
    flags = [word for name, value in contact.items() for word in (f"--{name}", value)]
    done = program.tried("replay", tap, "--replay", "hand", "--method", "basic", *hand, *flags)
    assert bool(done.returncode) == is_refused, done.stderr
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        if is_refused:
            with pytest.raises(ValueError) as raised:
                palpate.replay(tap, "basic", replay="hand", **given, **contact)
            model = str(raised.value)
        else:
            palpate.replay(tap, "basic", replay="hand", **given, **contact)
            (model,) = (str(one.message) for one in said)
    theirs = done.stderr.splitlines()[0].removeprefix("warning: ").removeprefix("error: ")
    for flag, argument in (
        ("--hand-stiffness 60 --hand-damping 2", "hand_stiffness=60, hand_damping=2"),
        ("--device-mass", "device_mass"),
    ):
        theirs = theirs.replace(flag, argument)
    assert model == theirs and "arm reaches" in model


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"stiffness": -1.0}, "stiffness is -1 N/m, but must be finite and greater than 0"),
        ({"mass": 0.0}, "mass is 0 kg, but must be "),
        ({"device_mass": 0.0}, "device_mass is 0 kg, but must be finite and greater than 0"),
        ({"model_device_mass": -1.0}, "model_device_mass is -1 kg, but must be finite and greater than 0"),
        ({"delay": -1.0}, "delay is -1 s, but must be finite and not below 0"),
        ({"lag": float("nan")}, "lag is NaN s, but must be"),
        ({"side": "left"}, 'side is "left", but must be "positive" or "negative"'),
        ({"guard": "on"}, 'guard is "on", but must be "off" or "report" or "limit"'),
        ({"guard_speed": 1.0}, "guard_speed, guard_allowance, guard_acceleration, guard_hand_force and guard_recovery need a guard; give guard"),
        ({"replay": "film"}, 'replay is "film", but must be "motion" or "hand"'),
        ({"hand_damping": 1.0}, 'hand_damping is for replay="hand"; replay="motion" has no hand model'),
        ({"replay": "hand", "hand_damping": -1.0}, "hand_damping is -1, but must be"),
        ({"begin": 1.0, "end": 1.0}, "begin is 1 s and end is 1 s, but the part must begin before it ends"),
        ({"begin": 100.0}, "the part between begin and end has 0 ticks, but needs at least 2"),
        ({"method": "virtual"}, "virtual"),
        ({"method": "basic", "damping": 1.0}, "damping cannot be used by method basic"),
        ({"method": "virtual-damper", "damping": -1.0}, "damping is -1 N s/m, but must be"),
    ],
)
def test_what_is_wrong_is_said_by_the_name_of_its_argument(tap: Path, arguments: Any, words: str) -> None:
    with pytest.raises(ValueError) as raised:
        palpate.replay(tap, **arguments)
    assert words in str(raised.value)


def test_what_is_no_recording_is_said(tap: Path, tmp_path: Path) -> None:
    with pytest.raises(OSError, match="none.mcap"):
        palpate.replay(tmp_path / "none.mcap")
    (tmp_path / "text.mcap").write_text("no recording")
    with pytest.raises(ValueError, match="text.mcap"):
        palpate.replay(tmp_path / "text.mcap")
    # Scenes of the old format are not read.
    plain = ROOT / "crates/palpate-record/tests/recording/golden.mcap"
    with pytest.raises(ValueError, match=r"golden.mcap \(scene\):1:\d+: the key scene_format is not read"):
        palpate.replay(plain)
    with pytest.raises(TypeError, match="no parameter is called stifness"):
        palpate.replay(tap, stifness=1.0)
