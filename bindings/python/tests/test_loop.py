"""A loop in real time beside Python: what it tells, how it changes, and that it leaves no force.

What is waited for is an event, for as long as a busy machine may need.
"""

from __future__ import annotations

import contextlib
import gc
import math
import multiprocessing
import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any, Callable, Iterator

import numpy as np
import palpate
import pytest

from conftest import Program

PATIENCE = 60.0
"""Nobody has to wait for so long but on a machine that does nothing else [s]."""
NONE = (0.0, 0.0, 0.0)


def wall(**changes: Any) -> palpate.Renderer:
    given = {"stiffness": 300.0, "mass": math.inf, "period": 0.002, "method": "basic", "soft_start": 0.0}
    return palpate.Renderer(**{**given, **changes})


def pressing(**changes: Any) -> palpate.devices.Pointer:
    """A device in a hand that presses 10 mm deep into a wall at 0."""
    return palpate.devices.Pointer(position=0.01, **changes)


def loop(device: palpate.devices.Device, renderer: palpate.Renderer, **changes: Any) -> palpate.Loop:
    # Limits that tolerate a stalled machine, which is not under test.
    return palpate.Loop(device, renderer, **{"priority": 0, "stall_after_periods": 1000.0, "oscillation": math.inf, **changes})


def until(what: str, is_so: Callable[[], Any]) -> None:
    end = time.monotonic() + PATIENCE
    while not is_so():
        assert time.monotonic() < end, f"waiting for {what}"
        time.sleep(0.002)


def read_until(running: palpate.Loop, what: str, is_so: Callable[[np.ndarray], Any]) -> np.ndarray:
    """All ticks up to those of which `is_so` holds."""
    end = time.monotonic() + PATIENCE
    ticks = running.read(wait=PATIENCE)
    while not is_so(ticks):
        assert time.monotonic() < end, f"waiting for {what}"
        ticks = np.concatenate([ticks, running.read(wait=PATIENCE)])
    return ticks


def test_ticks_are_numbered_without_a_gap_and_show_the_spring_of_the_wall() -> None:
    with loop(pressing(), wall()) as running:
        ticks = read_until(running, "100 ticks in contact", lambda ticks: (ticks["penetration_m"] > 0).sum() >= 100)
        assert running.status.running and running.status.lost == 0
    assert ticks.dtype == palpate.RECORDED
    assert (ticks["sequence"] == np.arange(len(ticks))).all()
    assert (np.diff(ticks["t_s"]) > 0).all()
    inside = ticks[ticks["penetration_m"] > 0]
    assert np.allclose(inside["force_on_device_n"], -300.0 * inside["penetration_m"], rtol=1e-9)
    assert np.allclose(inside["penetration_m"], inside["device_position_m"], rtol=1e-9)


def test_a_change_is_in_force_from_the_tick_that_carries_its_number() -> None:
    with loop(pressing(), wall()) as running:
        read_until(running, "contact", lambda ticks: ticks["penetration_m"][-1] > 0)
        assert running.change(stiffness=600.0) == 1
        # 100 ticks rather than a duration, because a busy machine may skip ticks.
        ticks = read_until(running, "the change", lambda ticks: (ticks["generation"] == 1).sum() > 100)
        last = ticks[-1]
        assert last["force_on_device_n"] == pytest.approx(-600.0 * last["penetration_m"], rel=1e-6)
        assert running.change(method="hfcr", mass=0.5, damping=0.5) == 2
        read_until(running, "the other method", lambda ticks: ticks["generation"][-1] == 2)
        assert running.parameters["method"] == "hfcr" and running.parameters["damping"] == 0.5
        # The settings of the previous method are dropped.
        assert running.change(method="basic") == 3
        assert "damping" not in running.parameters
        texts = [event.text for event in running.events() if event.kind == "parameters"]
        assert "600 N/m" in texts[0] and "hfcr" in texts[1]


def test_what_a_running_loop_cannot_change_is_refused_and_nothing_changes() -> None:
    with loop(pressing(), wall()) as running:
        before = running.parameters
        for changes, message in [
            ({"stiffness": -1.0}, "stiffness is -1 N/m"),
            ({"period": 0.001}, "the period is 0.001 s, and the loop runs at 0.002 s"),
            ({"side": "negative"}, "cannot change to the other side"),
            ({"force_limit": 3.0}, "force_limit is a limit of the loop"),
            ({"stifness": 3.0}, "no parameter is called stifness"),
        ]:
            with pytest.raises((ValueError, TypeError), match=message):
                running.change(**changes)
        assert running.parameters == before
        running.read(wait=PATIENCE)
    with pytest.raises(RuntimeError, match="the loop has ended"):
        running.change(stiffness=400.0)


