"""A world on a device in real time: what the loop tells of it, and that it leaves no force.

What is waited for is an event, for as long as a busy machine may need.
"""

from __future__ import annotations

import gc
import math
import pickle
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import palpate
import pytest

from conftest import Program
from test_loop import ENDS, NONE, PATIENCE, ends_at_zero, loop, read_until, threads_here, until, wall

FLOOR = {"name": "floor", "fixed": True, "shape": {"half_space": {"normal": [0, 0, 1], "offset_m": 0.0}}}


def world(bodies: list[dict[str, Any]], contacts: list[dict[str, Any]], **changes: Any) -> palpate.World:
    tables: dict[str, Any] = {
        "loop": {"period_s": 0.002},
        "devices": [
            {
                "name": "tool",
                "mass_kg": 0.25,
                "position_m": [0.0, 0.0, 0.005],
                "tool": {"sphere": {"radius_m": 0.01}},
                "hand": {"stiffness_n_per_m": 200.0, "damping_n_s_per_m": 10.0, "rest_m": [0.0, 0.0, 0.005]},
            }
        ],
        "bodies": bodies,
        "contacts": contacts,
        "method": "basic",
        "soft_start": 0.0,
    }
    return palpate.World(**{**tables, **changes})


def pressed(**changes: Any) -> palpate.World:
    """A tool that begins 5 mm deep in a floor of 300 N/m."""
    return world([FLOOR], [{"between": ["tool", "floor"], "stiffness_n_per_m": 300.0}], **changes)


def ball(**changes: Any) -> palpate.World:
    """A floor, and a ball beside the tool, which nothing but the tool moves along x."""
    free = {"name": "ball", "mass_kg": 0.1, "position_m": [0.045, 0, 0.05], "shape": {"sphere": {"radius_m": 0.03}}}
    contacts = [
        {"between": ["tool", "ball"], "stiffness_n_per_m": 400.0},
        {"between": ["tool", "floor"], "stiffness_n_per_m": 300.0},
    ]
    above: dict[str, Any] = {"name": "tool", "mass_kg": 0.25, "position_m": [0.0, 0.0, 0.05]}
    above["tool"] = {"sphere": {"radius_m": 0.01}}
    return world([FLOOR, free], contacts, devices=[above], **changes)


def test_ticks_are_numbered_without_a_gap_and_show_the_spring_of_the_floor() -> None:
    model = pressed()
    device = palpate.devices.PointerInWorld(model)
    assert device.target == (0.0, 0.0, 0.005)
    with loop(device, model) as running:
        ticks = read_until(running, "100 ticks in contact", lambda ticks: (ticks["penetration_m"] > 0).sum() >= 100)
        assert running.status.running and running.status.lost == 0
        assert running.contact_names == (("tool", "floor"),) and running.body_names == ("floor", "tool")
        assert running.parameters == {}
        with pytest.raises(TypeError, match="a world has no table stiffness"):
            running.change(stiffness=400.0)
    assert ticks.dtype == palpate.RECORDED
    assert (ticks["sequence"] == np.arange(len(ticks))).all()
    assert (np.diff(ticks["t_s"]) > 0).all()
    inside = ticks[ticks["penetration_m"] > 0]
    # The normal of a contact between tool and floor points towards the tool.
    assert np.allclose(inside["contact_normal_3"], 1.0)
    assert np.allclose(inside["contact_force_3_n"], 300.0 * inside["penetration_m"], rtol=1e-9)
    assert np.allclose(inside["commanded_force_3_n"], inside["contact_force_3_n"], rtol=1e-9)
    assert np.allclose(inside["penetration_m"], 0.01 - inside["device_axis_3_m"], rtol=1e-9)


