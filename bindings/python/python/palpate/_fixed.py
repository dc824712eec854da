"""Read-only parameters, and warnings about implausible values."""

from __future__ import annotations

import warnings
from typing import Any, ClassVar, Dict, Mapping

from . import _palpate


class Fixed:
    """Object with read-only parameters: an assignment raises an error instead of being ignored."""

    __slots__ = ()
    _settable: ClassVar[frozenset[str]] = frozenset()
    """Attributes that may be set."""
    _way: ClassVar[str] = "make another one"
    """Advice in the message of a rejected assignment."""

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_") and name not in self._settable:
            kinds = type(self).__mro__
            ours = [kind for kind in kinds if _is_ours(kind)]
            theirs = [kind for kind in kinds if not _is_ours(kind) and kind is not object]
            is_theirs = any(name in vars(kind) or name in vars(kind).get("__annotations__", {}) for kind in theirs)
            is_begun = any(name in vars(kind).get("__annotations__", {}) for kind in ours) and not hasattr(self, name)
            is_parameter = any(name in _parameters(kind) for kind in ours)
            if not is_theirs and not is_begun and (is_parameter or type(self) in ours):
                what = "a parameter, which cannot be set on" if is_parameter else "not a settable attribute of"
                raise AttributeError(f"{name} is {what} a {type(self).__name__}: {self._way}")
        super().__setattr__(name, value)

    def _found(self, **values: Any) -> None:
        """Sets attributes that the object determines itself."""
        for name, value in values.items():
            super().__setattr__(name, value)


class FixedParameters(Dict[str, Any]):
    """Read-only parameters of an object. They can be read, copied and pickled like a dictionary."""

    _way: str

    def __init__(self, parameters: Mapping[str, Any], way: str) -> None:
        super().__init__(parameters)
        self._way = way

    def _refuse(self, *_: Any, **__: Any) -> Any:
        raise TypeError(f"these parameters are read-only and change nothing: {self._way}")

    __setitem__ = __delitem__ = __ior__ = _refuse
    clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        return (dict, (dict(self),))

    def copy(self) -> dict[str, Any]:
        """Returns an independent dictionary, which may be changed."""
        return dict(self)


def _is_ours(kind: type) -> bool:
    return kind.__module__.partition(".")[0] in ("palpate", "_palpate")


def _parameters(kind: type) -> tuple[str, ...]:
    """Returns the names of the constructor arguments of a class."""
    made: list[str] = []
    for function in (vars(kind).get("__new__"), vars(kind).get("__init__")):
        code = getattr(getattr(function, "__func__", function), "__code__", None)
        if code is not None:
            made += code.co_varnames[1 : code.co_argcount + code.co_kwonlyargcount]
    return tuple(made)


def question_lag(lag: Any, name: str = "lag", stacklevel: int = 3) -> None:
    """Warns about a lag that is implausible for a haptic device: its unit is probably milliseconds."""
    if isinstance(lag, (int, float)):
        question = _palpate.lag_question(name, f"{name}=0.001", lag)
        if question is not None:
            warnings.warn(question, stacklevel=stacklevel)


def question_period(period: Any, name: str = "period", stacklevel: int = 3) -> None:
    """Warns about a period that is implausible for a haptic loop: its unit is probably milliseconds."""
    if isinstance(period, (int, float)):
        question = _palpate.period_question(name, f"{name}=0.001", period)
        if question is not None:
            warnings.warn(question, stacklevel=stacklevel)