def test_it_leaves_no_force_at_the_end_of_the_block_at_an_exception_and_when_it_is_forgotten() -> None:
    def touches(running: palpate.Loop) -> None:
        until("a force", lambda: running.status.force[0] < -0.5)

    with loop(pressing(), wall()) as running:
        touches(running)
    assert running.status.force == NONE and not running.status.running
    assert running.report is not None and running.report.ending == "stopped on request"

    class Own(Exception):
        pass

    with pytest.raises(Own):
        with loop(pressing(), wall()) as running:
            touches(running)
            raise Own
    assert running.status.force == NONE

    forgotten = loop(pressing(), wall())
    forgotten.start()
    touches(forgotten)
    assert "palpate loop" in threads_here()
    del forgotten
    gc.collect()
    until("the end of the loop's thread", lambda: "palpate loop" not in threads_here())


def threads_here() -> list[str]:
    if not Path("/proc/self/task").exists():
        pytest.skip("/proc shows the threads of a process")
    return [Path(task, "comm").read_text().strip() for task in Path("/proc/self/task").iterdir()]


def test_python_that_computes_without_a_break_keeps_no_tick_waiting() -> None:
    """The loop needs nothing of the interpreter: a thread that holds its lock for whole slices does not stop it."""
    with loop(pressing(), wall()) as running:
        read_until(running, "the start", lambda ticks: len(ticks) > 10)
        before = running.status.ticks
        # A single C call that holds the GIL until it returns.
        made = pow(3, 2_000_000)
        assert made
        assert running.status.ticks > before + 10


def test_of_a_ring_that_nobody_reads_the_newest_stay_and_the_rest_is_counted() -> None:
    with loop(pressing(), wall(), ring=20) as running:
        until("a full ring", lambda: running.status.ticks > 60)
        ticks = running.read()
        lost = running.status.lost
    assert len(ticks) <= 20 and lost > 0
    assert (np.diff(ticks["sequence"].astype(int)) == 1).all()
    rest = running.read() if running.status.ticks > 0 else ticks
    status = running.status
    assert status.ticks == len(ticks) + len(rest) + status.lost
    assert running.report is not None and status.ticks == running.report.ticks


def test_a_device_that_goes_ends_the_loop_which_says_so_once_its_ticks_are_read(program: Program, tmp_path: Path) -> None:
    board = two_diy(program, tmp_path)
    with board as (port, _):
        running = loop(arm(port), wall(period=0.004))
        with pytest.raises(palpate.LoopError, match="the device is gone.*; switch its motors off"):
            with running:
                running.read(wait=PATIENCE)
                board.process.kill()
                end = time.monotonic() + PATIENCE
                while time.monotonic() < end:
                    running.read(wait=PATIENCE)
    assert running.report is not None and running.report.ending == "the device is gone"
    kinds = [event.kind for event in running.events()]
    assert kinds[-1] == "ended" and "safety-stop-device-lost" in kinds
    # The error is raised once.
    assert running.stop() == running.report


def test_read_reports_a_stalled_loop() -> None:
    """A period of 1 s stands for a device that does not answer."""
    with pytest.warns(UserWarning, match="milliseconds"):
        slow = wall(period=1.0)
    with loop(pressing(), slow) as running:
        running.read(wait=PATIENCE)
        with pytest.raises(palpate.LoopError, match=r"has stalled: no tick within 0\.2 s, the last one .* s ago"):
            while True:
                running.read(wait=0.2)
        assert running.status.silent is not None and running.status.silent > 0.15


def test_a_recording_is_what_was_read_and_the_program_replays_it(program: Program, tmp_path: Path) -> None:
    path = tmp_path / "tap.mcap"
    device = pressing()
    with loop(device, wall(device_mass=0.25), record=path) as running:
        ticks = read_until(running, "contact", lambda ticks: (ticks["penetration_m"] > 0).sum() > 200)
        device.move_to(-0.01)
        running.change(stiffness=350.0)
        ticks = np.concatenate([ticks, read_until(running, "the way out", lambda ticks: ticks["penetration_m"][-1] < 0)])
    rest = running.read()
    ticks = np.concatenate([ticks, rest])
    recording = palpate.read_recording(path)
    assert recording.complete, recording.shortcomings
    assert running.report is not None
    assert (running.report.recorded, running.report.unrecorded) == (len(ticks), 0)
    assert recording.ticks.tobytes() == ticks.tobytes()
    # A busy machine may stop the loop for a while.
    waits = {"missed-deadline", "fault-gap-too-long", "safety-stop-stalled", "recovered"}
    assert [event.kind for event in recording.events if event.kind not in waits] == ["parameters", "ended"]
    assert "stiffness_n_per_m = 300" in recording.texts["scene"]
    assert 'name = "pointer"' in recording.texts["device"]
    replayed = program.json("replay", path, "--method", "basic")
    assert replayed["methods"][0]["method"] == "basic"
    [body] = palpate.Scene.parse(recording.texts["scene"]).to_dict()["body"]
    assert body["fixed"] is True and body["shape"] == {"half_space": {"normal": [-1.0, 0.0, 0.0]}}
    # An existing file is not overwritten.
    with pytest.raises(OSError, match="tap.mcap"):
        loop(pressing(), wall(), record=path)


