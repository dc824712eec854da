"""`render`: arrays in, structured arrays out."""

from __future__ import annotations

import csv
import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import palpate

CONTACT: dict[str, Any] = {"stiffness": 400.0, "mass": 0.1, "period": 1e-2, "force": -0.981}
SWING = (np.arange(2000) * 1e-3, 0.01 * np.sin(0.012 * np.arange(2000)))


def table(path: Path) -> dict[str, list[str]]:
    """The columns of a run file."""
    with path.open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return {name: [row[name] for row in rows] for name in rows[0]}


def test_a_recording_gives_the_numbers_of_the_program_to_the_last_bit(
    program: Any, motion: tuple[Any, Any], tmp_path: Path
) -> None:
    out = tmp_path / "run.csv"
    recording = "experiments/users/hand_intention.csv"
    flags = ["--stiffness", 400, "--mass", 0.1, "--period", 0.01, "--force", -0.981, "--method", "all"]
    theirs = program.json("render", recording, *flags, "--out", out)
    ours = palpate.render(*motion, **CONTACT, method="all", title=recording)
    assert theirs.pop("files") == [str(out)]
    assert ours == theirs
    columns = table(out)
    # The first column names the format.
    assert {*palpate.TICK.names} | {"method", "palpate_run_1"} == {*columns}
    for method, ticks in ours.ticks.items():
        of_method = [place for place, name in enumerate(columns["method"]) if name == method]
        assert len(of_method) == len(ticks) > 10
        for name in palpate.TICK.names:
            written = [columns[name][place] for place in of_method]
            match name:
                case "phase":
                    assert [palpate.PHASES[code] for code in ticks[name]] == written
                case "fault":
                    assert [palpate.FAULTS[code] for code in ticks[name]] == written
                case "limited":
                    said = [
                        " ".join(limit for bit, limit in enumerate(palpate.LIMITS) if code >> bit & 1)
                        for code in ticks[name]
                    ]
                    assert said == written
                case _:
                    numbers = np.array([float(cell) if cell else math.nan for cell in written])
                    np.testing.assert_array_equal(ticks[name], numbers, name)


def test_codes_say_which_limit_acted_and_what_was_refused() -> None:
    t, x = SWING
    run = palpate.render(t, x, **CONTACT, method="basic", force_limit=1.0, speed_limit=0.1, unilateral=True)
    ticks = run.ticks["basic"]
    refused = ticks["fault"] > 0
    assert {palpate.FAULTS[code] for code in ticks["fault"][refused]} == {"jump-too-fast"}
    assert (ticks["force_on_device_n"][refused] == 0.0).all()
    limited = ticks["limited"] >> palpate.LIMITS.index("force") & 1 == 1
    assert limited.any() and (np.abs(ticks["force_on_device_n"][limited]) == 1.0).all()
    assert run.method("basic").faults == refused.sum()


def test_arrays_of_any_layout_and_of_other_numbers_are_taken() -> None:
    t, x = SWING
    expected = palpate.render(t, x, **CONTACT, method="basic").ticks["basic"]
    pairs = np.stack([t, x], axis=1)
    for times, positions in [
        (pairs[:, 0], pairs[:, 1]),
        (t[::-1].copy()[::-1], x[::-1].copy()[::-1]),
        (list(t), tuple(x)),
        (t.astype(">f8"), x.astype(">f8")),
    ]:
        np.testing.assert_array_equal(palpate.render(times, positions, **CONTACT, method="basic").ticks["basic"], expected)
    single = palpate.render(t, x.astype(np.float32), **CONTACT, method="basic").ticks["basic"]
    double = palpate.render(t, x.astype(np.float32).astype(float), **CONTACT, method="basic").ticks["basic"]
    np.testing.assert_array_equal(single, double)
    with pytest.warns(UserWarning, match="period is 1 s"):
        whole = palpate.render(np.arange(3), np.arange(3), stiffness=1, mass=1, period=1, unit="m", time_unit="s", method="basic")
    assert len(whole.ticks["basic"]) == 3
    millimetres = palpate.render(t, 1000 * x, **CONTACT, method="basic", unit="mm").ticks["basic"]
    np.testing.assert_allclose(millimetres["device_position_m"], expected["device_position_m"], rtol=1e-14)


