"""What contacts change to between the steps of a ``Wave``."""

from __future__ import annotations

import math

from ..tolerances import NONZERO
from .borrowed import borrowing
from .wave import find_forces, force_rate, power_of, velocities
from .wave_holds import acceleration
from .wave_slips import AT_CHANGE, change_slip, settle
from .wave_state import FAINT, HELD, LOADS, NONE, OPEN, SLIPS, STICKS, UNLOADS, Wave

__all__ = ["RISES", "STILL_FORCES", "change", "end_compressions", "largest_force"]

# A contact that parts: what its force would still give is below these (beside the velocity with
# which it parts, and what that moves others), so it is given at once.
TAIL, MOVED = 1e-8, 1e-15
# What leaves at a speed is this far away at once, so that it can be met again in the same step.
LEAVES_BY = 1e-30
# Accelerations below this share of the largest force are rounding of sums in which friction and
# normal forces of redundant rows cancel.
STILL_FORCES = 1e-12
# A contact that was loaded by less than this, times what it had, was not.
LOADED = 1.0 + 1e-9
# What takes longer to part is not looked at [time].
LATER = 0.1
# A held contact is loaded again where its force rises faster [in units of the impact].
RISES = 1e-8


@borrowing
def change(w: Wave, crossed: int) -> None:
    """Let each contact go over to what it does next; velocities and forces are those at y.

    ``crossed``: the change at which the step ended, see ``wave_steps``; −1 for none.
    """
    n = len(w.kappa)
    for i in range(n):
        w.load[i] = max(w.force[w.normal[i]], 0.0)
    changed, rubs = False, False
    modes, normal, u, y, r = w.mode, w.normal, w.u, w.y, len(w.free)
    for i in range(len(modes)):
        rubs = rubs or (w.tangent[i] >= 0 and modes[i] != OPEN)
        un, depth = u[normal[i]], y[r + i]
        # What is far from any change, at little cost.
        if crossed in (i, 2 * n + i):
            pass
        elif modes[i] == LOADS and depth > 0.0:
            if un < -FAINT or (w.e2[i] == 1.0 and depth > LATER * un):
                continue
        elif modes[i] == OPEN and (un >= -AT_CHANGE or depth < -AT_CHANGE):
            continue
        if _change_normal(w, i, crossed == i, crossed == 2 * n + i):
            changed = True
            if w.mode[i] == OPEN:
                w.slip[i] = NONE
            find_forces(w, w.y)
    if rubs or changed:
        for i in range(len(modes)):
            if change_slip(w, i, crossed == n + i):
                changed = True
    if changed:
        find_forces(w, w.y)
    if rubs or changed:
        settle(w, crossed - n)


@borrowing
def _change_normal(w: Wave, i: int, crossed: bool, reloads: bool) -> bool:
    r = len(w.free)
    mode, depth, un = w.mode[i], float(w.y[r + i]), float(w.u[w.normal[i]])
    if mode == OPEN:
        if depth >= -AT_CHANGE and un < -AT_CHANGE:
            w.mode[i] = LOADS if w.kappa[i] < math.inf else HELD
            w.y[r + i], w.began[i] = max(depth, 0.0), _energy(w, i, max(depth, 0.0))
            return True
        return False
    if mode == HELD:
        if crossed or w.force[w.normal[i]] <= AT_CHANGE * largest_force(w):
            w.mode[i] = OPEN
            w.y[r + i] = 0.0
            return True
        if w.kappa[i] < math.inf and (reloads or force_rate(w, w.y, i) > 2.0 * RISES):
            _reload(w, i)
            return True
        return False
    if depth <= 0.0:
        if un > AT_CHANGE:
            w.mode[i] = OPEN
            w.y[r + i] = min(depth, -LEAVES_BY)
            w.loaded[i] += -w.began[i] if mode == LOADS else 0.0
            w.began[i] = 0.0
            return True
        return False
    if mode == LOADS and w.e2[i] == 0.0 and abs(un) <= FAINT and _is_stopped(w, i, depth):
        _end_compression(w, i)
        return True
    rises = acceleration(w, int(w.normal[i]))
    if un > 0.0 and (mode == UNLOADS or w.e2[i] == 1.0) and _parts(w, i, depth, un):
        return True
    if (
        mode == LOADS
        and w.e2[i] < 1.0
        and (crossed or (un >= -AT_CHANGE and rises > AT_CHANGE * largest_force(w)))
    ):
        _end_compression(w, i)
        return True
    if mode == UNLOADS and (crossed or (un <= AT_CHANGE and rises < 0.0)):
        w.mode[i] = LOADS
        w.began[i] = _energy(w, i, depth)
        return True
    return False


