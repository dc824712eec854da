"""A world of several devices in one loop: each is told apart, and what one of them cannot takes the force off all.

What is waited for is an event, for as long as a busy machine may need.
"""

from __future__ import annotations

import contextlib
import pickle
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import palpate
import pytest

from conftest import Program
from test_loop import ENDS, NONE, PATIENCE, ends_at_zero, loop, read_until, until, wall
from test_loop_world import FLOOR, world

NAMES = ("left", "right")


def pinch(**changes: Any) -> palpate.World:
    return palpate.World(Path(__file__).parents[3] / "experiments/worlds/pinch.toml", **changes)


def fingers(model: palpate.World) -> dict[str, palpate.devices.PointerInWorld]:
    return {name: palpate.devices.PointerInWorld(model, name) for name in NAMES}


def side_by_side(**changes: Any) -> palpate.World:
    """Two tools that begin 5 mm deep in a floor, of 300 N/m on the left and of 600 N/m on the right."""
    devices = [
        {
            "name": name,
            "mass_kg": 0.25,
            "position_m": [x, 0.0, 0.005],
            "tool": {"sphere": {"radius_m": 0.01}},
            "hand": {"stiffness_n_per_m": 200.0, "damping_n_s_per_m": 10.0, "rest_m": [x, 0.0, 0.005]},
        }
        for name, x in zip(NAMES, (-0.05, 0.05))
    ]
    contacts = [
        {"between": [name, "floor"], "stiffness_n_per_m": stiffness} for name, stiffness in zip(NAMES, (300.0, 600.0))
    ]
    return world([FLOOR], contacts, **{"devices": devices, **changes})


def of(devices: np.ndarray, number: int) -> np.ndarray:
    return devices[devices["device"] == number]


def test_each_device_has_its_hand_its_force_and_its_rows() -> None:
    model = pinch()
    hands = fingers(model)
    assert hands["right"].target == (0.0202, -0.0003, 0.016) and hands["right"].device == "right"
    with loop(hands, model) as running:
        assert running.device_names == NAMES
        assert running.body_names == ("cube", "table", *NAMES)
        assert running.device_name == "left: pointer, right: pointer"
        hands["left"].move_to([-0.014, 0.0005, 0.016])
        hands["right"].move_to([0.014, -0.0003, 0.016])

        def are_pushed_back() -> bool:
            ticks = running.read(wait=PATIENCE)
            devices = running.devices
            assert devices.dtype == palpate.DEVICES
            # Every tick has a row of each device.
            for number in (0, 1):
                assert (of(devices, number)["sequence"] == np.unique(ticks["sequence"])).all()
            left, right = (of(devices, number)["delivered_force_n"][:, 0] for number in (0, 1))
            return bool(((left < -0.5) & (right > 0.5)).any())

        until("both fingers to be pushed back", are_pushed_back)
        status = running.status
        assert len(status.forces) == 2 and status.force == status.forces[0]
    assert running.status.forces == (NONE, NONE)
    assert running.report is not None and running.report.failure is None and running.report.device is None


def test_devices_and_hands_of_the_world_press_each_as_deep_as_its_own_springs() -> None:
    model = side_by_side()
    with loop({name: palpate.devices.Simulated(model) for name in NAMES}, model) as running:
        # Equilibrium of floor and hand.
        depths = [0.005 * 200.0 / (200.0 + stiffness) for stiffness in (300.0, 600.0)]

        def are_at_rest() -> bool:
            running.read(wait=PATIENCE)
            places = [of(running.devices, number)["device_axes_m"][-1, 2] for number in (0, 1)]
            return bool(np.abs(0.01 - np.array(places) - depths).max() < 1e-4)

        until("both to rest", are_at_rest)
        forces = running.status.forces
    assert [force[2] for force in forces] == pytest.approx([300.0 * depths[0], 600.0 * depths[1]], abs=0.1)


def test_a_recording_is_what_was_read_and_the_program_reads_it(program: Program, tmp_path: Path) -> None:
    path = tmp_path / "pinch.mcap"
    model = pinch()
    hands = fingers(model)
    parts, devices = [], []
    with loop(hands, model, record=path) as running:
        hands["left"].move_to([-0.014, 0.0005, 0.016])
        hands["right"].move_to([0.014, -0.0003, 0.016])

        def touched() -> bool:
            parts.append(running.read(wait=PATIENCE))
            devices.append(running.devices)
            return bool((of(devices[-1], 1)["delivered_force_n"][:, 0] > 0.2).any())

        until("a force on the second", touched)
    parts.append(running.read())
    devices.append(running.devices)
    recording = palpate.read_recording(path)
    assert recording.complete, recording.shortcomings
    assert recording.ticks.tobytes() == np.concatenate(parts).tobytes()
    assert recording.devices.tobytes() == np.concatenate(devices).tobytes()
    assert recording.texts["devices"] == "left\nright\n"
    assert "frame right" in recording.texts and "safety left" in recording.texts
    again = pickle.loads(pickle.dumps(recording))
    assert again.devices.tobytes() == recording.devices.tobytes()
    assert program.json("info", path)["complete"]
    replayed = program.json("replay", path)
    assert replayed["methods"][0]["method"] == "coupled"
    # A loop of one device has no device rows.
    alone = tmp_path / "alone.mcap"
    with loop(palpate.devices.Pointer(), wall(), record=alone) as running:
        read_until(running, "a tick", len)
        assert len(running.devices) == 0 and running.device_names == ()
    assert len(palpate.read_recording(alone).devices) == 0


