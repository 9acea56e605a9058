"""Contacts with cones for friction, rolling and spin: 0 ≤ p_n ⊥ ξ_n ≥ 0 and balls of c p_n.

Of each contact the normal impulse p_n may be accompanied by groups of one or two rows: the
tangents (c = µ), the rolling axes (c in metres), the normal axis for spin. With ξ = W p + b

    0 ≤ p_n − floor ⊥ ξ_n ≥ 0,   |p_g| ≤ c p_n,   p_g = −c p_n ξ_g/|ξ_g| where ξ_g ≠ 0,

which is Coulomb's law, group by group, with maximal dissipation (Acary & Bourrier 2021 for
rolling friction; Tasora & Anitescu 2013). Velocities of impacts or accelerations of rest.

Rows are brought to one unit, p ← p √D and ξ ← ξ/√D with D the mobility of their group, √J all.
Newton on the natural map of all groups (Alart & Curnier 1991), with a line search; where that
does not get on, impulses are relaxed group by group, and Newton goes on from there. Where rows
depend on each other every row gives way by ε, which is taken out again by the proximal point
method (Rockafellar 1976): of many p it ends near the shortest.

W may be without symmetry: where a group slides in a known direction, its impulse goes with p_n.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..tolerances import NONZERO
from .borrowed import borrowing
from .compiled import compiled, entry
from .dense import cholesky, gauss

__all__ = ["IMMOBILE", "SMALL", "Cones", "find_cone_impulses"]

# A Newton step is accepted where the sum of squares falls by this share of it (Armijo).
FALLS = 1e-4
# Newton stops at the first residual, relative; after so many steps the second is a solution too.
CONES_SOLVED, SMALL = 2e-16, 1e-12
# Newton's steps from one start, at most; then impulses are relaxed.
MOST_STEPS = 40
# Rounds of relaxing and Newton; how often a round goes over all groups.
MOST_ROUNDS, SWEEPS = 12, 60
# The shortest part of a Newton step that is tried, in halvings.
HALVINGS = 12
# Squares of pivots below this share: rows depend on each other, or all but.
DEPENDENT_SQUARED = 1e-9
# By how much each row then gives way, and rounds that take this out again.
CONE_GIVE, MOST_SHIFTS = 1e-7, 12
# Mobilities below this share of the largest of all rows of a kind are none.
IMMOBILE = 1e-22


class Cones(NamedTuple):
    """The contacts: where their rows are and how far their groups reach.

    Attributes:
        normals: (n,) the row of each normal.
        floor: (n,) the least p_n, 0 or what Poisson's law gives back.
        first, size: (g,) the first row of each group, and whether it has one or two.
        contact: (g,) the contact that each belongs to.
        reach: (g,) c: µ, or metres for angular rows.
    """

    normals: np.ndarray
    floor: np.ndarray
    first: np.ndarray
    size: np.ndarray
    contact: np.ndarray
    reach: np.ndarray


def _examples() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, Cones]:
    whole = np.zeros(1, np.int64)
    cones = Cones(whole, np.zeros(1), whole, whole, whole, np.zeros(1))
    return np.eye(3), np.ones(3), np.zeros(3), np.zeros(3), cones


@entry(_examples, seconds=5.0)
def find_cone_impulses(
    coupled: np.ndarray, mobility: np.ndarray, free: np.ndarray, start: np.ndarray, cones: Cones
) -> tuple[np.ndarray, float, int]:
    """(m,) p, what it leaves of the law relative to ``free``, and the steps of Newton.

    Args:
        coupled: (m, m) W.
        mobility: (m,) the diagonal of J M⁻¹ Jᵀ, which W has but for what slides.
        free: (m,) b.
        start: (m,) p to start from.
        cones: the groups.
    """
    m, n = len(free), len(cones.normals)
    unit, moves = _units(mobility, cones)
    W, b, x = np.empty((m, m)), np.empty(m), np.empty(m)
    scale = 0.0
    for i in range(m):
        b[i] = free[i] * unit[i] if moves[i] else 0.0
        x[i] = start[i] / unit[i] if moves[i] else 0.0
        scale = max(scale, abs(b[i]))
        for j in range(m):
            W[i, j] = coupled[i, j] * unit[i] * unit[j] if moves[i] and moves[j] else 0.0
    for i in range(n):
        row = cones.normals[i]
        if not moves[row] and free[row] < 0.0:
            # Nothing can keep it from approaching.
            return np.zeros(m), math.inf, 0
    if not scale > 0.0 and not cones.floor.any():
        return np.zeros(m), 0.0, 0
    if not scale < math.inf:
        return np.zeros(m), math.inf, 0
    floor, reach = np.empty(n), np.empty(len(cones.reach))
    for i in range(n):
        floor[i] = cones.floor[i] / unit[cones.normals[i]]
        scale = max(scale, floor[i])
    for g in range(len(reach)):
        # |p_g| ≤ c p_n in the units of both.
        reach[g] = cones.reach[g] * unit[cones.normals[cones.contact[g]]] / unit[cones.first[g]]
    scaled = Cones(cones.normals, floor, cones.first, cones.size, cones.contact, reach)
    best, steps = _found(W, b, x, scaled, scale)
    residual = _natural(W, b, best, b, 0.0, scaled, np.empty(m)) / scale
    for i in range(m):
        best[i] *= unit[i]
    return best, residual, steps


@compiled
def _units(mobility: np.ndarray, cones: Cones) -> tuple[np.ndarray, np.ndarray]:
    """(m,) 1/√D by row, D of its group, and whether impulses of the row move anything."""
    m = len(mobility)
    unit, moves = np.ones(m), np.zeros(m, np.bool_)
    largest = 0.0
    for row in cones.normals:
        largest = max(largest, mobility[row])
    for row in cones.normals:
        if mobility[row] > IMMOBILE * largest:
            unit[row], moves[row] = 1.0 / math.sqrt(mobility[row]), True
    for g in range(len(cones.first)):
        at, most = cones.first[g], 0.0
        for k in range(cones.size[g]):
            most = max(most, mobility[at + k])
        for k in range(cones.size[g]):
            if most > 0.0 and moves[cones.normals[cones.contact[g]]]:
                unit[at + k] = 1.0 / math.sqrt(most)
                moves[at + k] = mobility[at + k] > IMMOBILE * most
    return unit, moves


@compiled
def _found(
    W: np.ndarray, b: np.ndarray, x: np.ndarray, cones: Cones, scale: float
) -> tuple[np.ndarray, int]:
    """(m,) x of the least residual that was reached, and the steps of Newton."""
    m = len(b)
    room = np.empty((m, m))
    give = 0.0
    symmetric, live = _live_part(W)
    if live and not cholesky(symmetric, live, room) >= DEPENDENT_SQUARED:
        give = CONE_GIVE
    value = np.empty(m)
    best, least = x.copy(), _natural(W, b, x, x, 0.0, cones, value)
    steps = 0
    for _ in range(MOST_SHIFTS if give else 1):
        found, made = _settled(W, b, best, give, cones, scale)
        steps += made
        left = _natural(W, b, found, found, 0.0, cones, value)
        if not left < least:
            break
        gained = left < 0.5 * least
        best, least = found, left
        if least <= CONES_SOLVED * scale or not gained:
            break
    return best, steps


@compiled
def _live_part(W: np.ndarray) -> tuple[np.ndarray, int]:
    """The symmetric part of W without the rows that nothing moves, and its size."""
    m = len(W)
    live = 0
    which = np.empty(m, np.int64)
    for i in range(m):
        if W[i, i] != 0.0:
            which[live] = i
            live += 1
    part = np.empty((live, live))
    for i in range(live):
        for j in range(live):
            part[i, j] = 0.5 * (W[which[i], which[j]] + W[which[j], which[i]])
    return part, live


@compiled
def _settled(
    W: np.ndarray, b: np.ndarray, centre: np.ndarray, give: float, cones: Cones, scale: float
) -> tuple[np.ndarray, int]:
    """(m,) x where every row gives way by ``give`` from ``centre``, and the steps of Newton."""
    m = len(b)
    value = np.empty(m)
    best, steps = centre.copy(), 0
    least = _natural(W, b, best, centre, give, cones, value)
    x = centre.copy()
    for turn in range(MOST_ROUNDS):
        if turn:
            x = best.copy() if turn % 3 else np.zeros(m)
            _relax(W, b, x, centre, give, cones, SWEEPS * turn)
        made = _newton(W, b, x, centre, give, cones, scale)
        steps += made
        left = _natural(W, b, x, centre, give, cones, value)
        if left < least:
            best, least = x.copy(), left
        if least <= SMALL * scale:
            break
    return best, steps


@borrowing
def _natural(
    W: np.ndarray,
    b: np.ndarray,
    x: np.ndarray,
    centre: np.ndarray,
    give: float,
    cones: Cones,
    value: np.ndarray,
) -> float:
    """The natural map F(x) = x − projection of x − ξ, written to ``value``; its largest entry."""
    m = len(b)
    for i in range(m):
        total = b[i] + give * (x[i] - centre[i])
        for j in range(m):
            total += W[i, j] * x[j]
        value[i] = total
    for g in range(len(cones.first)):
        at, size = cones.first[g], cones.size[g]
        reach = cones.reach[g] * max(x[cones.normals[cones.contact[g]]], 0.0)
        length = 0.0
        for k in range(size):
            length += (x[at + k] - value[at + k]) ** 2
        length = math.sqrt(length)
        if length > reach:
            for k in range(size):
                value[at + k] = x[at + k] - reach * ((x[at + k] - value[at + k]) / length)
    for i in range(len(cones.normals)):
        row = cones.normals[i]
        value[row] = min(value[row], x[row] - cones.floor[i])
    most = 0.0
    for i in range(m):
        if W[i, i] == 0.0:
            # Nothing moves it, and it carries nothing.
            value[i] = x[i]
        if not abs(value[i]) <= most:
            most = abs(value[i])
    return most


@compiled
def _newton(
    W: np.ndarray,
    b: np.ndarray,
    x: np.ndarray,
    centre: np.ndarray,
    give: float,
    cones: Cones,
    scale: float,
) -> int:
    """Newton's method from x, in its place; how many steps were made."""
    m = len(b)
    value, trial, slope, step = np.empty(m), np.empty(m), np.empty((m, m)), np.empty(m)
    left = _natural(W, b, x, centre, give, cones, value)
    for made in range(MOST_STEPS):
        if left <= CONES_SOLVED * scale:
            return made
        _slope(W, b, x, centre, give, cones, slope)
        for i in range(m):
            step[i] = value[i]
        if not gauss(slope, m, step):
            return made
        size, sum_before = 1.0, _squares(value)
        for _ in range(HALVINGS):
            for i in range(m):
                trial[i] = x[i] - size * step[i]
            left = _natural(W, b, trial, centre, give, cones, value)
            if _squares(value) < (1.0 - FALLS * size) * sum_before:
                break
            size *= 0.5
        if not _squares(value) < sum_before:
            _natural(W, b, x, centre, give, cones, value)
            return made
        for i in range(m):
            x[i] = trial[i]
    return MOST_STEPS


