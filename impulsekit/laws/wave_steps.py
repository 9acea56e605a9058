"""The steps in which the impulses of a ``Wave`` grow: of order 8, up to what a contact changes.

Hairer, Nørsett & Wanner, Solving Ordinary Differential Equations I, II.5 (1993).
"""

from __future__ import annotations

import math

from .borrowed import borrowing
from .dop853 import ERROR_3, ERROR_5, FROM, NODES, STAGES, WEIGHTS
from .wave import any_held, force_rate, rates, smooth_rates, velocities
from .wave_changes import RISES
from .wave_holds import acceleration
from .wave_slips import IN_CONE, SLOW
from .wave_state import (
    CREEPS,
    FAINT,
    HELD,
    LOADS,
    NONE,
    OPEN,
    SLIPS,
    STICKS,
    UNLOADS,
    Array,
    Matrix,
    Wave,
)  # fmt: skip
from .wave_stiff import implicit_trial

__all__ = ["AT_REST", "FIRST", "adaptive_step", "choose_lead", "longest_step"]

# By how much a flight goes beyond the contact that it leads to; the error below which the next
# step grows as far as it may; how exactly a change is located, as a share of the step.
BEYOND, EXACT, FOUND = 1e-12, 1e-12, 1e-15
# Contacts that end by this much later than the one that leads end with it.
SAME_END = 1.0 + 1e-9
# The error of a step, in units in which velocities, impulses and indentations are of size 1.
# With friction slip may pass 0 at next to no distance, which makes of errors many times as large.
TOLERANCE, WITH_FRICTION = 2e-12, 2e-13
# The first step, in units in which the impact takes about 3.
FIRST = 0.03
# A contact leads the step where its start or end is nearer than this many steps.
NEARBY = 1.5
# A step goes so far towards the end of a contact, where the force has no smooth derivatives.
NEARER = 0.6
# A step goes so far at most beyond the slip up to which it creeps.
OUT_OF_CREEP = 2.0
# Slip whose direction rounding decides: how fast it changes [times it] is as uncertain as this.
UNCERTAIN = 1e-14
# Approaches this small have ended [of the largest velocity].
AT_REST = 1e-10
# What is beyond a change by less is at it; a step that is none.
_SMALL, NEXT_TO_NOTHING = 1e-14, 1e-9


@borrowing
def _rate(w: Wave, i: int) -> float:
    """dδ/dt of a contact that gives way."""
    un = float(w.u[w.normal[i]])
    return -un / float(w.e2[i]) if w.mode[i] == UNLOADS else -un


@borrowing
def choose_lead(w: Wave, step: float) -> None:
    """Where a contact starts or ends within a step, its √δ is the variable of the step, not t.

    With δ = s² its force κ δ^n has derivatives in s, as δ has where it goes through 0 at a
    speed. Of several the one whose force bends most leads.
    """
    r, power, most = len(w.free), w.power[0], 0.0
    w.lead[0] = -1
    if w.stiff[0] == 1:
        return
    for i in range(len(w.kappa)):
        if w.mode[i] != LOADS and w.mode[i] != UNLOADS:
            continue
        depth, rate = w.y[r + i], _rate(w, i)
        speed = abs(rate)
        # What others press in from rest did not start at a speed.
        pressed = rate > 0.0 and acceleration(w, int(w.normal[i])) < 0.0
        if depth < 0.0 or speed <= AT_REST or pressed or (rate < 0.0 and depth == 0.0):
            continue
        near = depth / speed
        if near < NEARBY * step:
            bend = w.kappa[i] * speed**power * (near + FIRST * step) ** (power - 8.0)
            if bend > most:
                w.lead[0], w.pace[0], most = i, rate, bend


@borrowing
def longest_step(w: Wave) -> float:
    """How far a step may go: not beyond what a parting or closing contact allows, nor a slip.

    A slip that slows down might end, and come back, within one step: it goes to where its line
    ends, which is Newton's iteration to its first zero.
    """
    r = len(w.free)
    rubs = r > len(w.kappa)
    longest, still = math.inf, True
    lead, leads = w.lead[0], 0.0
    if lead >= 0 and w.pace[0] < 0.0:
        leads = float(-w.y[r + lead] / w.pace[0])
    for i in range(len(w.kappa)):
        depth, un = w.y[r + i], w.u[w.normal[i]]
        if w.mode[i] in (LOADS, UNLOADS) and depth > 0.0:
            still = False
            if un > 0.0:
                rate = un / w.e2[i] if w.mode[i] == UNLOADS else un
                whole = i == lead or depth <= SAME_END * leads * rate
                longest = min(longest, depth / rate if whole else NEARER * depth / rate)
        elif w.mode[i] == HELD:
            still = still and w.force[w.normal[i]] == 0.0
        if rubs and w.slip[i] == SLIPS:
            longest = min(longest, _line_of_slip(w, i))
    if still:
        # Free flight to the next contact.
        for i in range(len(w.kappa)):
            depth, un = w.y[r + i], w.u[w.normal[i]]
            if un < -AT_REST and depth < 0.0:
                longest = min(longest, -depth / -un * (1.0 + BEYOND))
    return longest