@pytest.mark.parametrize(
    ("axis", "place", "normal"),
    [("x", [-0.002, 0, 0], [-1, 0, 0]), ("z", [0, 0, -0.002], [0, 0, -1]), ([0, 3, 4], [0, -0.0012, -0.0016], [0, -0.6, -0.8])],
)
def test_a_recording_has_the_device_of_a_scene_along_x(axis: Any, place: list[float], normal: list[float], tmp_path: Path) -> None:
    held = {"force_n": [-20.0 * part for part in normal], "release_s": 10.0}
    rubs = {"coulomb_friction_n": 0.02}
    tool = {"name": "tool", "axes": [axis], "mass_kg": 0.3, "quantum_m": 1e-6, "position_m": place, "drivetrain": rubs, "hand": held}
    scene = palpate.Scene(
        "A tool at a wall",
        loop={"period_s": 0.002},
        device=tool,
        body={"name": "wall", "fixed": True, "shape": {"half_space": {"normal": normal}}},
        contact={"between": ["tool", "wall"], "stiffness_n_per_m": 300.0},
    )
    path = tmp_path / "tap.mcap"
    with loop(palpate.devices.Simulated(scene), wall(mass=0.2, force=-0.5, side="negative"), record=path) as running:
        running.read(wait=PATIENCE)
    recorded = palpate.Scene.parse(palpate.read_recording(path).texts["scene"]).to_dict()
    [device], [body] = recorded["device"], recorded["body"]
    assert device.pop("position_m") == [pytest.approx(-0.002), 0.0, 0.0]
    assert device == {"name": "device", "axes": ["x"], "mass_kg": 0.3, "quantum_m": 1e-6, "drivetrain": rubs}
    assert body["axes"] == ["x"] and body["mass_kg"] == 0.2 and body["force_n"] == [-0.5, 0.0, 0.0]
    assert body["shape"] == {"half_space": {"normal": [1.0, 0.0, 0.0]}}


def test_the_device_and_the_hand_of_a_scene(root: Path) -> None:
    device = palpate.devices.Simulated("experiments/wall.toml")
    with loop(device, wall(stiffness=1000.0, period=0.001)) as running:
        ticks = read_until(running, "contact", lambda ticks: (ticks["penetration_m"] > 0).any())
    assert ticks["device_position_m"][0] == pytest.approx(-0.002, abs=1e-4)