def test_the_hand_turns_a_device_of_six_axes(root: Any) -> None:
    model = palpate.World("experiments/worlds/box.toml")
    device = palpate.devices.PointerInWorld(model)
    assert device.orientation is None
    aim = np.array([np.cos(0.2), 0.0, np.sin(0.2), 0.0])
    with loop(device, model) as running:
        device.turn_to(2.0 * aim)
        assert device.orientation == pytest.approx(tuple(aim))
        device.move_to([0.0, 0.0, 0.08])

        def is_turned() -> bool:
            ticks = running.read(wait=PATIENCE)
            turned = np.stack([ticks[f"device_orientation_{part}"][-1:] for part in "wxyz"], axis=-1)
            return bool((np.abs(turned @ aim) > 0.999).any())

        until("the box to be turned", is_turned)
    device.turn_to(None)
    assert device.orientation is None
    with pytest.raises(ValueError, match="of a length above 0"):
        device.turn_to([0.0] * 4)
    with pytest.raises(ValueError, match="must have"):
        device.turn_to([1.0, 0.0, 0.0])


def test_a_ball_that_is_pushed_moves_and_its_bodies_are_of_the_ticks_that_were_read() -> None:
    model = ball()
    device = palpate.devices.PointerInWorld(model)
    parts, bodies = [], []
    with loop(device, model) as running:
        device.move_to([0.02, 0.0, 0.05])

        def has_moved() -> bool:
            parts.append(running.read(wait=PATIENCE))
            bodies.append(running.bodies)
            return bool((bodies[-1]["velocity_m_per_s"][bodies[-1]["body"] == 1, 0] > 0.01).any())

        until("the ball to move", has_moved)
        names = running.body_names
    ticks, model = np.concatenate(parts), np.concatenate(bodies)
    assert model.dtype == palpate.BODIES and names == ("floor", "ball", "tool")
    # Every tick has rows of the ball and the proxy; fixed bodies have none.
    for number in (1, 2):
        assert (model["sequence"][model["body"] == number] == np.unique(ticks["sequence"])).all()
    assert set(model["body"]) == {1, 2}
    free = model[model["body"] == 1]
    assert np.allclose(free["position_m"][0], [0.045, 0.0, 0.05]) and (free["velocity_m_per_s"][0] == 0).all()
    assert free["position_m"][-1, 0] > 0.045
    assert np.allclose(np.linalg.norm(free["orientation"], axis=1), 1.0)
    # The contact of tool and ball gives the force.
    touched = ticks[ticks["penetration_m"] > 0]
    assert {running.contact_names[pair] for pair in touched["pair"]} == {("tool", "ball")}
    # A second read returns no bodies.
    running.read()
    running.read()
    assert len(running.bodies) == 0


def test_it_leaves_no_force_at_the_end_of_the_block_at_an_exception_and_when_it_is_forgotten() -> None:
    def started() -> palpate.Loop:
        model = pressed()
        return loop(palpate.devices.PointerInWorld(model), model)

    def touches(running: palpate.Loop) -> None:
        until("a force", lambda: running.status.force[2] > 0.5)

    with started() as running:
        touches(running)
    assert running.status.force == NONE and not running.status.running
    assert running.report is not None and running.report.ending == "stopped on request"

    class Own(Exception):
        pass

    with pytest.raises(Own):
        with started() as running:
            touches(running)
            raise Own
    assert running.status.force == NONE

    forgotten = started()
    forgotten.start()
    touches(forgotten)
    assert "palpate loop" in threads_here()
    del forgotten
    gc.collect()
    until("the end of the loop's thread", lambda: "palpate loop" not in threads_here())


def test_python_that_computes_without_a_break_keeps_no_tick_waiting() -> None:
    model = pressed()
    with loop(palpate.devices.PointerInWorld(model), model) as running:
        read_until(running, "the start", lambda ticks: len(ticks) > 10)
        before = running.status.ticks
        # A single C call that holds the GIL until it returns.
        assert pow(3, 2_000_000)
        assert running.status.ticks > before + 10


def test_of_a_ring_that_nobody_reads_the_newest_stay_with_their_bodies() -> None:
    model = ball()
    with loop(palpate.devices.PointerInWorld(model), model, ring=20) as running:
        until("a full ring", lambda: running.status.ticks > 60)
        ticks = running.read()
        assert len(ticks) <= 20 and running.status.lost > 0
        assert (np.diff(ticks["sequence"].astype(int)) == 1).all()
        assert set(running.bodies["sequence"]) == set(ticks["sequence"])


