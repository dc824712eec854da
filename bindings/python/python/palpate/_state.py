"""States of renderers and worlds, to go back to and to branch from."""

from __future__ import annotations

from typing import Any, Mapping, NoReturn

import numpy as np


class State:
    """State of a `Renderer`, `Renderers` or `World` at its last sample, with its safety and its result.

    `set_state` of an object with the same parameters continues from it, bit by bit. A state does not change.
    """

    __slots__ = ("_held", "_kind", "_parameters")

    def __init__(self, kind: str, parameters: Mapping[str, Any], held: Any) -> None:
        self._kind, self._parameters, self._held = kind, dict(parameters), held

    def _for(self, kind: str, parameters: Mapping[str, Any]) -> Any:
        """Returns the content for an object of this kind and these parameters.

        Raises:
            ValueError: The state is of another kind or of other parameters.
        """
        if kind != self._kind:
            raise ValueError(f"the state is of a {self._kind}, not of a {kind}")
        for name in sorted({*self._parameters, *parameters}):
            one, other = self._parameters.get(name), parameters.get(name)
            if not np.array_equal(np.asarray(one, object), np.asarray(other, object)):
                raise ValueError(
                    f"the state is of a {kind} with {_short(name, one)}, but here {_short(name, other)}; it needs equal parameters"
                )
        return self._held

    def __reduce__(self) -> NoReturn:
        raise TypeError("a State belongs to its process and cannot be pickled")

    def __repr__(self) -> str:
        return f"<palpate.State of a {self._kind}>"


def _short(name: str, value: Any) -> str:
    text = repr(value)
    return f"{name}={text}" if len(text) <= 40 else f"another {name}"
