"""What a renderer says after a sample: plain tuples with names."""

from __future__ import annotations

from typing import NamedTuple


class Output(NamedTuple):
    """The answer to one sample. Positions, velocities and forces are along the contact's axis."""

    force_on_device: float
    """Force on the device [N]: what the motor is to be commanded, and to hold until the next sample."""
    force_on_object: float
    """The same force on the object [N], opposite in sign."""
    object_position: float
    """Position of the object at this sample [m]."""
    object_velocity: float
    """Velocity of the object at this sample [m/s]."""
    penetration: float
    """Penetration of the device into the object at this sample [m]: positive in contact, 0 after a fault."""
    phase: str
    """What the coming interval is predicted to hold: one of `palpate.PHASES`."""
    transition_after: float
    """Instant of the predicted transition, after this sample [s]; 0 where there is none."""
    object_shift: float
    """How far `coupled` shifted the object over the last interval [m]; 0 for other methods."""
    limited: tuple[str, ...]
    """Limits that changed the force: of `palpate.LIMITS`, `soft-start`, and `safety-stop`: the loop has
    created energy, and the force stays 0 until `reset()`."""
    fault: str | None
    """Why the sample was refused, one of `palpate.FAULTS`; `None` where it was not. The force is then 0."""


class Leak(NamedTuple):
    """Energy that a held force created (positive) or destroyed (negative)."""

    last: float
    """Leak of the last closed interval [J]."""
    accumulated: float
    """Sum over all closed intervals [J]; leaks of opposite sign cancel in it."""
    absolute: float
    """Sum of the absolute leaks of all closed intervals [J]."""


class Ledger(NamedTuple):
    """EnergyLedger of the object's energy, up to the last sample; energy is positive into the object.

    `stored - stored at the start = port_work + virtual_force_work + outside_work + held_leak.accumulated`
    """

    stored: float
    """Kinetic energy of the object and elastic energy of the contact [J]."""
    port_work: float
    """Work of the held force on the object's side of the port [J]."""
    virtual_force_work: float
    """Work of the virtual force on the object [J]."""
    outside_work: float
    """What changed the object from outside [J]: teleports, and time in which no sample could be trusted."""
    original_leak: Leak
    """Leak of the plain spring force over the same motion."""
    held_leak: Leak
    """Leak of the force that was held."""


class Situation(NamedTuple):
    """What a method of one's own is told at a sample, with the device in contact. The object is on the side
    of greater positions here, whatever the scene says; the bench mirrors what comes out."""

    penetration: float
    """Penetration of the device into the object [m], above 0."""
    device_velocity: float
    """Velocity of the device [m/s]: the backward difference of its samples."""
    object_velocity: float
    """Velocity of the object [m/s]."""
    virtual_force: float
    """Virtual force on the object [N]."""
    previous_penetration: float
    """Penetration at the sample before [m]; negative out of contact."""
    elapsed: float
    """Time since the sample before [s]."""
    port_work: float
    """Energy that has gone into the object through the port [J]."""
    held_leak: float
    """Energy that the held force has created so far [J]."""
