"""W λ = r for bilateral rows, redundant and contradictory ones included.

W = A M⁻¹ Aᵀ = Cᵀ C is the Delassus matrix. Its rank is judged as if its rows were scaled
to unit diagonal, so that neither units nor the scale a row was written in decide.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import ContradictionError
from . import lapack

__all__ = ["BilateralSolution", "solve_bilateral"]

# A row is dependent if, scaled to unit length in the metric of M⁻¹, it stands less than
# this (rad) out of the span of the others. Loops closed by hand are off by about as much.
RANK_TOLERANCE = 1e-7
# Dependent rows leave this much of singular values by rounding; more is not rounding.
EXACT_RANK = 1e-14
# Pivots of the scaled W above this need no closer look.
SAFE_PIVOT = 1e-6
# Rows whose squares differ by less than this are no rounding of each other.
COMPARABLE = 1e-9
# What dependent rows may disagree by, relative to the velocities they speak of.
CONTRADICTION_TOLERANCE = 1e-6
# A row whose square is this much smaller than that of its terms is a zero.
NULL_ROW = 1e-22
EXACT_NULL_ROW = 1e-27


@dataclass(frozen=True, eq=False)
class BilateralSolution:
    """The impulses of bilateral rows.

    Attributes:
        impulse: (m,) λ; the one of least scaled norm where rows are redundant.
        rank: how many rows are independent.
        unique: (m,) whether a row's impulse is determined; None where all are.
        nearly: whether rows were taken for dependent that are so only within the tolerance.
    """

    impulse: np.ndarray
    rank: int
    unique: np.ndarray | None
    nearly: bool = False


def solve_bilateral(
    half: np.ndarray,
    right: np.ndarray,
    magnitude: Callable[[], np.ndarray],
    velocity_scale: Callable[[], np.ndarray] | None,
    names: Sequence[str],
) -> BilateralSolution:
    """λ with W λ = r.

    Args:
        half: (nv, m) C, the half-solved rows: W = Cᵀ C.
        right: (m,) r, the wanted change of the rows' velocities.
        magnitude: called only if rows look dependent; (m,) the diagonal that W would
            have without cancellation.
        velocity_scale: called only then; (m,) the size of the velocities in each row. None:
            what dependent rows disagree by is rounding, and left.
        names: of the rows, for errors.

    Raises:
        ContradictionError: dependent rows demand different things.
    """
    delassus = half.T.dot(half)
    impulse = _regular(delassus, right)
    if impulse is not None:
        return BilateralSolution(impulse, len(right), None)
    solution = _without_still_rows(delassus, right)
    if solution is not None:
        return solution
    return _solve_dependent(half, right, magnitude, velocity_scale, names)


def _regular(delassus: np.ndarray, right: np.ndarray) -> np.ndarray | None:
    """(m,) λ, or None where rows may be dependent."""
    # Cholesky does not feel how rows are scaled, so only its pivots are compared scaled.
    factor, failed = lapack.dpotrf(delassus, lower=1)
    if failed:
        return None
    roots, least = factor.diagonal(), SAFE_PIVOT * delassus.diagonal()
    # Without an array of truths, which costs more than its few entries.
    if not all(map(operator.gt, (roots * roots).tolist(), least.tolist())):
        return None
    return lapack.dpotrs(factor, right, lower=1)[0]


def _without_still_rows(delassus: np.ndarray, right: np.ndarray) -> BilateralSolution | None:
    """λ where some rows are zeros, as those across a plane are, and the others regular.

    None where it takes a closer look.
    """
    squares = delassus.diagonal().tolist()
    moving = [i for i, square in enumerate(squares) if square]
    least = COMPARABLE * max(squares, default=0.0)
    if len(moving) in (0, len(squares)) or any(squares[i] < least for i in moving):
        return None
    # A row of no effect cannot change its velocity.
    if any(change for change, square in zip(right.tolist(), squares, strict=True) if not square):
        return None
    found = _regular(delassus[moving][:, moving], right[moving])
    if found is None:
        return None
    impulse = np.zeros(len(squares))
    impulse[moving] = found
    unique = np.zeros(len(squares), dtype=bool)
    unique[moving] = True
    return BilateralSolution(impulse, len(moving), unique)


def _solve_dependent(
    half: np.ndarray,
    right: np.ndarray,
    magnitude: Callable[[], np.ndarray],
    velocity_scale: Callable[[], np.ndarray] | None,
    names: Sequence[str],
) -> BilateralSolution:
    """The same by singular values, with rows of no effect set aside."""
    diagonal = np.einsum("ij,ij->j", half, half)
    gross = magnitude()
    live = diagonal > NULL_ROW * gross
    nearly = bool((diagonal[~live] > EXACT_NULL_ROW * gross[~live]).any())
    sizes = np.sqrt(diagonal[live])
    # A row of no effect cannot change its velocity.
    unmet = np.where(live, 0.0, np.abs(right))
    _refuse(unmet, right, velocity_scale, names)
    values, rows = _singular_values(half[:, live] / sizes)
    rank = int(np.count_nonzero(values > RANK_TOLERANCE))
    nearly = nearly or bool((values[rank:] > EXACT_RANK * len(values)).any())
    basis = rows[:rank]
    wanted = right[live] / sizes
    share = basis.dot(wanted)
    unmet[live] = np.abs(wanted - share.dot(basis)) * sizes
    _refuse(unmet, right, velocity_scale, names)
    impulse = np.zeros_like(right)
    impulse[live] = (share / values[:rank] ** 2).dot(basis) / sizes
    unique = np.zeros(len(right), dtype=bool)
    # A row is determined if no direction of the null space moves it.
    unique[live] = np.einsum("ij,ij->j", basis, basis) > 1.0 - 1e-9
    return BilateralSolution(impulse, rank, unique, nearly)


def _singular_values(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(k,) singular values, largest first, and (k, m) the vectors of the rows' space."""
    if not matrix.size:
        return np.empty(0), np.empty((0, matrix.shape[1]))
    # By LAPACK itself: on matrices as small as these, numpy's way to it takes as long again.
    _, values, rows, failed = lapack.dgesdd(matrix, full_matrices=0)
    if failed:
        _, values, rows = np.linalg.svd(matrix, full_matrices=False)
    return values, rows


def _refuse(
    unmet: np.ndarray,
    right: np.ndarray,
    velocity_scale: Callable[[], np.ndarray] | None,
    names: Sequence[str],
) -> None:
    """Tell of rows that lack more than rounding of the velocities they speak of.

    Raises:
        ContradictionError: it names them.
    """
    gross = np.abs(right)
    # Most are met to rounding of what they want alone.
    if velocity_scale is None or unmet.max(initial=0.0) <= (
        CONTRADICTION_TOLERANCE * gross.max(initial=0.0)
    ):
        return
    size = (velocity_scale() + gross).max()
    wrong = unmet > CONTRADICTION_TOLERANCE * size
    if not wrong.any():
        return
    worst = [names[i] for i in np.flatnonzero(unmet > 0.1 * unmet.max()).tolist()]
    named = ", ".join(worst[:6]) + (", …" if len(worst) > 6 else "")
    raise ContradictionError(
        f"these rows cannot hold together: {named}; they are dependent and their velocities "
        f"after the impact are {unmet.max():.3g} apart. Leave one out, or prescribe velocities "
        "that agree",
        rows=tuple(worst),
    )
