"""Results of a world after a sample, as named tuples. Vectors are arrays in the world frame."""

from __future__ import annotations

from typing import Mapping, NamedTuple

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
"""Array of three numbers, in the world frame."""


class Effort(NamedTuple):
    """Cost of the integration of a tick."""

    sub_steps: int
    """Number of sub-steps."""
    refined: int
    """Sub-steps with a change of contact mode that were repeated with shorter steps."""
    unrefined: int
    """Sub-steps with a change of contact mode that were not repeated, because there were too many."""
    too_fast: bool
    """Whether the fastest contact needed more sub-steps than a tick allows."""
    left_out: int
    """Number of near triangles and shell points that were ignored for lack of room: the furthest."""


class WorldOutput(NamedTuple):
    """Result for one sample of all devices."""

    forces: NDArray[np.float64]
    """Force that each device has to exert on the hand until the next sample [N], a row for each. If a device has a
    torque, each row has the torque about the centre of mass [N m] after the force, 0 for a device without torque."""
    slopes: NDArray[np.float64]
    """Slope of each force [N/s], a row for each device: with `hold = "line"` in `loop` the force is
    `force + slope (t - T/2)` for t from 0 to the period T, then its last value. Otherwise 0."""
    limited: tuple[str, ...]
    """Active limits: `force`, `torque`, `offset` of a proxy, `guard`, `beyond-guard`, `soft-start`, and `safety-stop`: the loop has
    generated energy, and all forces stay 0 until `reset()`."""
    effort: Effort
    """Cost of the tick."""
    fault: str | None
    """Reason for rejecting the sample, one of `palpate.FAULTS`, and all forces are 0; `None` for a valid sample.
    Positions beyond 1e154 m are an `overflow`."""
    fault_device: str | None
    """Device with the fault, if the fault is of one device."""


class BodyState(NamedTuple):
    """State of a body at the last sample."""

    position: Vector
    """Position of the centre of mass [m]."""
    orientation: NDArray[np.float64]
    """Unit quaternion [w, x, y, z] from the body frame to the world frame."""
    velocity: Vector
    """Velocity of the centre of mass [m/s]."""
    angular_velocity: Vector
    """Angular velocity [rad/s]."""


class TurnState(NamedTuple):
    """Rotational state of the tool of a device of six axes at the last sample."""

    orientation: NDArray[np.float64]
    """Estimated unit quaternion [w, x, y, z] from the tool frame to the world frame."""
    proxy_orientation: NDArray[np.float64]
    """Unit quaternion [w, x, y, z] from the proxy frame to the world frame."""
    angular_velocity: Vector
    """Angular velocity of the device [rad/s]."""
    offset: Vector
    """Rotation vector that turns the device into the proxy [rad]."""
    momentum_offset: Vector
    """Angular momentum of the proxy minus that of the device [N m s]."""
    torque: Vector
    """Torque of the method about the centre of mass at this sample [N m], before the soft start."""
    inertia: Vector | None
    """Estimated moments of inertia of device and hand about the tool's axes [kg m^2]; `None` if not estimated."""


class ToolState(NamedTuple):
    """State of the tool of a device at the last sample."""

    position: Vector
    """Estimated position of the device [m]."""
    velocity: Vector
    """Velocity of the device [m/s]."""
    proxy_position: Vector
    """Position of the proxy, which is in contact with the bodies [m]."""
    proxy_velocity: Vector
    """Velocity of the proxy [m/s]."""
    offset: Vector
    """Position of the proxy minus that of the device [m]."""
    velocity_offset: Vector
    """Velocity of the proxy minus that of the device [m/s]."""
    force: Vector
    """Force of the method at this sample [N], before the soft start."""
    mass: Vector | None
    """Estimated mass of device and hand along each axis [kg]; `None` if not estimated."""
    turn: TurnState | None
    """Rotational state; `None` for a device without rotation."""


class ContactState(NamedTuple):
    """State of a potential contact point at the last sample."""

    between: tuple[str, str]
    """Names of the two sides."""
    mode: str
    """`free`, `sticks`, `slides`, or `parts`: the sides overlap but do not push."""
    point: Vector
    """Point of action of the force [m]."""
    normal: Vector
    """Unit vector from the second side to the first."""
    penetration: float
    """Depth of the overlap [m], 0 without overlap."""
    force: Vector
    """Force on the first side [N]."""
    bristle: Vector
    """Deflection of the bristle of friction [m]."""


