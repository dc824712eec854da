"""The program `palpate`, built from the same sources, to compare with."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[3]


class Program:
    """The program, run in the root of the repository."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def tried(self, *arguments: object, given: str | None = None) -> subprocess.CompletedProcess[str]:
        """What it did, whatever its exit code."""
        command = [str(self.path), *map(str, arguments)]
        return subprocess.run(command, cwd=ROOT, input=given, capture_output=True, text=True)

    def __call__(self, *arguments: object, given: str | None = None, code: int = 0) -> str:
        done = self.tried(*arguments, given=given)
        assert done.returncode == code, done.stderr
        return done.stdout

    def json(self, *arguments: object, code: int = 0) -> Any:
        return json.loads(self(*arguments, "--json", code=code))


@pytest.fixture(scope="session")
def program() -> Program:
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    path = Path(os.environ.get("PALPATE", target / "release/palpate"))
    if not path.exists():
        pytest.fail(f"{path} is not there: bindings/python/test builds it")
    return Program(path)


@pytest.fixture
def root(monkeypatch: pytest.MonkeyPatch) -> Path:
    """The root of the repository, where relative paths of scenes are found."""
    monkeypatch.chdir(ROOT)
    return ROOT


@pytest.fixture(scope="session")
def motion() -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and positions [m] of a committed recording of a hand."""
    table = np.genfromtxt(ROOT / "experiments/users/hand_intention.csv", delimiter=",", names=True)
    return np.array(table["t_s"]), np.array(table["position_m"])
