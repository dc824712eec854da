"""`Renderer`, sample by sample."""

from __future__ import annotations

import math
import pickle
from typing import Any

import numpy as np
import pytest

import palpate

CONTACT: dict[str, Any] = {"stiffness": 400.0, "mass": 0.1, "period": 1e-3, "device_mass": 0.25}
PIPED = "force,force_on_object,object_position,object_velocity,penetration,proxy_shift,phase,stored_energy"
LEDGER = "port_work,virtual_force_work,outside_work,leak_original,leak_held"


def piped(program: Any, positions: list[float], *flags: object, mass: object = 0.1) -> list[list[str]]:
    """What `palpate pipe` answers to each position; its last line ends the force and is left out."""
    given = "".join(f"{position!r}\n" for position in positions)
    flags = ("--stiffness", 400, "--mass", mass, "--period", 0.001, "--device-mass", 0.25, *flags)
    lines = program("pipe", *flags, "--columns", f"{PIPED},{LEDGER},limited,fault", given=given).splitlines()
    assert len(lines) == len(positions) + 1
    return [line.split(",") for line in lines[:-1]]


def answered(renderer: palpate.Renderer, positions: list[float]) -> list[list[Any]]:
    rows = []
    for position in positions:
        force = renderer.step(position)
        output, ledger = renderer.output, renderer.ledger
        assert output is not None and output.force_on_device == force
        rows.append(
            [
                force,
                None,
                output.object_position,
                output.object_velocity,
                output.penetration,
                output.proxy_shift,
                output.phase,
                ledger.stored,
                ledger.port_work,
                ledger.virtual_force_work,
                ledger.outside_work,
                ledger.original_leak.accumulated,
                ledger.held_leak.accumulated,
                " ".join(output.limited),
                output.fault or "",
            ]
        )
    return rows


def same(rows: list[list[Any]], lines: list[list[str]]) -> None:
    assert len(rows) == len(lines)
    for row, line in zip(rows, lines):
        for ours, theirs in zip(row, line):
            if isinstance(ours, float):
                assert ours == float(theirs), (row, line)
            elif ours is not None:
                assert ours == theirs, (row, line)


@pytest.mark.parametrize("method", palpate.METHODS)
def test_every_method_gives_the_numbers_of_the_pipe_to_the_last_bit(program: Any, method: str) -> None:
    positions = [0.01 * math.sin(0.02 * i) - 0.002 for i in range(700)]
    positions[300] = math.nan
    renderer = palpate.Renderer(**CONTACT, method=method, force=-0.981)
    rows = answered(renderer, positions)
    same(rows, piped(program, positions, "--method", method, "--force", -0.981))
    assert max(abs(row[0]) for row in rows) > 0.1
    assert rows[300][-1] == "position-not-finite" and rows[300][0] == 0.0


def test_the_force_is_limited_and_comes_in_softly_as_in_the_pipe(program: Any) -> None:
    inside = [0.08] * 300
    rows = answered(palpate.Renderer(**{**CONTACT, "mass": math.inf}), inside)
    lines = piped(program, inside, mass="inf")
    same(rows, lines)
    forces = [abs(row[0]) for row in rows]
    assert forces[0] == 0.0 and max(forces) == 20.0 and "soft-start" in rows[10][-2]
    free = palpate.Renderer(**{**CONTACT, "mass": math.inf}, force_limit=math.inf, soft_start=0, method="basic")
    assert free.step(0.08) == -32.0
    limited = palpate.Renderer(**{**CONTACT, "mass": math.inf}, force_limit=5, soft_start=0, method="basic")
    assert limited.step(0.08) == -5.0
    assert limited.output is not None and limited.output.limited == ("force",)


