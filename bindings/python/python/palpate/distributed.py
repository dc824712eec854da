"""Maps, suites and tunings in parts, on many machines: `pip install palpate[distributed]`.

    from distributed import Client
    from palpate import distributed

    study = distributed.map(["basic", "coupled"], cells=200, parts=64)
    with Client("scheduler:8786") as client:
        study.run(client, "/shared/map")
    reach = study.merge("/shared/map")  # what palpate.map returns

Each part is a Dask task and a Parquet file in a folder that all machines share. A file is written atomically. Its
content depends only on the study and on the number of the part, not on the number or choice of workers. If a worker
dies, Dask reassigns its unfinished parts. A stopped study continues with the missing parts when it is run again.
"""

from __future__ import annotations

import json
import os
import uuid
from pathlib import Path
from typing import Any, Iterable, Mapping, Sequence

from . import _palpate
from ._arrays import plain
from ._palpate import __version__
from ._report import Report
from ._scene import Scene, SceneLike, _scenes
from ._studies import Map
from ._studies import map as _map
from ._studies import tune as _tune

try:
    import distributed as _dask
    import pyarrow
    import pyarrow.parquet
except ImportError as _missing:
    raise ImportError(
        "palpate.distributed needs Dask and Arrow: pip install 'palpate[distributed]'"
    ) from _missing

__all__ = ["MapStudy", "Study", "SuiteStudy", "TuneStudy", "map", "suite", "tune"]

_KEY = b"palpate"
"""Key of the metadata of a part, as JSON: identity of the study, and data that are not in its columns."""


class Study:
    """Computation in parts. `map`, `suite` and `tune` create one.

    A study is small and is pickled. It has no state: the folder has the completed parts.
    """

    parts: int
    """Number of parts, numbered from 1."""

    def __init__(self, parts: int) -> None:
        if parts < 1:
            raise ValueError(f"parts is {parts}, but must be 1 or more")
        self.parts = parts

    def run(self, client: _dask.Client, folder: str | os.PathLike[str]) -> list[Path]:
        """Computes the parts that are missing in the folder, and waits for them.

        Args:
            client: A Dask client. Its workers need the same version of palpate, and the folder under the same path.
            folder: Folder of the parts, each a Parquet file.

        Returns:
            The files of all parts.

        Raises:
            ValueError: A file in the folder is a part of another study.
            distributed.KilledWorker: A part killed several workers, more than
                `distributed.scheduler.allowed-failures` of Dask's configuration (3). Other parts are kept.
            Exception: An exception of a part.
        """
        futures = self.submit(client, folder)
        try:
            client.gather(futures)
        finally:
            client.cancel(futures)
        for part in range(1, self.parts + 1):
            # Remove leftovers of killed workers.
            for torn in Path(folder).glob(f".{self.file(part)}.*"):
                torn.unlink(missing_ok=True)
        return [Path(folder) / self.file(part) for part in range(1, self.parts + 1)]

    def submit(self, client: _dask.Client, folder: str | os.PathLike[str]) -> list[_dask.Future]:
        """Submits the parts that are missing in the folder to Dask without waiting, and returns a future for each. For
        several studies at once.

        Raises:
            ValueError: A file in the folder is a part of another study.
        """
        Path(folder).mkdir(parents=True, exist_ok=True)
        return [
            client.submit(Study.make, self, part, os.fspath(folder), key=f"palpate-{part}-of-{self.parts}-{uuid.uuid4()}")
            for part in self.missing(folder)
        ]

    def make(self, part: int, folder: str | os.PathLike[str]) -> str:
        """Computes a part in this process, in one thread, and writes its file, unless the file exists.

        Returns:
            The name of its file.

        Raises:
            ValueError: The part does not exist, or its file belongs to another study.
        """
        if not 1 <= part <= self.parts:
            raise ValueError(f"part is {part}, but must be 1 to {self.parts}")
        name = self.file(part)
        path = Path(folder) / name
        if not self._has(path, part):
            columns, beside = self._compute(part)
            said = {**self._identity(part), **beside}
            table = pyarrow.table(columns).replace_schema_metadata({_KEY: json.dumps(said)})
            torn = path.with_name(f".{name}.{uuid.uuid4()}")
            pyarrow.parquet.write_table(table, torn)
            os.replace(torn, path)
        return name

    def file(self, part: int) -> str:
        """Returns the name of the file of a part."""
        return f"part-{part:05}-of-{self.parts:05}.parquet"

    def missing(self, folder: str | os.PathLike[str]) -> list[int]:
        """Returns the parts that are missing in the folder.

        Raises:
            ValueError: A file in the folder is a part of another study.
        """
        return [part for part in range(1, self.parts + 1) if not self._has(Path(folder) / self.file(part), part)]

    def _has(self, path: Path, part: int) -> bool:
        if not path.exists():
            return False
        said = _said(path)
        for key, value in self._identity(part).items():
            if said.get(key) != value:
                raise ValueError(f"{path} is a part of another study: its {key} is {said.get(key)!r}, not {value!r}")
        return True

    def _whole(self, folder: str | os.PathLike[str]) -> list[Path]:
        """Returns the files of all parts."""
        missing = self.missing(folder)
        if missing:
            named = ", ".join(str(part) for part in missing[:10]) + (" and more" if len(missing) > 10 else "")
            raise ValueError(f"{os.fspath(folder)}: {len(missing)} of {self.parts} parts are missing: {named}; run it again")
        return [Path(folder) / self.file(part) for part in range(1, self.parts + 1)]

    def _identity(self, part: int) -> dict[str, Any]:
        """Returns the inputs that determine a part, for JSON."""
        return {"palpate_version": __version__, "part": f"{part}/{self.parts}", **self._parameters()}

    def _parameters(self) -> dict[str, Any]:
        raise NotImplementedError

    def _compute(self, part: int) -> tuple[Mapping[str, Any], dict[str, Any]]:
        """Returns the columns of a part and its further metadata."""
        raise NotImplementedError


