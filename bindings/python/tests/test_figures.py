"""Figures of reports, and tables of other packages."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest

import palpate

FIG2 = "experiments/fig2.toml"
MOTION = "experiments/users/hand_intention.csv"
CONTACT = {"stiffness": 400.0, "mass": 0.1, "period": 0.01, "force": -0.981, "method": ["basic", "coupled"]}
FLAGS = ["--stiffness", 400, "--mass", 0.1, "--period", 0.01, "--force", -0.981, "--method", "basic,coupled"]
DEVICE = {"device_mass": 0.25, "period": 0.005, "stiffness": 2000, "mass": 0.1}


@pytest.mark.parametrize(
    ("command", "ours"),
    [
        (["simulate", FIG2, "--method", "basic,coupled"], lambda _: palpate.simulate(FIG2, ["basic", "coupled"])),
        (["simulate", FIG2], lambda _: palpate.simulate(FIG2)),
        (["render", MOTION, *FLAGS], lambda motion: palpate.render(*motion, **CONTACT, title=MOTION)),
        (["compare", FIG2, "--method", "basic,hfcr"], lambda _: palpate.compare(FIG2, ["basic", "hfcr"])),
        (["tune", FIG2, "--method", "hfcr", "--steps", 3], lambda _: palpate.tune(FIG2, "hfcr", steps=3)),
        (["suite", "--plants", 2], lambda _: palpate.suite(plants=2)),
        (
            ["advise", "--device-mass", 0.25, "--period", 0.005, "--stiffness", 2000, "--mass", 0.1, "--method", "basic"],
            lambda _: palpate.advise(**DEVICE, method="basic"),
        ),
    ],
    ids=lambda value: value[0] if isinstance(value, list) else "",
)
def test_a_figure_is_that_of_the_program(
    program: Any, root: Path, motion: Any, tmp_path: Path, command: list[Any], ours: Callable[[Any], palpate.Report]
) -> None:
    program(*command, "--plot", tmp_path / "figure.svg")
    report = ours(motion)
    # A pickled report draws the same figure.
    sent = pickle.loads(pickle.dumps(report))
    assert report._repr_html_() is None
    assert report._repr_svg_() == sent.to_svg() == (tmp_path / "figure.svg").read_text()


def test_a_motion_may_change_after_it_was_rendered(motion: Any) -> None:
    t, x = (values.copy() for values in motion)
    run = palpate.render(t, x, **CONTACT)
    x[:] = 0.0
    assert run.to_svg() == palpate.render(*motion, **CONTACT).to_svg()


def test_what_has_no_figure_says_so(root: Path) -> None:
    def spring(now: palpate.Situation) -> float:
        return 100.0 * now.penetration

    for report in (palpate.simulate(FIG2, [spring, "basic"]), palpate.heights(FIG2, "basic")):
        assert report._repr_svg_() is None and report._repr_html_().startswith("<pre>")
        with pytest.raises(ValueError, match="this report has no figure"):
            report.to_svg()


@pytest.mark.parametrize("kind", ["pandas", "polars"])
def test_rows_are_tables_of_pandas_and_polars(root: Path, kind: str) -> None:
    pytest.importorskip(kind)
    run = palpate.simulate(FIG2, ["basic", "coupled"])
    reach = palpate.map("basic", cells=2)
    recording = palpate.read_recording("crates/palpate-record/tests/recording/golden.mcap")
    table, cells, ticks = (getattr(report, f"to_{kind}")() for report in (run, reach, recording))
    assert list(table.columns) == ["method", *palpate.TICK.names]
    assert list(table["method"]) == ["basic"] * len(run.ticks["basic"]) + ["coupled"] * len(run.ticks["coupled"])
    both = np.concatenate([run.ticks["basic"], run.ticks["coupled"]])
    for name in palpate.TICK.names:
        np.testing.assert_array_equal(np.asarray(table[name]), both[name], name)
    assert list(cells["growth_worst"]) == reach.rows["growth_worst"].tolist()
    assert list(ticks["t_s"]) == recording.ticks["t_s"].tolist()
