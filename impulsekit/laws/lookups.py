"""The types of operations, looked up once for each kind of arguments.

numba tries all that is known of ``+``, of ``a[i]`` or of ``sqrt`` one after the other at each
place where one stands, and writes a message for each that does not fit. The same operation on
the same types has the same signature everywhere.
"""

from __future__ import annotations

import functools
from typing import Any

from numba.core import types
from numba.core.compiler import Flags

__all__ = ["Lookups", "QuickFlags"]

# Types of which an operation's signature depends on nothing else.
_PLAIN = (types.Number, types.Boolean, types.Array, types.SliceType, types.NoneType)


class QuickFlags(Flags):
    """numba's flags, compared by those that were set before all others are looked at."""

    __slots__ = ()

    def __hash__(self) -> int:
        """As any flags: those that are equal to them have the same."""
        return _hash()

    def __eq__(self, other: object) -> bool:
        """Whether all flags are the same."""
        if isinstance(other, QuickFlags) and self._values == other._values:
            return True
        return bool(super().__eq__(other))


@functools.cache
def _hash() -> int:
    return hash(Flags())


class Lookups:
    """numba's typing context, with a memory.

    Args:
        context: numba's.
        found: signatures by operation and types of arguments; kept by the caller.
    """

    def __init__(self, context: Any, found: dict[Any, Any]) -> None:
        self._context, self._found = context, found

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    def resolve_function_type(self, func: Any, args: Any, kws: Any) -> Any:
        """The signature of a call; None where there is none."""
        if kws or (isinstance(func, types.Type) and not isinstance(func, types.Function)):
            return self._context.resolve_function_type(func, args, kws)
        return self._remembered(func, args, self._context.resolve_function_type, func, args, kws)

    def resolve_setitem(self, target: Any, index: Any, value: Any) -> Any:
        """The signature of ``target[index] = value``."""
        args = target, index, value
        return self._remembered("setitem", args, self._context.resolve_setitem, *args)

    def _remembered(self, what: Any, args: Any, look_up: Any, *given: Any) -> Any:
        if not all(map(_is_plain, args)):
            return look_up(*given)
        key = what, tuple(args)
        found = self._found.get(key)
        if found is None:
            found = look_up(*given)
            if found is not None:
                self._found[key] = found
        return found


def _is_plain(kind: Any) -> bool:
    if isinstance(kind, types.BaseTuple):
        parts: Any = kind
        return all(map(_is_plain, parts))
    return isinstance(kind, _PLAIN)
