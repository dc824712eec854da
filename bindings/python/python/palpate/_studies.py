"""Studies that consist of many runs."""

from __future__ import annotations

import csv
import json
import math
from typing import Any, Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _palpate
from ._arrays import numbers
from ._device_file import DeviceFile, named_text
from ._fixed import question_period
from ._report import Fields, Report
from ._scene import SceneLike, _scene, _scenes
from ._table import Table, of_records


def tune(
    scene: SceneLike,
    method: str | None = None,
    *,
    values: ArrayLike | None = None,
    steps: int = 400,
    least: str = "error",
) -> Report:
    """Evaluates a method at several values of its damping, over 21 start heights, as `palpate tune` does.

    Args:
        scene: A scene, or the path of a scene file.
        method: Name of a method that has a damping or a cap. `None`: that of the scene.
        values: Values to evaluate [N s/m]. `None`: `steps` values over the usual range.
        steps: Number of values if `values` is `None`.
        least: Quantity that the best value minimises: `"error"` or `"leak"`.

    Returns:
        The report: `best`, `best_at_own_height`, and `curve` with every value.

    Raises:
        ValueError: The method has no damping or does not allow a value, or the scene cannot be simulated.
        OSError: A file cannot be read.
    """
    given = None if values is None else numbers("values", values).ravel().tolist()
    fields, text, figure = _palpate.tune(_scene(scene), method, given, steps, least)
    return Report._of((fields, text), figure)


def heights(
    scenes: SceneLike | Iterable[SceneLike],
    method: str | Sequence[str] = "all",
    *,
    model_mass_factor: float = 1.0,
) -> Report:
    """Evaluates methods on scenes from 21 start heights each, as `palpate paper heights` does.

    Args:
        scenes: Scenes, or paths of scene files.
        method: Name of a method, of `palpate.METHODS`, several names, or `"all"`.
        model_mass_factor: Ratio of the model value of the device mass to the true mass.

    Returns:
        The report: `scenes`, each with its `columns`, one per method.

    Raises:
        ValueError: A scene cannot be simulated, or not with one of the methods.
        OSError: A file cannot be read.
    """
    return Report._of(_palpate.heights(_scenes(scenes), method, model_mass_factor))


def sweep(
    scene: SceneLike,
    over: str,
    values: ArrayLike,
    method: str | Sequence[str] | None = None,
    *,
    heights: bool = False,
) -> Report:
    """Evaluates methods on a scene at several values of one quantity, as `palpate sweep` does.

    Args:
        scene: A scene, or the path of a scene file.
        over: Quantity to vary: `"stiffness"`, `"mass"` or `"friction"`, factors on the stiffness of the contact, the
            mass of the object and the friction of the device; `"box"`, the safety box of a pantograph along y [m];
            `"damping"`, the damping or the cap of the methods [N s/m].
        values: Values of the quantity.
        method: Name of a method, several names, or `"all"`. `None`: all; for `"damping"` all that have a damping.
        heights: Whether each value is also evaluated over 21 start heights.

    Returns:
        The report: `values`, each with its `columns`, one per method.

    Raises:
        ValueError: The scene or a method does not have the quantity or does not allow a value, or the scene cannot be
            simulated.
        OSError: A file cannot be read.
    """
    given = numbers("values", values).ravel().tolist()
    return Report._of(_palpate.sweep(_scene(scene), over, given, method, heights))


def claims() -> Report:
    """Reproduces the numbers that the paper claims, as `palpate paper claims` does. It takes about ten seconds.

    Returns:
        The report: `claims`, each with its place in the paper, the numbers `found`, and whether it `holds`.
    """
    return Report._of(_palpate.claims())


def suite(
    set: str = "paper",
    method: str | Sequence[str] | None = None,
    *,
    seed: int = 1,
    plants: int = 200,
    seeds: int = 1,
) -> Report:
    """Evaluates methods on random plants, as `palpate suite` does.

    Args:
        set: Family of plants: `"paper"`, `"desk"`, `"real"`, `"steps"` or `"calibrated"`.
        method: Name of a method, several names, or `"all"`. `None`: the default methods of the set.
        seed: Seed of the random numbers.
        plants: Number of plants per seed, at most a million.
        seeds: Number of seeds, from `seed` on. With several, `over_seeds` has the median and the range over the seeds.

    Returns:
        The report: `columns`, one per method, with the distribution of its errors.

    Raises:
        ValueError: The set or a method does not exist, or the number of plants is not allowed.
    """
    fields, text, figure = _palpate.run_suite(set, seed, plants, method, seeds)
    return Report._of((fields, text), figure)


