"""What a world says after a sample: plain tuples with names. Vectors are arrays along the axes of the world."""

from __future__ import annotations

from typing import Mapping, NamedTuple

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
"""An array of three numbers along the axes of the world."""


class Effort(NamedTuple):
    """What the integration of a tick has cost, and what it left out."""

    sub_steps: int
    """Sub-steps taken."""
    refined: int
    """Sub-steps in which a contact changed its mode, done anew in finer ones."""
    unrefined: int
    """Sub-steps in which a contact changed its mode and that were not done anew: there were too many."""
    too_fast: bool
    """Whether the fastest contact asked for more sub-steps than a tick takes."""


class WorldOutput(NamedTuple):
    """The answer to one sample of all devices."""

    forces: NDArray[np.float64]
    """Force on each device [N], a row for each: what it is to give to the hand, and to hold until the next
    sample. Where a device that gives a torque is among them, each row has the torque about the mass centre [N m] behind
    the force, 0 for a device that gives none."""
    limited: tuple[str, ...]
    """Limits that acted: `force`, `torque`, `offset` of a proxy, `guard`, `soft-start`, and `safety-stop`:
    the loop has created energy, and all forces stay 0 until `reset()`."""
    effort: Effort
    """What the tick has cost."""
    fault: str | None
    """Why the sample was refused, one of `palpate.FAULTS`; `None` where it was not. All forces are then 0. Positions have to be
    within 1e154 m: farther ones are `overflow`."""
    fault_device: str | None
    """The device that the fault is of, where it is one's."""


class BodyState(NamedTuple):
    """A body at the last sample."""

    position: Vector
    """Position of the centre of mass [m]."""
    orientation: NDArray[np.float64]
    """Unit quaternion [w, x, y, z] that turns the body's own axes into those of the world."""
    velocity: Vector
    """Velocity of the centre of mass [m/s]."""
    angular_velocity: Vector
    """Angular velocity [rad/s]."""


class TurnState(NamedTuple):
    """How the tool of a device that measures six axes is turned at the last sample."""

    orientation: NDArray[np.float64]
    """Unit quaternion [w, x, y, z] that turns the tool's own axes into those of the world, by what the method knows."""
    proxy_orientation: NDArray[np.float64]
    """The same of the proxy."""
    angular_velocity: Vector
    """Angular velocity of the device [rad/s]."""
    offset: Vector
    """Rotation vector that turns the device into the proxy [rad]."""
    momentum_offset: Vector
    """Angular momentum of the proxy less that of the device [N m s]."""
    torque: Vector
    """Torque about the mass centre that the method asked for at this sample [N m], before the soft start."""
    inertia: Vector | None
    """Moments of inertia of the device with the hand along the tool's axes, as far as the method has learned them
    [kg m^2]."""


class ToolState(NamedTuple):
    """The tool of a device at the last sample."""

    position: Vector
    """Where the device is, by what the method knows [m]."""
    velocity: Vector
    """Velocity of the device [m/s]."""
    proxy_position: Vector
    """What the world meets in the device's place: its position [m]."""
    proxy_velocity: Vector
    """Velocity of the proxy [m/s]."""
    offset: Vector
    """Position of the proxy less that of the device [m]."""
    velocity_offset: Vector
    """Velocity of the proxy less that of the device [m/s]."""
    force: Vector
    """Force that the method asked for at this sample [N], before the soft start."""
    mass: Vector | None
    """Mass of the device with the hand along each axis, as far as the method has learned it [kg]."""
    turn: TurnState | None
    """How it is turned; `None` for a device that does not turn."""


class ContactState(NamedTuple):
    """A point at which two can touch, at the last sample."""

    between: tuple[str, str]
    """Names of the two sides."""
    mode: str
    """`free`, `sticks`, `slides`, or `parts`: they overlap but do not push."""
    point: Vector
    """Where the force acts [m]."""
    normal: Vector
    """Unit vector from the second side to the first."""
    penetration: float
    """How far they overlap [m], 0 where they do not."""
    force: Vector
    """Force on the first side [N]."""
    bristle: Vector
    """Deflection of the bristle of friction [m]."""


class ContactLedger(NamedTuple):
    """Energy at a contact over all intervals that have ended [J].

    `stored = stored at the start + observed + handed - work - dissipated + step_error`
    """

    between: tuple[str, str]
    """Names of the two sides."""
    stored: float
    """Energy of the contact's springs."""
    dissipated: float
    """What damping and friction took: never falls."""
    work: float
    """Work of the contact on both of its sides."""
    work_on_proxy: float
    """Work of the contact on the tool's proxy, if one of its sides is a tool."""
    held: float
    """Work of the contact's mean force on the device itself."""
    observed: float
    """What the stored energy changed by because a sample put the proxy elsewhere."""
    step_error: float
    """What finite sub-steps have made (positive) or lost."""
    handed: float
    """What came from the other points of the same pair of boxes: the sum over the pair is 0."""

    @property
    def leak(self) -> float:
        """Energy that holding gave to the hand beyond the contact's own work [J]."""
        return self.held - self.work_on_proxy


class JointLedger(NamedTuple):
    """Energy of a joint over all intervals that have ended [J].

    `stored = stored at the start - work - dissipated + step_error`
    """

    between: tuple[str, str]
    """Name of the body that moves, and of the body against which it does, or `world`."""
    kind: str
    """`hinge` or `slider`."""
    stored: float
    """Energy of its springs."""
    dissipated: float
    """What damping took: never falls."""
    work: float
    """Work of the joint on both of its sides."""
    step_error: float
    """What finite sub-steps have made (positive) or lost."""


class BodyLedger(NamedTuple):
    """Energy of a body over all intervals that have ended [J].

    `kinetic + potential = the same at the start + work + outside + step_error`
    """

    kinetic: float
    """Kinetic energy."""
    potential: float
    """Less the work of its constant force since the start."""
    work: float
    """Work of contacts and joints on it."""
    outside: float
    """What changed it from outside."""
    step_error: float
    """What finite sub-steps have made (positive) or lost."""


class DeviceLedger(NamedTuple):
    """Energy at the port of a device over all intervals that have ended [J]; positive to the hand.

    `port_work = held + unforeseen`
    """

    port_work: float
    """Work of the held force on the device as it was measured."""
    held: float
    """Work of the mean force of its contacts on the device."""
    unforeseen: float
    """What the two differ by."""
    offset: float
    """Work of the hand on the proxy less that on the device."""
    velocity_offset: float
    """By how much more kinetic energy the proxy has gained than the device."""
    unpaid: float
    """Work that the mean force of the contacts does on the device and the force that was asked for does not."""
    walked_back: float
    """Work of the hand on the offset as it went back to zero, while nothing touched the tool."""


class EnergyLedger(NamedTuple):
    """The books of a world's energy."""

    contacts: tuple[ContactLedger, ...]
    """Of each point of contact, in the order of `World.contacts`."""
    bodies: Mapping[str, BodyLedger]
    """Of each body, by its name."""
    devices: Mapping[str, DeviceLedger]
    """Of each device, by its name."""
    joints: tuple[JointLedger, ...]
    """Of each joint, in the order of the world."""
