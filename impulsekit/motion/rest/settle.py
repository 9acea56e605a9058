"""What rests, after a step or an impact, in one compiled call.

It does what ``course.settling`` does otherwise.

Points with a gap and a rate of their own are laid down, begin to slide or cease to, and their
drift is taken out. What lifts is left to ``settling``: it has to be told.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...laws.borrowed import borrowed, borrowing
from ...laws.compiled import compiled, entry
from ...laws.dense import cholesky, lower_solve, put
from ...laws.half import from_half, halve, is_safe
from ...rows.point_rows import gaps_and_rates, write_rows
from ...tolerances import NONZERO
from ..steps.compiled import SOLVED, accelerate
from ..steps.system import System
from ..tree.bodies import PLANAR, Tree, look_at, write_factor, write_jacobian
from ..tree.coordinates import centre, write_configuration

__all__ = [
    "LIFTED",
    "LIFTS",
    "MOST_STEPS",
    "NO_DRIFT",
    "Stand",
    "begin_stage",
    "next_slide",
    "settle",
    "settle_points",
]

# A tangential rate below this share of the largest acceleration has no direction.
NO_DIRECTION = 1e-7
# What became of it, besides what becomes of a step: a point lifts, and nothing was changed.
LIFTS = 3
# A resting contact that does not push and opens faster than this has lifted [m/s].
LIFTED = 0.5e-8
# Drift below this [m, rad] or [m/s] is left alone.
NO_DRIFT = 1e-14
# Newton on positions: the second step ends at rounding, the third makes sure.
MOST_STEPS = 3
# Tangential forces this near the cone are on it.
ON_CONE = 1.0 - 1e-7
# Slip above this share of the speed at which it has grown counts as grown.
ALL_BUT = 0.999
# Rows that depend on each other more than this, by a squared sine, share what they do; parts of
# them that are smaller [relative] are none.
APART, NOTHING_LEFT = 1e-6, 1e-7


class Stand(NamedTuple):
    """The points that rest, beside what ``System.sliding`` has.

    Attributes:
        slides: (n, 3) the direction of slip and 1 of what slides or begins to; written.
        begins: (n,) whether slip has just begun; written.
        grown: slip that has grown [m/s].
        fresh: after an impact: slip decides alone. lay: points are laid down first.
    """

    slides: np.ndarray
    begins: np.ndarray
    grown: float
    fresh: bool
    lay: bool


def _examples() -> tuple:
    from ..steps.tables import example_step

    system, *_ = example_step()
    stand = Stand(np.zeros((0, 3)), np.zeros(0, np.bool_), 0.0, False, False)
    return system, stand, np.zeros(0), system.q, system.load


@borrowing
def next_slide(
    before: tuple[float, float, float],
    begins: bool,
    slip: tuple[float, float],
    rate: tuple[float, float],
    force: tuple[float, float, float],
    numbers: tuple[float, float, float, float],
    fresh: bool,
) -> tuple[tuple[float, float, float], bool]:
    """Where a point slides from now on, with 1 if it does, and whether that has just begun.

    Args:
        before: the same of before. begins: whether that has just begun.
        slip: [m/s]. rate: of that [m/s²]. force: two tangents and the normal [N].
        numbers: µ, the largest acceleration of a point [m/s²], and ``slow`` and ``grown`` of
            ``Resting`` [m/s].
        fresh: after an impact slip decides alone.
    """
    mu, largest, slow, grown = numbers
    if mu == 0.0:
        return (0.0, 0.0, 0.0), False
    speed = math.hypot(slip[0], slip[1])
    way = before
    if speed > slow:
        way = (slip[0] / speed, slip[1] / speed, 1.0)
    if before[2] != 0.0 and not begins:
        return way, False
    if fresh and speed > slow:
        return way, False
    on_cone = force[2] > 0.0 and math.hypot(force[0], force[1]) >= mu * force[2] * ON_CONE
    if before[2] != 0.0:
        # Slip that has only begun is rounding: its direction is that in which it begins.
        turning = way[0] * rate[0] + way[1] * rate[1]
        if on_cone and speed < ALL_BUT * grown and turning >= 0.0:
            return way, True
        return way if speed > slow else (0.0, 0.0, 0.0), False
    if not on_cone:
        return (0.0, 0.0, 0.0), False
    if speed > slow:
        return way, False
    size = math.hypot(rate[0], rate[1])
    if not size > NO_DIRECTION * max(largest + force[2], NONZERO):
        return (0.0, 0.0, 0.0), False
    return (rate[0] / size, rate[1] / size, 1.0), grown > 0.0


@entry(_examples, seconds=9.0, apart=True)
def settle_points(
    system: System, stand: Stand, driven: np.ndarray, q: np.ndarray, v: np.ndarray
) -> tuple[int, bool]:
    """Look at the points that rest: which of them slide from here on; drift is taken out.

    Args:
        system: what moves; its table has all points that rest.
        stand: what they did, and do from now on.
        driven: what is driven in time, now.
        q, v: the state, which is changed.

    Returns:
        What became of it, and whether anything has changed. Of ``LIFTS`` nothing has, unless
        points were laid down.
    """
    return settle(borrowed(system), borrowed(stand), borrowed(driven), borrowed(q), borrowed(v))


@compiled
def settle(
    system: System, stand: Stand, driven: np.ndarray, q: np.ndarray, v: np.ndarray
) -> tuple[int, bool]:
    """As ``settle_points``."""
    n = len(system.table.whole)
    if stand.lay:
        laid = np.ones((n, 3), np.bool_)
        laid[:, :2] = False
        if not _take_out_drift(system, laid, q, v):
            return LIFTS, False
    if stand.fresh:
        _look(system, q, v)
        rows = np.empty((3 * n, len(v)))
        write_rows(system.table, system.room.kinematics, rows)
        for i in range(3 * n):
            system.slip[i] = 0.0
            for k in range(len(v)):
                system.slip[i] += rows[i, k] * v[k]
        for i in range(n):
            one, two = system.slip[3 * i], system.slip[3 * i + 1]
            speed = math.hypot(one, two)
            stand.begins[i] = False
            stand.slides[i] = 0.0
            if system.sliding.friction[i] > 0.0 and speed > system.sliding.slow:
                stand.slides[i, 0], stand.slides[i, 1] = one / speed, two / speed
                stand.slides[i, 2] = 1.0
    state = _accelerate(system, stand, driven, q, v)
    if state != SOLVED:
        return state, False
    for i in range(n):
        if not system.last[3 * i + 2] > 0.0 and system.slip[3 * i + 2] > LIFTED:
            return LIFTS, False
    bound = np.zeros((n, 3), np.bool_)
    changed = _update(system, stand, stand.fresh)
    for i in range(n):
        bound[i, 2] = system.last[3 * i + 2] > 0.0
        bound[i, 0] = bound[i, 2] and stand.slides[i, 2] == 0.0 and system.sliding.friction[i] > 0.0
        bound[i, 1] = bound[i, 0]
    if not _take_out_drift(system, bound, q, v):
        return LIFTS, False
    state = _accelerate(system, stand, driven, q, v)
    if state != SOLVED:
        return state, False
    # Once more: what was found to slide may change the loads of the others.
    return SOLVED, _update(system, stand, False) or changed


@borrowing
def begin_stage(system: System, stand: Stand) -> None:
    """Let the law know what slides."""
    for i in range(len(stand.slides)):
        system.sliding.ways[i] = 0.0
        if not stand.begins[i]:
            put(stand.slides[i], system.sliding.ways[i])


@compiled
def _accelerate(
    system: System, stand: Stand, driven: np.ndarray, q: np.ndarray, v: np.ndarray
) -> int:
    """Forces at rest at a state, for what slides now."""
    begin_stage(system, stand)
    system.q[:] = q
    rate = np.empty(len(v))
    return accelerate(system, driven, v, rate)


@borrowing
def _update(system: System, stand: Stand, fresh: bool) -> bool:
    """Which points slide from now on; whether that has changed."""
    changed, largest = False, 0.0
    for i in range(len(system.accelerations)):
        largest = max(largest, abs(system.accelerations[i]))
    sliding = system.sliding
    for i in range(len(stand.slides)):
        at, own = 3 * i, stand.slides[i]
        before, begins = (own[0], own[1], own[2]), bool(stand.begins[i])
        way, starts = next_slide(
            before,
            begins,
            (system.slip[at], system.slip[at + 1]),
            (system.accelerations[at], system.accelerations[at + 1]),
            (system.last[at], system.last[at + 1], system.last[at + 2]),
            (sliding.friction[i], largest, sliding.slow, stand.grown),
            fresh,
        )
        changed |= before[2] != way[2] or begins != starts
        own[0], own[1], own[2] = way
        stand.begins[i] = starts
    return changed


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
