"""How far relative changes of the data move the solution of the equations.

The condition is that of the linear equations K x = f at the solution: data that are known
to eps E and eps |f| move x by eps |K⁻¹| (E |x| + |f|) at most (Skeel 1979; Higham,
"Accuracy and stability of numerical algorithms", 7.2), with the sizes of ``mechanics`` in E.
It knows no norm and no units.
"""

from __future__ import annotations

import numpy as np

from impulsekit.reference.arithmetic import Array

from .equations import SEPARATED, STICKING, Equations
from .found import Exact
from .numbers import EPS

# Velocities below so many times their rounding.
DEGENERATE = 100


def conditioned(
    equations: Equations, x: Array, modes: list[int], inverse: Array, rank: int
) -> Exact:
    """The solution with what relative changes of the data do to it.

    Args:
        equations: of the state.
        x: (n + r + 3c,) their solution.
        modes: of the contacts.
        inverse, rank: a generalized inverse of the scaled K there, and its rank.
    """
    n = equations.n
    sizes = equations.sizes(x, modes) / equations.rows_units(modes)
    slack = (np.abs(inverse) @ sizes) / equations.units
    has_impulses = len(x) > n
    if has_impulses:
        # What is held altogether stays at rest whatever the data; rounding there is that of
        # what the blow would do to the heaviest body.
        m = equations.m
        heaviest = np.max(m.weights / m.spans)
        slack[:n] += np.max(m.known_size / m.weights) / heaviest / m.spans
    violation, degenerate = 0.0, False
    if equations.c:
        speeds = np.abs(x[:n]) + np.abs(equations.v)
        rounding = equations.m.contacts_size @ (speeds + slack[:n])
        violation = _violation(equations, x, modes, rounding)
        # A contact that parts by next to nothing might as well bear the load of others.
        parting = rounding[2::3] * (DEGENERATE * EPS)
        xi = equations.xi(x)[2::3]
        degenerate = any(
            mode == SEPARATED and abs(xi[i]) <= parting[i] for i, mode in enumerate(modes)
        )
        for i in range(equations.c):
            # Told in world axes, components round like the length; and what rounding
            # leaves of a velocity may be taken for a push.
            at, p = slice(3 * i, 3 * i + 3), n + equations.r + 3 * i
            own = slice(p, p + 3)
            slack[own] += np.abs(x[own]).sum() + rounding[at] / equations.units[own] ** 2
    return Exact(
        dv=x[:n],
        slack=slack[:n],
        weights=equations.m.spans,
        impulses_weights=equations.units[n:],
        impulses=x[n:] if has_impulses else None,
        impulses_slack=slack[n:] if has_impulses else None,
        determined=rank == len(x) and not degenerate,
        violation=violation,
        before=equations.v if has_impulses else None,
    )


def _violation(equations: Equations, x: Array, modes: list[int], rounding: Array) -> float:
    """What is left of the inequalities, in units of eps times what rounding may do."""
    worst = equations.numbers.number(0)
    xi = equations.xi(x)
    for i, mode in enumerate(modes):
        at, p = 3 * i, equations.n + equations.r + 3 * i
        normal = equations.units[p + 2] ** 2
        if mode == SEPARATED:
            worst = max(worst, -xi[at + 2] / rounding[at + 2])
            continue
        size = rounding[at + 2] + normal * abs(x[p + 2])
        worst = max(worst, -x[p + 2] * normal / size)
        if mode == STICKING:
            beyond = equations.numbers.norm(x[p : p + 2]) - equations.coefficients.mu[i] * x[p + 2]
            rate = equations.units[p] ** 2 + equations.units[p + 1] ** 2
            size = max(rounding[at : at + 2]) + rate * abs(x[p + 2])
            worst = max(worst, beyond * rate / size)
    return float(worst) / EPS
