"""A hit along the path of its slip as a linear stage.

P depends on the state by the contact's own W, by the velocity that the hit starts from and
by that which Newton's law looks at. With x_j the velocity change by a unit impulse along
row j, bilateral rows A held by λ_j,

    ∂W_ij/∂q = x_iᵀ ∂(J_jᵀ + Aᵀλ_j − M x_j)/∂q + ∂(J_i x_j)/∂q + λ_iᵀ ∂(A x_j)/∂q.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .building import Builder
from .hits import HitFound
from .linear import ModeStage, Passing, Touching
from .path_law import PathDerivative
from .stage import Loads

__all__ = ["BLOCK", "PathStage", "change_of_block"]

# The entries of W as the law takes them.
BLOCK = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))


def change_of_block(builder: Builder, hit: HitFound, touching: list[Touching]) -> np.ndarray:
    """(6, nv) ∂W/∂q of the contact that is hit."""
    point = touching[hit.point].rows
    ways, borne = hit.response.T, hit.borne.T
    by_rows, by_held, loads = [], [], []
    for j in range(3):
        x = np.ascontiguousarray(ways[j])
        changes = builder.changes(x, touching)
        count = len(changes) - len(touching)
        own = changes[count + hit.point]
        by_rows.append(np.zeros((3, len(x))) if own is None else own)
        by_held.append(builder.held_changes(changes[:count]))
        pulls = builder.pulls_of(borne[j])
        loads.append(builder.load(x, [*pulls, (point, np.eye(3)[j])]))
    rows = []
    for i, j in BLOCK:
        rows.append(ways[i] @ loads[j] + by_rows[j][i] + borne[i] @ by_held[j])
    return np.array(rows)


class PathStage(NamedTuple):
    """One contact struck along its path.

    Attributes:
        bare: the same stage without a contact, whose loads leave out ∂P.
        hit, touching: what is struck, among all that touch.
        law: P and its derivatives by the parameters of the law.
        block_by_q: (6, nv) ∂W/∂q.
        start_by_q: (3, nv) ∂(J v)/∂q at the start of the hit.
        before_by_q: (nv,) ∂(J_n v⁻)/∂q where Newton's law looks at v⁻; None where it looks
            at the start of the hit.
    """

    bare: ModeStage
    hit: HitFound
    touching: list[Touching]
    law: PathDerivative
    block_by_q: np.ndarray
    start_by_q: np.ndarray
    before_by_q: np.ndarray | None

    @property
    def velocity_change(self) -> np.ndarray:
        """(nv,) Δv of the hit."""
        return self.bare.velocity_change

    @property
    def null(self) -> np.ndarray:
        """(m,) True for bilateral rows that move nothing."""
        return self.bare.null

    @property
    def unit_changes(self) -> np.ndarray:
        """(3, nv) the velocity changes by unit impulses, which W is made of."""
        return self.hit.response.T

    def advance(self, passing: Passing, loads: Loads | None) -> None:
        """Take parameters through; loads beyond the first are ∂(−M x_j) by unit impulse."""
        columns, width = passing.columns, passing.columns.width
        point = self.touching[self.hit.point]
        rows = point.rows.matrix
        velocity = passing.velocity
        given = np.zeros((len(self.law.table[0]), width))
        if velocity is not None:
            given[6:9] = rows @ velocity
        if columns.q is not None:
            given[:6, columns.q] += self.block_by_q
            given[6:9, columns.q] += self.start_by_q
        if loads is not None:
            where = loads[0][0]
            units = [load for _, load in loads[1:]]
            for k, (i, j) in enumerate(BLOCK):
                given[k, where] += self.unit_changes[i] @ units[j]
            loads = loads[:1]
        if self.before_by_q is None:
            given[9] = given[8]
        else:
            if columns.v is not None:
                given[9, columns.v] = rows[2]
            if columns.q is not None:
                given[9, columns.q] = self.before_by_q
        change = passing.e_changes[self.hit.point]
        if change is not None:
            column, share = change
            given[10, column] += 1.0
            if share is not None:
                given[10] += share
        own = columns.friction.get(point.entry)
        if own is not None:
            given[11, own] += 1.0
        impulse = self.law.table @ given
        standing = self.bare.system.loads if loads is None else loads
        everything = (slice(0, width), rows.T @ impulse)
        held = np.zeros((len(self.bare.system.rows), width))
        if columns.q is not None:
            held[:, columns.q] -= self.bare.rates
        response = self.bare.system.respond(held, loads=[*standing, everything])
        passing.take(
            response.velocity, response.impulse, {self.hit.point: impulse}, response.consistent
        )
