"""Stages out of the velocities and impulses found: what every row and load is given."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from ..._core import HeldMass
from ..held_mass import held_mass
from .linear import ModeStage, Touching
from .modes import ContactMode
from .stage import Loads, Stage
from .state_rows import RowBlock, StateRows
from .workspace import Workspace

__all__ = ["Builder"]


class Builder:
    """Builds the stages of one impact.

    Attributes:
        rows: of the state.
        held: the bilateral rows of all constraints.
    """

    def __init__(self, workspace: Workspace, rows: StateRows, *, redundant: bool) -> None:
        self._workspace, self.rows, self._redundant = workspace, rows, redundant
        blocks = rows.bilateral
        nv = len(rows.masses)
        self.held = RowBlock(
            np.concatenate([np.zeros((0, nv)), *(block.matrix for block in blocks)]),
            np.concatenate([np.zeros((nv, 0, nv)), *(block.by_q for block in blocks)], axis=1),
        )

    @cached_property
    def held_mass(self) -> HeldMass:
        """M under the bilateral rows, filled up by them where it is singular."""
        workspace, rows = self._workspace, self.held.matrix
        return held_mass(workspace.model, workspace.flat, self.rows.masses, rows)

    def load(self, change: np.ndarray, pulls: Sequence[tuple[RowBlock, np.ndarray]]) -> np.ndarray:
        """(nv, nv) ∂(Gᵀp − M Δv)/∂q under impulses p on rows G, with Δv (nv,) as it is."""
        total = -self.rows.momentum_by_q(change)
        for block, impulse in pulls:
            total += block.pull(impulse)
        return total

    def stage(
        self,
        loads: Loads,
        start: np.ndarray,
        end: np.ndarray,
        touching: Sequence[Touching],
        modes: Sequence[ContactMode],
        *,
        first: bool,
        newton: bool,
    ) -> ModeStage:
        """The stage from velocity ``start`` to ``end`` in the modes found.

        Args:
            loads: what M d is given.
            modes: by touching point; those beyond its length take no part.
            first: whether bilateral rows get their prescribed velocity in this stage.
            newton: whether restitution shifts velocities.
        """
        carrying = tuple(i for i, mode in enumerate(modes) if not mode.parted)
        own = [self.held, *(touching[i].rows for i in carrying)]
        matrix = np.concatenate([block.matrix for block in own])
        rates = np.concatenate([block.change_of_velocity(end) for block in own])
        entering = np.full((len(matrix), 1), -1.0)
        starts = [float(touching[i].rows.matrix[2] @ start) for i in carrying]
        self._keep(rates, entering, start, first)
        if newton:
            self._shift(rates, entering, start, starts, touching, carrying)
        system = Stage(
            self.held_mass,
            matrix,
            len(self.held.matrix),
            [modes[i] for i in carrying],
            loads,
            redundant=self._redundant,
            vectors=self._workspace.vectors,
            velocities=(start, end),
        )
        kept_modes = tuple(modes[i] for i in carrying)
        return ModeStage(
            system, touching, carrying, kept_modes, starts, end - start, rates, entering, newton
        )

    def _keep(
        self, rates: np.ndarray, entering: np.ndarray, start: np.ndarray, first: bool
    ) -> None:
        """Bilateral rows that keep the velocity with which the stage begins."""
        kept = self._workspace.kept
        keeps = kept if first else np.ones(len(kept), dtype=bool)
        if keeps.any():
            rates[: len(kept)] -= keeps[:, None] * self.held.change_of_velocity(start)
            entering[: len(kept), 0] = np.where(keeps, 0.0, -1.0)

    def _shift(
        self,
        rates: np.ndarray,
        entering: np.ndarray,
        start: np.ndarray,
        starts: Sequence[float],
        touching: Sequence[Touching],
        carrying: Sequence[int],
    ) -> None:
        """Newton's law: ξ = u⁺ + e∘u⁻ of normals that approach, and e_t of tangents."""
        at = len(self.held.matrix)
        for i, normal in zip(carrying, starts, strict=True):
            own = touching[i].coefficients
            by_tangent = own.e_t if own.mu > 0.0 else 0.0
            by_normal = own.e if normal < 0.0 else 0.0
            if by_tangent or by_normal:
                shift = np.array((by_tangent, by_tangent, by_normal))[:, None]
                entering[at : at + 3] -= shift
                rates[at : at + 3] += shift * touching[i].rows.change_of_velocity(start)
            at += 3
