"""`calibrate` and `report`: what is known of a device, and the page about it."""

from __future__ import annotations

import json
import pickle
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import palpate

SHORT = {"period": 0.002, "duration": 3.0, "largest_force": 0.4, "seed": 3}
FLAGS = ["--period", 0.002, "--seconds", 3, "--largest-force", 0.4, "--seed", 3]
MASS = 0.2


def shaken(excitation: palpate.Excitation, mass: float = MASS, period: float = 0.002, delay: int = 1) -> None:
    """Shakes a mass whose motor answers so many samples late, with a sensor of 10 um."""
    position = velocity = 0.0
    commands = [0.0] * (delay + 1)
    while not excitation.done:
        commands.append(excitation.step(round(position / 1e-5) * 1e-5))
        # A weak spring keeps the mass in position.
        acceleration = (commands[-1 - delay] - 20.0 * position - 0.5 * velocity) / mass
        position += period * velocity + 0.5 * period**2 * acceleration
        velocity += period * acceleration


@pytest.fixture(scope="module")
def found() -> palpate.Calibration:
    excitation = palpate.Excitation(**SHORT)
    shaken(excitation)
    return palpate.calibrate(excitation)


def without_origin(text: str) -> list[str]:
    """The lines of a device file but for those that say what found it, and when."""
    return [line for line in text.splitlines() if not line.startswith(("command", "date"))]


def test_an_excitation_and_its_fit_are_those_of_the_program(program: Any, tmp_path: Path) -> None:
    excitation = palpate.Excitation(**SHORT)
    assert not excitation.done and len(excitation) == 1500
    shaken(excitation)
    positions, forces = excitation.motion.T
    assert excitation.done and len(positions) == 1500 and np.abs(forces).max() == 0.4 and forces[-1] == 0.0
    found = palpate.calibrate(excitation)
    files = [tmp_path / name for name in ("device.toml", "report.json", "device.svg")]
    given = "".join(f"{position!r}\n" for position in positions.tolist())
    answers = program(
        "calibrate", "--pipe", *FLAGS, "--out", files[0], "--report", files[1], "--plot", files[2], given=given
    )
    assert [float(line) for line in answers.split()] == forces.tolist()
    assert without_origin(found.to_toml()) == without_origin(files[0].read_text())
    assert found.to_svg() == files[2].read_text() == found._repr_svg_()
    ours, theirs = json.loads(found.to_report()), json.loads(files[1].read_text())
    for report in (ours, theirs):
        for key in ("fit_s", "wrote"):
            report.pop(key)
    assert ours == theirs
    mass, late = found.found["device_mass_kg"], found.found["delay_plus_lag_s"]
    assert abs(mass.value - MASS) < 3 * mass.standard_deviation < 0.01 * MASS
    assert abs(late.value - 0.002) < 3 * late.standard_deviation < 0.001
    again = pickle.loads(pickle.dumps(found))
    assert again == found and again.to_toml() == found.to_toml() and again.to_svg() == found.to_svg()


def test_the_device_of_a_scene_is_calibrated_in_simulated_time(program: Any, root: Path) -> None:
    scene = palpate.Scene.read("experiments/experiment1.toml").replace(
        device={"mass_kg": 0.3, "quantum_m": 1e-5}, loop={"period_s": 0.002}
    )
    found = palpate.calibrate(scene, duration=3.0)
    assert abs(found.found["device_mass_kg"].value - 0.3) < 0.003
    assert found.samples == 1500 and found.found["period_s"].value == 0.002
    assert "no resonance found" in str(found) and "simulated device" in found.to_toml()


def test_the_gain_follows_from_a_known_mass(found: palpate.Calibration, tmp_path: Path) -> None:
    heavier = palpate.Excitation(**SHORT)
    shaken(heavier, MASS + 0.1)
    before = tmp_path / "before.toml"
    before.write_text(found.to_toml())
    for earlier in (found, before):
        known = palpate.calibrate(heavier, added_mass=0.1, before=earlier).found
        assert abs(known["gain"].value - 1.0) < 0.05
    doubled = palpate.calibrate(heavier, gain=2.0).found
    once = palpate.calibrate(heavier).found["device_mass_kg"].value
    assert doubled["device_mass_kg"].value == pytest.approx(2.0 * once, rel=1e-4)


