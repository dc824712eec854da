"""The examples of the documentation run as they stand."""

from __future__ import annotations

import inspect
import re
from importlib.util import find_spec
from pathlib import Path

import pytest

import palpate
import palpate.engines
from conftest import ROOT

PAGES = ["README.md", "docs/python.md", "docs/engines.md", "bindings/python/README.md"]


@pytest.mark.parametrize("page", PAGES)
def test_every_example_of_a_page_runs(root: Path, page: str) -> None:
    if page == "docs/engines.md":
        pytest.importorskip("mujoco", reason="pip install palpate[mujoco]")
    examples = re.findall(r"^```python\n(.*?)^```", (ROOT / page).read_text(), re.DOTALL | re.MULTILINE)
    assert examples
    names: dict[str, object] = {}
    for example in examples:
        # `bindings/python/test` reports platforms without wheels.
        if any(f" {engine}" in example and find_spec(engine) is None for engine in ("pybullet", "pydrake")):
            continue
        exec(compile(example, page, "exec"), names)


def test_every_public_name_says_what_it_is() -> None:
    for of, name in [(module, name) for module in (palpate, palpate.engines) for name in module.__all__]:
        value = getattr(of, name)
        if callable(value):
            assert (value.__doc__ or "").strip(), name
            for member in dir(value):
                own = getattr(value, member)
                if callable(own) and not member.startswith("_") and member not in dir(dict) + dir(tuple):
                    assert (own.__doc__ or "").strip(), f"{name}.{member}"


def test_every_argument_is_explained_with_its_unit() -> None:
    """Names of arguments stand in the text, and what is no pure number or word has a unit in brackets."""
    text = inspect.cleandoc(palpate.Renderer.__doc__ or "")
    pure = {"method", "side", "unilateral", "guard", "gain", "gain_deviation", "guard_learn_mass", "hold"}
    made = palpate.Renderer(stiffness=1.0, mass=1.0, period=1e-3, method="basic")
    for name in made.parameters:
        [line] = re.findall(rf"^    {name}: (.*(?:\n {{8,}}.*)*)", text, re.MULTILINE)
        assert name in pure or re.search(r"\[.+\]", line), line
