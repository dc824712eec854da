"""Methods and their settings, from the list of the Rust core."""

from __future__ import annotations

from types import MappingProxyType
from typing import Mapping, NamedTuple

from . import _palpate


class Setting(NamedTuple):
    """Setting of a method."""

    name: str
    """Name of its argument."""
    key: str
    """Key in scene files and reports, with the unit at the end."""
    unit: str | None
    """Unit, empty for a pure number; `None` for words and switches."""
    allowed: str
    """Allowed values, in words."""
    help: str
    """Meaning."""
    default: str
    """Default value, in words."""


class Method(NamedTuple):
    """Description of a method."""

    name: str
    """Name in files and reports."""
    summary: str
    """One-line description."""
    settings: tuple[Setting, ...]
    """Settings."""


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
"""All methods by name, in the order of tables and figures."""
