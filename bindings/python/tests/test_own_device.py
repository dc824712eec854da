"""User-defined devices: in Python, and in other programs."""

from __future__ import annotations

import math
import os
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest

import palpate
from palpate.devices import Capabilities, Device, Plugin, Process, Udp

ROOT = Path(__file__).resolve().parents[3]
MINE = ROOT / "examples/own_device/my_device.py"
WALL: dict[str, Any] = {"stiffness": 400.0, "mass": math.inf, "period": 0.01, "device_mass": 0.2}
unix = pytest.mark.skipif(os.name != "posix", reason="a Process needs Linux or macOS")


def wait_for_force(loop: palpate.Loop, force: float) -> None:
    end = time.monotonic() + 60.0
    while not abs(loop.read(wait=10.0)["delivered_force_1_n"]).max() >= force:
        assert time.monotonic() < end, loop.events()


class Knob(Device):
    """At rest, 5 mm in the wall; it keeps what it receives."""

    def __init__(self, fails: str | None = None, **can: Any) -> None:
        self.can = Capabilities("knob", **can)
        self.fails = fails
        self.forces: list[Any] = []
        self.threads: set[int] = set()

    def capabilities(self) -> Capabilities:
        return self.can

    def read(self) -> Any:
        self.threads.add(threading.get_ident())
        if self.fails == "read" and len(self.forces) == 5:
            raise OSError("the cable is out")
        if self.fails == "shape":
            return [0.005, 0.0, 0.0]
        if self.fails == "nan":
            return math.nan
        return 0.005 if self.can.axes == 1 else [0.005, 0.0, 0.0][: self.can.axes]

    def write(self, force: Any, torque: Any = None) -> None:
        if self.fails == "write" and force:
            raise ValueError("too strong")
        self.forces.append(force)


def test_a_python_device_gets_the_force_of_the_contact_and_ends_with_zero(tmp_path: Path) -> None:
    knob = Knob(largest_force=1.5)
    with palpate.Loop(knob, palpate.Renderer(method="basic", **WALL), record=tmp_path / "knob.mcap") as loop:
        assert loop.device_name == "knob"
        wait_for_force(loop, 1.49)
    assert threading.get_ident() not in knob.threads
    # A wall of 2 N, within the limit of the device.
    assert -1.5 <= min(knob.forces) <= -1.49 and knob.forces[-1] == 0.0
    assert isinstance(knob.forces[0], float)
    assert loop.report is not None and loop.report.recorded == loop.report.ticks
    assert len(palpate.read_recording(tmp_path / "knob.mcap").ticks) == loop.report.ticks


def test_several_axes_are_tuples() -> None:
    knob = Knob(axes=2)
    knob.normal = [0.0, 1.0]
    with palpate.Loop(knob, palpate.Renderer(**WALL)) as loop:
        loop.read(wait=10.0)
    assert all(isinstance(force, tuple) and len(force) == 2 for force in knob.forces)
    knob.normal = [0.0, 1.0, 0.0]
    with pytest.raises(ValueError, match="normal: 3 numbers for the 2 axes of the device `knob`"):
        palpate.Loop(knob, palpate.Renderer(**WALL))


@pytest.mark.parametrize(
    ("fails", "kind", "words"),
    [
        ("read", OSError, "the cable is out"),
        ("write", ValueError, "too strong"),
        ("shape", ValueError, "read returned 3 coordinates, but the device has 1 axes"),
        ("nan", ValueError, "read returned NaN, but all must be finite"),
    ],
)
def test_an_exception_ends_the_loop_and_is_the_cause(fails: str, kind: type[Exception], words: str) -> None:
    knob = Knob(fails)
    loop = palpate.Loop(knob, palpate.Renderer(**WALL))
    loop.start()
    with pytest.raises(palpate.LoopError, match=words) as raised:
        while True:
            loop.read(wait=10.0)
    assert isinstance(raised.value.__cause__, kind)
    assert loop.report is not None and loop.report.ending == "the device is gone"
    # The fifth force was that of the wall.
    assert knob.forces[-1] == 0.0


