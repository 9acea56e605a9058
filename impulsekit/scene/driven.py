"""Entries driven in time: a joint along a given motion, velocities as functions of time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..errors import RangeError
from ..errors.calls import public
from .constraints import JointLock
from .entry import InJoint
from .functions import call, numbers_from
from .numbers import Name, OfTime

# A size to measure differences by where all values are 0.
LEAST_SIZE = 1e-6

# Times at which rates are compared with differences [s], and the steps tried for these.
LOOKS = (0.0, 0.0137, 0.131, 0.71)
STEPS = (1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1)
# A longer step is right where it differs by no more than this many times the error of a shorter.
AGREES = 10.0
# Central differences of order 8: of the first derivative, by how many steps away, and the next
# order below.
_EIGHTH = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])
_SIXTH = np.array([3 / 4, -3 / 20, 1 / 60])
# A rate that is off by more than this part of itself and of its largest is a mistake.
RATE_MISTAKEN = 1e-5
# How many times as far off a second derivative by differences is.
AGAIN_DERIVED = 10.0


@public
@dataclass(frozen=True)
class Driven(InJoint):
    """A joint that follows a given motion: a shaker, a cam shaft, a conveyor's belt.

    Whatever it takes to move the joint so is its reaction: in ``simulate`` the force that a motor
    would give, in an impact its impulse, for the joint keeps its velocity. What a contact strikes
    moves as well where it is ``against`` a driven link: a vibrating table, a belt that carries.

    Attributes:
        joint: a joint with one degree of freedom.
        position: function of time [s] that gives its coordinate [rad, m]. It must be smooth, and
            is also called a little before 0 and past the end where rates are not given. The motion
            must begin there: q of the joint is position(0).
        velocity, acceleration: functions for its rates; None for differences of ``position``,
            which are right to some 1e-9 of it where nothing in it is faster than a millisecond.
        name: its name in results; by default its index in the scene.

    Raises:
        InputError, CallbackError, ShapeError, NotFiniteError: a function that cannot be used.
        RangeError: a rate that is not the derivative of what it belongs to.

    Example:
        >>> import math
        >>> table = Driven("table", lambda t: 0.01 * math.sin(60 * t))
        >>> round(table.rate(0.0), 9)
        0.6
    """

    section = "constraints"

    joint: Name
    position: OfTime
    velocity: OfTime | None = None
    acceleration: OfTime | None = None
    name: Name | None = None

    def _check(self, what: str) -> None:
        rates = Rates(self.position, f"{what}: position", 1)
        for field, order in (("velocity", 1), ("acceleration", 2)):
            given = getattr(self, field)
            if given is not None:
                _check_rate(given, rates, order, f"{what}: {field}")
        object.__setattr__(self, "_rates", rates)

    def place(self, t: float) -> float:
        """Return the coordinate at a time [s]."""
        what = f'Driven of "{self.joint}": position at t = {t:g}'
        return float(numbers_from(self.position, what, 1, t)[0])

    def rate(self, t: float, order: int = 1) -> float:
        """Return its velocity at a time [s], or with order 2 its acceleration."""
        given = self.velocity if order == 1 else self.acceleration
        if given is not None:
            what = f'Driven of "{self.joint}": rate at t = {t:g}'
            return float(numbers_from(given, what, 1, t)[0])
        rates: Rates = self._rates  # type: ignore[attr-defined]
        return float(rates(t, order)[0])


class Rates:
    """Derivatives in time of a function that a user gave, by central differences.

    The step is chosen once: that at which two orders differ least.
    """

    def __init__(self, function: Callable[[float], Any], what: str, size: int) -> None:
        self._function, self._what, self._size = function, what, size
        self._step = STEPS[0]
        best, error = self._differences(STEPS[0])
        for h in STEPS[1:]:
            found, own = self._differences(h)
            # A step as long as a period would see nothing of it: it has to agree with shorter ones.
            if not np.abs(found - best).max() <= AGREES * error:
                break
            if own < error:
                self._step, best, error = h, found, own

    def __call__(self, t: float, order: int = 1) -> np.ndarray:
        """(size,) the derivative of this order, 1 or 2."""
        h, values = self._step, self._values
        sides = [(values(t + k * h), values(t - k * h)) for k in range(1, 5)]
        if order == 1:
            differences = [right - left for right, left in sides]
            return sum(w * d for w, d in zip(_EIGHTH, differences, strict=True)) / h
        middle = values(t)
        weights = 2.0 * _EIGHTH / np.arange(1, 5)
        sums = [right + left - 2.0 * middle for right, left in sides]
        return sum(w * s for w, s in zip(weights, sums, strict=True)) / h**2

    def _values(self, t: float) -> np.ndarray:
        return numbers_from(self._function, f"{self._what} at t = {t:g}", self._size, t)

    def _differences(self, h: float) -> tuple[np.ndarray, float]:
        """The first derivative at some times with a step h, and by how much two orders differ."""
        values = self._values
        differences = [
            np.array([values(t + k * h) - values(t - k * h) for t in LOOKS]) for k in range(1, 5)
        ]
        fine = sum(w * d for w, d in zip(_EIGHTH, differences, strict=True)) / h
        coarse = sum(w * d for w, d in zip(_SIXTH, differences[:3], strict=True)) / h
        size = max(float(np.abs(values(t)).max()) for t in LOOKS)
        rounding = 2.0 * np.finfo(float).eps * size / h
        return np.asarray(fine), float(np.abs(fine - coarse).max() + rounding)


def _check_rate(given: Callable[[float], Any], rates: Rates, order: int, what: str) -> None:
    given_rates = [float(numbers_from(given, f"{what} at t = {t:g}", 1, t)[0]) for t in LOOKS]
    found = [float(rates(t, order)[0]) for t in LOOKS]
    largest = max(map(abs, (*found, LEAST_SIZE)))
    for t, one, other in zip(LOOKS, given_rates, found, strict=True):
        if abs(one - other) > RATE_MISTAKEN * largest * (1.0 if order == 1 else AGAIN_DERIVED):
            raise RangeError.of(
                f"{what} at t = {t:g} s", one, f"{other:.9g}, the derivative of position"
            )


def is_driven(constraint: Any) -> bool:
    """Return whether a constraint prescribes something that changes with time."""
    return isinstance(constraint, Driven) or callable(getattr(constraint, "velocity", None))


def constraint_at(entry: Any, name: str, t: float) -> Any:
    """Return a constraint with the velocity that it prescribes at a time [s]."""
    if isinstance(entry, Driven):
        return JointLock(entry.joint, velocity=entry.rate(t), name=name)
    velocity = entry.velocity
    if callable(velocity):
        given = np.atleast_1d(velocity_at(velocity, name, t))
        value = float(given[0]) if given.size == 1 else tuple(given.tolist())
        return replace(entry, velocity=value, name=name)
    return entry


def at_rest(entry: Any) -> Any:
    """Return a constraint that lets nothing move."""
    if isinstance(entry, Driven):
        return JointLock(entry.joint, name=entry.name)
    return replace(entry, velocity=0.0)


def velocity_at(velocity: Callable[[float], Any], name: str, t: float) -> Any:
    """Return the velocity of a constraint by its function: one number or several."""
    what = f"{name}: velocity at t = {t:g}"
    size = np.size(call(velocity, what, t))
    return numbers_from(velocity, what, max(size, 1), t)
