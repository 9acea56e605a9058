"""Coulomb's law for forces and accelerations at resting contacts, solved to rounding.

With accelerations for velocities it is the law of ``impact.laws.frictional``:
0 ≤ P_n ⊥ ξ_n ≥ 0, |P_t| ≤ µ P_n, P_t = −µ P_n ξ_t/|ξ_t| where ξ_t ≠ 0, ξ = W P + b. W need
not be symmetric: a contact that slides is given as one without friction whose column of W
holds the friction that goes with its normal force. Newton on the natural map (Alart &
Curnier 1991) from the last solution; contact after contact where that does not get there.

Where rows depend on each other (four corners on a floor) many P do, and with sliding each
moves the body otherwise. Every point then gives way a little, by ε D P with D the diagonal
of W, as if it stood on a stiff spring: that has one solution, which changes smoothly with
the state. The springs are taken out again by moving them towards the body: with
b − ε D P of the last round for b (Rockafellar 1976, the proximal point method) from P = 0
what remains is their load split, the accelerations are those of rigid points.

Two points that stick to a floor are rigid to each other only if the line between them does not
turn. Speeds that count as zero leave it turning a little, and what b asks at the two contradicts
itself by the square of that. Such a part of b, off the span of W, is left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

__all__ = ["RestNotSolved", "solve_rest"]

# What the residual has to come down to, relative to the accelerations.
BAR = 1e-9
MOST_STEPS = 25
MOST_SWEEPS = 20
TINY = 1e-14
# How much points give way where they depend on each other, relative to D. Rounding in W shows
# in the split of loads enlarged by 1/ε, and what b asks along rows of size ε takes its rounds.
GIVE = 1e-5
MOST_ROUNDS = 12
# The accelerations that springs may leave, relative to those without contact forces.
GIVEN = 1e-13
# What b may contradict itself by, relative: speeds of at most the capture speed, squared, over
# the size of a body and gravity. 1e-2 m/s at 0.1 m is 1e-4 of it.
CONTRADICTION = 1e-4
# Eigenvalues of W this small beside the largest are zero where else there is no answer: of rows
# that differ by the root of it, as the stages of a step turn an edge against another.
NULL = 1e-10
# Rounds that shrink what springs leave by less than this meet a contradiction, or points at the
# edge of their cones, which take up a load slowly.
STUCK = 0.5
# A row whose part across those before it is smaller, in squares, depends on them.
DEPENDENT = 1e-3


class RestNotSolved(Exception):
    """No forces found. Internal: a motion ends with a status instead."""


def solve_rest(
    delassus: np.ndarray,
    free: np.ndarray,
    friction: np.ndarray,
    start: np.ndarray,
    ways: np.ndarray | None = None,
) -> np.ndarray:
    """(3n,) contact forces P [N], two tangents and the normal of each contact.

    Args:
        delassus: (3n, 3n) W [1/kg].
        free: (3n,) b, the accelerations without contact forces [m/s²].
        friction: (n,) µ; 0 for what slides.
        start: (3n,) the forces to start from.
        ways: (3n, 3n) contact forces from P where something slides: W times it is what counts.

    Raises:
        RestNotSolved: there are none, or they were not found.
    """
    scale = float(np.abs(free).max(initial=0.0))
    if not scale > 0.0:
        return np.zeros_like(free)
    used = np.repeat(friction > 0.0, 3)
    used[2::3] = True
    coupled = delassus if ways is None else delassus.dot(ways)
    if used.all():
        return _solve(coupled, delassus, free, friction, start, scale)
    # Tangents without friction carry nothing: they are left out.
    forces = np.zeros_like(free)
    few = np.ix_(used, used)
    forces[used] = _solve(coupled[few], delassus[few], free[used], friction, start[used], scale)
    return forces


def _solve(
    coupled: np.ndarray,
    delassus: np.ndarray,
    free: np.ndarray,
    friction: np.ndarray,
    start: np.ndarray,
    scale: float,
) -> np.ndarray:
    """(m,) forces: of points with friction two tangents and the normal, of others the normal."""
    if _depend(delassus):
        sizes = delassus.diagonal()
        found, settled = _shared(coupled, sizes, free, friction, start, scale)
        if not settled and (spanned := _spanned(delassus, coupled, free, scale)) is not None:
            start = start if found is None else found
            found, settled = _shared(spanned[0], sizes, spanned[1], friction, start, scale)
            if found is not None and not settled:
                # Near enough: from here to rigid points.
                found, residual = _found(spanned[0], sizes, spanned[1], friction, found, scale)
                settled = residual <= BAR
        if found is not None and settled:
            return found
    best, residual = _found(coupled, delassus.diagonal(), free, friction, start, scale)
    if not residual <= BAR:
        raise RestNotSolved(f"residual {residual:.1e}")
    return best


def _depend(delassus: np.ndarray) -> bool:
    """Whether rows depend on each other, or all but."""
    from scipy.linalg.lapack import dpotrf

    factor, failed = dpotrf(delassus, lower=1)
    own = factor.diagonal() ** 2
    return bool(failed or (own < DEPENDENT * delassus.diagonal()).any())


def _spanned(
    delassus: np.ndarray, coupled: np.ndarray, free: np.ndarray, scale: float
) -> tuple[np.ndarray, np.ndarray] | None:
    """W and b without what lies off the span of W; None where that is no small part of b."""
    values, vectors = np.linalg.eigh(delassus)
    null = vectors[:, values <= NULL * values[-1]]
    off = null.dot(null.T.dot(free))
    if not np.abs(off).max() <= CONTRADICTION * scale:
        return None
    return coupled - null.dot(null.T.dot(coupled)), free - off


def _shared(
    delassus: np.ndarray,
    sizes: np.ndarray,
    free: np.ndarray,
    friction: np.ndarray,
    start: np.ndarray,
    scale: float,
) -> tuple[np.ndarray | None, bool]:
    """(m,) forces shared as by stiff springs, None where there are none; whether they settled."""
    give = GIVE * np.maximum(sizes, TINY * sizes.max(initial=0.0))
    soft = delassus + np.diag(give)
    forces, left = np.zeros_like(free), math.inf
    for _ in range(MOST_ROUNDS):
        before, last = forces, left
        # A residual that counts for rigid points as well.
        forces, residual = _found(soft, sizes, free - give * before, friction, start, scale)
        if not residual <= BAR:
            return None, False
        left = float(np.abs(give * (forces - before)).max())
        if left <= GIVEN * scale:
            return forces, True
        if left > STUCK * last:
            break
        start = forces
    return forces, left <= BAR * scale


def _found(
    delassus: np.ndarray,
    sizes: np.ndarray,
    free: np.ndarray,
    friction: np.ndarray,
    start: np.ndarray,
    scale: float,
) -> tuple[np.ndarray, float]:
    """(m,) the best forces, and their residual relative to the accelerations."""
    problem = _NaturalMap(delassus, sizes, free, friction, scale)
    best, residual = problem.newton(start)
    if residual > BAR and start.any():
        other, error = problem.newton(np.zeros_like(start))
        if error < residual:
            best, residual = other, error
    if residual > BAR:
        for impulse in _swept(delassus, free, friction, scale):
            best, residual = problem.newton(impulse)
            if residual <= BAR:
                break
    return best, residual


def _swept(
    delassus: np.ndarray, free: np.ndarray, friction: np.ndarray, scale: float
) -> Iterator[np.ndarray]:
    """(m,) forces that contact after contact gives, ever nearer."""
    from ..impact.laws.gauss_seidel import sweep

    used = np.repeat(friction > 0.0, 3)
    used[2::3] = True
    whole, whole_free = np.zeros((len(used), len(used))), np.zeros(len(used))
    whole[np.ix_(used, used)], whole_free[used] = delassus, free
    impulse = np.zeros(len(used))
    for _ in range(MOST_SWEEPS):
        impulse, _ = sweep(whole, whole_free, friction, None, impulse, scale)
        yield impulse[used]


class _NaturalMap:
    """F(P) = 0, and Newton on it."""

    def __init__(
        self,
        delassus: np.ndarray,
        sizes: np.ndarray,
        free: np.ndarray,
        friction: np.ndarray,
        scale: float,
    ) -> None:
        self._delassus, self._free, self._scale = delassus, free, scale
        # Without friction's part, which may turn the sign of a diagonal (Painlevé).
        diagonal = sizes.tolist()
        least = TINY * max(map(abs, diagonal), default=0.0) or 1.0
        # By point: its first row, its normal's, µ, and the rates of normal and tangents.
        self._points: list[tuple[int, int, float, float, float]] = []
        at = 0
        for mu in friction.tolist():
            n = at + 2 if mu else at
            along = diagonal[at] + diagonal[at + 1] if mu else 0.0
            self._points.append((at, n, mu, max(diagonal[n], least), max(along, least)))
            at = n + 1

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
        value, slope = self._delassus.dot(P) + self._free, self._delassus
        # Plain numbers: most points stick or push, and have nothing to change.
        p, xi = P.tolist(), value.tolist()
        for at, n, mu, rate, tangent_rate in self._points:
            parts = rate * p[n] <= xi[n]
            slips = False
            if mu:
                aim = [p[k] - xi[k] / tangent_rate for k in (at, at + 1)]
                size, bound = math.hypot(*aim), mu * max(p[n], 0.0)
                slips = not size <= bound
            if (parts or slips) and slope is self._delassus:
                slope = slope.copy()
            if parts:
                value[n] = rate * p[n]
                slope[n] = 0.0
                slope[n, n] = rate
            if slips:
                self._slip(value, slope, P, at, aim, size, bound, mu, tangent_rate)
        return value, slope

    @staticmethod
    def _slip(
        value: np.ndarray,
        slope: np.ndarray,
        P: np.ndarray,
        at: int,
        aim: list[float],
        size: float,
        bound: float,
        mu: float,
        rate: float,
    ) -> None:
        """The tangents of a point that sticks no more: P_t = bound · aim/|aim|."""
        tangents, n = slice(at, at + 2), at + 2
        if not bound:
            value[tangents] = rate * P[tangents]
            slope[tangents] = 0.0
            slope[at, at] = slope[at + 1, at + 1] = rate
            return
        s = np.array(aim) / size
        value[tangents] = rate * (P[tangents] - bound * s)
        turn = (np.eye(2) - np.outer(s, s)) * (bound / size)
        rows = turn.dot(slope[tangents])
        rows[:, tangents] += rate * (np.eye(2) - turn)
        rows[:, n] -= rate * mu * s
        slope[tangents] = rows


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
