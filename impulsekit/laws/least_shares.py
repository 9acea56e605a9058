"""Redundant impulses: the split that knows no axes.

The P that make given velocities, each within its cone, are a convex set, and Σ w |P|² is least at
one of them alone, w being the mobility of each contact: neither axes, units nor the order of
contacts matter. Under Poisson's law e times the load of the compression comes back, so that v⁺
depends on how redundant contacts shared it. And what redundant contacts can hold still is known
only from all their shares, not from one of them.

With p = √w P and U the range of W so weighted, the least |p|² with Uᵀp = d is
p = proj(U m), proj going to the nearest p allowed; m is where a smooth convex function,
½|U m|² − ½|U m − proj(U m)|² − d·m, is least (its dual). Newton finds it to rounding.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .borrowed import borrowing
from .compiled import compiled, entry
from .dense import gauss
from .modes import NULL, residual_of, sizes_of
from .rank import pivoted_cholesky, range_rows
from .redundant import is_redundant
from .tolerances import BAR, CLEAR
from .words import NO, YES
from .workspace import Sizes, Workspace, workspace

__all__ = ["STILL", "least_holding", "least_split", "share_if_redundant", "share_least"]

# Velocities below this share of all are none.
STILL = 1e-11
# A contact that moves this share of what the lightest does counts as moving that much.
LIGHTEST = 1e-12
# Eigenvalues of W, each contact weighted, below this share of the largest are rounding, and so are
# pivots where the others are above CLEAR.
NO_RANGE = 1e-13
# Newton's steps at most, and halvings of one; what Uᵀp may be off by, relative.
MOST_STEPS, MOST_HALVINGS = 60, 30
SHARED = 1e-15
# What sums of terms that cancel are off by at most, relative to the sum of their sizes.
CANCELLED = 1e-9
# Impulses this many times those that make the velocities, and more, hold nothing: it slips.
HOLDS_NOTHING = 1e6
# How far the dual may rise by rounding, relative to |p|²; the most that its slope is stiffened.
RISEN, STIFFENED = 1e-13, 1e-3
# From step to step it is softened, so that where nothing holds that shows after a few of them.
SOFTER, SOFTEST = 0.3, 1e-8
# By how much the least split may leave more of the law than the split that was found: at an edge
# of cones Newton ends some 1e-13 off, and another split would be another answer by far more.
FITS = 1e-12


class Allowed(NamedTuple):
    """The weighted impulses that go with given velocities, contact by contact.

    Attributes:
        mu: (n,) friction.
        floor: (n,) √w f, the least normal ones.
        touches: (n,) whether more than that is allowed.
        slips: (n,) whether it slips, and P is on a ray.
        ray: (n, 3) that ray, (·, ·, 1).
    """

    mu: np.ndarray
    floor: np.ndarray
    touches: np.ndarray
    slips: np.ndarray
    ray: np.ndarray


@entry(lambda: (workspace(1), 1, 1.0, 0.0, 0.0), seconds=4.0, apart=True)
def share_least(
    work: Workspace, n: int, fastest: float, dependent: float, residual: float
) -> float:
    """Of redundant impulses take the split that knows no axes; the residual.

    Args:
        work: the problem, and P, a solution.
        n: how many contacts.
        fastest: the size of the velocities where they were larger before [m/s].
        dependent: pivots, the diagonal being 1, below which rows depend on each other.
        residual: that of P.
    """
    if not is_redundant(work.W, 3 * n, dependent, NULL):
        return residual
    kept = work.P[: 3 * n].copy()
    shared = least_split(work, n, sizes_of(work, n, fastest))
    if shared <= BAR:
        return shared
    for k in range(3 * n):
        work.P[k] = kept[k]
    return residual


@compiled
def share_if_redundant(
    work: Workspace, n: int, fastest: float, dependent: float, residual: float
) -> float:
    """``share_least``, which is only compiled where impulses are redundant."""
    if not is_redundant(work.W, 3 * n, dependent, NULL):
        return residual
    return share_least(work, n, fastest, dependent, residual)


@compiled
def least_split(work: Workspace, n: int, sizes: Sizes) -> float:
    """Bring P to least Σ w |P|² at the same velocities, where that is found; the residual.

    Args:
        work: the problem, and P, a solution.
        n: how many contacts.
        sizes: what counts as nothing.
    """
    before = residual_of(work, n, sizes)
    roots = _roots(work, n)
    span = _range(_weighted(work, n, roots))
    allowed = _allowed(work, n, sizes, work.xi, roots)
    kept = work.P[: 3 * n].copy()
    weighted = kept * roots
    p = _least(span, allowed, np.dot(span.T, weighted), NO)
    for k in range(3 * n):
        work.P[k] = p[k] / roots[k]
    after = residual_of(work, n, sizes)
    if after <= before + FITS:
        return after
    for k in range(3 * n):
        work.P[k] = kept[k]
    return residual_of(work, n, sizes)


@entry(lambda: (workspace(1), 1, Sizes(1.0, 1.0, 1.0, True)), seconds=3.0, apart=True)
def least_holding(work: Workspace, n: int, sizes: Sizes) -> float:
    """P of least Σ w |P|² in the cones that holds all still, or as near as found; the residual.

    Arguments as those of ``least_split``; P is only written.
    """
    roots = _roots(work, n)
    weighted = _weighted(work, n, roots)
    span = _range(weighted)
    allowed = _allowed(work, n, sizes, np.zeros(3 * n), roots)
    across = np.ascontiguousarray(span.T)
    wanted = -np.dot(across, work.b[: 3 * n] / roots)
    gauss(np.dot(across, np.dot(weighted, span)), len(wanted), wanted)
    p = _least(span, allowed, wanted, YES)
    for k in range(3 * n):
        work.P[k] = p[k] / roots[k]
    return residual_of(work, n, sizes)


@compiled
def _roots(work: Workspace, n: int) -> np.ndarray:
    """(3n,) √w."""
    roots = np.empty(3 * n)
    largest = 0.0
    for i in range(n):
        k = 3 * i
        own = work.W[k, k] + work.W[k + 1, k + 1] + work.W[k + 2, k + 2]
        roots[k] = own
        largest = max(largest, own)
    # Where nothing moves at all, any will do.
    least = LIGHTEST * largest if largest > 0.0 else 1.0
    for i in range(n):
        root = math.sqrt(max(roots[3 * i], least))
        for k in range(3 * i, 3 * i + 3):
            roots[k] = root
    return roots


@compiled
def _range(weighted: np.ndarray) -> np.ndarray:
    """An orthonormal basis (3n, r) of the range of W so weighted, but for rounding.

    By pivots; where these do not tell the rank clearly, by eigenvalues.
    """
    size = len(weighted)
    factor, order = weighted.copy(), np.empty(size, np.int64)
    largest = 0.0
    for k in range(size):
        largest = max(largest, weighted[k, k])
    rank = pivoted_cholesky(factor, size, NO_RANGE * largest, size, order)
    if rank > 0 and factor[rank - 1, rank - 1] ** 2 > CLEAR * largest:
        rows = np.empty((rank, size))
        range_rows(factor, size, rank, order, rows)
        return np.ascontiguousarray(rows.T)
    values, vectors = np.linalg.eigh(weighted)
    first = 0
    while first < size - 1 and not values[first] > NO_RANGE * values[size - 1]:
        first += 1
    return np.ascontiguousarray(vectors[:, first:])


@compiled
def _weighted(work: Workspace, n: int, roots: np.ndarray) -> np.ndarray:
    """(3n, 3n) W / √w √w."""
    size = 3 * n
    weighted = np.empty((size, size))
    for r in range(size):
        for c in range(size):
            weighted[r, c] = work.W[r, c] / (roots[r] * roots[c])
    return weighted


@compiled
def _allowed(
    work: Workspace, n: int, sizes: Sizes, velocity: np.ndarray, roots: np.ndarray
) -> Allowed:
    """What is allowed beside these velocities."""
    still = STILL * sizes.scale
    allowed = Allowed(
        work.mu[:n].copy(),
        np.empty(n),
        np.empty(n, np.bool_),
        np.empty(n, np.bool_),
        np.ones((n, 3)),
    )
    for i in range(n):
        k = 3 * i
        mu = work.mu[i]
        speed = math.sqrt(velocity[k] ** 2 + velocity[k + 1] ** 2)
        allowed.floor[i] = roots[k] * work.floor[i]
        allowed.touches[i] = velocity[k + 2] <= still
        allowed.slips[i] = mu > 0.0 and speed > still
        if allowed.slips[i]:
            allowed.ray[i, 0] = -mu * velocity[k] / speed
            allowed.ray[i, 1] = -mu * velocity[k + 1] / speed
    return allowed


@compiled
def _least(span: np.ndarray, allowed: Allowed, wanted: np.ndarray, may_fail: bool) -> np.ndarray:
    """The least of the allowed p with Uᵀp as wanted; the best one tried where it is not found.

    Args:
        span: (3n, m) U.
        allowed: the impulses that may be taken.
        wanted: (m,) d.
        may_fail: whether there may be none, which ends the search where it shows.
    """
    rows, m = span.shape
    place, step, across = wanted.copy(), np.zeros(m), np.ascontiguousarray(span.T)
    pull, off = np.dot(span, place), np.zeros(m)
    best: np.ndarray = pull.copy()
    near = np.empty(rows)
    slope, moved, matrix = np.empty((rows, 3)), np.empty((rows, m)), np.empty((m, m))
    least, last, height = math.inf, math.inf, math.inf
    stiffened = STIFFENED
    cones = allowed.floor.max() == 0.0
    for _ in range(MOST_STEPS):
        error, now, size = 0.0, 0.0, 0.0
        for _ in range(MOST_HALVINGS):
            pull = np.dot(span, place)
            _go_to_nearest(allowed, pull, near, slope)
            off = np.dot(across, near) - wanted
            error, now, size = 0.0, 0.0, 0.0
            for k in range(m):
                error = max(error, abs(off[k]))
                now -= wanted[k] * place[k]
            for k in range(rows):
                now += near[k] * (pull[k] - 0.5 * near[k])
                size = max(size, abs(near[k]))
            # Where the dual differs by its rounding, its slope tells.
            if now < height or (now <= height + RISEN * size * size and error < last):
                break
            for k in range(m):
                step[k] *= 0.5
                place[k] -= step[k]
        height, last = now, error
        if error < least:
            least = error
            for k in range(rows):
                best[k] = near[k]
        if not SHARED * size < error < math.inf:
            break
        for k in range(rows):
            first = k - k % 3
            for c in range(m):
                total = 0.0
                for j in range(3):
                    total += slope[k, j] * span[first + j, c]
                moved[k, c] = total
        matrix = np.dot(across, moved)
        for k in range(m):
            matrix[k, k] += min(error / size, stiffened) if size > 0.0 else stiffened
            step[k] = -off[k]
        if not gauss(matrix, m, step) or (may_fail and _leads_away(span, allowed, wanted, step)):
            break
        if may_fail and cones:
            stiffened = max(SOFTER * stiffened, SOFTEST)
        for k in range(m):
            place[k] += step[k]
    return best


@compiled
def _leads_away(span: np.ndarray, allowed: Allowed, wanted: np.ndarray, step: np.ndarray) -> bool:
    """Whether a step of the dual shows that no allowed p is within HOLDS_NOTHING |(d, f)|, Uᵀp = d.

    With g = U m, d·m = p·g ≤ |p| |proj(g)| + Σ f min(0, g_n + µ|g_t|) for every p in the cones
    above their floors f, and every m.
    """
    pull = np.dot(span, step)
    along, summed, size, left = 0.0, 0.0, 0.0, 0.0
    for k in range(len(wanted)):
        along += wanted[k] * step[k]
        summed += abs(wanted[k] * step[k])
        size += wanted[k] * wanted[k]
    for i in range(len(allowed.mu)):
        k, mu = 3 * i, allowed.mu[i]
        size += allowed.floor[i] ** 2
        across, normal = math.sqrt(pull[k] ** 2 + pull[k + 1] ** 2), pull[k + 2]
        raised = normal + mu * across
        if raised <= 0.0:
            along -= allowed.floor[i] * raised
            summed -= allowed.floor[i] * raised
        elif across <= mu * normal:
            left += across * across + normal * normal
        else:
            left += raised * raised / (1.0 + mu * mu)
    return along > HOLDS_NOTHING * math.sqrt(size * left) + CANCELLED * summed


@borrowing
def _go_to_nearest(allowed: Allowed, pull: np.ndarray, near: np.ndarray, slope: np.ndarray) -> None:
    """The allowed impulse nearest to one, (3n,), and how it moves with it, (3n, 3) by contact.

    On its ray where a contact slips, else within its cone; no less than its floor.
    """
    for i in range(len(allowed.mu)):
        k = 3 * i
        mu, floor = allowed.mu[i], allowed.floor[i]
        for r in range(k, k + 3):
            for c in range(3):
                slope[r, c] = 0.0
        if allowed.slips[i]:
            ray = allowed.ray[i]
            square = ray[0] ** 2 + ray[1] ** 2 + ray[2] ** 2
            normal = (pull[k] * ray[0] + pull[k + 1] * ray[1] + pull[k + 2] * ray[2]) / square
            if allowed.touches[i] and normal > floor:
                for r in range(3):
                    for c in range(3):
                        slope[k + r, c] = ray[r] * ray[c] / square
            else:
                normal = floor
            for r in range(3):
                near[k + r] = normal * ray[r]
            continue
        size = math.sqrt(pull[k] ** 2 + pull[k + 1] ** 2)
        c1, c2 = 0.0, 0.0
        if size > 0.0:
            c1, c2 = pull[k] / size, pull[k + 1] / size
        inside = size <= mu * pull[k + 2]
        normal = pull[k + 2] if inside else (pull[k + 2] + mu * size) / (1.0 + mu * mu)
        pressed = allowed.touches[i] and normal > floor
        if pressed and inside:
            near[k], near[k + 1], near[k + 2] = pull[k], pull[k + 1], pull[k + 2]
            slope[k, 0], slope[k + 1, 1], slope[k + 2, 2] = 1.0, 1.0, 1.0
            continue
        if not pressed:
            normal = floor
            if size <= mu * normal:
                near[k], near[k + 1], near[k + 2] = pull[k], pull[k + 1], normal
                slope[k, 0], slope[k + 1, 1] = 1.0, 1.0
                continue
        # On the edge of the cone: it moves along the edge, and turns with what pulls.
        along = 1.0 / (1.0 + mu * mu) if pressed else 0.0
        turns = mu * normal / size if size > 0.0 else 0.0
        slope[k, 0] = along * mu * mu * c1 * c1 + turns * c2 * c2
        slope[k, 1] = (along * mu * mu - turns) * c1 * c2
        slope[k + 1, 0] = slope[k, 1]
        slope[k + 1, 1] = along * mu * mu * c2 * c2 + turns * c1 * c1
        slope[k, 2], slope[k + 1, 2] = along * mu * c1, along * mu * c2
        slope[k + 2, 0], slope[k + 2, 1], slope[k + 2, 2] = slope[k, 2], slope[k + 1, 2], along
        near[k], near[k + 1], near[k + 2] = normal * mu * c1, normal * mu * c2, normal