def test_what_is_no_calibration_says_why(found: palpate.Calibration, root: Path) -> None:
    dead, begun, complete = (palpate.Excitation(**SHORT) for _ in range(3))
    shaken(complete)
    steps = 0
    with pytest.raises(ValueError, match="the device did not follow the commands: the position did not change for"):
        while not dead.done:
            dead.step(0.0)
            steps += 1
    assert steps < 1000
    begun.step(0.0)
    shaking = palpate.Excitation(**SHORT)
    with pytest.raises(ValueError, match="the device went 20.0 mm from where it started, and 10.0 mm are allowed"):
        shaking.step(0.0)
        shaking.step(0.02)
    with pytest.raises(ValueError, match="stopped"):
        shaking.step(0.0)
    timed = palpate.Excitation(**SHORT)
    timed.step(0.0, 1.0)
    for call, said in [
        (lambda: palpate.calibrate(dead), "samples; it must be complete"),
        (lambda: palpate.calibrate(begun), "the excitation has 1 of 1500 samples; it must be complete"),
        (lambda: palpate.calibrate(shaking), "samples; it must be complete"),
        (lambda: palpate.Excitation(period=1.0), "the period is 1 s, but must be 0.0001 to 0.02 s"),
        (lambda: palpate.calibrate(begun, gain=0), "it must be complete"),
        (lambda: palpate.calibrate(complete, gain=0), "gain is 0, but must be finite and greater than 0"),
        (lambda: timed.step(0.0, 1.0), "time is 1 s, but must be after that of the last sample, 1 s"),
    ]:
        with pytest.raises(ValueError, match=said):
            call()
    with pytest.raises(TypeError, match="seed: an excitation that is done cannot be changed"):
        palpate.calibrate(complete, seed=2)
    with pytest.raises(TypeError, match="one of gain, spring, or added_mass with before"):
        palpate.calibrate(complete, added_mass=0.1)


def test_a_report_is_that_of_the_program(program: Any, found: palpate.Calibration, tmp_path: Path) -> None:
    device, run, out = (tmp_path / name for name in ("device.toml", "report.json", "page.html"))
    device.write_text(found.to_toml())
    run.write_text(found.to_report())
    flags = ["--device-file", device, "--calibration", run, "--method", "basic", "--stiffness", 500]
    theirs = program.json("report", *flags, "--name", "A mass", "--out", out)
    ours = palpate.report(device_file=device, calibration=run, method="basic", stiffness=500.0, name="A mass")
    theirs.pop("files")
    made = ours["made"], theirs["made"]
    for report in (ours, theirs):
        report.pop("made")
        report["reach"].pop("computed_in_s")
    assert ours == theirs
    # Ignore the computing time of the map.
    pages = (re.sub(r"in [0-9.]+ s; kappa", "", page) for page in (ours.to_html(), out.read_text(encoding="utf-8")))
    assert next(pages).replace(made[0], made[1]) == next(pages)
    assert "A mass" in ours.to_html() and ours.calibration.motion.t_s
    again = pickle.loads(pickle.dumps(ours))
    assert again == ours and again.to_html() == ours.to_html()


def test_a_report_has_recordings_and_a_calibration_that_was_just_made(
    found: palpate.Calibration, root: Path, tmp_path: Path
) -> None:
    recording = "crates/palpate-record/tests/recording/golden.mcap"
    page = palpate.report(recording, device_file=found, method="basic")
    assert page.timing and "Recording golden.mcap" in page.obtained[0] and page._repr_html_().startswith("<pre>")
    mass = found.found["device_mass_kg"]
    assert any(one.key == "device_mass_kg" and one.value == mass.value for one in page.calibration.found)
    assert page.calibration.motion.measured_m
    for call, kind, said in [
        (lambda: palpate.report(), TypeError, "a report needs a source: a recording, or device_file"),
        (lambda: palpate.report([recording] * 4), ValueError, "4 recordings are given, but a page has room for 3"),
        (lambda: palpate.report(recording, period=0), ValueError, "period is 0, but must be finite and greater than 0"),
        (lambda: palpate.report("experiments/fig2.toml"), ValueError, "fig2.toml"),
        (lambda: palpate.report(tmp_path / "none.mcap"), OSError, "none.mcap"),
        (lambda: palpate.report(device_file=tmp_path / "none.toml"), OSError, "none.toml"),
    ]:
        with pytest.raises(kind, match=said):
            call()
