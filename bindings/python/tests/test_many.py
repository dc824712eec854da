"""Many contacts at once, and states to go back to."""

from __future__ import annotations

import copy
import pickle
import runpy
from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest

import palpate

ROOT = Path(__file__).resolve().parents[3]

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


def floors() -> Any:
    return palpate.Worlds(floor(), 3)


def place(of: Any, step: int) -> Any:
    at = 1e-3 * np.sin(0.1 * step)
    if isinstance(of, palpate.World):
        return (at, 0.5 * at, -2.0 * at)
    if isinstance(of, palpate.Worlds):
        return np.array([(at, 0.5 * at, -2.0 * at)] * 3) * [[0.5], [1.0], [1.5]]
    return np.full(3, at) if isinstance(of, palpate.Renderers) else at


@pytest.mark.parametrize("made", [contact, contacts, floor, floors])
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
    with pytest.raises(ValueError, match=r"out must be a writable array of the shape \(3,\), of native doubles"):
        many.step(np.zeros(3), out=np.zeros(3, np.float32))  # type: ignore[arg-type]
    same = np.zeros(3)
    with pytest.raises(ValueError, match="out shares memory with an argument"):
        many.step(same, out=same)
    with pytest.raises(ValueError, match="mask must have 3 truth values"):
        many.reset([1, 0, 1])
    assert len(many) == 3 and repr(many) == "<3 palpate.Renderers: coupled>"


TWO_DEVICES = """
format = 2
[loop]
period_s = 0.001
[[device]]
name = "left"
mass_kg = 0.2
inertia_kg_m2 = [1e-4, 1e-4, 1e-4]
tool = { sphere = { radius_m = 0.01 } }
[[device]]
name = "right"
mass_kg = 0.1
tool = { sphere = { radius_m = 0.01 } }
[[body]]
name = "ball"
mass_kg = 10.0
inertia_kg_m2 = [1e-3, 1e-3, 1e-3]
position_m = [0, 0, 0.0302]
shape = { sphere = { radius_m = 0.02 } }
[[body]]
name = "floor"
fixed = true
shape = { half_space = { normal = [0, 0, 1], offset_m = -0.02 } }
[[contact]]
between = ["*", "*"]
stiffness_n_per_m = 1000.0
friction = 0.3
"""


@pytest.mark.parametrize("method", ["basic", "coupled"])
def test_each_of_many_worlds_is_a_world_bit_by_bit(method: str) -> None:
    stiffnesses = np.linspace(200.0, 3000.0, 70)
    one = palpate.World.parse(TWO_DEVICES)
    law = one.to_dict()["contact"][0]
    alone = [one.replace(method=method, contacts=[{**law, "stiffness_n_per_m": value}]) for value in stiffnesses.tolist()]
    many = palpate.Worlds(alone)
    out = np.empty((70, 2, 6))
    deepest = np.linspace(0.0, 0.004, 70)
    for step in range(120):
        poses = np.zeros((70, 2, 7))
        poses[..., 3] = 1.0
        poses[:, 0, 2] = deepest * np.sin(0.015 * step)
        poses[:, 1, 0] = 0.032 - deepest * np.sin(0.015 * step)
        poses[:, 1, 2] = 0.03
        if step == 80:
            poses[9, 1, 0] = np.nan
        elapsed = 1e-3 * (1.0 + 0.1 * np.cos(np.arange(70))) if step % 2 else None
        assert many.step(poses, elapsed, out=out) is out
        for number, world in enumerate(alone):
            held = world.step(poses[number], None if elapsed is None else elapsed[number])
            assert (out[number] == held).all(), (step, number)
        if step in (80, 119):
            assert many.faults.tolist() == [(world.output.fault or "") if world.output else "" for world in alone]
            assert many.limited == [world.output.limited if world.output else () for world in alone]
    assert (np.abs(out[:, 0, 2]) > 0.1).mean() > 0.5
    assert (many.bodies["ball"].velocity == [world.bodies["ball"].velocity for world in alone]).all()
    assert many[-1].ledger == alone[-1].ledger and many[9].bodies["ball"].position.shape == (3,)


