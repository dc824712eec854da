"""Contacts with the bodies of other physics engines.

An engine keeps its bodies. palpate renders the contacts of a device's tool with them: nothing but forces goes
into the engine, nothing but states comes out of it, and no body is put anywhere.

`palpate.engines.mujoco` does that for MuJoCo, `palpate.engines.pybullet` for PyBullet, `palpate.engines.drake` for Drake.
`EngineContact` is what an adapter for another engine is made of. `SlowHost` is for an engine or a game that is slower than the loop.
"""

from __future__ import annotations

from ._contact import EngineBody, EngineContact, EngineOutput, PlacedShape, PointOfContact, PortBook, body_row
from ._device import SimulatedDevice
from ._slow_host import BodyImpulse, SlowContact, SlowHost, SlowProgress

__all__ = [
    "BodyImpulse",
    "EngineBody",
    "EngineContact",
    "EngineOutput",
    "PlacedShape",
    "PointOfContact",
    "PortBook",
    "SimulatedDevice",
    "SlowContact",
    "SlowHost",
    "SlowProgress",
    "body_row",
]