def test_a_world_of_several_devices_changes_while_it_runs() -> None:
    model = side_by_side()
    with loop(fingers(model), model) as running:
        read_until(running, "contact", lambda ticks: (ticks["penetration_m"] > 0).any())
        softer = [{"between": [name, "floor"], "stiffness_n_per_m": 150.0} for name in NAMES]
        assert running.change(contacts=softer) == 1
        ticks = read_until(running, "the change", lambda ticks: ticks["generation"][-1] == 1)
        changed = ticks[(ticks["generation"] == 1) & (ticks["penetration_m"] > 0)]
        assert set(changed["pair"]) == {0, 1}
        assert np.allclose(changed["contact_force_3_n"], 150.0 * changed["penetration_m"], rtol=1e-9)
        with pytest.raises(ValueError, match="devices"):
            running.change(pressed_alone())


def pressed_alone() -> palpate.World:
    return world([FLOOR], [{"between": ["tool", "floor"], "stiffness_n_per_m": 300.0}])


def test_wrong_devices_are_said_by_their_names() -> None:
    model = pinch()
    both = fingers(model)
    left = both["left"]
    for devices, rendered, message in [
        (left, model, "the world has the devices left and right; give one for each"),
        ({"left": left}, model, "there is no device for 'right'; the world has left and right"),
        ({**both, "thumb": left}, model, "the world has no device 'thumb'; it has left and right"),
        ({"left": left, "right": left}, model, "the device for 'right' is a PointerInWorld of 'left'"),
        ({"left": left, "right": palpate.devices.Pointer()}, model, "right: device moves along one axis"),
        ({"left": left, "right": palpate.devices.TwoDiy("/nowhere", normal=(0, 1))}, model, "right: normal is for a Renderer"),
        ({"tool": palpate.devices.Pointer()}, wall(), "device is a mapping of names, which is for a World"),
    ]:
        with pytest.raises(ValueError, match=re.escape(message)):
            loop(devices, rendered)  # type: ignore[arg-type]
    with pytest.raises(OSError, match="right: .*nowhere"):
        loop({"left": left, "right": palpate.devices.TwoDiy("/nowhere")}, model)
    for name, message in [(None, "device is not given, but must be one of the world's: left, right"), ("thumb", "device is 'thumb'")]:
        with pytest.raises(ValueError, match=message):
            palpate.devices.PointerInWorld(model, name)


@contextlib.contextmanager
def emulated(program: Program) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """An Inverse3 on a service of its own: its URL, and the process."""
    command = [str(program.path), "devices", "emulate", "inverse3", "--port", "0", "--events-port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as emulator:
        assert emulator.stdout is not None
        try:
            yield emulator.stdout.readline().strip(), emulator
        finally:
            emulator.kill()


def last_force(emulator: subprocess.Popen[str]) -> list[float]:
    emulator.send_signal(signal.SIGINT)
    _, said = emulator.communicate(timeout=PATIENCE)
    found = re.search(r"in the end \[?(.*?)\]? N", said)
    assert found, said
    return [float(force) for force in found[1].split(",")]


@pytest.mark.parametrize("gone", NAMES)
def test_a_device_that_has_gone_is_named_and_takes_the_force_off_the_other(gone: str, program: Program) -> None:
    model = side_by_side(loop={"period_s": 0.004})
    with emulated(program) as (left, on_left), emulated(program) as (right, on_right):
        devices = {"left": palpate.devices.Inverse3(left), "right": palpate.devices.Inverse3(right)}
        with pytest.raises(ValueError, match="left and right are one device, Inverse3 "):
            loop({"left": palpate.devices.Inverse3(left), "right": palpate.devices.Inverse3(left)}, model)
        with pytest.raises(palpate.LoopError, match=f"the device {gone} is gone"):
            with loop(devices, model) as running:
                until("a force on both", lambda: all(force[2] > 0.1 for force in running.status.forces))
                (on_left if gone == "left" else on_right).kill()
                while True:
                    running.read(wait=PATIENCE)
        assert running.report is not None and running.report.device == gone
        other = NAMES.index("right" if gone == "left" else "left")
        assert running.status.forces[other] == NONE
        assert any(f"device `{gone}`" in event.text for event in running.events())
        assert last_force(on_right if gone == "left" else on_left) == [0.0, 0.0, 0.0]


# The board and a simulated device.
RUNS = """
import math, os, sys, time
import palpate
ceiling = {{"name": "ceiling", "fixed": True, "shape": {{"half_space": {{"normal": [0, 0, -1], "offset_m": -0.01}}}}}}
tool = {{"sphere": {{"radius_m": 0.01}}}}
world = palpate.World(
    loop={{"period_s": 0.004}},
    devices=[
        {{"name": "other", "mass_kg": 0.25, "position_m": [0.1, 0.0, 0.0], "tool": tool}},
        {{"name": "board", "mass_kg": 0.25, "tool": tool}},
    ],
    bodies=[ceiling],
    contacts=[{{"between": [name, "ceiling"], "stiffness_n_per_m": 300.0}} for name in ("board", "other")],
    method="basic",
    soft_start=0.0,
)
device = palpate.devices.TwoDiy(sys.argv[1], start_pose=(130, 50), origin=(0.019, 0.11), world_axes=["x", "z"])
devices = {{"board": device, "other": palpate.devices.PointerInWorld(world, "other")}}
loop = palpate.Loop(devices, world, priority=0, stall_after_periods=50.0, oscillation=math.inf)
{begin}
    while not loop.status.forces[1][1] < -0.5:
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
@pytest.mark.parametrize("how", ["an exception in a block", "ctrl-C in a block", "killed"])
def test_however_python_ends_the_board_beside_another_device_holds_no_torque(how: str, program: Program, tmp_path: Path) -> None:
    assert how in ENDS
    ends_at_zero(RUNS, how, program, tmp_path)
