"""A slow host: what it publishes is rendered by a loop in real time, which goes on by itself between two models."""

from __future__ import annotations

import math
import pickle
import runpy
from pathlib import Path
from typing import Any, Callable

import numpy as np
import palpate
import pytest
from palpate.engines import SlowContact, LowRateSimulator, SlowProgress, body_row

from conftest import ROOT
from test_loop import NONE, PATIENCE, loop, read_until, until

UP = (0.0, 0.0, 1.0)
RADIUS = 0.01
STIFFNESS = 300.0


def device(start: tuple[float, float, float] = (0.0, 0.0, 0.005)) -> palpate.devices.PointerInWorld:
    """A device in a hand of 400 N/m, which holds it where it begins."""
    tool = {"name": "tool", "mass_kg": 0.25, "position_m": list(start), "tool": {"sphere": {"radius_m": RADIUS}}}
    floor = {"name": "floor", "fixed": True, "shape": {"half_space": {"normal": list(UP)}}}
    contact = {"between": ["tool", "floor"], "stiffness_n_per_m": 300.0}
    world = palpate.World(loop={"period_s": 0.002}, devices=[tool], bodies=[floor], contacts=[contact])
    return palpate.devices.PointerInWorld(world)


def host(**changes: Any) -> LowRateSimulator:
    # Limits that tolerate a stalled machine, which is not under test.
    given = {"period": 0.002, "device_mass": 0.25, "tool_radius": RADIUS, "bodies": 0, "contacts": 2, "stale_after": 2.0}
    return LowRateSimulator(**{**given, "soft_start": 0.0, **changes})


def floor(**changes: Any) -> SlowContact:
    return SlowContact(**{"place": NONE, "normal": UP, "stiffness": STIFFNESS, **changes})


def until_taken(slow: LowRateSimulator, publish: Callable[[SlowProgress], None]) -> SlowProgress:
    """Publishes until the loop has taken a model."""

    def is_taken() -> bool:
        publish(slow.progress)
        return slow.progress.model_tick is not None

    until("a model to be taken", is_taken)
    return slow.progress


def test_a_published_floor_pushes_as_its_stiffness_says_and_fades_where_nothing_more_comes(tmp_path: Path) -> None:
    slow = host(position=(0.0, 0.0, 0.005), stale_after=0.5)
    made = loop(device(), slow, record=tmp_path / "floor.mcap")
    assert slow.period == 0.002 and made.period == 0.002
    assert (made.body_names, made.contact_names, made.parameters, made.world) == ((), (), {}, None)
    with made:
        until("the first tick", lambda: slow.progress.tick > 0)
        first = slow.progress
        assert (first.model_tick, first.refusal, first.impulses, first.copies) == (None, None, (), ())
        taken = until_taken(slow, lambda progress: slow.publish(progress, [], [floor()]))
        assert taken.time_since(first) == pytest.approx((taken.tick - first.tick) * 0.002)

        def is_pressed(ticks: np.ndarray) -> bool:
            slow.publish(slow.progress, [], [floor()])
            return bool((ticks["contact_force_3_n"] > 0.5).sum() > 200)

        ticks = read_until(made, "a floor that pushes", is_pressed)
        until("a floor that fades", lambda: slow.progress.is_stale)
        until("no force", lambda: made.status.force == NONE)
    # Equilibrium of the hand's spring and the floor is at about 0.9 N.
    pressed = ticks[ticks["contact_force_3_n"] > 0.5][-20:]
    assert np.allclose(pressed["contact_force_3_n"], STIFFNESS * pressed["penetration_m"], rtol=0.02)
    # The commanded force is the mean over the next period, which a late tick changes.
    all_pressed = ticks[ticks["contact_force_3_n"] > 0.5]
    on_time = all_pressed[np.abs(all_pressed["period_s"] - 0.002) < 1e-4][-20:]
    assert np.median(on_time["commanded_force_3_n"]) == pytest.approx(np.median(on_time["contact_force_3_n"]), rel=0.05)
    assert (pressed["pair"] == 0).all()
    report = made.report
    assert report is not None and report.failure is None and report.recorded == report.ticks and report.unrecorded == 0


EXAMPLE = runpy.run_path(str(ROOT / "bindings/python/examples/low_rate_simulator.py"))
Ball = EXAMPLE["Ball"]


