"""Memory of long loops stays what it was: of renderers and worlds that Python steps, and of a loop in real time."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Callable

import numpy as np
import palpate
import pytest

from test_loop import loop, pressing, until, wall

pytestmark = pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="/proc shows the memory of a process")
MEGABYTE = 2**20


def occupied() -> int:
    """Memory of its own that this process occupies, in place or swapped out [B]. What is read from files comes and goes."""
    said = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
    return sum(1024 * int(said[name].split()[0]) for name in ("RssAnon", "VmSwap"))


def grown(work: Callable[[], None]) -> int:
    """By how much more memory is occupied after the work than before it [B], once everything is warm: the least of three times,
    since an allocator gives memory back when it likes, and what is left behind is left each time."""
    work()
    least = None
    for _ in range(3):
        before = occupied()
        work()
        more = occupied() - before
        least = more if least is None else min(least, more)
    return least


def test_a_long_loop_of_python_does_not_grow() -> None:
    """100 bytes left behind at each step would be ten times what is allowed."""
    renderer = palpate.Renderer(stiffness=400.0, mass=0.1, period=1e-3, device_mass=0.25)

    def steps() -> None:
        for number in range(200_000):
            renderer.step(0.005 * (number % 7 - 3), elapsed=1e-3)
            renderer.output

    assert grown(steps) < 2 * MEGABYTE

    world = palpate.World(
        loop={"period_s": 0.001},
        devices=[{"name": "tool", "mass_kg": 0.2, "tool": {"sphere": {"radius_m": 0.01}}}],
        bodies=[{"name": "ball", "mass_kg": 0.1, "position_m": [0, 0, 0.03], "shape": {"sphere": {"radius_m": 0.03}}}],
        contacts=[{"between": ["tool", "ball"], "stiffness_n_per_m": 2000.0}],
        method="basic",
    )

    def ticks() -> None:
        for number in range(20_000):
            world.step([0.0, 0.0, 1e-4 * (number % 7)])
            world.contacts, world.bodies, world.output

    assert grown(ticks) < 2 * MEGABYTE


def test_long_work_does_not_grow() -> None:
    t = np.arange(20_000) * 1e-3
    x = 0.01 * np.sin(12.0 * t)

    def runs() -> None:
        for _ in range(20):
            palpate.render(t, x, stiffness=400.0, mass=0.1, period=1e-3, method="basic")

    # Each run has 3 MB of ticks.
    assert grown(runs) < 12 * MEGABYTE


def test_a_loop_in_real_time_does_not_grow_whether_it_is_read_or_not() -> None:
    """A tick takes half a kilobyte. 5000 that were kept would be more than is allowed."""
    with loop(pressing(), wall(period=0.00025), ring=200) as running:
        # The queue from the loop to its listener has 16384 ticks; the system maps its memory at first use.
        until("the ring to be full, and the way to it used once", lambda: running.status.ticks > 20_000)
        before, began = occupied(), running.status.ticks
        until("5000 ticks that nobody read", lambda: running.status.ticks > began + 5000)
        assert occupied() - before < 1.5 * MEGABYTE
        running.read()
        before, began = occupied(), running.status.ticks

        def read_on() -> bool:
            running.read(wait=60.0)
            running.events()
            return running.status.ticks > began + 5000

        until("5000 ticks that were read", read_on)
        assert occupied() - before < 1.5 * MEGABYTE