def test_the_device_and_the_hand_of_a_world() -> None:
    """The hand rests 5 mm deep in the floor, and the device comes to where both springs agree."""
    model = pressed()
    with loop(palpate.devices.Simulated(model), model) as running:
        depth = 0.005 * 200.0 / 500.0
        ticks = read_until(running, "the balance", lambda ticks: abs(ticks["penetration_m"][-1] - depth) < 1e-4)
    assert ticks["device_axis_3_m"][0] == pytest.approx(0.005, abs=2e-4)


def test_a_hand_leads_its_device_through_space_and_lets_go() -> None:
    model = ball()
    device = palpate.devices.PointerInWorld(model)
    with loop(device, model) as running:
        device.move_to([-0.02, 0.03, 0.06])

        def is_there(ticks: np.ndarray) -> bool:
            at = [ticks[f"device_axis_{axis}_m"][-1] for axis in (1, 2, 3)]
            return bool(np.abs(np.array(at) - [-0.02, 0.03, 0.06]).max() < 1e-4)

        read_until(running, "the target", is_there)
        device.disable_output()
        assert device.target is None
        with pytest.raises(ValueError, match="target has a coordinate of NaN m"):
            device.move_to([0.0, math.nan, 0.0])
        with pytest.raises(ValueError, match=r"target has the shape \(2,\)"):
            device.move_to([0.0, 0.0])


def test_a_recording_is_what_was_read_and_the_program_reads_it(program: Program, tmp_path: Path) -> None:
    path = tmp_path / "ball.mcap"
    model = ball(method="coupled")
    device = palpate.devices.PointerInWorld(model)
    parts, bodies = [], []
    with loop(device, model, record=path) as running:
        device.move_to([0.02, 0.0, 0.05])

        def touched() -> bool:
            parts.append(running.read(wait=PATIENCE))
            bodies.append(running.bodies)
            return sum((part["penetration_m"] > 0).sum() for part in parts) > 3

        until("contact", touched)
    parts.append(running.read())
    bodies.append(running.bodies)
    recording = palpate.read_recording(path)
    assert recording.complete, recording.shortcomings
    assert running.report is not None and running.report.unrecorded == 0
    assert recording.ticks.tobytes() == np.concatenate(parts).tobytes()
    assert recording.bodies.tobytes() == np.concatenate(bodies).tobytes()
    assert "[[body]]" in recording.texts["world"] and 'name = "coupled"' in recording.texts["method"]
    assert 'axes = ["x", "y", "z"]' in recording.texts["frame"]
    again = pickle.loads(pickle.dumps(recording))
    assert again.bodies.tobytes() == recording.bodies.tobytes()
    assert program.json("info", path)["complete"]
    # The recording replays as a recording of the program does.
    replayed = program.json("replay", path)
    assert replayed["methods"][0]["method"] == "coupled"


def test_a_device_of_six_axes_turns_and_gets_a_torque() -> None:
    peg = palpate.World(Path(__file__).parents[3] / "experiments/worlds/peg.toml")
    torques = [f"commanded_torque_{axis}_n_m" for axis in (1, 2, 3)]

    def is_turned(ticks: Any) -> bool:
        return bool((np.abs(ticks["device_orientation_x"]) > 1e-4).any() and (np.abs(ticks[torques[0]]) > 1e-4).any())

    with loop(palpate.devices.Simulated(peg), peg) as running:
        ticks = read_until(running, "a torque", is_turned)
    turns = np.stack([ticks[f"device_orientation_{part}"] for part in "wxyz"])
    assert np.allclose((turns**2).sum(axis=0), 1.0)


