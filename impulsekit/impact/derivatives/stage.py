"""The linear system of one stage: M d = r + Gᵀy under the rows that its modes keep.

d is the derivative of the velocity change of the stage and y that of its impulses, in
columns, one for each parameter. Each row of y has an equation Φ G d + E y = given:

    bilateral, sticking, normal    G d = given
    held normal                    y = given directly
    sliding tangents               y_t + µ s y_n + µ P_n/|ξ_t| (1 − s sᵀ) G_t d = given

so that (Φ W + E) y = given − Φ G M⁻¹ r with W = G M⁻¹ Gᵀ.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dgesv

from ..._core import BilateralRows, HeldMass
from ...tolerances import NONZERO
from ..held_mass import CONTRADICTION
from .modes import ContactMode
from .shared_loads import even_shares

__all__ = ["Direct", "Loads", "Response", "Stage", "equations_of"]


# What M d is given, by the columns that it belongs to.
Loads = Sequence[tuple[slice, np.ndarray]]
# What rows are given without Φ: rows, columns, and what.
Direct = Sequence[tuple[slice, slice, np.ndarray]]


_NOTHING = np.zeros(0, dtype=int)
# A row whose square is this much smaller than the largest moves nothing.
NULL_ROW = 1e-22


@functools.cache
def _identity(count: int) -> np.ndarray:
    return np.eye(count)


def equations_of(mode: ContactMode) -> tuple[np.ndarray, np.ndarray]:
    """Φ and E of one contact, (3, 3)."""
    normal = 0.0 if mode.held else 1.0
    if mode.sticking:
        return np.diag((1.0, 1.0, normal)), np.diag((0.0, 0.0, 1.0 - normal))
    (a, b), mu, k = mode.slip.tolist(), mode.mu, mode.resistance
    off = -k * a * b
    mix = np.array(((k * b * b, off, 0.0), (off, k * a * a, 0.0), (0.0, 0.0, normal)))
    own = np.array(((1.0, 0.0, mu * a), (0.0, 1.0, mu * b), (0.0, 0.0, 1.0 - normal)))
    return mix, own


class Response(NamedTuple):
    """Derivatives of a stage in columns: d (nv, w) of its velocity change, y (r, w) of its
    impulses, and (w,) whether rows that were left out hold as well, None where none was."""

    velocity: np.ndarray
    impulse: np.ndarray
    consistent: np.ndarray | None


class Stage:
    """The linear system of one stage.

    ``velocities`` are those before and after, beside which zeros are judged. ``loads`` are
    those that every response meets. ``vectors`` tells which bilateral rows are axes of one
    velocity.

    Attributes:
        rows: (r, nv) G: bilateral rows, then three for each contact that carries.
        null: (r,) True for rows that move nothing.
        loads: that every response meets.
        even: springs under the normals that share loads; None where none do, or none slips.
    """

    def __init__(
        self,
        held_mass: HeldMass,
        rows: np.ndarray,
        bilateral: int,
        modes: Sequence[ContactMode],
        loads: Loads = (),
        *,
        redundant: bool,
        vectors: Sequence[int] = (),
        velocities: tuple[np.ndarray, np.ndarray],
    ) -> None:
        self._held, self.rows, self._bilateral = held_mass, rows, bilateral
        self._velocities = velocities
        # Each row of a contact stands for itself.
        singles = range(bilateral, len(rows))
        self._vectors = np.array([*vectors[:bilateral], *singles], dtype=np.int32)
        count = len(rows)
        self.loads = loads
        self._solved: Loads = ()
        if held_mass.is_filled:
            self._moved = self._solve(rows.T)
        else:
            # One solve for the rows and all loads.
            solved = self._solve(np.hstack([rows.T, *(load for _, load in loads)]))
            self._moved = solved[:, :count]
            at, parts = count, []
            for where, load in loads:
                parts.append((where, solved[:, at : at + load.shape[1]]))
                at += load.shape[1]
            self._solved = parts
        delassus = rows.dot(self._moved)
        # Of shared loads the rule is that of springs, as the core has it.
        self.even = None
        if redundant and not held_mass.is_filled:
            self.even = even_shares(held_mass, rows, bilateral, modes)
        if self.even is not None:
            delassus[np.ix_(self.even.rows, self.even.rows)] += self.even.stiffness
        diagonal = delassus.diagonal()
        sizes = diagonal.tolist()
        smallest = NULL_ROW * max(*sizes, NONZERO) if sizes else 0.0
        any_null = count > 0 and min(sizes) <= smallest
        self.null = diagonal <= smallest if any_null else np.zeros(count, dtype=bool)
        # Φ and E, by equation; Φ is None where it is the identity.
        self._mix: np.ndarray | None = None
        self._dropped = self._kept = _NOTHING
        own: np.ndarray | None = None
        if any_null or redundant or any(mode.held or not mode.sticking for mode in modes):
            mix, own = self._equations(modes, count)
            if any_null or redundant:
                self._drop(modes, mix, own, redundant)
            self._mix = mix
        if any_null:
            diagonal = np.where(self.null, 1.0, diagonal)
        # Impulses by what is given directly, and by velocities that are given.
        self._by_direct = self._inverse(delassus, own, 1.0 / np.sqrt(diagonal))
        self._by_velocity = self._by_direct
        if self._mix is not None and self._by_direct is not None:
            self._by_velocity = self._by_direct.dot(self._mix)

    def _solve(self, columns: np.ndarray) -> np.ndarray:
        """(nv, w) M⁻¹ of columns (nv, w)."""
        solved: np.ndarray = self._held.solve(np.ascontiguousarray(columns.T))
        return solved.reshape(columns.shape[::-1]).T

    def _inverse(
        self, delassus: np.ndarray, own: np.ndarray | None, scale: np.ndarray
    ) -> np.ndarray | None:
        """(r, r) (Φ W + E)⁻¹; None where there is none."""
        if not len(scale):
            return delassus
        whole = delassus if self._mix is None else self._mix.dot(delassus)
        if own is not None:
            whole = whole + own
        # Rows and columns of one size.
        per_row = scale[:, None]
        _, _, inverse, failed = dgesv(whole * (scale * per_row), _identity(len(scale)))
        return None if failed else inverse * (scale * per_row)

    def _equations(self, modes: Sequence[ContactMode], count: int) -> tuple[np.ndarray, np.ndarray]:
        """Φ and E, (r, r)."""
        if count == 3 and len(modes) == 1:
            return equations_of(modes[0])
        mix, own = _identity(count).copy(), np.zeros((count, count))
        at = self._bilateral
        for mode in modes:
            if mode.held or not mode.sticking:
                where = slice(at, at + 3)
                mix[where, where], own[where, where] = equations_of(mode)
            at += 3
        return mix, own

    def _drop(
        self, modes: Sequence[ContactMode], mix: np.ndarray, own: np.ndarray, redundant: bool
    ) -> None:
        """Leave out demands of rows that move nothing, or that others already make."""
        demands = [True] * self._bilateral
        for mode in modes:
            demands += [mode.sticking, mode.sticking, not mode.held]
        is_demand = np.array(demands, dtype=bool)
        dropped = is_demand & self.null
        if redundant:
            dropped |= self._dependent(is_demand & ~self.null)
        self._dropped = np.flatnonzero(dropped)
        # Springs would take up what redundant rows contradict each other by.
        self._kept = self._dropped
        if self.even is not None:
            self._kept = np.union1d(self._dropped, self.even.rows)
        mix[dropped] = 0.0
        own[dropped] = 0.0
        own[dropped, dropped] = 1.0

    def _dependent(self, demands: np.ndarray) -> np.ndarray:
        """(r,) True for demands that others already make."""
        chosen = np.flatnonzero(demands)
        half = self._held.half(self.rows[chosen]).reshape(len(chosen), self.rows.shape[1])
        if self.even is not None:
            springs = np.zeros((len(self.rows), len(self.even.rows)))
            springs[self.even.rows] = self.even.root.T
            half = np.hstack([half, springs[chosen]])
        ranked = BilateralRows(np.ascontiguousarray(half), self._vectors[chosen])
        left_out = ranked.order[ranked.rank :]
        dependent = np.zeros(len(self.rows), dtype=bool)
        dependent[chosen[left_out]] = True
        return dependent

    def respond(
        self, given: np.ndarray, direct: Direct = (), loads: Loads | None = None
    ) -> Response:
        """The derivatives for what the rows are given.

        Args:
            given: (r, w) velocities; Φ takes those that the modes do not ask for. It is
                overwritten.
            direct: what they are given beside.
            loads: what M d is given; None for the standing loads.
        """
        nv, width = self.rows.shape[1], given.shape[1]
        wanted = given.copy() if len(self._kept) else given
        if self._held.is_filled:
            load = np.zeros((nv, width))
            for where, part in self.loads if loads is None else loads:
                load[:, where] += part
            unit = np.eye(self._bilateral)
            filling = np.array([self._held.fill(row) for row in unit]).reshape(-1, nv)
            filled = load + filling.T.dot(given[: self._bilateral])
            free: Loads = [(slice(0, width), self._solve(filled))]
        elif loads is None:
            free = self._solved
        else:
            free = [(where, self._solve(part)) for where, part in loads]
        if not len(self.rows):
            impulse = np.zeros((0, width))
            velocity = np.zeros((width, nv)).T
        elif self._by_velocity is None or self._by_direct is None:
            # The modes leave the impulses open, or closed to change, as in Painlevé's case.
            gone = np.full((len(self.rows), width), np.nan)
            return Response(np.full((nv, width), np.nan), gone, np.zeros(width, dtype=bool))
        else:
            for where, part in free:
                given[:, where] -= self.rows.dot(part)
            impulse = self._by_velocity.dot(given)
            for own, columns, value in direct:
                impulse[:, columns] += self._by_direct[:, own].dot(value)
            # Column by column, so that a share of them lies together.
            velocity = impulse.T.dot(self._moved.T).T
        for where, part in free:
            velocity[:, where] += part
        return Response(velocity, impulse, self._holds(velocity, wanted))

    def _holds(self, velocity: np.ndarray, given: np.ndarray) -> np.ndarray | None:
        """(w,) whether demands left out or shared are met, relative to what makes them up."""
        if not len(self._kept):
            return None
        rows, wanted = self.rows[self._kept], given[self._kept]
        gap = np.abs(rows @ velocity - wanted).max(axis=0)
        every = np.abs(self.rows)
        # What is given by the configuration is a difference of terms of this size.
        terms = every.max() * max(float(np.abs(v).max()) for v in self._velocities)
        met: np.ndarray = gap <= CONTRADICTION * terms
        rest = np.flatnonzero(~met)
        if len(rest):
            sizes = every.dot(np.abs(velocity[:, rest])) + np.abs(given[:, rest])
            met[rest] = gap[rest] <= CONTRADICTION * (sizes.max(axis=0) + terms)
        return met
