"""Where contacts of a ``Wave`` begin and end to slip."""

from __future__ import annotations

import math

from .borrowed import borrowing
from .wave import find_forces
from .wave_holds import acceleration, hold
from .wave_state import (
    CREEPS,
    FAINT,
    HELD,
    LEANS,
    NONE,
    OPEN,
    SLIPS,
    STICKS,
    Wave,
)  # fmt: skip

__all__ = ["AT_CHANGE", "IN_CONE", "SLOW", "change_slip", "choose_slips", "settle"]

# This near a change it is made.
AT_CHANGE = 1e-13
# Slip that began from rest creeps up to here [of the largest velocity]: three times as much leaves
# 6e-10 of the velocities, ten times 3e-8; less leaves no less.
SLOW = 3e-8
# Slip below this may have ended with that of others [of the largest velocity].
MAY_HAVE_ENDED = 1e-9
# What moves by less than this share of what it would alone is held by others.
HELD_BY_OTHERS = 1e-6
# Shares of what depends on each other are tried so often; and so often where all are in their
# cones.
MOST_SHARES, INSIDE = 40, 8
# A friction force this far beyond its cone still is in it.
IN_CONE = 1e-10


@borrowing
def change_slip(w: Wave, i: int, crossed: bool) -> bool:
    """Whether a contact begins or ends to slip."""
    t = w.tangent[i]
    if t < 0 or w.mode[i] == OPEN:
        return False
    u1, u2 = float(w.u[t]), float(w.u[t + 1])
    speed = math.sqrt(u1 * u1 + u2 * u2)
    if w.slip[i] == NONE:
        if speed > FAINT:
            _go(w, i)
        else:
            w.slip[i] = STICKS
        return True
    if w.slip[i] == CREEPS:
        if speed > SLOW or (crossed and speed > FAINT):
            _go(w, i)
            return True
        if crossed:
            w.slip[i] = STICKS
        return crossed
    if w.slip[i] == LEANS and speed > SLOW:
        _go(w, i)
        return True
    if w.slip[i] != SLIPS:
        return False
    slows = acceleration(w, int(t)) * w.way[i, 0] + acceleration(w, int(t) + 1) * w.way[i, 1]
    if slows < 0.0 and speed <= FAINT:
        w.slip[i] = STICKS
        return True
    if FAINT < speed <= MAY_HAVE_ENDED:
        # Where others stick and hold it, its slip is what their steps have left.
        _, _, b11, b12, b22 = _free_of(w, i)
        held = _is_held(w, i, b11, b12, b22, u1, u2)
        if held:
            w.slip[i] = STICKS
        else:
            _go(w, i)
        find_forces(w, w.y)
        return held
    if speed > FAINT:
        _go(w, i)
    return False


@borrowing
def _go(w: Wave, i: int) -> None:
    """Contact i slips in the direction of its velocity."""
    t = w.tangent[i]
    u1, u2 = float(w.u[t]), float(w.u[t + 1])
    speed = math.sqrt(u1 * u1 + u2 * u2)
    w.slip[i], w.way[i, 2] = SLIPS, 0.0
    w.way[i, 0], w.way[i, 1] = u1 / speed, u2 / speed


@borrowing
def choose_slips(w: Wave) -> None:
    """Slip or stick for contacts that begin."""
    find_forces(w, w.y)
    for i in range(len(w.kappa)):
        change_slip(w, i, False)
    find_forces(w, w.y)
    settle(w, -1)


@borrowing
def settle(w: Wave, at: int) -> None:
    """What sticks and would need more than its cone begins to slip, the farthest out first.

    ``at``: the contact that has just come to the edge of its cone; −1 for none.
    """
    n = len(w.kappa)
    edge = 1.0 + (0.5 * IN_CONE if 0 <= at < n and w.slip[at] == STICKS else IN_CONE)
    if _farthest(w, edge) < 0:
        return
    for i in range(n):
        # What leaned can take as much as all the others again.
        if w.slip[i] == LEANS:
            w.slip[i] = STICKS
        w.share[i] = 1.0
    find_forces(w, w.y)
    if _shared(w, edge):
        return
    _note_rest(w)
    for _ in range(2 * n):
        found = _farthest(w, edge)
        if found < 0:
            break
        _start_slip(w, found)
    for i in range(n):
        if w.slip[i] == LEANS:
            _start_slip(w, i)
    _start_together(w)


@borrowing
def _note_rest(w: Wave) -> None:
    """What sticks, and the directions against its friction."""
    r = len(w.free)
    for i in range(len(w.kappa)):
        w.pulls[i, r + 1] = 0.0
        if w.slip[i] == STICKS:
            t = w.tangent[i]
            pull = math.sqrt(w.force[t] ** 2 + w.force[t + 1] ** 2)
            if pull > 0.0:
                w.pulls[i, r + 1] = 1.0
                w.pulls[i, r + 2], w.pulls[i, r + 3] = -w.force[t] / pull, -w.force[t + 1] / pull


@borrowing
def _start_together(w: Wave) -> None:
    """What began to slip while others still held it in part, and do no more: all creep."""
    count, sticks, r = 0, 0, len(w.free)
    for i in range(len(w.kappa)):
        count += w.pulls[i, r + 1] == 1.0 and w.slip[i] != STICKS and w.slip[i] != NONE
        sticks += w.slip[i] == STICKS
    if count < 2 or sticks > 0:
        return
    for i in range(len(w.kappa)):
        began = w.pulls[i, r + 1] == 1.0 and w.slip[i] != NONE
        if began and w.mode[i] != HELD and w.force[w.normal[i]] > 0.0:
            w.slip[i] = CREEPS
            w.way[i, 0], w.way[i, 1] = w.pulls[i, r + 2], w.pulls[i, r + 3]
    find_forces(w, w.y)


