"""Many contacts at once, and states to go back to."""

from __future__ import annotations

import copy
import pickle
from typing import Any, Callable

import numpy as np
import pytest

import palpate

COUNT = 2100
"""Enough for several threads."""
PERIOD = 1e-3


def various(method: str) -> dict[str, Any]:
    """Contacts of various objects, deep enough for every limit."""
    drawn = np.random.default_rng(7)
    masses = np.where(drawn.random(COUNT) < 0.2, np.inf, drawn.uniform(0.02, 1.0, COUNT))
    given: dict[str, Any] = {
        "stiffness": drawn.uniform(100.0, 4000.0, COUNT),
        "mass": masses,
        "period": PERIOD,
        "device_mass": 0.2,
        "force": np.where(np.isinf(masses), 0.0, -0.5),
        "soft_start": drawn.choice([0.0, 0.05], COUNT),
        "side": "positive",
    }
    return {**given, "method": method, **({"damping": 0.5} if method == "hfcr" else {})}


def of_row(parameters: dict[str, Any], place: int) -> palpate.Renderer:
    row = {name: value[place].item() if np.ndim(value) else value for name, value in parameters.items()}
    return palpate.Renderer(**row)


def positions(step: int) -> Any:
    return 0.004 * np.sin(0.03 * step + np.arange(COUNT)) + 1e-3


@pytest.mark.parametrize("method", ["basic", "hfcr", "coupled"])
def test_each_contact_is_a_renderer_bit_by_bit(method: str) -> None:
    parameters = various(method)
    many = palpate.Renderers(COUNT, **parameters)
    places = [*range(0, COUNT, 70), COUNT - 1]
    alone = [of_row(parameters, place) for place in places]
    out = np.empty(COUNT)
    for step in range(150):
        sampled = positions(step)
        elapsed = PERIOD * (1.0 + 0.2 * np.cos(np.arange(COUNT))) if step % 2 else None
        if step == 90:
            sampled[places[3]] = np.nan
        assert many.step(sampled, elapsed, out=out) is out
        for place, renderer in zip(places, alone):
            assert out[place] == renderer.step(sampled[place], None if elapsed is None else elapsed[place]), (step, place)
        if step in (90, 149):
            for place, renderer in zip(places, alone):
                assert_same(many.output[place], renderer.output)
                assert many.leak_held_j[place] == renderer.ledger.held_leak.accumulated
    assert (np.abs(out) > 0.1).mean() > 0.2


def assert_same(row: Any, output: palpate.Output | None) -> None:
    assert output is not None
    assert row["force_on_device_n"] == output.force_on_device and row["penetration_m"] == output.penetration
    assert row["object_position_m"] == output.object_position and row["object_velocity_m_per_s"] == output.object_velocity
    assert palpate.PHASES[row["phase"]] == output.phase and palpate.FAULTS[row["fault"]] == (output.fault or "")
    acted = {name for bit, name in enumerate(palpate.LIMITS) if row["limited"] >> bit & 1}
    acted |= {name for name, is_on in [("soft-start", row["soft_start"]), ("safety-stop", row["safety_stop"])] if is_on}
    assert acted == {*output.limited}


def contact() -> Any:
    return palpate.Renderer(stiffness=2000.0, mass=0.1, period=PERIOD, device_mass=0.2, force=-0.5)


def contacts() -> Any:
    return palpate.Renderers(3, stiffness=[500.0, 1000.0, 2000.0], mass=0.1, period=PERIOD, device_mass=0.2, force=-0.5)


def floor() -> Any:
    return palpate.World(
        loop={"period_s": PERIOD},
        devices=[{"name": "tool", "mass_kg": 0.2, "tool": {"sphere": {"radius_m": 0.01}}}],
        bodies=[{"name": "floor", "fixed": True, "shape": {"half_space": {"normal": [0, 0, 1], "offset_m": -0.01}}}],
        contacts=[{"between": ["tool", "floor"], "stiffness_n_per_m": 2000.0, "friction": 0.5}],
        soft_start=0.0,
    )


def place(of: Any, step: int) -> Any:
    at = 1e-3 * np.sin(0.1 * step)
    if isinstance(of, palpate.World):
        return (at, 0.5 * at, -2.0 * at)
    return np.full(3, at) if isinstance(of, palpate.Renderers) else at


