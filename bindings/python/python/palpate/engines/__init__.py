"""Contacts with the bodies of other physics engines.

An engine keeps its bodies. palpate renders the contacts of a device's tool with them: nothing but forces goes
into the engine, nothing but states comes out of it, and no body is put anywhere.

`palpate.engines.mujoco` does that for MuJoCo, `palpate.engines.pybullet` for PyBullet, `palpate.engines.drake` for Drake.
`EngineContact` is what an adapter for another engine is made of. `LowRateSimulator` is for an engine or a game that is slower than the loop.
"""

from __future__ import annotations

from ._contact import EngineBody, EngineContact, EngineOutput, PlacedShape, PointOfContact, PortLedger, body_row
from ._device import SimulatedDevice
from ._low_rate_simulator import BodyImpulse, SlowContact, LowRateSimulator, SlowProgress

__all__ = [
    "BodyImpulse",
    "EngineBody",
    "EngineContact",
    "EngineOutput",
    "PlacedShape",
    "PointOfContact",
    "PortLedger",
    "SimulatedDevice",
    "SlowContact",
    "LowRateSimulator",
    "SlowProgress",
    "body_row",
]