def test_a_hand_leads_its_device_and_lets_go() -> None:
    device = palpate.devices.Pointer(position=-0.05)
    assert device.target == -0.05
    with loop(device, wall()) as running:
        device.move_to(-0.03)
        read_until(running, "the target", lambda ticks: abs(ticks["device_position_m"][-1] + 0.03) < 1e-4)
        device.disable_output()
        assert device.target is None
        with pytest.raises(ValueError, match="target is NaN m"):
            device.move_to(math.nan)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"ring": 0}, "ring is 0 ticks"),
        ({"priority": 99}, "priority is 99"),
        ({"spin": -1.0}, "spin is -1 s"),
        ({"largest_speed": -1.0}, "speed"),
        ({"range": (1.0, 0.0)}, "range"),
    ],
)
def test_what_is_wrong_is_said_by_its_name(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        loop(pressing(), wall(), **changes)


def test_wrong_devices_are_said_by_their_argument(tmp_path: Path) -> None:
    for device, kind, message in [
        (palpate.devices.Pointer(mass=-1.0), ValueError, "device_mass"),
        (palpate.devices.TwoDiy(tmp_path / "nothing"), OSError, "nothing"),
        (palpate.devices.TwoDiy(generation=4), ValueError, "generation is 4"),
        (palpate.devices.TwoDiy(board="m5"), ValueError, 'board is "m5"'),
        (palpate.devices.TwoDiy(start_pose="up"), ValueError, 'start_pose is "up"'),
        (palpate.devices.Inverse3("ws://127.0.0.1:1"), OSError, "127.0.0.1"),
        (palpate.devices.Device(), TypeError, "Device has no method capabilities, read, write"),
    ]:
        with pytest.raises(kind, match=re.escape(message)):
            loop(device, wall())


def test_it_runs_once_and_stops_as_often_as_one_likes() -> None:
    never = loop(pressing(), wall())
    assert never.stop().ending is None
    running = loop(pressing(), wall())
    running.start()
    with pytest.raises(RuntimeError, match="started before"):
        running.start()
    reports: list[palpate.LoopReport] = []
    threads = [threading.Thread(target=lambda: reports.append(running.stop())) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE)
    assert len(reports) == 3 and len(set(reports)) == 1


def test_the_exit_of_the_interpreter_ends_a_loop_that_something_still_refers_to(tmp_path: Path) -> None:
    path = tmp_path / "kept.mcap"
    code = """
import ctypes, math, sys
import palpate
renderer = palpate.Renderer(stiffness=300.0, mass=math.inf, period=0.002, method="basic")
loop = palpate.Loop(palpate.devices.Pointer(position=0.01), renderer, record=sys.argv[1], priority=0)
loop.start()
loop.read(wait=60.0)
# Leak a reference, so that the loop is never dropped.
ctypes.pythonapi.Py_IncRef(ctypes.py_object(loop))
"""
    done = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    recording = palpate.read_recording(path)
    assert recording.complete, recording.shortcomings
    assert recording.events[-1].text == "the loop ended: stopped on request"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system forks no process")
@pytest.mark.filterwarnings("ignore:.*multi-threaded.*:DeprecationWarning")
def test_read_in_forked_process_fails_and_loop_continues() -> None:
    def child(said: Any) -> None:
        try:
            running.read()
        except RuntimeError as error:
            said.put(str(error))

    with loop(pressing(), wall()) as running:
        running.read(wait=PATIENCE)
        context: Any = multiprocessing.get_context("fork")
        said = context.Queue()
        process = context.Process(target=child, args=(said,))
        process.start()
        assert "was forked off it" in said.get(timeout=PATIENCE)
        process.join(PATIENCE)
        assert process.exitcode == 0
        running.read()
        running.read(wait=PATIENCE)


# An emulated board that holds its last torque, and Python in a separate process.


class Emulated:
    """What the emulator of a 2DIY has said in the end."""

    said = ""

    @property
    def last_torques(self) -> list[float]:
        found = re.search(r"in the end (\S+) and (\S+)", self.said)
        assert found, self.said
        return [float(torque) for torque in found.groups()]

    @property
    def largest_torque(self) -> float:
        found = re.search(r"torques up to ([0-9.]+) N m", self.said)
        assert found, self.said
        return float(found[1])


class two_diy:
    """An emulated 2DIY whose hand holds its handle 7 mm in a wall."""

    def __init__(self, program: Program, folder: Path, *flags: str) -> None:
        self.port = folder / "board"
        command = [program.path, "devices", "emulate", "haply-2diy", "--socket", self.port, "--angles", "130,50"]
        self.command = [*map(str, command), "--hold", "0.019,0.1169", *flags]
        self.end = Emulated()

    def __enter__(self) -> tuple[Path, Emulated]:
        self.process = subprocess.Popen(self.command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        # The port exists before the emulator is ready; the emulator prints it when it is ready.
        assert self.process.stdout is not None
        assert self.process.stdout.readline() == f"{self.port}\n"
        return self.port, self.end

    def __exit__(self, *_: object) -> None:
        self.process.send_signal(signal.SIGINT)
        _, self.end.said = self.process.communicate(timeout=PATIENCE)


def arm(port: Path) -> palpate.devices.TwoDiy:
    return palpate.devices.TwoDiy(port, start_pose=(130, 50), origin=(0.019, 0.11), normal=(0, 1))


@contextlib.contextmanager
def ended(process: subprocess.Popen[str]) -> Iterator[None]:
    """Ends a program that a test which fails leaves behind."""
    try:
        yield
    except BaseException:
        process.kill()
        raise


def test_an_inverse3_behind_its_service(program: Program) -> None:
    command = [str(program.path), "devices", "emulate", "inverse3", "--port", "0", "--events-port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as emulator, ended(emulator):
        assert emulator.stdout is not None
        url = emulator.stdout.readline().strip()
        # The initial cursor position is 1 mm deep in the wall.
        inside = wall(object_position=-0.001, period=0.004)
        with loop(palpate.devices.Inverse3(url), inside) as running:
            until("a force", lambda: running.status.force[0] < -0.1)
            ticks = read_until(running, "contact", lambda ticks: (ticks["force_on_device_n"] < -0.1).any())
            assert "nverse3" in running.device_name
            assert ticks["penetration_m"].max() > 0.0005
        assert running.status.force == NONE
        emulator.send_signal(signal.SIGINT)
        _, said = emulator.communicate(timeout=PATIENCE)
    found = re.search(r"in the end \[?(.*?)\]? N", said)
    assert found and [float(force) for force in found[1].split(",")] == [0.0, 0.0, 0.0], said


RUNS = """
import math, os, signal, sys, time
import palpate
# A shell that runs the tests in the background makes its programs ignore Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)
device = palpate.devices.TwoDiy(sys.argv[1], start_pose=(130, 50), origin=(0.019, 0.11), normal=(0, 1))
renderer = palpate.Renderer(stiffness=300.0, mass=math.inf, period=0.004, method="basic", soft_start=0.0)
loop = palpate.Loop(device, renderer, priority=0, stall_after_periods=50.0, oscillation=math.inf)
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
STARTS, BLOCK = "loop.start()\nif True:", "with loop:"
ENDS = {
    "the interpreter exits": (STARTS, "pass", None, 0),
    "an exception": (STARTS, "raise ValueError('own')", None, 1),
    "an exception in a block": (BLOCK, "raise ValueError('own')", None, 1),
    "ctrl-C in a block": (BLOCK, "time.sleep(600)", signal.SIGINT, None),
    "ctrl-C without a block": (STARTS, "pass", signal.SIGINT, None),
    "killed": (BLOCK, "time.sleep(600)", signal.SIGKILL, -signal.SIGKILL),
    "terminated": (BLOCK, "time.sleep(600)", signal.SIGTERM, -signal.SIGTERM),
    "os._exit": (BLOCK, "os._exit(3)", None, 3),
}


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the emulated board needs Linux")
@pytest.mark.parametrize("how", ENDS)
def test_however_python_ends_the_board_holds_no_torque(how: str, program: Program, tmp_path: Path) -> None:
    ends_at_zero(RUNS, how, program, tmp_path)


def ends_at_zero(runs: str, how: str, program: Program, folder: Path) -> None:
    """Runs a program whose loop presses, and lets it end. Where the machine stands still, a loop may lose its board before there is
    anything to see: it is done again then."""
    for attempt in range(6):
        begun = folder / str(attempt)
        begun.mkdir()
        if is_at_zero_after(runs, how, program, begun):
            return
    pytest.fail("each loop lost its board before it pressed")


def is_at_zero_after(runs: str, how: str, program: Program, folder: Path) -> bool:
    begin, then, number, code = ENDS[how]
    with two_diy(program, folder) as (port, board):
        command = [sys.executable, "-c", runs.format(begin=begin, then=then), str(port)]
        pipe = subprocess.PIPE
        with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, text=True) as python:
            assert python.stdin is not None and python.stdout is not None and python.stderr is not None
            said = python.stdout.readline()
            if said == "lost\n":
                return False
            assert said == "presses\n", python.stderr.read()
            guards = watchdogs(python.pid)
            assert len(guards) == 1, "one watchdog beside the loop"
            if number is not None:
                python.send_signal(number)
            else:
                python.stdin.write("go on\n")
                python.stdin.flush()
            done = python.wait(PATIENCE)
            assert code is None or done == code
            # The watchdog process lives until the board confirms zero torque.
            until("the end of the watchdog", lambda: not any(Path("/proc", guard).exists() for guard in guards))
    assert board.largest_torque > 0.001, board.said
    assert board.last_torques == [0.0, 0.0], board.said
    return True


def watchdogs(parent: int) -> list[str]:
    """Process ids of the watchdogs that a process has started."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            words = (entry / "cmdline").read_bytes()
            status = (entry / "status").read_text()
        except OSError:
            continue
        if b"module.guard()" in words and f"PPid:\t{parent}\n" in status:
            found.append(entry.name)
    return found


def test_what_is_no_device_and_no_renderer_is_said_by_its_name() -> None:
    renderer = palpate.Renderer(stiffness=400.0, mass=0.1, period=0.002, device_mass=0.25)
    pointer: Any = palpate.devices.Pointer
    for device, rendered, what in [
        (renderer, pointer(), "renderer is <palpate.devices.Pointer .* but must be a palpate.Renderer, a palpate.World or a"),
        (pointer, renderer, "device is <class 'palpate.devices.Pointer'>, but must be one of palpate.devices"),
        (None, renderer, "device is None, but must be one of palpate.devices"),
    ]:
        with pytest.raises(TypeError, match=what):
            palpate.Loop(device, rendered)
