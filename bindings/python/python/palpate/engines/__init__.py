"""Contacts with the bodies of other physics engines.

The engine simulates its bodies. palpate renders the contacts of a device's tool with them: it reads states from the
engine and applies forces, and never moves a body itself.

`palpate.engines.mujoco` supports MuJoCo, `palpate.engines.pybullet` PyBullet, and `palpate.engines.drake` Drake. Use
`EngineContact` to write an adapter for another engine, and `LowRateSimulator` for an engine or a game that runs at a
lower rate than the loop.
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
