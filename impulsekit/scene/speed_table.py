"""A coefficient that depends on a speed, by a table."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from ..errors import RangeError, ShapeError
from .numbers import listed, number

__all__ = ["SpeedTable"]


@dataclass(frozen=True)
class SpeedTable:
    """Values by speed, linear between the points, constant beyond them.

    Subclasses check a value in ``_coefficient``.

    Attributes:
        speeds: (n,) [m/s, rad/s], 0 or more, rising.
        values: (n,) the coefficient at each speed.

    Raises:
        InputError: not a sequence. NotFiniteError: not finite numbers.
        ShapeError: empty, or not as many values as speeds.
        RangeError: speeds that are negative or do not rise, a value that is not allowed.
    """

    speeds: tuple[float, ...]
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        name = type(self).__name__
        of_speeds, of_values = f"{name}: speeds", f"{name}: values"
        speeds = tuple(number(speed, of_speeds) for speed in listed(self.speeds, of_speeds))
        values = tuple(self._coefficient(one, of_values) for one in listed(self.values, of_values))
        if not speeds:
            raise ShapeError.of(of_speeds, (1,), (0,), "one or more")
        if len(speeds) != len(values):
            raise ShapeError.of(of_values, (len(speeds),), (len(values),))
        if speeds[0] < 0.0 or any(b <= a for a, b in pairwise(speeds)):
            raise RangeError.of(of_speeds, speeds, "0 or more, each above the last")
        object.__setattr__(self, "speeds", speeds)
        object.__setattr__(self, "values", values)

    def __call__(self, speed: float) -> float:
        """The coefficient at a speed [m/s, rad/s]."""
        return float(np.interp(speed, self.speeds, self.values))

    @staticmethod
    def _coefficient(value: Any, what: str) -> float:
        return number(value, what)
