"""How well an answer satisfies its own equations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..laws.residual_bound import bound_residual
from .contact_space.problem import in_order

if TYPE_CHECKING:
    from .answer import Answer

__all__ = ["Residuals", "at_most", "cancelling_speeds", "residuals_of"]


@dataclass(frozen=True)
class Residuals:
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
    """The residuals of an impact."""
    return Residuals(
        momentum=momentum_residual(impact),
        constraint=constraint_residual(impact),
        complementarity=complementarity_residual(impact),
    )


def at_most(impact: Answer) -> float:
    """A bound on the largest residual of contacts alone, for a part of what that takes.

    Infinity where known impulses or constraints take part.
    """
    outcome = impact.outcome
    if outcome is None or outcome.contacts is None or impact.scene.impulses:
        return np.inf
    if len(outcome.constraint_impulses) or impact.scene.constraints:
        return np.inf
    touches, solution = outcome.touches, outcome.contacts
    points = 3 * sum(touch.turns < 0 for touch in touches)
    rows = touches[0].jacobian if len(touches) == 1 else np.vstack([t.jacobian for t in touches])
    bound = bound_residual(
        in_order(impact.mechanics.mass_matrix),
        in_order(rows),
        in_order(solution.impulse),
        in_order(impact.v_before),
        in_order(impact.dv),
        in_order(solution.velocity_after),
        points,
    )
    return float(solution.residual) if bound <= solution.residual else bound


# What is slower than this part of the fastest is still but for rounding, such as all that hangs on
# a robot that is held: what is left of it is measured by the fastest.
STILL = 1e-12
# From here on [relative] a row is measured by what could stand in it: below, no answer is worse
# than its rounding, and the sizes need not be worked out.
ALL_BUT_ROUNDING = 1e-15


def momentum_residual(impact: Answer) -> float:
    """Backward error of M Δv = I, componentwise as far as rows are not themselves rounding."""
    mass_matrix = impact.mechanics.mass_matrix
    difference = np.abs(mass_matrix @ impact.dv - impact.generalized_impulse)
    # Each row of I is itself a sum; the largest share of an impulse in it sets its rounding.
    scale = np.abs(mass_matrix) @ np.abs(impact.dv) + impact.mechanics.impulse_scale()
    outcome = impact.outcome
    if outcome is not None and len(outcome.constraint_impulses):
        forces = np.abs(outcome.constraint_impulses)
        scale += forces @ np.abs(impact.mechanics.constraint_matrix)
    if outcome is not None and outcome.contacts is not None:
        triples = np.abs(outcome.contacts.impulse).reshape(-1, 3)
        for touch, impulse in zip(outcome.touches, triples, strict=True):
            scale += impulse @ np.abs(touch.jacobian)
    # A NaN is no zero: it has to show.
    rows = ~(scale == 0.0)
    largest = float(np.max(difference[rows] / scale[rows], initial=0.0))
    if largest < ALL_BUT_ROUNDING:
        return largest
    diagonal = np.diagonal(mass_matrix)
    scale += np.sqrt(diagonal * impact.mechanics.carried_energy(impact.dv))
    if outcome is not None and (len(outcome.constraint_impulses) or len(outcome.touches) > 1):
        # Their impulses are found together: the rounding of large ones is in all.
        energies = [max(float(u @ mass_matrix @ u), 0.0) for u in (impact.dv, impact.v_before)]
        scale += np.finfo(float).eps * np.sqrt(diagonal * energies[0])
        # Of Δv that is but the rounding of v there is nothing else to measure by.
        whole = np.sqrt(diagonal * max(energies))
        scale += np.where(scale > STILL * whole, 0.0, whole)
    return float(np.max(difference[rows] / scale[rows], initial=0.0))


def constraint_residual(impact: Answer) -> float:
    """Largest |A v⁺ − b| over the largest velocity that the rows are made of."""
    if not impact.constraints:
        return 0.0
    matrix, rows = impact.mechanics.constraint_matrix, impact.mechanics.constraint_rows
    difference = np.abs(matrix @ impact.v_after - rows.target(matrix @ impact.v_before))
    return _share(difference, _terms(matrix, cancelling_speeds(impact)) + np.abs(rows.velocity))


def complementarity_residual(impact: Answer) -> float:
    """What the contact law left over, or how far Δv is from what the law was told."""
    outcome = impact.outcome
    if outcome is None or outcome.contacts is None:
        return 0.0
    solution = outcome.contacts
    jacobian = np.vstack([touch.jacobian for touch in outcome.touches])
    # Rows that the law does not use (tangents without friction) count as well: Δv must
    # give every velocity that the law was solved with.
    difference = np.abs(jacobian @ impact.v_after - solution.velocity_after)
    mismatch = _mismatch(difference, _terms(jacobian, cancelling_speeds(impact)), impact)
    return max(float(solution.residual), mismatch)


def _mismatch(difference: np.ndarray, scale: np.ndarray, impact: Answer) -> float:
    """As ``_share``, the rows of turning [rad/s] apart from those of points [m/s]."""
    outcome = impact.outcome
    points = 0 if outcome is None else 3 * sum(touch.turns < 0 for touch in outcome.touches)
    own = _share(difference[:points], scale[:points])
    return max(own, _share(difference[points:], scale[points:]))


def cancelling_speeds(impact: Answer) -> np.ndarray:
    """(nv,) the speeds that cancel in v⁺: before, after, and what each impulse alone makes.

    Where everything comes to rest, v⁻ and v⁺ alone would measure rounding by rounding.
    """
    speeds = np.maximum(np.abs(impact.v_before), np.abs(impact.v_after))
    shares = np.array(list(impact.impulse_shares.values()))
    # Least squares, since M may be singular where constraints make up for it.
    alone = np.linalg.lstsq(impact.mechanics.mass_matrix, shares.T, rcond=None)[0]
    return speeds + np.abs(alone).sum(axis=1)


def _terms(rows: np.ndarray, speeds: np.ndarray) -> np.ndarray:
    """(m,) how large the terms are that rows are sums of, with the speeds of all (nv,)."""
    sizes = np.abs(rows)
    own, fastest = sizes @ speeds, sizes.sum(axis=1) * speeds.max(initial=0.0)
    return own if own.max(initial=0.0) > STILL * fastest.max(initial=0.0) else fastest


def _share(difference: np.ndarray, scale: np.ndarray) -> float:
    """The largest difference over the largest scale; 0 where nothing moves at all."""
    largest = scale.max(initial=0.0)
    return 0.0 if largest == 0.0 else float(difference.max(initial=0.0) / largest)
