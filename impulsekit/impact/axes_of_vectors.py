"""Bilateral rows that are axes of one velocity: a short one is judged beside the long ones.

Which axes a constraint is written in is no matter of physics, but rows that are scaled to unit
length one by one depend on it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..laws.rank_tolerances import DEPENDENT_SHARES, FAINT_AXIS, UNEVEN_AXES

__all__ = ["Shares", "faint_axes", "lengths_of_vectors", "shared_evenly"]


class Shares(NamedTuple):
    """Rows that are left out for rounding, as shares of those that are kept.

    Attributes:
        kept, left_out: indices of rows.
        shares: (kept, left_out) of each kept row in each that is left out.
    """

    kept: np.ndarray
    left_out: np.ndarray
    shares: np.ndarray

    def laid_in(self, values: np.ndarray) -> np.ndarray:
        """(..., m) values by row, of the rows left out as the kept ones imply them."""
        laid = values.copy()
        laid[..., self.left_out] = values[..., self.kept].dot(self.shares)
        return laid


def lengths_of_vectors(sizes: np.ndarray, triples: np.ndarray) -> np.ndarray | None:
    """(k,) the longest axis of each row's vector; None where no axis is far shorter."""
    if not len(triples):
        return None
    largest = np.zeros(triples.max() + 1)
    np.maximum.at(largest, triples, sizes)
    shared = largest[triples]
    return shared if (sizes < UNEVEN_AXES * shared).any() else None


def faint_axes(half: np.ndarray, shared: np.ndarray, rank: int) -> Shares | None:
    """Rows that are rounding beside the other axes of the same vector.

    A loop in a plane that is a hair out of line with the axes has a short row across the
    plane. Scaled to unit length by itself, what it says beside the others would count.

    Args:
        half: (nv, k) half-solved rows. shared: (k,) the sizes of their vectors.
        rank: of the rows scaled to unit length.
    """
    import scipy.linalg

    triangle, order = scipy.linalg.qr(half / shared, mode="r", pivoting=True)
    least = int(np.count_nonzero(np.abs(triangle.diagonal()) > FAINT_AXIS))
    if least >= rank:
        return None
    kept, left_out = order[:least], order[least:]
    shares = scipy.linalg.solve_triangular(triangle[:least, :least], triangle[:least, least:])
    return Shares(kept, left_out, shares * shared[left_out] / shared[kept][:, None])


def shared_evenly(
    impulse: np.ndarray, sizes: np.ndarray, shared: np.ndarray, rows: np.ndarray
) -> np.ndarray:
    """(k, ...) impulses with the same effect, of least norm as their vectors are long.

    Args:
        impulse: (k, ...) of the rows. sizes, shared: (k,) lengths of the rows and their vectors.
        rows: (rank, k) what the rows scaled to unit length span.
    """
    null = np.eye(len(sizes)) - rows.T.dot(rows)
    weights = shared / sizes
    shared_now = -(impulse.T * sizes * weights).T
    shift = np.linalg.lstsq(weights[:, None] * null, shared_now, rcond=DEPENDENT_SHARES)[0]
    return impulse + (null.dot(shift).T / sizes).T
