"""What each law of contact asks of an impact, all of them: ``wrong`` is what an answer leaves."""

from __future__ import annotations

import numpy as np

import impulsekit as ik

from .end_laws import compression, left_of_coulomb, newton_shift, struck_once
from .mechanics import Mechanics
from .path_laws import struck_along_path
from .waves import waves

# An approach of this share of the first is none.
OVER = 1e-14


def left_of_law(law: ik.Law, m: Mechanics, coefficients, P) -> float:
    """How far P (3n,) is from the law, relative to the largest impulse.

    Args:
        coefficients: e, mu and stiffness, each (n,).
    """
    e, mu, _ = coefficients
    if (law.slip, law.order) == ("end", "simultaneous"):
        free = m.J @ m.v_free
        if law.restitution == "newton":
            return left_of_coulomb(m.W, free + newton_shift(e, m.J @ m.v), mu, P)
        pressed = compression(m.W, free, mu)
        floor = e * pressed[2::3]
        if not floor.any():
            return left_of_coulomb(m.W, free, mu, P)
        return left_of_coulomb(m.W, free + m.W @ pressed, mu, P - pressed, floor)
    truth = true_impulse(law, m, coefficients)
    return float(np.abs(P - truth).max() / np.abs(truth).max())


def true_impulse(law: ik.Law, m: Mechanics, coefficients) -> np.ndarray:
    """(3n,) impulses that obey the law; of redundant contacts one of the splits."""
    e, mu, stiffness = coefficients
    free, before = m.J @ m.v_free, m.J @ m.v
    if law.restitution == "lzb":
        return waves(m.W, free, e, mu, stiffness, law.exponent)

    def hit(i, u, was):
        k = slice(3 * i, 3 * i + 3)
        if law.slip == "path":
            return struck_along_path(m.W[k, k], u, e[i], mu[i], law.restitution)
        return struck_once(m.W[k, k], was, u, e[i], mu[i], law.restitution)

    if law.order == "sequential":
        return in_sequence(m.W, free, hit)
    if law.slip == "path" and np.any(mu):
        n = len(e)
        triples = [slice(3 * i, 3 * i + 3) for i in range(n)]
        return np.concatenate([hit(i, free[k], before[k]) for i, k in enumerate(triples)])
    if law.restitution == "newton":
        return compression(m.W, free + newton_shift(e, before), mu)
    pressed = compression(m.W, free, mu)
    floor = e * pressed[2::3]
    return pressed + compression(m.W, free + m.W @ pressed, mu, floor)


def in_sequence(W, free, hit):
    """(3n,) P of contacts hit one after the other, the fastest approach first.

    ``hit``: function of a contact and its velocity, twice.
    """
    P, n = np.zeros(len(free)), len(free) // 3
    pace = np.sqrt(W.diagonal()[2::3])
    first = max(-(free[2::3] / pace).min(), 0.0)
    for _ in range(20_000):
        u = free + W @ P
        speeds = -u[2::3] / pace
        i = int(speeds.argmax())
        if not speeds[i] > OVER * first:
            return P
        k = slice(3 * i, 3 * i + 3)
        P[k] += hit(i, u[k], u[k])
    raise AssertionError(f"{n} contacts hit each other without end")
