"""Rows of contacts that are zero but for rounding.

A contact that cannot move along its normal carries nothing: a point on the axis of a hinge against
the other link, a normal across the slide between two links, a rope to the middle of a joint. Of its
row nothing is left but the rounding of the places whose difference it is; an impulse from such a
row would be rounding over its square.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
import pinocchio as pin

from ..laws.rank_tolerances import EXACT_RANK, FAINT_ROW
from .pair import ends_at, sizes_of_terms

__all__ = ["cleared", "farthest", "rows_at", "turning_rows"]


def cleared(rows: np.ndarray, sizes: Callable[[], np.ndarray], *, rubs: bool = True) -> np.ndarray:
    """(3, nv) the rows of a contact; the normal, or both tangents, zero if they are rounding.

    Args:
        rows: tangents and normal, or their turning.
        sizes: called only where rows are small; (3, nv) what they are differences of.
        rubs: whether the tangents matter.
    """
    squares = rows.dot(rows.T)
    slip = squares.item(0) + squares.item(4) if rubs else 0.0
    if not (0.0 < squares.item(8) <= FAINT_ROW or 0.0 < slip <= FAINT_ROW):
        return rows
    faint = (np.abs(rows) <= EXACT_RANK * sizes()).all(axis=1)
    return np.where(faint[:, None], 0.0, rows)


def farthest(
    model: pin.Model, data: pin.Data, joint_ids: Iterable[int], points: Iterable[np.ndarray]
) -> float:
    """How far points and all joints that move them are from the origin at most [m].

    ``data`` with placements of joints.
    """
    movers = {joint_id for end in joint_ids for joint_id in model.supports[end]}
    places = *points, *(data.oMi[joint_id].translation for joint_id in movers)
    return max(float(np.abs(place).max()) for place in places)


def rows_at(
    model: pin.Model,
    data: pin.Data,
    joint_ids: tuple[int, int],
    point: np.ndarray,
    axes: np.ndarray,
) -> np.ndarray:
    """(3, nv) Rᵀ (J_first − J_other) at a point of the world; ``data`` with joint Jacobians."""
    first, other = ends_at(model, data, joint_ids, point)

    def sizes() -> np.ndarray:
        arm = farthest(model, data, joint_ids, [point])
        return sizes_of_terms(first, other, arm)[:3]

    return cleared(axes.T.dot(first[:3] - other[:3]), sizes)


def turning_rows(
    model: pin.Model, data: pin.Data, joint_ids: tuple[int, int], axes: np.ndarray
) -> np.ndarray:
    """(3, nv) Rᵀ (ω_first − ω_other) of two bodies; ``data`` with joint Jacobians."""
    first, other = ends_at(model, data, joint_ids, np.zeros(3))
    rows = axes.T.dot(first[3:] - other[3:])
    return cleared(rows, lambda: sizes_of_terms(first, other, 0.0)[3:])