class MapStudy(Study):
    """Map in parts: `palpate.distributed.map` creates one.

    A part has the columns of the program's file and the cells of `palpate map --shard`.
    """

    def __init__(self, method: str | Sequence[str], arguments: dict[str, Any], parts: int) -> None:
        super().__init__(parts)
        cells = _palpate.map_check(method, arguments)
        if parts > cells:
            raise ValueError(f"parts is {parts}, but the map has {cells} cells")
        self.method = method
        self.arguments = arguments

    def merge(self, folder: str | os.PathLike[str]) -> Map:
        """Merges all parts to the result of `palpate.map`, except for the duration.

        Raises:
            ValueError: Parts are missing or belong to another study.
        """
        columns = _palpate.map_columns()
        parts = []
        for path in self._whole(folder):
            rows = zip(*(pyarrow.parquet.read_table(path)[name].to_pylist() for name in columns))
            lines = [",".join("" if cell is None else str(cell) for cell in row) for row in rows]
            metadata = [(key, value) for key, value in _said(path)["metadata"]]
            parts.append((str(path), (metadata, lines)))
        return Map._of_map(_palpate.map_of_parts(parts))

    def _parameters(self) -> dict[str, Any]:
        method = self.method if isinstance(self.method, str) else [*self.method]
        return {"study": "map", "method": method, "arguments": self.arguments}

    def _compute(self, part: int) -> tuple[Mapping[str, Any], dict[str, Any]]:
        metadata, lines = _palpate.map_part(self.method, self.arguments, part, self.parts)
        names = _palpate.map_columns()
        columns = dict(zip(names, zip(*(line.split(",") for line in lines))))
        return {name: _column(name, column) for name, column in columns.items()}, {"metadata": metadata}


