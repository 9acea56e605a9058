"""Numbers of a scene: checked once, kept as plain tuples and floats."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

import numpy as np

from ..errors import (
    InputError,
    RangeError,
    ShapeError,
    UnknownNameError,
    a_thing,
    nearest_names,
    quoted,
)
from ..errors.wording import one_of
from ..robot.arrays import not_negative, number, text

# Of a value and what it is called: the value as it is kept.
Check = Callable[[Any, str], Any]


def positive(value: Any, what: str) -> float:
    """Return a finite float above 0."""
    result = number(value, what)
    if not result > 0.0:
        raise RangeError.of(what, result, "above 0")
    return result


def between(low: float, high: float, allowed: str = "") -> Check:
    """Return a check of numbers; ``allowed``: the range in words, if not just its ends."""

    def checked(value: Any, what: str) -> float:
        result = number(value, what)
        if not low <= result <= high:
            raise RangeError.of(what, value, allowed or f"{low:g} to {high:g}")
        return result

    return checked


def optional(check: Check) -> Check:
    """Return the same check, which lets None pass."""
    return lambda value, what: None if value is None else check(value, what)


def keep(entry: Any, what: str, check: Check, *fields: str) -> None:
    """Keep fields of a frozen entry as a check gives them.

    Args:
        what: the entry in words, before the names of its fields.
        check: of a value and what it is called.
    """
    for field in fields:
        object.__setattr__(entry, field, check(getattr(entry, field), f"{what}: {field}"))


def keep_table(
    entry: Any, points: str, check: Check, allowed: str, least: float = -math.inf
) -> None:
    """Keep the rising ``points`` of a table and as many ``values`` as tuples of floats."""
    what = {field: f"{type(entry).__name__}: {field}" for field in (points, "values")}
    at, values = (listed(getattr(entry, field), what[field]) for field in (points, "values"))
    at = tuple(number(one, what[points]) for one in at)
    values = tuple(check(one, what["values"]) for one in values)
    if not at:
        raise ShapeError.of(what[points], (1,), (0,), "one or more")
    if len(at) != len(values):
        raise ShapeError.of(what["values"], (len(at),), (len(values),))
    if at[0] < least or any(b <= a for a, b in pairwise(at)):
        raise RangeError.of(what[points], at, allowed)
    object.__setattr__(entry, points, at)
    object.__setattr__(entry, "values", values)


def each(value: Any) -> Any:
    """Return the members of a list or an array, or a single value as the only one."""
    return value if is_list(value) else (value,)


def is_list(value: Any) -> bool:
    """Return whether there are several values; an array without an axis is a single one."""
    return isinstance(value, list | tuple) or (isinstance(value, np.ndarray) and value.ndim > 0)


def whole(value: Any, what: str, least: int) -> int:
    """Return a whole number, at least so much.

    Raises:
        RangeError: another number, or none.
    """
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
        raise RangeError.of(what, quoted(value), f"a whole number, {least} or more")
    return int(value)


def vector(value: Any, what: str) -> Vector:
    """Return three finite floats.

    Raises:
        ShapeError: not three entries.
        NotFiniteError, RangeError: as for ``number``.
    """
    if isinstance(value, np.ndarray):
        if value.shape != (3,):
            raise ShapeError.of(what, (3,), value.shape)
        entries: Sequence[Any] = value.tolist() if value.dtype.kind in "fiu" else list(value)
    elif isinstance(value, list | tuple):
        entries = value
    else:
        entries = _entries(value, what)
    if len(entries) != 3:
        raise ShapeError.of(what, (3,), (len(entries),))
    x, y, z = (number(entry, f"{what}[{i}]") for i, entry in enumerate(entries))
    return (x, y, z)


def _entries(value: Any, what: str) -> Sequence[Any]:
    """The entries of something that is neither a list nor an array."""
    if not isinstance(value, str | bytes | dict):
        try:
            return list(value)
        except TypeError:
            pass
    raise ShapeError(
        f"{what} must be three numbers, got {quoted(value)}", what=what, expected=(3,), got=()
    )


def listed(value: Any, what: str) -> tuple[Any, ...]:
    """Return the members of a list.

    Raises:
        InputError: it is none.
    """
    if isinstance(value, str):
        raise InputError(f"{what} must be a list of numbers, got {quoted(value)}")
    try:
        return tuple(value)
    except TypeError:
        raise InputError(f"{what} must be a list of numbers, got {a_thing(value)}") from None


def choice(*allowed: str, separator: str = ", ") -> Check:
    """Return a check of words."""

    def checked(value: Any, what: str) -> str:
        if not isinstance(value, str) or value not in allowed:
            words = separator.join(f'"{one}"' for one in allowed)
            nearest = nearest_names(value, allowed) if isinstance(value, str) else ()
            hint = f"; did you mean {one_of(nearest)}?" if nearest else ""
            raise UnknownNameError(
                f"{what} must be {words}, got {quoted(value)}{hint}",
                kind=what,
                name=value,
                nearest=nearest,
                known=allowed,
            )
        return value

    return checked


def function(value: Any, what: str) -> Any:
    """Return a function."""
    if not callable(value):
        raise InputError(f"{what} must be a function, got {a_thing(value)}")
    return value


Name: TypeAlias = Annotated[str, text]
OfTime: TypeAlias = Annotated[Callable[[float], Any], function]
OfState: TypeAlias = Annotated[Callable[[Any], Any], function]
OfMotion: TypeAlias = Annotated[Callable[[Any, Any], Any], function]
Number: TypeAlias = Annotated[float, number]
NotNegative: TypeAlias = Annotated[float, not_negative]
Positive: TypeAlias = Annotated[float, positive]
Axes: TypeAlias = Annotated[str, choice("world", "local", separator=" or ")]
if TYPE_CHECKING:
    # What a user may give; what is kept is always a tuple.
    Vector = Sequence[float] | np.ndarray
    Numbers = float | Vector
    Velocity = Numbers | Literal["kept"] | Callable[[float], Any]
    Names = str | Sequence[str]
else:
    Vector = Annotated[tuple[float, float, float], vector]
    # Checked by the entries themselves, which say in one sentence what is wrong.
    Numbers = Velocity = Names = Any
