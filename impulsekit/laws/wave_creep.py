"""Friction of contacts of a ``Wave`` whose slip starts from rest: against the acceleration."""

from __future__ import annotations

import math

from .borrowed import borrowed, borrowing
from .compiled import entry
from .dense import factorize, solve_factorized
from .path import outgoing
from .wave_holds import acceleration, hold
from .wave_state import CREEPS, Wave, wave

__all__ = ["creep"]

# How often contacts that creep take turns to find their directions, where Newton does not.
SWEEPS = 12
# Newton on the directions: turns by less have arrived, none is by more at once, and so often [rad].
CREEP_ARRIVED, MOST_TURN, MOST_TURNS = 1e-14, 0.5, 30


def _examples() -> tuple[object, ...]:
    return (wave(1, 3),)


@entry(_examples, seconds=5.0, apart=True)
def creep(w: Wave) -> int:
    """Friction of what creeps, against the direction in which it then is accelerated; how many."""
    w = borrowed(w)
    count = _lay_out(w)
    if count == 1 or not _together(w, count):
        # Those that feel each other take turns.
        for _ in range(1 if count == 1 else SWEEPS):
            for a in range(count):
                _direct(w, a, count)
    for a in range(count):
        i = _creeping(w, a)
        t, force = w.tangent[i], w.mu[i] * w.force[w.normal[i]]
        w.force[t], w.force[t + 1] = -force * w.way[i, 0], -force * w.way[i, 1]
    hold(w)
    return count


@borrowing
def _creeping(w: Wave, a: int) -> int:
    """The contact that is number a of those that creep."""
    return int(w.rows[len(w.free) + a])


@borrowing
def _direct(w: Wave, a: int, count: int) -> None:
    """The direction of one, beside the friction of the others."""
    i, k = _creeping(w, a), 2 * a
    n1, n2 = float(w.pulls[k, 2 * count]), float(w.pulls[k + 1, 2 * count])
    for b in range(count):
        if b != a:
            j = _creeping(w, b)
            f = w.mu[j] * w.force[w.normal[j]]
            n1 -= f * (w.pulls[k, 2 * b] * w.way[j, 0] + w.pulls[k, 2 * b + 1] * w.way[j, 1])
            n2 -= f * (
                w.pulls[k + 1, 2 * b] * w.way[j, 0] + w.pulls[k + 1, 2 * b + 1] * w.way[j, 1]
            )
    force = float(w.force[w.normal[i]])
    if n1 != 0.0 or n2 != 0.0:
        b11, b12, b22 = float(w.pulls[k, k]), float(w.pulls[k, k + 1]), float(w.pulls[k + 1, k + 1])
        s1, s2 = outgoing((b11, b12, b22, n1 / force, n2 / force, 1.0), float(w.mu[i]))
        # Where nothing it does moves it there is no direction.
        if math.isfinite(s1 + s2):
            w.way[i, 0], w.way[i, 1] = s1, s2


@borrowing
def _together(w: Wave, count: int) -> bool:
    """All that creep by Newton's iteration on their directions; whether it arrived.

    With a = a_0 − B µ F s their accelerations, s the directions, it seeks a × s = 0 for each. The
    turns δ solve (a·s + s⊥ᵀ B µ F s⊥) δ = s⊥·a, also where a is next to nothing: points of one
    body that depend on each other begin to slip so, all at once.
    """
    for _ in range(MOST_TURNS):
        for a in range(count):
            i = _creeping(w, a)
            s1, s2 = float(w.way[i, 0]), float(w.way[i, 1])
            a1, a2 = float(w.pulls[2 * a, 2 * count]), float(w.pulls[2 * a + 1, 2 * count])
            for b in range(count):
                j = _creeping(w, b)
                f1 = w.mu[j] * w.force[w.normal[j]] * w.way[j, 0]
                f2 = w.mu[j] * w.force[w.normal[j]] * w.way[j, 1]
                b11, b12 = w.pulls[2 * a, 2 * b], w.pulls[2 * a, 2 * b + 1]
                b21, b22 = w.pulls[2 * a + 1, 2 * b], w.pulls[2 * a + 1, 2 * b + 1]
                a1 -= b11 * f1 + b12 * f2
                a2 -= b21 * f1 + b22 * f2
                w.matrix[a, b] = s2 * (b11 * f2 - b12 * f1) - s1 * (b21 * f2 - b22 * f1)
            w.matrix[a, a] += s1 * a1 + s2 * a2
            w.right[a] = s1 * a2 - s2 * a1
        if not factorize(w.matrix, count, w.order):
            return False
        solve_factorized(w.matrix, count, w.order, w.right)
        most, total = 0.0, 0.0
        for a in range(count):
            most = max(most, abs(w.right[a]))
            total += w.right[a]
        # A maximum passes over what is no number.
        if not math.isfinite(total):
            return False
        _turn(w, count, min(1.0, MOST_TURN / most) if most > 0.0 else 1.0)
        if most <= CREEP_ARRIVED:
            return True
    return False


@borrowing
def _lay_out(w: Wave) -> int:
    """a_0 and B of what creeps into ``w.pulls``, beside what is held; how many they are."""
    count = 0
    for i in range(len(w.kappa)):
        if w.slip[i] == CREEPS:
            t = w.tangent[i]
            w.force[t], w.force[t + 1] = 0.0, 0.0
            if w.force[w.normal[i]] > 0.0:
                w.rows[len(w.free) + count] = i
                count += 1
    rows = 2 * count
    # First the forces without what creeps, then each of its forces alone.
    for b in range(-1, rows):
        if b >= 0:
            w.force[w.tangent[_creeping(w, b // 2)] + b % 2] = 1.0
        hold(w)
        for a in range(rows):
            rate = acceleration(w, int(w.tangent[_creeping(w, a // 2)] + a % 2))
            if b < 0:
                w.pulls[a, rows] = rate
            else:
                w.pulls[a, b] = rate - w.pulls[a, rows]
        if b >= 0:
            w.force[w.tangent[_creeping(w, b // 2)] + b % 2] = 0.0
    return count


@borrowing
def _turn(w: Wave, count: int, share: float) -> None:
    """Turn the directions by so much of the angles in ``w.right``."""
    for a in range(count):
        i, angle = _creeping(w, a), share * w.right[a]
        c, s = math.cos(angle), math.sin(angle)
        s1, s2 = float(w.way[i, 0]), float(w.way[i, 1])
        w.way[i, 0], w.way[i, 1] = c * s1 - s * s2, s * s1 + c * s2
