"""Slip that turns while the impact goes on, in 3-D.

With u_t = r (cos θ, sin θ), the rates r' and r θ' in p depend on θ alone. In τ with
dp = r dτ the equations are smooth down to r = 0, which lies at τ → ∞:

    dθ/dτ = T(θ),   d ln r/dτ = R(θ),   dp/dτ = r,   du_n/dτ = r N(θ)

with T = s⊥·g, R = s·g, N = W_nn − µ w·s, g = w − µ W_tt s.
"""

from __future__ import annotations

import math

import numpy as np

from .path import Progress, left_to_go
from .slide import Block

__all__ = ["turn"]

# Slip this slow against where the stretch began has ended.
FAINT = 1e-14
RTOL = 1e-13
MOST_STEPS = 20_000


def turn(
    block: Block, now: Progress, mu: float, law: str, e: float, target: float, scale: float
) -> tuple[bool, bool]:
    """Follow the slip to the end of the phase or of the slip.

    Returns:
        Whether the impact is over, and whether the contact was pressed further in
        meanwhile (N ≤ 0).
    """
    from scipy.integrate import DOP853

    t11, t12, t22, n1, n2, nn = block
    first = math.hypot(now.u1, now.u2)
    # Impulses in units of ``first``/``inertia``; velocities of ``first``; τ of 1/inertia.
    inertia = abs(n1) + abs(n2) + mu * (t11 + t22) + nn
    a11, a12, a22 = mu * t11 / inertia, mu * t12 / inertia, mu * t22 / inertia
    w1, w2, wn = n1 / inertia, n2 / inertia, nn / inertia

    def rates(_: float, y: np.ndarray) -> tuple[float, ...]:
        theta, log, _, un = y[:4].tolist()
        s1, s2, r = math.cos(theta), math.sin(theta), math.exp(log)
        g1, g2 = w1 - a11 * s1 - a12 * s2, w2 - a12 * s1 - a22 * s2
        return (
            s1 * g2 - s2 * g1,
            s1 * g1 + s2 * g2,
            r,
            r * (wn - mu * (w1 * s1 + w2 * s2)),
            -mu * r * s1,
            -mu * r * s2,
            r * un,
            -mu * r * r,
        )

    in_velocity, in_impulse, in_work = left_to_go(now, law, e, target)
    lift = now.un / first
    if in_velocity < math.inf:
        index, goal = 3, lift + in_velocity / first
    elif in_impulse < math.inf:
        index, goal = 2, in_impulse * inertia / first
    else:
        index, goal = 6, in_work * inertia / (first * first)
    start = np.array([math.atan2(now.u2, now.u1), 0.0, 0.0, lift, 0.0, 0.0, 0.0, 0.0])
    # A slow approach beside a fast slip: its velocity, impulse and work are small numbers
    # here, and count by their own size (down to where rounding would stop the steps).
    small = min(1.0, max(1e-2, abs(lift), abs(goal) ** (0.5 if index == 6 else 1.0)))
    sizes = (1.0, 1.0, small, small, small, small, small * small, small)
    absolute = 1e-15 * np.array(sizes)
    # τ runs on for as long as the slowest decay takes.
    solver = DOP853(rates, 0.0, start, 1e12, rtol=RTOL, atol=absolute)
    floor = math.log(FAINT)
    falls = rates(0.0, start)[3] <= 0.0
    reached = back = False
    y = start
    for _ in range(MOST_STEPS):
        last, t_last = y, solver.t
        if solver.status != "running":
            break
        solver.step()
        y = solver.y
        falls = falls or rates(0.0, y)[3] <= 0.0
        reached = y[index] >= goal
        back = not now.compressing and y[3] < 0.0 and rates(0.0, y)[3] < 0.0
        if reached or back:
            which, value = (index, goal) if reached else (3, 0.0)
            y = _located(rates, t_last, solver.t, last, which, value, absolute)
            break
        if y[1] < floor:
            break
    stopped = not (reached or back)
    theta, log, p, un, p1, p2, normal, friction = y.tolist()
    unit = first / inertia
    if stopped:
        r = 0.0
    else:
        r = math.exp(log) * first
    now.u1, now.u2, now.un = r * math.cos(theta), r * math.sin(theta), un * first
    now.p1, now.p2, now.p = now.p1 + p1 * unit, now.p2 + p2 * unit, now.p + p * unit
    now.normal += normal * unit * first
    now.friction += friction * unit * first
    if now.compressing:
        now.pressed += p * unit
        now.spent += normal * unit * first
    else:
        now.regained += normal * unit * first
    if back and not reached:
        now.un, now.compressing = 0.0, True
    if not reached:
        return False, falls
    if not now.compressing:
        return True, falls
    now.compressing, now.un = False, 0.0
    return e == 0.0 or (law == "newton" and target <= 1e-15 * scale), falls


def _located(
    rates: object,
    t0: float,
    t1: float,
    y0: np.ndarray,
    index: int,
    goal: float,
    absolute: np.ndarray,
) -> np.ndarray:
    """The state where entry ``index`` reaches ``goal``, between t0 and t1.

    Integrated anew up to there, as dense output is less exact than the steps.
    """
    from scipy.integrate import solve_ivp

    low, high = t0, t1
    t, y = t0, y0
    # Newton within the bracket; the rate of the entry is known.
    for _ in range(60):
        rate = rates(t, y)[index]  # type: ignore[operator]
        error = goal - y[index]
        if abs(error) <= max(4e-16 * abs(goal), 0.4 * absolute[index]):
            break
        rising = goal >= y0[index]
        if (error > 0.0) is rising:
            low = t
        else:
            high = t
        following = t + error / rate if rate else 0.5 * (low + high)
        if not low <= following <= high:
            following = 0.5 * (low + high)
        if following == t:
            break
        y = (
            solve_ivp(rates, (t0, following), y0, method="DOP853", rtol=RTOL, atol=absolute).y[
                :, -1
            ]
            if following > t0
            else y0
        )
        t = following
        if high - low <= 1e-15 * max(abs(high), 1e-300):
            break
    return y
