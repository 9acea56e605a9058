"""One impact followed along its normal impulse: friction opposes the slip at every instant.

With p the normal impulse so far and s the direction of slip, du/dp = W (−µ s, 1) (Routh
1860; Keller 1986). Slip ends where u_t = 0: there the contact sticks if friction can hold
it, |k| ≤ µ with W_tt k = w, w = W_tn; else slip starts again in the one direction that
keeps, w − µ W_tt s = λ s with λ > 0. Compression lasts while u_n < 0. The impact ends

- Newton: at u_n = −e u_n⁻,
- Poisson: at p = (1 + e) p_c, p_c the impulse of the compression,
- Stronge: when the normal impulse has regained e² of its work in compression.

Where slip does not turn, all is linear in p: closed form. Where it turns, see ``turning``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ...laws.status import Status
from .coulomb import NOTHING
from .single import Hit, Triple, gained, moved
from .slide import Block

__all__ = ["NULL", "STOPPED", "Progress", "follow", "left_to_go", "outgoing"]

# Slip this slow against the velocities has ended.
STOPPED = 1e-15
# What rises this slowly against them, and no faster, does not.
LIFTED = 1e-12
# A direction that turns slower than this against its decay keeps.
STRAIGHT = 1e-13
MOST_SEGMENTS = 200
# An inertia this much smaller than its terms is a zero.
NULL = 1e-10


@dataclass(slots=True)
class Progress:
    """An impact so far. Velocities [m/s], impulses [N s], works [J].

    Attributes:
        u1, u2, un: the relative velocity.
        p1, p2, p: the impulse.
        normal, friction: the works.
        pressed, spent: impulse and (negative) work of compression.
        regained: work of restitution.
        compressing: whether u_n < 0.
    """

    u1: float
    u2: float
    un: float
    p1: float = 0.0
    p2: float = 0.0
    p: float = 0.0
    normal: float = 0.0
    friction: float = 0.0
    pressed: float = 0.0
    spent: float = 0.0
    regained: float = 0.0
    compressing: bool = True


def left_to_go(now: Progress, law: str, e: float, target: float) -> tuple[float, float, float]:
    """What ends the phase at hand: (in u_n, in p, in work); infinite where it is not asked."""
    if now.compressing:
        return -now.un, math.inf, math.inf
    if law == "newton":
        return target - now.un, math.inf, math.inf
    if law == "poisson":
        return math.inf, (1.0 + e) * now.pressed - now.p, math.inf
    return math.inf, math.inf, -e * e * now.spent - now.regained


def follow(
    block: Block,
    before: Triple,
    free: Triple,
    e: float,
    mu: float,
    law: str,
    scale: float,
) -> Hit:
    """The impact of one contact.

    Args:
        block: W [1/kg].
        before, free: u⁻ and u_free [m/s]; the impact starts at u_free, Newton's target
            is −e u_n⁻.
        e, mu: restitution and friction.
        law: "newton", "poisson" or "stronge".
        scale: the size of the velocities [m/s].
    """
    target = max(0.0, -e * before[2]) if law == "newton" else 0.0
    if free[2] - target >= -1e-15 * scale:
        return Hit(NOTHING, free, Status.SOLVED, 0.0, 0.0, 0.0)
    if block[5] <= 0.0:
        return Hit(NOTHING, free, Status.NO_SOLUTION, 1.0, 0.0, 0.0)
    now = Progress(*free, compressing=free[2] < 0.0)
    jammed = wedged = False
    for _ in range(MOST_SEGMENTS):
        heading = _heading(block, now, mu, scale)
        if heading is None:
            from .turning import turn

            ended, falls = turn(block, now, mu, law, e, target, scale)
            jammed |= falls
        else:
            rates, kept = heading
            jammed |= kept and rates[2] <= 0.0
            ended, wedged = _straight(now, rates, mu, kept, law, e, target, scale)
            if wedged:
                # Friction holds all that moves: u_n ended with the slip, up to rounding.
                if not (now.compressing and abs(now.un) <= 1e-6 * scale):
                    break
                ended = _phase_over(now, law, e, target, scale)
                wedged = False
        if ended:
            break
    else:
        return _told(block, now, free, Status.NOT_CONVERGED, 1.0, scale)
    # Without restitution a wedged contact is at its end as well.
    if wedged and law != "poisson" and e > 0.0:
        return _told(block, now, free, Status.NO_SOLUTION, 1.0, scale)
    residual = _residual(now, law, e, target, scale)
    if residual > 1e-9:
        return _told(block, now, free, Status.NOT_CONVERGED, residual, scale)
    return _told(
        block, now, free, Status.PAINLEVE_JAM if jammed else Status.SOLVED, residual, scale
    )


def _heading(
    block: Block, now: Progress, mu: float, scale: float
) -> tuple[tuple[float, float, float, float, float], bool] | None:
    """(du_1, du_2, du_n, dP_1, dP_2)/dp if they keep, and whether it slips; None if slip turns."""
    t11, t12, t22, n1, n2, nn = block
    if not mu:
        return (n1, n2, nn, 0.0, 0.0), False
    speed = math.hypot(now.u1, now.u2)
    if speed > STOPPED * scale:
        s1, s2 = now.u1 / speed, now.u2 / speed
    else:
        now.u1 = now.u2 = 0.0
        held = _held(block, mu)
        if held is not None:
            k1, k2 = held
            rise = nn + n1 * k1 + n2 * k2
            return (0.0, 0.0, rise if rise > NULL * nn else 0.0, k1, k2), False
        s1, s2 = outgoing(block, mu)
    d1 = n1 - mu * (t11 * s1 + t12 * s2)
    d2 = n2 - mu * (t12 * s1 + t22 * s2)
    size = abs(n1) + abs(n2) + mu * (t11 + t22)
    if abs(s1 * d2 - s2 * d1) > STRAIGHT * size:
        return None
    along = s1 * d1 + s2 * d2
    falls = nn - mu * (n1 * s1 + n2 * s2)
    return (along * s1, along * s2, falls, -mu * s1, -mu * s2), True


def _straight(
    now: Progress,
    rates: tuple[float, float, float, float, float],
    mu: float,
    slips: bool,
    law: str,
    e: float,
    target: float,
    scale: float,
) -> tuple[bool, bool]:
    """Go on while rates keep; whether that was the end, and whether nothing moves any more."""
    d1, d2, dn = rates[:3]
    in_velocity, in_impulse, in_work = left_to_go(now, law, e, target)
    phase = in_impulse
    if in_velocity < math.inf:
        phase = in_velocity / dn if dn > 0.0 else math.inf
    elif in_work < math.inf:
        # un p + dn p²/2 = work, in the form that bears dn → 0.
        # What friction holds wholly does not lift off by rounding.
        lies = not slips and dn <= 0.0 and abs(now.un) <= LIFTED * scale
        un = 0.0 if lies else now.un
        root = un * un + 2.0 * dn * in_work
        below = un + math.sqrt(max(root, 0.0))
        phase = 2.0 * in_work / below if root >= 0.0 and below > 0.0 else math.inf
    phase = max(phase, 0.0) if in_work > 0.0 or in_work == math.inf else 0.0
    speed = math.hypot(now.u1, now.u2) if slips else 0.0
    decay = -(d1 * now.u1 + d2 * now.u2) / speed if speed else 0.0
    stop = speed / decay if decay > 0.0 else math.inf
    # Friction may draw a contact back in after it has begun to part.
    back = math.inf
    if not now.compressing and dn < 0.0 and now.un > 0.0:
        back = -now.un / dn
    step = min(phase, stop, back)
    if step == math.inf:
        return False, True
    _advance(now, rates, step, slips, mu)
    if step == stop and slips:
        now.u1 = now.u2 = 0.0
    if step == phase:
        return _phase_over(now, law, e, target, scale), False
    if step == back:
        now.un, now.compressing = 0.0, True
    return False, False


def _advance(
    now: Progress,
    rates: tuple[float, float, float, float, float],
    step: float,
    slips: bool,
    mu: float,
) -> None:
    """Add a stretch of p on which the rates keep."""
    d1, d2, dn, k1, k2 = rates
    work = step * (now.un + 0.5 * step * dn)
    if slips:
        speed = math.hypot(now.u1, now.u2)
        then = math.hypot(now.u1 + d1 * step, now.u2 + d2 * step)
        now.friction -= mu * step * 0.5 * (speed + then)
    now.normal += work
    if now.compressing:
        now.pressed += step
        now.spent += work
    else:
        now.regained += work
    now.u1, now.u2, now.un = now.u1 + d1 * step, now.u2 + d2 * step, now.un + dn * step
    now.p1, now.p2, now.p = now.p1 + k1 * step, now.p2 + k2 * step, now.p + step


def _phase_over(now: Progress, law: str, e: float, target: float, scale: float) -> bool:
    """Go over from compression to restitution, or say that the impact is over."""
    if not now.compressing:
        return True
    now.compressing = False
    now.un = 0.0
    return e == 0.0 or (law == "newton" and target <= 1e-15 * scale)


def _held(block: Block, mu: float) -> tuple[float, float] | None:
    """dP_t/dp that keeps u_t = 0, if friction can give it."""
    t11, t12, t22, n1, n2, _ = block
    det = t11 * t22 - t12 * t12
    if det > NULL * t11 * t22 > 0.0:
        k1, k2 = (t12 * n2 - t22 * n1) / det, (t12 * n1 - t11 * n2) / det
    else:
        # W_tt of rank one at most; w lies in its range, as W is semidefinite.
        trace = t11 + t22
        if trace <= 0.0:
            return (0.0, 0.0)
        k1, k2 = -n1 / trace, -n2 / trace
    return (k1, k2) if math.hypot(k1, k2) <= mu else None


def outgoing(block: Block, mu: float) -> tuple[float, float]:
    """s with (λ + µ W_tt) s = w and λ > 0: the direction in which slip starts again."""
    t11, t12, t22, n1, n2, _ = block
    # |(λ + µ W_tt)⁻¹ w| falls with λ: Newton on its inverse climbs to the root from below.
    mean, spread = 0.5 * (t11 + t22), math.hypot(0.5 * (t11 - t22), t12)
    size = math.hypot(n1, n2)
    k = max(size - mu * (mean + spread), 1e-15 * size)
    s1, s2 = n1 / size, n2 / size
    for _ in range(100):
        k1, k2, k12 = mu * t11 + k, mu * t22 + k, mu * t12
        det = k1 * k2 - k12 * k12
        s1, s2 = (k2 * n1 - k12 * n2) / det, (k1 * n2 - k12 * n1) / det
        length = math.hypot(s1, s2)
        if length <= 1.0 + 1e-15:
            break
        slope = (k2 * s1 * s1 - 2.0 * k12 * s1 * s2 + k1 * s2 * s2) / det
        step = length * length * (length - 1.0) / slope
        if step <= 1e-16 * k:
            break
        k += step
    length = math.hypot(s1, s2)
    return (s1 / length, s2 / length)


def _residual(now: Progress, law: str, e: float, target: float, scale: float) -> float:
    """How far the end is from what the law asks, relative."""
    if law == "newton":
        return abs(now.un - target) / scale
    if law == "poisson":
        return abs(now.p - (1.0 + e) * now.pressed) / now.p
    if not now.spent:
        return 0.0
    return abs(now.regained + e * e * now.spent) / -now.spent


def _told(
    block: Block, now: Progress, free: Triple, status: Status, residual: float, scale: float
) -> Hit:
    """The hit; u⁺ from the impulse, so that both agree to rounding."""
    impulse = (now.p1, now.p2, now.p)
    mu = 1.0 if now.p1 or now.p2 else 0.0
    after = moved(block, free, impulse, mu)
    if status.valid and math.dist(after, (now.u1, now.u2, now.un)) > 1e-8 * scale and mu:
        status = Status.INACCURATE
    status = gained(status, now.normal, now.friction, impulse, free)
    return Hit(impulse, after, status, residual, now.normal, now.friction)