class SuiteStudy(Study):
    """Random plants in parts: `palpate.distributed.suite` creates one.

    A part has a row for each plant, condition and column of methods.
    """

    def __init__(self, set: str, method: str | Sequence[str] | None, seed: int, plants: int, parts: int) -> None:
        super().__init__(parts)
        if parts > plants:
            raise ValueError(f"parts is {parts}, but there are {plants} plants")
        self.set, self.method, self.seed, self.plants = set, method, seed, plants
        self._conditions, self._columns = _palpate.suite_names(set, plants, method)

    def merge(self, folder: str | os.PathLike[str]) -> Report:
        """Merges all parts to the result of `palpate.suite`.

        Raises:
            ValueError: Parts are missing or belong to another study.
        """
        conditions = {name: place for place, name in enumerate(self._conditions)}
        columns = {name: place for place, name in enumerate(self._columns)}
        rows = []
        for path in self._whole(folder):
            for row in pyarrow.parquet.read_table(path).to_pylist():
                places = (row["plant"], conditions[row["condition"]], columns[row["column"]], row["redrawn"])
                numbers = tuple(row[name] for name in _NUMBERS)
                rows.append((places, numbers, tuple(row[name] for name in _COUNTS)))
        fields, text, figure = _palpate.suite_of_parts(self.set, self.seed, self.method, rows)
        return Report._of((fields, text), figure)

    def _parameters(self) -> dict[str, Any]:
        method = self.method if self.method is None or isinstance(self.method, str) else [*self.method]
        return {"study": "suite", "set": self.set, "method": method, "seed": self.seed, "plants": self.plants}

    def _compute(self, part: int) -> tuple[Mapping[str, Any], dict[str, Any]]:
        first, end = ((place * self.plants) // self.parts for place in (part - 1, part))
        rows = _palpate.suite_part(self.set, self.seed, first, end, self.method)
        plants, conditions, columns, redrawn = zip(*(places for places, _, _ in rows))
        table: dict[str, Any] = {
            "plant": plants,
            "condition": [self._conditions[place] for place in conditions],
            "column": [self._columns[place] for place in columns],
            "redrawn": redrawn,
        }
        table.update(zip(_NUMBERS, zip(*(numbers for _, numbers, _ in rows))))
        table.update(zip(_COUNTS, zip(*(counts for _, _, counts in rows))))
        return table, {}


_NUMBERS = (
    "ideal_error",
    "mean_force_error_percent",
    "force_rendering_error_percent",
    "error_over_bound",
    "peak_over_ideal_peak",
)
_COUNTS = ("diverged", "samples", "limited")


class TuneStudy(Study):
    """Tunings of a method on many scenes, a part for each: `palpate.distributed.tune` creates one.

    A part has the columns of the report's `curve`.
    """

    def __init__(self, scenes: Sequence[Scene], method: str | None, arguments: dict[str, Any]) -> None:
        super().__init__(len(scenes))
        self.scenes, self.method, self.arguments = list(scenes), method, arguments

    def merge(self, folder: str | os.PathLike[str]) -> list[Report]:
        """Returns the result of `palpate.tune` for each scene, in order.

        Raises:
            ValueError: Parts are missing or belong to another study.
        """
        said = [_said(path)["report"] for path in self._whole(folder)]
        return [Report._of((fields, text), figure) for fields, text, figure in said]

    def _identity(self, part: int) -> dict[str, Any]:
        return {**super()._identity(part), "scene": self.scenes[part - 1].to_toml()}

    def _parameters(self) -> dict[str, Any]:
        return {"study": "tune", "method": self.method, "arguments": self.arguments}

    def _compute(self, part: int) -> tuple[Mapping[str, Any], dict[str, Any]]:
        report = _tune(self.scenes[part - 1], self.method, **self.arguments)
        columns: dict[str, list[Any]] = {}
        for point in report["curve"]:
            for key, value in point.items():
                # A spread has three columns.
                for name, number in value.items() if isinstance(value, dict) else [("", value)]:
                    columns.setdefault(f"{key}_{name}" if name else key, []).append(number)
        return columns, {"report": (report.to_json(), str(report), report.to_svg())}


def map(method: str | Sequence[str] = "all", *, cells: int = 100, parts: int = 64, **arguments: Any) -> MapStudy:
    """Creates a map of the contacts that each method can render, in parts.

    Args:
        method: Name of a method, of `palpate.METHODS`, several names, or `"all"`.
        cells: Cells along each axis, 2 to 1000; a column of walls is added.
        parts: Number of parts, each a task. Use several for each worker to keep all workers busy until the end.
        arguments: Other arguments of `palpate.map`.

    Returns:
        The study: call `run`, then `merge`.

    Raises:
        ValueError: An argument is not allowed.
        TypeError: `palpate.map` does not have an argument.
    """
    known = {**(_map.__kwdefaults__ or {}), "cells": cells}
    for name in arguments:
        if name not in known:
            raise TypeError(f"palpate.map has no argument {name}; it has {', '.join(known)}")
    given = {name: plain(value) for name, value in {**known, **arguments}.items()}
    return MapStudy(method, given, plain(parts))


def suite(
    set: str = "paper",
    method: str | Sequence[str] | None = None,
    *,
    seed: int = 1,
    plants: int = 200,
    parts: int = 20,
) -> SuiteStudy:
    """Creates a study of methods on random plants, in parts.

    Args:
        parts: Number of parts, each a task; the numbers of plants per part differ by at most one.

    The other arguments are those of `palpate.suite`.

    Returns:
        The study: call `run`, then `merge`.

    Raises:
        ValueError: An argument is not allowed.
    """
    return SuiteStudy(set, method, plain(seed), plain(plants), plain(parts))


def tune(
    scenes: SceneLike | Iterable[SceneLike],
    method: str | None = None,
    *,
    steps: int = 400,
    least: str = "error",
) -> TuneStudy:
    """Creates a study of a method at several values of its damping on many scenes, a part for each scene.

    Args:
        scenes: Scenes, or paths of scene files. Workers get their text; files that the scenes name must exist there.

    The other arguments are those of `palpate.tune`.

    Returns:
        The study: call `run`, then `merge`.

    Raises:
        ValueError: There is no scene, or a scene is not valid.
        OSError: A file cannot be read.
    """
    several = [scene for scene in _scenes(scenes) if isinstance(scene, Scene)]
    return TuneStudy(several, method, {"steps": plain(steps), "least": least})


def _column(name: str, values: Sequence[str]) -> Any:
    """Converts the text of a column of a map: words, counts, or numbers; the `resting_swing` of walls is missing."""
    if name in ("plant", "method"):
        return pyarrow.array(values).dictionary_encode()
    if name in ("cell", "stable", "growing", "diverged"):
        return pyarrow.array([int(value) for value in values])
    return pyarrow.array([float(value) if value else None for value in values], pyarrow.float64())


def _said(path: Path) -> dict[str, Any]:
    """Reads palpate's metadata of a file."""
    metadata = pyarrow.parquet.read_schema(path).metadata or {}
    if _KEY not in metadata:
        raise ValueError(f"{path} is not a part of a study of palpate")
    said: dict[str, Any] = json.loads(metadata[_KEY])
    return said
