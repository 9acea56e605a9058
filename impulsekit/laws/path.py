"""One impact followed along its normal impulse: friction opposes the slip at every instant.

With p the normal impulse so far and s the direction of slip, du/dp = W (−µ s, 1) (Routh
1860; Keller 1986). Slip ends where u_t = 0: there the contact sticks if friction can hold
it, |k| ≤ µ with W_tt k = w, w = W_tn; else slip starts again in the one direction that
keeps, w − µ W_tt s = λ s with λ > 0. Compression lasts while u_n < 0. The impact ends

- Newton: at u_n = −e u_n⁻,
- Poisson: at p = (1 + e) p_c, p_c the impulse of the compression,
- Stronge: when the normal impulse has regained e² of its work in compression.

Where slip does not turn, all is linear in p: closed form. Where it turns, see ``taylor``.
"""

from __future__ import annotations

import math

from .borrowed import borrowing
from .compiled import entry
from .pair import solve_pair
from .progress import (
    COMPRESSING,
    FALLS,
    FRICTION,
    NORMAL,
    P1,
    P2,
    PRESSED,
    REGAINED,
    RESIDUAL,
    SPENT,
    U1,
    U2,
    UN,
    Block,
    P,
    PathMemory,
    Triple,
    is_over,
    left_to_go,
    path_memory,
)
from .status import Status
from .taylor import STRAIGHT, Array, turn
from .tolerances import ARRIVED, AT_REST, GAIN, RESIDUAL_LIMIT, SINGULAR
from .words import JAM, NEWTON, POISSON, STRONGE

__all__ = ["STOPPED", "follow", "outgoing"]

# A normal velocity below this share ended with the slip, where friction wedges.
WEDGED = 1e-6
# Relative tolerance for the length of a unit vector.
UNIT = 1e-15
# Slip this slow against the velocities has ended.
STOPPED = 1e-15
# What rises this slowly against them, and no faster, does not.
LIFTED = 1e-12
MOST_SEGMENTS = 200
# Velocities of the way that are farther than this from W P have lost digits.
CLOSE = 1e-8
# Velocities whose squares are doubles in full.
SQUARES_FROM, SQUARES_TO = 1e-120, 1e120
_SOLVED, _GAIN = int(Status.SOLVED), int(Status.ENERGY_GAIN)
_NONE = int(Status.NO_SOLUTION)
_LOST, _ENDLESS = int(Status.INACCURATE), int(Status.NOT_CONVERGED)
# What goes on: slip that turns, slip that keeps, rest.
_TURNS, _SLIPS, _RESTS = 0, 1, 2

_Rates = tuple[float, float, float, float, float]


@entry(lambda: ((1.0,) * 6, -1.0, (1.0, 1.0, -1.0), 0.5, 0.5, STRONGE, path_memory()), seconds=4.0)
def follow(
    block: Block, before: float, free: Triple, e: float, mu: float, law: int, memory: PathMemory
) -> int:
    """The code of a ``Status``; impulse, u⁺, works and residual in ``memory.now``.

    Args:
        block: W [1/kg].
        before: u_n⁻; Newton's target is −e u_n⁻ [m/s].
        free: u_free, where the impact starts [m/s].
        e, mu: restitution and friction.
        law: NEWTON, POISSON or STRONGE.
        memory: is overwritten.
    """
    now = memory.now
    now[:] = 0.0
    now[U1], now[U2], now[UN] = free
    scale = max(abs(before), abs(free[2]))
    if mu > 0.0:
        scale = max(scale, abs(free[0]), abs(free[1]))
    if scale == 0.0 or SQUARES_FROM < scale < SQUARES_TO:
        return _follow(block, before, free, e, mu, law, scale, memory)
    # Works are squares of velocities, and would leave the doubles.
    unit = math.ldexp(1.0, min(-math.frexp(scale)[1], 1000))
    small = (unit * free[0], unit * free[1], unit * free[2])
    now[U1], now[U2], now[UN] = small
    code = _follow(block, unit * before, small, e, mu, law, unit * scale, memory)
    for k in (U1, U2, UN, P1, P2, P):
        now[k] /= unit
    for k in (FRICTION, NORMAL):
        now[k] = now[k] / unit / unit
    return code