@pytest.mark.parametrize("made", [contact, contacts, floor])
def test_a_state_continues_bit_by_bit(made: Callable[[], Any]) -> None:
    one = made()

    def forces(of: Any, steps: range) -> Any:
        return np.array([of.step(place(of, step)) for step in steps])

    before = forces(one, range(60))
    state = one.get_state()
    branch = one.copy()
    after = forces(one, range(60, 120))
    assert np.abs(before).max() > 0.0 and np.abs(after).max() > 0.0
    other = made()
    for again in (branch, other, copy.deepcopy(branch)):
        again.set_state(state)
        assert (forces(again, range(60, 120)) == after).all()
    one.reset()
    assert (forces(one, range(60)) == before).all()
    for value in (one, state):
        with pytest.raises(TypeError, match="cannot be pickled"):
            pickle.dumps(value)


def test_a_state_of_something_else_is_refused() -> None:
    state = contact().get_state()
    stiffer = palpate.Renderer(**{**contact().parameters, "stiffness": 3000.0})
    with pytest.raises(ValueError, match="a Renderer with stiffness=2000.0, but here stiffness=3000.0"):
        stiffer.set_state(state)
    with pytest.raises(ValueError, match="the state is of a Renderer, not of a World"):
        floor().set_state(state)
    with pytest.raises(ValueError, match="method='coupled', but here method='basic'"):
        floor().replace(method="basic", soft_start=0.0).set_state(floor().replace(method="coupled").get_state())


def test_a_changed_array_changes_no_contact() -> None:
    stiffness = np.array([500.0, 1000.0, 2000.0])
    given = {**contacts().parameters, "stiffness": stiffness}
    many, other = palpate.Renderers(3, **given), contacts()
    stiffness[:] = 1.0
    many.step(place(many, 1))
    other.step(place(other, 1))
    assert (many.copy().step(place(many, 2)) == other.step(place(other, 2))).all()
    with pytest.raises(ValueError, match="read-only"):
        many.parameters["stiffness"][0] = 1.0


def test_chosen_contacts_are_reset() -> None:
    many, fresh = contacts(), contacts()
    for step in range(1, 30):
        many.step(place(many, step))
    many.reset([False, True, False])
    assert np.isnan(many.output["force_on_device_n"]).tolist() == [False, True, False]
    sampled = place(many, 3)
    assert many.step(sampled)[1] == fresh.step(sampled)[1]
    many.reset()
    assert np.isnan(many.output["force_on_device_n"]).all()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"mass": 0.1, "period": PERIOD}, "Renderers needs stiffness"),
        ({"stiffness": [1.0, 2.0], "mass": 0.1, "period": PERIOD}, r"stiffness has the shape \(2,\), but must be one value or have \(3,\)"),
        ({"stiffness": [1.0, -2.0, 3.0], "mass": 0.1, "period": PERIOD, "method": "basic"}, "row 1: stiffness is -2"),
        ({"stiffness": 1.0, "mass": 0.1, "period": PERIOD, "method": "basic", "stifness": 2.0}, "stifness"),
    ],
)
def test_wrong_arguments_are_named(arguments: dict[str, Any], said: str) -> None:
    with pytest.raises((TypeError, ValueError), match=said):
        palpate.Renderers(3, **arguments)


def test_wrong_arrays_are_named() -> None:
    many = contacts()
    with pytest.raises(ValueError, match=r"positions has the shape \(2,\), but must have \(3,\)"):
        many.step([0.0, 0.0])
    with pytest.raises(ValueError, match="out must be a writable array of 3 native doubles"):
        many.step(np.zeros(3), out=np.zeros(3, np.float32))  # type: ignore[arg-type]
    same = np.zeros(3)
    with pytest.raises(ValueError, match="out shares memory with an argument"):
        many.step(same, out=same)
    with pytest.raises(ValueError, match="mask must have 3 truth values"):
        many.reset([1, 0, 1])
    assert len(many) == 3 and repr(many) == "<3 palpate.Renderers: coupled>"


def test_tensors_of_pytorch_are_read_and_written_without_a_copy() -> None:
    torch = pytest.importorskip("torch")
    many, other = contacts(), contacts()
    sampled, out = torch.full((3,), 1e-3, dtype=torch.float64), torch.zeros(3, dtype=torch.float64)
    assert many.step(sampled, out=out) is out
    assert out.tolist() == other.step(np.full(3, 1e-3)).tolist()
