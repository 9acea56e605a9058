"""Numbers of a scene: checked once, kept as plain tuples and floats."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, NotFiniteError, RangeError, ShapeError, quoted

__all__ = ["AXES", "LARGEST", "Vector", "axes_name", "number", "text", "vector"]

if TYPE_CHECKING:
    # What a user may give; what is kept is always a tuple.
    Vector = Sequence[float] | np.ndarray
else:
    Vector = tuple[float, float, float]
AXES = ("world", "local")

# Beyond this the products of a solve would overflow.
LARGEST = 1e100


def number(value: Any, what: str) -> float:
    """A finite float.

    Raises:
        NotFiniteError: not a number, NaN or infinite.
        RangeError: beyond ±1e100.
    """
    try:
        result = float(value)
    except (TypeError, ValueError, OverflowError):
        raise NotFiniteError(
            f"{what} is {quoted(value)}, a number is wanted", what=what, where=what
        ) from None
    if not math.isfinite(result):
        raise NotFiniteError(
            f"{what} is {result}, a finite number is wanted", what=what, where=what
        )
    if abs(result) > LARGEST:
        raise RangeError.of(what, result, f"-{LARGEST:g} to {LARGEST:g}")
    return result


def vector(value: Any, what: str) -> Vector:
    """Three finite floats.

    Raises:
        ShapeError: not three entries.
        NotFiniteError, RangeError: as for ``number``.
    """
    if isinstance(value, np.ndarray):
        if value.shape != (3,):
            raise ShapeError.of(what, (3,), value.shape)
        entries: Sequence[Any] = value.tolist()
    else:
        try:
            entries = list(value)
        except TypeError:
            raise ShapeError.of(what, (3,), (), "three numbers are wanted") from None
    if len(entries) != 3:
        raise ShapeError.of(what, (3,), (len(entries),))
    x, y, z = (number(entry, f"{what}[{i}]") for i, entry in enumerate(entries))
    return (x, y, z)


def axes_name(value: Any, what: str) -> str:
    """ "world" or "local"."""
    if value not in AXES:
        raise RangeError.of(what, quoted(value), '"world" or "local"')
    return str(value)


def text(value: Any, what: str) -> str:
    """A name: text that is not empty."""
    if not isinstance(value, str) or not value:
        raise InputError(f"{what} is {quoted(value)}, a name is wanted")
    return value