def test_a_body_is_moved_in_chosen_worlds() -> None:
    one = palpate.World.parse(TWO_DEVICES)
    many = palpate.Worlds(one, 4)
    starts = np.array([[0.0, 0.0, 0.0301 + 0.0002 * number] for number in range(4)])
    many.set_body("ball", position=starts, velocity=[0.0, 0.0, 0.01], mask=[True, True, True, False])
    moved = [one.replace(bodies=_ball_at(one, start, 0.01)) for start in starts[:3].tolist()]
    poses = np.zeros((4, 2, 7))
    poses[..., 3], poses[:, 1, 0] = 1.0, 0.2
    for step in range(40):
        poses[:, 0, 2] = 2e-5 * step
        held = many.step(poses)
        for number, world in enumerate([*moved, one]):
            assert (held[number] == world.step(poses[number])).all(), (step, number)
    assert np.abs(held[:, 0, 2]).max() > 0.1
    before = many.bodies["ball"].position
    turned = np.array([[1.0, 0.0, 0.0, 0.0]] * 4)
    turned[2] *= 1.1
    with pytest.raises(ValueError, match="world 2: .*orientation"):
        many.set_body("ball", orientation=turned)
    with pytest.raises(ValueError, match="body is 'bal', but must be one of ball, floor"):
        many.set_body("bal", position=[0.0, 0.0, 0.0])
    with pytest.raises(ValueError, match=r"velocity has the shape \(2,\), but must have \(3,\) or \(4, 3\)"):
        many.set_body("ball", velocity=[0.0, 0.0])
    assert (many.bodies["ball"].position == before).all()


def _ball_at(one: palpate.World, position: list[float], speed: float) -> list[dict[str, Any]]:
    bodies = one.to_dict()["body"]
    return [{**bodies[0], "position_m": position, "velocity_m_per_s": [0.0, 0.0, speed]}, *bodies[1:]]


def test_a_body_that_is_moved_during_a_loop_changes_the_force_without_a_step() -> None:
    world = floor().add(bodies=[{"name": "ball", "mass_kg": 10.0, "position_m": [0, 0, 1.0], "shape": {"sphere": {"radius_m": 0.03}}}])
    world = world.replace(contacts=[*world.to_dict()["contact"], {"between": ["tool", "ball"], "stiffness_n_per_m": 1000.0}])
    for _ in range(10):
        world.step([0.0, 0.0, 0.0])
    world.set_body("ball", position=[0.0, 0.0, 0.035])
    forces = np.array([world.step([0.0, 0.0, 0.0])[2] for _ in range(100)])
    assert (forces[:3] == 0.0).all() and np.abs(np.diff(forces)).max() < 0.5 and forces.min() < -2.0
    [contact] = [of for of in world.ledger.contacts if "ball" in of.between and of.stored > 0.0]
    came = contact.observed + contact.outside - contact.work - contact.dissipated + contact.step_error
    assert contact.outside > 0.01 and contact.stored == pytest.approx(came, abs=1e-12)
    before = world.ledger.bodies["ball"].outside
    kinetic = world.ledger.bodies["ball"].kinetic
    world.set_body("ball", velocity=[0.0, 0.0, 0.0])
    world.step([0.0, 0.0, 0.0])
    assert world.ledger.bodies["ball"].outside - before == pytest.approx(-kinetic)
    with pytest.raises(ValueError, match="a fixed body has no velocity"):
        world.set_body("floor", velocity=[0.0, 0.0, 1.0])
    with pytest.raises(ValueError, match="position has 2 numbers, but must have 3"):
        world.set_body("ball", position=[0.0, 0.0])


