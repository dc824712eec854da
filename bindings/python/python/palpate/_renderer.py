"""`Renderer`: one contact in a loop of one's own."""

from __future__ import annotations

from typing import Any, ClassVar, NoReturn

from . import _palpate
from ._fixed import Fixed, FixedParameters, question_period


class Renderer(Fixed, _palpate.Renderer):
    """A contact with a virtual object or a wall, rendered by one method, sample by sample.

    All values are SI, along one axis. The object lies on the side of greater positions, unless `side` says
    otherwise; a positive force on the device pushes it to greater positions.

    A renderer is made for a motor. So it has the limits of `palpate pipe`: forces are limited to 20 N, and
    where a start or a recovery finds the device inside the object, the force comes in over 0.2 s.
    `force_limit=math.inf` and `soft_start=0` switch that off.

    Args:
        stiffness: Stiffness K of the contact [N/m].
        mass: Mass M of the object [kg]; `math.inf`: a wall.
        period: Nominal period T of the loop [s].
        method: Name of the method, of `palpate.METHODS`.
        device_mass: Effective mass of the device [kg], right within a factor of 2; `coupled` needs it.
        force: Virtual force f_V on the object [N], such as its weight.
        object_position: Position of the object at the start [m].
        object_velocity: Velocity of the object at the start [m/s].
        side: On which side of the device the object lies: `"positive"` or `"negative"`.
        unilateral: Never pull.
        force_limit: Largest force that is held [N]; `math.inf`: no limit.
        soft_start: Time over which a force comes in where a start or a recovery finds contact, at most
            60 [s]; 0: at once.
        slew_limit: Fastest change of the force [N/s]; `None`: no limit.
        speed_limit: Device speed above which a sample is refused [m/s]; `None`: no limit.
        largest_gap: Longest time between samples that is bridged [s]; `None`: 20 periods.
        guard: Bound on the energy that held forces give out: `"off"`, `"report"` or `"limit"`.
        guard_speed: Fastest device motion that the guard reckons with [m/s].
        guard_allowance: Energy that the guard lets out on top [J].
        delay: Time from a sample to the beginning of its force [periods], at most 8; fractions are taken.
        delay_deviation: Standard deviation of the delay [periods].
        lag: Time constant of the actuator [s].
        lag_deviation: Standard deviation of the lag [s].
        gain: Delivered over commanded force.
        gain_deviation: Standard deviation of the gain.
        encoder_quantum: Quantum of the device's position sensor [m]; 0: not known to have one.
        settings: Settings of the method, such as `damping`: `palpate.METHODS[method].settings` lists them.

    Raises:
        ValueError: A value that is not allowed, by the name of its argument.
    """

    _way: ClassVar[str] = "make another one by Renderer(**{**renderer.parameters, NAME: VALUE})"
    parameters: dict[str, Any]
    """The arguments that this renderer was made with: `Renderer(**parameters)` makes it anew. They cannot be set."""

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
        guard_allowance: float = 1e-3,
        delay: float = 0.0,
        delay_deviation: float = 0.0,
        lag: float = 0.0,
        lag_deviation: float = 0.0,
        gain: float = 1.0,
        gain_deviation: float = 0.0,
        encoder_quantum: float = 0.0,
        **settings: float | str | bool,
    ) -> Renderer:
        given = dict(locals())
        for other in ("cls", "__class__", "method", "soft_start", "settings"):
            given.pop(other, None)
        question_period(period)
        made = super().__new__(cls, method, given, soft_start, settings)
        made.parameters = FixedParameters({"method": method, **given, "soft_start": soft_start, **settings}, cls._way)
        return made

    def __reduce__(self) -> NoReturn:
        raise TypeError(
            "a Renderer has a state and is not pickled; pickle its `parameters`, and make one anew by "
            "Renderer(**parameters)"
        )

    def __repr__(self) -> str:
        said = ", ".join(f"{name}={value!r}" for name, value in self.parameters.items())
        return f"Renderer({said})"
