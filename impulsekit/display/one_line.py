"""A result in one line of plain text."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

__all__ = ["OneLine", "one_line"]

# A line longer than this wraps in a terminal several times over.
LONGEST_LINE = 160
LONGEST_VALUE = 60


class OneLine:
    """A dataclass whose ``repr`` is one line, however large its arrays are.

    The dataclass is declared with ``repr=False``, or its own ``__repr__`` would come first.
    """

    __slots__ = ()

    def __repr__(self) -> str:
        """The class and its fields; arrays by their shape."""
        named: dict[str, Any] = {
            field.name: getattr(self, field.name, None)
            for field in fields(self)  # type: ignore[arg-type]
            if field.repr
        }
        return one_line(type(self).__name__, **named)


def one_line(title: str, *first: str, **named: Any) -> str:
    """``title(first, ..., name=value, ...)`` in one line.

    Args:
        title: the class.
        first: words as they are, such as a status.
        named: values, each cut to what can be read.

    Example:
        >>> import numpy as np
        >>> one_line("Fit", "CONVERGED", names=("e", "mu"), covariance=np.eye(2))
        "Fit(CONVERGED, names=('e', 'mu'), covariance=array(2, 2))"
    """
    inside = ", ".join([*first, *(f"{name}={_short(value)}" for name, value in named.items())])
    return _cut(f"{title}({inside})", LONGEST_LINE)


def _short(value: Any) -> str:
    shape = getattr(value, "shape", None)
    if isinstance(shape, tuple):
        # A dask array has a shape before it has values.
        small = len(shape) == 1 and isinstance(shape[0], int) and 0 < shape[0] <= 3
        if shape and not (small and hasattr(value, "tolist")):
            return f"array({', '.join(map(str, shape))})"
        if shape:
            return "[" + ", ".join(_short(x) for x in value.tolist()) + "]"
    if isinstance(value, float) or type(value).__module__ == "numpy":
        try:
            return f"{float(value):.6g}"
        except (TypeError, ValueError):
            pass
    if isinstance(value, Mapping) and len(value) > 4:
        return f"{type(value).__name__} of {len(value)}"
    if isinstance(value, list | tuple) and len(value) > 4:
        return f"{type(value).__name__} of {len(value)}"
    return _cut(" ".join(repr(value).split()), LONGEST_VALUE)


def _cut(text: str, longest: int) -> str:
    return text if len(text) <= longest else text[: longest - 4].rstrip(" ,") + " ..." + text[-1]
