from os import PathLike
from pathlib import Path
from typing import Any, Final, Mapping

import numpy as np
from numpy.typing import NDArray
from typing_extensions import Self, disjoint_base

__all__ = [
    "Renderer",
    "Scene",
    "__version__",
    "columns",
    "compare",
    "from_toml",
    "ideal_columns",
    "methods",
    "read_scene",
    "render",
    "simulate",
    "to_toml",
]

from palpate._values import Ledger, Output

__version__: Final[str]

_Words = NDArray[np.uint64]
_Rendered = tuple[str, str, list[tuple[str, _Words]], _Words]

@disjoint_base
class Renderer:
    def __new__(
        cls,
        method: object,
        parameters: dict[str, Any],
        soft_start: float,
        settings_given: dict[str, Any],
    ) -> Self: ...
    @property
    def output(self) -> Output | None: ...
    @property
    def ledger(self) -> Ledger: ...
    @property
    def method(self) -> str: ...
    @property
    def method_parameters(self) -> dict[str, Any]: ...
    def step(self, position: float, elapsed: float | None = None, force: float | None = None) -> float: ...
    def report_sent(self, force_on_device: float) -> None: ...
    def teleport(self, position: float, velocity: float = 0.0) -> None: ...
    def reset(self) -> None: ...

@disjoint_base
class Scene:
    def __new__(cls, text: str, name: str | None, folder: str | PathLike[str]) -> Self: ...
    @property
    def title(self) -> str: ...
    @property
    def method(self) -> str: ...
    def parts(self) -> tuple[str, str | None, Path]: ...

def compare(scenes: list[Scene], method: object) -> tuple[str, str]: ...
def columns() -> tuple[list[str], list[str], list[list[str]]]: ...
def ideal_columns() -> list[str]: ...
def from_toml(text: str) -> dict[str, Any]: ...
def methods() -> list[dict[str, Any]]: ...
def read_scene(path: str | PathLike[str]) -> tuple[str, str, Path]: ...
def render(
    motion: tuple[NDArray[np.float64], NDArray[np.float64]],
    title: str,
    unit: str | None,
    method: object,
    parameters: dict[str, Any],
    settings_given: dict[str, Any],
) -> _Rendered: ...
def simulate(scene: Scene, method: object) -> _Rendered: ...
def to_toml(tables: Mapping[str, Any]) -> str: ...