@borrowing
def _farthest(w: Wave, edge: float) -> int:
    """What sticks farthest beyond ``edge`` [of its cone]; −1 for none."""
    found, most, largest = -1, edge, _largest(w)
    for i in range(len(w.kappa)):
        if w.slip[i] == STICKS:
            share = _share(w, i, largest)
            if share > most:
                found, most = i, share
    return found


@borrowing
def _largest(w: Wave) -> float:
    largest = 0.0
    for k in range(len(w.free)):
        largest = max(largest, abs(w.force[k]))
    return largest


@borrowing
def _share(w: Wave, i: int, largest: float) -> float:
    """Friction of what sticks over what its cone holds."""
    t = w.tangent[i]
    pull = math.sqrt(w.force[t] ** 2 + w.force[t + 1] ** 2)
    cone = w.mu[i] * w.force[w.normal[i]]
    # What pulls by rounding alone does not make slip.
    if pull <= AT_CHANGE * largest:
        return 0.0
    return float(pull / cone) if cone > 0.0 else math.inf


@borrowing
def _shared(w: Wave, edge: float) -> bool:
    """Share what redundant contacts hold so that the largest share of a cone is least.

    Whether all are in their cones then. Each takes the less, the more of its cone it had to give.
    """
    inside = 0
    for _ in range(MOST_SHARES):
        # On from where all are inside, so that they stay there for a while.
        inside += _farthest(w, edge) < 0
        if w.redundant[0] == 0 or inside > INSIDE:
            break
        largest, most = _largest(w), 0.0
        for i in range(len(w.kappa)):
            if w.slip[i] == STICKS:
                w.share[i] *= min(max(_share(w, i, largest), 0.1), 10.0)
                most = max(most, w.share[i])
        for i in range(len(w.kappa)):
            w.share[i] = max(w.share[i] / most, AT_CHANGE) if w.slip[i] == STICKS else 1.0
        find_forces(w, w.y)
    return _farthest(w, edge) < 0


@borrowing
def _start_slip(w: Wave, i: int) -> None:
    """A contact at rest begins to slip: in the direction that its own friction then opposes."""
    t = w.tangent[i]
    force = float(w.force[w.normal[i]])
    f1, f2 = float(w.force[t]), float(w.force[t + 1])
    n1, n2, b11, b12, b22 = _free_of(w, i)
    size, pull = math.sqrt(n1 * n1 + n2 * n2), math.sqrt(f1 * f1 + f2 * f2)
    s1, s2 = 0.0, 0.0
    if force > 0.0 and pull > 0.0 and _is_held(w, i, b11, b12, b22, f1, f2):
        # It gives all it has, and the others take the rest.
        w.slip[i], s1, s2 = LEANS, -f1 / pull, -f2 / pull
    elif w.mode[i] == HELD and not size > AT_CHANGE * _largest(w):
        # Without friction it stays where it is: what is held along normals holds it.
        find_forces(w, w.y)
        return
    elif not size > 0.0:
        w.slip[i] = STICKS
        find_forces(w, w.y)
        return
    else:
        w.slip[i], s1, s2 = SLIPS, n1 / size, n2 / size
        if force > 0.0 and w.mode[i] != HELD and b11 * b22 - b12 * b12 > HELD_BY_OTHERS * b11 * b22:
            w.slip[i] = CREEPS
    w.way[i, 0], w.way[i, 1] = s1, s2
    w.way[i, 2] = min(float(w.u[t] * s1 + w.u[t + 1] * s2), 0.0)
    find_forces(w, w.y)
    if w.slip[i] == CREEPS:
        w.way[i, 0] = -w.force[t] / (w.mu[i] * force)
        w.way[i, 1] = -w.force[t + 1] / (w.mu[i] * force)


@borrowing
def _is_held(w: Wave, i: int, b11: float, b12: float, b22: float, d1: float, d2: float) -> bool:
    """Whether others hold contact i along d: W of its tangents beside them is none along it."""
    t = w.tangent[i]
    give = b11 * d1 * d1 + 2.0 * b12 * d1 * d2 + b22 * d2 * d2
    alone = w.W[t, t] * d1 * d1 + 2.0 * w.W[t, t + 1] * d1 * d2 + w.W[t + 1, t + 1] * d2 * d2
    return bool(give <= HELD_BY_OTHERS * alone)


@borrowing
def _free_of(w: Wave, i: int) -> tuple[float, float, float, float, float]:
    """Without friction of contact i: how its tangents accelerate, and W of them, 11, 12 and 22.

    Its slip is NONE after that, and forces are to be found again.
    """
    t = w.tangent[i]
    w.slip[i] = NONE
    find_forces(w, w.y)
    n1, n2 = acceleration(w, int(t)), acceleration(w, int(t) + 1)
    w.force[t] = 1.0
    hold(w)
    b11, b12 = acceleration(w, int(t)) - n1, acceleration(w, int(t) + 1) - n2
    find_forces(w, w.y)
    w.force[t + 1] = 1.0
    hold(w)
    return n1, n2, b11, b12, acceleration(w, int(t) + 1) - n2
