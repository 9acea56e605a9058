"""An impact as a chain of linear stages, ready for any parameter.

One stage for Newton's law, two for Poisson's: compression and expansion; a sequence of
hits has its own for each. Columns of derivatives pass through them one after the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np

from .modes import Coefficients, ContactMode
from .stage import Loads, Stage
from .state_rows import RowBlock

__all__ = ["Columns", "LinearStage", "ModeStage", "Passing", "Touching", "pass_through"]

NO_COLUMN, _EVERY = slice(0, 0), slice(None)


class Touching(NamedTuple):
    """A touching point: its place among the contacts of the scene, rows, coefficients.

    ``e_by_q`` and ``e_by_v`` (nv,) tell how its restitution changes with the state, None
    where it does not.
    """

    entry: int
    rows: RowBlock
    coefficients: Coefficients
    e_by_q: np.ndarray | None = None
    e_by_v: np.ndarray | None = None


@dataclass(eq=False)
class Columns:
    """Parameters in columns. Slices and indices say which column is which.

    Attributes:
        width: how many.
        q, v: the columns of the configuration and of the velocity before, or None.
        restitution, friction: by contact of the scene, its column, as a slice.
        names: of the contacts in the order of these.
        loads: by stage, what M d is given; None for what the stage itself holds.
    """

    width: int
    q: slice | None = None
    v: slice | None = None
    restitution: dict[int, slice] = field(default_factory=dict)
    friction: dict[int, slice] = field(default_factory=dict)
    loads: Sequence[Loads] | None = None
    names: tuple[str, ...] = ()


@dataclass(eq=False)
class Passing:
    """Derivatives on their way through the stages.

    Attributes:
        columns: the parameters.
        velocity: (nv, w) of the velocity so far; None before the first stage.
        multipliers: (m, w) of λ so far.
        contacts: by touching point, (3, w) of P so far; None for zero.
        shares: by touching point, (3, w) of P in the last stage.
        consistent: (w,) whether redundant rows agree; None where nothing speaks against it.
        e_changes: by touching point, of its restitution: the column that is its own, and
            (w,) by the state, None for zero; None for both.
    """

    columns: Columns
    velocity: np.ndarray | None
    multipliers: np.ndarray
    contacts: list[np.ndarray | None]
    shares: dict[int, np.ndarray]
    consistent: np.ndarray | None
    e_changes: list[tuple[slice, np.ndarray | None] | None]

    def take(
        self,
        velocity: np.ndarray,
        multipliers: np.ndarray,
        shares: dict[int, np.ndarray],
        consistent: np.ndarray | None,
    ) -> None:
        """Add what one stage changed."""
        if self.velocity is None:
            own = self.columns.v
            if own is not None:
                velocity.T[own].reshape(-1)[:: len(velocity) + 1] += 1.0
        else:
            velocity += self.velocity
        self.velocity = velocity
        if len(multipliers):
            self.multipliers = self.multipliers + multipliers
        for i, share in shares.items():
            before = self.contacts[i]
            self.contacts[i] = share if before is None else before + share
        self.shares = shares
        if consistent is not None:
            self.consistent = (
                consistent if self.consistent is None else self.consistent & consistent
            )


class LinearStage(Protocol):
    """One stage of an impact, made linear.

    Attributes:
        velocity_change: (nv,) Δv in it.
        null: (m,) True for bilateral rows that move nothing.
    """

    @property
    def velocity_change(self) -> np.ndarray: ...

    @property
    def null(self) -> np.ndarray: ...

    def advance(self, passing: Passing, loads: Loads | None) -> None:
        """Take parameters through; ``loads`` stand for the stage's own where given."""