def test_a_field_is_a_table_and_has_a_row_in_the_ledger() -> None:
    detents = {"at_m": [0, 0, 0], "axis": [1, 0, 0], "positions": 3, "period_m": 0.01, "amplitude_j": 1e-3, "stiffness_n_per_m": 800.0}
    knob = palpate.World(
        loop={"period_s": PERIOD},
        devices=[{"name": "knob", "mass_kg": 0.1, "tool": {"sphere": {"radius_m": 0.008}}}],
        fields=[{"on": "knob", "potential": {"detents": detents}}],
        soft_start=0.0,
    )
    more = knob.add(fields=[{"on": "knob", "potential": {"constant": {"force_n": [0.0, 0.0, -0.5]}}}])
    for step in range(100):
        force = knob.step([2.5e-5 * step, 0.0, 0.0])
        both = more.step([2.5e-5 * step, 0.0, 0.0])
    # Halfway up the hill: pi A/p.
    assert force[0] == pytest.approx(-0.1 * np.pi, rel=0.01) and both[2] == pytest.approx(-0.5, rel=1e-6)
    [field] = knob.ledger.fields
    assert field.device == "knob" and field.stored == pytest.approx(5e-4, rel=0.05)
    assert field.stored == pytest.approx(field.observed + field.outside + field.supplied - field.work + field.step_error)
    assert [len(of.ledger.fields) for of in (more, more.replace(fields=[]))] == [2, 0]


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: palpate.Worlds(floor()), "count is None, but must be an integer of at least 1"),
        (lambda: palpate.Worlds([]), "there is no world"),
        (lambda: palpate.Worlds([floor(), palpate.World.parse(TWO_DEVICES)]), "world 1 has left, right, ball, floor with samples of 7 numbers, but world 0 has tool, floor"),
        (lambda: palpate.Worlds(["floor.toml"]), "world 0 is a str, but must be a palpate.World"),  # type: ignore[list-item]
        (lambda: floors().step(np.zeros((3, 2))), r"positions has the shape \(3, 2\), but must have \(3, 3\)"),
        (lambda: floors().step(np.zeros((3, 3)), [1.0]), r"elapsed has the shape \(1,\), but must be a number or have \(3,\)"),
        (lambda: floors().set_state(floor().get_state()), "the state is of a World, not of a Worlds"),
        (lambda: floors()[3], "out of range"),
    ],
)
def test_wrong_arguments_of_many_worlds_are_named(make: Callable[[], Any], said: str) -> None:
    with pytest.raises((TypeError, ValueError, IndexError), match=said):
        make()


def test_tensors_of_pytorch_are_read_and_written_without_a_copy() -> None:
    torch = pytest.importorskip("torch")
    many, other = contacts(), contacts()
    sampled, out = torch.full((3,), 1e-3, dtype=torch.float64), torch.zeros(3, dtype=torch.float64)
    assert many.step(sampled, out=out) is out
    assert out.tolist() == other.step(np.full(3, 1e-3)).tolist()


def test_a_traced_function_of_jax_calls_many_worlds() -> None:
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    many, other = floors(), floors()
    result = jax.ShapeDtypeStruct((3, 3), np.float64)
    step = jax.jit(lambda positions: 2.0 * jax.pure_callback(lambda rows: many.step(np.asarray(rows)), result, positions))
    for tick in range(1, 20):
        sampled = place(other, tick)
        forces = other.step(sampled)
        assert np.asarray(step(sampled)).tolist() == (2.0 * forces).tolist()
    assert np.abs(forces).max() > 0.1


def test_the_environment_of_gymnasium_repeats_and_starts_again() -> None:
    pytest.importorskip("gymnasium")
    peg = runpy.run_path(str(ROOT / "bindings/python/examples/gymnasium_peg.py"))

    def steps(seed: int) -> Any:
        pegs = peg["PegInHole"](3, max_steps=30)
        seen, _ = pegs.reset(seed=seed)
        rows = []
        for step in range(40):
            seen, reward, terminated, truncated, _ = pegs.step(peg["feels"](seen, step))
            assert pegs.observation_space.contains(seen) and not terminated.any()
            rows.append((seen, reward, truncated))
        return rows

    rows = steps(1)
    assert all((one == other).all() for row, again in zip(rows, steps(1)) for one, other in zip(row, again))
    assert not (rows[0][0] == steps(2)[0][0]).all()
    assert [row[2].all() for row in rows] == [step == 29 for step in range(40)]
    # The peg presses on the edge, and its next start is above it.
    assert 0.3 < rows[29][0][:, 8].mean() < 3.0 and (rows[30][0][:, 6:9] == 0.0).all() and (rows[30][1] == 0.0).all()