@borrowing
def _is_stopped(w: Wave, i: int, depth: float) -> bool:
    """Whether friction holds a contact still that was loaded until now; it sticks then.

    Where a contact has one way to go its slip ends with its compression, and rounding says which
    of the two is seen first.
    """
    t, slip = w.tangent[i], w.slip[i]
    if t < 0 or slip not in (SLIPS, STICKS) or w.u[t] ** 2 + w.u[t + 1] ** 2 > FAINT**2:
        return False
    # What was held and is loaded again has not moved since.
    if not _energy(w, i, depth) > LOADED * w.began[i]:
        return False
    w.slip[i] = STICKS
    find_forces(w, w.y)
    push, holds = STILL_FORCES * largest_force(w), True
    for k in range(t, t + 3):
        holds = holds and abs(acceleration(w, int(k))) <= push
    pull = math.sqrt(w.force[t] ** 2 + w.force[t + 1] ** 2)
    if holds and pull <= w.mu[i] * w.force[w.normal[i]]:
        return True
    w.slip[i] = slip
    find_forces(w, w.y)
    return False


@borrowing
def largest_force(w: Wave) -> float:
    """The size of the forces, in units of which that of a held contact is zero."""
    most = NONZERO
    for k in range(len(w.free)):
        most = max(most, abs(w.force[k]))
    return most


@borrowing
def _end_compression(w: Wave, i: int) -> None:
    w.loaded[i] += _energy(w, i, float(w.y[len(w.free) + i])) - w.began[i]
    w.began[i] = 0.0
    w.mode[i] = UNLOADS if w.e2[i] > 0.0 else HELD


@borrowing
def end_compressions(w: Wave) -> bool:
    """End that of all contacts without restitution, where nothing moves them; whether of any."""
    ended = False
    for i in range(len(w.kappa)):
        if w.mode[i] == LOADS and w.e2[i] == 0.0 and w.y[len(w.free) + i] > 0.0:
            _end_compression(w, i)
            ended = True
    if ended:
        find_forces(w, w.y)
        settle(w, -1)
    return ended


@borrowing
def _parts(w: Wave, i: int, depth: float, un: float) -> bool:
    """Give at once what a parting contact still would give, if that is next to nothing."""
    r, row = len(w.free), w.normal[i]
    rate = un / w.e2[i] if w.mode[i] == UNLOADS else un
    left = depth / rate
    given = float(w.force[row]) * left / (w.power[0] + 1.0)
    speed = given * w.W[row, row]
    if speed > TAIL * un or speed * left > MOVED:
        return False
    w.y[row] += given
    t = w.tangent[i]
    if t >= 0 and w.force[row] > 0.0:
        for k in range(2):
            w.y[t + k] += given * w.force[t + k] / w.force[row]
    if w.mode[i] == LOADS:
        w.loaded[i] -= w.began[i]
    w.began[i] = 0.0
    w.mode[i] = OPEN
    # Its gap opens when the rest of the way is done.
    w.y[r + i] = un * left
    return True


@borrowing
def _energy(w: Wave, i: int, depth: float) -> float:
    """E = κ δ^(n + 1)/(n + 1)."""
    if depth <= 0.0 or w.kappa[i] == math.inf:
        return 0.0
    return float(w.kappa[i] * depth * power_of(depth, w.power[0]) / (w.power[0] + 1.0))


@borrowing
def _reload(w: Wave, i: int) -> None:
    """A contact that was held begins to be loaded again, from the force that it carries."""
    r, row = len(w.free), w.normal[i]
    # What the steps have left of u_n = 0 would end the loading at once.
    w.y[row] -= w.u[row] / w.W[row, row]
    velocities(w.W, w.reach, w.free, w.y, w.u)
    force = max(float(w.force[w.normal[i]]), 0.0)
    w.mode[i] = LOADS
    w.y[r + i] = (force / w.kappa[i]) ** (1.0 / w.power[0])
    w.began[i] = _energy(w, i, float(w.y[r + i]))