@borrowing
def _squares(value: np.ndarray) -> float:
    total = 0.0
    for entry_of_it in value:
        total += entry_of_it * entry_of_it
    return total


@compiled
def _slope(
    W: np.ndarray,
    b: np.ndarray,
    x: np.ndarray,
    centre: np.ndarray,
    give: float,
    cones: Cones,
    slope: np.ndarray,
) -> None:
    """Write (m, m) the slope of the natural map."""
    m = len(b)
    xi = np.empty(m)
    for i in range(m):
        xi[i] = b[i] + give * (x[i] - centre[i])
        for j in range(m):
            xi[i] += W[i, j] * x[j]
            slope[i, j] = W[i, j]
        slope[i, i] += give
    for i in range(len(cones.normals)):
        row = cones.normals[i]
        if x[row] - cones.floor[i] < xi[row]:
            slope[row] = 0.0
            slope[row, row] = 1.0
    for g in range(len(cones.first)):
        at, size, normal = cones.first[g], cones.size[g], cones.normals[cones.contact[g]]
        reach = cones.reach[g] * max(x[normal], 0.0)
        z, length = np.zeros(2), 0.0
        for k in range(size):
            z[k] = x[at + k] - xi[at + k]
            length += z[k] * z[k]
        length = math.sqrt(length)
        if not length > reach:
            continue
        z /= length
        _slope_of_slip(slope, at, size, z, reach / length)
        if x[normal] > 0.0:
            for k in range(size):
                slope[at + k, normal] -= cones.reach[g] * z[k]
    for i in range(m):
        if W[i, i] == 0.0:
            slope[i] = 0.0
            slope[i, i] = 1.0


