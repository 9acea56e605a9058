"""Redundant impulses of one compression: the split that knows no axes.

Under Poisson's law e times the load of the compression comes back, so that v⁺ depends on how
redundant contacts shared it. Among all P that make the velocities found, Σ w |P|² is least at one
alone, w being the mobility of each contact: neither axes, units nor the order of contacts matter.
It is the limit of P(ε) for W + ε w as ε falls (Tikhonov), found by Newton on the modes.
"""

from __future__ import annotations

import numpy as np

from .modes import Modes

__all__ = ["least_split"]

# ε, relative to the mobilities: the last leaves P off by about as much, and its rounding, the
# spacing of doubles over ε, is as small.
STEPS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
# Velocities that differ by less than this share are those found.
SAME = 1e-5
# A contact that moves this share of what the lightest does counts as moving that much.
LIGHTEST = 1e-12


def least_split(modes: Modes, impulse: np.ndarray) -> np.ndarray:
    """P of least Σ w |P|² that makes the same velocities; P itself where none is found.

    Args:
        modes: the problem.
        impulse: (3n,) P, a solution [N s].
    """
    mobility = modes.delassus.diagonal().reshape(-1, 3).sum(axis=1)
    weights = np.repeat(np.maximum(mobility, LIGHTEST * mobility.max()), 3)
    least = impulse
    for share in STEPS:
        regular = modes.delassus.copy()
        regular.reshape(-1)[:: len(impulse) + 1] += share * weights
        near = Modes(regular, modes.shifted, modes.friction, modes.floor, modes.scale)
        least, residual = near.polish(least, ridge=0.0)
        if not residual < SAME:
            return impulse
    change = np.abs(modes.delassus @ (least - impulse)).max()
    if not change <= SAME * modes.scale:
        return impulse
    exact, residual = modes.polish(least)
    moved = np.abs(weights * (exact - least)).max() <= SAME * np.abs(weights * least).max()
    return exact if moved and residual <= modes.residual(impulse) + 1e-13 else least
