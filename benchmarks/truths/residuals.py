"""What an answer leaves of its equations, relative, in 50 digits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from impulsekit.reference.arithmetic import Array

from .equations import SEPARATED, Equations
from .found import Found
from .numbers import EPS, SMALLEST


@dataclass(frozen=True)
class Residuals:
    """What an answer leaves of its equations, relative, computed in 50 digits.

    Attributes:
        momentum: of M Δv = I + Aᵀλ + JᵀP, by row over the sizes of its terms: the componentwise
            backward error (Oettli & Prager 1964), where nothing is known better than to the
            spacing of denormal numbers.
        law: of the bilateral rows, by row likewise; of the contact law over the velocities in it.
    """

    momentum: float
    law: float


def residuals_of(equations: Equations, found: Found) -> Residuals:
    """What an answer leaves of its equations."""
    if found.dv is None or not np.isfinite(found.dv).all():
        return Residuals(np.inf, np.inf)
    n, r = equations.n, equations.r
    impulses = equations.own_axes(found)
    if impulses is None:
        return Residuals(np.nan, np.nan)
    x = np.concatenate([equations.numbers.array(found.dv), impulses])
    left = np.abs(equations.left_over(x, [SEPARATED] * equations.c)[: n + r])
    # An entry of x stands for what is half a spacing off it, too.
    spaced = np.maximum(np.abs(x), equations.numbers.number(SMALLEST / EPS))
    momentum = share_of(left[:n], equations.momentum_size(spaced))
    # Beside what rests, velocities are those of what the blow would do to the heaviest body.
    heaviest = np.max(equations.m.weights / equations.m.spans)
    floor = np.max(equations.m.known_size / equations.m.weights) / heaviest / equations.m.spans
    speeds = np.abs(x[:n]) + np.abs(equations.v) + floor
    law = 0.0
    if r:
        law = share_of(left[n:], equations.m.rows_size @ speeds + np.abs(equations.m.target))
    if equations.c:
        law = max(law, _law_left(equations, x, speeds))
    return Residuals(momentum, law)


def _law_left(equations: Equations, x: Array, speeds: Array) -> float:
    """The natural map of the contact law over the velocities at hand."""
    xi = equations.xi(x)
    moving = equations.m.contacts_size @ speeds
    scale = np.max(moving)
    worst = equations.numbers.number(0)
    for i in range(equations.c):
        at, p = 3 * i, equations.n + equations.r + 3 * i
        units = equations.units[p : p + 3]
        rate = units[0] ** 2 + units[1] ** 2
        # Impulses in balance make velocities that nobody sees.
        pushed = max(units[2] ** 2 * abs(x[p + 2]), rate * equations.numbers.norm(x[p : p + 2]))
        scale = max(scale, pushed)
        worst = max(worst, abs(min(xi[at + 2], units[2] ** 2 * x[p + 2])))
        mu = equations.coefficients.mu[i]
        if not mu:
            continue
        q = x[p : p + 2] - xi[at : at + 2] / rate
        bound = max(mu * x[p + 2], equations.numbers.number(0))
        size = equations.numbers.norm(q)
        if size > bound:
            q = q * (bound / size)
        worst = max(worst, rate * equations.numbers.norm(x[p : p + 2] - q))
    return float(worst / scale) if scale > 0 else float(worst)


def share_of(left: Array, sizes: Array) -> float:
    """The largest entry of ``left`` over its size."""
    worst = 0.0
    for entry, size in zip(left, sizes, strict=True):
        if size > 0:
            worst = max(worst, float(entry / size))
        elif entry != 0:
            return float("inf")
    return worst
