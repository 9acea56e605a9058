"""Which contacts carry what no other contact could carry for them."""

from __future__ import annotations

import numpy as np

from .. import lapack
from .modes import DEPENDENT, NULL, Modes

__all__ = ["unique_contacts"]

# Pivots between these leave the rank to eigenvalues.
CLEAR, VANISHED = 1e-6, 1e-13
# A contact has part in a null direction above this share of its square.
PART = 1e-9


def unique_contacts(modes: Modes, impulse: np.ndarray, *, slips: bool = True) -> np.ndarray | None:
    """(n,) whether the impulse of each contact is determined within its mode; None if all are.

    Sticking leaves three entries free, sliding the normal one; what moves no velocity
    among these can be added or taken away.

    Args:
        modes: the problem.
        impulse: (3n,) P [N s].
        slips: whether an impulse on its cone is that of slip; False where none slips.
    """
    P = impulse.tolist()
    diagonal, largest = modes.diagonal, modes.largest
    loaded = 1e-13 * max(P[2::3])
    # Of each free entry its contact, and the direction of P as a row.
    owner: list[int] = []
    whole = True
    directions = np.zeros((len(P), len(P)))
    entries = directions.reshape(-1)
    for i, mu in enumerate(modes.friction.tolist()):
        at = 3 * i
        p1, p2, pn = P[at : at + 3]
        if not pn > loaded:
            continue
        if slips and (p1 * p1 + p2 * p2) ** 0.5 > mu * pn * (1.0 - 1e-9):
            first = len(owner) * len(P) + at
            entries[first], entries[first + 1], entries[first + 2] = p1 / pn, p2 / pn, 1.0
            owner.append(i)
            whole = False
        else:
            for row in range(at, at + 3):
                if diagonal[row] > NULL * largest:
                    entries[len(owner) * len(P) + row] = 1.0
                    owner.append(i)
    if whole and len(owner) == len(P):
        reduced = modes.delassus.copy()
    else:
        directions = directions[: len(owner)]
        reduced = directions.dot(modes.delassus.dot(directions.T))
    scale = 1.0 / np.sqrt(np.maximum(reduced.diagonal(), NULL * largest))
    reduced *= scale
    reduced *= scale[:, None]
    factor, order, rank, failed = lapack.dpstrf(reduced, tol=DEPENDENT, lower=1)
    if not failed and rank == len(owner):
        return None
    part = _parts(reduced, factor, order - 1, rank)
    if not part.any():
        return None
    unique = np.ones(len(modes.friction), dtype=bool)
    unique[np.array(owner)[part]] = False
    return unique


def _parts(matrix: np.ndarray, factor: np.ndarray, order: np.ndarray, rank: int) -> np.ndarray:
    """(m,) whether each entry has part in the null space of a matrix with unit diagonal.

    Args:
        matrix: (m, m), positive semidefinite.
        factor, order, rank: of its Cholesky factorization with pivots, the largest first.
    """
    rest = factor[rank:, :rank]
    left = matrix.diagonal()[order[rank:]] - np.einsum("ij,ij->i", rest, rest)
    if factor[rank - 1, rank - 1] ** 2 < CLEAR or np.abs(left).max() > VANISHED * len(order):
        values, vectors = np.linalg.eigh(matrix)
        null = vectors[:, values <= DEPENDENT * values[-1]]
        return np.einsum("ij,ij->i", null, null) > PART
    # (X, 1) with L₁₁ᵀ X = −L₂₁ᵀ spans the null space.
    leading = lapack.dtrsm(-1.0, factor[:rank, :rank], rest.T, lower=1, trans_a=1)
    squares = np.einsum("ij,ij->i", leading, leading)
    # In an orthonormal basis a row's square is no more than here, and less at most by this.
    part = squares > PART * (1.0 + squares.sum())
    if (part == (squares > PART)).all():
        everywhere = np.ones(len(order), dtype=bool)
        everywhere[order[:rank]] = part
        return everywhere
    square = leading.T.dot(leading)
    square.reshape(-1)[:: len(square) + 1] += 1.0
    root, _ = lapack.dpotrf(square, lower=1)
    null = np.empty((len(order), len(square)))
    null[order[:rank]], null[order[rank:]] = leading, np.eye(len(square))
    null = lapack.dtrsm(1.0, root, null.T, lower=1)
    return np.einsum("ij,ij->j", null, null) > PART
