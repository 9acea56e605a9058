"""What bilateral rows span: the decision of rank by singular values, where it is not plain.

Rows are judged as if they were of unit length, so that neither units nor the scale a row was
written in decide.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..laws.rank_tolerances import EXACT_RANK, RANK_TOLERANCE
from . import lapack
from .axes_of_vectors import Shares, faint_axes, lengths_of_vectors

__all__ = ["Span", "span_of"]


class Span(NamedTuple):
    """What rows span, scaled to unit length: the one decision of rank.

    Attributes:
        live: (m,) False for rows of no effect.
        sizes: of the live ones.
        basis: (nv, rank) orthonormal.
        values, rows: (rank,) singular values and (rank, live) the vectors of the rows' space.
        nearly: whether anything was left out that is more than rounding.
        faint: live rows that are left out beside others of the same vector; None without any.
        shared: (live,) the sizes of the rows' vectors, where dependent rows differ from them.
    """

    live: np.ndarray
    sizes: np.ndarray
    basis: np.ndarray
    values: np.ndarray
    rows: np.ndarray
    nearly: bool
    faint: Shares | None
    shared: np.ndarray | None


def span_of(
    half: np.ndarray, live: np.ndarray, squares: np.ndarray, triples: np.ndarray, nearly: bool
) -> Span:
    """What half-solved rows (nv, live) span.

    Args:
        half: of the live rows alone. live: (m,) which rows these are.
        squares: (live,) their diagonal of W.
        triples: (live,) as ``Elimination`` takes them, or empty.
        nearly: whether a row that is not live is so only within the tolerance.
    """
    sizes = np.sqrt(squares)
    vectors, values, rows = _singular_values(half / sizes)
    rank = int(np.count_nonzero(values > RANK_TOLERANCE))
    shared, faint = lengths_of_vectors(sizes, triples), None
    if shared is not None:
        faint = faint_axes(half, shared, rank)
    if shared is not None and faint is not None:
        half, sizes, shared, nearly = faint.laid_in(half), shared, None, True
        vectors, values, rows = _singular_values(half / sizes)
        rank = len(faint.kept)
    nearly = nearly or bool((values[rank:] > EXACT_RANK * len(values)).any())
    if rank == len(sizes):
        shared = None
    span = vectors[:, :rank], values[:rank], rows[:rank]
    return Span(live, sizes, *span, nearly, faint, shared)


def _singular_values(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(nv, k) the vectors of the span, (k,) singular values, largest first, (k, m) of the rows."""
    if not matrix.size:
        return np.empty((len(matrix), 0)), np.empty(0), np.empty((0, matrix.shape[1]))
    # By LAPACK itself: on matrices as small as these, numpy's way to it takes as long again.
    vectors, values, rows, failed = lapack.dgesdd(matrix, full_matrices=0)
    if failed:
        vectors, values, rows = np.linalg.svd(matrix, full_matrices=False)
    return vectors, values, rows
