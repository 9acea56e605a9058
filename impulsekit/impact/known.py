"""Δv of known impulses on a tree: M Δv = I, by articulated inertias in O(n).

Trees that hang on the world side by side do not feel each other: what no blow reaches is left
out. ``contact_problem`` has the same equations as matrices on Pinocchio.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from .._core import KnownImpulses as CoreImpulses
from .flat.scene import flat_of

if TYPE_CHECKING:
    from ..scene import Scene

__all__ = ["KnownImpulses"]

# Impulses of other sizes are brought near 1: their products would leave the doubles.
_SMALLEST, _LARGEST = 1e-150, 1e150


class KnownImpulses:
    """The known impulses of a scene of impulses alone, and Δv of them at one q after the other."""

    def __init__(self, scene: Scene) -> None:
        flat = flat_of(scene)
        self._core, self._order = CoreImpulses(flat.core), flat.order
        self._scaled, self._unit = _scaled(flat.impulses)

    def velocity_jump(self, q: np.ndarray, numbers: np.ndarray | None = None) -> np.ndarray:
        """(nv,) Δv of the robot at q (nq,); ``numbers`` (columns,) of the impulses, if others."""
        if numbers is None:
            scaled, unit = self._scaled, self._unit
        else:
            scaled, unit = _scaled(numbers[self._order])
        dv = self._core.velocity_jump(q, scaled)
        return dv if unit == 1.0 else dv / unit


def _scaled(numbers: np.ndarray) -> tuple[np.ndarray, float]:
    """The numbers of the impulses, and the power of two that brings them near 1 if they need it."""
    largest = float(np.abs(numbers).max(initial=0.0))
    if not largest or _SMALLEST < largest < _LARGEST:
        return numbers, 1.0
    unit = math.ldexp(1.0, min(-math.frexp(largest)[1], 1000))
    return unit * numbers, unit