DROPPED = """
import math, threading, palpate
from palpate.devices import Capabilities, Device
pressed = threading.Event()
class Knob(Device):
    force = 0.0
    def capabilities(self):
        return Capabilities("knob")
    def read(self):
        return 0.005
    def write(self, force):
        Knob.force = force
        if force:
            pressed.set()
loop = palpate.Loop(Knob(), palpate.Renderer(stiffness=400.0, mass=math.inf, period=0.01, device_mass=0.2))
loop.start()
assert pressed.wait(60.0)
del loop
assert Knob.force == 0.0
"""


def test_a_running_loop_that_is_dropped_ends_with_zero() -> None:
    subprocess.run([sys.executable, "-c", DROPPED], check=True, timeout=120.0)


def test_a_wrong_device_says_what_is_needed() -> None:
    class Mine(Device):
        def read(self) -> float:
            return 0.0

    with pytest.raises(TypeError, match="Mine has no method capabilities, write"):
        palpate.Loop(Mine(), palpate.Renderer(**WALL))
    for can, words in [
        ({"axes": 4}, "axes is 4, but must be 1, 2 or 3"),
        ({"torque_axes": 3}, "torque_axes is 3, but must be 0 to 3, and 0 without orientation"),
        ({"largest_force": -1.0}, "largest_force is -1, but must be finite and above 0, or None"),
    ]:
        with pytest.raises(ValueError, match=words):
            palpate.Loop(Knob(**can), palpate.Renderer(**WALL))


@unix
def test_a_program_is_a_device() -> None:
    device = Process([sys.executable, str(MINE)])
    with palpate.Loop(device, palpate.Renderer(**WALL)) as loop:
        assert loop.device_name == "my device"
        wait_for_force(loop, 0.5)
        (connection,) = loop.stop().connections
    assert connection is not None and connection.round_trip is not None
    assert connection.samples > 0 and 0.0 < connection.round_trip.median <= connection.round_trip.longest
    with pytest.raises(OSError, match="/no/such/program cannot be started"):
        palpate.Loop(Process("/no/such/program"), palpate.Renderer(**WALL))
    with pytest.raises(ValueError, match="command is empty"):
        Process("  ")


@unix
def test_a_shared_library_is_a_device(tmp_path: Path) -> None:
    library = tmp_path / "libmine.so"
    include, source = ROOT / "bindings/c/include", ROOT / "examples/own_device/my_device.c"
    subprocess.run(["cc", "-shared", "-fPIC", "-I", include, source, "-o", library], check=True)
    # The library moves its mass by 1 ms in each read.
    with palpate.Loop(Plugin(library), palpate.Renderer(**{**WALL, "period": 0.001})) as loop:
        assert loop.device_name == "my device"
        wait_for_force(loop, 0.5)
        assert loop.stop().connections == (None,)
    with pytest.raises(OSError, match="the plug-in .*nothing.so: .*cannot open"):
        palpate.Loop(Plugin(tmp_path / "nothing.so"), palpate.Renderer(**WALL))


def test_a_program_answers_packets() -> None:
    forces = []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as board:
        board.bind(("127.0.0.1", 0))
        board.settimeout(60.0)

        def serve() -> None:
            word = ""
            while word != "end":
                packet, host = board.recvfrom(1000)
                word, *values = packet.decode().split()
                if word == "hello":
                    board.sendto(b"device 1 axes=1 name=board", host)
                elif word == "read":
                    board.sendto(f"sample {values[0]} {values[0]} - 0.005".encode(), host)
                elif word == "wrench":
                    forces.append(float(values[1]))

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        # A long period: an answer older than three periods is late, and this thread may wait for a busy machine.
        renderer = palpate.Renderer(**{**WALL, "period": 0.2}, method="basic")
        with palpate.Loop(Udp(*board.getsockname()), renderer) as loop:
            wait_for_force(loop, 1.0)
        thread.join()
    assert min(forces) < -1.0 and forces[-1] == 0.0
    with pytest.raises(ValueError, match="on another machine; allow_remote=True permits it"):
        palpate.Loop(Udp("192.0.2.1", 5005), palpate.Renderer(**WALL))
