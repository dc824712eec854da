"""Methods of one's own, beside the built-in ones."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import palpate
from conftest import ROOT

FIG2 = "experiments/fig2.toml"
STIFFNESS = palpate.Scene.read(ROOT / FIG2).to_dict()["contact"][0]["stiffness_n_per_m"]


def spring(now: palpate.Situation) -> float:
    """The plain spring of the scene."""
    return float(STIFFNESS * now.penetration)


def test_the_plain_spring_of_python_is_that_of_rust(root: Path) -> None:
    run = palpate.simulate(FIG2, method=["basic", spring, "coupled"])
    assert [method.method for method in run.methods] == [*run.ticks] == ["basic", "spring", "coupled"]
    assert run.ticks["spring"].tobytes() == run.ticks["basic"].tobytes()
    built_in, own = dict(run.method("basic")), dict(run.method("spring"))
    assert own.pop("method") == "spring" and built_in.pop("method") == "basic" and own == built_in
    mirrored = palpate.Scene.read(FIG2).replace(
        body={"shape": {"half_space": {"normal": [1, 0, 0]}}, "position_m": [-0.05, 0, 0], "force_n": [0.981, 0, 0]},
        device={"hand": {"force_n": [-1.0, 0, 0]}},
    )
    ticks = palpate.simulate(mirrored, method=["basic", spring]).ticks
    assert ticks["spring"].tobytes() == ticks["basic"].tobytes()
    assert np.abs(ticks["spring"]["force_on_object_n"]).max() > 1.0


def test_a_method_sees_what_the_ticks_say(root: Path) -> None:
    class Watcher:
        def __init__(self) -> None:
            self.seen: list[palpate.Situation] = []

        def __call__(self, now: palpate.Situation) -> float:
            self.seen.append(now)
            return STIFFNESS * now.penetration + 0.5 * now.device_velocity

    watcher = Watcher()
    run = palpate.simulate(FIG2, method=watcher)
    ticks = run.ticks["Watcher"]
    pressed = ticks[ticks["penetration_m"] > 0.0]
    assert len(watcher.seen) == len(pressed) > 5
    for now, tick in zip(watcher.seen, pressed):
        assert now.penetration == tick["penetration_m"] and now.object_velocity == tick["object_velocity_m_per_s"]
        assert now.port_work == tick["port_work_j"] and now.held_leak == tick["leak_held_j"]
        assert tick["force_on_object_n"] == STIFFNESS * now.penetration + 0.5 * now.device_velocity


def test_what_a_method_raises_comes_out(root: Path) -> None:
    def broken(now: palpate.Situation) -> float:
        raise ZeroDivisionError("of my own")

    def wordy(now: palpate.Situation) -> Any:
        return "strong"

    with pytest.raises(ZeroDivisionError, match="of my own"):
        palpate.simulate(FIG2, method=["basic", broken])
    with pytest.raises(TypeError):
        palpate.simulate(FIG2, method=wordy)
    with pytest.raises(TypeError, match="method spring is a function, and only simulate takes one"):
        palpate.compare(FIG2, method=[spring])  # type: ignore[list-item]
    with pytest.raises(ValueError, match="spring is named twice"):
        palpate.simulate(FIG2, method=[spring, spring])


def test_reports_show_themselves(root: Path) -> None:
    run = palpate.simulate(FIG2, method=["basic", "coupled"])
    shown = palpate.heights(FIG2, "coupled")._repr_html_() or ""
    assert shown.startswith("<pre>") and "coupled" in shown

    class Axes:
        def __init__(self) -> None:
            self.drawn: list[str] = []

        def plot(self, x: Any, y: Any, label: str, **_: Any) -> None:
            assert len(x) == len(y)
            self.drawn.append(label)

        def step(self, x: Any, y: Any, label: str, **_: Any) -> None:
            self.plot(x, y, label)

        def set(self, **_: Any) -> None: ...
        def legend(self) -> None: ...

    axes = Axes()
    assert run.plot(axes) is axes and axes.drawn == ["ideal", "basic", "coupled"]


@pytest.mark.parametrize("answer", [math.nan, math.inf])
def test_an_answer_that_is_no_finite_number_is_refused_by_the_method_s_name(answer: float) -> None:
    def broken(now: palpate.Situation) -> float:
        return answer

    with pytest.raises(ValueError, match=f"broken returned {answer}, but must return a finite number"):
        palpate.simulate(ROOT / FIG2, broken)


def test_an_answer_that_is_no_number_is_refused_by_the_method_s_name() -> None:
    def silent(now: palpate.Situation) -> Any:
        return None

    with pytest.raises(TypeError, match="silent returned None, but must return a finite number"):
        palpate.simulate(ROOT / FIG2, silent)
