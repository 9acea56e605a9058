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
from typing import Any, NamedTuple

import numpy as np

from ...laws.borrowed import borrowing
from ...laws.compiled import compiled

__all__ = ["GAP", "Node", "error_of", "lowest_of", "root_finder", "zero_finder"]

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
# Where a function comes to zero: to so much [s, and of the time], in so many steps.
EXACT, MOST_STEPS = 1e-15, 100


class Node(NamedTuple):
    """A gap [m] and its rate [m/s] at a time [s]."""

    t: float
    gap: float
    rate: float


@borrowing
def error_of(double: Any, begin: Any, middle: Any, end: Any, first: Any, last: Any) -> Any:
    """By how much the cubics over both halves of a piece may be off [m].

    The cubic over all of it is held against the value in the middle; the error of one half is a
    sixteenth of what is seen there, and is taken four times as large. Of numbers or arrays.

    Args:
        double: the length of the piece [s].
        begin, middle, end: values. first, last: rates at both ends.
    """
    return 0.25 * abs(middle - 0.5 * (begin + end) - double / 8.0 * (first - last))


@borrowing
def lowest_of(piece: Any, left: Any, right: Any, first: Any, last: Any, error: Any) -> Any:
    """A lower bound of a function near a cubic, from its Bernstein coefficients.

    Of numbers or arrays.

    Args:
        piece: its length [s]. left, right: values at both ends. first, last: rates there.
        error: by how much the cubic may be off.
    """
    one, two = left + piece / 3.0 * first, right - piece / 3.0 * last
    lowest = np.minimum(np.minimum(left, right), np.minimum(one, two))
    highest = np.maximum(np.maximum(left, right), np.maximum(one, two))
    return lowest - MARGIN * (highest - lowest) - error


@borrowing
def _turning_points(a: Node, b: Node) -> tuple[int, float, float]:
    """How often the cubic between two nodes turns, and where, in order."""
    h = b.t - a.t
    # Its slope over s from 0 to 1: c + 2 b s + a s².
    c, change = h * a.rate, b.gap - a.gap
    half = 3.0 * change - h * (2.0 * a.rate + b.rate)
    top = 3.0 * (h * (a.rate + b.rate) - 2.0 * change)
    inside = half * half - top * c
    if inside <= 0.0:
        return 0, 0.0, 0.0
    # Without cancellation (Numerical Recipes 5.6).
    q = -(half + math.copysign(math.sqrt(inside), half))
    one, two = math.inf, math.inf
    if top != 0.0 and 0.0 < q / top < 1.0 and a.t < a.t + q / top * h < b.t:
        one = a.t + q / top * h
    if q != 0.0 and 0.0 < c / q < 1.0 and a.t < a.t + c / q * h < b.t:
        two = a.t + c / q * h
    one, two = min(one, two), max(one, two)
    return int(one < math.inf) + int(two < math.inf), one, two


@borrowing
def _zero_of_cubic(a: Node, b: Node) -> float:
    """Where the cubic between two nodes falls to zero, from 0 to 1."""
    h = b.t - a.t
    p, q, change = h * a.rate, h * b.rate, b.gap - a.gap
    bend, third = 3.0 * change - 2.0 * p - q, p + q - 2.0 * change
    low, high, s = 0.0, 1.0, a.gap / (a.gap - b.gap)
    for _ in range(HALVES):
        value = a.gap + s * (p + s * (bend + s * third))
        if value > 0.0:
            low = s
        else:
            high = s
        slope = p + s * (2.0 * bend + 3.0 * s * third)
        last = s
        s = s - value / slope if slope < 0.0 else high
        if not low < s < high:
            s = 0.5 * (low + high)
        if abs(s - last) <= NEARLY:
            break
    return s