def test_the_example_pushes_its_ball_away(capsys: pytest.CaptureFixture[str]) -> None:
    ball = EXAMPLE["main"]()
    assert ball.place[0] > 0.1 and ball.velocity[0] > 0.01
    assert "impulse on the ball" in capsys.readouterr().out


def pushed_away() -> tuple[Any, SlowProgress, np.ndarray]:
    """A ball that the device has pushed away, how far the loop has come, and its ticks."""
    ball, slow = Ball(), host(bodies=1, contacts=1)
    pointer = device((0.0, 0.0, 0.0))
    with loop(pointer, slow) as running:
        before = until_taken(slow, lambda progress: slow.publish(progress, [ball.row()], [ball.contact(progress.position)]))
        pointer.move_to([0.03, 0.0, 0.0])

        def steps_and_is_away() -> bool:
            nonlocal before
            now = slow.progress
            ball.step(now.wrench_since(before, 0), now.time_since(before))
            slow.publish(now, [ball.row()], [ball.contact(now.position)])
            before = now
            return bool(ball.place[0] > 0.09)

        until("the ball to be pushed away", steps_and_is_away)
        assert slow.progress.refusal is None
        return ball, before, running.read(wait=PATIENCE)


def test_a_ball_of_the_host_gets_the_impulse_that_the_hand_gave() -> None:
    def gets_what_the_hand_gave() -> bool:
        ball, progress, ticks = pushed_away()
        impulse = progress.impulses[0].linear
        assert impulse == pytest.approx(ball.MASS * ball.velocity, rel=1e-9, abs=1e-12)
        # A busy machine can delay a tick: the force is then held for longer, and the hand gives another impulse.
        if np.nanmax(ticks["period_s"]) > 0.003:
            return False
        assert impulse[0] > 0.01 and np.abs(progress.copies[0] - ball.place).max() < 0.01
        assert ticks["contact_force_1_n"][ticks["penetration_m"] > 0].max() < 0.0
        held = np.where(ticks["pair"] == 0, ticks["commanded_force_1_n"], 0.0)
        assert -np.nansum(held) * 0.002 == pytest.approx(impulse[0], rel=0.15)
        return True

    until("a run without a late tick", gets_what_the_hand_gave)


def test_a_model_of_a_tick_that_has_not_been_is_refused_by_name() -> None:
    slow = host()
    with loop(device(), slow):
        until_taken(slow, lambda progress: slow.publish(progress, [], [floor()]))
        slow.publish(slow.progress._replace(tick=10**9), [], [floor()])
        until("a refusal", lambda: slow.progress.refusal == "its tick is in the future")


def test_a_host_belongs_to_one_loop_and_says_so(tmp_path: Path) -> None:
    slow = host()
    with pytest.raises(RuntimeError, match="the LowRateSimulator is not in a Loop; make a Loop with it first"):
        slow.progress
    with pytest.raises(TypeError, match="cannot be pickled"):
        pickle.dumps(slow)
    with pytest.raises(ValueError, match="range is for a Renderer, whose contact has one axis; a LowRateSimulator has no range"):
        loop(device(), slow, range=(-1.0, 1.0))
    with pytest.raises(ValueError, match="device is a mapping of names, which is for a World; a LowRateSimulator runs on one device"):
        palpate.Loop({"tool": device()}, slow)
    with pytest.raises(ValueError, match="device moves along one axis"):
        loop(palpate.devices.Pointer(), slow)
    # A loop that cannot be created leaves the LowRateSimulator unchanged.
    (tmp_path / "there.mcap").write_text("")
    for wrong, kind in [({"record": tmp_path / "there.mcap"}, OSError), ({"largest_speed": -1.0}, ValueError)]:
        with pytest.raises(kind):
            loop(device(), slow, **wrong)
    with loop(device(), slow) as running:
        with pytest.raises(TypeError, match="its next `publish` changes them"):
            running.change(stiffness=300.0)
        with pytest.raises(RuntimeError, match="the LowRateSimulator belongs to another Loop"):
            loop(device(), slow)


def test_what_is_published_after_the_end_of_the_loop_is_an_error() -> None:
    slow = host()
    with loop(device(), slow):
        until_taken(slow, lambda progress: slow.publish(progress, [], [floor()]))
    with pytest.raises(RuntimeError, match="the Loop of the LowRateSimulator has ended"):
        slow.publish(slow.progress, [], [floor()])
    # The progress stays readable.
    assert slow.progress.tick > 0 and slow.progress.model_tick is not None


