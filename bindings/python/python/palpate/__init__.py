"""Energy-consistent haptic contact rendering.

palpate computes the contact force between a haptic device and a virtual object, or a wall, at the loop rate
that the device affords, counts the energy that each method creates, and compares each force with the exact
one. This package has the renderers and studies of the Rust library palpate; the numbers are the same.

    import palpate

    r = palpate.Renderer(stiffness=400.0, mass=0.1, period=1e-3, device_mass=0.25)
    f = r.step(0.012)  # position of the device [m] in, force on the device [N] out

All values are SI, along one axis. Where a name stands for a number in an array or a report, its unit is at
the end of the name.
"""

from ._methods import METHODS, Method, Setting
from ._palpate import __version__
from ._recording import FLAGS, RECORDED, Event, Recording, read_recording
from ._render import render
from ._renderer import Renderer
from ._report import FAULTS, IDEAL, LIMITS, PHASES, TICK, Fields, Report, Runs
from ._scene import Scene, compare, simulate
from ._studies import heights, suite, tune
from ._values import Leak, Ledger, Output, Situation

__all__ = [
    "FAULTS",
    "FLAGS",
    "IDEAL",
    "LIMITS",
    "METHODS",
    "PHASES",
    "RECORDED",
    "TICK",
    "Event",
    "Fields",
    "Leak",
    "Ledger",
    "Method",
    "Output",
    "Recording",
    "Renderer",
    "Report",
    "Runs",
    "Scene",
    "Setting",
    "Situation",
    "__version__",
    "compare",
    "heights",
    "read_recording",
    "render",
    "simulate",
    "suite",
    "tune",
]
