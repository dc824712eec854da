"""`replay`: renders a recording of a loop with other methods or parameters."""

from __future__ import annotations

import os
import warnings
from typing import Any, Sequence

from . import _palpate
from ._recording import Recording
from ._report import Runs, WorldRuns


def replay(
    recording: str | os.PathLike[str] | Recording,
    method: str | Sequence[str] | None = None,
    *,
    replay: str = "motion",
    begin: float | None = None,
    end: float | None = None,
    hand_bandwidth: float | None = None,
    hand_stiffness: float | None = None,
    hand_damping: float | None = None,
    stiffness: float | None = None,
    mass: float | None = None,
    force: float | None = None,
    object_position: float | None = None,
    object_velocity: float | None = None,
    side: str | None = None,
    unilateral: bool | None = None,
    period: float | None = None,
    force_limit: float | None = None,
    slew_limit: float | None = None,
    speed_limit: float | None = None,
    largest_gap: float | None = None,
    guard: str | None = None,
    guard_speed: float | None = None,
    guard_allowance: float | None = None,
    guard_acceleration: float | None = None,
    guard_hand_force: float | None = None,
    guard_mass: float | None = None,
    guard_learn_mass: bool | None = None,
    guard_recovery: float | None = None,
    delay: float | None = None,
    delay_deviation: float | None = None,
    lag: float | None = None,
    lag_deviation: float | None = None,
    gain: float | None = None,
    gain_deviation: float | None = None,
    device_mass: float | None = None,
    model_device_mass: float | None = None,
    encoder_quantum: float | None = None,
    **settings: float | str | bool,
) -> Any:
    """Renders a recording with other methods or parameters, as `palpate replay` does: its motion, or its hand.

        palpate.replay("tap.mcap", ["basic", "coupled"], replay="hand")

    Args:
        recording: Path of a recording (MCAP), or a `palpate.Recording`, whose file is read again.
        method: Name of a method, of `palpate.METHODS`, several names, or `"all"`. `None`: the method of the scene.
        replay: `"motion"`: the device follows the recorded motion whatever the force. `"hand"`: the hand's force is
            estimated from the recording, and the device moves under the new force.
        begin: First time of the recording to use [s]. `None`: its first tick.
        end: Last time of the recording to use [s]. `None`: its last tick.
        hand_bandwidth: Bandwidth of the hand's force [Hz]. `None`: the maximum-likelihood estimate.
        hand_stiffness: Stiffness that couples the hand to its recorded motion [N/m]. `None`: 60, an assumption.
        hand_damping: Damping of this coupling [N s/m]. `None`: 2, an assumption.
        model_device_mass: Device mass in the renderer's model [kg].
        settings: Settings of the methods, such as `damping`.

    The other arguments are those of `palpate.Renderer`. `None` keeps the value of the recording's scene. If neither
    `object_position` nor `object_velocity` is given, the object starts in its recorded state.

    A recording of a world takes no argument except `method`. Its motion is rendered, and the result is that of
    `simulate`.

    Returns:
        The report, and the ticks of each method as structured arrays; for a world its forces. The fields `recording`
        and `replay` of the report describe the replayed part and its accuracy.

    Raises:
        ValueError: The file is not a recording; the recording cannot be replayed; or an argument is not allowed, and
            the message names it.
        OSError: The file cannot be read.

    Warns:
        UserWarning: The recording is incomplete; or the device leaves the recorded motion by more than the reach of an
            arm.
    """
    given = dict(locals())
    for other in ("recording", "method", "settings"):
        del given[other]
    parts = ("replay", "begin", "end", "hand_bandwidth", "hand_stiffness", "hand_damping")
    of = {name: given.pop(name) for name in parts}
    path = recording["recording"] if isinstance(recording, Recording) else os.fspath(recording)
    arguments = (path, method, of, given, settings)
    runs, worlds, said = _palpate.replay(*arguments)
    for words in said:
        warnings.warn(words, stacklevel=2)
    if worlds is not None:
        return WorldRuns._of_worlds(worlds)
    assert runs is not None
    return Runs._of_runs(runs, (_palpate.replay_figure, arguments))
