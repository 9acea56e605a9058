"""What rests, after a step or an impact, in one compiled call.

It does what ``course.settling`` does otherwise.

Points with a gap and a rate of their own are laid down, begin to slide or cease to, and their
drift is taken out. What lifts is left to ``settling``: it has to be told.
"""

from __future__ import annotations

import numpy as np

from ...laws.borrowed import borrowed, borrowing
from ...laws.compiled import compiled, entry
from ...laws.dense import cholesky, lower_solve
from ...laws.half import from_half, halve, is_safe
from ...rows.point_rows import gaps_and_rates, write_rows
from ..steps.compiled import SOLVED, accelerate
from ..steps.system import System
from ..tree.bodies import PLANAR, Tree, look_at, write_factor, write_jacobian
from ..tree.coordinates import centre, write_configuration
from ..tree.pressed import STICKS
from .slip import begin_slides, update_slides

__all__ = [
    "LIFTED",
    "LIFTS",
    "MOST_STEPS",
    "NO_DRIFT",
    "settle",
    "settle_points",
]

# What became of it, besides what becomes of a step: a point lifts, and nothing was changed.
LIFTS = 3
# A resting contact that does not push and opens faster than this has lifted [m/s].
LIFTED = 0.5e-8
# Drift below this [m, rad] or [m/s] is left alone.
NO_DRIFT = 1e-14
# Newton on positions: the second step ends at rounding, the third makes sure.
MOST_STEPS = 3
# Rows that depend on each other more than this, by a squared sine, share what they do; parts of
# them that are smaller [relative] are none.
APART, NOTHING_LEFT = 1e-6, 1e-7


def _examples() -> tuple:
    from ..steps.tables import example_step

    system, *_ = example_step()
    return system, np.zeros(0), system.q, system.load, False, False


@entry(_examples, seconds=9.0, apart=True)
def settle_points(
    system: System, driven: np.ndarray, q: np.ndarray, v: np.ndarray, fresh: bool, lay: bool
) -> tuple[int, bool]:
    """Look at the points that rest: which of them slide from here on; drift is taken out.

    Args:
        system: what moves; its table has all points that rest, ``sliding.ways`` what they did and
            do from now on.
        driven: what is driven in time, now.
        q, v: the state, which is changed.
        fresh: after an impact: slip decides alone. lay: points are laid down first.

    Returns:
        What became of it, and whether anything has changed. Of ``LIFTS`` nothing has, unless
        points were laid down.
    """
    return settle(borrowed(system), borrowed(driven), borrowed(q), borrowed(v), fresh, lay)


@compiled
def settle(
    system: System, driven: np.ndarray, q: np.ndarray, v: np.ndarray, fresh: bool, lay: bool
) -> tuple[int, bool]:
    """As ``settle_points``."""
    n, sliding = len(system.table.whole), system.sliding
    if lay:
        laid = np.ones((n, 3), np.bool_)
        laid[:, :2] = False
        if not _take_out_drift(system, laid, q, v):
            return LIFTS, False
    if fresh:
        _look(system, q, v)
        rows = np.empty((3 * n, len(v)))
        write_rows(system.table, system.room.kinematics, rows)
        for i in range(3 * n):
            system.slip[i] = 0.0
            for k in range(len(v)):
                system.slip[i] += rows[i, k] * v[k]
        begin_slides(system.slip, sliding.friction, sliding.slow, sliding.ways)
    state = _accelerate(system, driven, q, v)
    if state != SOLVED:
        return state, False
    for i in range(n):
        if not system.last[3 * i + 2] > 0.0 and system.slip[3 * i + 2] > LIFTED:
            return LIFTS, False
    bound = np.zeros((n, 3), np.bool_)
    changed = _update(system, fresh)
    for i in range(n):
        bound[i, 2] = system.last[3 * i + 2] > 0.0
        bound[i, 0] = bound[i, 2] and sliding.ways[i, 2] == STICKS and sliding.friction[i] > 0.0
        bound[i, 1] = bound[i, 0]
    if not _take_out_drift(system, bound, q, v):
        return LIFTS, False
    state = _accelerate(system, driven, q, v)
    if state != SOLVED:
        return state, False
    # Once more: what was found to slide may change the loads of the others.
    return SOLVED, _update(system, False) or changed


@compiled
def _accelerate(system: System, driven: np.ndarray, q: np.ndarray, v: np.ndarray) -> int:
    """Forces at rest at a state, for what slides now."""
    system.q[:] = q
    rate = np.empty(len(v))
    return accelerate(system, driven, v, rate)


