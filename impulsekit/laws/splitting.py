"""Several contacts with friction by operator splitting (ADMM), which knows no order of contacts.

½ xᵀW x + (b + s)ᵀx over the friction cones, s_n = µ|ξ_t| being De Saxcé's correction, which
makes a convex problem of Coulomb's law at every step (Acary, Cadoux, Lemaréchal & Malick
2011); x and its copy y in the cones are brought together by z (Carpentier et al. 2024).
"""

from __future__ import annotations

import math

import numpy as np

from .compiled import compiled
from .dense import invert
from .workspace import Workspace

__all__ = ["split"]


@compiled
def split(work: Workspace, n: int, steps: int, rate: float) -> float:
    """Improve y (3n,) in the cones by some steps, z (3n,) being kept; the rate to go on with.

    y and z are in units of ``work.unit`` (n,): P = unit y, of one size for a contact's three rows.
    """
    W, b, mu, y, z, unit = work.W, work.b, work.mu, work.y, work.z, work.unit
    inverse, x, last, right = work.matrix, work.x, work.moved, work.best
    size = 3 * n
    fresh = True
    for step in range(steps):
        if fresh:
            for i in range(size):
                for j in range(size):
                    inverse[i, j] = unit[i // 3] * W[i, j] * unit[j // 3]
                inverse[i, i] += rate
            if not invert(inverse, size, last):
                return rate
            fresh = False
        for i in range(n):
            k = 3 * i
            slip = math.sqrt(z[k] * z[k] + z[k + 1] * z[k + 1])
            for j in range(k, k + 3):
                right[j] = rate * y[j] - unit[i] * b[j] - z[j]
            right[k + 2] -= mu[i] * slip
        for i in range(size):
            x[i] = 0.0
        # By columns, which lie as the rows do: many entries at once.
        for j in range(size):
            share = right[j]
            for i in range(size):
                x[i] += share * inverse[j, i]
        apart = 0.0
        moved = 0.0
        for i in range(n):
            k = 3 * i
            for j in range(k, k + 3):
                last[j] = y[j]
                y[j] = x[j] + z[j] / rate
            _project(y, k, mu[i])
            for j in range(k, k + 3):
                z[j] += rate * (x[j] - y[j])
                apart = max(apart, abs(x[j] - y[j]))
                moved = max(moved, abs(y[j] - last[j]))
        if step % 20 == 19:
            if apart > 8.0 * moved:
                rate *= 4.0
                fresh = True
            elif moved > 8.0 * apart:
                rate *= 0.25
                fresh = True
    return rate


@compiled
def _project(y: np.ndarray, k: int, mu: float) -> None:
    """The nearest point of the cone |y_t| ≤ µ y_n."""
    size = math.sqrt(y[k] * y[k] + y[k + 1] * y[k + 1])
    if size <= mu * y[k + 2]:
        return
    if mu * size <= -y[k + 2]:
        y[k], y[k + 1], y[k + 2] = 0.0, 0.0, 0.0
        return
    normal = (y[k + 2] + mu * size) / (1.0 + mu * mu)
    factor = mu * normal / size if size > 0.0 else 0.0
    y[k], y[k + 1], y[k + 2] = factor * y[k], factor * y[k + 1], normal
