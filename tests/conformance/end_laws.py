"""Newton's and Poisson's laws with Coulomb's friction at the end of the impact.

ξ = W P + b. For each contact, with a floor P̲ that is 0 but in Poisson's expansion:

    0 ≤ P_n − P̲ ⊥ ξ_n ≥ 0,   |P_t| ≤ µ P_n,   P_t |ξ_t| = −µ P_n ξ_t.

``left_of_coulomb`` says how far impulses are from it, whoever found them. ``answers_of_one`` tries
all modes of one contact; ``compression`` finds the answer of several, one after the other.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

# Directions that are tried, none of them along an axis.
TURN = np.linspace(-np.pi, np.pi, 181) + 0.0123
MOST_SWEEPS = 4000


def left_of_coulomb(W, b, mu, P, floor=0.0):
    """The natural map of Alart and Curnier (1991), relative to the largest impulse it moves by.

    Args:
        W: (3n, 3n) [1/kg]. b, P: (3n,). mu, floor: (n,) or a number.
    """
    W_nn = W.diagonal()[2::3]
    size = max(np.abs(P).max(), np.max(floor), (np.abs(b[2::3]) / W_nn).max())
    return np.abs(_natural_map(W, b, mu, P, floor)).max() / size if size else 0.0


def _natural_map(W, b, mu, P, floor):
    xi, p = (W @ P + b).reshape(-1, 3), P.reshape(-1, 3)
    step = 1.0 / W.reshape(len(p), 3, len(p), 3)[range(len(p)), 2, range(len(p)), 2]
    normal = p[:, 2] - np.maximum(floor, p[:, 2] - step * xi[:, 2])
    aim = p[:, :2] - step[:, None] * xi[:, :2]
    bound, length = mu * np.maximum(p[:, 2], 0.0), np.hypot(*aim.T)
    kept = np.where(length > bound, bound / np.where(length > 0.0, length, 1.0), 1.0)
    return np.column_stack([p[:, :2] - kept[:, None] * aim, normal]).ravel()


def newton_shift(e, before):
    """(3n,) what Newton's law adds to u⁺: e·min(u_n⁻, 0) on normals."""
    shift = np.zeros_like(before)
    shift[2::3] = e * np.minimum(before[2::3], 0.0)
    return shift


def answers_of_one(W, b, mu, floor=0.0):
    """Every P (3,) of one contact that obeys the law: parting, sticking and slip of all ways."""
    found = []
    tt, w, nn = W[:2, :2], W[:2, 2], W[2, 2]

    def keep(P):
        if left_of_coulomb(W, b, mu, P, floor) < 1e-9:
            found.append(P)

    if floor == 0.0:
        keep(np.zeros(3))
    if mu == 0.0:
        keep(np.array([0.0, 0.0, max(floor, -b[2] / nn)]))
        return found
    keep(-np.linalg.lstsq(W, b, rcond=1e-13)[0])
    if floor > 0.0:
        keep(np.array([*-np.linalg.lstsq(tt, b[:2] + w * floor, rcond=1e-13)[0], floor]))

    for fixed in (False, True) if floor > 0.0 else (False,):

        def slides(angle, fixed=fixed):
            """s, P_n and ξ_t over it, both times what P_n is divided by, and that."""
            s = np.array([np.cos(angle), np.sin(angle)])
            below = 1.0 if fixed else nn - mu * (w @ s)
            p = floor if fixed else -b[2]
            return s, p, b[:2] * below + p * (w - mu * tt @ s), below

        def aside(angle, slides=slides):
            """What slip has across the direction that friction opposes."""
            s, _, xi, _ = slides(angle)
            return s[0] * xi[1] - s[1] * xi[0]

        values = np.array([aside(angle) for angle in TURN])
        for i in np.flatnonzero(values[1:] * values[:-1] <= 0.0):
            angle = brentq(aside, TURN[i], TURN[i + 1], xtol=1e-15, rtol=1e-15)
            s, p, _, below = slides(angle)
            if p * below > 0.0:
                keep(p / below * np.array([-mu * s[0], -mu * s[1], 1.0]))
    return found


def struck_once(W, before, free, e, mu, restitution):
    """(3,) P of one contact under "newton" or "poisson"; the only one there is.

    Args:
        before, free: (3,) u⁻ and what blows and constraints make of it.
    """
    if restitution == "newton":
        return _only(answers_of_one(W, free + newton_shift(e, before), mu))
    pressed = _only(answers_of_one(W, free, mu))
    if e * pressed[2] == 0.0:
        return pressed
    return pressed + _only(answers_of_one(W, free + W @ pressed, mu, e * pressed[2]))


def _only(found):
    distinct = [P for i, P in enumerate(found) if not any(np.allclose(P, Q) for Q in found[:i])]
    assert len(distinct) == 1, f"{len(distinct)} answers: this scene is none for this truth"
    return distinct[0]


def compression(W, b, mu, floor=0.0):
    """(3n,) P of several contacts: each in turn against the others, then Newton on the rest.

    ``mu``, ``floor``: (n,). Of redundant contacts one of the splits.
    """
    n = len(mu)
    floor = np.broadcast_to(np.asarray(floor, dtype=float), n)
    P = np.zeros(3 * n)
    for sweep in range(MOST_SWEEPS):
        last = P.copy()
        for i in range(n):
            k = slice(3 * i, 3 * i + 3)
            rest = b[k] + W[k] @ P - W[k, k] @ P[k]
            own = answers_of_one(W[k, k], rest, mu[i], floor[i])
            P[k] = own[np.argmin([np.abs(p - P[k]).max() for p in own])]
        if np.abs(P - last).max() <= 1e-15 * np.abs(P).max() or not P.any():
            break
        if sweep % 20 == 19:
            P = _polished(W, b, mu, floor, P)
        if left_of_coulomb(W, b, mu, P, floor) < 2e-15:
            break
    return P


def _polished(W, b, mu, floor, P):
    """Newton on the natural map with differences, where it comes nearer."""
    near, best = left_of_coulomb(W, b, mu, P, floor), P
    for _ in range(6):
        h = 1e-7 * max(np.abs(P).max(), 1e-300)
        ways = h * np.eye(len(P))
        slope = np.column_stack(
            [
                _natural_map(W, b, mu, P + d, floor) - _natural_map(W, b, mu, P - d, floor)
                for d in ways
            ]
        ) / (2.0 * h)
        P = P - np.linalg.lstsq(slope, _natural_map(W, b, mu, P, floor), rcond=1e-10)[0]
        left = left_of_coulomb(W, b, mu, P, floor)
        if left < near:
            near, best = left, P
    return best
