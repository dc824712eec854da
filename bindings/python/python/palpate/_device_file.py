"""Calibrations, their device files, and the page about a device."""

from __future__ import annotations

import datetime
import json
import os
from pathlib import Path
from typing import Any, Mapping, Sequence, Union

import numpy as np
from numpy.typing import NDArray

from . import _palpate
from ._fixed import Fixed, FixedParameters, question_period
from ._report import Fields, Figure, Report
from ._scene import SceneLike, _scene


class Excitation(Fixed, _palpate.Excitation):
    """Forces that shake a device, so that its motion says what a renderer has to know of it.

    Make one, give it the position of the device at each period, and command the force that it answers. When it is
    `done`, `palpate.calibrate` fits the motion. It is what `palpate calibrate --pipe` does.

        excitation = palpate.Excitation(period=0.001, largest_force=0.5)
        while not excitation.done:
            command(excitation.step(read_position()))  # [m] in, [N] out
        found = palpate.calibrate(excitation)

    Hold the device as in use. The first 0.5 s have no force, the last answer is 0. When `step` raises, command 0: it
    asks for no force any more. Python does not keep time: where a period passes without a sample, the fit takes the
    device for a slower one. `palpate calibrate --device` has a loop that keeps time, and a safety layer.

    Args:
        period: Period of the loop [s], 0.0001 to 0.02.
        largest_force: Largest force on the device [N], 0.01 to 20.
        duration: How long it takes [s], 2 to 120.
        excursion: How far the device may go from where it starts [m]; beyond, `step` raises.
        tremor: Largest tremor of the hand, root mean square, before the force begins [m].
        seed: Seed of the random force steps.

    Raises:
        ValueError: A value that is not allowed.
    """

    parameters: dict[str, Any]
    """The arguments that it was made with. They cannot be set."""

    def __new__(
        cls,
        *,
        period: float,
        largest_force: float = 0.5,
        duration: float = 8.0,
        excursion: float = 0.01,
        tremor: float = 1e-3,
        seed: int = 1,
    ) -> Excitation:
        made = super().__new__(cls, period, largest_force, duration, excursion, tremor, seed)
        given = {
            "period": period,
            "largest_force": largest_force,
            "duration": duration,
            "excursion": excursion,
            "tremor": tremor,
            "seed": seed,
        }
        made.parameters = FixedParameters(given, "make another Excitation(**{**excitation.parameters, NAME: VALUE})")
        return made

    @property
    def motion(self) -> NDArray[np.float64]:
        """Positions [m] and the forces [N] that they were answered with so far, in two columns."""
        return np.column_stack([self.positions, self.forces])

    def __repr__(self) -> str:
        taken, whole = len(self.positions), len(self)
        return f"<palpate.Excitation: {taken} of {whole} samples>"


class Calibration(Report):
    """What a calibration found: the fields of `palpate calibrate --json`, and the device file.

    `found["device_mass_kg"].value` and `.standard_deviation` are what was found under the keys of a device file.
    """

    __slots__ = ("_device_file", "_whole")

    def __init__(
        self,
        fields: Mapping[str, Any] = {},
        text: str = "",
        figure: Figure = None,
        device_file: str = "",
        whole: str = "",
    ) -> None:
        super().__init__(fields, text, figure)
        self._device_file = device_file
        self._whole = whole

    def to_toml(self) -> str:
        """The device file as text (TOML): `Path("device.toml").write_text(found.to_toml())`."""
        return self._device_file

    def to_report(self) -> str:
        """The report with a part of the motion, as JSON, as `palpate calibrate --report` writes it."""
        return self._whole

    def __reduce__(self) -> Any:
        return (type(self), (dict(self), str(self), self._figure, self._device_file, self._whole))


DeviceFile = Union[str, "os.PathLike[str]", Calibration]
"""The path of a device file, or a calibration."""


def named_text(file: DeviceFile | None) -> tuple[str, str] | None:
    """The name and the text of a device file."""
    if file is None:
        return None
    if isinstance(file, Calibration):
        return ("the calibration", file.to_toml())
    return (str(file), Path(file).read_text(encoding="utf-8"))