@borrowing
def _update(system: System, fresh: bool) -> bool:
    """Which points slide from now on; whether that has changed."""
    largest = 0.0
    for i in range(len(system.accelerations)):
        largest = max(largest, abs(system.accelerations[i]))
    sliding = system.sliding
    return update_slides(
        system.slip,
        system.accelerations,
        system.last,
        sliding.friction,
        (largest, sliding.slow, sliding.grown),
        fresh,
        sliding.ways,
    )


@borrowing
def _look(system: System, q: np.ndarray, v: np.ndarray) -> None:
    """Places, velocities and Jacobians at a state."""
    look_at(system.tree, system.room, q, v)
    write_jacobian(system.tree, system.room)


@compiled
def _take_out_drift(system: System, bound: np.ndarray, q: np.ndarray, v: np.ndarray) -> bool:
    """Bring rows of points that are bound (n, 3) back to rest: positions, then velocities.

    By as little as can be in the metric of M; whether M let it.
    """
    nv, n = len(v), len(bound)
    if not bound.any():
        return True
    rows, kinematics = np.empty((3 * n, nv)), system.room.kinematics
    normals = bound.copy()
    normals[:, :2] = False
    off = np.empty(3 * n)
    x, reference = np.empty(nv), np.empty(len(q))
    for _ in range(MOST_STEPS):
        _look(system, q, v)
        gaps = gaps_and_rates(system.table, kinematics.places, kinematics.speeds, q, v)[0]
        largest = 0.0
        for i in range(n):
            off[3 * i + 2] = -gaps[i]
            if normals[i, 2]:
                largest = max(largest, abs(gaps[i]))
        if not largest > NO_DRIFT:
            break
        write_rows(system.table, kinematics, rows)
        change = np.zeros(nv)
        if not _moved(system, rows, off, normals, change):
            return False
        centre(system.tree, q, reference, x)
        _add_to_chart(system.tree, q, change, x)
        write_configuration(system.tree, reference, x, q)
    _look(system, q, v)
    write_rows(system.table, kinematics, rows)
    largest = 0.0
    for i in range(3 * n):
        off[i] = 0.0
        for k in range(nv):
            off[i] -= rows[i, k] * v[k]
        if bound[i // 3, i % 3]:
            largest = max(largest, abs(off[i]))
    return not largest > NO_DRIFT or _moved(system, rows, off, bound, v)


@compiled
def _moved(
    system: System, rows: np.ndarray, off: np.ndarray, bound: np.ndarray, v: np.ndarray
) -> bool:
    """Change v (nv,) by the least in the metric of M that changes bound rows by ``off``."""
    rows, off, bound, v = borrowed(rows), borrowed(off), borrowed(bound), borrowed(v)
    nv, m = len(v), 0
    factor = system.room.factor
    write_factor(system.tree, system.room)
    if not is_safe(factor):
        return False
    half, wanted = np.empty((len(rows), nv)), np.empty(len(rows))
    for i in range(len(rows)):
        if bound[i // 3, i % 3]:
            half[m] = rows[i]
            wanted[m] = off[i]
            halve(factor, half[m])
            m += 1
    delassus, lower = np.empty((m, m)), np.empty((m, m))
    for i in range(m):
        for j in range(i + 1):
            total = 0.0
            for k in range(nv):
                total += half[i, k] * half[j, k]
            delassus[i, j] = total
            delassus[j, i] = total
    change = np.zeros(nv)
    if m <= nv and cholesky(delassus, m, lower) > APART:
        lower_solve(lower, m, wanted)
        for i in range(m - 1, -1, -1):
            for j in range(i + 1, m):
                wanted[i] -= lower[j, i] * wanted[j]
            wanted[i] /= lower[i, i]
            for k in range(nv):
                change[k] += wanted[i] * half[i, k]
    else:
        change[:] = np.linalg.lstsq(half[:m], wanted[:m], NOTHING_LEFT)[0]
    from_half(factor, change)
    for k in range(nv):
        v[k] += change[k]
    return True


@borrowing
def _add_to_chart(tree: Tree, q: np.ndarray, change: np.ndarray, x: np.ndarray) -> None:
    """Add a small change of q, as velocities count it, to x."""
    for j in range(1, len(tree.joints)):
        kind, at, row = tree.joints[j, 1], tree.joints[j, 2], tree.joints[j, 3]
        for k in range(tree.joints[j, 4]):
            if kind == PLANAR and k < 2:
                c, s = q[at + 2], q[at + 3]
                other = change[row + 1] if k == 0 else change[row]
                x[row + k] += c * change[row + k] + (-s if k == 0 else s) * other
            else:
                x[row + k] += change[row + k]
