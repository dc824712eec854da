"""A world that changes while its loop runs: what is in force from which tick, and what goes on.

What is waited for is an event, for as long as a busy machine may need.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import palpate
import pytest

from test_loop import PATIENCE, loop, pressing, until, wall
from test_loop_world import FLOOR, ball, pressed, world


def floor_of(stiffness: float, **changes: Any) -> list[dict[str, Any]]:
    return [{"between": ["tool", "floor"], "stiffness_n_per_m": stiffness, **changes}]


COUPLING = {"coupling_stiffness_n_per_m": 500.0, "coupling_mass_kg": 0.01, "damping_n_s_per_m": 1.0}


class Heard:
    """All that a loop has told."""

    def __init__(self, running: palpate.Loop) -> None:
        self.running = running
        self.ticks: list[np.ndarray] = []
        self.bodies: list[np.ndarray] = []

    def until(self, what: str, is_so: Any) -> np.ndarray:
        def look() -> bool:
            self.ticks.append(self.running.read(wait=PATIENCE))
            self.bodies.append(self.running.bodies)
            return bool(is_so(np.concatenate(self.ticks)))

        until(what, look)
        return np.concatenate(self.ticks)

    def of_body(self, number: int) -> np.ndarray:
        bodies = np.concatenate(self.bodies)
        return bodies[bodies["body"] == number]


def after(generation: int, count: int = 1) -> Any:
    """Whether so many ticks of a change were heard."""
    return lambda ticks: (ticks["generation"] == generation).sum() >= count


def test_another_stiffness_is_in_force_from_the_tick_that_says_so_and_comes_without_a_step() -> None:
    model = pressed()
    with loop(palpate.devices.PointerInWorld(model), model) as running:
        heard = Heard(running)
        heard.until("contact at rest", lambda ticks: (np.abs(np.diff(ticks["device_axis_3_m"][-20:])) < 1e-7).all() and len(ticks) > 100)
        assert running.world is model
        assert running.change(contacts=floor_of(600.0)) == 1
        # 0.1 s is 50 ticks.
        ticks = heard.until("the change and 80 ticks of it", after(1, 80))
        assert running.world is not None and running.world.to_dict()["contact"][0]["stiffness_n_per_m"] == 600.0
        [event] = [event for event in running.events() if event.kind == "parameters"]
    first = int(np.argmax(ticks["generation"] == 1))
    assert (ticks["generation"][:first] == 0).all() and (ticks["generation"][first:] == 1).all()
    assert event.sequence == ticks["sequence"][first] and event.text == "parameters number 1 from here on: another world, rendered by basic"
    force, depth = ticks["commanded_force_3_n"], ticks["penetration_m"]
    assert force[first - 1] == pytest.approx(300.0 * depth[first - 1], rel=1e-9)
    # The first three forces are those of the previous world, for any springs.
    assert force[first : first + 3] == pytest.approx(300.0 * depth[first : first + 3], rel=1e-9)
    # The contact changes at once; the device force is blended over 0.1 s.
    assert np.allclose(ticks["contact_force_3_n"][first:], 600.0 * depth[first:], rtol=1e-9)
    # The difference fades from the third tick on, over 0.1 s.
    passed = np.cumsum(ticks["period_s"][first + 3 :])
    more = (force - 600.0 * depth)[first + 2 :]
    fades = np.diff(more / more[0])
    assert (fades <= 1e-9).all() and np.abs(more[1:][passed > 0.1 + 1e-9]).max() < 1e-9 * np.abs(more[0])
    # No step: the change per sample is bounded by the blending rate and the deflection of the hand.
    assert (np.abs(np.diff(force[first + 2 :])) < (ticks["period_s"][first + 3 :] / 0.1 + 0.05) * force[first - 1]).all()


def another_mass_and_weight() -> tuple[np.ndarray, np.ndarray, int, np.ndarray]:
    """Of a ball that is pushed, let go, and given another mass and weight: its rows, their times, the first of them under the new ones,
    and its velocity before."""
    model = ball()
    device = palpate.devices.PointerInWorld(model)
    bodies = model.to_dict()["body"]
    with loop(device, model) as running:
        heard = Heard(running)
        device.move_to([0.02, 0.0, 0.05])
        heard.until("the ball to move", lambda _: (heard.of_body(1)["velocity_m_per_s"][:, 0] > 0.01).any())
        device.move_to([-0.02, 0.0, 0.05])
        heard.until("the ball to be free", lambda ticks: np.isnan(ticks["penetration_m"][-10:]).all() and len(ticks) > 10)
        before = heard.of_body(1)["velocity_m_per_s"][-1].copy()
        assert running.change(bodies=[FLOOR, {**bodies[1], "mass_kg": 0.2, "force_n": [0.0, 0.04, 0.0]}]) == 1
        ticks = heard.until("60 ticks of the change", after(1, 60))
    changed = ticks["sequence"][np.argmax(ticks["generation"] == 1)]
    free = heard.of_body(1)
    place = int(np.argmax(free["sequence"] == changed))
    return free, ticks["t_s"][np.searchsorted(ticks["sequence"], free["sequence"])], place, before


def test_a_body_goes_on_from_where_it_is_and_with_its_speed_under_another_mass_and_weight() -> None:
    for _ in range(10):
        free, times, place, before = another_mass_and_weight()
        # After a gap of 20 periods of 2 ms without a sample bodies are held still.
        if np.diff(times[place - 1 :]).max() < 0.035:
            break
    else:
        pytest.fail("the machine stood still in each of ten runs")
    assert before[0] > 0.001 and free["velocity_m_per_s"][place - 1] == pytest.approx(before)
    # The motion is unchanged up to the last tick before the change; the new mass and weight act from there on.
    # Sampling times are accurate within a period.
    moved = free["position_m"][place, 0] - free["position_m"][place - 1, 0]
    assert moved == pytest.approx(before[0] * (times[place] - times[place - 1]), abs=0.002 * before[0])
    assert free["velocity_m_per_s"][place:, 0] == pytest.approx(np.full(len(free) - place, before[0]), abs=1e-9)
    model = free["velocity_m_per_s"][place:, 1]
    assert model[0] > 0.0 and model == pytest.approx(0.2 * (times[place:] - times[place - 1]), abs=0.2 * 0.002)
    assert model[-1] > 0.02


def test_a_body_is_put_elsewhere_and_others_stay() -> None:
    model = ball()
    device = palpate.devices.PointerInWorld(model)
    bodies = model.to_dict()["body"]
    with loop(device, model) as running:
        heard = Heard(running)
        device.move_to([0.02, 0.0, 0.05])
        heard.until("the ball to move", lambda _: (heard.of_body(1)["velocity_m_per_s"][:, 0] > 0.01).any())
        there = {**bodies[1], "position_m": [0.3, 0.1, 0.05]}
        running.change(bodies=[FLOOR, there])
        heard.until("the change", after(1, 5))
        # The same tables again: the body continues its motion.
        assert running.change(running.world, method="virtual-coupling", methods={"virtual-coupling": COUPLING}) == 2
        ticks = heard.until("the other method", after(2, 5))
    free = heard.of_body(1)
    assert [event.text[-len("virtual-coupling"):] for event in running.events() if event.kind == "parameters"][-1] == "virtual-coupling"
    for generation in (1, 2):
        changed = ticks["sequence"][np.argmax(ticks["generation"] == generation)]
        place = int(np.argmax(free["sequence"] == changed))
        assert free["position_m"][place].tolist() == [0.3, 0.1, 0.05]
        assert (free["velocity_m_per_s"][place] == 0).all()


def test_what_cannot_change_is_refused_and_changes_nothing() -> None:
    model, other = pressed(), ball()
    with loop(palpate.devices.PointerInWorld(model), model) as running:
        for changes, words in [
            ({"loop": {"period_s": 0.004}}, "the period is 0.002 s and cannot become 0.004 s while the loop runs"),
            ({"contacts": floor_of(-1.0)}, "stiffness"),
            ({"bodies": []}, "floor"),
            ({"bodies": [FLOOR, {**FLOOR, "name": "wall"}]}, "the bodies are floor, wall, but must stay floor while the loop runs"),
            ({"contacts": []}, "the contact pairs are "),
            ({"method": "none"}, "none"),
            ({"soft_start": 1.0}, "soft_start is a limit of the loop"),
            ({"force_limit": 1.0}, "force_limit is a limit of the loop"),
        ]:
            with pytest.raises(ValueError, match=words):
                running.change(**changes)
        with pytest.raises(ValueError, match="the bodies are floor, ball, but must stay floor"):
            running.change(other)
        with pytest.raises(TypeError, match="world is 'another', but must be a palpate.World"):
            running.change("another")  # type: ignore[arg-type]
        ticks = Heard(running).until("ticks", lambda ticks: len(ticks) > 20)
        assert (ticks["generation"] == 0).all() and running.world is model
        assert not [event for event in running.events() if event.kind == "parameters"]
    with pytest.raises(RuntimeError, match="the loop has ended"):
        running.change(contacts=floor_of(500.0))
    with loop(pressing(), wall()) as contact:
        with pytest.raises(TypeError, match="the loop renders a Renderer; make another Loop for a World"):
            contact.change(model)
        assert contact.world is None


def test_many_changes_in_a_row_leave_the_last_one_and_no_room_is_said(tmp_path: Path) -> None:
    model = pressed()
    path = tmp_path / "changed.mcap"
    running = loop(palpate.devices.PointerInWorld(model), model, record=path)
    # Before the start nothing takes the changes.
    for number in range(1, 9):
        assert running.change(contacts=floor_of(300.0 + number)) == number
    with pytest.raises(ValueError, match="8 worlds are already queued"):
        running.change(contacts=floor_of(500.0))
    with running:
        heard = Heard(running)
        ticks = heard.until("ticks", lambda ticks: len(ticks) > 70)
        assert (ticks["generation"] == 8).all()
        for number in range(9, 60):
            # The loop takes each change before the next one is made.
            assert running.change(contacts=floor_of(300.0 + number)) == number
            heard.until("the change", after(number))
        kinds = [event.kind for event in running.events() if event.kind == "parameters"]
        assert len(kinds) == 52
    recording = palpate.read_recording(path)
    assert recording.complete and set(recording.ticks["generation"]) == set(range(8, 60))
    assert recording.parameter_changes == 59