@pytest.mark.parametrize(
    ("t", "x", "words"),
    [
        (np.zeros((2, 2)), SWING[1], "t has the shape (2, 2), but must have one dimension"),
        (SWING[0], 1.0, "x has the shape (), but must have one dimension"),
        (SWING[0], SWING[1][1:], "2000 times but 1999 positions"),
        ([0.0], [0.0], "a path needs at least two samples, not 1"),
        ([], [], "a path needs at least two samples, not 0"),
        ([0.0, 0.01, 0.01], [0, 0, 0], "time 0.01 s at index 2 is not after 0.01 s"),
        ([0.0, 1.0, math.nan], [0, 0, 0], "time NaN s at index 2 is not finite"),
        ([0.0, 1.0, 2.0], [0, math.nan, 0], "position NaN m at index 1 is not finite"),
        (["a", "b"], [0, 0], "t is of type <U1, but must be of numbers"),
        (SWING[0], SWING[1] * 1j, "x is of type complex128, but must be of numbers"),
        ([0.0, 0.001], [0.0, 0.0], "the recording lasts 0.001 s, less than one period of 0.01 s"),
        (SWING[0], 1000 * SWING[1], 'implausible motion: 151 m path in 2 s, range 20 m; is the unit mm? If so, pass unit="mm"'),
        ([0.0, 1e5], [0, 0], "the recording has 10000000 periods; at most 2000000 fit"),
        ([0.0, 1e9], [0, 0], "period is 0.01, but must be long enough for at most 1e8 periods"),
    ],
)
def test_what_is_no_motion_is_refused_with_the_reason(t: Any, x: Any, words: str) -> None:
    with pytest.raises(ValueError) as raised:
        palpate.render(t, x, **CONTACT, method="basic")
    assert str(raised.value).startswith(words)


def test_a_table_is_read_as_it_is_laid_out_and_rendered_as_its_arrays(tmp_path: Any) -> None:
    t, x = SWING
    table = tmp_path / "recorder.csv"
    rows = [f"{1000 * time:.10g};a;{1000 * place:.17g}" for time, place in zip(t, x)]
    table.write_text("\n".join(["time;note;X", *rows]).replace(".", ",") + "\n")
    said: dict[str, Any] = {"columns": {"t": "time", "x": "X"}, "decimal_comma": True, "unit": "mm", "time_unit": "ms"}
    read = palpate.read_trace(table, **said)
    np.testing.assert_allclose(read.t, t, rtol=1e-12)
    np.testing.assert_allclose(read.x, x, rtol=1e-15, atol=1e-17)
    assert read.force is None and read.virtual_force is None and read.left_out == 0
    for left, words in [
        ("columns", r'columns=\{"t": NAME, "x": NAME\}'),
        ("decimal_comma", "decimal_comma=True"),
        ("unit", 'unit="mm"'),
        ("time_unit", 'time_unit="ms"'),
    ]:
        with pytest.raises(ValueError, match=words):
            palpate.read_trace(table, **{key: value for key, value in said.items() if key != left})
    table.write_text("t_s,position_m\n0,0.01\n0.001,\n0.002,0.01\n0.003,0.0")
    with pytest.raises(ValueError, match="skip_missing=True"):
        palpate.read_trace(table)
    with pytest.warns(UserWarning, match="`?0.0`?, may be cut off"):
        read = palpate.read_trace(table, skip_missing=True)
    assert read.left_out == 1
    np.testing.assert_array_equal(read.t, [0, 0.002])


def test_each_sample_may_have_a_virtual_force(tmp_path: Any) -> None:
    t, x = SWING
    contact = {**CONTACT, "method": "hfcr"}
    constant = palpate.render(t, x, **{**contact, "force": -0.5})
    varying = palpate.render(t, x, **{**contact, "force": -0.1}, virtual_force=np.full(len(t), -0.4))
    assert varying["methods"] == constant["methods"]
    table = tmp_path / "pushed.csv"
    table.write_text("t_s,position_m,virtual_force_n\n0,0.01,1\n0.001,0.01,2\n")
    assert palpate.read_trace(table).virtual_force.tolist() == [1, 2]  # type: ignore[union-attr]
    with pytest.raises(ValueError, match="virtual_force has 1 numbers, but must have"):
        palpate.render(t, x, **contact, virtual_force=[1.0])


