"""A device of Force Dimension behind the emulated library of the driver's tests, with a device in Python."""

from __future__ import annotations

import math
import os
import socket
import struct
import subprocess
import threading
import time
from pathlib import Path
from typing import Any, Iterator

import pytest

import palpate
from palpate.devices import ForceDimension

ROOT = Path(__file__).resolve().parents[3]
SOURCE = ROOT / "crates/palpate-drivers/src/emulator/force_dimension/libdrd.c"
WALL: dict[str, Any] = {"stiffness": 400.0, "mass": math.inf, "period": 0.01, "device_mass": 0.2}
pytestmark = pytest.mark.skipif(os.name != "posix", reason="the emulated library needs a Unix socket")
# Numbers of questions in the emulated library.
AVAILABLE, TYPE, STATUS, POSITION, FORCES, SET_WATCHDOG, WATCHDOG = 0, 4, 5, 7, 10, 15, 16


class Emulated:
    """An omega.3 at rest, 5 mm in the wall."""

    def __init__(self, folder: Path) -> None:
        self.library = folder / "libdrd.so"
        path = folder / "socket"
        options = ["-shared", "-fPIC", "-std=gnu99", f'-DPALPATE_SOCKET="{path}"']
        subprocess.run(["cc", *options, SOURCE, "-o", self.library], check=True)
        self.forces: list[float] = []
        self.watchdog = 0
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(str(path))
        self.listener.listen()
        threading.Thread(target=self.serve, daemon=True).start()

    def serve(self) -> None:
        while True:
            client, _ = self.listener.accept()
            threading.Thread(target=self.answer, args=(client,), daemon=True).start()

    def answer(self, client: socket.socket) -> None:
        while question := client.recv(72, socket.MSG_WAITALL):
            what, number, *values = struct.unpack("=ii8d", question)
            result, answer = 0, [0.0] * 36
            if what == AVAILABLE:
                result = 1
            elif what == TYPE:
                result = 33
            elif what == STATUS:
                answer[:3] = [1.0] * 3
            elif what == POSITION:
                answer[0] = 0.005
            elif what == FORCES:
                self.forces.append(values[0])
            elif what == SET_WATCHDOG:
                self.watchdog = number
            elif what == WATCHDOG:
                answer[0] = self.watchdog
            client.sendall(struct.pack("=ii36d", result, 0, *answer))


@pytest.fixture
def emulated(tmp_path: Path) -> Iterator[Emulated]:
    emulated = Emulated(tmp_path)
    yield emulated
    emulated.listener.close()


def test_a_wall_is_felt_and_the_last_force_is_zero(emulated: Emulated) -> None:
    with palpate.Loop(ForceDimension(emulated.library), palpate.Renderer(method="basic", **WALL)) as loop:
        assert loop.device_name == "omega.3"
        end = time.monotonic() + 60.0
        while not abs(loop.read(wait=10.0)["delivered_force_1_n"]).max() >= 0.5:
            assert time.monotonic() < end, loop.events()
    # A wall of 2 N.
    assert -2.1 <= min(emulated.forces) <= -0.5 and emulated.forces[-1] == 0.0
    # 15 ms, in units of 125 us.
    assert emulated.watchdog == 120


def test_what_cannot_be_opened_says_why(emulated: Emulated, tmp_path: Path) -> None:
    renderer = palpate.Renderer(**WALL)
    with pytest.raises(OSError, match="the library .*none.so: .*cannot open"):
        palpate.Loop(ForceDimension(tmp_path / "none.so"), renderer)
    with pytest.raises(ValueError, match="the omega.3 has no gripper"):
        palpate.Loop(ForceDimension(emulated.library, gripper=True), renderer)
