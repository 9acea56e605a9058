"""Derivatives of impulses by entry of the scene, in the axes in which results tell them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..result import Impact
from .linear import Rows, Touching

__all__ = ["constraint_tables", "contact_tables"]


def constraint_tables(
    impact: Impact, bilateral: Sequence[Rows], multipliers: np.ndarray, null: np.ndarray
) -> dict[str, np.ndarray]:
    """By constraint, (k, w) of its rows; NaN where they are not determined.

    Args:
        multipliers: (m, w) derivatives of λ.
        null: True for rows that move nothing and carry nothing.
    """
    outcome = impact.outcome
    tables = {}
    at = 0
    for name, rows in zip(impact.scene.entry_names("constraints"), bilateral, strict=True):
        where = slice(at, at + len(rows.matrix))
        table = multipliers[where].copy()
        if outcome is not None and outcome.unique is not None:
            table[~outcome.unique[where] & ~null[where]] = np.nan
        tables[name] = table
        at = where.stop
    return tables


def contact_tables(
    impact: Impact, touching: Sequence[Touching], impulses: Sequence[np.ndarray], nv: int
) -> dict[str, np.ndarray]:
    """By contact that touches, (3, w) in world axes; (1, w) of a joint stop.

    Args:
        impulses: by touching point, (3, w) derivatives of P in the axes of the contact,
            those by q in the first ``nv`` columns.
    """
    names = impact.scene.entry_names("contacts")
    tables: dict[str, np.ndarray] = {}
    outcome = impact.outcome
    if outcome is None or outcome.contacts is None:
        return tables
    unique = outcome.contacts.unique
    found = outcome.contacts.impulse.reshape(-1, 3)
    for i, (point, touch) in enumerate(zip(touching, outcome.touches, strict=True)):
        if touch.axes is None:
            table = touch.jacobian[2].sum() * impulses[i][2:]
        else:
            table = touch.axes @ impulses[i]
            turned = point.rows.turned(touch.axes @ found[i])
            if turned is not None:
                table[:, :nv] += turned
        if unique is not None and not unique[i]:
            table = np.full_like(table, np.nan)
        name = names[point.entry]
        tables[name] = tables[name] + table if name in tables else table
    return tables
