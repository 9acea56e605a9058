"""Integrators, one step at a time: DOP853, scipy's Radau, and two with a fixed step.

All work on y = (x, v) in a chart, and give a dense output of their last step.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from .explicit import ExplicitStepper, StepFailed

__all__ = ["FixedStepper", "RadauStepper", "StepFailed", "Stepper", "stepper_of"]

# A remaining time below this share of a step becomes part of the step.
REST = 1e-9
Rhs = Callable[[float, np.ndarray], np.ndarray]
Dense = Callable[[float], np.ndarray]

# The size of x and v [m, rad, and those by s] of which the steps of numerical slopes are a part:
# near rest a step measured by x and v themselves would drown in rounding.
TYPICAL = 1.0
# The step [s] of methods with a fixed one, where none is given.
FIXED_STEP = 1e-3


class Stepper(Protocol):
    """What the loop needs of an integrator.

    Attributes:
        t: time [s]. y: (2 nv,) x and v. f: (2 nv,) the rates there.
        length: of the next step to try [s].
    """

    t: float
    y: np.ndarray
    f: np.ndarray
    length: float

    def step(self, longest: float) -> Dense:
        """One step of at most ``longest`` [s]; its dense output, on [t before, t after]."""

    def reset(self, t: float, y: np.ndarray, first: float | None, end: float) -> None:
        """Go on from elsewhere, to ``end`` [s] at most.

        ``first`` is the length to try first [s], None to choose.
        """

    def moved(self, y: np.ndarray, f: np.ndarray) -> None:
        """Go on from the same time, with y and f put into another chart or slightly moved."""


def stepper_of(method: str, rhs: Rhs, rtol: float, atol: float, step: float | None) -> Stepper:
    """The stepper for a method's name; ``step`` for those with a fixed one [s]."""
    if method in ("rk4", "semi-implicit"):
        return FixedStepper(rhs, method, FIXED_STEP if step is None else step)
    if method == "dop853":
        return ExplicitStepper(rhs, rtol, atol)
    return RadauStepper(rhs, rtol, atol)


class RadauStepper:
    """Radau IIA (order 5), as scipy has it."""

    def __init__(self, rhs: Rhs, rtol: float, atol: float) -> None:
        from scipy.integrate import Radau

        self._kind: Any = Radau
        self.t, self.y, self.f, self.length = 0.0, np.empty(0), np.empty(0), 0.0
        self._rhs, self._end = rhs, 0.0
        self._options: dict[str, Any] = {"rtol": rtol, "atol": atol, "jac": self._slope}
        self._solver: Any = None
        # The slope of the right side that Radau had last, and num_jac's own increments.
        self._last_slope: np.ndarray | None = None
        self._increments: np.ndarray | None = None

    def reset(self, t: float, y: np.ndarray, first: float | None, end: float) -> None:
        """Go on from elsewhere."""
        self._last_slope, self._end = None, end
        self._start(t, y, first)

    def moved(self, y: np.ndarray, f: np.ndarray) -> None:
        """Go on from the same time, slightly moved."""
        # Radau starts its Newton from the last step's polynomial, which is of another chart.
        # Its slope is worth keeping: it is what costs.
        self._last_slope = self._solver.J
        self._start(self.t, y, self._solver.h_abs)
        self._solver.current_jac = False

    def step(self, longest: float) -> Dense:
        """One step; its dense output."""
        solver = self._solver
        solver.max_step = longest
        message = solver.step()
        if solver.status == "failed":
            raise StepFailed(message)
        self._read()
        return solver.dense_output()

    def _start(self, t: float, y: np.ndarray, first: float | None) -> None:
        if first is not None:
            first = min(first, self._end - t)
            first = first if first > 0.0 else None
        self._solver = self._kind(self._rhs, t, y, self._end, first_step=first, **self._options)
        self._read()

    def _read(self) -> None:
        """Show where scipy's solver is."""
        own = self._solver
        self.t, self.y, self.f, self.length = float(own.t), own.y, own.f, float(own.h_abs)

    def _slope(self, t: float, y: np.ndarray) -> np.ndarray:
        from scipy.integrate._ivp.common import num_jac

        if self._last_slope is not None:
            slope, self._last_slope = self._last_slope, None
            return slope

        def many(t: float, columns: np.ndarray) -> np.ndarray:
            return np.array([self._rhs(t, column) for column in columns.T]).T

        slope, self._increments = num_jac(many, t, y, self._rhs(t, y), TYPICAL, self._increments)
        return slope


class FixedStepper:
    """Baselines: the classical fourth-order method, and semi-implicit Euler of first order."""

    def __init__(self, rhs: Rhs, method: str, step: float) -> None:
        self._rhs, self._end, self.length = rhs, 0.0, step
        self._advance = _rk4 if method == "rk4" else _semi_implicit
        self.t, self.y, self.f = 0.0, np.empty(0), np.empty(0)

    def reset(self, t: float, y: np.ndarray, first: float | None, end: float) -> None:
        """Go on from elsewhere."""
        self._end = end
        self.t, self.y, self.f = t, y, self._rhs(t, y)

    def moved(self, y: np.ndarray, f: np.ndarray) -> None:
        """Go on from the same time, slightly moved."""
        self.y, self.f = y, f

    def step(self, longest: float) -> Dense:
        """One step; its dense output."""
        t, y, f = self.t, self.y, self.f
        h = min(self.length, longest)
        # The last step ends at the end, not a rounding before it.
        h = self._end - t if t + h * (1.0 + REST) >= self._end else h
        if not t + h > t:
            raise StepFailed("the step is below the spacing of numbers")
        self.t = self._end if h == self._end - t else t + h
        self.y = self._advance(self._rhs, t, y, f, h)
        self.f = self._rhs(self.t, self.y)
        return _hermite(t, self.t, y, f, self.y, self.f)


def _rk4(rhs: Rhs, t: float, y: np.ndarray, f: np.ndarray, h: float) -> np.ndarray:
    second = rhs(t + 0.5 * h, y + 0.5 * h * f)
    third = rhs(t + 0.5 * h, y + 0.5 * h * second)
    last = rhs(t + h, y + h * third)
    return y + (h / 6.0) * (f + 2.0 * (second + third) + last)


def _semi_implicit(rhs: Rhs, t: float, y: np.ndarray, f: np.ndarray, h: float) -> np.ndarray:
    """v from the old state, then x with the new v."""
    half = len(y) // 2
    after = y.copy()
    after[half:] += h * f[half:]
    after[:half] += h * rhs(t, after)[:half]
    return after


def _hermite(
    t0: float, t1: float, y0: np.ndarray, f0: np.ndarray, y1: np.ndarray, f1: np.ndarray
) -> Dense:
    """The cubic with values and rates of both ends."""
    h = t1 - t0
    change = y1 - y0

    def dense(t: float) -> np.ndarray:
        s = (t - t0) / h
        bend = (1.0 - 2.0 * s) * change + h * ((s - 1.0) * f0 + s * f1)
        return y0 + s * change + s * (s - 1.0) * bend

    return dense
