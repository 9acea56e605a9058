"""Several contacts of a system whose mass matrix is factored, in one compiled call.

With C = D^-½ U⁻¹ Jᵀ the Delassus matrix is W = Cᵀ C; the law gives P from it, and
Δv = M⁻¹ JᵀP. The difference of J Δv and W P is a measure of rounding errors.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .at_once import hit_contacts
from .borrowed import borrowing
from .compiled import compiled, entry
from .half import delassus_of, factor_of, halve, solve_mass
from .rank_tolerances import FAINT_ROW
from .sharpening import sharpen
from .status import Status
from .tolerances import ROUNDING, ROUNDING_OF_SUMS
from .words import AGAIN, NEWTON

__all__ = [
    "PlainTogether", "Together", "examples", "is_faint", "is_sound", "posed", "strike_at_once",
    "write_jump",
]  # fmt: skip

_SOLVED, _NOT_UNIQUE = int(Status.SOLVED), int(Status.NOT_UNIQUE)


class Together(NamedTuple):
    """What several contacts did to a system.

    Attributes:
        code: of the ``Status``; AGAIN where the general algorithm has to solve.
        residual: how far it is from the law, relative.
        off, fastest: the largest entries of J Δv − W P, and of u⁻ and u⁺ [m/s].
        hits: of a sequence; 0 at once.
        tied: whether the order of the contacts decided which is hit first.
        jump: (nv,) Δv.
        points: (3, 3n) P [N s], u⁺ and u⁻ [m/s].
        works: (3, n) of normals and friction [J]; 1 where no other contact could carry what
            this one carries, else 0.
    """

    code: int
    residual: float
    off: float
    fastest: float
    hits: int
    tied: bool
    jump: np.ndarray
    points: np.ndarray
    works: np.ndarray


PlainTogether = tuple[
    int, float, float, float, int, bool, np.ndarray, np.ndarray, np.ndarray
]  # fmt: skip


def examples() -> tuple[object, ...]:
    """Arguments of ``strike_at_once``."""
    return np.eye(3), np.ones(3), np.ones((6, 3)), np.ones(3), np.ones((3, 2)), NEWTON


@entry(examples, seconds=2.0)
def strike_at_once(
    lower: np.ndarray,
    pivots: np.ndarray,
    rows: np.ndarray,
    v: np.ndarray,
    coefficients: np.ndarray,
    restitution: int,
) -> PlainTogether:
    """All contacts at once, slip at the end: the fields of a ``Together``.

    Args:
        lower, pivots: (nv, nv) Uᵀ and (nv,) D of M = U D Uᵀ.
        rows: (3n, nv) J.
        v: (nv,) v⁻.
        coefficients: (3, n) µ, e and tangential restitution.
        restitution: NEWTON or POISSON.
    """
    n = coefficients.shape[1]
    W, before = posed(lower, pivots, rows, v)
    points, works, jump = np.empty((3, 3 * n)), np.empty((3, n)), np.empty(len(v))
    mu, e, e_t = coefficients[0], coefficients[1], coefficients[2]
    if not is_sound(W, before, rows, mu):
        return AGAIN, 0.0, 0.0, 0.0, 0, False, jump, points, works
    code, residual, impulse, after, normal, friction, unique = hit_contacts(
        W, before, before, mu, e, e_t, restitution
    )
    points[0], points[1], points[2] = impulse[: 3 * n], after[: 3 * n], before
    off, fastest = write_jump(lower, pivots, rows, points, jump)
    sure = code in (_SOLVED, _NOT_UNIQUE) and restitution == NEWTON
    if sure and residual > ROUNDING and off <= ROUNDING_OF_SUMS * fastest:
        residual = sharpen(lower, pivots, rows, W, coefficients, points, jump)
        for i in range(n):
            normal[i], friction[i] = 0.0, 0.0
            for k in range(3 * i, 3 * i + 3):
                own = 0.5 * points[0, k] * (points[2, k] + points[1, k])
                normal[i] += own if k == 3 * i + 2 else 0.0
                friction[i] += own if k < 3 * i + 2 else 0.0
    for i in range(n):
        works[0, i], works[1, i], works[2, i] = normal[i], friction[i], unique[i]
    return code, residual, off, fastest, 0, False, jump, points, works


@compiled
def posed(
    lower: np.ndarray, pivots: np.ndarray, rows: np.ndarray, v: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(3n, 3n) W and (3n,) u⁻."""
    factor, half = factor_of(lower, pivots), rows.copy()
    size, nv = rows.shape
    before = np.zeros(size)
    for r in range(size):
        for k in range(nv):
            before[r] += rows[r, k] * v[k]
        halve(factor, half[r])
    return delassus_of(half), before


@borrowing
def is_faint(rows: np.ndarray, i: int, mu: float) -> bool:
    """Whether the normal's row of contact i, or both tangents', may be zero but for rounding."""
    slip = normal = 0.0
    for k in range(rows.shape[1]):
        slip += rows[3 * i, k] ** 2 + rows[3 * i + 1, k] ** 2
        normal += rows[3 * i + 2, k] ** 2
    return 0.0 < normal <= FAINT_ROW or (mu > 0.0 and 0.0 < slip <= FAINT_ROW)


@borrowing
def is_sound(W: np.ndarray, before: np.ndarray, rows: np.ndarray, mu: np.ndarray) -> bool:
    """Whether all numbers are finite, impulses move something, and rows are no rounding."""
    for i in range(len(mu)):
        if is_faint(rows, i, mu[i]):
            return False
    total = 0.0
    for r in range(len(before)):
        total += abs(before[r])
        for c in range(len(before)):
            total += abs(W[r, c])
    return W[0, 0] > 0.0 and total < np.inf


@compiled
def write_jump(
    lower: np.ndarray, pivots: np.ndarray, rows: np.ndarray, points: np.ndarray, jump: np.ndarray
) -> tuple[float, float]:
    """Write Δv; how far J Δv is from W P at most, and the largest velocity [m/s]."""
    impulse, after, before = points[0], points[1], points[2]
    size, nv = rows.shape
    jump[:] = 0.0
    for r in range(size):
        for k in range(nv):
            jump[k] += rows[r, k] * impulse[r]
    solve_mass(factor_of(lower, pivots), jump)
    off, fastest = 0.0, 0.0
    for r in range(size):
        moved = before[r]
        for k in range(nv):
            moved += rows[r, k] * jump[k]
        off = max(off, abs(moved - after[r]))
        fastest = max(fastest, abs(moved), abs(before[r]))
    return off, fastest
