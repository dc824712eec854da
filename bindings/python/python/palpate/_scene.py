"""Scenes, and the simulation and comparison of methods in them."""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING, Any, Callable, Iterable, Mapping, Sequence, Union, overload

from . import _palpate
from ._fixed import Fixed, question_lag, question_period
from ._report import Report, Runs, WorldRuns
from ._values import Situation

if TYPE_CHECKING:
    from ._world import World

Tables = Mapping[str, Any]
"""Table of a scene file: keys and values."""


class Scene(Fixed, _palpate.Scene):
    """Closed loop to simulate: a device in a hand, and its contact with one body along one axis.

    Each argument is a table of a scene file, as a dictionary. Keys, units, ranges and defaults are those of the file
    (`docs/reference/scene.md` in palpate's repository lists them). Tables within tables are dictionaries, too: `hand` and
    `drivetrain` of the device. Values of `None` are omitted. `Scene.read` reads a file. A scene with more than one contact
    along one axis is a `palpate.World`.

        palpate.Scene(
            "A light block",
            loop={"period_s": 0.01},
            device={"name": "device", "axes": ["x"], "mass_kg": 0.25, "hand": {"force_n": [1.0, 0, 0]}},
            body={
                "name": "block",
                "axes": ["x"],
                "mass_kg": 0.1,
                "position_m": [0.01, 0, 0],
                "force_n": [-0.981, 0, 0],
                "shape": {"half_space": {"normal": [-1, 0, 0]}},
            },
            contact={"between": ["device", "block"], "stiffness_n_per_m": 400.0},
            measure={"duration_s": 1.0},
        )

    Args:
        title: Title for tables and figures, one line.
        loop: The loop.
        device: The device, or a sequence of one device.
        body: The body, or a sequence of one body.
        contact: The contact law, or a sequence of one law.
        measure: The evaluation window. `None`: 0.5 s.
        model: Model values that override the true values for the renderer.
        render: The default method, the limits and the guard.
        methods: Settings of methods, by method name.
        folder: Folder of the files that the scene names.

    Raises:
        ValueError: Values are not allowed, with a line for each and its key; or the scene has more than one contact along
            one axis.
    """

    def __new__(
        cls,
        title: str,
        *,
        loop: Tables,
        device: Tables | Sequence[Tables],
        body: Tables | Sequence[Tables],
        contact: Tables | Sequence[Tables],
        measure: Tables | None = None,
        model: Tables | None = None,
        render: Tables | None = None,
        methods: Mapping[str, Tables] | None = None,
        folder: str | os.PathLike[str] = "",
    ) -> Scene:
        tables = {
            "format": 2,
            "title": title,
            "loop": loop,
            "device": _several(device),
            "body": _several(body),
            "contact": _several(contact),
            "model": model,
            "render": render,
            "methods": methods,
            "measure": measure,
        }
        return cls._of(_palpate.to_toml(tables), None, folder)

    @classmethod
    def _of(cls, text: str, name: str | None, folder: str | os.PathLike[str]) -> Scene:
        made = super().__new__(cls, text, name, folder)
        loop = _palpate.from_toml(text)["loop"]
        question_period(loop["period_s"], "period_s", 4)
        question_lag(loop.get("lag_s"), "lag_s", 4)
        return made

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Scene:
        """Reads a scene file. Messages have the file, the line and the column.

        Raises:
            ValueError: The scene is not valid, or has more than one contact along one axis.
            OSError: The file cannot be read.
        """
        return cls._of(*_palpate.read_scene(path))

    @classmethod
    def parse(cls, text: str, folder: str | os.PathLike[str] = "") -> Scene:
        """Parses the text of a scene file."""
        return cls._of(text, "scene", folder)

    def replace(self, title: str | None = None, **tables: Tables | Sequence[Tables]) -> Scene:
        """Returns a copy with the given keys of the given tables replaced; `None` removes a key.

            scene.replace(body={"mass_kg": 0.05}, loop={"period_s": 0.002})

        Keys of tables within a table are replaced one by one, too. A sequence of tables replaces the device, body or
        contact as a whole.
        """
        text, _, folder = self.parts()
        changed = _merged(_palpate.from_toml(text), tables)
        if title is not None:
            changed["title"] = title
        return self._of(_palpate.to_toml(changed), None, folder)

    def to_dict(self) -> dict[str, Any]:
        """Returns the tables of the scene."""
        return _palpate.from_toml(self.parts()[0])

    def to_toml(self) -> str:
        """Returns the text of the scene file."""
        return self.parts()[0]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Scene) and self.parts() == other.parts()

    def __hash__(self) -> int:
        return hash(self.parts())

    def __reduce__(self) -> Any:
        return (type(self)._of, self.parts())

    def __repr__(self) -> str:
        return f"<palpate.Scene {self.title!r}>"


_ARRAYS = ("device", "body", "contact", "joint", "field")
"""Arrays of tables of a scene file."""


def _several(given: Tables | Sequence[Tables]) -> Any:
    """Returns an array of tables; a single table is an array of one."""
    if isinstance(given, Mapping):
        return [given]
    # Other values are refused by their place.
    return list(given) if isinstance(given, Sequence) and not isinstance(given, str) else given


