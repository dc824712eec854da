"""Studies of many runs."""

from __future__ import annotations

from typing import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from . import _palpate
from ._report import Report
from ._scene import SceneLike, _scene, _scenes


def tune(
    scene: SceneLike,
    method: str | None = None,
    *,
    values: ArrayLike | None = None,
    steps: int = 400,
    least: str = "error",
) -> Report:
    """Judges a method at values of its damping, over 21 start heights, as `palpate tune` does.

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
    given = None if values is None else np.asarray(values, dtype=np.float64).ravel().tolist()
    return Report._of(_palpate.tune(_scene(scene), method, given, steps, least))


def heights(
    scenes: SceneLike | Iterable[SceneLike],
    method: str | Sequence[str] = "all",
    *,
    told_mass_factor: float = 1.0,
) -> Report:
    """Judges methods on scenes from 21 start heights each, as `palpate heights` does.

    Args:
        scenes: Scenes, or paths of scene files.
        method: Name of a method, of `palpate.METHODS`, several names, or `"all"`.
        told_mass_factor: Mass of the device that a renderer is told, over the true one.

    Returns:
        The report: `scenes`, and of each its `columns`, one for each method.

    Raises:
        ValueError: A scene that cannot be run, or not by a method.
        OSError: A file that cannot be read.
    """
    return Report._of(_palpate.heights(_scenes(scenes), method, told_mass_factor))


def suite(
    set: str = "paper",
    method: str | Sequence[str] | None = None,
    *,
    seed: int = 1,
    plants: int = 200,
) -> Report:
    """Judges methods on plants that are drawn at random, as `palpate suite` does.

    Args:
        set: Family of plants: `"paper"`, `"desk"`, `"real"` or `"steps"`.
        method: Name of a method, several names, or `"all"`. `None`: those that the set is for.
        seed: Seed of the draws.
        plants: Number of plants.

    Returns:
        The report: `columns`, one for each method, with the distribution of its errors.

    Raises:
        ValueError: A set or a method that there is not.
    """
    return Report._of(_palpate.run_suite(set, seed, plants, method))
