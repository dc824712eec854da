"""Studies, and recordings that were read."""

from __future__ import annotations

import csv
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import palpate
from conftest import ROOT

FIG2 = "experiments/fig2.toml"
RECORDINGS = "crates/palpate-record/tests/recording"


def test_a_sweep_is_that_of_the_program(program: Any, root: Path) -> None:
    theirs = program.json("sweep", FIG2, "--over", "damping", "--values", "0.1,0.5", "--method", "hfcr,virtual-damper")
    ours = palpate.sweep(FIG2, "damping", [0.1, 0.5], ["hfcr", "virtual-damper"])
    assert ours == theirs and str(ours)
    usual = palpate.sweep(FIG2, "damping", [0.1])
    assert usual == program.json("sweep", FIG2, "--over", "damping", "--values", "0.1")
    pantograph = "experiments/fig5.toml"
    arguments = ("sweep", pantograph, "--over", "friction", "--values", "1", "--method", "basic")
    assert palpate.sweep(pantograph, "friction", np.float32(1), "basic") == program.json(*arguments)
    for wrong, words in [
        ({"over": "mess"}, 'over is "mess", but must be one of "stiffness", "mass", "friction", "box", "damping"'),
        ({"values": []}, "values is empty"),
        ({"method": "basic"}, "experiments/fig2.toml: column basic: its method has no damping to vary"),
        ({"values": [-1.0]}, "experiments/fig2.toml:"),
        ({"over": "box"}, "experiments/fig2.toml:"),
    ]:
        given: dict[str, Any] = {"over": "damping", "values": [0.1], "method": "hfcr", **wrong}
        with pytest.raises(ValueError) as raised:
            palpate.sweep(FIG2, **given)
        assert str(raised.value).startswith(words), str(raised.value)


def test_the_paper_s_claims_are_those_of_the_program(program: Any) -> None:
    ours = palpate.claims()
    assert ours == program.json("paper", "claims")
    assert ours.format == "palpate claims 1" and len(ours.claims) > 5
    # Comparing the program's own text would need a third run.
    assert all(claim.name in str(ours) for claim in ours.claims)


def test_a_damping_is_tuned_as_by_the_program(program: Any, root: Path) -> None:
    theirs = program.json("tune", FIG2, "--method", "virtual-damper", "--steps", 7)
    ours = palpate.tune(FIG2, "virtual-damper", steps=7)
    assert ours == theirs and len(ours.curve) == 7
    cap = program.json("tune", FIG2, "--method", "popc-ref", "--steps", 4, "--least", "leak")
    assert palpate.tune(FIG2, "popc-ref", steps=4, least="leak") == cap
    named = palpate.tune(FIG2, "hfcr", values=np.array([0.0, 0.5], dtype=np.float32))
    assert [point.value_n_s_per_m for point in named.curve] == [0.0, 0.5]
    for wrong, words in [
        ({"method": "basic"}, "basic has no damping to tune"),
        ({"method": ["hfcr", "popc"]}, "tune evaluates one method"),
        ({"method": "hfcr", "least": "noise"}, 'least is "noise", but must be "error" or "leak"'),
        ({"method": "hfcr", "steps": 1}, "steps is 1, but must be 2 or more"),
        ({"method": "hfcr", "values": []}, "values is empty"),
        ({"method": "hfcr", "values": [-1.0]}, "experiments/fig2.toml:"),
    ]:
        with pytest.raises(ValueError) as raised:
            palpate.tune(FIG2, **wrong)
        assert str(raised.value).startswith(words)


def test_start_heights_match_the_cli(program: Any, root: Path) -> None:
    theirs = program.json("paper", "heights", FIG2, "--method", "basic,coupled", "--model-mass-factor", 1.5)
    assert palpate.heights(FIG2, ["basic", "coupled"], model_mass_factor=1.5) == theirs
    with pytest.raises(ValueError, match="model_mass_factor is 0, but must be finite and greater than 0"):
        palpate.heights(FIG2, model_mass_factor=0)


def test_suite_of_random_plants_matches_the_cli(program: Any, root: Path) -> None:
    for name in ("paper", "desk"):
        theirs = program.json("suite", "--set", name, "--plants", 3, "--method", "hfcr,coupled")
        assert palpate.suite(name, ["hfcr", "coupled"], plants=3) == theirs
    other = program.json("suite", "--plants", 2, "--seed", 7, "--method", "basic")
    assert palpate.suite(method="basic", plants=2, seed=7) == other
    for wrong, words in [
        ({"set": "moon"}, 'set is "moon", but must be'),
        ({"plants": 0}, "plants is 0, but must be 1 to 1000000"),
        ({"plants": 10**12}, "plants is 1000000000000, but must be 1 to 1000000"),
    ]:
        with pytest.raises(ValueError, match=words):
            palpate.suite(**wrong)


def test_a_recording_is_read_as_by_the_program(program: Any, root: Path, tmp_path: Path) -> None:
    recording = f"{RECORDINGS}/golden.mcap"
    ours = palpate.read_recording(recording)
    # The recording has no count of the ticks, which the program reports by its exit code.
    assert ours == program.json("info", recording, code=4)
    out = tmp_path / "ticks.csv"
    program("convert", recording, "--out", out, code=4)
    with out.open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    assert len(rows) == len(ours.ticks) == ours["ticks"] > 0
    compared = 0
    for name in (name for name in palpate.RECORDED.names or () if name in rows[0]):
        cells = [row[name] for row in rows]
        match name:
            case "phase":
                found = [palpate.PHASES[code] for code in ours.ticks[name]]
                assert found == cells
            case "flags":
                found = [
                    " ".join(flag for bit, flag in enumerate(palpate.FLAGS) if int(code) >> bit & 1)
                    for code in ours.ticks[name]
                ]
                assert found == cells
            case _:
                numbers = [float(cell) if cell else np.nan for cell in cells]
                np.testing.assert_array_equal(ours.ticks[name].astype(float), numbers, name)
        compared += 1
    assert compared == 44
    assert ours.texts and ours.events[0].kind in ours["events"]
    again = pickle.loads(pickle.dumps(ours))
    assert again == ours and again.events == ours.events and again.texts == ours.texts
    assert again.ticks.tobytes() == ours.ticks.tobytes() and again.ticks.dtype == palpate.RECORDED


def test_what_is_no_recording_is_refused(root: Path, tmp_path: Path) -> None:
    with pytest.raises(OSError, match="none.mcap"):
        palpate.read_recording(tmp_path / "none.mcap")
    with pytest.raises(ValueError, match="fig2.toml"):
        palpate.read_recording(ROOT / FIG2)
