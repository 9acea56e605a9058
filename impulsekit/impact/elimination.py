"""Bilateral rows eliminated: W λ = r, and contacts in the system that is left without them.

All rows are half-solved: C = L⁻¹ Aᵀ with M = L Lᵀ, so that W = A M⁻¹ Aᵀ = Cᵀ C. The rank of W is
judged as if its rows were scaled to unit diagonal, so that neither units nor the scale a row was
written in decide. Velocities and accelerations are brought to what rows want alike.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from ..errors import ContradictionError
from ..laws.rank_tolerances import (
    COMPARABLE,
    CONTRADICTION_TOLERANCE,
    DETERMINED,
    EXACT_NULL_ROW,
    FAINT_AXIS_PIVOT,
    IN_SPAN,
    NULL_ROW,
    SPAN_ROUNDING,
    WEIGHTLESS,
)
from ..laws.tolerances import CLEAR, ROUNDING
from ..rows.constraints import ConstraintRows
from . import lapack
from .axes_of_vectors import lengths_of_vectors, shared_evenly
from .span import Span, span_of

__all__ = [
    "BilateralSolution",
    "Elimination",
    "refined",
]

# Columns that LAPACK's pivoted QR takes at once: room for them, less would be slower.
QR_BLOCK = 32
# Steps at most by what rows still lack: each must halve it.
MOST_REFINEMENTS = 4
# Rows that miss by this share of the worst are named with it.
NAMED = 0.1


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


def refined(
    impulse: np.ndarray,
    made: np.ndarray,
    lacking: Callable[[np.ndarray], np.ndarray],
    change: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]],
    units: np.ndarray,
    enough: float = 0.0,
) -> tuple[np.ndarray, np.ndarray]:
    """λ (m,) and what it makes (nv,), once more from what this still lacks.

    Where light bodies are held, or rows nearly depend on each other, what is made is the small
    rest of large shares, with their rounding; but what it lacks is known to all its own digits.

    Args:
        impulse: λ. made: (nv,) Δv, or half of it.
        lacking: from that to what the rows still lack of their velocities (m,).
        change: from what is lacking to the changes of both.
        units: (m,) in which rows are compared.
        enough: what rows may lack in these; 0 to go on while each step halves it.
    """
    missing = lacking(made)
    lack = (np.abs(missing) / units).max(initial=0.0)
    for _ in range(MOST_REFINEMENTS):
        if not lack > enough:
            break
        more, moved = change(missing)
        nearer = made + moved
        missing = lacking(nearer)
        left = (np.abs(missing) / units).max()
        if not left < 0.5 * lack:
            break
        impulse, made, lack = impulse + more, nearer, left
    return impulse, made


class Elimination:
    """Bilateral rows at one configuration; factored once for all that is asked of them.

    Args:
        half: (nv, m) C, the half-solved rows.
        magnitude: called only if rows look dependent; (m,) the diagonal that W would
            have without cancellation. None: rows far smaller than the largest are zeros.
        names: of the rows, for errors.
        triples: (m,) a number for each row, the same for rows along axes of one vector; empty
            where each row stands for itself.
    """

    def __init__(
        self,
        half: np.ndarray,
        magnitude: Callable[[], np.ndarray] | None,
        names: Sequence[str],
        triples: Sequence[int] = (),
    ) -> None:
        self.half, self._magnitude, self._names = half, magnitude, names
        self._triples = np.array(triples, dtype=int)
        self._delassus = half.T.dot(half)
        self._factor = _regular_factor(self._delassus, self._triples)

    @classmethod
    def of(
        cls, half: np.ndarray, rows: ConstraintRows, data: pin.Data, q: np.ndarray
    ) -> Elimination:
        """Of a scene's rows at q, half-solved; ``data`` with M."""
        return cls(
            half,
            lambda: _without_cancellation(rows.magnitude(data, q), data.M),
            rows.names,
            rows.triples,
        )

    def solve(
        self, right: np.ndarray, velocity_scale: Callable[[], np.ndarray] | None = None
    ) -> BilateralSolution:
        """λ with W λ = r.

        Args:
            right: (m,) r, the wanted change of the rows' velocities or accelerations.
            velocity_scale: called only if rows look dependent; (m,) the size of what each row
                adds up. None: what dependent rows disagree by is rounding, and left.

        Raises:
            ContradictionError: dependent rows demand different things.
        """
        if not len(right):
            return BilateralSolution(right, 0, None)
        if self._factor is not None:
            impulse = lapack.dpotrs(self._factor, right, lower=1)[0]
            return BilateralSolution(impulse, len(right), None)
        solution = self._without_still_rows(right)
        return self._of_dependent(right, velocity_scale) if solution is None else solution

    def refined(
        self, impulse: np.ndarray, start: np.ndarray, right: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """λ (m,), and start + C λ (nv,), once more from what the rows still lack.

        Where bilateral rows hold light bodies or nearly depend on each other, start + C λ is the
        small rest of large shares; changes of it lose nothing. A contact that can only move as
        the rows leave it must not slip by the rounding of these shares.

        Args:
            impulse: λ.
            start: (nv,) half-solved impulse without λ.
            right: (m,) the wanted change of the rows' velocities.
        """
        moved = start + self.half.dot(impulse)
        sizes = np.sqrt(self._delassus.diagonal() * moved.dot(moved)) + np.abs(right)

        def change(missing: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            more = self.solve(missing).impulse
            return more, self.half.dot(more)

        def lacking(made: np.ndarray) -> np.ndarray:
            return right - made.dot(self.half)

        units = np.where(sizes > 0.0, sizes, 1.0)
        return refined(impulse, moved, lacking, change, units, ROUNDING)

    def off_the_span(self, half_contacts: np.ndarray) -> np.ndarray:
        """(nv, 3n) contact rows, half-solved, less what lies in the span of the bilateral rows."""
        basis = self._span.basis
        return half_contacts - basis.dot(basis.T.dot(half_contacts))

    def shares(self, half_others: np.ndarray) -> np.ndarray:
        """(m, k) how much of each bilateral row is in other rows, half-solved (nv, k).

        λ takes as much from impulses on the others. Of least scaled norm where rows are redundant.
        """
        right = self.half.T.dot(half_others)
        if self._factor is not None:
            return lapack.dpotrs(self._factor, right, lower=1)[0]
        found = np.empty_like(right)
        for k, column in enumerate(right.T):
            found[:, k] = self.solve(column).impulse
        return found

    def left_out(self) -> np.ndarray:
        """Indices of the rows that others imply, or that move nothing; the others imply all."""
        if self._factor is not None:
            return np.zeros(0, dtype=int)
        live, sizes, basis, *_, faint, _ = self._span
        rank, moving = basis.shape[1], np.flatnonzero(live)
        if faint is not None:
            implied = faint.left_out
        else:
            count = len(moving)
            room = 2 * count + QR_BLOCK * (count + 1)
            implied = lapack.dgeqp3(self.half[:, live] / sizes, lwork=room)[1][rank:] - 1
        return np.concatenate([np.flatnonzero(~live), moving[implied]])

    def still_what_is_held(self, left: np.ndarray, half_contacts: np.ndarray) -> np.ndarray:
        """Clear, in place, what is rounding in contact rows that the bilateral rows hold.

        Args:
            left: (nv, 3n) from ``off_the_span``.
            half_contacts: (nv, 3n) the contact rows, half-solved.

        Returns:
            (3n,) whether they hold it.
        """
        sizes = np.einsum("ij,ij->j", half_contacts, half_contacts)
        # A contact's three rows are made of the same terms, and have the rounding of the largest.
        sizes = sizes.reshape(-1, 3).max(axis=1).repeat(3)
        # The span is known as well as its narrowest direction.
        narrow = self._span.values.min(initial=1.0)
        bar = max(IN_SPAN, SPAN_ROUNDING / narrow)
        held: np.ndarray = np.einsum("ij,ij->j", left, left) <= bar**2 * sizes
        left[:, held] = 0.0
        return held

    def velocity_of_held(
        self, held: np.ndarray, half_contacts: np.ndarray, imposed: np.ndarray
    ) -> np.ndarray | float:
        """(k,) the velocities of contact rows that are held (3n,), 0 where nothing moves them.

        Such a row is so much of each bilateral row, and moves by as much of the velocities that
        these are to have: ``imposed`` (m,).
        """
        return imposed.dot(self.shares(half_contacts[:, held])) if imposed.any() else 0.0

    @cached_property
    def _span(self) -> Span:
        diagonal = self._delassus.diagonal()
        live, nearly = diagonal > 0.0, False
        if self._factor is None and self._moving is None:
            gross = np.full(len(diagonal), diagonal.max(initial=0.0))
            if self._magnitude is not None:
                gross = self._magnitude()
            live = diagonal > NULL_ROW * gross
            nearly = bool((diagonal[~live] > EXACT_NULL_ROW * gross[~live]).any())
        triples = self._triples[live] if len(self._triples) else self._triples
        return span_of(self.half[:, live], live, diagonal[live], triples, nearly)

    @cached_property
    def _moving(self) -> tuple[list[int], np.ndarray] | None:
        """The rows of zeros, as they are across a plane, where the others are regular.

        With the factor of W, in which each of them stands for itself; None where it takes a
        closer look.
        """
        diagonal = self._delassus.diagonal()
        still, squares = (diagonal == 0.0).nonzero()[0].tolist(), diagonal.tolist()
        if len(still) in (0, len(squares)):
            return None
        largest = max(squares)
        if min(filter(None, squares)) < COMPARABLE * largest:
            return None
        apart = self._delassus.copy()
        apart[still, still] = largest
        factor = _regular_factor(apart)
        return None if factor is None else (still, factor)

    def _without_still_rows(self, right: np.ndarray) -> BilateralSolution | None:
        """λ where some rows are zeros and the others regular; None for all other cases."""
        if self._moving is None:
            return None
        still, factor = self._moving
        # A row of no effect cannot change its velocity.
        if any(right[still].tolist()):
            return None
        unique = np.ones(len(right), dtype=bool)
        unique[still] = False
        impulse = lapack.dpotrs(factor, right, lower=1)[0]
        return BilateralSolution(impulse, len(right) - len(still), unique)

    def _of_dependent(
        self, right: np.ndarray, velocity_scale: Callable[[], np.ndarray] | None
    ) -> BilateralSolution:
        """λ by singular values, with rows of no effect set aside."""
        live, sizes, _, values, basis, nearly, faint, shared = self._span
        # A row of no effect cannot change its velocity.
        unmet = np.where(live, 0.0, np.abs(right))
        _refuse(unmet, right, velocity_scale, self._names)
        implied = right[live]
        if faint is not None:
            implied = faint.laid_in(implied)
            unmet[live] = np.abs(right[live] - implied)
            _refuse(unmet, right, velocity_scale, self._names)
        wanted = implied / sizes
        share = basis.dot(wanted)
        unmet[live] = np.abs(wanted - share.dot(basis)) * sizes
        _refuse(unmet, right, velocity_scale, self._names)
        impulse = np.zeros_like(right)
        impulse[live] = (share / values**2).dot(basis) / sizes
        if shared is not None:
            # A row that is short for rounding is not to bear a large impulse.
            impulse[live] = shared_evenly(impulse[live], sizes, shared, basis)
        unique = np.zeros(len(right), dtype=bool)
        # A row is determined if no direction of the null space moves it.
        unique[live] = np.einsum("ij,ij->j", basis, basis) > DETERMINED
        return BilateralSolution(impulse, len(values), unique, nearly)


def _without_cancellation(gross: np.ndarray, mass_matrix: np.ndarray) -> np.ndarray:
    """(m,) the diagonal of W without cancellation, out of the sizes (m, nv) of its rows' terms."""
    masses = np.diagonal(np.atleast_2d(mass_matrix))
    return (gross**2) @ (1.0 / np.maximum(masses, WEIGHTLESS * masses.max()))


def _regular_factor(delassus: np.ndarray, triples: np.ndarray | None = None) -> np.ndarray | None:
    """(m, m) the Cholesky factor of W, or None where rows may be dependent."""
    diagonal = delassus.diagonal()
    squares = diagonal.tolist()
    if 0.0 in squares:
        return None
    # Cholesky does not feel how rows are scaled, so only its pivots are compared scaled.
    factor, failed = lapack.dpotrf(delassus, lower=1)
    if failed:
        return None
    roots, least = factor.diagonal(), CLEAR * diagonal
    # Without an array of truths, which costs more than its few entries.
    pivots = roots * roots
    if not all(map(operator.gt, pivots.tolist(), least.tolist())):
        return None
    if triples is not None and len(triples) and pivots.min() < FAINT_AXIS_PIVOT * max(squares):
        shared = lengths_of_vectors(np.sqrt(diagonal), triples)
        if shared is not None and (pivots < FAINT_AXIS_PIVOT * shared**2).any():
            return None
    return factor


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
    worst = [names[i] for i in np.flatnonzero(unmet > NAMED * unmet.max()).tolist()]
    named = ", ".join(worst[:6]) + (", …" if len(worst) > 6 else "")
    raise ContradictionError(
        f"these rows cannot hold together: {named}; they are dependent and their velocities "
        f"after the impact are {unmet.max():.3g} apart. Leave one out, or prescribe velocities "
        "that agree",
        rows=tuple(worst),
    )
