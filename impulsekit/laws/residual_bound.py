"""How far Δv and contact impulses are from their own equations, as a bound on the residuals."""

from __future__ import annotations

import math

import numpy as np

from .borrowed import borrowing
from .compiled import entry

__all__ = ["bound_residual", "momentum_misfit"]


def _examples() -> tuple[object, ...]:
    few = np.ones(2)
    return np.eye(2), np.ones((3, 2)), np.ones(3), few, few, np.ones(3), 3


@entry(_examples, seconds=1.0)
def bound_residual(
    mass: np.ndarray,
    rows: np.ndarray,
    impulse: np.ndarray,
    v: np.ndarray,
    dv: np.ndarray,
    after: np.ndarray,
    points: int,
) -> float:
    """A bound on what M Δv = JᵀP and u⁺ = J v⁺ lack, relative; NaN shows.

    Its sizes are those of the terms, without what impulses make one by one, and so are smaller
    than those of the residuals.

    Args:
        mass: (nv, nv) M; its lower half is read.
        rows: (m, nv) J. impulse: (m,) P.
        v, dv: (nv,) v⁻ and Δv.
        after: (m,) u⁺ of the law.
        points: how many rows are of points [m/s]; those of turning [rad/s] are judged apart.
    """
    nv, worst = len(dv), momentum_misfit(mass, rows, impulse, dv)
    if worst != worst:
        return worst
    for begin, end in ((0, points), (points, len(impulse))):
        off, fastest = 0.0, 0.0
        for r in range(begin, end):
            moved, size = -after[r], 0.0
            for k in range(nv):
                moved += rows[r, k] * (v[k] + dv[k])
                size += abs(rows[r, k]) * max(abs(v[k]), abs(v[k] + dv[k]))
            if moved != moved:
                return math.nan
            off = max(off, abs(moved))
            fastest = max(fastest, size)
        if fastest > 0.0:
            worst = max(worst, off / fastest)
    return worst


@borrowing
def momentum_misfit(
    mass: np.ndarray, rows: np.ndarray, impulse: np.ndarray, dv: np.ndarray
) -> float:
    """|M Δv − JᵀP| over the sum of its terms, the largest entry's; NaN shows.

    Args:
        mass: (nv, nv) M; its lower half is read.
        rows: (m, nv) J. impulse: (m,) P.
        dv: (nv,) Δv.
    """
    worst = 0.0
    for i in range(len(dv)):
        left, size = 0.0, 0.0
        for k in range(len(dv)):
            term = mass[max(i, k), min(i, k)] * dv[k]
            left += term
            size += abs(term)
        for k in range(len(impulse)):
            term = rows[k, i] * impulse[k]
            left -= term
            size += abs(term)
        # What is nothing but zeros is no error; of all else a NaN has to show.
        if left != left:
            return math.nan
        if left != 0.0:
            worst = max(worst, abs(left) / size)
    return worst
