"""The methods and their settings, from the list that the Rust core has."""

from __future__ import annotations

from types import MappingProxyType
from typing import Mapping, NamedTuple

from . import _palpate


class Setting(NamedTuple):
    """What a method says of one of its settings."""

    name: str
    """The argument that gives it."""
    key: str
    """Its key in scene files and reports, with its unit at the end."""
    unit: str | None
    """Its unit, empty for a pure number; `None` for words and switches."""
    allowed: str
    """What it may be, in words."""
    help: str
    """What it is."""
    default: str
    """What is taken where it is not given, in words."""


class Method(NamedTuple):
    """What a method says of itself."""

    name: str
    """Its name, as files and reports spell it."""
    summary: str
    """What it is, in a few words."""
    settings: tuple[Setting, ...]
    """What can be set."""


def _methods() -> Mapping[str, Method]:
    return MappingProxyType(
        {
            said["name"]: Method(
                said["name"],
                said["summary"],
                tuple(Setting(**setting) for setting in said["settings"]),
            )
            for said in _palpate.methods()
        }
    )


METHODS: Mapping[str, Method] = _methods()
"""Every method by its name, in the order of tables and figures."""
