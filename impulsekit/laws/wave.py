"""The rates at which indentations, forces and impulses of a ``Wave`` grow."""

from __future__ import annotations

import math

from .borrowed import borrowing
from .wave_creep import creep
from .wave_holds import direction, hold
from .wave_state import (
    CREEPS,
    HELD,
    LEANS,
    LOADS,
    NONE,
    OPEN,
    SLIPS,
    STICKS,
    UNLOADS,
    Array,
    Grid,
    Integers,
    Matrix,
    Wave,
)

__all__ = [
    "any_held", "find_forces", "force_rate", "power_of", "rates", "smooth_rates", "velocities",
]  # fmt: skip

# Indentations below this give no force: it would be 1e-30, and powers of it leave the normal
# doubles, with which processors are slow.
SHALLOW = 1e-20
# Forces rise or fall over this time [in units of the impact] where their rate is asked for.
AHEAD = 1e-6
# Hertz's exponent of force by indentation: a root is quicker than a power.
HERTZ = 1.5


@borrowing
def rates(w: Wave, y: Array, dy: Array) -> None:
    """dy/dt at y; velocities and forces are left in ``w.u`` and ``w.force``."""
    # Names of their own: numba counts references each time that a field is read.
    u, force, modes, normal, tangent = w.u, w.force, w.mode, w.normal, w.tangent
    slip, e2 = w.slip, w.e2
    n, r = len(modes), len(u)
    velocities(w.W, w.reach, w.free, y, u)
    if r == n and not any_held(modes):
        smooth_rates(e2, w.kappa, w.power[0], modes, y, dy, u, force)
        return
    find_forces(w, y)
    for k in range(r):
        dy[k] = force[k]
    for i in range(n):
        mode = modes[i]
        un = u[normal[i]]
        if mode == HELD:
            dy[r + i] = 0.0
        elif mode == UNLOADS:
            dy[r + i] = -un / e2[i]
        else:
            dy[r + i] = -un
        if r > n:
            work = 0.0
            if slip[i] == SLIPS or slip[i] == CREEPS:
                t = tangent[i]
                work = force[t] * u[t] + force[t + 1] * u[t + 1]
            dy[r + n + i] = work


@borrowing
def any_held(modes: Integers) -> bool:
    """Whether a contact is held."""
    count = 0
    for i in range(len(modes)):
        count += modes[i] == HELD
    return count > 0


@borrowing
def smooth_rates(
    e2: Array,
    kappa: Array,
    power: float,
    modes: Integers,
    y: Array,
    dy: Array,
    u: Array,
    force: Array,
) -> None:
    """``rates`` where nothing rubs and nothing is held: each row is the normal of a contact."""
    n = len(kappa)
    for i in range(n):
        depth, mode, un = y[n + i], modes[i], u[i]
        rise = 0.0
        if depth > SHALLOW and mode != OPEN:
            rise = kappa[i] * (depth * math.sqrt(depth) if power == HERTZ else depth**power)
        force[i], dy[i] = rise, rise
        dy[n + i] = -un / e2[i] if mode == UNLOADS else -un


@borrowing
def velocities(W: Matrix, reach: Grid, free: Array, y: Array, u: Array) -> None:
    r = len(free)
    for k in range(r):
        u[k] = free[k]
    for j in range(r):
        p = y[j]
        for k in range(reach[j, 0], reach[j, 1]):
            u[k] += W[j, k] * p


@borrowing
def find_forces(w: Wave, y: Array) -> None:
    """Forces at y, whose velocities stand in ``w.u``: by indentation, by slip, by what is held."""
    modes, kappa, force, normal = w.mode, w.kappa, w.force, w.normal
    r, power = len(w.free), w.power[0]
    rubs = False
    for i in range(len(kappa)):
        depth, mode = y[r + i], modes[i]
        rubs = rubs or mode == HELD or w.slip[i] != NONE
        if depth > SHALLOW and mode in (LOADS, UNLOADS):
            rise = depth * math.sqrt(depth) if power == HERTZ else depth**power
            force[normal[i]] = kappa[i] * rise
        else:
            force[normal[i]] = 0.0
    if rubs or r > len(kappa):
        spread(w)


@borrowing
def power_of(depth: float, power: float) -> float:
    """δ^n, n = 1.5 by a root."""
    return depth * math.sqrt(depth) if power == HERTZ else float(depth**power)


@borrowing
def force_rate(w: Wave, y: Array, i: int) -> float:
    """dF/dt of contact i at y, by a short way along the rates; forces and velocities are kept."""
    row, ahead = w.normal[i], w.stages[0]
    rates(w, y, w.error)
    before = float(w.force[row])
    for k in range(len(y)):
        ahead[k] = y[k] + AHEAD * w.error[k]
    velocities(w.W, w.reach, w.free, ahead, w.u)
    find_forces(w, ahead)
    rate = (float(w.force[row]) - before) / AHEAD
    velocities(w.W, w.reach, w.free, y, w.u)
    find_forces(w, y)
    return rate


@borrowing
def spread(w: Wave) -> None:
    """From the normal forces of what gives way to all others: friction, and what is held."""
    solved, creeps = 0, False
    for i in range(len(w.kappa)):
        row, mode = w.normal[i], w.mode[i]
        creeps = creeps or w.slip[i] == CREEPS
        force = w.force[row]
        if mode == HELD:
            w.force[row] = 0.0
            w.rows[solved] = row
            solved += 1
        t = w.tangent[i]
        if t >= 0:
            w.force[t], w.force[t + 1] = 0.0, 0.0
            if w.slip[i] in (SLIPS, LEANS) and mode != HELD:
                s1, s2 = direction(w, i)
                w.force[t], w.force[t + 1] = -w.mu[i] * force * s1, -w.mu[i] * force * s2
            elif w.slip[i] == STICKS:
                w.rows[solved], w.rows[solved + 1] = t, t + 1
                solved += 2
    w.solved[0] = solved
    hold(w)
    if creeps:
        creep(w)
