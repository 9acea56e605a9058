"""Derivatives by entry of the scene, in the axes in which results tell impulses."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from ..result import Impact
from .linear import Columns, Passing, Touching
from .result import Derivatives, ImpulseDerivatives
from .status import DerivativeStatus
from .workspace import Workspace

__all__ = ["parts_of", "told"]

_NONE: MappingProxyType = MappingProxyType({})
_ByName: TypeAlias = Mapping[str, np.ndarray]
_Parts: TypeAlias = tuple[np.ndarray, np.ndarray, _ByName, _ByName, _ByName]


class ByEntry(Mapping[str, ImpulseDerivatives]):
    """Derivatives of impulses by the names of entries, computed on first access.

    Args:
        build: gives all of them. Two threads may call it: it changes nothing.
    """

    def __init__(self, build: Callable[[], dict[str, ImpulseDerivatives]]) -> None:
        self._build = build
        self._found: dict[str, ImpulseDerivatives] | None = None

    def _all(self) -> dict[str, ImpulseDerivatives]:
        if self._found is None:
            self._found = self._build()
        return self._found

    def __getitem__(self, name: str) -> ImpulseDerivatives:
        return self._all()[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._all())

    def __len__(self) -> int:
        return len(self._all())

    def __repr__(self) -> str:
        return repr(self._all())


def told(
    impact: Impact,
    workspace: Workspace,
    passed: Passing,
    touching: Sequence[Touching],
    null: np.ndarray,
    edges: tuple[str, ...],
    by_inertia: Callable[[int], np.ndarray],
) -> Derivatives:
    """What has passed all stages, as a result.

    Args:
        null: (m,) True for bilateral rows that move nothing and carry nothing.
    """
    columns, nv = passed.columns, workspace.model.nv
    velocity = passed.velocity
    if velocity is None:
        velocity = np.zeros((nv, columns.width))
    status = DerivativeStatus.EXISTS
    if any(point.coefficients.differenced for point in touching):
        status = DerivativeStatus.BY_DIFFERENCES
    if passed.consistent is not None and not passed.consistent.all():
        contradictory = np.flatnonzero(~passed.consistent)
        for table in (velocity, passed.multipliers, *passed.contacts):
            if table is not None:
                table[:, contradictory] = np.nan
        if not passed.consistent[: workspace.width_of_state].all():
            status = DerivativeStatus.RANK_CHANGES
    if edges and status.exists:
        status = DerivativeStatus.MODE_EDGE
    by_restitution, by_friction = columns.restitution.values(), columns.friction.values()
    restitution = [(n, c.start) for n, c in zip(columns.names, by_restitution, strict=True)]
    friction = [(n, c.start) for n, c in zip(columns.names, by_friction, strict=True)]

    def parts(tables: dict[str, np.ndarray]) -> dict[str, ImpulseDerivatives]:
        return {
            name: ImpulseDerivatives(*parts_of(table, workspace, restitution, friction))
            for name, table in tables.items()
        }

    def of_constraints() -> dict[str, ImpulseDerivatives]:
        return parts(_constraint_tables(impact, workspace, passed.multipliers, null))

    def of_contacts() -> dict[str, ImpulseDerivatives]:
        return parts(_contact_tables(impact, workspace, touching, passed.contacts, columns, nv))

    return Derivatives(
        impact,
        status,
        edges,
        *parts_of(velocity, workspace, restitution, friction),
        ByEntry(of_constraints),
        ByEntry(of_contacts),
        by_inertia,
    )


def parts_of(
    table: np.ndarray,
    workspace: Workspace,
    restitution: Sequence[tuple[str, int]],
    friction: Sequence[tuple[str, int]],
) -> _Parts:
    """The columns of a table, which is made read-only: by q, v, blow, restitution and friction.

    Args:
        restitution, friction: by contact, its column.
    """
    nv, blows = workspace.model.nv, workspace.blow_columns
    table.setflags(write=False)
    return (
        table[:, :nv],
        table[:, nv : 2 * nv],
        MappingProxyType({name: table[:, s] for name, s in blows.items()}) if blows else _NONE,
        MappingProxyType({name: table[:, c] for name, c in restitution}),
        MappingProxyType({name: table[:, c] for name, c in friction}),
    )


def _constraint_tables(
    impact: Impact,
    workspace: Workspace,
    multipliers: np.ndarray,
    null: np.ndarray,
) -> dict[str, np.ndarray]:
    """By constraint, (k, w) of its rows; NaN where they are not determined.

    Args:
        multipliers: (m, w) derivatives of λ.
    """
    outcome = impact.outcome
    tables = {}
    for name, where in zip(workspace.constraint_names, workspace.flat.slices, strict=True):
        table = multipliers[where]
        if outcome is not None and outcome.unique is not None:
            table = table.copy()
            table[~outcome.unique[where] & ~null[where]] = np.nan
        tables[name] = table
    return tables


def _contact_tables(
    impact: Impact,
    workspace: Workspace,
    touching: Sequence[Touching],
    impulses: Sequence[np.ndarray | None],
    columns: Columns,
    nv: int,
) -> dict[str, np.ndarray]:
    """By contact that touches, (3, w) in world axes; (1, w) of a joint stop.

    Args:
        impulses: by touching point, (3, w) derivatives of P in the axes of the contact,
            those by q in the first ``nv`` columns; None for zeros.
    """
    tables: dict[str, np.ndarray] = {}
    outcome = impact.outcome
    if outcome is None or outcome.contacts is None:
        return tables
    unique = outcome.contacts.unique
    found = outcome.contacts.impulse.reshape(-1, 3)
    for i, (point, touch) in enumerate(zip(touching, outcome.touches, strict=True)):
        given = impulses[i]
        if given is None:
            given = np.zeros((3, columns.width))
        if touch.axes is None:
            table = touch.jacobian[2].sum() * given[2:]
        else:
            table = touch.axes.dot(given)
            if point.rows.axes_by_q is not None:
                table[:, :nv] += (point.rows.axes_by_q @ found[i]).T
        if unique is not None and not unique[i]:
            table = np.full_like(table, np.nan)
        name = workspace.contact_names[point.entry]
        tables[name] = tables[name] + table if name in tables else table
    return tables
