"""How well an answer satisfies its own equations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .result import Impact

__all__ = ["Residuals", "residuals_of"]


@dataclass(frozen=True)
class Residuals:
    """Relative residuals, all without units.

    Attributes:
        momentum: largest |M Δv − I| over the sum of the absolute terms in its row, so
            that neither units nor scaling of a row matter.
        constraint: of the bilateral constraints; 0 without any.
        complementarity: of the contacts; 0 without any.
    """

    momentum: float
    constraint: float = 0.0
    complementarity: float = 0.0

    @property
    def largest(self) -> float:
        """The largest of them; NaN if any is."""
        return float(np.max([self.momentum, self.constraint, self.complementarity]))


def residuals_of(impact: Impact) -> Residuals:
    """The residuals of an impact."""
    return Residuals(momentum=momentum_residual(impact), constraint=constraint_residual(impact))


def momentum_residual(impact: Impact) -> float:
    """Componentwise backward error of M Δv = I."""
    mass_matrix = impact.mechanics.mass_matrix
    difference = np.abs(mass_matrix @ impact.dv - impact.generalized_impulse)
    # Each row of I is itself a sum; the largest share of an impulse in it sets its rounding.
    scale = np.abs(mass_matrix) @ np.abs(impact.dv) + impact.mechanics.impulse_scale()
    if impact.outcome is not None:
        forces = np.abs(impact.outcome.constraint_impulses)
        scale += forces @ np.abs(impact.mechanics.constraint_matrix)
    rows = scale > 0.0
    return float(np.max(difference[rows] / scale[rows], initial=0.0))


def constraint_residual(impact: Impact) -> float:
    """Largest |A v⁺ − b| over the largest velocity that the rows are made of."""
    if not impact.constraints:
        return 0.0
    matrix, rows = impact.mechanics.constraint_matrix, impact.mechanics.constraint_rows
    difference = np.abs(matrix @ impact.v_after - rows.target(matrix @ impact.v_before))
    speeds = np.maximum(np.abs(impact.v_before), np.abs(impact.v_after))
    scale = np.max(np.abs(matrix) @ speeds + np.abs(rows.velocity), initial=0.0)
    return float(difference.max(initial=0.0) / scale) if scale > 0.0 else 0.0
