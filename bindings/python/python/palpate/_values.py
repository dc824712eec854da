"""Results of a renderer after a sample, as named tuples."""

from __future__ import annotations

from typing import NamedTuple


class Output(NamedTuple):
    """Result for one sample. Positions, velocities and forces are along the contact's axis."""

    force_on_device: float
    """Force on the device [N]: the motor command to hold until the next sample."""
    force_on_object: float
    """The opposite force, on the object [N]."""
    slope_on_device: float
    """Slope of the force on the device [N/s]: with `hold="line"` the force to command is
    `force_on_device + slope_on_device (t - T/2)` for t from 0 to the period T, then its last value. Otherwise 0."""
    object_position: float
    """Position of the object at this sample [m]."""
    object_velocity: float
    """Velocity of the object at this sample [m/s]."""
    penetration: float
    """Penetration of the device into the object at this sample [m]: positive in contact, 0 after a fault."""
    phase: str
    """Predicted phase of the coming interval: one of `palpate.PHASES`."""
    transition_after: float
    """Time from this sample to the predicted transition [s]; 0 without a transition."""
    proxy_shift: float
    """Shift of the object by `coupled` over the last interval [m]; 0 for other methods."""
    limited: tuple[str, ...]
    """Active limits: those of `palpate.LIMITS`, `soft-start`, and `safety-stop`: the loop has generated energy, and
    the force stays 0 until `reset()`."""
    fault: str | None
    """Reason for rejecting the sample, one of `palpate.FAULTS`, and the force is 0; `None` for a valid sample."""


class Leak(NamedTuple):
    """Energy that a held force generated (positive) or dissipated (negative)."""

    last: float
    """Leak of the last closed interval [J]."""
    accumulated: float
    """Sum over all closed intervals [J]; leaks of opposite sign cancel in it."""
    absolute: float
    """Sum of the absolute leaks of all closed intervals [J]."""


class Ledger(NamedTuple):
    """Energy ledger of the object up to the last sample; energy is positive into the object.

    `stored - stored at the start = port_work + virtual_force_work + outside_work + held_leak.accumulated`
    """

    stored: float
    """Kinetic energy of the object and elastic energy of the contact [J]."""
    port_work: float
    """Work of the held force on the object's side of the port [J]."""
    virtual_force_work: float
    """Work of the virtual force on the object [J]."""
    outside_work: float
    """Energy of external changes of the object [J]: teleports, and intervals without a valid sample."""
    original_leak: Leak
    """Leak of the plain spring force over the same motion."""
    held_leak: Leak
    """Leak of the held force."""


class Situation(NamedTuple):
    """Input of a user-defined method at a sample in contact. The object is always on the side of greater positions. For
    a scene with the object on the other side, values and force are mirrored."""

    penetration: float
    """Penetration of the device into the object [m], above 0."""
    device_velocity: float
    """Velocity of the device [m/s]: the backward difference of its samples."""
    object_velocity: float
    """Velocity of the object [m/s]."""
    virtual_force: float
    """Virtual force on the object [N]."""
    previous_penetration: float
    """Penetration at the previous sample [m]; negative out of contact."""
    elapsed: float
    """Time since the previous sample [s]."""
    port_work: float
    """Energy that entered the object through the port [J]."""
    held_leak: float
    """Energy that the held force has generated so far [J]."""
