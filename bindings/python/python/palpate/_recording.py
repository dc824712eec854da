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
"""Fields of a tick of a recording and of its contact. Counts and codes are integers."""
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
"""Fields of a body of a world at a tick: number of the tick, number of the body, position of the centre of mass, unit
quaternion w, x, y, z, and velocities, in the world frame."""
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
        ("delivered_slope_n_per_s", "f8", (3,)),
        ("delivered_torque_n_m", "f8", (3,)),
    ]
)
"""Fields of one of several devices at a tick: number of the tick, number of the device, flags (`FLAGS`), time of the
sample, round-trip time, position, unit quaternion w, x, y, z, commanded wrench, and wrench that the device reports,
with the slope of its force. Vectors are in the frame of the device; missing values are NaN."""
FLAGS: tuple[str, ...] = tuple(_FLAGS)
"""Meaning of the field `flags` of a tick of a recording: `FLAGS[bit]` applies if the bit is set."""


class Event(NamedTuple):
    """Event at a tick of a loop."""

    sequence: int
    """Number of the tick."""
    t_s: float
    """Time since the start of the loop [s]."""
    kind: str
    """Kind, in kebab case."""
    text: str
    """Description."""


class Recording(Table, Report):
    """Recording of a loop with a device: the report of `palpate info --json`, and every tick."""

    __slots__ = ("bodies", "devices", "events", "texts", "ticks")

    ticks: NDArray[np.void]
    """Ticks in order: an array with the fields of `palpate.RECORDED`.

    A tick has one element per contact, or one element without contact values if it has no contact.
    """
    events: list[Event]
    """Events."""
    bodies: NDArray[np.void]
    """Bodies of a world at these ticks: an array with the fields of `palpate.BODIES`, first the moving bodies, then the
    proxies of the devices. Empty for a recording of one contact."""
    devices: NDArray[np.void]
    """Devices at these ticks: an array with the fields of `palpate.DEVICES`. Empty for a loop with one device, whose
    data are in `ticks`."""
    texts: dict[str, str]
    """Metadata entries, such as `scene`: the source of the recording."""

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
    """Reads a recording (MCAP) of `palpate run --record`. An incomplete recording is read as far as possible.

    The fields `complete`, `shortcomings` and `ticks_lost` of the report describe missing and damaged parts.

    Raises:
        ValueError: The file is not a recording.
        OSError: The file cannot be read.
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
