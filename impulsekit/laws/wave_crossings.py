"""Where in a step of a ``Wave`` a contact changes what it does.

What a step goes beyond is seen at its end; what begins and ends within it (a contact touched in
passing, friction out of its cone for a moment) at the vertex of a parabola.
"""

from __future__ import annotations

import math

from .borrowed import borrowing
from .wave import AHEAD, find_forces, force_rate, rates, velocities
from .wave_changes import RISES
from .wave_holds import acceleration
from .wave_slips import IN_CONE
from .wave_state import AFTER, BEGAN, CREEPS, HELD, LOADS, NONE, OPEN, SLIPS, STICKS, UNLOADS, Wave
from .wave_trial import trial_step

__all__ = ["find_change"]

# How exactly a change is located, as a share of the step.
FOUND = 1e-15
# What is beyond a change by less is at it; a step that is none.
_SMALL, NEXT_TO_NOTHING = 1e-14, 1e-9
# A parabola through a step comes near a change where it leaves less than this share of what its
# curvature makes in the step, ten times what a third derivative adds. It is drawn anew, so often,
# through the place that it told, until that moves by less than this share of the step.
NEAR_MISS, MOST_LOOKS, CROSSING_ARRIVED = 0.1, 4, 0.01


@borrowing
def find_change(w: Wave, h: float) -> int:
    """The first change in the step h just tried, which is shortened to it; −1 for none."""
    which = _first_crossed(w)
    if which >= 0:
        return _to_change(w, h, which)
    n = len(w.kappa)
    looks, moves = False, False
    for i in range(n):
        looks = looks or _is_watched(w, i) or _is_watched(w, n + i)
        moves = moves or w.mode[i] == HELD or w.slip[i] == STICKS
    if not looks:
        return -1
    if moves:
        _note_forces_ahead(w)
    found, place = -1, h
    for i in range(2 * n):
        if _is_watched(w, i):
            at = _vertex(w, i, h)
            if at < place:
                found, place = i, at
    return _look_within(w, found, place, h) if found >= 0 else -1


@borrowing
def _is_watched(w: Wave, which: int) -> bool:
    """Whether a change may begin and end within a step without a trace in the energy.

    What turns or returns for a moment leaves one, and the impact is followed again.
    """
    n, r = len(w.kappa), len(w.free)
    if which >= n:
        return bool(w.slip[which - n] == STICKS)
    i = which
    if w.mode[i] == OPEN:
        return bool(w.y[r + i] < 0.0 and w.u[w.normal[i]] > 0.0)
    return bool(w.mode[i] == HELD)


@borrowing
def _note_forces_ahead(w: Wave) -> None:
    """Forces a short time behind the trial into ``w.stages[2]``; all else is kept."""
    ahead, end = w.stages[0], w.stages[1]
    for k in range(len(w.y)):
        ahead[k] = w.trial[k] + AHEAD * w.error[k]
    for k in range(len(w.free)):
        end[k] = w.force[k]
    velocities(w.W, w.reach, w.free, ahead, w.u)
    find_forces(w, ahead)
    for k in range(len(w.free)):
        w.stages[AFTER, k], w.force[k] = w.force[k], end[k]
    velocities(w.W, w.reach, w.free, w.trial, w.u)


@borrowing
def _vertex(w: Wave, which: int, h: float) -> float:
    """Where in the step a parabola comes nearest to a change, if near; else h."""
    n, r = len(w.kappa), len(w.free)
    begin, end = _left_before(w, which), _left(w, which)
    if which < n and w.mode[which] == OPEN:
        slope = float(w.u[w.normal[which]])
    else:
        slope = (_left_of_force(w, which, AFTER) - end) / AHEAD
    if w.lead[0] >= 0:
        # By the variable of the step.
        slope *= w.pace[0] / w.error[r + w.lead[0]]
    bend = begin - end + slope * h
    if begin <= 0.0 or end <= 0.0 or slope <= 0.0 or not bend > 0.5 * slope * h:
        return h
    # end - slope (h - t) + bend (h - t)²/h²
    back = 0.5 * slope * h / bend
    near = end - 0.5 * slope * h * back < NEAR_MISS * bend
    return h * (1.0 - back) if near else h


@borrowing
def _left_before(w: Wave, which: int) -> float:
    """``_left`` of what is watched where the step begins."""
    if which < len(w.kappa) and w.mode[which] == OPEN:
        return -float(w.y[len(w.free) + which])
    return _left_of_force(w, which, BEGAN)


@borrowing
def _left_of_force(w: Wave, which: int, row: int) -> float:
    """``_left`` of what depends on forces alone, with those in a row of ``w.stages``."""
    n = len(w.kappa)
    if which < n:
        return float(w.stages[row, w.normal[which]])
    i = which - n
    t = w.tangent[i]
    pull = math.sqrt(w.stages[row, t] ** 2 + w.stages[row, t + 1] ** 2)
    return float(w.mu[i] * w.stages[row, w.normal[i]] * (1.0 + IN_CONE) - pull)


