"""One impact along its path, as ``impact.laws.path`` follows it, for kernels.

Where an inertia is neither one nor a zero, or the end is not what the law asks, the code AGAIN
leaves the state to the solver of single states.
"""

from __future__ import annotations

import math

from ...laws.status import Status
from ..codes import AGAIN
from .jit import built_in
from .progress import (
    COMPRESSING,
    FALLS,
    FRICTION,
    NORMAL,
    P1,
    P2,
    PRESSED,
    REGAINED,
    SPENT,
    U1,
    U2,
    UN,
    P,
    is_over,
    left_to_go,
)
from .turning import STRAIGHT, turn
from .words import NEWTON, POISSON

__all__ = ["follow"]

# As in ``impact``.
STOPPED = 1e-15
LIFTED = 1e-12
MOST_SEGMENTS = 200
MOST_TURNS = 400
GAIN = 1e-10
# Farther than this from W P the velocities of the way are in doubt.
CLOSE = 1e-9
# Shares so many times the velocities leave too few digits of their sum.
MOST_SHARES = 1e4
TINY, HUGE = 1e-120, 1e120
# Of rank one for all that rounding tells, and far from it; in between digits are lost.
NULL, NEAR = 1e-13, 1e-4
_SOLVED, _GAIN = int(Status.SOLVED), int(Status.ENERGY_GAIN)
_JAM, _NONE = int(Status.PAINLEVE_JAM), int(Status.NO_SOLUTION)
# What goes on: nothing that is sure, slip that turns, slip that keeps, rest.
_DOUBT, _TURNS, _SLIPS, _RESTS = -1, 0, 1, 2


@built_in
def follow(t11, t12, t22, n1, n2, nn, before, f1, f2, fn, e, mu, law, now, series):
    """The code; P and the works in ``now``.

    Args:
        t11, t12, t22, n1, n2, nn: W [1/kg].
        before: u_n⁻; f1, f2, fn: u_free, where the impact starts [m/s].
        e, mu: restitution and friction.
        law: NEWTON, POISSON or STRONGE.
        now: room, (PROGRESS,).
        series: room, (SERIES, ORDER + 1).
    """
    now[:] = 0.0
    scale = max(abs(before), abs(fn))
    if mu > 0.0:
        scale = max(scale, abs(f1), abs(f2))
    target = max(0.0, -e * before) if law == NEWTON else 0.0
    if fn - target >= -1e-15 * scale:
        return _SOLVED
    if not (nn > 0.0 and TINY < scale < HUGE):
        return AGAIN
    now[U1], now[U2], now[UN] = f1, f2, fn
    now[COMPRESSING] = 1.0 if fn < 0.0 else 0.0
    turns = 0
    over = wedged = False
    for _ in range(MOST_SEGMENTS):
        way, d1, d2, dn, k1, k2 = _heading(t11, t12, t22, n1, n2, nn, now, mu, scale)
        if way == _DOUBT:
            return AGAIN
        if way == _TURNS:
            over, steps = turn(t11, t12, t22, n1, n2, nn, now, mu, law, e, target, scale, series)
            turns += steps
            if turns > MOST_TURNS:
                return AGAIN
        else:
            slips = way == _SLIPS
            if slips and dn <= 0.0:
                now[FALLS] = 1.0
            over, wedged = _straight(now, d1, d2, dn, k1, k2, mu, slips, law, e, target, scale)
            if wedged:
                # Friction holds all that moves: u_n ended with the slip, up to rounding.
                if not (now[COMPRESSING] > 0.0 and abs(now[UN]) <= 1e-6 * scale):
                    break
                over = is_over(now, law, e, target, scale)
                wedged = False
        if over:
            break
    # Without restitution a wedged contact is at its end as well.
    if wedged and law != POISSON and e > 0.0:
        return _NONE
    if not (over or wedged) or not _residual(now, law, e, target, scale) <= 1e-9:
        return AGAIN
    p1, p2, pn = now[P1], now[P2], now[P]
    a1, a2 = f1 + t11 * p1 + t12 * p2 + n1 * pn, f2 + t12 * p1 + t22 * p2 + n2 * pn
    an = fn + n1 * p1 + n2 * p2 + nn * pn
    o1, o2, on = a1 - now[U1], a2 - now[U2], an - now[UN]
    if p1 != 0.0 or p2 != 0.0:
        shares = t11 * abs(p1) + t22 * abs(p2) + nn * pn
        off = math.sqrt(o1 * o1 + o2 * o2 + on * on)
        if not (off <= CLOSE * scale and shares <= MOST_SHARES * scale):
            return AGAIN
    total = 0.5 * (p1 * (f1 + a1) + p2 * (f2 + a2) + pn * (fn + an))
    now[NORMAL] = total - now[FRICTION]
    size = abs(p1 * f1) + abs(p2 * f2) + abs(pn * fn) + abs(now[NORMAL]) + abs(now[FRICTION])
    if total > 0.0 and total > GAIN * size:
        return _GAIN
    return _JAM if now[FALLS] > 0.0 else _SOLVED


