"""Coulomb's law for forces at resting contacts and dry joints, as a motion asks for it."""

from __future__ import annotations

import numpy as np

from ...impact.contact_law import Turning
from ...laws.product_cones import Cones, find_cone_impulses
from ...laws.resting import find_forces
from ...laws.tolerances import RESIDUAL_LIMIT

__all__ = ["RESIDUAL_LIMIT", "RestNotSolved", "by_cones", "cones_of", "solve_rest"]

# More rows are solved by compiled code where it is stored; above the second it is compiled, since
# the second search takes a minute without.
FEW_ROWS, MANY_ROWS = 3, 24


class RestNotSolved(Exception):
    """No forces found. Internal: a motion ends with a status instead."""


def solve_rest(
    delassus: np.ndarray,
    free: np.ndarray,
    friction: np.ndarray,
    start: np.ndarray,
    ways: np.ndarray | None = None,
    bounds: np.ndarray | None = None,
) -> np.ndarray:
    """(3n + k,) contact forces P [N], two tangents and the normal of each contact, and joints'.

    Args:
        delassus: (3n + k, 3n + k) W [1/kg].
        free: (3n + k,) b, the accelerations without contact forces [m/s²].
        friction: (n,) µ; 0 for what slides.
        start: (3n + k,) the forces to start from.
        ways: (3n + k, 3n + k) contact forces from P where something slides: W times it is what
            counts.
        bounds: (k,) of the joints that stand still the largest dry friction [N m, N]; 0 for none.

    Raises:
        RestNotSolved: there are none, or they were not found.
    """
    forces = np.zeros_like(free)
    used = np.repeat(friction > 0.0, 3)
    used[2::3] = True
    if bounds is not None:
        used = np.concatenate([used, bounds > 0.0])
        friction = np.concatenate([friction, -bounds[bounds > 0.0]])
    coupled = delassus if ways is None else delassus.dot(ways)
    # Tangents without friction carry nothing: they are left out.
    own, few = np.flatnonzero(used), np.ix_(used, used)
    all_of_it, own_part = (np.ascontiguousarray(w[few]) for w in (coupled, delassus))
    if len(own) > FEW_ROWS:
        find_forces.load()
    found, residual = find_forces(all_of_it, own_part, free[own], friction, start[own])
    if not residual <= RESIDUAL_LIMIT:
        others = None if bounds is not None else by_cones(coupled, delassus, free, friction)
        if others is None:
            raise RestNotSolved(f"residual {residual:.1e}")
        return others
    forces[own] = found
    return forces


def by_cones(
    coupled: np.ndarray, delassus: np.ndarray, free: np.ndarray, friction: np.ndarray
) -> np.ndarray | None:
    """The same by another search, which finds forces of many points that stick; None if not."""
    if not friction.any():
        return None
    nothing = Turning(np.zeros(0, dtype=int), np.zeros(0), np.zeros(0))
    cones = cones_of(friction, nothing, np.zeros(len(friction)))
    if len(free) > MANY_ROWS:
        find_cone_impulses.compile()
    whole, mobility = np.ascontiguousarray(coupled), delassus.diagonal().copy()
    found, residual, _ = find_cone_impulses(
        whole, mobility, np.ascontiguousarray(free), np.zeros(len(free)), cones
    )
    return found if residual <= RESIDUAL_LIMIT else None


def cones_of(friction: np.ndarray, turning: Turning, floor: np.ndarray) -> Cones:
    """The groups of n points and of those of them that resist turning.

    Args:
        friction: (n,) µ.
        turning: whose rows come after those of the points.
        floor: (n,) the least normal impulses.
    """
    n = len(friction)
    first = [3 * i for i in range(n)]
    size, contact, reach = [2] * n, list(range(n)), friction.tolist()
    for k, (i, rolling, torsion) in enumerate(
        zip(turning.of.tolist(), turning.rolling.tolist(), turning.torsion.tolist(), strict=True)
    ):
        at = 3 * (n + k)
        first += [at, at + 2]
        size += [2, 1]
        contact += [i, i]
        reach += [rolling, torsion]
    normals = np.arange(2, 3 * n, 3, dtype=np.int64)
    return Cones(
        normals,
        np.ascontiguousarray(floor, dtype=float),
        np.array(first, dtype=np.int64),
        np.array(size, dtype=np.int64),
        np.array(contact, dtype=np.int64),
        np.array(reach),
    )
