"""`Renderer`: one contact, for a loop of the caller."""

from __future__ import annotations

from typing import Any, ClassVar, NoReturn

from . import _palpate
from ._fixed import Fixed, FixedParameters, question_lag, question_period
from ._state import State


class Renderer(Fixed, _palpate.Renderer):
    """Contact with a virtual object or a wall, rendered by one method, sample by sample.

    All values are in SI units, along one axis. The object is at greater positions than the device, unless `side` is
    `"negative"`. A positive force on the device pushes it to greater positions.

    A renderer is meant to drive a motor and has the limits of `palpate pipe`: forces are limited to 20 N, and if the
    device is inside the object at a start or a recovery, the force ramps up over 0.2 s. `force_limit=math.inf` and
    `soft_start=0` disable these limits.

    Args:
        stiffness: Stiffness K of the contact [N/m].
        mass: Mass M of the object [kg]; `math.inf`: a wall.
        period: Nominal period T of the loop [s].
        method: Name of the method, of `palpate.METHODS`.
        device_mass: Effective mass of the device [kg], accurate within a factor of 2; `coupled` needs it.
        force: Virtual force f_V on the object [N], such as its weight.
        object_position: Initial position of the object [m].
        object_velocity: Initial velocity of the object [m/s].
        side: Side of the device on which the object is: `"positive"` or `"negative"`.
        unilateral: Never pull.
        force_limit: Largest held force [N]; `math.inf`: no limit.
        soft_start: Duration of the force ramp if a start or a recovery begins in contact [s], at most 60; 0: no ramp.
        slew_limit: Largest rate of change of the force [N/s]; `None`: no limit.
        speed_limit: Device speed above which a sample is rejected [m/s]; `None`: no limit.
        largest_gap: Longest time between samples that is bridged [s]; `None`: 20 periods.
        guard: Passivity guard, a bound on the generated energy: `"off"`, `"report"` or `"limit"`.
        guard_speed: Largest device speed that the guard assumes [m/s].
        guard_allowance: Generated energy that the guard tolerates [J]; `None`: 0.001, or 0.02 with `guard_acceleration`
            or `guard_hand_force`.
        guard_acceleration: Largest acceleration of the device by everything except the rendered force [m/s^2]; the guard
            then bounds by the last step too. `None`: by speed only.
        guard_hand_force: Largest force on the device by everything except the rendered force [N], instead of
            `guard_acceleration`, which is then this force over `guard_mass`.
        guard_mass: Least device mass for this bound [kg]; `None`: half of `device_mass`.
        guard_learn_mass: Whether the motion may raise this mass, which must be the same in every pose.
        guard_recovery: Power by which the guard forgives energy that may have been given out unnoticed, in the quanta of
            the sensor or by a force that changes between samples [W]; `None`: 0.02.
        delay: Time from a sample to the beginning of its force [s], at most 8 periods.
        delay_deviation: Standard deviation of the delay [s], at most 8 periods.
        lag: Time constant of the actuator [s].
        lag_deviation: Standard deviation of the lag [s], at most 8 periods.
        gain: Ratio of delivered to commanded force.
        gain_deviation: Standard deviation of the gain, at most the gain.
        hold: What the actuator holds over a period: `"constant"`, or `"line"`, for which a step returns the mean and
            `output.slope_on_device` is the slope. Lines require `coupled`, and exclude a lag, a slew limit and a guard.
        encoder_quantum: Quantum of the device's position sensor [m]; 0: unknown or none.
        settings: Settings of the method, such as `damping`: `palpate.METHODS[method].settings` lists them.

    Raises:
        ValueError: An argument is not allowed; the message names it.
    """

    _way: ClassVar[str] = "make another one by Renderer(**{**renderer.parameters, NAME: VALUE})"
    parameters: dict[str, Any]
    """Arguments of the constructor, read-only: `Renderer(**parameters)` makes an equal renderer."""

    def __new__(
        cls,
        *,
        stiffness: float,
        mass: float,
        period: float,
        method: str = "coupled",
        device_mass: float | None = None,
        force: float = 0.0,
        object_position: float = 0.0,
        object_velocity: float = 0.0,
        side: str = "positive",
        unilateral: bool = False,
        force_limit: float = 20.0,
        soft_start: float = 0.2,
        slew_limit: float | None = None,
        speed_limit: float | None = 100.0,
        largest_gap: float | None = None,
        guard: str = "off",
        guard_speed: float = 1.0,
        guard_allowance: float | None = None,
        guard_acceleration: float | None = None,
        guard_hand_force: float | None = None,
        guard_mass: float | None = None,
        guard_learn_mass: bool = False,
        guard_recovery: float | None = None,
        delay: float = 0.0,
        delay_deviation: float = 0.0,
        lag: float = 0.0,
        lag_deviation: float = 0.0,
        gain: float = 1.0,
        gain_deviation: float = 0.0,
        hold: str = "constant",
        encoder_quantum: float = 0.0,
        **settings: float | str | bool,
    ) -> Renderer:
        given = dict(locals())
        for other in ("cls", "__class__", "method", "soft_start", "settings"):
            given.pop(other, None)
        question_period(period)
        question_lag(lag)
        made = super().__new__(cls, method, given, soft_start, settings)
        made.parameters = FixedParameters({"method": method, **given, "soft_start": soft_start, **settings}, cls._way)
        return made

    def get_state(self) -> State:
        """Returns the state at the last sample, for `set_state`."""
        return State("Renderer", self.parameters, self.held_state())

    def set_state(self, state: State) -> None:
        """Continues from `state`.

        Raises:
            ValueError: The state is of a renderer with other parameters.
        """
        self.hold_state(state._for("Renderer", self.parameters))

    def copy(self) -> Renderer:
        """Returns an independent renderer with the same parameters in the same state."""
        made = Renderer(**self.parameters)
        made.hold_state(self.held_state())
        return made

    __copy__ = copy

    def __deepcopy__(self, memo: Any) -> Renderer:
        return self.copy()

    def __reduce__(self) -> NoReturn:
        raise TypeError(
            "a Renderer has a state and cannot be pickled; pickle its `parameters`, and make a new one by "
            "Renderer(**parameters)"
        )

    def __repr__(self) -> str:
        said = ", ".join(f"{name}={value!r}" for name, value in self.parameters.items())
        return f"Renderer({said})"