@borrowing
def _is_clear(a: Node, b: Node, error: float, rounding: float) -> bool:
    """Whether the cubic between two nodes stays above zero, or only grazes it."""
    h = b.t - a.t
    lowest = min(a.gap, a.gap + h * a.rate / 3.0, b.gap - h * b.rate / 3.0, b.gap)
    ends_open = b.gap >= 0.0 or (b.gap >= -rounding and b.rate >= 0.0)
    return lowest > error or (ends_open and lowest - error >= -GRAZED)


# What is known of a gap in a piece: it rises, nothing yet, it falls or bends one way only.
_RISES, _UNSURE, _SURE = 0, 1, 2


@borrowing
def _shape(a: Node, b: Node, error: float) -> int:
    """How a gap surely runs between two nodes whose cubic is off by ``error`` [m]."""
    h, change = b.t - a.t, b.gap - a.gap
    begin, middle, end = h * a.rate, 3.0 * change - h * (a.rate + b.rate), h * b.rate
    if min(begin, middle, end) >= OF_SLOPE * error:
        return _RISES
    one = 6.0 * change - h * (4.0 * a.rate + 2.0 * b.rate)
    two = h * (2.0 * a.rate + 4.0 * b.rate) - 6.0 * change
    if max(begin, middle, end) <= -OF_SLOPE * error:
        return _SURE
    return (
        _SURE if min(one, two) >= OF_BEND * error or max(one, two) <= -OF_BEND * error else _UNSURE
    )


@borrowing
def _put(pieces: np.ndarray, at: int, a: Node, b: Node, error: float, halved: int) -> None:
    """Put a piece on the pile of those that are still to be looked at."""
    row = pieces[at]
    row[0], row[1], row[2], row[3], row[4], row[5] = a.t, a.gap, a.rate, b.t, b.gap, b.rate
    row[6], row[7] = error, halved


def zero_finder(node: Callable[[Any, float], Node]) -> Callable[..., float]:
    """The search for the first zero of gaps that ``node(gap, t)`` evaluates.

    Returns:
        ``first_zero(gap, left, right, error, rounding)``: the first time at which a gap falls to
        zero in a piece; infinity where it does not. Its arguments are the gap; its nodes at both
        ends; the error of the cubic between them [m]; and the gap's rounding error [m]: nothing
        is looked for in less. Compiled code may call it if it may call ``node``.
    """
    where = _searcher(node)

    @compiled
    def first_zero(gap: Any, left: Node, right: Node, error: float, rounding: float) -> float:
        if left.gap <= 0.0 and (left.rate < 0.0 or (left.rate == 0.0 and right.gap < left.gap)):
            return left.t
        pieces, count = np.empty((2 * HALVES, 8)), 1
        _put(pieces, 0, left, right, error, 0)
        while count > 0:
            count -= 1
            row = pieces[count]
            a, b = Node(row[0], row[1], row[2]), Node(row[3], row[4], row[5])
            error, halved = row[6], int(row[7])
            if _is_clear(a, b, error, rounding):
                continue
            turns, one, two = 0, 0.0, 0.0
            if error <= rounding or halved == HALVES:
                turns, one, two = _turning_points(a, b)
            else:
                shape = _shape(a, b, error)
                if shape == _RISES:
                    continue
                if shape == _UNSURE:
                    middle = node(gap, 0.5 * (a.t + b.t))
                    _put(pieces, count, middle, b, error / 16.0, halved + 1)
                    _put(pieces, count + 1, a, middle, error / 16.0, halved + 1)
                    count += 2
                    continue
            before = a
            for turn in range(turns + 1):
                here = b if turn == turns else node(gap, one if turn == 0 else two)
                # Where the cubic turns inside it may have come no further than to graze.
                if turn == turns or not -GRAZED <= here.gap < 0.0 < before.gap:
                    t = where(gap, before, here)
                    if t < math.inf:
                        return t
                before = here
        return math.inf

    return first_zero


# What is asked of a node: its gap, or its rate turned round or as it is.
GAP, _FALL, _RISE = 0, -1, 1


