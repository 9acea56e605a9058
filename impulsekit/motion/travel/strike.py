"""Points meet planes, in one compiled call: rows, law, v⁺, residuals.

It gives the velocities of what ``ImpactSolver`` gives, and a bound on the residuals by which that
is judged; what it can't answer to rounding is left to it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...geometry.point_table import Table
from ...laws.borrowed import borrowed, borrowing
from ...laws.compiled import compiled, entry
from ...laws.dense import put_rows
from ...laws.half import from_half, halve, is_safe
from ...laws.residual_bound import momentum_misfit
from ...laws.single import strike_at_end
from ...laws.status import Status
from ...laws.struck import is_faint, strike_at_once
from ...laws.tolerances import RESIDUAL_LIMIT, ROUNDING, ROUNDING_OF_SUMS
from ...laws.words import NEWTON
from ...rows.point_rows import write_rows
from ..steps.system import System
from ..tree.bodies import factorize_mass, look_at, write_jacobian, write_mass

__all__ = ["Blow", "room_for_blow", "strike_alone", "strike_point", "strike_together"]

# The statuses of several contacts that a motion follows.
_SOLVED, _NOT_UNIQUE, _JAM = int(Status.SOLVED), int(Status.NOT_UNIQUE), int(Status.PAINLEVE_JAM)


class Blow(NamedTuple):
    """What points did that met planes at once; room for m of them.

    Attributes:
        dv: (nv,) Δv.
        numbers: (4,) of a ``Together`` its code, ``residual``, ``off`` and ``fastest``.
        points: (3, 3m) and works: (3, m), as a ``Together`` has them.
        mass: (nv, nv) M.
    """

    dv: np.ndarray
    numbers: np.ndarray
    points: np.ndarray
    works: np.ndarray
    mass: np.ndarray


def _examples() -> tuple:
    from ..steps.tables import NO_POINTS, example_step

    system, *_ = example_step()
    coefficients = 0.5, 0.5, 0.0
    return system, NO_POINTS, system.q, system.load, coefficients, NEWTON, room_for_blow(6, 1)


def room_for_blow(nv: int, points: int) -> Blow:
    """Room for so many points."""
    return Blow(
        np.zeros(nv),
        np.zeros(4),
        np.zeros((3, 3 * points)),
        np.zeros((3, points)),
        np.zeros((nv, nv)),
    )


@entry(_examples, seconds=2.0)
def strike_point(
    system: System,
    table: Table,
    q: np.ndarray,
    v: np.ndarray,
    coefficients: tuple[float, float, float],
    restitution: int,
    blow: Blow,
) -> bool:
    """The impact of one point; see ``strike_alone``."""
    system, table, blow = borrowed(system), borrowed(table), borrowed(blow)
    return strike_alone(system, table, borrowed(q), borrowed(v), coefficients, restitution, blow)


@compiled
def strike_alone(
    system: System,
    table: Table,
    q: np.ndarray,
    v: np.ndarray,
    coefficients: tuple[float, float, float],
    restitution: int,
    blow: Blow,
) -> bool:
    """The impact of one point, written into ``blow``.

    Args:
        system: what moves. table: the point.
        q, v: the state before.
        coefficients: e, µ and tangential restitution. restitution: the law's word.
        blow: what it did.

    Returns:
        Whether that is the answer to rounding: not where a pivot of M is near rounding, the law
        has another status than solved, or residuals (``impact.residuals.at_most``) may be above
        rounding.
    """
    nv, mass, dv = len(v), blow.mass, blow.dv
    factor = system.room.factor
    if not _has_mass(system, q, v, mass):
        return False
    rows = np.empty((3, nv))
    write_rows(table, system.room.kinematics, rows)
    e, mu, e_t = coefficients
    if is_faint(rows, 0, mu):
        return False
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
    hit = strike_at_end(block, u, u, e, mu, e_t, restitution)
    p = np.array(hit.impulse)
    for k in range(nv):
        dv[k] = p[0] * half[0, k] + p[1] * half[1, k] + p[2] * half[2, k]
    from_half(factor, dv)
    off, most, left = hit.residual, 0.0, 0.0
    for i in range(3):
        after = u[i] + _dot(rows[i], dv)
        most = max(most, abs(u[i]), abs(after))
        left = max(left, abs(after - hit.after[i]))
    sizes = _sizes(rows, v, dv)
    misfit, bound = momentum_misfit(mass, rows, p, dv), hit.residual
    if sizes > 0.0:
        bound = max(bound, left / sizes)
    if most > 0.0:
        off = max(off, left / most)
    for i in range(3):
        blow.points[0, i], blow.points[1, i], blow.points[2, i] = p[i], hit.after[i], u[i]
    numbers, works = blow.numbers, blow.works
    numbers[0], numbers[1], numbers[2], numbers[3] = hit.code, hit.residual, left, most
    works[0, 0], works[1, 0], works[2, 0] = hit.normal_work, hit.friction_work, 1.0
    is_met = misfit <= RESIDUAL_LIMIT and bound <= RESIDUAL_LIMIT
    return hit.code == _SOLVED and off <= ROUNDING and is_met


@compiled
def strike_together(
    system: System,
    table: Table,
    q: np.ndarray,
    v: np.ndarray,
    coefficients: np.ndarray,
    restitution: int,
    blow: Blow,
) -> bool:
    """The impact of several points at once, written into ``blow``; whether it can be followed.

    Args:
        system, table, q, v, restitution: as for ``strike_alone``.
        coefficients: (3, n) µ, e and tangential restitution.
    """
    count = len(table.whole)
    factor = system.room.factor
    if not _has_mass(system, q, v, blow.mass):
        return False
    rows = np.empty((3 * count, len(v)))
    write_rows(table, system.room.kinematics, rows)
    code, residual, off, fastest, _, _, jump, points, works = strike_at_once(
        factor.factor, factor.pivots, rows, v, coefficients, restitution
    )
    if code not in (_SOLVED, _NOT_UNIQUE, _JAM):
        return False
    if not (residual <= ROUNDING and off <= ROUNDING_OF_SUMS * fastest):
        return False
    if not momentum_misfit(blow.mass, rows, points[0], jump) <= RESIDUAL_LIMIT:
        return False
    if not off <= RESIDUAL_LIMIT * _sizes(rows, v, jump):
        return False
    numbers = blow.numbers
    numbers[0], numbers[1], numbers[2], numbers[3] = code, residual, off, fastest
    blow.dv[:] = jump
    blow.points[:, : 3 * count] = points
    blow.works[:, :count] = works
    return True


@borrowing
def _has_mass(system: System, q: np.ndarray, v: np.ndarray, mass: np.ndarray) -> bool:
    """Look at a state; write M (nv, nv), its lower half; whether no pivot of it is rounding."""
    look_at(system.tree, system.room, q, v)
    write_jacobian(system.tree, system.room)
    write_mass(system.tree, system.room)
    put_rows(system.room.factor.factor, mass)
    factorize_mass(system.room)
    return is_safe(system.room.factor)


@borrowing
def _sizes(rows: np.ndarray, v: np.ndarray, dv: np.ndarray) -> float:
    """The largest sum of the terms of J v⁻ or J v⁺ [m/s]."""
    sizes = 0.0
    for i in range(len(rows)):
        size = 0.0
        for k in range(len(v)):
            size += abs(rows[i, k]) * max(abs(v[k]), abs(v[k] + dv[k]))
        sizes = max(sizes, size)
    return sizes


@borrowing
def _dot(a: np.ndarray, b: np.ndarray) -> float:
    total = 0.0
    for k in range(len(a)):
        total += a[k] * b[k]
    return total
