"""What may be set on an object after it was made, and values that are likely to be mistakes."""

from __future__ import annotations

import warnings
from typing import Any, ClassVar, Dict, Mapping

from . import _palpate


class Fixed:
    """An object whose parameters are those that it was made with: to set one is an error and not silence."""

    __slots__ = ()
    _settable: ClassVar[frozenset[str]] = frozenset()
    """Attributes that may be set."""
    _way: ClassVar[str] = "make another one"
    """What to do in place of it."""

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_") and name not in self._settable:
            kinds = type(self).__mro__
            ours = [kind for kind in kinds if _is_ours(kind)]
            theirs = [kind for kind in kinds if not _is_ours(kind) and kind is not object]
            is_theirs = any(name in vars(kind) or name in vars(kind).get("__annotations__", {}) for kind in theirs)
            is_begun = any(name in vars(kind).get("__annotations__", {}) for kind in ours) and not hasattr(self, name)
            is_parameter = any(name in _parameters(kind) for kind in ours)
            if not is_theirs and not is_begun and (is_parameter or type(self) in ours):
                what = "a parameter, which cannot be set on" if is_parameter else "nothing that can be set on"
                raise AttributeError(f"{name} is {what} a {type(self).__name__}: {self._way}")
        super().__setattr__(name, value)

    def _found(self, **values: Any) -> None:
        """Sets attributes that the object itself has found out."""
        for name, value in values.items():
            super().__setattr__(name, value)


class FixedParameters(Dict[str, Any]):
    """Parameters that something was made with. They are read, copied and pickled as a dictionary; to change one is an error."""

    _way: str

    def __init__(self, parameters: Mapping[str, Any], way: str) -> None:
        super().__init__(parameters)
        self._way = way

    def _refuse(self, *_: Any, **__: Any) -> Any:
        raise TypeError(f"these parameters are those that it was made with and change nothing: {self._way}")

    __setitem__ = __delitem__ = __ior__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        return (dict, (dict(self),))

    def copy(self) -> dict[str, Any]:
        """A dictionary of its own, which may be changed."""
        return dict(self)


def _is_ours(kind: type) -> bool:
    return kind.__module__.partition(".")[0] in ("palpate", "_palpate")


def _parameters(kind: type) -> tuple[str, ...]:
    """Names of the arguments by which an object of this kind is made."""
    made: list[str] = []
    for function in (vars(kind).get("__new__"), vars(kind).get("__init__")):
        code = getattr(getattr(function, "__func__", function), "__code__", None)
        if code is not None:
            made += code.co_varnames[1 : code.co_argcount + code.co_kwonlyargcount]
    return tuple(made)


def question_period(period: Any, name: str = "period", stacklevel: int = 3) -> None:
    """Warns of a period that no haptic loop has: its unit is likely to be milliseconds."""
    if isinstance(period, (int, float)):
        question = _palpate.period_question(name, f"{name}=0.001", period)
        if question is not None:
            warnings.warn(question, stacklevel=stacklevel)
