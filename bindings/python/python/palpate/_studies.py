"""Studies of many runs."""

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
    """Evaluates a method at values of its damping, over 21 start heights, as `palpate tune` does.

    Args:
        scene: A scene, or the path of a scene file.
        method: Name of a method that has a damping or a cap. `None`: the scene's own.
        values: Values to try [N s/m]. `None`: `steps` values over the usual range.
        steps: Number of values where none are given.
        least: What the best value makes least: `"error"` or `"leak"`.

    Returns:
        The report: `best`, `best_at_own_height`, and `curve` with every value.

    Raises:
        ValueError: A method without a damping, a value that it does not allow, a scene that cannot be run.
        OSError: A file that cannot be read.
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
    """Evaluates methods on scenes from 21 start heights each, as `palpate heights` does.

    Args:
        scenes: Scenes, or paths of scene files.
        method: Name of a method, of `palpate.METHODS`, several names, or `"all"`.
        model_mass_factor: Mass of the device that a renderer is told, over the true one.

    Returns:
        The report: `scenes`, and of each its `columns`, one for each method.

    Raises:
        ValueError: A scene that cannot be run, or not by a method.
        OSError: A file that cannot be read.
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
        over: What is varied: `"friction"`, a factor on the friction of the device; `"box"`, the safety box of a pantograph
            along y [m]; `"damping"`, the damping or the cap of the methods [N s/m].
        values: Its values.
        method: Name of a method, several names, or `"all"`. `None`: all; of `"damping"` those that have one.
        heights: Whether each value is judged over 21 start heights too.

    Returns:
        The report: `values`, and of each its `columns`, one for each method.

    Raises:
        ValueError: A quantity that the scene or a method does not have, a value that it cannot have, a scene that cannot
            be run.
        OSError: A file that cannot be read.
    """
    given = numbers("values", values).ravel().tolist()
    return Report._of(_palpate.sweep(_scene(scene), over, given, method, heights))


def claims() -> Report:
    """Computes anew the numbers that the paper of HFCR claims, as `palpate claims` does. It takes some ten seconds.

    Returns:
        The report: `claims`, and of each where it stands, the numbers that were `found`, and whether it `holds`.
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
    """Evaluates methods on plants that are drawn at random, as `palpate suite` does.

    Args:
        set: Family of plants: `"paper"`, `"desk"`, `"real"`, `"steps"` or `"calibrated"`.
        method: Name of a method, several names, or `"all"`. `None`: those that the set is for.
        seed: Seed of the draws.
        plants: Number of plants of each seed, at most a million.
        seeds: Number of seeds, from `seed` on. With several, `over_seeds` has the median and the range over the seeds.

    Returns:
        The report: `columns`, one for each method, with the distribution of its errors.

    Raises:
        ValueError: A set or a method that there is not, another number of plants.
    """
    fields, text, figure = _palpate.run_suite(set, seed, plants, method, seeds)
    return Report._of((fields, text), figure)


class Map(Table, Report):
    """What each method can render: the fields of `palpate map --json`, and every cell. In a notebook it is its figure."""

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
        """A record for each cell, plant and method, with the columns of the program's file (`docs/map.md` in palpate's
        repository). What a cell has not is NaN."""
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
        """The text of the program's file of this map, for `palpate map merge` and others."""
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
    delay: float = 0.0,
    lag: float = 0.0,
    delay_deviation: float = 0.0,
    lag_deviation: float = 0.0,
    forces: str = "balanced",
) -> Map:
    """Computes what each method can render, over stiffness and mass of the object, as `palpate map` does.

    Args:
        method: Name of a method, of `palpate.METHODS`, several names, or `"all"`.
        cells: Cells along each axis, 2 to 1000; the program's default is 100, which takes minutes.
        viscous_friction: Of the damped device [N s/m]; `None`: that of the paper's.
        encoder_quantum: Quantum of the device's position sensor [m].
        model_mass: Mass of the device that the renderer is told, over the true one.
        model_period: Period that the renderer is told, over the true one.
        delay: Time from a sample to the beginning of its force [periods].
        lag: Time constant of the actuator [periods].
        delay_deviation: Standard deviation of the delay in the renderer's model [periods].
        lag_deviation: Standard deviation of the lag in the renderer's model [periods].
        forces: What drives device and object together: `"balanced"` or `"weight"`.

    Returns:
        The report: `methods` says on how much of the map each one is stable and faithful; `rows` has the cells.

    Raises:
        ValueError: A value that is not allowed.
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
    """Says what can be rendered on a device, and by which method, as `palpate advise` does.

    Args:
        period: Period T of the loop [s].
        device_mass: Effective mass of the device [kg]; `None`: that of `device_file`.
        stiffness: Stiffness K of the contact that one would like [N/m]; `None`: how stiff can it be?
        mass: Mass M of the object [kg]; `math.inf`: a wall.
        method: Name of a method, several names, or `"all"`.
        viscous_friction: Of the device [N s/m].
        coulomb_friction: Of the device [N].
        encoder_quantum: Quantum of the position sensor [m]; `None`: that of `device_file`, or 0.
        delay: Time from a sample to the beginning of its force [periods]; `None`: that of `device_file`, or 0.
        lag: Time constant of the actuator [s]; `None`: that of `device_file`, or 0.
        delay_deviation: Standard deviation of the delay [periods]; `None`: that of `device_file`, or 0.
        lag_deviation: Standard deviation of the lag [s]; `None`: that of `device_file`, or 0.
        device_file: A device file of `palpate calibrate`, or a `palpate.Calibration`.

    Returns:
        The report: `verdict`, and for each of `methods` how it renders the contact, the stiffest contact and the lightest
        object.

    Raises:
        ValueError: A value that is not allowed, or a device file that cannot be read as one.
        OSError: A device file that is not there.
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
