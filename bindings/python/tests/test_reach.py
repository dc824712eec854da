"""`map`, `advise` and `Bench`."""

from __future__ import annotations

import math
import pickle
from pathlib import Path
from typing import Any

import pytest

import palpate

DEVICE = """
calibration_format = 1
period_s = 0.001
device_mass_kg = 0.2
delay_s = 0.0005
lag_s = 0.0002
resonance_hz = 100.0
flexible_mass_fraction = 0.5
"""


def test_a_map_is_that_of_the_program(program: Any, tmp_path: Path) -> None:
    out = tmp_path / "map.csv"
    arguments = ["--cells", 2, "--method", "basic,coupled", "--delay-periods", 0.5, "--encoder-quantum", 1e-5]
    theirs = program.json("map", *arguments, "--out", out, "--plot", tmp_path / "map.svg")
    ours = palpate.map(["coupled", "basic"], cells=2, delay_periods=0.5, encoder_quantum=1e-5)
    assert ours.to_csv() == out.read_text() and ours.to_svg() == (tmp_path / "map.svg").read_text()
    # Ignore computing time and file paths.
    for each in (ours, theirs):
        for key in ("work", "files"):
            each.pop(key, None)
    assert ours == theirs
    rows = ours.rows
    assert set(rows["method"]) == {"basic", "coupled"} and set(rows["plant"]) == {"damped", "undamped"}
    assert rows.shape == (2 * 3 * 2 * 2,) and math.isinf(rows["object_mass_kg"].max()) and rows["growth_worst"].min() > 0
    again = pickle.loads(pickle.dumps(ours))
    assert again == ours and again.to_csv() == ours.to_csv() and ours._repr_svg_().startswith("<svg")


def test_an_advice_is_that_of_the_program(program: Any, tmp_path: Path) -> None:
    theirs = program.json("advise", "--device-mass", 0.25, "--period", 0.005, "--stiffness", 2000, "--mass", 0.1, "--delay", 0.005, "--method", "basic,hfcr")
    ours = palpate.advise(device_mass=0.25, period=0.005, stiffness=2000, mass=0.1, delay=0.005, method=["basic", "hfcr"])
    assert ours == theirs
    text = program("advise", "--device-mass", 0.25, "--period", 0.005, "--method", "basic")
    assert str(palpate.advise(device_mass=0.25, period=0.005, method="basic")).strip() == text.strip()
    file = tmp_path / "device.toml"
    file.write_text(DEVICE)
    theirs = program.json("advise", "--device-file", file, "--period", 0.001, "--method", "hfcr", "--stiffness", 7000)
    assert palpate.advise(device_file=file, period=0.001, method="hfcr", stiffness=7000) == theirs
    assert theirs["device"]["stiffest_by_resonance_n_per_m"] < 7000


def test_what_cannot_be_mapped_is_said() -> None:
    for call, said in [
        (lambda: palpate.map("basic", cells=1), "a map has 2 to 1000 cells along each axis, not 1"),
        (lambda: palpate.map("basic", delay_periods=-1), "delay_periods is -1 periods, but must be 0 to 100"),
        (
            lambda: palpate.map("basic", lag_deviation_periods=9),
            "lag_deviation_periods is 9 periods, but must be 0 to 8",
        ),
        (lambda: palpate.map("basic", model_mass=0), "model_mass is 0, but must be 0.001 to 1000"),
        (lambda: palpate.map("basic", viscous_friction=math.nan), "viscous_friction is NaN N s/m, but must be finite and not below 0"),
        (lambda: palpate.map("basic", forces="none"), 'forces is "none", but must be "balanced" or "weight"'),
        (lambda: palpate.map("none"), "none"),
        (lambda: palpate.advise(period=0.001), "device_mass is missing"),
        (lambda: palpate.advise(period=0, device_mass=1), "period is 0 s, but must be finite and greater than 0"),
        (lambda: palpate.advise(period=0.001, device_mass=1, mass=-1), "mass is -1 kg, but must be finite and greater than 0"),
    ]:
        with pytest.raises(ValueError, match=said):
            call()
    with pytest.raises(FileNotFoundError):
        palpate.advise(period=0.001, device_file="none.toml")


def test_a_bench_keeps_the_runs_of_methods(root: Path) -> None:
    def spring(now: palpate.Situation) -> float:
        return 100.0 * now.penetration

    bench = palpate.Bench("experiments/fig2.toml")
    assert repr(bench).endswith("no run>")
    own = bench.run(spring)
    assert own == palpate.simulate("experiments/fig2.toml", method=spring)
    bench.run("coupled")
    bench.run("basic", name="plain")
    errors = bench.errors()
    assert [*errors][0] == "coupled" and set(errors) == {"coupled", "spring", "plain"}
    assert abs(errors["spring"] - errors["plain"]) < 1e-9 and bench.runs["coupled"].ticks["coupled"].size
    with pytest.raises(ValueError):
        palpate.Bench("experiments/worlds/paddle.toml")