def test_a_row_of_a_body_has_each_part_in_its_place() -> None:
    three, turned = [0.0] * 3, [1.0, 0.0, 0.0, 0.0]
    good: list[Any] = [three, turned, three, three, three, three, np.zeros((6, 6))]
    assert body_row(*good).shape == (55,)
    # 55 numbers as well, but with two arguments swapped.
    with pytest.raises(ValueError, match="position has 4 numbers, but must have 3"):
        body_row(turned, three, *good[2:])
    with pytest.raises(ValueError, match="mobility has 25 numbers, but must have 36"):
        body_row(*good[:-1], np.zeros((5, 5)))


def test_what_is_wrong_is_said_by_name_and_nothing_of_it_is_published() -> None:
    for wrong, what in [
        ({"device_mass": -1.0}, "device_mass is -1, and has to be above 0"),
        ({"device_mass": [1.0, 2.0]}, r"device_mass has the shape \(2,\), but must be one number, or have \(3,\)"),
        ({"tool_radius": -0.01}, "radius is -0.01, and has to be at least 0"),
        ({"bodies": 17}, "bodies is 17, and at most 16 are allowed"),
        ({"bodies": -1}, "bodies is -1, but must not be below 0"),
        ({"soft_start": -1.0}, "soft_start is -1 s, but must be 0 to 60"),
        ({"soft_start": 100.0}, "soft_start is 100 s, but must be 0 to 60"),
        ({"soft_start": math.nan}, "soft_start is NaN s, but must be 0 to 60"),
        ({"contacts": 0}, "contacts is 0, and has to be 1 to 64"),
        ({"stale_after": 0.001}, "stale_after is 0.001 s, and has to be 0.002 to 2 s"),
        ({"position": [0.0, 1.0]}, "position has 2 numbers, but must have three: x, y, z"),
        ({"position": [0.0, 0.0, math.nan]}, r"position\[2\] is nan, but must be finite"),
        ({"period": math.nan}, "period is NaN, and has to be above 0"),
    ]:
        with pytest.raises(ValueError, match=what):
            host(**wrong)
    for wrong, what in [
        ({"bodies": 1.5}, "bodies is 1.5, but must be a whole number"),
        ({"contacts": "a"}, "contacts is 'a', but must be a whole number"),
        ({"tool_radius": "a"}, "tool_radius is 'a': must be real number, not str"),
    ]:
        with pytest.raises(TypeError, match=what):
            host(**wrong)
    slow = host(bodies=1)
    with loop(device(), slow):
        until("the first tick", lambda: slow.progress.tick > 0)
        row = Ball().row()
        for bodies, contacts, what in [
            ([], [], "there are 0 bodies, and the loop needs exactly 1"),
            ([row[:50]], [], r"bodies\[0\] has 50 numbers, but must have 55: palpate.engines.body_row"),
            ([row * math.nan], [], "body 0: position, orientation, motion"),
            ([row], [floor(), floor(on=-1)], "contact 1: on is -1, but must be the number of a body, from 0, or None"),
            ([row], [floor(place=(0.0, 0.0))], "contact 0: place has 2 numbers, but must have three: x, y, z"),
            ([row], [floor()] * 3, "there are 3 contacts, and at most 2 are allowed"),
            ([row], [floor(on=1)], "contact 0: it is on body 1, and there are 1 bodies"),
            ([row], [None, floor(normal=(0.0, 0.0, 2.0))], "contact 1: normal has length 2"),
            ([row], [floor(stiffness=-1.0)], "contact 0: stiffness is -1, and has to be above 0"),
            ([row], [floor(stiffness="a")], "contact 0: stiffness is 'a', but must be a number"),
            ([row], [floor(on=0.5)], "contact 0: on is 0.5, but must be the number of a body"),
        ]:
            with pytest.raises(ValueError, match=what):
                slow.publish(slow.progress, bodies, contacts)
        with pytest.raises(TypeError, match=r"contacts\[0\] is .* but must be a SlowContact or None, in a list"):
            slow.publish(slow.progress, [row], floor())  # type: ignore[arg-type]
        with pytest.raises(IndexError):
            slow.progress.wrench_since(slow.progress, 1)
        ticks = slow.progress.tick
        until("ten more ticks", lambda: slow.progress.tick > ticks + 10)
        assert slow.progress.model_tick is None