def test_a_measured_time_and_a_force_count_for_their_sample() -> None:
    def after(elapsed: float | None, force: float | None) -> float:
        renderer = palpate.Renderer(**CONTACT, method="basic", object_position=0.0)
        renderer.step(-0.001)
        renderer.step(-0.001, elapsed=elapsed, force=force)
        renderer.step(-0.001)
        assert renderer.output is not None
        return renderer.output.object_position

    assert after(None, None) == 0.0
    # f_V / M over a period of 1 ms, from rest: half of g t^2.
    assert after(None, -0.2) == pytest.approx(-0.5 * 2.0 * 1e-6, rel=1e-9)
    late = palpate.Renderer(**CONTACT, method="basic", largest_gap=0.01)
    late.step(0.0)
    late.step(0.0, elapsed=0.02)
    assert late.output is not None and late.output.fault == "gap-too-long"


def test_the_side_mirrors_forces() -> None:
    forces = []
    for side, sign in (("positive", 1.0), ("negative", -1.0)):
        renderer = palpate.Renderer(**CONTACT, side=side)
        forces.append([sign * renderer.step(sign * 1e-4 * i) for i in range(-10, 50)])
    assert forces[0] == forces[1] and min(forces[0]) < -0.1


def test_a_reset_begins_anew_and_a_teleport_is_booked() -> None:
    renderer = palpate.Renderer(**CONTACT)
    assert renderer.output is None
    first = [renderer.step(1e-4 * i) for i in range(50)]
    renderer.reset()
    assert renderer.output is None and renderer.ledger.stored == 0.0
    assert [renderer.step(1e-4 * i) for i in range(50)] == first
    renderer.teleport(0.1)
    renderer.step(50e-4)
    assert renderer.output is not None and renderer.output.object_position == 0.1
    assert renderer.ledger.outside_work < 0.0


def test_ledger_records_the_reported_sent_force() -> None:
    work = []
    for sent in (None, 0.0):
        renderer = palpate.Renderer(**{**CONTACT, "mass": math.inf}, method="basic", soft_start=0)
        renderer.step(0.001)
        if sent is not None:
            renderer.report_sent(sent)
        renderer.step(0.002)
        work.append(renderer.ledger.port_work)
    assert work == [pytest.approx(400 * 0.001 * 0.001), 0.0]


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"stiffness": -1}, "stiffness is -1 N/m, but must be finite and greater than 0"),
        ({"mass": math.nan}, "mass is NaN kg, but must be finite and greater than 0"),
        ({"period": 0}, "period is 0 s, but must be finite and greater than 0"),
        ({"force": math.inf}, "force is inf N, but must be finite"),
        ({"object_position": math.inf}, "object_position is inf m, but must be finite"),
        ({"mass": math.inf, "object_velocity": 1.0}, "object_velocity is 1 m/s, but must be 0 for a wall"),
        ({"side": "left"}, 'side is "left", but must be "positive" or "negative"'),
        ({"guard": "on"}, 'guard is "on", but must be "off" or "report" or "limit"'),
        ({"force_limit": 0.0}, "force_limit is 0 N, but must be finite and greater than 0"),
        ({"soft_start": -1}, "soft_start is -1 s, but must be 0 to 60"),
        ({"slew_limit": -1}, "slew_limit is -1 N/s, but must be finite and greater than 0"),
        ({"speed_limit": 0}, "speed_limit is 0 m/s, but must be finite and greater than 0"),
        ({"largest_gap": 1e-4}, "largest_gap is 0.0001 s, but must be finite and at least one period"),
        ({"guard": "limit", "guard_speed": 0}, "guard_speed is 0 m/s, but must be finite and greater than 0"),
        ({"guard": "limit", "guard_acceleration": 0}, "guard_acceleration is 0 m/s^2, but must be finite and greater than 0"),
        (
            {"guard": "limit", "guard_acceleration": 80, "guard_mass": 0},
            "guard_mass is 0 kg, but must be finite and greater than 0",
        ),
        ({"guard": "limit", "guard_mass": 0.1}, "guard_mass and guard_learn_mass need guard_acceleration or guard_hand_force"),
        ({"guard": "limit", "guard_hand_force": 0}, "guard_hand_force is 0 N, but must be finite and greater than 0"),
        (
            {"guard": "limit", "guard_acceleration": 80, "guard_hand_force": 10},
            "guard_hand_force excludes guard_acceleration; give one",
        ),
        ({"guard": "limit", "guard_recovery": -1}, "guard_recovery is -1 W, but must be finite and not below 0"),
        ({"delay": 0.009}, "delay is 0.009 s, 9 periods, but must be at most 8 periods"),
        ({"delay": -1}, "delay is -1 s, but must be finite and not below 0"),
        ({"lag": -1}, "lag is -1 s, but must be finite and not below 0"),
        ({"gain": 0}, "gain is 0, but must be finite and greater than 0"),
        ({"device_mass": 0}, "device_mass is 0 kg, but must be finite and greater than 0"),
        ({"encoder_quantum": -1}, "encoder_quantum is -1 m, but must be finite and not below 0"),
        ({"device_mass": None}, "coupled needs device_mass [kg]: the effective mass of the device"),
        ({"method": "couplid"}, 'no method is called "couplid"; did you mean "coupled"?'),
        ({"method": ["basic", "seh"]}, "a Renderer renders by one method; name it with method"),
        (
            {"damping": 2.0},
            "damping cannot be used by method coupled; it is for virtual-damper, energy-tank, virtual-coupling, hfcr",
        ),
        ({"method": "virtual-damper", "damping": -2.0}, "damping is -2 N s/m, but must be finite and not below 0"),
        ({"method": "hfcr", "damping": "lots"}, "damping is 'lots', but must be a number [N s/m] or \"stability-optimal\" or \"auto\" or \"adaptive\""),
        ({"placement": 1.5}, "placement is 1.5, but must be True or False"),
    ],
)
def test_a_wrong_value_is_named_with_what_is_allowed(wrong: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError) as raised:
        palpate.Renderer(**{**CONTACT, **wrong})
    assert str(raised.value).startswith(words)