class ModeStage(NamedTuple):
    """A stage in which every contact keeps one mode.

    Attributes:
        system: the linear system.
        touching: all touching points.
        carrying: which of them have rows in it.
        modes: theirs.
        starts: by carrying point, u_n at the start [m/s].
        velocity_change: (nv,) Δv of the stage.
        rates: (r, nv) what the configuration takes from what the rows are given.
        entering: (r, 1) what share of G dv, of the velocity at the start, the rows are given:
            −1, less what restitution adds; 0 where they keep their velocity.
        newton: whether restitution shifts velocities here.
    """

    system: Stage
    touching: Sequence[Touching]
    carrying: tuple[int, ...]
    modes: tuple[ContactMode, ...]
    starts: Sequence[float]
    velocity_change: np.ndarray
    rates: np.ndarray
    entering: np.ndarray
    newton: bool

    @property
    def null(self) -> np.ndarray:
        """(m,) True for bilateral rows that move nothing."""
        return self.system.null[: len(self.system.rows) - 3 * len(self.carrying)]

    def advance(self, passing: Passing, loads: Loads | None) -> None:
        """Take parameters through."""
        columns, rows = passing.columns, self.system.rows
        if passing.velocity is not None:
            given = rows.dot(passing.velocity)
            given *= self.entering
        else:
            given = np.zeros((len(rows), columns.width))
            if columns.v is not None:
                np.multiply(rows, self.entering, out=given[:, columns.v])
        if columns.q is not None:
            given[:, columns.q] -= self.rates
        direct: list[tuple[slice, slice, np.ndarray]] = []
        count = len(rows) - 3 * len(self.carrying)
        at = count
        for i, mode, start in zip(self.carrying, self.modes, self.starts, strict=True):
            point = self.touching[i]
            normal = at + 2
            change = passing.e_changes[i]
            if self.newton and change is not None and start < 0.0:
                column, share = change
                given[normal, column] -= start
                if share is not None:
                    given[normal] -= start * share
            if mode.held:
                direct.append((slice(normal, at + 3), _EVERY, self._held(passing, i, mode)))
            if not mode.sticking:
                own = columns.friction.get(point.entry)
                if own is not None:
                    by_friction = -mode.normal_impulse * mode.slip[:, None]
                    direct.append((slice(at, normal), own, by_friction))
            at += 3
        response = self.system.respond(given, direct, loads)
        impulse = response.impulse
        shares = {
            i: impulse[count + 3 * place : count + 3 * place + 3]
            for place, i in enumerate(self.carrying)
        }
        passing.take(response.velocity, impulse[:count], shares, response.consistent)

    def _held(self, passing: Passing, i: int, mode: ContactMode) -> np.ndarray:
        """(1, w) ∂(e P_n^c) of a point whose P_n is held."""
        held = self.touching[i].coefficients.e * passing.shares[i][2:]
        change = passing.e_changes[i]
        if change is not None:
            column, share = change
            held[:, column] += mode.compressed
            if share is not None:
                held += mode.compressed * share
        return held


def pass_through(
    stages: Sequence[LinearStage], touching: Sequence[Touching], columns: Columns, count: int
) -> Passing:
    """Parameters through all stages; ``count`` is that of the bilateral rows."""
    width = columns.width
    passing = Passing(
        columns,
        None,
        np.zeros((count, width)),
        [None] * len(touching),
        {},
        None,
        [_change_of_restitution(point, columns) for point in touching],
    )
    for number, stage in enumerate(stages):
        stage.advance(passing, None if columns.loads is None else columns.loads[number])
    return passing


def _change_of_restitution(
    point: Touching, columns: Columns
) -> tuple[slice, np.ndarray | None] | None:
    """∂e of a touching point: the column in which it is one, and (w,) of the state."""
    column = columns.restitution.get(point.entry, NO_COLUMN)
    if point.e_by_v is None or columns.v is None:
        return None if column is NO_COLUMN else (column, None)
    change = np.zeros(columns.width)
    change[columns.v] = point.e_by_v
    if columns.q is not None:
        change[columns.q] = point.e_by_q
    return column, change
