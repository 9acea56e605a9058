"""Bilateral rows eliminated: W λ = r, and contacts in the system that is left without them.

All rows are half-solved: C = L⁻¹ Aᵀ with M = L Lᵀ, so that W = A M⁻¹ Aᵀ = Cᵀ C. Their rank is
decided in the core, in one place for impacts, motions and derivatives.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from .._core import BilateralRows
from ..errors import ContradictionError
from .held_mass import CONTRADICTION

__all__ = ["BilateralSolution", "Elimination", "refuse_contradiction"]

# Rows that miss by this share of the worst are named with it, so many at most.
NAMED, MOST_NAMED = 0.1, 6


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


def refuse_contradiction(names: Sequence[str], apart: float) -> ContradictionError:
    """Return the error that names rows whose velocities disagree."""
    named = ", ".join(names[:MOST_NAMED]) + (", …" if len(names) > MOST_NAMED else "")
    return ContradictionError(
        f"these rows cannot hold together: {named}; they are dependent and their velocities "
        f"after the impact are {apart:.3g} apart. Leave one out, or prescribe velocities that "
        "agree",
        rows=tuple(names),
    )


class Elimination:
    """Bilateral rows at one configuration; factored once for all that is asked of them.

    Args:
        half: (nv, m) C, the half-solved rows.
        names: of the rows, for errors.
        triples: (m,) a number for each row, the same for rows along axes of one vector; empty
            where each row stands for itself.
    """

    def __init__(
        self, half: np.ndarray, names: Sequence[str] = (), triples: Sequence[int] = ()
    ) -> None:
        self.half, self._names = half, names
        vectors = triples if len(triples) else range(half.shape[1])
        self._rows = BilateralRows(np.ascontiguousarray(half.T), np.array(vectors, dtype=np.int32))

    def solve(
        self, right: np.ndarray, velocity_scale: Callable[[], np.ndarray] | None = None
    ) -> BilateralSolution:
        """λ with W λ = r.

        Args:
            right: (m,) r, the wanted change of the rows' velocities or accelerations.
            velocity_scale: called only if rows disagree; (m,) the size of what each row
                adds up. None: what dependent rows disagree by is rounding, and left.

        Raises:
            ContradictionError: dependent rows demand different things.
        """
        if not len(right):
            return BilateralSolution(right, 0, None)
        impulse, lacking = self._rows.solve(np.ascontiguousarray(right))
        unmet = np.abs(lacking)
        if velocity_scale is not None and unmet.max() > CONTRADICTION * np.abs(right).max():
            size = (velocity_scale() + np.abs(right)).max()
            if unmet.max() > CONTRADICTION * size:
                worst = np.flatnonzero(unmet > NAMED * unmet.max())
                raise refuse_contradiction(
                    [self._names[i] for i in worst.tolist()], float(unmet.max())
                )
        unique = self._rows.unique.astype(bool)
        return BilateralSolution(
            impulse,
            self._rows.rank,
            None if unique.all() else unique,
            self._rows.nearly_dependent,
        )

    def off_the_span(self, half_contacts: np.ndarray) -> np.ndarray:
        """(nv, 3n) contact rows, half-solved, less what lies in the span of the bilateral rows."""
        rows = np.ascontiguousarray(half_contacts.T)
        left = [self._rows.project_off(row) for row in rows]
        return np.array(left).reshape(rows.shape).T

    def shares(self, half_others: np.ndarray) -> np.ndarray:
        """(m, k) how much of each bilateral row is in other rows, half-solved (nv, k).

        λ takes as much from impulses on the others. Of least scaled norm where rows are redundant.
        """
        right = np.ascontiguousarray((self.half.T @ half_others).T)
        found = [self._rows.solve(column)[0] for column in right]
        return np.array(found).reshape(right.shape).T

    def left_out(self) -> np.ndarray:
        """Indices of the rows that others imply, or that move nothing; the others imply all."""
        return np.array(self._rows.order[self._rows.rank :], dtype=int)

    def still_what_is_held(self, left: np.ndarray, half_contacts: np.ndarray) -> np.ndarray:
        """Clear, in place, what is rounding in contact rows that the bilateral rows hold.

        Args:
            left: (nv, 3n) from ``off_the_span``.
            half_contacts: (nv, 3n) the contact rows, half-solved.

        Returns:
            (3n,) whether they hold it.
        """
        sizes = np.einsum("ij,ij->j", half_contacts, half_contacts)
        # The three rows of a contact are made of the same terms.
        sizes = sizes.reshape(-1, 3).max(axis=1).repeat(3)
        bar = self._rows.rounding_of_span
        held: np.ndarray = np.einsum("ij,ij->j", left, left) <= bar * bar * sizes
        left[:, held] = 0.0
        return held