def test_a_wrong_name_or_type_is_a_type_error() -> None:
    with pytest.raises(TypeError, match="no parameter is called dampng; did you mean damping?"):
        palpate.Renderer(**CONTACT, dampng=2.0)
    with pytest.raises(TypeError, match="period"):
        palpate.Renderer(stiffness=400.0, mass=0.1)  # type: ignore[call-arg]
    with pytest.raises(TypeError):
        palpate.Renderer(**{**CONTACT, "stiffness": "400"})
    with pytest.raises(TypeError):
        palpate.Renderer(**CONTACT).step("near")  # type: ignore[arg-type]


def test_every_setting_of_every_method_is_taken_by_its_name() -> None:
    values: dict[str, Any] = {"True or False": False}
    taken = 0
    for method in palpate.METHODS.values():
        for setting in method.settings:
            word = setting.allowed.split('"')
            value = word[1] if setting.unit is None and len(word) > 1 else values.get(setting.allowed, 0.5)
            given = {setting.name: value}
            if setting.name == "window_error":
                given["prediction"] = "adaptive-window"
            try:
                renderer = palpate.Renderer(**CONTACT, method=method.name, **given)
            except ValueError as error:
                # A setting that applies only with a certain word of another setting.
                assert f"{setting.name} is for " in str(error)
                continue
            if setting.key in renderer.method_parameters:
                assert renderer.method_parameters[setting.key] == value
                taken += 1
    assert taken >= 5


def test_numbers_of_numpy_are_numbers() -> None:
    renderer = palpate.Renderer(
        stiffness=np.float32(400), mass=np.float64(0.1), period=np.float64(1e-3), device_mass=np.int64(1)
    )
    assert renderer.step(np.float32(-0.001)) == 0.0
    assert renderer.step(np.float32(0.001)) < 0.0


def test_parameters_are_pickled_and_a_renderer_is_not() -> None:
    renderer = palpate.Renderer(**CONTACT, method="hfcr", damping=0.5)
    with pytest.raises(TypeError, match="pickle its `parameters`"):
        pickle.dumps(renderer)
    again = palpate.Renderer(**pickle.loads(pickle.dumps(renderer.parameters)))
    assert again.parameters == renderer.parameters
    assert again.method_parameters == renderer.method_parameters
    assert renderer.method_parameters["damping_n_s_per_m"] == 0.5
    assert eval(repr(again), {"Renderer": palpate.Renderer}).parameters == renderer.parameters


