"""One stage of an impact, made linear: M d = r + Gᵀy under the rows that its modes keep.

d is the derivative of the velocity change of the stage and y that of its impulses, in
columns, one for each parameter. Each row of y has an equation Φ G d + E y = given:

    bilateral, sticking, normal    G d = given
    held normal                    y = given
    sliding tangents               y_t + µ s y_n + µ P_n/|ξ_t| (1 − s sᵀ) G_t d = given

so that (Φ W + E) y = given − Φ G M⁻¹ r with W = G M⁻¹ Gᵀ.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .factor import Factor
from .modes import ContactMode

__all__ = ["Response", "Stage"]

# As for the rows of a solve: what stands less than this out of the others' span is dependent.
RANK_TOLERANCE = 1e-7
CONSISTENT = 1e-6
NULL_ROW = 1e-22


@dataclass(frozen=True, eq=False)
class Response:
    """Derivatives of a stage in columns: d (nv, w) of its velocity change, y (r, w) of its
    impulses, and (w,) whether rows that were left out hold as well."""

    velocity: np.ndarray
    impulse: np.ndarray
    consistent: np.ndarray


class Stage:
    """The linear system of one stage.

    ``speed`` is the size of the velocities, beside which zeros are judged.

    Attributes:
        rows: (r, nv) G: bilateral rows, then three for each contact that carries.
        null: (r,) True for rows that move nothing.
    """

    def __init__(
        self,
        factor: Factor,
        rows: np.ndarray,
        bilateral: int,
        modes: Sequence[ContactMode],
        *,
        redundant: bool,
        speed: float,
    ) -> None:
        self._factor, self.rows, self._bilateral = factor, rows, bilateral
        self._speed = speed
        count = len(rows)
        moved = factor.solve(np.ascontiguousarray(rows.T))
        self._moved = moved
        delassus = rows @ moved
        diagonal = delassus.diagonal()
        self.null = diagonal <= NULL_ROW * max(diagonal.max(initial=0.0), 1e-300)
        # Φ and E, by equation.
        self._mix = np.eye(count)
        self._own = np.zeros((count, count))
        is_demand = np.ones(count, dtype=bool)
        for i, mode in enumerate(modes):
            t, n = slice(bilateral + 3 * i, bilateral + 3 * i + 2), bilateral + 3 * i + 2
            if mode.held:
                self._mix[n, n], self._own[n, n] = 0.0, 1.0
                is_demand[n] = False
            if not mode.sticking:
                across = np.eye(2) - np.outer(mode.slip, mode.slip)
                self._mix[t, t] = mode.resistance * across
                self._own[t, t] = np.eye(2)
                self._own[t, n] = mode.mu * mode.slip
                is_demand[t] = False
        dropped = is_demand & self.null
        if redundant:
            dropped |= self._dependent(is_demand & ~self.null)
        self._dropped = np.flatnonzero(dropped)
        self._mix[dropped] = 0.0
        self._own[dropped] = 0.0
        self._own[dropped, dropped] = 1.0
        scale = 1.0 / np.sqrt(np.where(self.null, 1.0, np.maximum(diagonal, 1e-300)))
        self._scale = scale[:, None]
        self._matrix = (self._mix @ delassus + self._own) * scale * scale[:, None]

    def _dependent(self, demands: np.ndarray) -> np.ndarray:
        """(r,) True for demands that others already make."""
        import scipy.linalg

        chosen = np.flatnonzero(demands)
        half = self._factor.half(self.rows[chosen])
        half = half / np.sqrt(np.einsum("ij,ij->j", half, half))
        triangle, order = scipy.linalg.qr(half, mode="r", pivoting=True)
        rank = int((np.abs(triangle.diagonal()) > RANK_TOLERANCE).sum())
        dependent = np.zeros(len(self.rows), dtype=bool)
        dependent[chosen[order[rank:]]] = True
        return dependent

    def respond(self, force: np.ndarray | None, given: np.ndarray) -> Response:
        """The derivatives for r (nv, w), None for zero, and given (r, w)."""
        count = self._bilateral
        start: np.ndarray | None = None
        if force is not None:
            start = self._factor.solve(self._factor.filled(force, given[:count]))
        elif count:
            filled = self._factor.filled(
                np.zeros((self.rows.shape[1], given.shape[1])), given[:count]
            )
            start = self._factor.solve(filled) if filled.any() else None
        if not len(self.rows):
            velocity = np.zeros((self.rows.shape[1], given.shape[1])) if start is None else start
            every = np.ones(given.shape[1], dtype=bool)
            return Response(velocity, np.zeros((0, given.shape[1])), every)
        right = given.copy()
        right[self._dropped] = 0.0
        if start is not None:
            right -= self._mix @ (self.rows @ start)
        try:
            impulse = self._scale * np.linalg.solve(self._matrix, self._scale * right)
        except np.linalg.LinAlgError:
            # The modes leave the impulses open, or closed to change, as in Painlevé's case.
            gone = np.full(given.shape, np.nan)
            none = np.zeros(given.shape[1], dtype=bool)
            return Response(np.full((self.rows.shape[1], given.shape[1]), np.nan), gone, none)
        velocity = self._moved @ impulse
        if start is not None:
            velocity += start
        return Response(velocity, impulse, self._holds(velocity, given))

    def _holds(self, velocity: np.ndarray, given: np.ndarray) -> np.ndarray:
        """(w,) whether the demands left out are met, relative to what makes them up."""
        if not len(self._dropped):
            return np.ones(given.shape[1], dtype=bool)
        rows, wanted = self.rows[self._dropped], given[self._dropped]
        gap = np.abs(rows @ velocity - wanted).max(axis=0)
        size = (np.abs(self.rows) @ np.abs(velocity) + np.abs(given)).max(axis=0)
        # What is given by the configuration is a difference of terms of this size.
        size += np.abs(self.rows).max() * self._speed
        return gap <= CONSISTENT * size