@borrowing
def _look_within(w: Wave, which: int, place: float, h: float) -> int:
    """Try the step up to its nearest to a change; what changes there or −1, with the step as then.

    Of a minimum between 0, the place and h the parabola through them tells the next place.
    """
    begin, end = _left_before(w, which), _left(w, which)
    for _ in range(MOST_LOOKS):
        trial_step(w, place)
        other = _first_crossed(w)
        if other >= 0:
            return _to_change(w, place, other)
        here = _left(w, which)
        # Slopes of the chords to both sides.
        down, up = (here - begin) / place, (end - here) / (h - place)
        bend = (up - down) / h
        if not bend > 0.0:
            break
        following = 0.5 * (place - down / bend)
        least = here - bend * (following - place) ** 2
        if not 0.0 < following < h or abs(following - place) <= CROSSING_ARRIVED * h:
            break
        if least > NEAR_MISS * bend * h * h:
            break
        place = following
    trial_step(w, h)
    return -1


@borrowing
def _left(w: Wave, which: int) -> float:
    """How far the trial is from a change: below 0 beyond it; infinite where there is none.

    ``which``: i for the normal of contact i, n + i for its slip, 2n + i where it is held and
    might be loaded again.
    """
    n, r = len(w.kappa), len(w.free)
    if which < n:
        i = which
        mode, un, depth = w.mode[i], w.u[w.normal[i]], w.trial[r + i]
        if mode == LOADS and w.e2[i] < 1.0 and depth > 0.0:
            return float(-un)
        if mode == UNLOADS:
            return float(un)
        if mode == OPEN and w.y[r + i] < 0.0:
            return float(-depth)
        if mode == HELD:
            return float(w.force[w.normal[i]])
        return math.inf
    if which >= 2 * n:
        i = which - 2 * n
        if w.mode[i] != HELD or w.kappa[i] == math.inf:
            return math.inf
        return RISES - force_rate(w, w.trial, i)
    i = which - n
    t = w.tangent[i]
    if t < 0 or w.mode[i] == OPEN:
        return math.inf
    if w.slip[i] == SLIPS:
        return float(w.u[t] * w.way[i, 0] + w.u[t + 1] * w.way[i, 1] - w.way[i, 2])
    if w.slip[i] == CREEPS:
        # Along its friction it is accelerated, as long as it could not stick.
        force = w.mu[i] * w.force[w.normal[i]]
        if not force > 0.0:
            return math.inf
        pull = acceleration(w, int(t)) * w.force[t] + acceleration(w, int(t) + 1) * w.force[t + 1]
        return float(-pull / force)
    if w.slip[i] == STICKS:
        pull = math.sqrt(w.force[t] ** 2 + w.force[t + 1] ** 2)
        return float(w.mu[i] * w.force[w.normal[i]] * (1.0 + IN_CONE) - pull)
    return math.inf


@borrowing
def _first_crossed(w: Wave) -> int:
    """Of the changes that the trial went beyond, the one that it left farthest behind; or −1."""
    modes, slip, normal, e2, u, y, trial = w.mode, w.slip, w.normal, w.e2, w.u, w.y, w.trial
    n, r = len(modes), len(u)
    found, most = -1, 0.0
    for i in range(n):
        mode, un = modes[i], u[normal[i]]
        left = 0.0
        if mode == LOADS:
            if e2[i] < 1.0 and trial[r + i] > 0.0:
                left = -un
        elif mode == UNLOADS:
            left = un
        elif mode == HELD or (y[r + i] < 0.0 and trial[r + i] > 0.0):
            left = _left(w, i)
        if left < -_SMALL and left < most:
            found, most = i, left
        if mode == HELD:
            left = _left(w, 2 * n + i)
            if left < -_SMALL and left < most:
                found, most = 2 * n + i, left
        if slip[i] != NONE:
            left = _left(w, n + i)
            if left < -_SMALL and left < most:
                found, most = n + i, left
    return found


@borrowing
def _to_change(w: Wave, h: float, which: int) -> int:
    """Shorten the step to the first change, by the Illinois rule on steps of their own.

    Which change it is; the step is in ``w.trial``.
    """
    low, high, side = 0.0, h, 0
    at_high, at_low = _left(w, which), _left_at_start(w, which)
    for _ in range(80):
        if not at_low > 0.0:
            # It was there already: the change is made behind a step of next to nothing.
            high = min(high, NEXT_TO_NOTHING)
            break
        if high - low <= FOUND * h:
            break
        middle = low + (high - low) * min(max(at_low / (at_low - at_high), 0.01), 0.99)
        trial_step(w, middle)
        other = _first_crossed(w)
        if other >= 0 and other != which:
            # Another change comes before.
            which, high, low, side = other, middle, 0.0, 0
            at_high, at_low = _left(w, which), _left_at_start(w, which)
            continue
        here = _left(w, which)
        if abs(here) <= _SMALL:
            return which
        if here < 0.0:
            high, at_high = middle, here
            at_low = 0.5 * at_low if side < 0 else at_low
            side = -1
        else:
            low, at_low = middle, here
            at_high = 0.5 * at_high if side > 0 else at_high
            side = 1
    trial_step(w, high)
    return which


@borrowing
def _left_at_start(w: Wave, which: int) -> float:
    """``_left`` where the step begins."""
    for k in range(len(w.y)):
        w.trial[k] = w.y[k]
    rates(w, w.y, w.error)
    return _left(w, which)
