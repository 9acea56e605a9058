"""What bilateral rows span: by the compiled law where their rank is clear, else by singular values.

Rows are judged as if they were of unit length, so that neither units nor the scale a row was
written in decide.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..laws.rank_tolerances import (
    DETERMINED,
    EXACT_NULL_ROW,
    EXACT_RANK,
    NULL_ROW,
    RANK_TOLERANCE,
)
from ..laws.spanning import span_rows
from ..laws.tolerances import CLEAR
from . import lapack
from .axes_of_vectors import Shares, faint_axes, lengths_of_vectors, shared_evenly

__all__ = ["Span", "span_of"]

# Time that the compiled call saves [s], about: compiling waits until it pays.
SAVED_OF_SPAN = 5e-5
# Columns that LAPACK's pivoted QR takes at once: room for them, less would be slower.
QR_BLOCK = 32


@dataclass(frozen=True, eq=False)
class Span:
    """What rows span: the one decision of rank.

    With the live rows scaled to unit length W is N L Lᵀ Nᵀ, and NᵀN = G.

    Attributes:
        live: indices of the rows that have an effect. sizes: their lengths.
        basis: (nv, rank) orthonormal.
        shares: (live, rank) N; lower: (rank, rank) L.
        gram: the Cholesky factor of G; None where that is 1.
        least: the least singular value of the rows, or a bound from below.
        left_out: indices of rows that others imply, or that have no effect.
        nearly: whether anything was left out that is more than rounding.
        faint: live rows that are left out beside others of the same vector; None without any.
        shared: (live,) the sizes of the rows' vectors, where dependent rows differ from them.
    """

    live: np.ndarray
    sizes: np.ndarray
    basis: np.ndarray
    shares: np.ndarray
    lower: np.ndarray
    gram: np.ndarray | None
    least: float
    left_out: np.ndarray
    nearly: bool = False
    faint: Shares | None = None
    shared: np.ndarray | None = None

    @property
    def rank(self) -> int:
        """How many rows are independent."""
        return len(self.lower)

    def known(self, right: np.ndarray) -> np.ndarray:
        """(rank, ...) what rows want, (live, ...) and scaled, as far as they agree: N of it is
        nearest to that."""
        return _solved(self.gram, self.shares.T.dot(right))

    def impulse(self, known: np.ndarray) -> np.ndarray:
        """(live, ...) the least λ, scaled, by which rows get what is ``known``."""
        found = _solved(self.gram, _solved(self.lower, known))
        found = (self.shares.dot(found).T / self.sizes).T
        if self.shared is None:
            return found
        # A row that is short for rounding is not to bear a large impulse.
        return shared_evenly(found, self.sizes, self.shared, self.shares.T)

    def determined(self) -> np.ndarray:
        """(live,) whether no direction of the null space moves a row."""
        part = _solved(self.gram, self.shares.T)
        determined: np.ndarray = np.einsum("ij,ji->i", self.shares, part) > DETERMINED
        return determined


def _solved(factor: np.ndarray | None, right: np.ndarray) -> np.ndarray:
    """(L Lᵀ)⁻¹ of a right-hand side; itself without L."""
    if factor is None or not right.size:
        return right
    solved: np.ndarray = lapack.dpotrs(factor, right, lower=1)[0]
    return solved


def span_of(
    half: np.ndarray, vectors: np.ndarray, magnitude: Callable[[], np.ndarray] | None
) -> Span:
    """What half-solved rows (nv, m) span; arguments as for ``Elimination``."""
    if span_rows.is_compiled:
        live, rank, order, basis, lower, shares, least = span_rows(
            np.ascontiguousarray(half.T), vectors
        )
        if rank >= 0:
            moving = order[:live]
            sizes = np.sqrt(np.einsum("ij,ij->j", *2 * [half[:, moving]]))
            own, gram = np.eye(live, rank), None
            if live > rank:
                own[rank:] = shares[: live - rank, :rank]
                gram, _ = lapack.dpotrf(own.T.dot(own), lower=1)
            factor = np.asfortranarray(lower[:rank, :rank])
            return Span(moving, sizes, basis[:rank].T, own, factor, gram, least, order[rank:])
    else:
        span_rows.wait(SAVED_OF_SPAN)
    squares = np.einsum("ij,ij->j", half, half)
    found = _by_values(half, squares > 0.0, squares, vectors, nearly=False)
    full = found.rank == len(found.live) and found.faint is None
    if full and (found.least**2 > CLEAR or not found.rank):
        return found
    gross = np.full(len(squares), squares.max(initial=0.0)) if magnitude is None else magnitude()
    live_rows = squares > NULL_ROW * gross
    if np.count_nonzero(live_rows) == len(found.live):
        return found
    nearly = bool((squares[~live_rows] > EXACT_NULL_ROW * gross[~live_rows]).any())
    return _by_values(half, live_rows, squares, vectors, nearly)


def _by_values(
    half: np.ndarray, live: np.ndarray, squares: np.ndarray, vectors: np.ndarray, nearly: bool
) -> Span:
    """The span of the live rows by their singular values.

    ``nearly``: whether a row that is not live is so only within the tolerance.
    """
    still, moving = np.flatnonzero(~live), np.flatnonzero(live)
    half, sizes = half[:, live], np.sqrt(squares[live])
    basis, values, rows = _singular_values(half / sizes)
    rank = int(np.count_nonzero(values > RANK_TOLERANCE))
    shared, faint = lengths_of_vectors(sizes, vectors[live]), None
    if shared is not None:
        faint = faint_axes(half, shared, rank)
    if shared is not None and faint is not None:
        half, sizes, shared, nearly = faint.laid_in(half), shared, None, True
        basis, values, rows = _singular_values(half / sizes)
        rank = len(faint.kept)
    nearly = nearly or bool((values[rank:] > EXACT_RANK * len(values)).any())
    implied = np.zeros(0, dtype=int)
    if faint is not None:
        implied = faint.left_out
    elif rank < len(sizes):
        room = 2 * len(sizes) + QR_BLOCK * (len(sizes) + 1)
        implied = lapack.dgeqp3(half / sizes, lwork=room)[1][rank:] - 1
    else:
        shared = None
    return Span(
        moving,
        sizes,
        basis[:, :rank],
        rows[:rank].T,
        np.diag(values[:rank]),
        None,
        float(values[:rank].min(initial=1.0)),
        np.concatenate([still, moving[implied]]),
        nearly,
        faint,
        shared,
    )


def _singular_values(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(nv, k) the vectors of the span, (k,) singular values, largest first, (k, m) of the rows."""
    if not matrix.size:
        return np.empty((len(matrix), 0)), np.empty(0), np.empty((0, matrix.shape[1]))
    # By LAPACK itself: on matrices as small as these, numpy's way to it takes as long again.
    vectors, values, rows, failed = lapack.dgesdd(matrix, full_matrices=0)
    if failed:
        vectors, values, rows = np.linalg.svd(matrix, full_matrices=False)
    return vectors, values, rows
