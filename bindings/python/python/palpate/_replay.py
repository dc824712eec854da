"""`replay`: a recording of a loop with a device, under another force."""

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
    """Renders a recording by other methods or parameters, as `palpate replay` does: its motion as it was, or its hand.

        palpate.replay("tap.mcap", ["basic", "coupled"], replay="hand")

    Args:
        recording: Path of a recording (MCAP), or what `palpate.read_recording` made of it: its file is read again.
        method: Name of a method, of `palpate.METHODS`, several names, or `"all"`. `None`: that of the recording's scene.
        replay: `"motion"`: the device goes where it went, whatever the force. `"hand"`: the hand's force is estimated from
            the recording, and the device moves under the new force.
        begin: Takes the recording from this time of its own on [s]. `None`: from its first tick.
        end: Takes it up to this time of its own [s]. `None`: to its last tick.
        hand_bandwidth: Bandwidth of the hand's force [Hz]. `None`: the one under which the recording is most likely.
        hand_stiffness: Stiffness with which the hand holds on to its recorded motion [N/m]. `None`: 60, which is assumed.
        hand_damping: Damping with which it does [N s/m]. `None`: 2, which is assumed.
        model_device_mass: Mass of the device as the renderer is told [kg].
        settings: Settings of the methods, such as `damping`.

    The other arguments are those of `palpate.Renderer`. `None` leaves what the recording's scene says. Where neither
    `object_position` nor `object_velocity` is given, the object begins where it was recorded.

    A recording of a world takes no argument but `method`: its motion is rendered, and the answer is that of `simulate`.

    Returns:
        The report, and the ticks of each method as structured arrays; for a world its forces. `recording` and `replay` of the
        report say what was replayed and how well it is known.

    Raises:
        ValueError: A file that is no recording; a recording that cannot be replayed; a value that is not allowed, by the name of
            its argument.
        OSError: A file that cannot be read.

    Warns:
        UserWarning: A recording that is not whole; a run in which the device leaves the recorded motion farther than an arm
            reaches.
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
