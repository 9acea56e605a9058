"""Redundant contacts whose targets contradict each other: one of them bears nothing.

Where two corners of a face rest and the others strike, e·u_n⁻ is asked of the latter alone.
Four corners of a rigid face have only three velocities between them, so that all four targets
are met at once only up to rounding of u⁻, or not at all. Then Newton on the modes keeps all
four loaded and cannot get below what the targets contradict each other by. The law has its
answer where one corner parts a little faster than it has to, and carries no impulse.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from .modes import Modes

if TYPE_CHECKING:
    from .frictional import Frictional

__all__ = ["unload"]

# From few contacts and an impulse nearby to theirs.
Find = Callable[[Modes, np.ndarray], np.ndarray]

# Residuals between these are looked at: below is rounding, above the modes are not yet known.
ROUNDING, FAR = 1e-13, 1e-4


def unload(modes: Modes, impulse: np.ndarray, residual: float) -> tuple[np.ndarray, float]:
    """P and its residual with one contact after the other unloaded, where that is nearer.

    Args:
        modes: the problem, without a floor.
        impulse: (3n,) P [N s] as Newton leaves it.
        residual: relative to the velocities.
    """
    from .frictional import solve_frictional

    loaded = impulse[2::3] > 0.0
    while ROUNDING < residual < FAR and loaded.sum() > 1:
        nearest = impulse, residual, -1
        # Mostly the others stay in their modes.
        for find in (lambda few, start: few.polish(start)[0], _afresh(solve_frictional)):
            for i in np.flatnonzero(loaded).tolist():
                others = loaded.copy()
                others[i] = False
                tried = _with(modes, others, impulse, find)
                left = modes.residual(tried)
                if left < nearest[1]:
                    nearest = tried, left, i
            if nearest[1] <= ROUNDING:
                break
        impulse, residual, which = nearest
        if which < 0:
            break
        loaded[which] = False
    return impulse, residual


def _afresh(solve: Callable[..., Frictional]) -> Find:
    return lambda few, _: solve(few.delassus, few.shifted, few.friction).impulse


def _with(modes: Modes, loaded: np.ndarray, impulse: np.ndarray, find: Find) -> np.ndarray:
    """(3n,) what is found with these contacts alone."""
    rows = np.flatnonzero(np.repeat(loaded, 3))
    few = Modes(
        np.ascontiguousarray(modes.delassus[np.ix_(rows, rows)]),
        modes.shifted[rows],
        modes.friction[loaded],
        None,
    )
    found = np.zeros_like(impulse)
    # Contacts that no impulse moves bear none.
    if few.largest > 0.0:
        found[rows] = find(few, impulse[rows])
    return found
