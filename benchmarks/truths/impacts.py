"""Impacts with known impulses, bilateral rows and Coulomb contacts, to 50 digits.

Newton goes from the answer that was found to the solution of the ``equations`` beside it;
modes are seen anew at each step (Alart & Curnier 1991). That solution satisfies the law to the
last digit, whatever it started from, so an answer that is not near any solution is far from
this one as well.
"""

from __future__ import annotations

import numpy as np

from impulsekit.reference.arithmetic import Array
from impulsekit.scene import Scene

from .condition import conditioned
from .elimination import generalized_inverse
from .equations import SEPARATED, SLIDING, Coefficients, Equations
from .found import Exact, Found
from .mechanics import SceneMechanics
from .numbers import EPS
from .residuals import Residuals, residuals_of

MOST_STEPS = 60


class Impacts:
    """The truth of a scene under Newton's law with slip at the end, or without contacts."""

    def __init__(self, scene: Scene) -> None:
        self.mechanics = SceneMechanics(scene)
        self._coefficients = Coefficients(scene, self.mechanics.numbers)

    def at(self, q: np.ndarray, v: np.ndarray) -> _State:
        """The solutions at a state."""
        numbers, mechanics = self.mechanics.numbers, self.mechanics.at(q, v)
        return _State(numbers, mechanics, self._coefficients, v)


class _State(Equations):
    """The solutions of the equations of one state."""

    def exact(self, found: Found | None = None) -> Exact | None:
        """The solution beside an answer; None where Newton finds none there."""
        start = self._start_of(found)
        solution = self._newton(start, None)
        return self.exact_in_its_modes(found) if solution is None else solution

    def exact_in_its_modes(self, found: Found | None) -> Exact | None:
        """The solution in the modes of an answer.

        Contacts that are redundant but for rounding may be in one mode as well as in another;
        what these modes leave of the law's inequalities is told. A load that moves its contact
        by less than the velocities' own rounding is none.
        """
        if not self.c or found is None or not found.valid:
            return None
        start = self._start_of(found)
        speeds = np.abs(start[: self.n]) + np.abs(self.v)
        rounding = EPS * (self.m.contacts_size @ speeds)[2::3]
        pushes = (start[self.n + self.r :] * self.units[self.n + self.r :] ** 2)[2::3]
        modes = [
            SEPARATED if push <= least else mode
            for mode, push, least in zip(self.modes(start), pushes, rounding, strict=True)
        ]
        return self._newton(start, modes)

    def _newton(self, x: Array, kept: list[int] | None) -> Exact | None:
        modes: list[int] | None = None
        inverse, rank = None, 0
        tiny = self.numbers.epsilon**2
        target = self.numbers.number(10) ** -36
        for _ in range(MOST_STEPS):
            seen = kept or self.modes(x)
            if inverse is None or seen != modes or SLIDING in seen:
                inverse, rank = generalized_inverse(self.numbers, self.matrix(x, seen))
            modes = seen
            step = (inverse @ (self.left_over(x, seen) / self.rows_units(seen))) / self.units
            x = x - step
            moved = np.max(np.abs(step * self.units))
            size = np.max(np.abs(x * self.units))
            if not moved > target * size + tiny and (kept or self.modes(x) == modes):
                # Where rank is lost, a step of zero may leave what nothing can bring to zero.
                left = np.max(np.abs(self.left_over(x, modes) / self.rows_units(modes)))
                if not left > self.numbers.sqrt(target) * size + tiny:
                    return conditioned(self, x, modes, inverse, rank)
                return None
        return None

    def _start_of(self, found: Found | None) -> Array:
        x = self.numbers.zeros(self.n + self.r + 3 * self.c)
        if found is None or found.dv is None or not np.isfinite(found.dv).all():
            return x
        x[: self.n] = self.numbers.array(found.dv)
        impulses = self.own_axes(found)
        if impulses is not None:
            x[self.n :] = impulses
        return x

    def residuals(self, found: Found) -> Residuals:
        """What an answer leaves of its equations."""
        return residuals_of(self, found)
