"""Arrays that compiled code does not count the references of.

numba counts who holds an array, atomically, each time a field of a named tuple or a row is taken:
in code that works on tuples of arrays that is most of what it does. What a function is given
outlives the call, so that nobody has to count. Two marks say so:

- ``borrowing`` for a function that makes no arrays, returns none, writes none into arrays (numbers
  one by one, as ``dense.put`` does), and calls none that returns any: nothing in it is counted,
  nor in what numba compiles for it;
- ``borrowed`` for single arguments, where a function makes arrays (which have to be counted) or is
  an ``entry``.

What is not counted must not be returned: who gets it would count it down.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from .compiled import compiled, tell_numba

__all__ = ["UNCOUNTED", "borrowed", "borrowing"]

T = TypeVar("T")
F = TypeVar("F", bound=Callable[..., Any])

# The option of the compiler.
UNCOUNTED: dict[str, Any] = {"_nrt": False}


def borrowing(function: F) -> F:
    """As ``compiled``, for a function that makes no arrays: it counts no references."""
    return compiled(function, **UNCOUNTED)


def borrowed(value: T) -> T:
    """The same arrays, or (named) tuples of arrays and numbers, uncounted in compiled code."""
    return value


def _tell() -> None:
    from numba import types
    from numba.core.registry import cpu_target
    from numba.core.typing.templates import AbstractTemplate

    class Template(AbstractTemplate):
        key = borrowed

        def generic(self, args: Any, kws: Any) -> Any:
            (value,) = args
            return value(value)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _uncounted(context, builder, sig.args[0], args[0])

    cpu_target.typing_context.insert_global(borrowed, types.Function(Template))
    cpu_target.target_context.insert_func_defn([(lower, borrowed, (types.Any,))])


def _uncounted(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """The value without the owners of its arrays."""
    from numba import types
    from numba.core import cgutils

    if isinstance(kind, types.Array):
        array = context.make_array(kind)(context, builder, value=value)
        array.meminfo = cgutils.get_null_value(array.meminfo.type)
        array.parent = cgutils.get_null_value(array.parent.type)
        return array._getvalue()
    if isinstance(kind, types.BaseTuple):
        parts: Any = kind
        for i, part in enumerate(parts.types):
            own = builder.extract_value(value, i)
            value = builder.insert_value(value, _uncounted(context, builder, part, own), i)
    return value


tell_numba(_tell)