class ContactLedger(NamedTuple):
    """Energy at a contact over all completed intervals [J].

    `stored = stored at the start + observed + outside + handed - work - dissipated + step_error`
    """

    between: tuple[str, str]
    """Names of the two sides."""
    stored: float
    """Energy of the contact's springs."""
    dissipated: float
    """Energy dissipated by damping and friction: never decreases."""
    work: float
    """Work of the contact on both of its sides."""
    work_on_proxy: float
    """Work of the contact on the tool's proxy, if one of its sides is a tool."""
    held: float
    """Work of the contact's mean force on the device itself."""
    observed: float
    """Change of the stored energy because a sample moved the proxy."""
    outside: float
    """Energy added by changes of the world, such as a body that was moved."""
    step_error: float
    """Energy generated (positive) or lost by finite sub-steps."""
    handed: float
    """Energy transferred from the other points of the same pair of boxes: the sum over the pair is 0."""

    @property
    def leak(self) -> float:
        """Energy that holding the force gave to the hand beyond the contact's own work [J]."""
        return self.held - self.work_on_proxy


class JointLedger(NamedTuple):
    """Energy of a joint over all completed intervals [J].

    `stored = stored at the start + outside - work - dissipated + step_error`
    """

    between: tuple[str, str]
    """Name of the moving body, and of the body to which the joint connects it, or `world`."""
    kind: str
    """`hinge` or `slider`."""
    stored: float
    """Energy of its springs."""
    dissipated: float
    """Energy dissipated by damping: never decreases."""
    work: float
    """Work of the joint on both of its sides."""
    outside: float
    """Energy added by changes of the world, such as a body that was moved."""
    step_error: float
    """Energy generated (positive) or lost by finite sub-steps."""


class FieldLedger(NamedTuple):
    """Energy of a force field over all completed intervals [J].

    `stored = observed + outside + supplied - work + step_error`
    """

    device: str
    """Name of the device on whose tool it acts."""
    stored: float
    """Stored energy U at the last sample."""
    work: float
    """Work of the field on the tool's proxy."""
    held: float
    """Work of the field's mean force on the device itself."""
    observed: float
    """Change in stored energy due to samples or limits that displaced the proxy from its expected position."""
    outside: float
    """Energy added by changes of the running world."""
    supplied: float
    """Work of a constant force, which is external."""
    step_error: float
    """Energy generated (positive) or lost by finite sub-steps."""


class BodyLedger(NamedTuple):
    """Energy of a body over all completed intervals [J].

    `kinetic + potential = the same at the start + work + outside + step_error`
    """

    kinetic: float
    """Kinetic energy."""
    potential: float
    """Negative work of its constant force since the start."""
    work: float
    """Work of contacts and joints on it."""
    outside: float
    """Energy of external changes."""
    step_error: float
    """Energy generated (positive) or lost by finite sub-steps."""


class DeviceLedger(NamedTuple):
    """Energy at the port of a device over all completed intervals [J]; positive to the hand.

    `port_work = held + unforeseen`
    """

    port_work: float
    """Work of the held force over the measured motion of the device."""
    held: float
    """Work of the mean force of its contacts on the device."""
    unforeseen: float
    """Difference of the two."""
    offset: float
    """Work of the hand on the proxy minus that on the device."""
    velocity_offset: float
    """Kinetic energy gained by the proxy minus that gained by the device."""
    unpaid: float
    """Work of the mean force of the contacts on the device minus the work of the requested force."""
    walked_back: float
    """Work of the hand on the offset while it returns to zero without contact."""


class EnergyLedger(NamedTuple):
    """Energy ledger of a world."""

    contacts: tuple[ContactLedger, ...]
    """One for each contact point, in the order of `World.contacts`."""
    bodies: Mapping[str, BodyLedger]
    """One for each body, by name."""
    devices: Mapping[str, DeviceLedger]
    """One for each device, by name."""
    joints: tuple[JointLedger, ...]
    """One for each joint, in the order of the world."""
    fields: tuple[FieldLedger, ...]
    """One for each force field, in the order of the world."""
