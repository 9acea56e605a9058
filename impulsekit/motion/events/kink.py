"""A kink of a force, and the search for the first of several functions that falls to zero."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..zeros.closing import Node
from ..zeros.roots import States, first_zero

__all__ = ["PART", "Kink", "first_fall", "with_rate"]

# Step of the differences for rates, as a part of the time that is looked at.
PART = 1e-4


class Kink(NamedTuple):
    """Where a force of the scene changes its law.

    Attributes:
        t: [s].
        switch: sets what changes there to what it is from then on.
        off: what falls to zero there and its rate, from a time and the states of a step.
    """

    t: float
    switch: Callable[[], None]
    off: Callable[[float, States], tuple[float, float]]


def with_rate(
    value: Callable[[float, States], float], step: float
) -> Callable[[float, States], tuple[float, float]]:
    """A function of time and states, with its rate by a difference over a step [s]."""

    def both(t: float, states: States) -> tuple[float, float]:
        here = value(t, states)
        return here, (here - value(t - step, states)) / step

    return both


def first_fall(
    values: Callable[[float], np.ndarray], times: np.ndarray, rounding: float
) -> tuple[float, int]:
    """The first time at which one of several smooth functions falls to zero, and which.

    Infinity and -1 where none does. Rates are differences.

    Args:
        values: (m,) at a time [s].
        times: (k,) the nodes to look at, evenly in pairs. rounding: of the values.
    """
    step = PART * (times[-1] - times[0]) / (len(times) - 1)

    def rates(t: float) -> np.ndarray:
        a, b = max(t - step, times[0]), min(t + step, times[-1])
        return (values(b) - values(a)) / (b - a)

    def node(i: int, t: float) -> Node:
        return Node(t, float(values(t)[i]), float(rates(t)[i]))

    seen = np.array([values(t) for t in times])
    slopes = np.array([rates(t) for t in times])
    return first_zero(times, seen, slopes, node, lambda i, size: rounding)