@built_in
def _heading(t11, t12, t22, n1, n2, nn, now, mu, scale):
    """What goes on, and the rates du_1, du_2, du_n, dP_1, dP_2 over dp if they keep."""
    if mu == 0.0:
        return _RESTS, n1, n2, nn, 0.0, 0.0
    speed = math.sqrt(now[U1] * now[U1] + now[U2] * now[U2])
    if speed > STOPPED * scale:
        s1, s2 = now[U1] / speed, now[U2] / speed
    else:
        now[U1], now[U2] = 0.0, 0.0
        k1, k2, sure = _holding(t11, t12, t22, n1, n2)
        if not sure:
            return _DOUBT, 0.0, 0.0, 0.0, 0.0, 0.0
        if math.sqrt(k1 * k1 + k2 * k2) <= mu:
            rise = nn + n1 * k1 + n2 * k2
            if rise > NULL * nn:
                return _RESTS if rise > NEAR * nn else _DOUBT, 0.0, 0.0, rise, k1, k2
            return _RESTS, 0.0, 0.0, 0.0, k1, k2
        s1, s2 = _outgoing(t11, t12, t22, n1, n2, mu)
    d1 = n1 - mu * (t11 * s1 + t12 * s2)
    d2 = n2 - mu * (t12 * s1 + t22 * s2)
    size = abs(n1) + abs(n2) + mu * (t11 + t22)
    if abs(s1 * d2 - s2 * d1) > STRAIGHT * size:
        return _TURNS, 0.0, 0.0, 0.0, 0.0, 0.0
    along = s1 * d1 + s2 * d2
    return _SLIPS, along * s1, along * s2, nn - mu * (n1 * s1 + n2 * s2), -mu * s1, -mu * s2


@built_in
def _straight(now, d1, d2, dn, k1, k2, mu, slips, law, e, target, scale):
    """Go on while rates keep; whether that was the end, and whether nothing moves any more."""
    in_velocity, in_impulse, in_work = left_to_go(now, law, e, target)
    phase = in_impulse
    if in_velocity < math.inf:
        phase = in_velocity / dn if dn > 0.0 else math.inf
    elif in_work < math.inf:
        # un p + dn p²/2 = work, in the form that bears dn → 0.
        un = now[UN]
        if not slips and dn <= 0.0 and abs(un) <= LIFTED * scale:
            # What friction holds wholly does not lift off by rounding.
            un = 0.0
        root = un * un + 2.0 * dn * in_work
        below = un + math.sqrt(max(root, 0.0))
        phase = 2.0 * in_work / below if root >= 0.0 and below > 0.0 else math.inf
    phase = max(phase, 0.0) if in_work > 0.0 else 0.0
    speed = math.sqrt(now[U1] * now[U1] + now[U2] * now[U2]) if slips else 0.0
    decay = -(d1 * now[U1] + d2 * now[U2]) / speed if speed > 0.0 else 0.0
    stop = speed / decay if decay > 0.0 else math.inf
    # Friction may draw a contact back in after it has begun to part.
    back = math.inf
    if now[COMPRESSING] == 0.0 and dn < 0.0 and now[UN] > 0.0:
        back = -now[UN] / dn
    step = min(phase, stop, back)
    if step == math.inf:
        return False, True
    work = step * (now[UN] + 0.5 * step * dn)
    if slips:
        x, y = now[U1] + d1 * step, now[U2] + d2 * step
        now[FRICTION] -= mu * step * 0.5 * (speed + math.sqrt(x * x + y * y))
    if now[COMPRESSING] > 0.0:
        now[PRESSED] += step
        now[SPENT] += work
    else:
        now[REGAINED] += work
    now[U1] += d1 * step
    now[U2] += d2 * step
    now[UN] += dn * step
    now[P1] += k1 * step
    now[P2] += k2 * step
    now[P] += step
    if step == stop and slips:
        now[U1], now[U2] = 0.0, 0.0
    if step == phase:
        return is_over(now, law, e, target, scale), False
    if step == back:
        now[UN], now[COMPRESSING] = 0.0, 1.0
    return False, False


@built_in
def _holding(t11, t12, t22, n1, n2):
    """dP_t/dp that keeps u_t = 0, and whether it is sure."""
    det = t11 * t22 - t12 * t12
    if det > NULL * t11 * t22 and det > 0.0:
        k1, k2 = (t12 * n2 - t22 * n1) / det, (t12 * n1 - t11 * n2) / det
        return k1, k2, det > NEAR * t11 * t22
    # W_tt of rank one at most; w lies in its range, as W is semidefinite.
    trace = t11 + t22
    if not trace > 0.0:
        return 0.0, 0.0, True
    return -n1 / trace, -n2 / trace, True


@built_in
def _outgoing(t11, t12, t22, n1, n2, mu):
    """s with (λ + µ W_tt) s = w and λ > 0: the direction in which slip starts again."""
    # |(λ + µ W_tt)⁻¹ w| falls with λ: Newton on its inverse climbs to the root from below.
    mean, half = 0.5 * (t11 + t22), 0.5 * (t11 - t22)
    spread = math.sqrt(half * half + t12 * t12)
    size = math.sqrt(n1 * n1 + n2 * n2)
    k = max(size - mu * (mean + spread), 1e-15 * size)
    s1, s2 = n1 / size, n2 / size
    for _ in range(100):
        k1, k2, k12 = mu * t11 + k, mu * t22 + k, mu * t12
        det = k1 * k2 - k12 * k12
        s1, s2 = (k2 * n1 - k12 * n2) / det, (k1 * n2 - k12 * n1) / det
        length = math.sqrt(s1 * s1 + s2 * s2)
        if length <= 1.0 + 1e-15:
            break
        slope = (k2 * s1 * s1 - 2.0 * k12 * s1 * s2 + k1 * s2 * s2) / det
        step = length * length * (length - 1.0) / slope
        if step <= 1e-16 * k:
            break
        k += step
    length = math.sqrt(s1 * s1 + s2 * s2)
    return s1 / length, s2 / length


@built_in
def _residual(now, law, e, target, scale):
    """How far the end is from what the law asks, relative."""
    if law == NEWTON:
        return abs(now[UN] - target) / scale
    if law == POISSON:
        return abs(now[P] - (1.0 + e) * now[PRESSED]) / now[P]
    if now[SPENT] == 0.0:
        return 0.0
    return abs(now[REGAINED] + e * e * now[SPENT]) / -now[SPENT]