@borrowing
def _line_of_slip(w: Wave, i: int) -> float:
    """When the slip of contact i would end at the rate it has; infinity where it does not fall."""
    t = w.tangent[i]
    speed = w.u[t] * w.way[i, 0] + w.u[t + 1] * w.way[i, 1]
    rate = acceleration(w, int(t)) * w.way[i, 0] + acceleration(w, int(t) + 1) * w.way[i, 1]
    if rate >= 0.0 or speed <= FAINT or (w.stiff[0] == 1 and -rate * speed <= UNCERTAIN):
        return math.inf
    return float(-speed / rate)


@borrowing
def adaptive_step(w: Wave, h: float) -> tuple[int, float]:
    """One step of at most h; the change at which it ended or −1, and the next one's length."""
    for _ in range(60):
        error = _trial(w, h)
        if error > 1.0:
            h *= max(0.2, 0.9 * error ** (-1.0 / 8.0))
            continue
        slip = _creeping_slip(w)
        if slip <= OUT_OF_CREEP * SLOW:
            break
        # Friction against the acceleration: no error of a step tells that it is slip's by now.
        h *= max(0.2, math.sqrt(SLOW / slip))
    grown = h * min(6.0, 0.9 * max(error, EXACT) ** (-1.0 / 8.0))
    which = _first_crossed(w)
    if which >= 0:
        which = _to_change(w, h, which)
    for k in range(len(w.y)):
        w.y[k] = w.trial[k]
    return which, grown


@borrowing
def _creeping_slip(w: Wave) -> float:
    """The fastest slip of what creeps, at the end of a trial."""
    most = 0.0
    for i in range(len(w.kappa)):
        if w.slip[i] == CREEPS:
            u1, u2 = float(w.u[w.tangent[i]]), float(w.u[w.tangent[i] + 1])
            most = max(most, math.sqrt(u1 * u1 + u2 * u2))
    return most


@borrowing
def _trial(w: Wave, h: float) -> float:
    """The error of a step of h over what it may be; y behind it is in ``w.trial``."""
    if w.stiff[0] == 1:
        return float(implicit_trial(w, h))
    K, y, trial, lead = w.stages, w.y, w.trial, w.lead[0]
    m, r = len(y), len(w.free)
    # What the rates are multiplied by is the variable's way of the step: time, or √δ.
    length, root = h, 0.0
    if lead >= 0:
        root = math.sqrt(max(y[r + lead], 0.0))
        length = math.sqrt(max(y[r + lead] + w.pace[0] * h, 0.0)) - root
    smooth = len(w.free) == len(w.kappa) and not any_held(w.mode)
    if smooth:
        kappa, e2, power, modes = w.kappa, w.e2, w.power[0], w.mode
        W, reach, free, u, force = w.W, w.reach, w.free, w.u, w.force
        for s in range(STAGES):
            _state_of_stage(y, length, K, s, trial)
            velocities(W, reach, free, trial, u)
            smooth_rates(e2, kappa, power, modes, trial, K[s], u, force)
            if lead >= 0 and not _led(w, K, s, root + NODES[s] * length):
                return math.inf
    else:
        for s in range(STAGES):
            _state_of_stage(y, length, K, s, trial)
            rates(w, trial, K[s])
            if lead >= 0 and not _led(w, K, s, root + NODES[s] * length):
                return math.inf
    fifth, third = 0.0, 0.0
    tolerance = TOLERANCE if r == len(w.kappa) else WITH_FRICTION
    for k in range(m):
        total, e5, e3 = 0.0, 0.0, 0.0
        for j in range(STAGES):
            total += WEIGHTS[j] * K[j, k]
            e5 += ERROR_5[j] * K[j, k]
            e3 += ERROR_3[j] * K[j, k]
        trial[k] = y[k] + length * total
        allowed = tolerance * (0.1 + abs(y[k]))
        fifth += (e5 / allowed) ** 2
        third += (e3 / allowed) ** 2
    if lead >= 0:
        trial[r + lead] = (root + length) ** 2
    rates(w, trial, w.error)
    if fifth == 0.0 and third == 0.0:
        return 0.0
    return float(abs(length) * fifth / math.sqrt((fifth + 0.01 * third) * m))


@borrowing
def _led(w: Wave, K: Matrix, s: int, root: float) -> bool:
    """Let the rates of a stage be by √δ of the contact that leads: dy/d√δ = dy/dt 2 √δ/(dδ/dt).

    False where its δ turns back.
    """
    rate = K[s, len(w.free) + w.lead[0]]
    if not rate * w.pace[0] > 0.0:
        return False
    share = 2.0 * root / rate
    for k in range(len(w.y)):
        K[s, k] *= share
    return True


@borrowing
def _state_of_stage(y: Array, h: float, K: Matrix, s: int, state: Array) -> None:
    m = len(y)
    for k in range(m):
        state[k] = 0.0
    for j in range(s):
        share = FROM[s, j]
        if share != 0.0:
            for k in range(m):
                state[k] += share * K[j, k]
    for k in range(m):
        state[k] = y[k] + h * state[k]


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
        _trial(w, middle)
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
    _trial(w, high)
    return which


@borrowing
def _left_at_start(w: Wave, which: int) -> float:
    """``_left`` where the step begins."""
    for k in range(len(w.y)):
        w.trial[k] = w.y[k]
    rates(w, w.y, w.error)
    return _left(w, which)
