"""A hit along the path of its slip as a linear stage.

P depends on the state by the contact's own W, by the velocity that the hit starts from and
by that which Newton's law looks at. With x_j the velocity change by a unit impulse along
row j, bilateral rows A held by λ_j,

    ∂W_ij/∂q = x_iᵀ ∂(J_jᵀ + Aᵀλ_j − M x_j)/∂q + ∂(J_i x_j)/∂q + λ_iᵀ ∂(A x_j)/∂q.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..._core import derive_path
from ...errors import InputError
from ...scene.law import RESTITUTIONS
from .building import Builder
from .hits import HitFound
from .linear import ModeStage, Passing, Touching
from .stage import Loads
from .state_rows import RowBlock

__all__ = ["BLOCK", "PathDerivative", "PathStage", "change_of_block", "path_derivative"]

# The entries of W as the law takes them.
BLOCK = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))
# Why a small change of the parameters may lead another way, as the core counts them.
_EDGES = (
    "what has stuck is at the edge of its cone",
    "slip ends just as the compression or the impact does",
    "it hardly slips when it meets",
)


class PathDerivative(NamedTuple):
    """P (3,), its derivatives (3, 12), and why a small change may lead another way.

    The parameters are W (as in ``BLOCK``), the velocity at the start, u_n⁻, e and µ.
    """

    impulse: np.ndarray
    table: np.ndarray
    edges: tuple[str, ...]


def path_derivative(
    W: np.ndarray, free: np.ndarray, before: float, e: float, mu: float, law: str
) -> PathDerivative:
    """The impulse of one contact that is followed along its path, and its derivatives.

    Args:
        W: (3, 3) [1/kg].
        free: (3,) the velocity at the start [m/s], which approaches.
        before: u_n⁻ [m/s], of which Newton's law wants −e back.
        e, mu: restitution and friction.
        law: "newton", "poisson" or "stronge".

    Raises:
        InputError: friction presses the contact in again, or holds all that moves.
    """
    impulse, table, edges, is_drawn_in = derive_path(
        np.ascontiguousarray(W), before, free, e, mu, RESTITUTIONS.index(law)
    )
    if is_drawn_in:
        raise InputError(
            "derivatives: friction holds all that moves, or draws the contact in again (Painlevé); "
            "there the impulse has no derivative of this kind"
        )
    told = tuple(words for k, words in enumerate(_EDGES) if edges >> k & 1)
    return PathDerivative(impulse, table.reshape(3, -1), told)


def change_of_block(builder: Builder, hit: HitFound, point: RowBlock) -> np.ndarray:
    """(6, nv) ∂W/∂q of the contact that is hit."""
    ways, borne = hit.response.T, hit.borne.T
    by_rows, by_held, loads = [], [], []
    for j in range(3):
        by_rows.append(point.change_of_velocity(ways[j]))
        by_held.append(builder.held.change_of_velocity(ways[j]))
        loads.append(builder.load(ways[j], [(builder.held, borne[j]), (point, np.eye(3)[j])]))
    return np.array([ways[i] @ loads[j] + by_rows[j][i] + borne[i] @ by_held[j] for i, j in BLOCK])


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
