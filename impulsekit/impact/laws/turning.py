"""Slip that turns while the impact goes on, in 3-D.

In τ with dp = r dτ, r = |u_t|, the equations are smooth down to r = 0, at τ → ∞, and linear
but for r itself:

    du_t/dτ = w r − µ W_tt u_t,   du_n/dτ = W_nn r − µ w·u_t,   r² = u_t·u_t

So their Taylor coefficients follow one from the other, r's from those of its square (Jorba &
Zou 2005, "A software package for the numerical integration of ODEs by means of high-order
Taylor methods"). A step of such order is exact to rounding, and where in it a phase ends is
a root of a polynomial.
"""

from __future__ import annotations

import math
from operator import mul

from .path import STRAIGHT, Progress, left_to_go
from .slide import Block

__all__ = ["turn"]

# Slip this slow against where the stretch began has ended.
FAINT = 1e-14
ORDER = 20
# What the last terms of a series may add.
CUT = 1e-17
LONGEST = 1e12
MOST_STEPS = 400

Series = list[float]
# µ W_tt and W_tn, W_nn in units of one inertia: a11, a12, a22, w1, w2, wn.
Rates = tuple[float, float, float, float, float, float]


def turn(
    block: Block, now: Progress, mu: float, law: str, e: float, target: float, scale: float
) -> tuple[bool, bool]:
    """Follow the slip to the end of the phase or of the slip, or until it keeps its direction.

    Returns:
        Whether the impact is over, and whether the contact was pressed further in
        meanwhile (W_nn ≤ µ w·s).
    """
    t11, t12, t22, n1, n2, nn = block
    first = math.hypot(now.u1, now.u2)
    tangential = abs(n1) + abs(n2) + mu * (t11 + t22)
    # Per step: velocities in units of r, τ of 1/inertia, impulses of r/inertia.
    inertia = tangential + nn
    a11, a12, a22 = mu * t11 / inertia, mu * t12 / inertia, mu * t22 / inertia
    rates = (a11, a12, a22, n1 / inertia, n2 / inertia, nn / inertia)
    straight = STRAIGHT * tangential / inertia
    falls = _falls(rates, mu, now.u1, now.u2)
    for _ in range(MOST_STEPS):
        r = math.hypot(now.u1, now.u2)
        if r <= FAINT * first:
            now.u1 = now.u2 = 0.0
            return False, falls
        turning = abs(_turning(rates, now.u1 / r, now.u2 / r))
        if turning <= straight and turning * r <= 1e-15 * first:
            return False, falls
        reached, pressed_in = _step(rates, now, mu, law, e, target, r, inertia)
        falls |= pressed_in
        if reached and not now.compressing:
            return True, falls
        if reached:
            now.compressing, now.un = False, 0.0
            return e == 0.0 or (law == "newton" and target <= 1e-15 * scale), falls
    return False, falls


def _falls(rates: Rates, mu: float, u1: float, u2: float) -> bool:
    """Whether slip at u presses the contact further in."""
    return rates[5] * math.hypot(u1, u2) <= mu * (rates[3] * u1 + rates[4] * u2)


def _turning(rates: Rates, s1: float, s2: float) -> float:
    """dθ/dτ of the direction of slip."""
    a11, a12, a22, w1, w2, _ = rates
    return s1 * (w2 - a12 * s1 - a22 * s2) - s2 * (w1 - a11 * s1 - a12 * s2)


