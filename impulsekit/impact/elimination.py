"""Contact rows in a system from which the bilateral rows are eliminated.

All rows are half-solved: C = L⁻¹ Jᵀ with M = L Lᵀ, so that W = Cᵀ C.
"""

from __future__ import annotations

import numpy as np

from .bilateral import RANK_TOLERANCE

__all__ = ["DEPENDENT", "off_the_span", "still_what_is_held"]

# Singular values this small beside the largest are taken for zero.
DEPENDENT = 1e-13
# Bilateral rows this small beside the largest move nothing.
NULL_ROW = 1e-11


def off_the_span(half_contacts: np.ndarray, half_rows: np.ndarray) -> np.ndarray:
    """(nv, 3n) the contact rows less what lies in the span of the bilateral rows (nv, m)."""
    sizes = np.sqrt(np.einsum("ij,ij->j", half_rows, half_rows))
    live = sizes > NULL_ROW * sizes.max(initial=0.0)
    vectors, values, _ = np.linalg.svd(half_rows[:, live] / sizes[live], full_matrices=False)
    basis = vectors[:, values > RANK_TOLERANCE]
    return half_contacts - basis.dot(basis.T.dot(half_contacts))


def still_what_is_held(
    left: np.ndarray,
    half_contacts: np.ndarray,
    free: np.ndarray,
    before: np.ndarray,
    start: np.ndarray,
) -> None:
    """Zero, in place, what is rounding in contact rows that the bilateral rows hold still."""
    sizes = np.einsum("ij,ij->j", half_contacts, half_contacts)
    held = np.einsum("ij,ij->j", left, left) <= DEPENDENT**2 * sizes
    if held.any():
        left[:, held] = 0.0
        noise = DEPENDENT * (np.abs(before) + np.sqrt(sizes * start.dot(start)))
        free[held & (np.abs(free) <= noise)] = 0.0