def test_what_was_sent_and_a_number_that_is_too_large_are_refused_by_name() -> None:
    renderer = palpate.Renderer(**CONTACT)
    renderer.step(0.001)
    for wrong in (math.nan, math.inf):
        with pytest.raises(ValueError, match=f"(?i)force_on_device is {wrong} N, but must be finite"):
            renderer.report_sent(wrong)
    with pytest.raises(ValueError, match=r"stiffness is 1000+\.\.\.: int too large"):
        palpate.Renderer(**{**CONTACT, "stiffness": 10**400})
    excitation = palpate.Excitation(period=1e-3)
    with pytest.raises(ValueError, match="(?i)force is nan N, but must be finite"):
        excitation.report_sent(math.nan)
    with pytest.raises(ValueError, match="(?i)time is nan s, but must be finite"):
        excitation.step(0.0, time=math.nan)


def test_a_parameter_is_not_set_in_silence() -> None:
    renderer = palpate.Renderer(stiffness=400.0, mass=0.1, period=1e-3, device_mass=0.25)
    for name in ("force_limit", "stiffness", "guard", "force_limitt", "output", "parameters"):
        with pytest.raises(AttributeError):
            setattr(renderer, name, 1.0)
    with pytest.raises(AttributeError, match=r"force_limit is a parameter, which cannot be set on a Renderer: make another one by"):
        renderer.force_limit = 1.0  # type: ignore[attr-defined]
    for change in (
        lambda of: of.__setitem__("force_limit", 1.0),
        lambda of: of.update(force_limit=1.0),
        lambda of: of.pop("force_limit"),
    ):
        with pytest.raises(TypeError, match=r"change nothing: make another one by Renderer\("):
            change(renderer.parameters)
    assert {**renderer.parameters, "force_limit": 1.0} != renderer.parameters == dict(renderer.parameters)
    world = palpate.World(
        loop={"period_s": 0.001},
        devices=[{"name": "tool", "mass_kg": 0.2, "tool": {"sphere": {"radius_m": 0.01}}}],
        bodies=[{"name": "ball", "mass_kg": 0.1, "position_m": [0, 0, 0.05], "shape": {"sphere": {"radius_m": 0.03}}}],
        contacts=[{"between": ["tool", "ball"], "stiffness_n_per_m": 2000.0}],
    )
    with pytest.raises(AttributeError, match="torque_limit is a parameter.*world.replace"):
        world.torque_limit = 1.0  # type: ignore[attr-defined]

    class Logged(palpate.Renderer):
        def __init__(self, **_: object) -> None:
            self.log: list[float] = []

    logged = Logged(stiffness=400.0, mass=0.1, period=1e-3, device_mass=0.25)
    logged.log.append(logged.step(0.0))
    with pytest.raises(AttributeError, match="delay is a parameter"):
        logged.delay = 1.0  # type: ignore[attr-defined]


def test_a_simulated_device_checks_what_it_is_made_of() -> None:
    from palpate.engines import SimulatedDevice

    made = {"mass": 0.2, "position": [0, 0, 0], "stiffness": 60, "damping": 1.5, "rest": [0, 0, 0.0], "hand_force": [0, 0, 1], "period": 1e-3}
    device = SimulatedDevice(**made)  # type: ignore[arg-type]
    device.hold([0, 0, -1.0])
    np.testing.assert_array_equal(device.position, 0.0)
    device.rest = [0, 0, 0.01]  # type: ignore[assignment]
    device.hold([0.0, 0, 0])
    assert device.position[2] > 0
    for wrong, words in [
        ({"mass": 0.0}, "mass is 0.0"),
        ({"mass": [0.2, 0.2]}, "mass is"),
        ({"mass": math.nan}, r"mass\[\] is nan"),
        ({"position": [0, 0]}, r"position has the shape \(2,\)"),
        ({"rest": [0, 0, math.inf]}, r"rest\[2\] is inf"),
        ({"stiffness": -1.0}, "stiffness is -1.0, but must be finite and at least 0"),
        ({"damping": math.nan}, "damping is nan"),
        ({"period": 0.0}, "period is 0.0, but must be finite and above 0"),
        ({"hand_force": 1.0}, r"hand_force has the shape \(\)"),
    ]:
        with pytest.raises(ValueError, match=words):
            SimulatedDevice(**{**made, **wrong})  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"force\[0\] is nan"):
        device.hold([math.nan, 0, 0])
    with pytest.raises(ValueError, match="rest has the shape"):
        device.rest = [1.0]  # type: ignore[assignment]
    with pytest.raises(AttributeError, match="stiffness is a parameter"):
        device.stiffness = 1.0  # type: ignore[attr-defined]


