"""Slip followed along the normal impulse in 3-D, in any numbers.

With p the normal impulse so far and s = (cos θ, sin θ) the direction of slip, r its speed,
g = w − µ W_tt s (Keller 1986):

    dr/dp = R = s·g,   r dθ/dp = T = s⊥·g,   du_n/dp = N = W_nn − µ w·s.

Slip turns towards a root θ* of T. With θ as the variable all is quadrature, r first and the
rest from it: d(ln r)/dθ = R/T, dp/dθ = r/T, du_n = N dp, on panels that halve the way to θ* and
keep off the other roots of T, by Gauss and Legendre's points: 32 are good for some 25 digits.
(``turning`` goes by Taylor series in another variable: nothing is shared.) Slip that keeps its
direction, sticking and starting again are linear in p, as in ``planar``.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from impulsekit.reference import Arithmetic
from impulsekit.reference.arithmetic import Array
from impulsekit.tolerances import NONZERO

from .elimination import solved_pair
from .phases import MOST_EVENTS, Way

MOST_PANELS = 2000
# Of epsilon: the power of it below which a direction is θ*.
STRAIGHT = 0.6
# Angles of which a root in doubles may be one.
NEAR_CIRCLE = 1e-6
# Roots below this or above its inverse are zero or infinite: the polynomial has a lower degree.
FAR = 1e-100


def followed(numbers: Arithmetic, W: Array, u: Array, e: Any, mu: Any, law: str) -> Array | None:
    """(3,) the impulse of one contact; None if the impact never ends.

    Args:
        numbers: what all is made of.
        W: (3, 3) Delassus matrix, rows t₁, t₂, n.
        u: (3,) the velocity before; u_n < 0.
        e, mu: restitution and friction.
        law: "newton", "poisson" or "stronge".
    """
    tt, w = W[:2, :2], W[:2, 2]
    now = Way.begin(numbers, u[:2].copy(), u[2], e, law)
    over: bool | None
    for _ in range(MOST_EVENTS):
        s, slips = now.ut * 0, False
        if not mu:
            k = s
        elif (now.ut != 0).any():
            s, slips = now.ut / numbers.norm(now.ut), True
            k = -mu * s
        else:
            k = -solved_pair(tt, w)
            if not numbers.norm(k) <= mu:
                s, slips = _outgoing(numbers, tt, w, mu), True
                k = -mu * s
        g = w + tt @ k
        aside = abs(s[0] * g[1] - s[1] * g[0])
        if slips and aside > 100 * _straight_below(numbers) * (abs(w) + mu * abs(tt).sum()).max():
            if not _turned(numbers, W, mu, now):
                return None
            over = _phase_is_over(now)
        else:
            rates = g if slips or not mu else g * 0
            over = now.go_straight(rates, W[2, 2] + w @ k, k, slips)
            if over is None:
                return None
        if over and now.ends():
            return np.array([now.pt[0], now.pt[1], now.pn], dtype=u.dtype)
    return None


def _phase_is_over(now: Way) -> bool:
    left = now.goal(now.un, now.pn * 0, now.pn * 0)
    size = abs(now.target) + abs(now.un) + abs(now.pn) + abs(now.spent)
    return bool(left <= now.numbers.epsilon * 10000 * size) and bool((now.ut != 0).any())


class _Rates:
    """T, R and N at θ* + φ, with all digits however small φ."""

    def __init__(self, numbers: Arithmetic, W: Array, mu: Any, root: Any) -> None:
        self.numbers, self._mu = numbers, mu
        self._tt, self._w, self._nn = W[:2, :2], W[:2, 2], W[2, 2]
        c, s = numbers.cos(root), numbers.sin(root)
        self._cs = np.array([c, s])
        w, tt = self._w, self._tt
        self._first = (w[1] * c - w[0] * s, -(w[0] * c + w[1] * s))
        skew = (tt[1, 1] - tt[0, 0]) / 2
        c2, s2 = c * c - s * s, 2 * s * c
        self._second = (
            -mu * (tt[0, 1] * c2 + skew * s2),
            -mu * (-tt[0, 1] * s2 + skew * c2),
        )

    def at(self, phi: Array) -> tuple[Array, Array, Array, Array]:
        """T, R, N (n,) and s (2, n) at some φ (n,)."""
        cos, sin = self.numbers.cos, self.numbers.sin
        half_s = np.array([sin(x / 2) for x in phi])
        half_c = np.array([cos(x / 2) for x in phi])
        s1, c1_less = 2 * half_s * half_c, -2 * half_s * half_s
        c1 = 1 + c1_less
        s2, c2_less = 2 * s1 * c1, -2 * s1 * s1
        (a, b), (a2, b2) = self._first, self._second
        # T(θ*) = 0 is left out of the sum.
        T = a * c1_less + b * s1 + a2 * c2_less + b2 * s2
        c0, s0 = self._cs
        s = np.array([c0 * c1 - s0 * s1, s0 * c1 + c0 * s1])
        pressed = self._w @ s
        R = pressed - self._mu * (s * (self._tt @ s)).sum(axis=0)
        return T, R, self._nn - self._mu * pressed, s


def _turned(numbers: Arithmetic, W: Array, mu: Any, now: Way) -> bool:
    """Follow slip that turns until the phase or the slip ends, or the contact falls back in."""
    theta = numbers.atan2(now.ut[1], now.ut[0])
    ahead = _root_ahead(numbers, W, mu, theta)
    if ahead is None:
        return False
    root, others = ahead
    rates = _Rates(numbers, W, mu, root)
    phi, r = theta - root, numbers.norm(now.ut)
    faint = r * numbers.epsilon / 1000
    for _ in range(MOST_PANELS):
        distance = min((abs(complex(float(phi)) - other) for other in others), default=np.inf)
        share = min(0.5, 0.5 * distance / max(abs(float(phi)), NONZERO))
        far = -phi * numbers.number(share)
        panel = _panel(rates, phi, far, r, now, mu)
        ends = _events(now, panel)
        if ends is not None:
            low, high = ends[0] * far, ends[1] * far
            way = _located(rates, phi, low, high, r, now, mu)
            panel = _panel(rates, phi, way, r, now, mu)
        _, _, ut, un, pt, p, work = panel
        back = not now.compressing and un[-1] <= 0 and ends is not None
        now.advance(ut[:, -1], un[-1], pt[:, -1], p[-1], work[-1])
        if ends is not None:
            if back and not _phase_is_over(now):
                now.fall_back()
            return True
        phi, r = phi + far, panel[1][-1]
        if not r > faint:
            now.ut = now.ut * 0
            return True
        if abs(phi) < _straight_below(numbers):
            return True
    return False


def _straight_below(numbers: Arithmetic) -> float:
    return float(numbers.epsilon) ** STRAIGHT


def _panel(
    rates: _Rates, phi: Any, far: Any, r: Any, now: Way, mu: Any
) -> tuple[Array, Array, Array, Array, Array, Array, Array]:
    """Places, r, u_t, u_n, P_t, p and work at the points of a panel and at its end."""
    numbers = rates.numbers
    points, summed, base = _rule(numbers)
    places = phi + far * points
    T, R, N, s = rates.at(places)
    speed = r * base ** (far * (summed @ (R[:-1] / T[:-1])))
    flow = far * speed / T
    p = summed @ flow[:-1]
    un = now.un + summed @ (N * flow)[:-1]
    pt = -mu * ((s * flow)[:, :-1] @ summed.T)
    work = summed @ (un * flow)[:-1]
    return points, speed, s * speed, un, pt, p, work


def _events(now: Way, panel: Any) -> tuple[Any, Any] | None:
    """Between which points (shares of the panel) the phase ends or the contact falls back in."""
    points, _, _, un, _, p, work = panel
    before = points[0] * 0
    for i, place in enumerate(points):
        left = now.goal(un[i], p[i], work[i])
        if left <= 0 or (not now.compressing and un[i] < 0):
            return before, place
        before = place
    return None


def _located(rates: _Rates, phi: Any, low: Any, high: Any, r: Any, now: Way, mu: Any) -> Any:
    """The way from φ at which the phase ends, between two ways, by secants kept in between."""

    def left(way: Any) -> tuple[Any, Any]:
        """What is left of the phase after a way, and how fast that changes with it."""
        panel = _panel(rates, phi, way, r, now, mu)
        un, p, work = panel[3][-1], panel[5][-1], panel[6][-1]
        goal = now.goal(un, p, work)
        T, _, N, _ = rates.at(np.array([phi + way]))
        dp = panel[1][-1] / T[0]
        rising = now.compressing or now.law == "newton"
        slope = -dp * (N[0] if rising else 1 if now.law == "poisson" else un)
        if not now.compressing and un < goal:
            return un, dp * N[0]
        return goal, slope

    way = (low + high) / 2
    for _ in range(200):
        value, slope = left(way)
        if value > 0:
            low = way
        else:
            high = way
        # Newton, kept in between; at the end itself no step leaves it.
        following = way - value / slope if slope else low
        if slope and not abs(value / slope) > rates.numbers.epsilon * 8 * abs(way):
            return following
        if not min(low, high) < following < max(low, high):
            following = (low + high) / 2
        if not abs(following - way) > rates.numbers.epsilon * 8 * abs(way):
            return following
        way = following
    return way


def _root_ahead(
    numbers: Arithmetic, W: Array, mu: Any, theta: Any
) -> tuple[Any, list[complex]] | None:
    """θ* that slip turns towards, and the other roots of T, less θ*, in doubles."""
    (t11, t12), (_, t22) = W[:2, :2].astype(float)
    w1, w2 = W[:2, 2].astype(float)
    m = float(mu)
    second = complex(-m * t12 / 2, m * (t22 - t11) / 4)
    first = complex(w2, w1) / 2
    z = np.roots([second, first, 0.0, first.conjugate(), second.conjugate()])
    z = z[(np.abs(z) > FAR) & (np.abs(z) < 1.0 / FAR)]
    places = np.angle(z) - 1j * np.log(np.abs(z))

    def turning(angle: Any) -> tuple[Any, Any]:
        """T and dT/dθ."""
        c, s = numbers.cos(angle), numbers.sin(angle)
        skew = W[1, 1] - W[0, 0]
        first = W[1, 2] * c - W[0, 2] * s
        slope = -W[1, 2] * s - W[0, 2] * c
        second = W[0, 1] * (c * c - s * s) + skew * s * c
        turn = -4 * W[0, 1] * s * c + skew * (c * c - s * s)
        return first - mu * second, slope - mu * turn

    def refined(root: Any) -> Any:
        for _ in range(8):
            value, slope = turning(root)
            root = root - value / slope
        return root

    heading = 1 if turning(theta)[0] > 0 else -1
    circle = 2.0 * np.pi

    def ahead_by(place: complex) -> float:
        """How far θ has to turn to a root."""
        away = (heading * (place.real - float(theta))) % circle
        if min(away, circle - away) > NEAR_CIRCLE:
            return away
        # So near that doubles may not tell whether it is ahead or behind.
        around = away if away < 1.0 else away - circle
        around = float(heading * (refined(theta + numbers.number(heading * around)) - theta))
        return around if around >= 0.0 else circle + around

    real = [x for x in places if abs(x.imag) < NEAR_CIRCLE]
    if not real:
        return None
    ahead = min(real, key=ahead_by)
    root = refined(theta + numbers.number(heading * ahead_by(ahead)))
    others = []
    for place in places:
        if place is not ahead:
            turns = np.round((place.real - ahead.real) / circle)
            own = complex(place.real - ahead.real - circle * turns, place.imag)
            others += [own, own + circle, own - circle]
    return root, others


def _outgoing(numbers: Arithmetic, tt: Array, w: Array, mu: Any) -> Array:
    """s with w − µ W_tt s = λ s, λ > 0: the direction in which slip starts again."""
    size = numbers.norm(w)
    low, high = size * 0, size
    identity = numbers.eye(2)

    def direction(rate: Any) -> Array:
        return solved_pair(mu * tt + rate * identity, w)

    # |s| falls with λ from above 1.
    for _ in range(int(-3.4 * np.log10(float(numbers.epsilon))) + 4):
        middle = (low + high) / 2
        if numbers.norm(direction(middle)) > 1:
            low = middle
        else:
            high = middle
    s = direction(high)
    return s / numbers.norm(s)


@cache
def _rule(numbers: Arithmetic) -> tuple[Array, Array, Any]:
    """Points on [0, 1] and its end (k + 1,), what sums values at the k points up to each, and e.

    Legendre's polynomials carry what is between the points.
    """
    count = 16 if numbers.dtype == np.float64 else 32
    starts, _ = np.polynomial.legendre.leggauss(count)

    def legendre(x: Any) -> list[Any]:
        values = [x * 0 + 1, x]
        for k in range(1, count + 1):
            values.append(((2 * k + 1) * x * values[k] - k * values[k - 1]) / (k + 1))
        return values

    nodes, weights = [], []
    for start in starts:
        x = numbers.number(float(start))
        for _ in range(6):
            values = legendre(x)
            slope = count * (x * values[count] - values[count - 1]) / (x * x - 1)
            x = x - values[count] / slope
        values = legendre(x)
        slope = count * (x * values[count] - values[count - 1]) / (x * x - 1)
        nodes.append(x)
        weights.append(2 / ((1 - x * x) * slope * slope))
    at_nodes = [legendre(x) for x in nodes]
    ends = [*nodes, numbers.number(1)]
    summed = numbers.zeros(count + 1, count)
    for i, end in enumerate(ends):
        values = legendre(end)
        integrals = [end + 1] + [
            (values[k + 1] - values[k - 1]) / (2 * k + 1) for k in range(1, count)
        ]
        for j in range(count):
            total = sum((2 * k + 1) * at_nodes[j][k] * integrals[k] for k in range(count))
            # On [0, 1], of half the length.
            summed[i, j] = weights[j] * total / 4
    points = (numbers.array(np.array(ends, dtype=numbers.dtype)) + 1) / 2
    base, term = numbers.number(1), numbers.number(1)
    for k in range(1, 60):
        term = term / k
        base = base + term
    return points, summed, base
