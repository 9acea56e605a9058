"""The state of several contacts while their impulses grow, and its rates.

Each contact has an indentation δ, its normal force is F = κ δ^n. In compression dδ/dt = −u_n, in
restitution −u_n/e², so that the force regains e² of the work of the compression, and is
continuous (the bi-stiffness law of Liu, Zhao & Brogliato 2008): dP_i/dP_j = F_i/F_j depends on
stiffness ratios and stored energies E = κ δ^(n + 1)/(n + 1) alone. Time t, indentation and force
are in units in which all are of size 1; no result depends on the absolute stiffness.

A contact whose stiffness is infinite beside the others, or that loses all its energy at the
end of its compression (e = 0), is held: u_n = 0, F from the equations of motion, F ≥ 0.

Friction opposes the slip of each instant: it slides, or sticks as long as its force stays in the
cone. Slip that starts from rest creeps at first: it goes where its acceleration goes, as the slip
of a single contact does exactly, for its own direction would be lost in rounding.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .borrowed import borrowing
from .compiled import compiled
from .dense import factorize, solve_factorized
from .path import outgoing

__all__ = [
    "CREEPS", "FAINT", "HELD", "LOADS", "NONE", "OPEN", "SLIPS", "STICKS", "UNLOADS", "Wave",
    "acceleration", "any_held", "direction", "find_forces", "force_rate", "hold", "power_of",
    "rates", "smooth_rates", "velocities", "wave",
]  # fmt: skip

Array = np.ndarray[tuple[int], np.dtype[np.float64]]
Integers = np.ndarray[tuple[int], np.dtype[np.int64]]
Grid = np.ndarray[tuple[int, int], np.dtype[np.int64]]
Matrix = np.ndarray[tuple[int, int], np.dtype[np.float64]]

# What a contact does along its normal, and along its tangents.
OPEN, LOADS, UNLOADS, HELD = 0, 1, 2, 3
NONE, SLIPS, STICKS, CREEPS = 0, 1, 2, 3
# Indentations below this give no force: it would be 1e-30, and powers of it leave the normal
# doubles, with which processors are slow.
SHALLOW = 1e-20
# Slip below this has the direction that it was given: it starts or ends there.
FAINT = 1e-11
# Forces rise or fall over this time [in units of the impact] where their rate is asked for.
AHEAD = 1e-6
# How often contacts that creep take turns to find their directions.
SWEEPS = 12
# How much redundant rows that are held give way, relative to W; a pivot below the second says
# that they are.
SHARED, REGULAR = 1e-3, 1e-10
# It is taken out again until this is left of the accelerations, or so often.
HELD_STILL, MOST_AGAIN = 1e-14, 40


class Wave(NamedTuple):
    """Contacts in units of their own; the rows are the normals and the tangents that rub.

    Attributes:
        W: (r, r) Delassus matrix. free: (r,) u_free.
        reach: (r, 2) the first column of each row of W that is not 0, and that behind the last.
        normal, tangent: (n,) row of the normal, of the first tangent or −1.
        kappa: (n,) stiffness, the largest finite one being 1; infinite: held.
        e2: (n,) e². mu: (n,) friction.
        power: (1,) n.
        mode, slip: (n,) along the normal and along the tangents.
        way: (n, 2) the direction of slip where it began.
        give: (n, 3) W of the tangents, 11, 12 and 22, of a contact that creeps.
        y: P by row (r), δ by contact (n), and where any rubs the work of friction (n).
        u: (r,) velocity. force: (r,) dP/dt.
        began, loaded: (n,) E where the loading at hand began; all that was loaded so far.
        matrix, right, order: room for what sticks or is held.
        rows: (r,) those rows; solved: (1,) how many.
        stages, trial, error: room of a step.
        lead: (1,) the contact whose √δ is the variable of the step; −1: time.
        pace: (1,) its dδ/dt where the step begins.
    """

    W: Matrix
    reach: Grid
    free: Array
    normal: Integers
    tangent: Integers
    kappa: Array
    e2: Array
    mu: Array
    power: Array
    mode: Integers
    slip: Integers
    way: Matrix
    give: Matrix
    y: Array
    u: Array
    force: Array
    began: Array
    loaded: Array
    matrix: Matrix
    right: Array
    order: Integers
    rows: Integers
    solved: Integers
    stages: Matrix
    trial: Array
    error: Array
    lead: Integers
    pace: Array


@compiled
def wave(n: int, r: int) -> Wave:
    """Memory for n contacts with r rows."""
    m = r + n if r == n else r + 2 * n
    return Wave(
        np.zeros((r, r)),
        np.zeros((r, 2), dtype=np.int64),
        np.zeros(r),
        np.zeros(n, dtype=np.int64),
        np.zeros(n, dtype=np.int64),
        np.zeros(n),
        np.zeros(n),
        np.zeros(n),
        np.zeros(1),
        np.zeros(n, dtype=np.int64),
        np.zeros(n, dtype=np.int64),
        np.zeros((n, 2)),
        np.zeros((n, 3)),
        np.zeros(m),
        np.zeros(r),
        np.zeros(r),
        np.zeros(n),
        np.zeros(n),
        np.zeros((r, r)),
        np.zeros(r),
        np.zeros(r, dtype=np.int64),
        np.zeros(r, dtype=np.int64),
        np.zeros(1, dtype=np.int64),
        np.zeros((12, m)),
        np.zeros(m),
        np.zeros(m),
        np.full(1, -1),
        np.zeros(1),
    )


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
            rise = kappa[i] * (depth * math.sqrt(depth) if power == 1.5 else depth**power)
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
            rise = depth * math.sqrt(depth) if power == 1.5 else depth**power
            force[normal[i]] = kappa[i] * rise
        else:
            force[normal[i]] = 0.0
    if rubs or r > len(kappa):
        spread(w)


@borrowing
def power_of(depth: float, power: float) -> float:
    """δ^n, n = 1.5 by a root."""
    return depth * math.sqrt(depth) if power == 1.5 else float(depth**power)


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
    solved = 0
    for i in range(len(w.kappa)):
        row, mode = w.normal[i], w.mode[i]
        force = w.force[row]
        if mode == HELD:
            w.force[row] = 0.0
            w.rows[solved] = row
            solved += 1
        t = w.tangent[i]
        if t >= 0:
            w.force[t], w.force[t + 1] = 0.0, 0.0
            if w.slip[i] == SLIPS and mode != HELD:
                s1, s2 = direction(w, i)
                w.force[t], w.force[t + 1] = -w.mu[i] * force * s1, -w.mu[i] * force * s2
            elif w.slip[i] == STICKS:
                w.rows[solved], w.rows[solved + 1] = t, t + 1
                solved += 2
    w.solved[0] = solved
    hold(w)
    _creep(w)


@borrowing
def _creep(w: Wave) -> None:
    """Friction of what creeps: against the direction in which it then is accelerated."""
    n = len(w.kappa)
    count = 0
    for i in range(n):
        count += w.slip[i] == CREEPS
    if count == 0:
        return
    # Those that feel each other take turns.
    for _ in range(1 if count == 1 else SWEEPS):
        for i in range(n):
            if w.slip[i] != CREEPS:
                continue
            t, force = w.tangent[i], float(w.force[w.normal[i]])
            w.force[t], w.force[t + 1] = 0.0, 0.0
            if not force > 0.0:
                continue
            hold(w)
            n1, n2 = acceleration(w, int(t)), acceleration(w, int(t) + 1)
            b11, b12, b22 = w.give[i, 0], w.give[i, 1], w.give[i, 2]
            s1, s2 = float(w.way[i, 0]), float(w.way[i, 1])
            if n1 != 0.0 or n2 != 0.0:
                s1, s2 = outgoing((b11, b12, b22, n1 / force, n2 / force, 1.0), float(w.mu[i]))
            w.force[t], w.force[t + 1] = -w.mu[i] * force * s1, -w.mu[i] * force * s2
            hold(w)


@borrowing
def acceleration(w: Wave, row: int) -> float:
    """du/dt of a row under the forces that are there."""
    total = 0.0
    for k in range(len(w.free)):
        total += w.W[row, k] * w.force[k]
    return total


@borrowing
def direction(w: Wave, i: int) -> tuple[float, float]:
    """The direction of slip of contact i."""
    t = w.tangent[i]
    u1, u2 = float(w.u[t]), float(w.u[t + 1])
    speed = math.sqrt(u1 * u1 + u2 * u2)
    # Beyond the end of slip it goes on as it was, so that the end can be found from both sides.
    if speed <= FAINT or u1 * w.way[i, 0] + u2 * w.way[i, 1] <= 0.0:
        return float(w.way[i, 0]), float(w.way[i, 1])
    return u1 / speed, u2 / speed


@borrowing
def hold(w: Wave) -> None:
    """Add forces in ``w.rows`` so that their velocities keep, beside the forces that are there.

    Redundant rows share by least squares: each gives way a little, and what that leaves of the
    equations is taken out again.
    """
    solved = int(w.solved[0])
    _fill(w, solved)
    most = 0.0
    for a in range(solved):
        most = max(most, abs(w.matrix[a, a]))
    if solved == 0 or not most > 0.0:
        return
    regular = factorize(w.matrix, solved, w.order)
    for a in range(solved):
        regular = regular and abs(w.matrix[a, a]) > REGULAR * most
    if not regular:
        _fill(w, solved)
        for a in range(solved):
            w.matrix[a, a] += SHARED * most
        if not factorize(w.matrix, solved, w.order):
            return
    for again in range(MOST_AGAIN):
        # What the forces so far leave of these rows' accelerations.
        left, size = 0.0, 0.0
        for a in range(solved):
            total = 0.0
            row = w.rows[a]
            for k in range(len(w.free)):
                part = w.W[row, k] * w.force[k]
                total -= part
                size = max(size, abs(part))
            w.right[a] = total
            left = max(left, abs(total))
        if again > 0 and left <= HELD_STILL * size:
            return
        solve_factorized(w.matrix, solved, w.order, w.right)
        for a in range(solved):
            w.force[w.rows[a]] += w.right[a]
        _rub_on_held(w)


@borrowing
def _fill(w: Wave, solved: int) -> None:
    """W of the rows that are solved; what slides on a held contact rubs with the force sought."""
    for a in range(solved):
        for b in range(solved):
            w.matrix[a, b] = w.W[w.rows[a], w.rows[b]]
    for i in range(len(w.kappa)):
        if w.mode[i] == HELD and w.slip[i] == SLIPS:
            s1, s2 = direction(w, i)
            t, b = w.tangent[i], 0
            while w.rows[b] != w.normal[i]:
                b += 1
            for a in range(solved):
                row = w.rows[a]
                w.matrix[a, b] -= w.mu[i] * (s1 * w.W[row, t] + s2 * w.W[row, t + 1])


@borrowing
def _rub_on_held(w: Wave) -> None:
    for i in range(len(w.kappa)):
        if w.mode[i] == HELD and w.slip[i] == SLIPS:
            s1, s2 = direction(w, i)
            t, force = w.tangent[i], w.force[w.normal[i]]
            w.force[t], w.force[t + 1] = -w.mu[i] * force * s1, -w.mu[i] * force * s2
