"""Bilateral rows eliminated: W λ = r, and contacts in the system that is left without them.

All rows are half-solved: C = L⁻¹ Aᵀ with M = L Lᵀ, so that W = A M⁻¹ Aᵀ = Cᵀ C. The rank of W is
judged as if its rows were scaled to unit diagonal, so that neither units nor the scale a row was
written in decide. Velocities and accelerations are brought to what rows want alike.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from ..errors import ContradictionError
from ..laws.rank_tolerances import CONTRADICTION_TOLERANCE, IN_SPAN, SPAN_ROUNDING, WEIGHTLESS
from ..laws.tolerances import ROUNDING
from ..rows.constraints import ConstraintRows
from .span import Span, span_of

__all__ = [
    "BilateralSolution",
    "Elimination",
    "refined",
]

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
        self._vectors = np.array(triples if len(triples) else range(half.shape[1]), dtype=np.int64)

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
        span = self._span
        live, sizes = span.live, span.sizes
        wanted = right[live]
        if len(live) == span.rank == len(right):
            impulse = np.zeros_like(right)
            impulse[live] = span.impulse(span.known(wanted / sizes))
            return BilateralSolution(impulse, span.rank, None)
        # A row of no effect cannot change its velocity.
        unmet = np.abs(right)
        unmet[live] = 0.0
        _refuse(unmet, right, velocity_scale, self._names)
        if span.faint is not None:
            wanted = span.faint.laid_in(wanted)
            unmet[live] = np.abs(right[live] - wanted)
            _refuse(unmet, right, velocity_scale, self._names)
        known = span.known(wanted / sizes)
        unmet[live] = np.abs(wanted / sizes - span.shares.dot(known)) * sizes
        _refuse(unmet, right, velocity_scale, self._names)
        impulse, unique = np.zeros_like(right), np.zeros(len(right), dtype=bool)
        impulse[live], unique[live] = span.impulse(known), span.determined()
        return BilateralSolution(impulse, span.rank, unique, span.nearly)

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
        squares = np.einsum("ij,ij->j", self.half, self.half)
        sizes = np.sqrt(squares * moved.dot(moved)) + np.abs(right)

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
        span = self._span
        right = self.half[:, span.live].T.dot(half_others)
        if span.faint is not None:
            right = span.faint.laid_in(right.T).T
        found = np.zeros((self.half.shape[1], half_others.shape[1]))
        found[span.live] = span.impulse(span.known(right / span.sizes[:, None]))
        return found

    def left_out(self) -> np.ndarray:
        """Indices of the rows that others imply, or that move nothing; the others imply all."""
        return self._span.left_out

    def still_what_is_held(self, left: np.ndarray, half_contacts: np.ndarray) -> np.ndarray:
        """Clear, in place, what is rounding in contact rows that the bilateral rows hold.

        Args:
            left: (nv, 3n) from ``off_the_span``.
            half_contacts: (nv, 3n) the contact rows, half-solved.

        Returns:
            (3n,) whether they hold it.
        """
        sizes = np.einsum("ij,ij->j", half_contacts, half_contacts)
        sizes = _of_contacts(sizes)
        held: np.ndarray = np.einsum("ij,ij->j", left, left) <= self._bar**2 * sizes
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

    def rounding_of_held(
        self,
        held: np.ndarray,
        half_contacts: np.ndarray,
        sizes: np.ndarray,
        of_bilateral: np.ndarray,
    ) -> np.ndarray:
        """(3n,) velocities up to which rows that are held move by rounding alone; 0 for others.

        Nothing stops a contact that is held, so that the sign of its velocity decides whether
        the law has a solution.

        Args:
            held: (3n,) from ``still_what_is_held``.
            half_contacts: (nv, 3n) the contact rows, half-solved.
            sizes: (3n,) of the terms that their velocities add up.
            of_bilateral: (m,) the same of the bilateral rows.
        """
        sizes = sizes.copy()
        sizes[held] += np.abs(self.shares(half_contacts[:, held])).T.dot(of_bilateral)
        return np.where(held, self._bar * _of_contacts(sizes), 0.0)

    @property
    def _bar(self) -> float:
        """Share of its terms below which what the rows leave of a contact is rounding."""
        # The span is known as well as its narrowest direction.
        return max(IN_SPAN, SPAN_ROUNDING / self._span.least)

    @cached_property
    def _span(self) -> Span:
        return span_of(self.half, self._vectors, self._magnitude)


def _of_contacts(sizes: np.ndarray) -> np.ndarray:
    """(3n,) the largest of each contact: its three rows are made of the same terms."""
    largest: np.ndarray = sizes.reshape(-1, 3).max(axis=1).repeat(3)
    return largest


def _without_cancellation(gross: np.ndarray, mass_matrix: np.ndarray) -> np.ndarray:
    """(m,) the diagonal of W without cancellation, out of the sizes (m, nv) of its rows' terms."""
    masses = np.diagonal(np.atleast_2d(mass_matrix))
    return (gross**2) @ (1.0 / np.maximum(masses, WEIGHTLESS * masses.max()))


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
