"""How bodies respond to impulses on points where bilateral rows hold.

With C = L⁻¹ Aᵀ of the rows and C_p of the points, Δv = L⁻ᵀ of what is left of C_p off the span
of C: impacts, their derivatives, and what is looked for beside an answer see the same freedom.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from .elimination import Elimination

__all__ = ["Responses", "responses"]


class HasHalf(Protocol):
    """A factor of the mass matrix, M = L Lᵀ."""

    def half(self, *rows: np.ndarray) -> np.ndarray:
        """(nv, m) L⁻¹ Aᵀ of rows A (m, nv), given in parts."""

    def back(self, half: np.ndarray) -> np.ndarray:
        """(nv, k) L⁻ᵀ of half-solved columns."""


class Responses(NamedTuple):
    """What unit impulses on points do where bilateral rows hold.

    Attributes:
        moved: (nv, 3n) Δv.
        borne: (m, 3n) λ.
        delassus: (3n, 3n) W [1/kg].
    """

    moved: np.ndarray
    borne: np.ndarray
    delassus: np.ndarray


def responses(
    factor: HasHalf, rows: np.ndarray, points: np.ndarray, triples: Sequence[int]
) -> Responses:
    """Of points' rows (3n, nv) beside bilateral rows (m, nv), whose ``triples`` are as above.

    Where M is filled up by the bilateral rows, what points leave of it is the same.
    """
    if not len(rows):
        left = factor.half(points)
        return Responses(factor.back(left), np.zeros((0, len(points))), left.T.dot(left))
    half = factor.half(rows, points)
    half_rows, half_points = half[:, : len(rows)], half[:, len(rows) :]
    eliminated = Elimination(half_rows, (), triples)
    left = eliminated.off_the_span(half_points)
    eliminated.still_what_is_held(left, half_points)
    return Responses(factor.back(left), -eliminated.shares(half_points), left.T.dot(left))
