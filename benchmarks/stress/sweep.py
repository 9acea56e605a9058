"""What a sweep is, and what it records."""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from benchmarks.truths.found import Exact, Found
from benchmarks.truths.residuals import Residuals
from impulsekit.scene import Scene

# Of a case, as a rule.
STATES = 6


def decades(first: int, last: int, step: int = 1) -> tuple[float, ...]:
    """Powers of ten."""
    return tuple(float(f"1e{k}") for k in range(first, last + 1, step))


class StateTruth(Protocol):
    """The equations of one state."""

    def exact(self, found: Found | None = None) -> Exact | None:
        """The solution beside an answer; None where there is none to be found."""

    def residuals(self, found: Found) -> Residuals:
        """What an answer leaves of its equations."""


class Truth(Protocol):
    """Answers in 50 digits."""

    def at(self, q: np.ndarray, v: np.ndarray) -> StateTruth:
        """The equations at a state."""


@dataclass(frozen=True, eq=False)
class Case:
    """A scene at B states, and its truth.

    Attributes:
        scene: what strikes, holds and touches.
        q: (B, nq). v: (B, nv).
        truth: gives the answer in 50 digits.
        batch: whether ``solve_batch`` is.
    """

    scene: Scene
    q: np.ndarray
    v: np.ndarray
    truth: Truth
    batch: bool = True


@dataclass(frozen=True)
class Sweep:
    """A parameter that goes to the edge.

    Attributes:
        name: as the command takes it.
        parameter: what varies, with its unit.
        values: of the parameter.
        cases: from a value and a generator of random numbers to a case.
        repeats: how many cases of each value the full form takes; the quick one takes some.
        logarithmic: whether the parameter is best drawn so.
    """

    name: str
    parameter: str
    values: tuple[float, ...]
    cases: Cases = field(repr=False)
    repeats: int
    logarithmic: bool = True

    @property
    def what(self) -> str:
        """One sentence: that of its cases."""
        return self.cases.__doc__ or ""

    def rng(self, place: int, repeat: int, seed: int) -> np.random.Generator:
        """The random numbers of one case: the same however the work is shared out."""
        return np.random.default_rng([seed, zlib.crc32(self.name.encode()), place, repeat])


class Sweeps(list[Sweep]):
    """The sweeps of a file in its order; each is written over the function of its cases."""

    def of(
        self,
        name: str,
        parameter: str,
        values: tuple[float, ...],
        repeats: int,
        *,
        logarithmic: bool = True,
    ) -> Callable[[Cases], Cases]:
        """A decorator; the arguments are those of ``Sweep``."""

        def added(cases: Cases) -> Cases:
            self.append(Sweep(name, parameter, values, cases, repeats, logarithmic))
            return cases

        return added


@dataclass(frozen=True)
class Point:
    """One method at one state.

    Attributes:
        sweep, value, repeat, state: which.
        method: "solve", "batch", "long chain".
        status: the name of the status or error that came.
        verdict: "right", "said so" (the status or an error reports that it is not valid) or
            "wrong": silently.
        error: of Δv, the largest over the largest speed, as velocities of matter.
        condition: by how much relative changes of the data are amplified.
        share: the error over condition times eps, of speeds and of impulses.
        each: the same speed by speed, each against its own condition.
        momentum, law: residuals in 50 digits.
        seconds: of the call; of a batch, per state.
    """

    sweep: str
    value: float
    repeat: int
    state: int
    method: str
    status: str
    verdict: str
    error: float
    condition: float
    share: float
    each: float
    momentum: float
    law: float
    seconds: float

    def row(self) -> tuple[Any, ...]:
        """Its entries in order."""
        return tuple(getattr(self, name) for name in self.__dataclass_fields__)


Cases = Callable[[float, np.random.Generator], Case | Sequence[Point]]


def seen(
    state: int,
    method: str,
    status: str,
    verdict: str,
    seconds: float,
    *,
    error: float = math.nan,
    condition: float = 1.0,
    share: float = math.nan,
) -> Point:
    """A point that knows no truth in 50 digits; its sweep, value and repeat come from ``run``."""
    none = math.nan
    numbers = (error, condition, share, none, none, none)
    return Point("", none, 0, state, method, status, verdict, *numbers, seconds)
