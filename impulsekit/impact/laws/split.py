"""Redundant impulses: the split that knows no axes.

The P that make given velocities, each within its cone, are a convex set, and Σ w |P|² is least at
one of them alone, w being the mobility of each contact: neither axes, units nor the order of
contacts matter. Under Poisson's law e times the load of the compression comes back, so that v⁺
depends on how redundant contacts shared it. And what redundant contacts can hold still is known
only from all their shares, not from one of them.

With p = √w P and U the range of W so weighted, the least |p|² with Uᵀp = d is
p = proj(U m), proj going to the nearest p allowed; m is where a smooth convex function,
½|U m|² − ½|U m − proj(U m)|² − d·m, is least (its dual). Newton finds it to rounding.
"""

from __future__ import annotations

import math

import numpy as np

from .modes import Modes

__all__ = ["least_holding", "least_split"]

# Velocities below this share of all are none.
STILL = 1e-11
# A contact that moves this share of what the lightest does counts as moving that much.
LIGHTEST = 1e-12
# Eigenvalues of W, each contact weighted, below this share of the largest are rounding.
NO_RANGE = 1e-13
# Newton's steps at most, and halvings of one; what Uᵀp may be off by, relative.
MOST_STEPS, MOST_HALVINGS = 60, 30
SHARED = 1e-15
# By how much the least split may leave more of the law than the split that was found: at an edge
# of cones Newton ends some 1e-13 off, and another split would be another answer by far more.
FITS = 1e-12
# How far the dual may rise by rounding, relative to |p|²; the most that its slope is stiffened.
RISEN, STIFFENED = 1e-13, 1e-3


def least_split(modes: Modes, impulse: np.ndarray) -> np.ndarray:
    """P of least Σ w |P|² that makes the same velocities; P itself where none is found.

    Args:
        modes: the problem.
        impulse: (3n,) P, a solution [N s].
    """
    roots = _roots(modes)
    _, span = _range(modes, roots)
    velocity = modes.delassus @ impulse + modes.shifted
    least = _least(span, _Allowed(modes, velocity, roots), span.T @ (roots * impulse)) / roots
    fits = modes.residual(least) <= modes.residual(impulse) + FITS
    return least if fits else impulse


def least_holding(modes: Modes) -> np.ndarray:
    """P of least Σ w |P|² within the cones that holds all contacts still, or as near as found.

    Args:
        modes: the problem.
    """
    roots = _roots(modes)
    values, span = _range(modes, roots)
    wanted = -(span.T @ (modes.shifted / roots)) / values
    return _least(span, _Allowed(modes, np.zeros_like(roots), roots), wanted) / roots


def _roots(modes: Modes) -> np.ndarray:
    """(3n,) √w."""
    mobility = modes.delassus.diagonal().reshape(-1, 3).sum(axis=1)
    # Where nothing moves at all, any will do.
    least = LIGHTEST * mobility.max() or 1.0
    return np.repeat(np.sqrt(np.maximum(mobility, least)), 3)


def _range(modes: Modes, roots: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues and vectors (3n, r) of W so weighted, but those of rounding."""
    values, vectors = np.linalg.eigh(modes.delassus / roots / roots[:, None])
    kept = values > NO_RANGE * values[-1]
    return values[kept], vectors[:, kept]


def _least(span: np.ndarray, allowed: _Allowed, wanted: np.ndarray) -> np.ndarray:
    """The least of the allowed p with Uᵀp as wanted; the last one tried where it is not found."""
    place, step = wanted, np.zeros_like(wanted)
    best, least, last, height = span @ wanted, math.inf, math.inf, math.inf
    for _ in range(MOST_STEPS):
        for _ in range(MOST_HALVINGS):
            pull = span @ place
            near, slope = allowed.nearest(pull)
            off = span.T @ near - wanted
            error = float(np.abs(off).max(initial=0.0))
            now = float(near @ (pull - 0.5 * near) - wanted @ place)
            size = float(np.abs(near).max(initial=0.0))
            # Where the dual differs by its rounding, its slope tells.
            if now < height or (now <= height + RISEN * size * size and error < last):
                break
            step *= 0.5
            place = place - step
        height, last = now, error
        if error < least:
            best, least = near, error
        if not SHARED * size < error < math.inf:
            break
        matrix = span.T @ slope @ span
        matrix.reshape(-1)[:: len(place) + 1] += min(error / size, STIFFENED) if size else STIFFENED
        step = -np.linalg.solve(matrix, off)
        place = place + step
    return best


class _Allowed:
    """The weighted impulses that go with given velocities, contact by contact."""

    def __init__(self, modes: Modes, velocity: np.ndarray, roots: np.ndarray) -> None:
        still = STILL * modes.scale
        floor = np.zeros_like(modes.friction) if modes.floor is None else modes.floor
        # Of each contact µ, √w f, whether it touches, and its direction of P where it slips.
        self._contacts: list[tuple[float, float, bool, np.ndarray | None]] = []
        for i, (mu, least) in enumerate(zip(modes.friction, floor, strict=True)):
            slip, away = velocity[3 * i : 3 * i + 2], velocity[3 * i + 2]
            speed = math.hypot(*slip)
            ray = np.array([*(-mu / speed * slip), 1.0]) if mu and speed > still else None
            self._contacts.append((mu, roots[3 * i] * least, away <= still, ray))

    def nearest(self, pull: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The allowed impulse nearest to one, (3n,), and how it moves with it, (3n, 3n)."""
        near, slope = np.zeros_like(pull), np.zeros((len(pull), len(pull)))
        for i, contact in enumerate(self._contacts):
            own = slice(3 * i, 3 * i + 3)
            near[own], slope[own, own] = _nearest(pull[own], *contact)
        return near, slope


def _nearest(
    pull: np.ndarray, mu: float, floor: float, touches: bool, ray: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Of one contact: on its ray where it slips, else within its cone; no less than its floor."""
    slope = np.zeros((3, 3))
    if ray is not None:
        normal = pull @ ray / (ray @ ray)
        if touches and normal > floor:
            slope = np.outer(ray, ray) / (ray @ ray)
        else:
            normal = floor
        return normal * ray, slope
    size = math.hypot(pull[0], pull[1])
    along = np.array([pull[0] / size, pull[1] / size, 0.0]) if size else np.zeros(3)
    normal = pull[2] if size <= mu * pull[2] else (pull[2] + mu * size) / (1.0 + mu * mu)
    if touches and normal > floor:
        if size <= mu * pull[2]:
            return pull.copy(), np.eye(3)
        edge = mu * along + [0.0, 0.0, 1.0]
        slope = np.outer(edge, edge) / (1.0 + mu * mu)
    else:
        normal = floor
        if size <= mu * normal:
            return np.array([pull[0], pull[1], normal]), np.diag([1.0, 1.0, 0.0])
    if size:
        across = np.array([-along[1], along[0], 0.0])
        slope += mu * normal / size * np.outer(across, across)
    return normal * (mu * along + [0.0, 0.0, 1.0]), slope
