"""Recordings of loops with a device."""

from __future__ import annotations

import json
import os
from typing import Any, Mapping, NamedTuple, Sequence

import numpy as np
from numpy.typing import NDArray

from . import _palpate
from ._report import Fields, Report
from ._table import Table, of_records

_COLUMNS, (_PHASES, _FLAGS) = _palpate.recorded_columns()

RECORDED: np.dtype[np.void] = np.dtype([(name, "f8" if number else "u8") for name, number in _COLUMNS])
"""The fields of a tick of a recording and of its contact: numbers, and counts and codes as whole numbers."""
BODIES: np.dtype[np.void] = np.dtype(
    [
        ("sequence", "u8"),
        ("body", "u8"),
        ("position_m", "f8", (3,)),
        ("orientation", "f8", (4,)),
        ("velocity_m_per_s", "f8", (3,)),
        ("angular_velocity_rad_per_s", "f8", (3,)),
    ]
)
"""The fields of a body of a world at a tick: number of the tick, number of the body, position of the centre of mass, unit
quaternion w, x, y, z, and velocities, along the axes of the world."""
DEVICES: np.dtype[np.void] = np.dtype(
    [
        ("sequence", "u8"),
        ("device", "u8"),
        ("flags", "u8"),
        ("t_s", "f8"),
        ("device_round_trip_s", "f8"),
        ("device_axes_m", "f8", (3,)),
        ("device_orientation", "f8", (4,)),
        ("commanded_force_n", "f8", (3,)),
        ("commanded_torque_n_m", "f8", (3,)),
        ("delivered_force_n", "f8", (3,)),
        ("delivered_torque_n_m", "f8", (3,)),
    ]
)
"""The fields of one of several devices at a tick: number of the tick, number of the device, its flags (`FLAGS`), when it was sampled,
how long it took to answer, its place and its unit quaternion w, x, y, z, what it was commanded, and what it held by its own account;
in the frame of the device, NaN where there is no value."""
FLAGS: tuple[str, ...] = tuple(_FLAGS)
"""What the field `flags` of a tick of a recording means: `FLAGS[bit]` holds where the bit is set."""


class Event(NamedTuple):
    """Something that happened at a tick of a loop."""

    sequence: int
    """Number of the tick."""
    t_s: float
    """When, since the loop's start [s]."""
    kind: str
    """What kind of thing, in kebab case."""
    text: str
    """What happened, in words."""


class Recording(Table, Report):
    """What a loop with a device did: the report of `palpate info --json`, and every tick."""

    __slots__ = ("bodies", "devices", "events", "texts", "ticks")

    ticks: NDArray[np.void]
    """The ticks that are there, in their order: an array with the fields of `palpate.RECORDED`.

    A tick has an element for each of its contacts, and one without a value of a contact where it has none.
    """
    events: list[Event]
    """What happened beside the ticks."""
    bodies: NDArray[np.void]
    """The bodies of a world at these ticks: an array with the fields of `palpate.BODIES`, those that move and then the proxies
    of the devices. Of a recording of one contact it is empty."""
    devices: NDArray[np.void]
    """The devices of a loop that has several at these ticks: an array with the fields of `palpate.DEVICES`. Of a loop with one
    device it is empty: `ticks` have all of it."""
    texts: dict[str, str]
    """The texts of the metadata, such as `scene`: what made the recording."""

    def __init__(
        self,
        fields: Mapping[str, Any] = {},
        text: str = "",
        ticks: NDArray[np.void] | None = None,
        events: Sequence[Event] = (),
        texts: Mapping[str, str] = {},
        bodies: NDArray[np.void] | None = None,
        devices: NDArray[np.void] | None = None,
    ) -> None:
        super().__init__(fields, text)
        self.ticks = np.empty(0, RECORDED) if ticks is None else ticks
        self.events = list(events)
        self.texts = dict(texts)
        self.bodies = np.empty(0, BODIES) if bodies is None else bodies
        self.devices = np.empty(0, DEVICES) if devices is None else devices

    def _columns(self) -> dict[str, NDArray[Any]]:
        return of_records(self.ticks)

    def __reduce__(self) -> Any:
        return (type(self), (dict(self), str(self), self.ticks, self.events, self.texts, self.bodies, self.devices))


def read_recording(path: str | os.PathLike[str]) -> Recording:
    """Reads a recording (MCAP) of `palpate record`, whole or as much of it as there is.

    What is missing or damaged is in the report: `complete`, `shortcomings`, `ticks_lost`.

    Raises:
        ValueError: A file that is no recording.
        OSError: A file that cannot be read.
    """
    (fields, text), words, events, texts, bodies, devices = _palpate.read_recording(path)
    return Recording(
        json.loads(fields, object_hook=Fields),
        text,
        words.view(RECORDED),
        [Event(*event) for event in events],
        dict(texts),
        bodies.view(BODIES),
        devices.view(DEVICES),
    )
