"""The first downward zero of a smooth gap: cubics between nodes, halved until they are sure.

Between two nodes a gap is the cubic with its values and rates there, but for an error that
shrinks by 16 as the piece is halved. A piece is left out where the cubic's Bernstein
coefficients keep it above zero; where the gap surely falls, or bends one way only, its sign
changes are known; else it is halved. Where its error is below the rounding error of the gap, the
cubic is all that can be known: its own turning points part it into pieces that fall or rise.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from .roots import falling_root

__all__ = ["Node", "errors_of", "first_zero", "may_close"]

# A gap that only dips this far below zero [m] was grazed.
GRAZED = 1e-12
# Of how much a cubic spans: so far it is off besides what its neighbours tell.
MARGIN = 1e-3
# The slope of a cubic is off by up to 3.2, its bend by 32 of its own error (Birkhoff & Priver
# 1967), by piece. What neighbours tell is rounded up.
OF_SLOPE, OF_BEND = 4.0, 32.0
# Newton's steps to a zero of a gap, and one so short [s, and of the time] that it is found. The
# zero of a cubic is wanted to a part of its length.
FEW, TICK, NEARLY = 8, 1e-15, 1e-12
# Pieces are halved so often at most: of a window of 1 s the last are one step of a clock long.
HALVES = 52


@dataclass(frozen=True)
class Node:
    """A gap [m] and its rate [m/s] at a time [s]."""

    t: float
    gap: float
    rate: float


def errors_of(times: np.ndarray, values: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """(k - 1, m) by how much cubics between even nodes may be off [m]; an even number of pieces.

    The cubic over two pieces is held against the node in the middle; the error of one piece is a
    sixteenth of what is seen there, and is taken four times as large.
    """
    double = times[2::2] - times[:-2:2]
    middle = 0.5 * (values[:-2:2] + values[2::2])
    middle += double[:, None] / 8.0 * (rates[:-2:2] - rates[2::2])
    return np.repeat(0.25 * np.abs(values[1::2] - middle), 2, axis=0)


def may_close(
    times: np.ndarray, values: np.ndarray, rates: np.ndarray, errors: np.ndarray
) -> np.ndarray:
    """(k - 1, m) whether cubics between nodes may come to zero."""
    step = np.diff(times)[:, None] / 3.0
    left, right = values[:-1], values[1:]
    bounds = np.array([left, left + step * rates[:-1], right - step * rates[1:], right])
    lowest, highest = bounds.min(axis=0), bounds.max(axis=0)
    return lowest <= MARGIN * (highest - lowest) + errors


def first_zero(
    node: Callable[[float], Node], left: Node, right: Node, error: float, rounding: float
) -> float:
    """The first time at which a gap falls to zero in a piece; infinity where it does not.

    Args:
        node: the gap at a time.
        left, right: at both ends.
        error: of the cubic between them [m].
        rounding: of the gap [m]: nothing is looked for in less.
    """
    if left.gap <= 0.0 and (left.rate < 0.0 or (left.rate == 0.0 and right.gap < left.gap)):
        return left.t
    pieces = [(left, right, error, 0)]
    while pieces:
        a, b, error, halved = pieces.pop()
        h = b.t - a.t
        change = b.gap - a.gap
        lowest = min(a.gap, a.gap + h * a.rate / 3.0, b.gap - h * b.rate / 3.0, b.gap)
        ends_open = b.gap >= 0.0 or (b.gap >= -rounding and b.rate >= 0.0)
        if lowest > error or (ends_open and lowest - error >= -GRAZED):
            continue
        parts = [a, b]
        if error <= rounding or halved == HALVES:
            parts[1:1] = [node(t) for t in _turning_points(a, b)]
        else:
            slopes = (h * a.rate, 3.0 * change - h * (a.rate + b.rate), h * b.rate)
            bends = (
                6.0 * change - h * (4.0 * a.rate + 2.0 * b.rate),
                h * (2.0 * a.rate + 4.0 * b.rate) - 6.0 * change,
            )
            if min(slopes) >= OF_SLOPE * error:
                continue
            sure = (
                max(slopes) <= -OF_SLOPE * error
                or min(bends) >= OF_BEND * error
                or max(bends) <= -OF_BEND * error
            )
            if not sure:
                middle = node(0.5 * (a.t + b.t))
                pieces.append((middle, b, error / 16.0, halved + 1))
                pieces.append((a, middle, error / 16.0, halved + 1))
                continue
        for one, two in pairwise(parts):
            if two is not b and -GRAZED <= two.gap < 0.0 < one.gap:
                # Where the cubic turns it has come no further.
                continue
            t = _where(node, one, two)
            if t < np.inf:
                return t
    return np.inf


def _turning_points(a: Node, b: Node) -> list[float]:
    """Where the cubic between two nodes turns, in order."""
    h = b.t - a.t
    # Its slope over s from 0 to 1: c + 2 b s + a s².
    c, change = h * a.rate, b.gap - a.gap
    half = 3.0 * change - h * (2.0 * a.rate + b.rate)
    top = 3.0 * (h * (a.rate + b.rate) - 2.0 * change)
    inside = half * half - top * c
    if inside <= 0.0:
        return []
    # Without cancellation (Numerical Recipes 5.6).
    q = -(half + math.copysign(math.sqrt(inside), half))
    found = [x / y for x, y in ((q, top), (c, q)) if y != 0.0]
    return sorted(t for t in (a.t + s * h for s in found if 0.0 < s < 1.0) if a.t < t < b.t)


def _falling(node: Callable[[float], Node], a: Node, b: Node) -> float:
    """Where a gap comes to zero that is positive at one end of a piece and negative at the other.

    Newton from the zero of the cubic, which is all but there; where rates are rounding it wanders,
    and the piece that is left is searched without them.
    """
    s = _zero_of_cubic(a, b)
    t = a.t + s * (b.t - a.t)
    for _ in range(FEW):
        here = node(t)
        if here.gap == 0.0:
            return t
        a, b = (here, b) if here.gap > 0.0 else (a, here)
        step = -here.gap / here.rate if here.rate < 0.0 else np.inf
        if abs(step) <= TICK * (1.0 + abs(t)):
            return t
        t += step
        if not a.t < t < b.t:
            break
    return falling_root(lambda t: node(t).gap, a.t, b.t)


def _zero_of_cubic(a: Node, b: Node) -> float:
    """Where the cubic between two nodes falls to zero, from 0 to 1."""
    h = b.t - a.t
    p, q, change = h * a.rate, h * b.rate, b.gap - a.gap
    bend, third = 3.0 * change - 2.0 * p - q, p + q - 2.0 * change
    low, high, s = 0.0, 1.0, a.gap / (a.gap - b.gap)
    for _ in range(HALVES):
        value = a.gap + s * (p + s * (bend + s * third))
        low, high = (s, high) if value > 0.0 else (low, s)
        slope = p + s * (2.0 * bend + 3.0 * s * third)
        last, s = s, s - value / slope if slope < 0.0 else high
        if not low < s < high:
            s = 0.5 * (low + high)
        if abs(s - last) <= NEARLY:
            break
    return s


def _where(node: Callable[[float], Node], a: Node, b: Node) -> float:
    """The zero in a piece in which the gap falls, or bends one way only."""

    def gap(t: float) -> float:
        return node(t).gap

    if a.gap > 0.0 >= b.gap and b.gap < 0.0:
        return _falling(node, a, b)
    if a.rate < 0.0 < b.rate:
        # It may have been below in between.
        lowest = node(falling_root(lambda t: -node(t).rate, a.t, b.t))
        if lowest.gap < -GRAZED:
            return falling_root(gap, a.t, lowest.t) if a.gap > 0.0 else a.t
        return np.inf
    if a.rate > 0.0 > b.rate and b.gap < min(a.gap, 0.0):
        # It starts at zero, or below it by rounding, and comes back.
        highest = node(falling_root(lambda t: node(t).rate, a.t, b.t))
        level = min(0.0, a.gap) if highest.gap <= 0.0 else 0.0
        return falling_root(lambda t: gap(t) - level, highest.t, b.t)
    if b.gap < min(a.gap, -GRAZED) and a.gap <= 0.0:
        return a.t
    return np.inf