class Map(Table, Report):
    """Map of the contacts that each method can render: the fields of `palpate map --json`, and every cell.

    A notebook shows its figure.
    """

    __slots__ = ("_csv",)

    def __init__(self, fields: Mapping[str, Any] = {}, text: str = "", svg: str = "", csv: str = "") -> None:
        super().__init__(fields, text, svg)
        self._csv = csv

    @classmethod
    def _of_map(cls, made: tuple[str, str, str, str]) -> Map:
        fields, text, svg, table = made
        return cls(json.loads(fields, object_hook=Fields), text, svg, table)

    @property
    def rows(self) -> NDArray[np.void]:
        """A record for each cell, plant and method, with the columns of the program's file
        (`docs/reference/tables.md` in palpate's repository). Missing values are NaN."""
        lines = [line for line in self._csv.splitlines() if not line.startswith("#")]
        [names, *rows] = csv.reader(lines)
        # The first line has the metadata of the map in its last column.
        names = names[:-1]
        words = {"plant", "method"}
        dtype = [(name, "U20" if name in words else "f8") for name in names]
        values = [
            tuple(cell if name in words else float(cell or "nan") for name, cell in zip(names, row)) for row in rows
        ]
        return np.array(values, dtype)

    def to_csv(self) -> str:
        """Returns the map as the text of the program's file, for `palpate map merge` and other tools."""
        return self._csv

    def _columns(self) -> dict[str, NDArray[Any]]:
        return of_records(self.rows)

    def __reduce__(self) -> Any:
        return (type(self), (dict(self), str(self), self.to_svg(), self._csv))


def map(
    method: str | Sequence[str] = "all",
    *,
    cells: int = 20,
    viscous_friction: float | None = None,
    encoder_quantum: float = 0.0,
    model_mass: float = 1.0,
    model_period: float = 1.0,
    delay_periods: float = 0.0,
    lag_periods: float = 0.0,
    delay_deviation_periods: float = 0.0,
    lag_deviation_periods: float = 0.0,
    forces: str = "balanced",
) -> Map:
    """Computes the contacts that each method can render, over stiffness and mass of the object, as `palpate map` does.

    Args:
        method: Name of a method, of `palpate.METHODS`, several names, or `"all"`.
        cells: Cells along each axis, 2 to 1000; the program's default is 100, which takes minutes.
        viscous_friction: Viscous friction of the damped device [N s/m]; `None`: that of the paper.
        encoder_quantum: Quantum of the device's position sensor [m].
        model_mass: Ratio of the model value of the device mass to the true mass.
        model_period: Ratio of the model value of the period to the true period.
        delay_periods: Time from a sample to the beginning of its force [periods].
        lag_periods: Time constant of the actuator [periods].
        delay_deviation_periods: Standard deviation of the delay in the renderer's model, at most 8 [periods].
        lag_deviation_periods: Standard deviation of the lag in the renderer's model, at most 8 [periods].
        forces: Forces that press device and object together: `"balanced"` or `"weight"`.

    Returns:
        The report: `methods` has the fraction of the map on which each method is stable and faithful; `rows` has the
        cells.

    Raises:
        ValueError: An argument is not allowed.
    """
    given = dict(locals())
    del given["method"]
    return Map._of_map(_palpate.map(method, given))


def advise(
    *,
    period: float,
    device_mass: float | None = None,
    stiffness: float | None = None,
    mass: float = math.inf,
    method: str | Sequence[str] = "all",
    viscous_friction: float = 0.0,
    coulomb_friction: float = 0.0,
    encoder_quantum: float | None = None,
    delay: float | None = None,
    lag: float | None = None,
    delay_deviation: float | None = None,
    lag_deviation: float | None = None,
    device_file: DeviceFile | None = None,
) -> Report:
    """Computes the contacts that each method can render on a device, as `palpate advise` does.

    Args:
        period: Period T of the loop [s].
        device_mass: Effective mass of the device [kg]; `None`: that of `device_file`.
        stiffness: Desired stiffness K of the contact [N/m]; `None`: none, the report has the stiffest contact.
        mass: Mass M of the object [kg]; `math.inf`: a wall.
        method: Name of a method, several names, or `"all"`.
        viscous_friction: Viscous friction of the device [N s/m].
        coulomb_friction: Coulomb friction of the device [N].
        encoder_quantum: Quantum of the position sensor [m]; `None`: that of `device_file`, or 0.
        delay: Time from a sample to the beginning of its force [s]; `None`: that of `device_file`, or 0.
        lag: Time constant of the actuator [s]; `None`: that of `device_file`, or 0.
        delay_deviation: Standard deviation of the delay [s], at most 8 periods; `None`: that of `device_file`, or 0.
        lag_deviation: Standard deviation of the lag [s], at most 8 periods; `None`: that of `device_file`, or 0.
        device_file: A device file of `palpate calibrate`, or a `palpate.Calibration`.

    Returns:
        The report: `verdict`, and for each of `methods` its result for the contact, the stiffest contact and the
        lightest object.

    Raises:
        ValueError: An argument is not allowed, or the device file is not valid.
        OSError: The device file cannot be read.
    """
    question_period(period)
    given = {
        "period": period,
        "device_mass": device_mass,
        "stiffness": stiffness,
        "mass": mass,
        "viscous_friction": viscous_friction,
        "coulomb_friction": coulomb_friction,
        "encoder_quantum": encoder_quantum,
        "delay": delay,
        "lag": lag,
        "delay_deviation": delay_deviation,
        "lag_deviation": lag_deviation,
        "device_file": named_text(device_file),
    }
    return Report._of(_palpate.advise(method, given), (_palpate.advice_figure, (method, given)))
