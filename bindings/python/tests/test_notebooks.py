"""The notebooks of the documentation run as they stand, and give the outputs that stand in them.

    PALPATE_WRITE_NOTEBOOKS=1 bindings/python/test python3 tests/test_notebooks.py

writes the outputs anew.
"""

from __future__ import annotations

import ast
import contextlib
import io
import json
import os
from pathlib import Path
from typing import Any

import pytest

from conftest import ROOT

NOTEBOOKS = sorted((ROOT / "docs/notebooks").glob("*.ipynb"))


def run(source: str, names: dict[str, Any], place: str) -> list[dict[str, Any]]:
    """Runs a cell, and gives its outputs: what it prints, and its last expression as a notebook shows it."""
    parsed = ast.parse(source, place)
    last = parsed.body.pop() if parsed.body and isinstance(parsed.body[-1], ast.Expr) else None
    printed, value = io.StringIO(), None
    with contextlib.redirect_stdout(printed):
        exec(compile(parsed, place, "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), place, "eval"), names)
    outputs: list[dict[str, Any]] = []
    if printed.getvalue():
        outputs.append({"name": "stdout", "output_type": "stream", "text": lines(printed.getvalue())})
    if value is not None:
        drawn = getattr(value, "_repr_svg_", lambda: None)()
        # The text of a report may contain the computing time.
        data = {"text/plain": lines(repr(value))} if drawn is None else {"image/svg+xml": lines(drawn)}
        outputs.append({"data": data, "execution_count": None, "metadata": {}, "output_type": "execute_result"})
    return outputs


def lines(text: str) -> list[str]:
    return text.splitlines(keepends=True)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_gives_the_outputs_that_stand_in_it(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    notebook = json.loads(path.read_text(encoding="utf-8"))
    if "mujoco" in path.stem:
        pytest.importorskip("mujoco", reason="pip install palpate[mujoco]")
    # Like Jupyter, run a notebook in its own folder.
    monkeypatch.chdir(path.parent)
    names: dict[str, Any] = {"__name__": "__main__"}
    shown = 0
    for number, cell in enumerate(notebook["cells"]):
        if cell["cell_type"] != "code":
            continue
        found = run("".join(cell["source"]), names, f"{path.name}, cell {number}")
        shown += len(found)
        if os.environ.get("PALPATE_WRITE_NOTEBOOKS"):
            cell["outputs"] = found
        assert found == cell["outputs"], f"{path.name}, cell {number}"
    assert shown > 0
    path_text = json.dumps(notebook, indent=1, ensure_ascii=False) + "\n"
    if os.environ.get("PALPATE_WRITE_NOTEBOOKS"):
        path.write_text(path_text, encoding="utf-8")


def test_notebooks_exist_and_are_small() -> None:
    assert len(NOTEBOOKS) >= 5
    # Keep the files small enough to review.
    assert all(path.stat().st_size < 400_000 for path in NOTEBOOKS)