@borrowing
def _follow(
    block: Block,
    before: float,
    free: Triple,
    e: float,
    mu: float,
    law: int,
    scale: float,
    memory: PathMemory,
) -> int:
    """``follow`` for velocities whose squares are doubles."""
    now = memory.now
    target = max(0.0, -e * before) if law == NEWTON else 0.0
    if free[2] - target >= -AT_REST * scale:
        return _SOLVED
    if not block[5] > 0.0:
        now[RESIDUAL] = 1.0
        return _NONE
    now[COMPRESSING] = 1.0 if free[2] < 0.0 else 0.0
    over, wedged = _run(block, memory, mu, law, e, target, scale)
    if not (over or wedged):
        code, now[RESIDUAL] = _ENDLESS, 1.0
    elif wedged and (now[COMPRESSING] > 0.0 or e > 0.0):
        # No impulse, however large, ends the approach or gives the rest of the release. Without
        # restitution a contact that wedges after its compression is at its end.
        code, now[RESIDUAL] = _NONE, 1.0
    else:
        now[RESIDUAL] = _residual(now, law, e, target, scale)
        code = JAM if now[FALLS] > 0.0 else _SOLVED
        if not now[RESIDUAL] <= RESIDUAL_LIMIT:
            code = _ENDLESS
    return _book(block, free, scale, code, now)


@borrowing
def _run(
    block: Block, memory: PathMemory, mu: float, law: int, e: float, target: float, scale: float
) -> tuple[bool, bool]:
    """Whether the impact came to its end, and whether nothing moves any more before it."""
    now = memory.now
    for _ in range(MOST_SEGMENTS):
        way, rates = _heading(block, now, mu, scale)
        if way == _TURNS:
            over = turn(block, memory, mu, law, e, target, scale)
        else:
            slips = way == _SLIPS
            if slips and rates[2] <= 0.0:
                now[FALLS] = 1.0
            over, wedged = _straight(now, rates, mu, slips, law, e, target, scale)
            if wedged:
                # Friction holds all that moves: u_n ended with the slip, up to rounding.
                if not (now[COMPRESSING] > 0.0 and abs(now[UN]) <= WEDGED * scale):
                    return False, True
                over = is_over(now, law, e, target, scale)
        if over:
            return True, False
    return False, False


@borrowing
def _book(block: Block, free: Triple, scale: float, code: int, now: Array) -> int:
    """Write u⁺ from the impulse, so that both agree to rounding, and the works; the code."""
    t11, t12, t22, n1, n2, nn = block
    f1, f2, fn = free
    p1, p2, pn = now[P1], now[P2], now[P]
    a1 = f1 + t11 * p1 + t12 * p2 + n1 * pn
    a2 = f2 + t12 * p1 + t22 * p2 + n2 * pn
    an = fn + n1 * p1 + n2 * p2 + nn * pn
    o1, o2, on = a1 - now[U1], a2 - now[U2], an - now[UN]
    now[U1], now[U2], now[UN] = a1, a2, an
    off = math.sqrt(o1 * o1 + o2 * o2 + on * on)
    rubs = p1 != 0.0 or p2 != 0.0
    valid = code in (_SOLVED, JAM)
    if rubs and valid and not off <= CLOSE * scale:
        code, valid = _LOST, False
    total = 0.5 * (p1 * (f1 + a1) + p2 * (f2 + a2) + pn * (fn + an))
    now[NORMAL] = total - now[FRICTION]
    size = abs(p1 * f1) + abs(p2 * f2) + abs(pn * fn) + abs(now[NORMAL]) + abs(now[FRICTION])
    if valid and total > 0.0 and total > GAIN * size:
        return _GAIN
    return code