def _step(
    rates: Rates,
    now: Progress,
    mu: float,
    law: str,
    e: float,
    target: float,
    r: float,
    inertia: float,
) -> tuple[bool, bool]:
    """One step, cut where the phase ends; whether it does, and whether the contact fell in."""
    u1, u2, un, speed, square, power = _series(rates, now, mu, r)
    h = _length(u1, u2, speed)
    # On each step u_n shall rise or fall, not both.
    rise = [(k + 1) * un[k + 1] for k in range(ORDER)]
    if rise[0] * _at(rise, h) < 0.0:
        lowest = _root(rise, 0.0, h)
        # Where the last step was cut there, rounding may tell so again.
        if lowest > 1e-8 * h:
            h = lowest
    back = not now.compressing and un[0] + _gain(un, h) < 0.0 and _at(rise, h) < 0.0
    if back:
        h = _root([0.0, *un[1:]], -un[0], h) if un[0] > 0.0 else 0.0
    in_velocity, in_impulse, in_work = left_to_go(now, law, e, target)
    if in_velocity < math.inf:
        series, goal = [0.0, *un[1:]], in_velocity / r
    elif in_impulse < math.inf:
        series, goal = _integral(speed), in_impulse * inertia / r
    else:
        series, goal = _integral(power), in_work * inertia / (r * r)
    reached = _at(series, h) >= goal
    if reached:
        h = _root(series, goal, h)
    s1, s2 = u1[0] + _gain(u1, h), u2[0] + _gain(u2, h)
    # Where slip turns past w, W_nn − µ w·s is least between the ends of the step.
    across = rates[3] * u2[0] - rates[4] * u1[0], rates[3] * s2 - rates[4] * s1
    falls = _falls(rates, mu, s1, s2) or (
        across[0] * across[1] < 0.0
        and rates[3] * s1 + rates[4] * s2 > 0.0
        and rates[5] <= mu * math.hypot(rates[3], rates[4])
    )
    unit = r / inertia
    p, work = unit * _at(_integral(speed), h), unit * r * _at(_integral(power), h)
    now.p1 -= mu * unit * _at(_integral(u1), h)
    now.p2 -= mu * unit * _at(_integral(u2), h)
    now.p += p
    now.normal += work
    now.friction -= mu * unit * r * _at(_integral(square), h)
    if now.compressing:
        now.pressed += p
        now.spent += work
    else:
        now.regained += work
    now.u1, now.u2 = r * s1, r * s2
    now.un += r * _gain(un, h)
    if back and not reached:
        now.un, now.compressing = 0.0, True
    return reached, falls


def _series(rates: Rates, now: Progress, mu: float, r: float) -> tuple[Series, ...]:
    """Taylor coefficients in τ of u_1, u_2, u_n, |u_t|, |u_t|² and |u_t| u_n, in units of r."""
    a11, a12, a22, w1, w2, wn = rates
    u1, u2, un = [now.u1 / r], [now.u2 / r], [now.un / r]
    m1, m2 = mu * w1, mu * w2
    speed, square, power = [1.0], [1.0], [un[0]]
    for k in range(ORDER):
        x, y, z, part = u1[k], u2[k], speed[k], 1.0 / (k + 1)
        u1.append(part * (w1 * z - a11 * x - a12 * y))
        u2.append(part * (w2 * z - a12 * x - a22 * y))
        un.append(part * (wn * z - m1 * x - m2 * y))
        own = sum(map(mul, u1, reversed(u1))) + sum(map(mul, u2, reversed(u2)))
        square.append(own)
        speed.append(0.5 * (own - sum(map(mul, speed[1:], reversed(speed[1:])))))
        power.append(sum(map(mul, speed, reversed(un))))
    return u1, u2, un, speed, square, power


def _length(*every: Series) -> float:
    """How far series reach."""
    h = LONGEST
    for k in (ORDER - 1, ORDER):
        size = max(abs(series[k]) for series in every)
        if size > 0.0:
            h = min(h, (CUT / size) ** (1.0 / k))
    return h


def _at(series: Series, x: float) -> float:
    total = 0.0
    for value in reversed(series):
        total = total * x + value
    return total


def _gain(series: Series, x: float) -> float:
    """By how much a series is more at x than at 0."""
    return x * _at(series[1:], x)


def _integral(series: Series) -> Series:
    return [0.0, *(value / (k + 1) for k, value in enumerate(series[:-1]))]


def _root(series: Series, goal: float, high: float) -> float:
    """Where between 0 and ``high`` a series is ``goal``: Newton, kept in by bisection."""
    low, x = 0.0, high
    rate = [k * value for k, value in enumerate(series)][1:]
    rising = _at(series, high) >= series[0]
    for _ in range(100):
        error = goal - _at(series, x)
        if error == 0.0:
            break
        if (error > 0.0) is rising:
            low = x
        else:
            high = x
        slope = _at(rate, x)
        following = x + error / slope if slope else 0.5 * (low + high)
        if not low <= following <= high:
            following = 0.5 * (low + high)
        if abs(following - x) <= 1e-16 * x:
            break
        x = following
    return x
