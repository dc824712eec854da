"""Energy-consistent haptic contact rendering.

palpate computes the contact force between a haptic device and a virtual object or wall at the loop rate of the
device. It reports the generated energy of each method and the error of each force against the reference solution.
This package calls the renderers and studies of the Rust library palpate and returns bit-identical numbers.

    import palpate

    r = palpate.Renderer(stiffness=400.0, mass=0.1, period=1e-3, device_mass=0.25)
    r.step(-0.001)  # position of the device [m] in, force on the device [N] out
    f = r.step(0.002)

`Renderer` renders one contact along one axis, `World` several devices, bodies and contacts in space; `Renderers` and
`Worlds` render many of them at once. `Loop` runs one on a device in real time. `palpate.engines` renders contacts with the bodies of other physics engines.

All values are in SI units. The name of a number in an array or a report ends with its unit.
"""

from . import devices
from ._device_file import Calibration, DeviceReport, Excitation, calibrate, report
from ._loop import Connection, Granted, Loop, LoopError, LoopReport, LoopStatus, Spread
from ._methods import METHODS, Method, Setting
from ._palpate import __version__
from ._recording import BODIES, DEVICES, FLAGS, RECORDED, Event, Recording, read_recording
from ._render import Trace, read_trace, render
from ._renderer import Renderer
from ._renderers import OUTPUT, Renderers
from ._replay import replay
from ._report import FAULTS, IDEAL, LIMITS, PHASES, TICK, Fields, Report, Runs, WorldRuns
from ._scene import Bench, Scene, compare, simulate
from ._state import State
from ._studies import Map, advise, claims, heights, map, suite, sweep, tune
from ._values import Leak, Ledger, Output, Situation
from ._world import World
from ._world_values import (
    BodyLedger,
    BodyState,
    EnergyLedger,
    ContactLedger,
    ContactState,
    DeviceLedger,
    Effort,
    FieldLedger,
    JointLedger,
    ToolState,
    TurnState,
    WorldOutput,
)
from ._worlds import Worlds

__all__ = [
    "BODIES",
    "DEVICES",
    "FAULTS",
    "FLAGS",
    "IDEAL",
    "LIMITS",
    "METHODS",
    "OUTPUT",
    "PHASES",
    "RECORDED",
    "TICK",
    "Bench",
    "BodyLedger",
    "BodyState",
    "EnergyLedger",
    "Calibration",
    "Connection",
    "ContactLedger",
    "ContactState",
    "DeviceLedger",
    "DeviceReport",
    "Effort",
    "Event",
    "Excitation",
    "FieldLedger",
    "Fields",
    "Granted",
    "JointLedger",
    "Leak",
    "Ledger",
    "Loop",
    "LoopError",
    "LoopReport",
    "LoopStatus",
    "Map",
    "Method",
    "Output",
    "Recording",
    "Renderer",
    "Renderers",
    "Report",
    "Runs",
    "Scene",
    "Setting",
    "Situation",
    "Spread",
    "State",
    "ToolState",
    "Trace",
    "TurnState",
    "World",
    "WorldOutput",
    "WorldRuns",
    "Worlds",
    "__version__",
    "advise",
    "calibrate",
    "claims",
    "compare",
    "devices",
    "heights",
    "map",
    "read_recording",
    "read_trace",
    "render",
    "replay",
    "report",
    "simulate",
    "suite",
    "sweep",
    "tune",
]
