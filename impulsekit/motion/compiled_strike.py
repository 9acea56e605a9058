"""A lone point meets a plane while nothing rests, in one compiled call: rows, law, v⁺, residuals.

It gives the velocities of what ``ImpactSolver`` gives, and a bound on the residuals by which that
is judged; what it can't answer to rounding is left to it.
"""

from __future__ import annotations

import numpy as np

from ..laws.compiled import compiled, entry
from ..laws.half import from_half, halve, is_safe
from ..laws.single import strike_at_end
from ..laws.words import NEWTON
from .compiled_step import System
from .points import Table, write_rows
from .tree import factorize_mass, look_at, write_jacobian, write_mass

__all__ = ["strike_point"]

# [of the terms of the approach] What closes more slowly is known to few digits, and Δv is not to
# be told beside impulses that another program finds from the same state.
FAINT_APPROACH = 1e-4


def _examples() -> tuple:
    from .compiled_model import NO_POINTS, example_step

    system, *_ = example_step()
    return system, NO_POINTS, system.q, system.load, (0.5, 0.5, 0.0), NEWTON, np.zeros((6, 6))


@entry(_examples, seconds=4.0)
def strike_point(
    system: System,
    table: Table,
    q: np.ndarray,
    v: np.ndarray,
    coefficients: tuple[float, float, float],
    restitution: int,
    mass: np.ndarray,
) -> tuple[int, float, float, np.ndarray]:
    """The impact of one point.

    Args:
        system: what moves. table: the point.
        q, v: the state before.
        coefficients: e, µ and tangential restitution. restitution: the law's word.
        mass: (nv, nv) room.

    Returns:
        The code of the law's status, −1 where a pivot of M or the approach is near rounding; how
        far the law and Δv are from what they should be [of the velocities at the point]; a
        bound on the largest residual (``impact.residuals.at_most``); and (nv,) Δv.
    """
    nv = len(v)
    factor, kinematics = system.room.factor, system.room.kinematics
    look_at(system.tree, system.room, q, v)
    write_jacobian(system.tree, system.room)
    write_mass(system.tree, system.room)
    mass[:] = factor.factor
    factorize_mass(system.room)
    dv = np.zeros(nv)
    if not is_safe(factor):
        return -1, 0.0, 0.0, dv
    rows = np.empty((3, nv))
    write_rows(table, kinematics, rows)
    half = rows.copy()
    for i in range(3):
        halve(factor, half[i])
    u = (_dot(rows[0], v), _dot(rows[1], v), _dot(rows[2], v))
    block = (
        _dot(half[0], half[0]),
        _dot(half[0], half[1]),
        _dot(half[1], half[1]),
        _dot(half[0], half[2]),
        _dot(half[1], half[2]),
        _dot(half[2], half[2]),
    )
    e, mu, e_t = coefficients
    hit = strike_at_end(block, u, u, e, mu, e_t, restitution)
    p = hit.impulse
    for k in range(nv):
        dv[k] = p[0] * half[0, k] + p[1] * half[1, k] + p[2] * half[2, k]
    from_half(factor, dv)
    off, most, left, sizes = hit.residual, 0.0, 0.0, 0.0
    for i in range(3):
        after, size = u[i] + _dot(rows[i], dv), 0.0
        most = max(most, abs(u[i]), abs(after))
        left = max(left, abs(after - hit.after[i]))
        for k in range(nv):
            size += abs(rows[i, k]) * max(abs(v[k]), abs(v[k] + dv[k]))
        sizes = max(sizes, size)
    if abs(u[2]) < FAINT_APPROACH * sizes:
        return -1, 0.0, 0.0, dv
    bound = max(hit.residual, _momentum(rows, p, dv, mass))
    if sizes > 0.0:
        bound = max(bound, left / sizes)
    if most > 0.0:
        off = max(off, left / most)
    return hit.code, off, bound, dv


@compiled
def _dot(a: np.ndarray, b: np.ndarray) -> float:
    total = 0.0
    for k in range(len(a)):
        total += a[k] * b[k]
    return total


@compiled
def _momentum(
    rows: np.ndarray, p: tuple[float, float, float], dv: np.ndarray, mass: np.ndarray
) -> float:
    """|M Δv − JᵀP| over the sum of its terms, the largest row's; M by its lower half."""
    nv, worst = len(dv), 0.0
    for i in range(nv):
        left, size = 0.0, 0.0
        for k in range(nv):
            term = mass[max(i, k), min(i, k)] * dv[k]
            left += term
            size += abs(term)
        for k in range(3):
            term = rows[k, i] * p[k]
            left -= term
            size += abs(term)
        if left != 0.0:
            worst = max(worst, abs(left) / size)
    return worst
