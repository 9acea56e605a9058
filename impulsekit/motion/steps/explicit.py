"""DOP853 (Dormand & Prince, order 8) with its dense output, one step at a time.

The coefficients and the control of steps are scipy's (Hairer, Nørsett & Wanner, Solving Ordinary
Differential Equations I, II.5). scipy's own loop takes as long between evaluations as compiled
dynamics take for one; this one holds the stages in one array and asks for nothing twice.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ...laws.borrowed import borrowing

__all__ = [
    "GO_ON",
    "LEAST",
    "ExplicitStepper",
    "Output",
    "Rhs",
    "StepFailed",
    "Tableau",
    "error_of_sums",
    "first_guess",
    "first_length",
    "first_powers",
    "inside",
    "length_after",
    "nested",
    "shorter_length",
    "tableau",
]

# Hairer, Nørsett & Wanner (1993), II.4: the first step [s] where sizes or rates are below
# FAINT_RATE; rates and second derivatives below NONE count as zero.
FIRST, FAINT_RATE, NONE = 1e-6, 1e-5, 1e-15
Rhs = Callable[[float, np.ndarray], np.ndarray]

# By how much the next step may be longer or shorter, and below what its error allows.
LONGER, SHORTER, SAFETY = 10.0, 0.2, 0.9
# Of the error that steps are chosen by.
ORDER = 7
# In place of a first length: steps go on as long as they were about to be.
GO_ON = 0.0
# The least step, in units of the last place of time.
LEAST = 10.0
# The first step where nothing moves, as a share of the guess.
FIRST_SHARE = 1e-3


class Tableau(NamedTuple):
    """DOP853: weights (16, 16) and times (16,) of the stages, those of the result (12,), of both
    errors (2, 13) and of the dense output (4, 16)."""

    weights: np.ndarray
    times: np.ndarray
    result: np.ndarray
    errors: np.ndarray
    dense: np.ndarray


@cache
def tableau() -> Tableau:
    """The coefficients of DOP853."""
    from scipy.integrate import DOP853

    method: Any = DOP853
    count, more = method.n_stages, len(method.C_EXTRA)
    weights, times = np.zeros((count + 1 + more,) * 2), np.ones(count + 1 + more)
    weights[:count, :count], times[:count] = method.A, method.C
    weights[count + 1 :, : method.A_EXTRA.shape[1]] = method.A_EXTRA
    times[count + 1 :] = method.C_EXTRA
    errors = np.array([method.E5, method.E3])
    return Tableau(weights, times, np.array(method.B), errors, np.array(method.D))


class StepFailed(Exception):
    """No step is short enough. Internal: a motion ends with a status instead."""


@borrowing
def length_after(length: float, error: float, rejected: bool) -> float:
    """The length to try after a step of this length and error, which may be a second try [s]."""
    grown = LONGER if error == 0.0 else SAFETY * error ** (-1.0 / (ORDER + 1))
    return length * min(1.0 if rejected else LONGER, grown)


@borrowing
def shorter_length(length: float, error: float) -> float:
    """The length to try instead of a step that is off by too much [s]."""
    return length * max(SHORTER, SAFETY * error ** (-1.0 / (ORDER + 1)))


@borrowing
def first_guess(size: float, rate: float) -> float:
    """A step [s] after which y is still near, from sizes of y and ẏ in units of what is allowed."""
    return FIRST if size < FAINT_RATE or rate < FAINT_RATE else 0.01 * size / rate


@borrowing
def first_length(guess: float, rate: float, bend: float) -> float:
    """A first step [s] from a guess, and the sizes of ẏ and of how that changes in it."""
    if rate <= NONE and bend <= NONE:
        other = max(FIRST, guess * FIRST_SHARE)
    else:
        other = (0.01 / max(rate, bend)) ** (1.0 / (ORDER + 1))
    return min(100.0 * guess, other)


@borrowing
def inside(error: float, part: float) -> float:
    """What of a step's error counts for its dense output at a part of the step.

    Dense output is as good as the step at both ends, and so is its slope: between them its error
    goes with x² (1 − x)².
    """
    return 16.0 * error * (part * (1.0 - part)) ** 2


@borrowing
def error_of_sums(h: float, fifth: float, third: float, count: int) -> float:
    """The error of a step from the sums of squares of both its errors, ``count`` numbers each."""
    if fifth == 0.0 and third == 0.0:
        return 0.0
    return abs(h) * fifth / math.sqrt((fifth + 0.01 * third) * count)


@borrowing
def first_powers(h: float, change: Any, first: Any, last: Any) -> tuple[Any, Any, Any]:
    """F₀, F₁ and F₂ of ``nested`` from the rates at both ends; of numbers or arrays."""
    return change, h * first - change, 2.0 * change - h * (last + first)


@borrowing
def nested(x: float, a: Any, b: Any, c: Any, d: Any, e: Any, f: Any, g: Any) -> Any:
    """x (F₀ + (1 − x) (F₁ + x (F₂ + (1 − x) (F₃ + …)))) of F₀ to F₆; of numbers or arrays."""
    u = 1.0 - x
    return x * (a + u * (b + x * (c + u * (d + x * (e + u * (f + x * g))))))


class Output:
    """y within a step: y₀ and what ``nested`` adds.

    Attributes:
        start, length: of the step [s].
        before: (2 nv,) y₀. powers: (7, 2 nv) F₀, F₁, ….
    """

    def __init__(self, start: float, length: float, y: np.ndarray, powers: np.ndarray) -> None:
        self.start, self.length, self.before, self.powers = start, length, y, powers

    def __call__(self, t: float) -> np.ndarray:
        """(2 nv,) y at a time [s]."""
        return self.before + nested((t - self.start) / self.length, *self.powers)


class ExplicitStepper:
    """Steps of DOP853.

    Attributes:
        t: time [s]. y: (2 nv,) x and v. f: (2 nv,) the rates there.
        length: of the next step to try [s]. before: length [s] and error of the last step.
        soon: how long the next step may be [s], which those after it know nothing of.
    """

    def __init__(self, rhs: Rhs, rtol: float, atol: float) -> None:
        self._rhs, self._rtol, self._atol = rhs, rtol, atol
        table = tableau()
        self._count = count = len(table.result)
        stages = [(s, c, table.weights[s, :s].copy()) for s, c in enumerate(table.times.tolist())]
        self._stages, self._more = stages[1:count], stages[count + 1 :]
        self._last, self._power, self._errors = table.result, table.dense, table.errors
        self._slopes = np.empty((0, 0))
        self.t, self.y, self.f = 0.0, np.empty(0), np.empty(0)
        self.length, self._end = 0.0, 0.0
        self.before = 0.0, 0.0
        self.soon = math.inf

    def reset(self, t: float, y: np.ndarray, first: float | None, end: float) -> None:
        """Go on from elsewhere."""
        self.t, self.y, self._end = t, y, end
        self.before = 0.0, 0.0
        self.f = self._rhs(t, y)
        self._slopes = np.empty((self._count + 1 + len(self._more), len(y)))
        if first == GO_ON:
            return
        given = 0.0 if first is None else min(first, end - t)
        self.length = given if given > 0.0 else self._first_length()

    def moved(self, y: np.ndarray, f: np.ndarray) -> None:
        """Go on from the same time, slightly moved."""
        self.y, self.f = y, f

    def step(self, longest: float) -> Output:
        """One step of at most ``longest`` [s]; its dense output.

        Raises:
            StepFailed: none is short enough.
        """
        t, y, slopes, count = self.t, self.y, self._slopes, self._count
        least = LEAST * (math.nextafter(t, math.inf) - t)
        length = max(min(self.length, longest, self.soon), least)
        allowed = self.length if self.soon < self.length else 0.0
        slopes[0] = self.f
        rejected = False
        while True:
            if length < least:
                raise StepFailed("Required step size is less than spacing between numbers.")
            until = min(t + length, self._end)
            h = until - t
            length = h
            after, error = self._try(t, h, y)
            if error < 1.0:
                self.length = length_after(length, error, rejected)
                if not rejected:
                    self.length = max(self.length, allowed)
                self.before = length, error
                break
            length = shorter_length(length, error)
            rejected = True
        output = self._output(t, h, y, after)
        self.t, self.y, self.f = until, after, slopes[count].copy()
        return output

    def shortened(self, step: Output, end: float) -> Output:
        """The last step made once more, up to an earlier time [s].

        Its end is right to the order of a step; the dense output of the longer one is not.
        """
        t, y = step.start, step(step.start)
        after, _ = self._try(t, end - t, y)
        return self._output(t, end - t, y, after)

    def _try(self, t: float, h: float, y: np.ndarray) -> tuple[np.ndarray, float]:
        """(2 nv,) y after a step, and its error in units of what is allowed."""
        slopes, count = self._slopes, self._count
        for s, c, a in self._stages:
            slopes[s] = self._rhs(t + c * h, y + np.dot(slopes[:s].T, a) * h)
        after = y + h * np.dot(slopes[:count].T, self._last)
        slopes[count] = self._rhs(t + h, after)
        return after, self._error(slopes[: count + 1], h, y, after)

    def _output(self, t: float, h: float, y: np.ndarray, after: np.ndarray) -> Output:
        slopes, count = self._slopes, self._count
        for s, c, a in self._more:
            slopes[s] = self._rhs(t + c * h, y + np.dot(slopes[:s].T, a) * h)
        powers = np.empty((3 + len(self._power), len(y)))
        powers[0], powers[1], powers[2] = first_powers(h, after - y, slopes[0], slopes[count])
        powers[3:] = h * np.dot(self._power, slopes)
        return Output(t, h, y, powers)

    def _error(self, slopes: np.ndarray, h: float, y: np.ndarray, after: np.ndarray) -> float:
        """The error of a step in units of what is allowed."""
        scale = self._atol + np.maximum(np.abs(y), np.abs(after)) * self._rtol
        fifth, third = (np.dot(slopes.T, weights) / scale for weights in self._errors)
        return error_of_sums(h, float(fifth.dot(fifth)), float(third.dot(third)), len(y))

    def _first_length(self) -> float:
        """A first step [s] (Hairer, Nørsett & Wanner I, II.4)."""
        span = self._end - self.t
        if not self.y.size or span == 0.0:
            return math.inf
        scale = self._atol + np.abs(self.y) * self._rtol
        size, rate = _norm(self.y / scale), _norm(self.f / scale)
        length = min(first_guess(size, rate), span)
        there = self._rhs(self.t + length, self.y + length * self.f)
        bend = _norm((there - self.f) / scale) / length
        return min(first_length(length, rate, bend), span)


def _norm(values: np.ndarray) -> float:
    return float(np.linalg.norm(values)) / values.size**0.5
