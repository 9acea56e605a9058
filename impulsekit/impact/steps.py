"""How Δv follows the contacts' impulses, for an answer that is to be refined."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ..laws.rank_tolerances import IN_SPAN
from ..tolerances import NONZERO

if TYPE_CHECKING:
    from .contact_space.refine import Steps, System

__all__ = ["steps_of"]


def steps_of(
    mass_matrix: np.ndarray,
    known: np.ndarray,
    jacobian: np.ndarray,
    rows: np.ndarray,
    moved_by: Callable[[np.ndarray], np.ndarray],
    multipliers: Callable[[np.ndarray], np.ndarray],
) -> Steps:
    """The ways to change Δv with the contacts' impulses.

    Args:
        mass_matrix: (nv, nv) M.
        known: (nv,) I of the known impulses.
        jacobian: (3n, nv) J.
        rows: (m, nv) A.
        moved_by: from a change of P (3n,) to the change of Δv.
        multipliers: from P to λ (m,).
    """
    from .contact_space.refine import Steps

    roots = np.sqrt(np.maximum(mass_matrix.diagonal(), NONZERO))

    def momentum(impulse: np.ndarray, dv: np.ndarray) -> tuple[np.ndarray, float]:
        """I + JᵀP + Aᵀλ − M Δv, and its largest share in the terms."""
        held = multipliers(impulse)
        left = known + impulse.dot(jacobian) + held.dot(rows) - mass_matrix.dot(dv)
        sizes = roots * roots.dot(np.abs(dv)) + np.abs(known)
        sizes += np.abs(impulse).dot(np.abs(jacobian)) + np.abs(held).dot(np.abs(rows))
        return left, float((np.abs(left) / np.where(sizes > 0.0, sizes, 1.0)).max())

    def together(system: System, lacking: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """M Δ − (J Way)ᵀ x − Aᵀ λ = lacking, Aimᵀ J Δ + stiffness x = −right, A Δ = 0."""
        push, pull = system.way.dot(jacobian), system.aim.dot(jacobian)
        n, m = len(mass_matrix), len(push)
        matrix = np.zeros((n + m + len(rows), n + m + len(rows)))
        matrix[:n, :n] = mass_matrix
        matrix[:n, n : n + m], matrix[:n, n + m :] = -push.T, -rows.T
        matrix[n : n + m, :n], matrix[n + m :, :n] = pull, rows
        matrix[n : n + m, n : n + m] = np.diag(system.stiffness)
        right = np.zeros(len(matrix))
        right[:n] = lacking
        right[n : n + m] = -system.right
        # Speeds in units of √M_ii, impulses in those of their rows.
        sizes = np.sqrt(((np.concatenate([pull, rows]) / roots) ** 2).sum(axis=1))
        units = 1.0 / np.concatenate([roots, np.where(sizes > 0.0, sizes, 1.0)])
        scaled = matrix * units * units[:, None]
        found = units * np.linalg.lstsq(scaled, units * right, rcond=IN_SPAN)[0]
        return found[:n], found[n : n + m]

    return Steps(jacobian, moved_by, momentum, together)
