"""Residuals of an impact's equations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..formatting import Displayed

if TYPE_CHECKING:
    from .answer import Answer

__all__ = ["Residuals", "cancelling_speeds", "residuals_of"]


@dataclass(frozen=True)
class Residuals(Displayed):
    """Relative residuals, all without units.

    Attributes:
        momentum: largest |M Δv − I| over the sum of the absolute terms in its row, so
            that neither units nor scaling of a row matter. Where these terms are themselves
            rounding, as of a body that is struck through its mass centre and does not turn,
            over √(M_ii 2T), T the energy of Δv in all that hangs on the row's joint; among
            bilateral constraints or several contacts, over machine precision of that of the
            whole robot as well.
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


def residuals_of(impact: Answer) -> Residuals:
    """Return the residuals of an impact: those that the core measured, or of M Δv = I alone."""
    outcome = impact.outcome
    if outcome is None:
        return Residuals(momentum_residual(impact))
    return Residuals(*outcome.residuals)


def momentum_residual(impact: Answer) -> float:
    """Backward error of M Δv = I, componentwise as far as rows are not themselves rounding."""
    mass_matrix = impact.mechanics.mass_matrix
    difference = np.abs(mass_matrix @ impact.dv - impact.generalized_impulse)
    # Each row of I is itself a sum; the largest share of an impulse in it sets its rounding.
    scale = np.abs(mass_matrix) @ np.abs(impact.dv) + impact.mechanics.impulse_scale()
    # Of inertias that no body has either may be negative: then they measure nothing.
    carried = np.diagonal(mass_matrix) * impact.mechanics.carried_energy(impact.dv)
    scale += np.sqrt(np.where(carried < 0.0, 0.0, carried))
    # A NaN is no zero: it has to show.
    rows = ~(scale == 0.0)
    return float(np.max(difference[rows] / scale[rows], initial=0.0))


def cancelling_speeds(impact: Answer) -> np.ndarray:
    """(nv,) the speeds that cancel in v⁺: before, after, and what each impulse alone makes.

    Where everything comes to rest, v⁻ and v⁺ alone would measure rounding by rounding.
    """
    speeds = np.maximum(np.abs(impact.v_before), np.abs(impact.v_after))
    shares = np.array(list(impact.impulse_shares.values()))
    # Least squares, since M may be singular where constraints make up for it.
    alone = np.linalg.lstsq(impact.mechanics.mass_matrix, shares.T, rcond=None)[0]
    return speeds + np.abs(alone).sum(axis=1)