def _searcher(node: Callable[[Any, float], Node]) -> Callable[..., float]:
    """The zero in a piece in which the gap falls, or bends one way only."""
    root = root_finder(node)

    @borrowing
    def falling(gap: Any, a: Node, b: Node) -> float:
        # Newton from the zero of the cubic, which is nearly there; where rates are rounding it
        # wanders, and the piece that is left is searched without them.
        t = a.t + _zero_of_cubic(a, b) * (b.t - a.t)
        for _ in range(FEW):
            here = node(gap, t)
            if here.gap == 0.0:
                return t
            if here.gap > 0.0:
                a = here
            else:
                b = here
            step = -here.gap / here.rate if here.rate < 0.0 else math.inf
            if abs(step) <= TICK * (1.0 + abs(t)):
                return t
            t += step
            if not a.t < t < b.t:
                break
        return root(gap, a.t, b.t, GAP, 0.0)

    @borrowing
    def where(gap: Any, a: Node, b: Node) -> float:
        if a.gap > 0.0 >= b.gap and b.gap < 0.0:
            return falling(gap, a, b)
        if a.rate < 0.0 < b.rate:
            # It may have been below in between.
            lowest = node(gap, root(gap, a.t, b.t, _FALL, 0.0))
            if lowest.gap < -GRAZED:
                return root(gap, a.t, lowest.t, GAP, 0.0) if a.gap > 0.0 else a.t
            return math.inf
        if a.rate > 0.0 > b.rate and b.gap < min(a.gap, 0.0):
            # It starts at zero, or below it by rounding, and comes back.
            highest = node(gap, root(gap, a.t, b.t, _RISE, 0.0))
            level = min(0.0, a.gap) if highest.gap <= 0.0 else 0.0
            return root(gap, highest.t, b.t, GAP, level)
        if b.gap < min(a.gap, -GRAZED) and a.gap <= 0.0:
            return a.t
        return math.inf

    return where


def root_finder(node: Callable[[Any, float], Node]) -> Callable[..., float]:
    """Where a gap, above a level, or a rate falls to zero in a piece (Brent 1973, as in scipy)."""

    @borrowing
    def value(gap: Any, t: float, kind: int, level: float) -> float:
        here = node(gap, t)
        return here.gap - level if kind == GAP else kind * here.rate

    @borrowing
    def root(gap: Any, start: float, end: float, kind: int, level: float) -> float:
        last, t, other = start, end, start
        of_last, of_t = value(gap, start, kind, level), value(gap, end, kind, level)
        of_other = of_last
        if of_last <= 0.0:
            return start
        if of_t > 0.0:
            return end
        before = step = end - start
        for _ in range(MOST_STEPS):
            if of_last != 0.0 and of_t != 0.0 and (of_last > 0.0) != (of_t > 0.0):
                other, of_other = last, of_last
                before = step = t - last
            if abs(of_other) < abs(of_t):
                last, t, other = t, other, t
                of_last, of_t, of_other = of_t, of_other, of_t
            near, half = 0.5 * EXACT * (1.0 + abs(t)), 0.5 * (other - t)
            if of_t == 0.0 or abs(half) < near:
                break
            trial = math.inf
            if abs(before) > near and abs(of_t) < abs(of_last):
                if last == other:
                    trial = -of_t * (t - last) / (of_t - of_last)
                else:
                    one = (of_last - of_t) / (last - t)
                    two = (of_other - of_t) / (other - t)
                    trial = -of_t * (of_other * two - of_last * one)
                    trial /= two * one * (of_other - of_last)
            if 2.0 * abs(trial) < min(abs(before), 3.0 * abs(half) - near):
                before, step = step, trial
            else:
                before = step = half
            last, of_last = t, of_t
            t += step if abs(step) > near else math.copysign(near, half)
            of_t = value(gap, t, kind, level)
        return t

    return root
