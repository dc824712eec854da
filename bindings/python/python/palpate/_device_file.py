"""Calibrations, device files and device reports."""

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
    """Excitation force for the identification of a device.

    Pass the position of the device to `step` in each period and command the returned force. When the excitation is
    `done`, `palpate.calibrate` identifies the device from the motion, as `palpate calibrate --pipe` does.

        excitation = palpate.Excitation(period=0.001, largest_force=0.5)
        while not excitation.done:
            command(excitation.step(read_position()))  # [m] in, [N] out
        found = palpate.calibrate(excitation)

    Hold the device as in use. The force is 0 during the first 0.5 s and after the last sample. If `step` raises,
    command 0: the excitation has ended. Python does not keep time: if a period passes without a sample, the
    identification attributes the delay to the device. `palpate calibrate --device` has a real-time loop and a safety
    layer.

    Args:
        period: Period of the loop [s], 0.0001 to 0.02.
        largest_force: Largest force on the device [N], 0.01 to 20.
        duration: Duration of the excitation [s], 2 to 120.
        excursion: Allowed distance of the device from its start position [m]; beyond it `step` raises.
        tremor: Largest RMS tremor of the hand before the force begins [m].
        seed: Seed of the random force steps.

    Raises:
        ValueError: An argument is not allowed.
    """

    parameters: dict[str, Any]
    """Arguments of the constructor, read-only."""

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
        """Positions [m] and returned forces [N] so far, in two columns."""
        return np.column_stack([self.positions, self.forces])

    def __repr__(self) -> str:
        taken, whole = len(self.positions), len(self)
        return f"<palpate.Excitation: {taken} of {whole} samples>"


class Calibration(Report):
    """Result of a calibration: the fields of `palpate calibrate --json`, and the device file.

    Each key of the device file has an estimate, such as `found["device_mass_kg"].value`, and a `.standard_deviation`.
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
        """Returns the device file as text (TOML): `Path("device.toml").write_text(found.to_toml())`."""
        return self._device_file

    def to_report(self) -> str:
        """Returns the report with an excerpt of the motion as JSON, as `palpate calibrate --report` writes it."""
        return self._whole

    def __reduce__(self) -> Any:
        return (type(self), (dict(self), str(self), self._figure, self._device_file, self._whole))


DeviceFile = Union[str, "os.PathLike[str]", Calibration]
"""Path of a device file, or a calibration."""


def named_text(file: DeviceFile | None) -> tuple[str, str] | None:
    """Returns the name and the text of a device file."""
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
    """Identifies the parameters of a device, as `palpate calibrate` does.

    Args:
        device: A completed excitation; or a scene, or the path of a scene file. The device of a scene is calibrated in
            simulated time, in its hand, which exerts no force of its own.
        gain: Measured ratio of delivered to commanded force, if known.
        spring: Stiffness of a spring that the device is fixed to, without a hand [N/m]; it determines the gain.
        added_mass: Mass that was fixed to the device after the calibration `before`, without a hand [kg]; it determines
            the gain.
        before: Device file or calibration of the same device without `added_mass`.
        axis: Description of the axis for the device file.
        excitation: Arguments of `palpate.Excitation`, for a scene only. The default period is that of the scene.

    Returns:
        The estimates and the device file.

    Raises:
        ValueError: The calibration failed, with the reason: the excitation stopped or is incomplete, or the motion does
            not determine the parameters; or an argument is not allowed.
        TypeError: Arguments of an excitation are given together with an excitation.
        OSError: A file cannot be read.
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
    """Device report: the fields of `palpate report --json`, and its page."""

    __slots__ = ("_page",)

    def __init__(self, fields: Mapping[str, Any] = {}, text: str = "", page: str = "") -> None:
        super().__init__(fields, text)
        self._page = page

    def to_html(self) -> str:
        """Returns the page as one HTML file without scripts and external resources.
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
    """Creates the device report from recordings and a calibration, as `palpate report` does.

    Args:
        recordings: Recordings (MCAP) of one device, at most 3.
        device_file: Device file or calibration of the device.
        calibration: Report of the calibration (JSON) with an excerpt of the motion, from `palpate calibrate --report`.
            A `device_file` that is a `Calibration` contains it.
        name: Name of the device; `None`: the name in the recording.
        stiffness: Contact stiffness to evaluate [N/m]; `None`: that of the recording, or 1000.
        period: Period of the loop [s]; `None`: that of the recording, or of the device file.
        method: Methods to compare; `None`: `basic`, `virtual-damper`, `hfcr` and `coupled`.

    Returns:
        The report and its page.

    Raises:
        ValueError: A file has the wrong format, the recordings are of several devices, or an argument is not allowed.
        TypeError: Neither recordings nor a device file are given.
        OSError: A file cannot be read.
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
