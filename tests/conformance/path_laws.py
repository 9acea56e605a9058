"""One contact along its impact: Coulomb's law at every instant (Routh 1860; Keller 1986).

du/dP_n = W (−µ s, 1) while it slips along s. With dτ = dP_n/|u_t| as the variable nothing is
singular where slip ends: (ln |u_t|)' = s·g, θ' = s⊥·g, P_n' = |u_t|, with g = W_tn − µ W_tt s.
Slip that has ended stays so where µ can hold it, else it starts along s with g = λ s, λ > 0.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

# Slip is followed down to this share of the largest velocity; less than the second is none.
ENDED, NO_SLIP = 1e-14, 1e-11
TOLERANCE = {"method": "DOP853", "rtol": 2e-13, "atol": 1e-15}


def struck_along_path(W, u, e, mu, restitution):
    """(3,) P of one contact with u_n < 0, under "newton", "poisson" or "stronge"."""
    start, P, compressed, work = np.array(u, dtype=float), np.zeros(3), None, 0.0
    tt, w = W[:2, :2], W[:2, 2]
    speed = np.abs(start).max()
    for _ in range(40):
        now = start + W @ P
        if compressed is None:
            goal, value = "velocity", 0.0
        elif restitution == "newton":
            goal, value = "velocity", -e * start[2]
        elif restitution == "poisson":
            goal, value = "impulse", (1.0 + e) * compressed[0]
        else:
            goal, value = "work", (1.0 - e * e) * compressed[1]
        if mu > 0.0 and np.hypot(*now[:2]) > NO_SLIP * speed:
            P, work, over = _slips(W, start, P, mu, work, goal, value, ENDED * speed)
        else:
            P, work = _straight(W, now, P, _pull(tt, w, mu), work, goal, value)
            over = True
        if over and compressed is not None:
            return P
        if over:
            compressed = (P[2], work)
            if e == 0.0:
                return P
    raise AssertionError("the impact does not end")


def _pull(tt, w, mu):
    """(2,) dP_t/dP_n of a contact that does not slip yet."""
    if mu == 0.0:
        return np.zeros(2)
    hold = -np.linalg.solve(tt, w)
    if np.hypot(*hold) <= mu:
        return hold

    def too_long(rate):
        return np.hypot(*np.linalg.solve(mu * tt + rate * np.eye(2), w)) - 1.0

    rate = brentq(too_long, 0.0, np.hypot(*w), xtol=1e-16, rtol=1e-15)
    return -mu * np.linalg.solve(mu * tt + rate * np.eye(2), w)


def _straight(W, now, P, pull, work, goal, value):
    """To the end of a phase with a constant dP_t/dP_n."""
    way = np.array([*pull, 1.0])
    rise = W[2] @ way
    if goal == "velocity":
        more = (value - now[2]) / rise
    elif goal == "impulse":
        more = value - P[2]
    else:
        left = max(value - work, 0.0)
        more = (np.sqrt(now[2] ** 2 + 2.0 * rise * left) - now[2]) / rise
    return P + more * way, work + more * (now[2] + 0.5 * rise * more)


def _slips(W, start, P, mu, work, goal, value, ended):
    """Until the phase or the slip ends; P, the work of the normal, and whether it is the phase."""
    tt, w = W[:2, :2], W[:2, 2]
    now = start + W @ P

    def rates(_, y):
        s = np.array([np.cos(y[0]), np.sin(y[0])])
        g, r = w - mu * tt @ s, np.exp(y[1])
        un = start[2] + W[2] @ y[2:5]
        return [
            s[0] * g[1] - s[1] * g[0], s @ g, -mu * s[0] * r, -mu * s[1] * r, r, un * r,
        ]  # fmt: skip

    def phase(_, y):
        if goal == "velocity":
            return start[2] + W[2] @ y[2:5] - value
        return (y[4] if goal == "impulse" else y[5]) - value

    def stops(_, y):
        return y[1] - np.log(ended)

    phase.terminal = stops.terminal = True
    phase.direction, stops.direction = 1.0, -1.0
    first = [np.arctan2(now[1], now[0]), np.log(np.hypot(*now[:2])), *P, work]
    way = solve_ivp(rates, [0.0, 1e6], first, events=[phase, stops], **TOLERANCE)
    assert way.status == 1, "neither phase nor slip ends"
    y = way.y[:, -1]
    return y[2:5], y[5], not len(way.t_events[1])