@pytest.mark.parametrize("kind", ["renderer", "world"])
def test_created_energy_stops_the_forces(kind: str) -> None:
    """Held while the device leaves by 2 mm, 2 N create 4 mJ in each second period."""
    made: Any
    if kind == "renderer":
        made = palpate.Renderer(method="basic", period=0.001, stiffness=1000.0, mass=math.inf, soft_start=0)
    else:
        made = palpate.World(
            loop={"period_s": 0.001},
            devices=[{"name": "tool", "mass_kg": 0.2, "position_m": [0.0, 0.0, 0.0], "tool": {"sphere": {"radius_m": 0.0}}}],
            bodies=[{"name": "floor", "fixed": True, "shape": {"half_space": {"normal": [0.0, 0.0, 1.0], "offset_m": 0.0}}}],
            contacts=[{"between": ["tool", "floor"], "stiffness_n_per_m": 1000.0}],
            method="basic",
            soft_start=0,
        )

    def step(depth: float) -> float:
        return -made.step(depth) if kind == "renderer" else made.step([0.0, 0.0, -depth])[2]

    forces = [step(depth) for depth in 50 * [0.002, 0.0]]
    pushed = sum(force > 1.0 for force in forces)
    assert 10 <= pushed < 20 and not any(forces[40:])
    assert "safety-stop" in made.output.limited
    made.reset()
    assert step(0.002) == 2.0 and "safety-stop" not in made.output.limited


def test_a_line_hold_gives_a_mean_and_a_slope() -> None:
    line = palpate.Renderer(**{**CONTACT, "mass": math.inf}, hold="line", soft_start=0)
    # A free device of 0.25 kg flies into a wall of 400 N/m, under the line that it holds.
    position, speed, period, slopes = -0.00095, 0.1, 1e-3, []
    for _ in range(40):
        force = line.step(position)
        assert line.output is not None and line.output.force_on_device == force
        slope = line.output.slope_on_device
        start = force - 0.5 * slope * period
        position += speed * period + (0.5 * start + slope * period / 6) * period**2 / 0.25
        speed += force * period / 0.25
        if start < -0.2 and position > 0.0005:
            # The line ends at the force of the spring; a constant would be K v T/2 = 0.02 N off.
            assert force + 0.5 * slope * period == pytest.approx(-400 * position, abs=0.001)
            slopes.append(abs(slope))
    assert max(slopes) > 30
    line.report_sent(-0.5, -10.0)
    with pytest.raises(ValueError, match="slope_on_device"):
        line.report_sent(-0.5, math.nan)
    with pytest.raises(ValueError, match='hold is "lines", but must be "constant" or "line"'):
        palpate.Renderer(**CONTACT, hold="lines")
    with pytest.raises(ValueError, match="only coupled plans a line"):
        palpate.Renderer(**CONTACT, hold="line", method="hfcr")
    constant = palpate.Renderer(**CONTACT, method="basic")
    constant.step(0.001)
    assert constant.output is not None and constant.output.slope_on_device == 0.0


def test_a_hand_beyond_the_acceleration_of_the_guard_is_shown() -> None:
    renderer = palpate.Renderer(**CONTACT, object_position=1.0, guard="report", guard_acceleration=80.0)
    seen = []
    # 0.2 mm more within a millisecond is 200 m/s^2.
    for position in (-1e-3, -1e-3, -0.8e-3, -0.6e-3):
        renderer.step(position)
        assert renderer.output is not None
        seen.append(renderer.output.limited)
    assert seen == [(), (), ("beyond-guard",), ()]
