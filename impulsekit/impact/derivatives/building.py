"""Stages out of the velocities and impulses found: what every row and load is given."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from ..factor import DenseFactor
from .linear import ModeStage, Rows, Touching
from .modes import ContactMode
from .motion import Motion
from .pulls import Pulls
from .stage import Loads, Stage
from .workspace import Workspace

__all__ = ["Builder"]

_rnea_derivatives = pin.computeRNEADerivatives


class Builder:
    """Builds the stages of one impact. The factor of M is made once and shared.

    Attributes:
        masses: (nv, nv) M; there when the first load has been worked out.
    """

    def __init__(
        self,
        workspace: Workspace,
        motion: Motion,
        q: np.ndarray,
        bilateral: Sequence[Rows],
        *,
        redundant: bool,
    ) -> None:
        self._workspace, self._motion, self._q = workspace, motion, q
        self._bilateral, self._redundant = bilateral, redundant
        self._count = sum(len(rows.matrix) for rows in bilateral)
        self.masses = np.zeros((0, 0))
        self._factor: DenseFactor | None = None

    def factor(self) -> DenseFactor:
        """The factor of M; a load has to be worked out before."""
        if self._factor is None:
            rows = [rows.matrix for rows in self._bilateral]
            matrix = rows[0] if len(rows) == 1 else self.stacked(rows)
            regular, singular = self._workspace.always_regular, self._workspace.singular
            self._factor = DenseFactor(
                self._workspace.model, self.masses, matrix, regular=regular, singular=singular
            )
        return self._factor

    def stacked(self, matrices: Sequence[np.ndarray]) -> np.ndarray:
        """(r, nv) rows one below the other."""
        if not matrices:
            return self._workspace.no_rows
        return matrices[0] if len(matrices) == 1 else np.concatenate(matrices)

    def load(self, change: np.ndarray, pulls: Sequence[tuple[Rows, np.ndarray]]) -> np.ndarray:
        """(nv, nv) ∂(Gᵀp − M Δv)/∂q under impulses p on rows G, with Δv (nv,) as it is."""
        workspace = self._workspace
        expanded = workspace.expanded
        by_q, _, masses = _rnea_derivatives(
            expanded.model,
            workspace.data,
            self._q,
            expanded.still,
            expanded.speeds(change),
            workspace.no_forces,
        )
        self._motion.forget_speed()
        size = len(expanded.still)
        by_q, masses = by_q.reshape(size, size), masses.reshape(size, size)
        if expanded.spread is not None:
            by_q = expanded.rows(expanded.columns(by_q))
            masses = expanded.rows(expanded.columns(masses))
        self.masses = masses
        pulled = Pulls(expanded)
        for rows, impulse in pulls:
            rows.pull(pulled, impulse)
        total = pulled.total()
        return np.negative(by_q) if total is None else np.subtract(total, by_q, out=total)

    def pulls_of(self, multipliers: np.ndarray) -> list[tuple[Rows, np.ndarray]]:
        """The bilateral rows with their impulses, out of λ (m,)."""
        pulls: list[tuple[Rows, np.ndarray]] = []
        at = 0
        for rows in self._bilateral:
            until = at + len(rows.matrix)
            pulls.append((rows, multipliers[at:until]))
            at = until
        return pulls

    def held_changes(self, changes: Sequence[np.ndarray | None]) -> np.ndarray:
        """(m, nv) ∂(A v)/∂q of the bilateral rows, out of those by constraint."""
        return self.stacked(
            [
                np.zeros_like(rows.matrix) if change is None else change
                for rows, change in zip(self._bilateral, changes, strict=True)
            ]
        )

    def changes(self, v: np.ndarray, touching: Sequence[Touching]) -> list[np.ndarray | None]:
        """∂(G v)/∂q of bilateral rows and touching points, one after the other."""
        self._motion.set_speed(v)
        every = (*self._bilateral, *(point.rows for point in touching))
        return [rows.change_of_velocity() for rows in every]

    def stage(
        self,
        loads: Loads,
        start: np.ndarray,
        end: np.ndarray,
        changes: Sequence[np.ndarray | None],
        touching: Sequence[Touching],
        modes: Sequence[ContactMode],
        *,
        first: bool,
        newton: bool,
    ) -> ModeStage:
        """The stage from velocity ``start`` to ``end`` in the modes found.

        Args:
            loads: what M d is given.
            changes: those at ``end``.
            modes: by touching point; those beyond its length take no part.
            first: whether bilateral rows get their prescribed velocity in this stage.
            newton: whether restitution shifts velocities.
        """
        carrying = tuple(i for i, mode in enumerate(modes) if not mode.parted)
        bilateral = self._bilateral
        own = [*bilateral, *(touching[i].rows for i in carrying)]
        matrix = self.stacked([rows.matrix for rows in own])
        shift = len(bilateral)
        at_end = [*changes[:shift], *(changes[shift + i] for i in carrying)]
        rates, entering, starts = self._given(own, matrix, start, at_end, touching, carrying, first)
        if newton:
            entering = self._shift(rates, entering, start, starts, touching, carrying)
        system = Stage(
            self.factor(),
            matrix,
            self._count,
            [modes[i] for i in carrying],
            loads,
            redundant=self._redundant,
            vectors=self._workspace.vectors,
            velocities=(start, end),
        )
        return ModeStage(
            system,
            touching,
            carrying,
            tuple(modes[i] for i in carrying),
            starts,
            end - start,
            rates,
            entering,
            newton,
        )

    def _given(
        self,
        own: Sequence[Rows],
        matrix: np.ndarray,
        start: np.ndarray,
        changes: Sequence[np.ndarray | None],
        touching: Sequence[Touching],
        carrying: Sequence[int],
        first: bool,
    ) -> tuple[np.ndarray, np.ndarray | None, Sequence[float]]:
        """∂(G v_end)/∂q, the share of the velocity at the start, and that of normals there."""
        motion = self._motion
        entering: np.ndarray | None = None
        if len(own) == 1 and changes[0] is not None:
            rates = changes[0]
        else:
            rates = np.empty_like(matrix)
            at = 0
            for rows, change in zip(own, changes, strict=True):
                until = at + len(rows.matrix)
                rates[at:until] = 0.0 if change is None else change
                at = until
        kept = self._workspace.kept
        if len(kept) and (not first or self._workspace.any_kept):
            motion.set_speed(start)
            entering = np.full((len(matrix), 1), -1.0)
            at = 0
            for rows in self._bilateral:
                until = at + len(rows.matrix)
                keeps = kept[at:until] if first else np.ones(until - at, dtype=bool)
                change = rows.change_of_velocity()
                if change is not None:
                    rates[at:until] -= np.where(keeps[:, None], change, 0.0)
                entering[at:until, 0] = np.where(keeps, 0.0, -1.0)
                at = until
        starts = [float(touching[i].rows.matrix[2].dot(start)) for i in carrying]
        return rates, entering, starts

    def _shift(
        self,
        rates: np.ndarray,
        entering: np.ndarray | None,
        start: np.ndarray,
        starts: Sequence[float],
        touching: Sequence[Touching],
        carrying: Sequence[int],
    ) -> np.ndarray | None:
        """Newton's law: ξ = u⁺ + e∘u⁻ of normals that approach, and e_t of tangents."""
        at = self._count
        is_set = False
        for i, normal in zip(carrying, starts, strict=True):
            own = touching[i].coefficients
            by_tangent = own.e_t if own.mu > 0.0 else 0.0
            by_normal = own.e if normal < 0.0 else 0.0
            if by_tangent or by_normal:
                if not is_set:
                    self._motion.set_speed(start)
                    is_set = True
                if entering is None:
                    entering = np.full((len(rates), 1), -1.0)
                shift = np.array((by_tangent, by_tangent, by_normal))
                entering[at : at + 3, 0] -= shift
                change = touching[i].rows.change_of_velocity()
                if change is not None:
                    rates[at : at + 3] += shift[:, None] * change
            at += 3
        return entering