def test_wrong_devices_and_worlds_are_said() -> None:
    model = pressed()
    pointer = palpate.devices.PointerInWorld(model)
    two = world(
        [FLOOR],
        [],
        devices=[{"name": name, "mass_kg": 0.2, "tool": {"sphere": {"radius_m": 0.01}}} for name in ("one", "other")],
    )
    contact = wall()
    for device, rendered, message in [
        (palpate.devices.Pointer(), model, "a world runs on palpate.devices.PointerInWorld"),
        (pointer, contact, "device is for a World"),
        (palpate.devices.Simulated(model), contact, "device is for a World"),
        (palpate.devices.Simulated(two), two, "the world has the devices one and other; give one for each"),
        (palpate.devices.TwoDiy("/nowhere", normal=(0, 1)), model, "normal is for a Renderer"),
        (palpate.devices.Inverse3("ws://127.0.0.1:1", normal=(0, 1, 0)), model, "normal is for a Renderer"),
    ]:
        with pytest.raises(ValueError, match=re.escape(message)):
            loop(device, rendered)  # type: ignore[arg-type]
    with pytest.raises(OSError, match="nowhere"):
        loop(palpate.devices.TwoDiy("/nowhere"), model)
    for changes, message in [({"ring": 0}, "ring is 0 ticks"), ({"range": (-1.0, 1.0)}, "range is for a Renderer")]:
        with pytest.raises(ValueError, match=message):
            loop(pointer, model, **changes)


def test_an_inverse3_stands_in_a_world(program: Program) -> None:
    command = [str(program.path), "devices", "emulate", "inverse3", "--port", "0", "--events-port", "0"]
    # At the initial cursor position the tool is 5 mm deep in the floor. The device's y axis points down in this world.
    model = pressed(loop={"period_s": 0.004})
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as emulator:
        assert emulator.stdout is not None
        url = emulator.stdout.readline().strip()
        for axes, message in [
            (["x", "y"], "2 for the 3 axes"),
            (["x", "x", "z"], "the same axis of the world, x"),
            (["x", "up", "z"], 'world_axes names "up"'),
        ]:
            with pytest.raises(ValueError, match="world_axes.*" + re.escape(message.split("world_axes ")[-1])):
                loop(palpate.devices.Inverse3(url, world_axes=axes), model)
        with pytest.raises(ValueError, match="world_axes is for a World"):
            loop(palpate.devices.Inverse3(url, world_axes=["x", "y", "z"]), wall(period=0.004))
        device = palpate.devices.Inverse3(url, world_axes=["x", "-z", "y"])
        with loop(device, model) as running:
            until("a force", lambda: running.status.force[1] < -0.1)
            x, y, z = running.status.force
            assert (x, z) == (0.0, 0.0) and y < 0
            assert "nverse3" in running.device_name
        assert running.status.force == NONE
        emulator.send_signal(signal.SIGINT)
        _, said = emulator.communicate(timeout=PATIENCE)
    found = re.search(r"in the end \[?(.*?)\]? N", said)
    assert found and [float(force) for force in found[1].split(",")] == [0.0, 0.0, 0.0], said


RUNS = """
import math, os, sys, time
import palpate
ceiling = {{"name": "ceiling", "fixed": True, "shape": {{"half_space": {{"normal": [0, 0, -1], "offset_m": -0.01}}}}}}
world = palpate.World(
    loop={{"period_s": 0.004}},
    devices=[{{"name": "tool", "mass_kg": 0.25, "tool": {{"sphere": {{"radius_m": 0.01}}}}}}],
    bodies=[ceiling],
    contacts=[{{"between": ["tool", "ceiling"], "stiffness_n_per_m": 300.0}}],
    method="basic",
    soft_start=0.0,
)
device = palpate.devices.TwoDiy(sys.argv[1], start_pose=(130, 50), origin=(0.019, 0.11), world_axes=["x", "z"])
loop = palpate.Loop(device, world, priority=0, stall_after_periods=50.0, oscillation=math.inf)
{begin}
    while not loop.status.force[1] < -0.5:
        if loop.status.motors_off or not loop.status.running:
            print("lost", flush=True)
            os._exit(0)
        loop.read(wait=60.0)
        time.sleep(0.001)
    print("presses", flush=True)
    sys.stdin.readline()
    {then}
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the emulated board needs Linux")
@pytest.mark.parametrize("how", ENDS)
def test_however_python_ends_the_board_holds_no_torque(how: str, program: Program, tmp_path: Path) -> None:
    ends_at_zero(RUNS, how, program, tmp_path)