def _merged(tables: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the tables of a scene with the keys of `changes` replaced."""
    merged = dict(tables)
    for key, value in changes.items():
        before = merged.get(key)
        if key not in _ARRAYS:
            merged[key] = _replaced(before, value)
        elif isinstance(value, Mapping) and isinstance(before, list) and len(before) == 1:
            merged[key] = [_replaced(before[0], value)]
        else:
            merged[key] = _several(value)
    return merged


def _replaced(before: Any, value: Any) -> Any:
    """Returns `value`; of a table, `before` with the keys of `value` replaced."""
    if not isinstance(value, Mapping):
        return value
    kept = dict(before) if isinstance(before, Mapping) else {}
    return {**kept, **{key: _replaced(kept.get(key), one) for key, one in value.items()}}


SceneLike = Union[Scene, str, "os.PathLike[str]"]
"""Scene, or path of a scene file."""


MethodLike = Union[str, Callable[[Situation], float]]
"""Name of a method, or a user-defined method: a function that returns the force on the object [N] in contact."""


@overload
def simulate(scene: World, method: str | Sequence[str] | None = None) -> WorldRuns: ...
@overload
def simulate(scene: Scene, method: MethodLike | Sequence[MethodLike] | None = None) -> Runs: ...
@overload
def simulate(scene: str | os.PathLike[str], method: MethodLike | Sequence[MethodLike] | None = None) -> Any: ...
def simulate(
    scene: SceneLike | World, method: MethodLike | Sequence[MethodLike] | None = None
) -> Runs | WorldRuns:
    """Simulates a scene or a world in closed loop and evaluates each method, as `palpate simulate` does.

    Args:
        scene: A scene, a world, or the path of a scene file. A file with one contact along one axis is a `Scene`, and
            any other is a `World`. A world is simulated from its initial state; the hands of its tables move its devices.
        method: Name of a method, of `palpate.METHODS`, several names, or `"all"`. `None`: that of the scene.
            A function is a user-defined method with the function's name. At each sample in contact it gets a
            `palpate.Situation` and returns the force on the object [N] to hold until the next sample. The object moves
            as in the paper: it is free or in contact throughout an interval, as at the sample.
            Worlds accept names only, those of the world renderer.

    Returns:
        The report, and the ticks of each method as arrays; for a world its forces.

    Raises:
        ValueError: The scene cannot be simulated, or not with this method.
        Exception: An exception of a user-defined method.
        OSError: A file cannot be read.
    """
    from ._world import World

    if isinstance(scene, (str, os.PathLike)):
        text, name, folder = _palpate.read_scene(scene)
        scene = World(scene) if _palpate.is_world(text) else Scene._of(text, name, folder)
    if isinstance(scene, World):
        return WorldRuns._of_worlds(_palpate.simulate_world(scene, method))
    made = _palpate.simulate(scene, method)
    several = [method] if method is None or isinstance(method, str) or callable(method) else method
    # A user-defined method may be stateful, so it is not run again for a figure.
    is_drawn = not any(callable(one) for one in several)
    return Runs._of_runs(made, (_palpate.simulate_figure, (scene, method)) if is_drawn else None)


class Bench:
    """Scene on which several methods are run one by one.

        bench = palpate.Bench("experiments/fig2.toml")
        bench.run("coupled")
        bench.run(look_ahead)  # a function: a user-defined method
        print(bench.errors())  # mean-force error [%] of each run, the best first

    Args:
        scene: A scene, or the path of a scene file of one contact.

    Raises:
        ValueError: The scene is not valid, or is a world.
        OSError: A file cannot be read.
    """

    scene: Scene
    """The scene."""
    runs: dict[str, Runs]
    """The last run of each method, by name."""

    def __init__(self, scene: SceneLike) -> None:
        self.scene = _scene(scene)
        self.runs = {}

    def run(self, method: MethodLike, name: str | None = None) -> Runs:
        """Runs a method, as `palpate.simulate` does, and stores the result.

        Args:
            method: Name of a method, or a user-defined method.
            name: Key of the result in `runs`; `None`: the name of the method.

        Returns:
            The report, and its ticks.

        Raises:
            ValueError: The scene cannot be simulated, or not with this method.
            Exception: An exception of a user-defined method.
        """
        run = simulate(self.scene, method)
        self.runs[name or run["methods"][0]["method"]] = run
        return run

    def errors(self) -> dict[str, float]:
        """Returns the mean-force error E of each run [%], in ascending order; infinite if the loop diverged."""
        of = {name: run["methods"][0].get("mean_force_error_percent") for name, run in self.runs.items()}
        known = {name: math.inf if error is None else float(error) for name, error in of.items()}
        return dict(sorted(known.items(), key=lambda run: run[1]))

    def __repr__(self) -> str:
        return f"<palpate.Bench {self.scene.title!r}: {', '.join(self.runs) or 'no run'}>"


def compare(scenes: SceneLike | Iterable[SceneLike], method: str | Sequence[str] = "all") -> Report:
    """Compares methods on several scenes, as `palpate compare` does.

    Args:
        scenes: Scenes, or paths of scene files, at least one.
        method: Name of a method, of `palpate.METHODS`, several names, or `"all"`.

    Returns:
        The report: `scenes`, each with its `methods`. A method that cannot be set up on a scene has the field `cannot`
        with the reason instead of its numbers.

    Raises:
        ValueError: A scene cannot be simulated, or there is no scene.
        OSError: A file cannot be read.
    """
    *made, figure = _palpate.compare(_scenes(scenes), method)
    return Report._of((made[0], made[1]), figure)


def _scenes(scenes: SceneLike | Iterable[SceneLike]) -> list[_palpate.Scene]:
    several = [scenes] if isinstance(scenes, (Scene, str, os.PathLike)) else scenes
    return [_scene(scene) for scene in several]


def _scene(scene: SceneLike) -> Scene:
    return scene if isinstance(scene, Scene) else Scene.read(scene)
