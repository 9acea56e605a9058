"""Coulomb's law for forces and accelerations at resting contacts, solved to rounding.

With accelerations for velocities it is the law of ``impact.laws.frictional``:
0 ≤ P_n ⊥ ξ_n ≥ 0, |P_t| ≤ µ P_n, P_t = −µ P_n ξ_t/|ξ_t| where ξ_t ≠ 0, ξ = W P + b. W need
not be symmetric: a contact that slides is given as one without friction whose column of W
holds the friction that goes with its normal force. Newton on the natural map (Alart &
Curnier 1991) from the last solution; contact after contact where that does not get there.
"""

from __future__ import annotations

import numpy as np

__all__ = ["RestNotSolved", "solve_rest"]

# What the residual has to come down to, relative to the accelerations.
BAR = 1e-9
MOST_STEPS = 25
TINY = 1e-14


class RestNotSolved(Exception):
    """No forces found. Internal: a motion ends with a status instead."""


def solve_rest(
    delassus: np.ndarray, free: np.ndarray, friction: np.ndarray, start: np.ndarray
) -> np.ndarray:
    """(3n,) contact forces P [N], two tangents and the normal of each contact.

    Args:
        delassus: (3n, 3n) W [1/kg].
        free: (3n,) b, the accelerations without contact forces [m/s²].
        friction: (n,) µ; 0 for what slides.
        start: (3n,) the forces to start from.

    Raises:
        RestNotSolved: there are none, or they were not found.
    """
    scale = float(np.abs(free).max(initial=0.0))
    if not scale > 0.0:
        return np.zeros_like(free)
    problem = _NaturalMap(delassus, free, friction, scale)
    best, residual = problem.newton(start)
    if residual > BAR and start.any():
        other, error = problem.newton(np.zeros_like(start))
        if error < residual:
            best, residual = other, error
    if residual > BAR:
        from ..impact.laws.gauss_seidel import sweep

        impulse = np.zeros_like(start)
        for _ in range(20):
            impulse, _ = sweep(problem.delassus, problem.free, friction, None, impulse, scale)
            best, residual = problem.newton(impulse)
            if residual <= BAR:
                break
    if not residual <= BAR:
        raise RestNotSolved(f"residual {residual:.1e}")
    return best


class _NaturalMap:
    """F(P) = 0, and Newton on it."""

    def __init__(
        self, delassus: np.ndarray, free: np.ndarray, friction: np.ndarray, scale: float
    ) -> None:
        smooth = np.flatnonzero(friction == 0.0)
        if smooth.size:
            # Tangents without friction carry nothing.
            delassus, free = delassus.copy(), free.copy()
            for offset in (0, 1):
                delassus[3 * smooth + offset] = 0.0
                delassus[:, 3 * smooth + offset] = 0.0
                free[3 * smooth + offset] = 0.0
        self.delassus, self.free = delassus, free
        self._friction = friction.tolist()
        diagonal = delassus.diagonal().reshape(-1, 3)
        least = TINY * float(np.abs(diagonal).max(initial=0.0)) or 1.0
        self._normal_rate = np.maximum(diagonal[:, 2], least).tolist()
        self._tangent_rate = np.maximum(diagonal[:, 0] + diagonal[:, 1], least).tolist()
        self._scale = scale

    def newton(self, start: np.ndarray) -> tuple[np.ndarray, float]:
        """The best P found from a start, and its residual relative to the accelerations."""
        P = start
        best, least = start, np.inf
        for step in range(MOST_STEPS + 1):
            value, slope = self._at(P)
            residual = float(np.abs(value).max()) / self._scale
            if not residual < np.inf:
                break
            if residual < least:
                best, least = P, residual
            if residual < 1e-14 or step == MOST_STEPS or (step > 8 and least < 1e-12):
                break
            P = P - _solved(slope, value)
        return best, least

    def _at(self, P: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """F(P) [m/s²] and its slope."""
        xi = self.delassus.dot(P) + self.free
        value, slope = xi.copy(), self.delassus.copy()
        for i, mu in enumerate(self._friction):
            at = 3 * i
            n = at + 2
            rate = self._normal_rate[i]
            if rate * P[n] <= xi[n]:
                value[n] = rate * P[n]
                slope[n] = 0.0
                slope[n, n] = rate
            rate = self._tangent_rate[i]
            tangents = slice(at, n)
            aim = P[tangents] - xi[tangents] / rate
            size = float(np.sqrt(aim.dot(aim)))
            bound = mu * max(float(P[n]), 0.0)
            if size <= bound and mu:
                continue
            if not mu or size == 0.0 or not bound:
                value[tangents] = rate * P[tangents]
                slope[tangents] = 0.0
                slope[at, at] = slope[at + 1, at + 1] = rate
                continue
            s = aim / size
            value[tangents] = rate * (P[tangents] - bound * s)
            turn = (np.eye(2) - np.outer(s, s)) * (bound / size)
            rows = turn.dot(slope[tangents])
            rows[:, tangents] += rate * (np.eye(2) - turn)
            rows[:, n] -= rate * mu * s
            slope[tangents] = rows
        return value, slope


def _solved(slope: np.ndarray, value: np.ndarray) -> np.ndarray:
    """The Newton step; the shortest where contacts are redundant."""
    from scipy.linalg.lapack import dgelsy, dgesv

    _, _, step, failed = dgesv(slope, value)
    size = float(np.abs(value).max())
    # A step that is huge comes from a slope that is all but singular.
    large = np.abs(step).max() * np.abs(slope).max() > 1e8 * size
    if not failed and not large and np.abs(slope.dot(step) - value).max() <= 1e-9 * size:
        return step
    n = len(value)
    work = dgelsy(slope, value.reshape(n, 1), np.zeros(n, dtype=np.int32), 1e-10, 8 * n + 64)
    return np.asarray(work[1]).ravel()[:n]