@compiled
def _slope_of_slip(slope: np.ndarray, at: int, size: int, z: np.ndarray, part: float) -> None:
    """x − R z/|z|, whose rows of dξ stand in ``slope``: 1 − part (1 − z zᵀ)(1 − dξ)."""
    m = len(slope)
    first = np.zeros((2, m))
    for k in range(size):
        for j in range(m):
            first[k, j] = -slope[at + k, j]
        first[k, at + k] += 1.0
    for k in range(size):
        for j in range(m):
            along = 0.0
            for other in range(size):
                along += z[other] * first[other, j]
            slope[at + k, j] = -part * (first[k, j] - z[k] * along)
        slope[at + k, at + k] += 1.0


@compiled
def _relax(
    W: np.ndarray,
    b: np.ndarray,
    x: np.ndarray,
    centre: np.ndarray,
    give: float,
    cones: Cones,
    sweeps: int,
) -> None:
    """Projected relaxation, group after group, in the place of x."""
    m = len(b)
    for _ in range(sweeps):
        for i in range(len(cones.normals)):
            row = cones.normals[i]
            if W[row, row] > 0.0:
                xi = b[row] + give * (x[row] - centre[row])
                for j in range(m):
                    xi += W[row, j] * x[j]
                x[row] = max(cones.floor[i], x[row] - xi / (W[row, row] + give))
        for g in range(len(cones.first)):
            at, size = cones.first[g], cones.size[g]
            reach = cones.reach[g] * max(x[cones.normals[cones.contact[g]]], 0.0)
            rate, length = give, 0.0
            for k in range(size):
                rate += abs(W[at + k, at + k])
            z = np.zeros(2)
            for k in range(size):
                xi = b[at + k] + give * (x[at + k] - centre[at + k])
                for j in range(m):
                    xi += W[at + k, j] * x[j]
                z[k] = x[at + k] - xi / max(rate, NONZERO)
                length += z[k] * z[k]
            length = math.sqrt(length)
            short = reach / length if length > reach else 1.0
            for k in range(size):
                x[at + k] = z[k] * short if W[at + k, at + k] != 0.0 else 0.0