@borrowing
def _heading(block: Block, now: Array, mu: float, scale: float) -> tuple[int, _Rates]:
    """What goes on, and the rates du_1, du_2, du_n, dP_1, dP_2 over dp if they keep."""
    t11, t12, t22, n1, n2, nn = block
    if mu == 0.0:
        return _RESTS, (n1, n2, nn, 0.0, 0.0)
    u1, u2 = float(now[U1]), float(now[U2])
    speed = math.sqrt(u1 * u1 + u2 * u2)
    begins = not speed > STOPPED * scale
    if not begins:
        s1, s2 = u1 / speed, u2 / speed
    else:
        now[U1], now[U2] = 0.0, 0.0
        k1, k2 = _holding(block)
        if math.sqrt(k1 * k1 + k2 * k2) <= mu:
            rise = nn + n1 * k1 + n2 * k2
            return _RESTS, (0.0, 0.0, rise if rise > SINGULAR * nn else 0.0, k1, k2)
        s1, s2 = outgoing(block, mu)
    d1 = n1 - mu * (t11 * s1 + t12 * s2)
    d2 = n2 - mu * (t12 * s1 + t22 * s2)
    size = abs(n1) + abs(n2) + mu * (t11 + t22)
    # Slip that begins keeps its direction, whatever rounding makes of that where W_tt is stiff.
    if not begins and abs(s1 * d2 - s2 * d1) > STRAIGHT * size:
        return _TURNS, (0.0, 0.0, 0.0, 0.0, 0.0)
    along = s1 * d1 + s2 * d2
    falls = nn - mu * (n1 * s1 + n2 * s2)
    return _SLIPS, (along * s1, along * s2, falls, -mu * s1, -mu * s2)


@borrowing
def _straight(
    now: Array,
    rates: _Rates,
    mu: float,
    slips: bool,
    law: int,
    e: float,
    target: float,
    scale: float,
) -> tuple[bool, bool]:
    """Go on while rates keep; whether that was the end, and whether nothing moves any more."""
    d1, d2, dn, k1, k2 = rates
    speed = math.sqrt(now[U1] * now[U1] + now[U2] * now[U2]) if slips else 0.0
    phase = _to_end_of_phase(now, dn, slips, law, e, target, scale)
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


@borrowing
def _to_end_of_phase(
    now: Array, dn: float, slips: bool, law: int, e: float, target: float, scale: float
) -> float:
    """The impulse to the end of compression or restitution if du_n/dp keeps; may be infinite."""
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
    return max(phase, 0.0) if in_work > 0.0 else 0.0


@borrowing
def _holding(block: Block) -> tuple[float, float]:
    """dP_t/dp that keeps u_t = 0."""
    t11, t12, t22, n1, n2, _ = block
    det = t11 * t22 - t12 * t12
    if det > SINGULAR * t11 * t22 and det > 0.0:
        return solve_pair(t11, t12, t22, -n1, -n2)
    # W_tt of rank one at most; w lies in its range, as W is semidefinite.
    trace = t11 + t22
    if not trace > 0.0:
        return 0.0, 0.0
    return -n1 / trace, -n2 / trace


@borrowing
def outgoing(block: Block, mu: float) -> tuple[float, float]:
    """s with (λ + µ W_tt) s = w and λ > 0: the direction in which slip starts again."""
    t11, t12, t22, n1, n2, _ = block
    # |(λ + µ W_tt)⁻¹ w| falls with λ: Newton on its inverse climbs to the root from below.
    mean, half = 0.5 * (t11 + t22), 0.5 * (t11 - t22)
    spread = math.sqrt(half * half + t12 * t12)
    size = math.sqrt(n1 * n1 + n2 * n2)
    k = max(size - mu * (mean + spread), UNIT * size)
    s1, s2 = n1 / size, n2 / size
    for _ in range(100):
        k1, k2, k12 = mu * t11 + k, mu * t22 + k, mu * t12
        det = k1 * k2 - k12 * k12
        s1, s2 = (k2 * n1 - k12 * n2) / det, (k1 * n2 - k12 * n1) / det
        length = math.sqrt(s1 * s1 + s2 * s2)
        if length <= 1.0 + UNIT:
            break
        slope = (k2 * s1 * s1 - 2.0 * k12 * s1 * s2 + k1 * s2 * s2) / det
        step = length * length * (length - 1.0) / slope
        if step <= ARRIVED * k:
            break
        k += step
    length = math.sqrt(s1 * s1 + s2 * s2)
    return s1 / length, s2 / length


@borrowing
def _residual(now: Array, law: int, e: float, target: float, scale: float) -> float:
    """How far the end is from what the law asks, relative."""
    if law == NEWTON:
        return float(abs(now[UN] - target)) / scale
    if law == POISSON:
        return float(abs(now[P] - (1.0 + e) * now[PRESSED]) / now[P])
    if now[SPENT] == 0.0:
        return 0.0
    return float(abs(now[REGAINED] + e * e * now[SPENT]) / -now[SPENT])