def test_times_in_milliseconds_gaps_and_missing_values_are_not_taken_for_others() -> None:
    t, x = SWING
    with pytest.raises(ValueError, match='time_unit="ms"'):
        palpate.render(1000 * t, x, **CONTACT)
    whole = palpate.render(t, x, **CONTACT, method="basic")
    in_ms = palpate.render(1000 * t, x, **CONTACT, method="basic", time_unit="ms")
    np.testing.assert_allclose(in_ms.ticks["basic"]["device_position_m"], whole.ticks["basic"]["device_position_m"], rtol=1e-9, atol=1e-15)
    holes = x.copy()
    holes[300:400] = math.nan
    with pytest.raises(ValueError, match="position NaN m at index 300 is not finite; skip_missing=True"):
        palpate.render(t, holes, **CONTACT)
    with pytest.warns(UserWarning, match="no sample was recorded for"):
        run = palpate.render(t, holes, **CONTACT, method="basic", skip_missing=True)
    assert run["motion"]["samples_left_out"] == 100
    assert run["motion"]["longest_gap_s"] == pytest.approx(101 * (t[1] - t[0]))


def test_a_period_in_milliseconds_is_questioned() -> None:
    with pytest.warns(UserWarning, match="period is 1 s, a loop of 1 Hz; is it in milliseconds"):
        palpate.Renderer(stiffness=400.0, mass=0.1, period=1.0, device_mass=0.25)
    with pytest.warns(UserWarning, match="period is 1 s"):
        palpate.render([0.0, 0.1, 2.0], [0.0, 0.0, 0.0], stiffness=400.0, mass=0.1, period=1.0, method="basic", time_unit="s")
    with pytest.warns(UserWarning, match="lag is 1 s; is it in milliseconds"):
        palpate.Renderer(stiffness=400.0, mass=0.1, period=0.001, device_mass=0.25, lag=1.0)
    with pytest.warns(UserWarning, match="period is 1 s"):
        palpate.advise(period=1.0, device_mass=0.25, stiffness=0.1, method="basic")
    with pytest.warns(UserWarning, match="period_s is 1 s"):
        palpate.Scene(
            "slow",
            loop={"period_s": 1.0},
            device={"name": "device", "axes": ["x"], "mass_kg": 0.25, "hand": {"force_n": [1.0, 0, 0]}},
            body={"name": "wall", "fixed": True, "shape": {"half_space": {"normal": [-1, 0, 0]}}},
            contact={"between": ["device", "wall"], "stiffness_n_per_m": 0.4},
            measure={"duration_s": 1.0},
        )


def test_wrong_arguments_are_named() -> None:
    for wrong, words in [
        ({"unit": "inch"}, 'unit is "inch", but must be "m" or "cm" or "mm" or "um"'),
        ({"method": []}, "method is empty; name a method"),
        ({"method": ["basic", "basic"]}, "basic is named twice"),
        ({"method": ["basic", "hfcr"], "damping": 1.0}, "damping cannot be used by method basic"),
        ({"stiffness": 0.0}, "stiffness is 0 N/m, but must be finite and greater than 0"),
    ]:
        with pytest.raises(ValueError) as raised:
            palpate.render(*SWING, **{**CONTACT, **wrong})
        assert str(raised.value).startswith(words)


def test_what_comes_out_is_the_callers_own() -> None:
    t, x = SWING
    before = x.copy()
    run = palpate.render(t, x, **CONTACT, method="basic")
    np.testing.assert_array_equal(x, before)
    ticks = run.ticks["basic"]
    assert ticks.flags.writeable and ticks.flags.aligned
    ticks["t_s"] = 0.0
    assert not np.may_share_memory(ticks, x)


def test_runs_are_pickled_whole() -> None:
    run = palpate.render(*SWING, **CONTACT, method=["basic", "hfcr"])
    again = pickle.loads(pickle.dumps(run))
    assert again == run and str(again) == str(run) and [*again.ticks] == ["basic", "hfcr"]
    for method, ticks in run.ticks.items():
        np.testing.assert_array_equal(again.ticks[method], ticks)
    np.testing.assert_array_equal(again.ideal, run.ideal)
    assert run.methods[1].method == run.method("hfcr")["method"] == "hfcr"
    with pytest.raises(AttributeError, match="there is no field kapa; the fields are format"):
        run.kapa
    with pytest.raises(KeyError, match="there is no run of seh; there are basic, hfcr"):
        run.method("seh")


def test_positions_that_are_no_numbers_are_refused_wherever_they_stand() -> None:
    for positions, index in (([0.0, math.nan, math.nan, 0.0], 1), ([math.nan] * 4, 0), ([0.0, 0.0, math.inf, math.nan], 2)):
        with pytest.raises(ValueError, match=f"position .* at index {index} is not finite"):
            palpate.render([0.0, 0.1, 0.2, 0.3], positions, **CONTACT)
