"""W λ = r for bilateral rows, redundant and contradictory ones included.

W = A M⁻¹ Aᵀ = Cᵀ C is the Delassus matrix. Its rank is judged as if its rows were scaled
to unit diagonal, so that neither units nor the scale a row was written in decide.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import ContradictionError

__all__ = ["BilateralSolution", "solve_bilateral"]

# A row is dependent if, scaled to unit length in the metric of M⁻¹, it stands less than
# this (rad) out of the span of the others. Loops closed by hand are off by about as much.
RANK_TOLERANCE = 1e-7
# Dependent rows leave this much of singular values by rounding; more is not rounding.
EXACT_RANK = 1e-14
# Pivots of the scaled W above this need no closer look.
SAFE_PIVOT = 1e-6
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
    from scipy.linalg.lapack import dpotrf, dpotrs

    delassus = half.T.dot(half)
    # Cholesky does not feel how rows are scaled, so only its pivots are compared scaled.
    factor, failed = dpotrf(delassus, lower=1)
    if not failed:
        roots = factor.diagonal()
        if (roots * roots > SAFE_PIVOT * delassus.diagonal()).all():
            impulse, _ = dpotrs(factor, right, lower=1)
            return BilateralSolution(impulse, len(right), None)
    return _solve_dependent(half, right, magnitude, velocity_scale, names)


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
    scale = np.zeros_like(diagonal)
    scale[live] = 1.0 / np.sqrt(diagonal[live])
    speeds = None if velocity_scale is None else velocity_scale() + np.abs(right)
    # A row of no effect cannot change its velocity.
    _refuse(np.where(live, 0.0, np.abs(right)), speeds, names)
    _, values, right_vectors = np.linalg.svd((half * scale)[:, live], full_matrices=False)
    rank = int((values > RANK_TOLERANCE).sum())
    nearly |= bool((values[rank:] > EXACT_RANK * len(values)).any())
    basis = right_vectors[:rank].T
    wanted = scale[live] * right[live]
    share = basis.T @ wanted
    unmet = np.zeros_like(right)
    unmet[live] = np.abs(wanted - basis @ share) / scale[live]
    _refuse(unmet, speeds, names)
    impulse = np.zeros_like(right)
    impulse[live] = scale[live] * (basis @ (share / values[:rank] ** 2))
    unique = np.zeros(len(right), dtype=bool)
    # A row is determined if no direction of the null space moves it.
    unique[live] = (basis**2).sum(axis=1) > 1.0 - 1e-9
    return BilateralSolution(impulse, rank, unique, nearly)


def _refuse(unmet: np.ndarray, speeds: np.ndarray | None, names: Sequence[str]) -> None:
    if speeds is None:
        return
    size = speeds.max(initial=0.0)
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
