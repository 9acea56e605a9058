"""Coefficients of restitution: a number, or one that falls with the approach speed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..errors import InputError, RangeError, quoted
from .functions import numbers_from
from .numbers import keep, not_negative, number
from .speed_table import SpeedTable

__all__ = ["Restitution", "RestitutionTable", "checked_restitution", "restitution_at"]


@dataclass(frozen=True)
class Restitution:
    """A coefficient that is zero below a capture speed.

    Attributes:
        value: e above the capture speed, 0 to 1.
        capture_speed: approach speed [m/s, rad/s for a stop] below which e is zero.

    Raises:
        RangeError, NotFiniteError.

    Example:
        >>> bounce = Restitution(0.8, capture_speed=0.01)
        >>> bounce(1.0), bounce(0.005)
        (0.8, 0.0)
    """

    value: float
    capture_speed: float = 0.0

    def __post_init__(self) -> None:
        keep(self, "Restitution", _coefficient, "value")
        keep(self, "Restitution", not_negative, "capture_speed")

    def __call__(self, approach_speed: float) -> float:
        """e at an approach speed."""
        return self.value if approach_speed >= self.capture_speed else 0.0


@dataclass(frozen=True)
class RestitutionTable(SpeedTable):
    """A coefficient by approach speed, linear between the points, constant beyond them.

    Attributes:
        speeds: approach speeds [m/s, rad/s for a stop], rising.
        values: e at each, 0 to 1.

    Raises:
        ShapeError, RangeError, NotFiniteError.

    Example:
        >>> RestitutionTable([0.0, 1.0], [1.0, 0.5])(0.5)
        0.75
    """

    @staticmethod
    def _coefficient(value: Any, what: str) -> float:
        return _coefficient(value, what)


def checked_restitution(value: Any, what: str) -> float | Callable[[float], float]:
    """A number in [0, 1], or something that gives one for an approach speed.

    Raises:
        RangeError, NotFiniteError, InputError.
    """
    if callable(value):
        return value
    if isinstance(value, str | bytes | dict | list | tuple):
        raise InputError(
            f"{what} must be a number, a Restitution, a RestitutionTable or a function of the "
            f"approach speed, got {quoted(value)}"
        )
    return _coefficient(value, what)


def restitution_at(
    value: float | Callable[[float], float] | str, approach_speed: float, what: str
) -> float:
    """e at an approach speed; what a user's own function gives is checked.

    Raises:
        RangeError, NotFiniteError, ShapeError, CallbackError: the function raised, or gave
            something else than 0 to 1.
        InputError: "material", outside of a scene with materials.
    """
    if isinstance(value, str):
        raise InputError(f'{what}: "{value}" needs the Scene(materials=[...]) that has its pair')
    if not callable(value):
        return value
    if type(value) in (Restitution, RestitutionTable):
        return value(approach_speed)
    where = f"{what} at {approach_speed:g} m/s"
    try:
        return _coefficient(numbers_from(value, where, 1, approach_speed)[0], where)
    except RangeError as error:
        error.from_function = True
        raise


def _coefficient(value: Any, what: str) -> float:
    result = number(value, what)
    if not 0.0 <= result <= 1.0:
        raise RangeError.of(what, result, "0 to 1")
    return result