def calibrate(
    device: Excitation | SceneLike,
    *,
    gain: float | None = None,
    spring: float | None = None,
    added_mass: float | None = None,
    before: DeviceFile | None = None,
    axis: str | None = None,
    **excitation: float,
) -> Calibration:
    """Measures what a renderer has to know of a device, as `palpate calibrate` does.

    Args:
        device: An excitation of a device that is done. Or a scene, or the path of one: its device is calibrated in
            simulated time, in its hand, which does not push.
        gain: Force that the motor gives over the force that is commanded, where it was measured.
        spring: Stiffness of a spring that the device is fixed to, with no hand on it [N/m]: gives the gain.
        added_mass: Mass that was fixed to the device after the calibration `before`, with no hand on it [kg]: gives
            the gain.
        before: Device file or calibration of the same device without that mass.
        axis: What the device file says of the axis.
        excitation: Of a scene: the arguments of `palpate.Excitation`; the period is the scene's where none is given.

    Returns:
        What was found, and the device file.

    Raises:
        ValueError: No calibration, with the reason: an excitation that stopped or is not done, a motion that says
            too little; a value that is not allowed.
        TypeError: Arguments of an excitation beside one.
        OSError: A file that cannot be read.
    """
    if isinstance(device, Excitation):
        if excitation:
            raise TypeError(f"{', '.join(excitation)}: an excitation that is done cannot be changed")
        excited, source = device, "palpate.calibrate of an excitation"
    else:
        scene = _scene(device)
        excitation.setdefault("period", scene.to_dict()["loop"]["period_s"])
        excited = Excitation(**excitation)  # type: ignore[arg-type]
        _palpate.excite_scene(scene, excited)
        source = f"palpate.calibrate of the simulated device of {scene.title!r}"
    said = ", ".join(f"{name}={value!r}" for name, value in excited.parameters.items())
    beside = {
        "gain": gain,
        "spring": spring,
        "added_mass": added_mass,
        "before": named_text(before),
        "axis": axis,
        "command": f"{source}, {said}",
        "date": datetime.date.today().isoformat(),
    }
    fields, text, figure, device_file, whole = _palpate.calibrate(excited, beside)
    return Calibration(json.loads(fields, object_hook=Fields), text, figure, device_file, whole)


class DeviceReport(Report):
    """What is to be said of a device: the fields of `palpate report --json`, and its page."""

    __slots__ = ("_page",)

    def __init__(self, fields: Mapping[str, Any] = {}, text: str = "", page: str = "") -> None:
        super().__init__(fields, text)
        self._page = page

    def to_html(self) -> str:
        """The page as HTML: one file, without scripts, without anything that lies elsewhere.
        `Path("device.html").write_text(page.to_html(), encoding="utf-8")` writes it."""
        return self._page

    def __reduce__(self) -> Any:
        return (type(self), (dict(self), str(self), self._page))


def report(
    recordings: str | os.PathLike[str] | Sequence[str | os.PathLike[str]] = (),
    *,
    device_file: DeviceFile | None = None,
    calibration: str | os.PathLike[str] | None = None,
    name: str | None = None,
    stiffness: float | None = None,
    period: float | None = None,
    method: str | Sequence[str] | None = None,
) -> DeviceReport:
    """Makes the report of a device from recordings and from its calibration, as `palpate report` does.

    Args:
        recordings: Recordings of the device (MCAP), at most 3, of one device.
        device_file: Its device file, or its calibration.
        calibration: Report of the calibration (JSON) with a part of the motion, `palpate calibrate --report`. A
            `device_file` that is a `Calibration` has it.
        name: What the device is called; `None`: as the recording says.
        stiffness: Stiffness that is asked about [N/m]; `None`: that of the recording, or 1000.
        period: Period of the loop [s]; `None`: that of the recording, or of the device file.
        method: Methods to compare; `None`: `basic`, `virtual-damper`, `hfcr` and `coupled`.

    Returns:
        The report, and its page.

    Raises:
        ValueError: A file that is none of its kind, recordings of several devices, a value that is not allowed.
        TypeError: Neither recordings nor a device file.
        OSError: A file that cannot be read.
    """
    several = [recordings] if isinstance(recordings, (str, os.PathLike)) else [*recordings]
    motion: tuple[str, str] | None = None
    if calibration is not None:
        motion = (str(calibration), Path(calibration).read_text(encoding="utf-8"))
    elif isinstance(device_file, Calibration):
        motion = ("the calibration", device_file.to_report())
    question_period(period)
    sources = {
        "recordings": several,
        "device_file": named_text(device_file),
        "calibration": motion,
        "name": name,
        "stiffness": stiffness,
        "period": period,
    }
    fields, text, page = _palpate.report(sources, method)
    return DeviceReport(json.loads(fields, object_hook=Fields), text, page)
