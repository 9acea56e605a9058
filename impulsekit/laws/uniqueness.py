"""Whether other velocities obey the law of contact as well: all modes, or a proof without them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .compiled import compiled, entry
from .coupling import SURE, friction_is_weak
from .plane_modes import plane_modes, plane_of
from .space_modes import space_modes

__all__ = [
    "MOST_IN_PLANE",
    "MOST_IN_SPACE",
    "SAME",
    "SURE",
    "TOO_MANY",
    "TRIED_ALL",
    "TRIED_SOME",
    "Search",
    "is_another",
    "search_answers",
    "search_modes",
    "search_phase",
]

# Contacts of which all modes are tried: 4⁴ linear systems in the plane (6⁴ at release), and 3³
# modes with directions of slip in space; one more takes six to ten times as long.
MOST_IN_PLANE, MOST_IN_SPACE = 4, 3
# Friction below this counts as none: it would only underflow.
NEGLIGIBLE = 1e-150
# Velocities that differ by less than this share of the largest are the same.
SAME = 1e-6
# Work above this share of the energies in play is a gain.
GAIN = 1e-10
# How many solutions are kept at most.
MOST_FOUND = 16
# [N s], relative: releases of less than this share of the load are none.
LEAST_RELEASE = 1e-290

SMOOTH, WEAK, ALL_TRIED, SEARCHED, TOO_MANY = "smooth", "weak", "all tried", "searched", "too many"


# What ``search_modes`` did.
NOTHING_TRIED, TRIED_SOME, TRIED_ALL = 0, 1, 2


def _examples() -> tuple[Any, ...]:
    line, few = np.ones(6), np.ones(2)
    return np.eye(6), line, few, few, 1.0, True, np.eye(6)


@entry(_examples, seconds=25.0)
def search_modes(
    W: np.ndarray,
    b: np.ndarray,
    mu: np.ndarray,
    floor: np.ndarray,
    scale: float,
    plane: bool,
    found: np.ndarray,
) -> tuple[int, int]:
    """What was tried, and how many solutions of one phase were written to ``found``.

    Args:
        W: (3n, 3n), tangents without friction cleared [1/kg].
        b: (3n,) likewise [m/s].
        mu, floor: (n,) friction, and the least normal impulses [N s].
        scale: the size of the velocities [m/s].
        plane: only where all modes can be tried.
        found: (most, 3n), written: P of the solutions [N s].
    """
    n = len(mu)
    direction = np.empty((n, 2))
    if n <= MOST_IN_PLANE and plane_of(W, b, mu, direction):
        basis = np.zeros((2 * n, 3 * n))
        for i in range(n):
            basis[2 * i, 3 * i], basis[2 * i, 3 * i + 1] = direction[i, 0], direction[i, 1]
            basis[2 * i + 1, 3 * i + 2] = 1.0
        flat = np.empty((len(found), 2 * n))
        own = np.dot(np.dot(basis, W), basis.T.copy())
        count = plane_modes(own, np.dot(basis, b), mu, floor, scale, flat)
        for k in range(count):
            found[k] = np.dot(flat[k], basis)
        return TRIED_ALL, count
    if plane or n > MOST_IN_SPACE or floor.max() > 0.0:
        return NOTHING_TRIED, 0
    return TRIED_SOME, space_modes(W, b, mu, scale, found)


@compiled
def is_another(W, P, shown, start, free, scale):  # type: ignore[no-untyped-def]
    """Whether P makes other velocities than ``shown``, and adds no energy.

    Args:
        W: (3n, 3n) Delassus matrix [1/kg].
        P, shown: (3n,) impulses [N s].
        start: (3n,) the velocity from which works count [m/s].
        free: (3n,) u_free [m/s].
        scale: the size of the velocities [m/s].
    """
    apart, work, size = 0.0, 0.0, 0.0
    for r in range(len(P)):
        after, change = free[r], 0.0
        for c in range(len(P)):
            after += W[r, c] * P[c]
            change += W[r, c] * (P[c] - shown[c])
        apart = max(apart, abs(change))
        own = 0.5 * P[r] * (start[r] + after)
        work += own
        size += abs(own) + abs(P[r] * start[r])
    return apart > SAME * scale and work <= GAIN * size


class Search(NamedTuple):
    """What is known of the solutions of a contact problem.

    Attributes:
        how: "smooth" (no friction), "weak" (friction is too weak to leave a choice) and "all
            tried" prove how many there are; "searched" and "too many" do not.
        impulses: (k, 3n) the impulses found [N s]; none where a proof needs no search.
        compressions: (k, 3n) under Poisson's law the impulses of their compression.
    """

    how: str
    impulses: np.ndarray
    compressions: np.ndarray | None = None

    @property
    def complete(self) -> bool:
        """Whether there are no others."""
        return self.how in (SMOOTH, WEAK, ALL_TRIED)


def search_answers(
    delassus: np.ndarray,
    aim: np.ndarray,
    friction: np.ndarray,
    scale: float,
    release: np.ndarray | None = None,
    *,
    always: bool = False,
) -> Search:
    """The solutions of 0 ≤ P_n ⊥ ξ_n ≥ 0 with Coulomb friction, ξ = W P + b.

    Args:
        delassus: (3n, 3n) W [1/kg].
        aim: (3n,) b: u_free, and under Newton's law what restitution adds [m/s].
        friction: (n,) µ.
        scale: the size of the velocities [m/s].
        release: (n,) e of Poisson's expansion; None under Newton's law.
        always: search even where a proof says that there is one at most.
    """
    n = len(friction)
    none = np.empty((0, 3 * n))
    mu = np.where(friction > NEGLIGIBLE, friction, 0.0)
    if not mu.any() and not always:
        return Search(SMOOTH, none)
    rubbed = _without_idle_tangents(delassus, mu)
    b = aim.copy()
    b[0::3][mu == 0.0] = 0.0
    b[1::3][mu == 0.0] = 0.0
    if not always and friction_is_weak(rubbed, mu):
        return Search(WEAK, none)
    how, pressed = _phase(rubbed, b, mu, np.zeros(n), scale)
    if release is None or not release.any():
        return Search(how, pressed)
    if how != ALL_TRIED:
        # Of Poisson's law in space only what friction proves is known.
        return Search(TOO_MANY, none)
    impulses, compressions = [none], [none]
    for one in pressed:
        floor = release * one[2::3]
        floor[floor < LEAST_RELEASE] = 0.0
        _, back = _phase(rubbed, b + rubbed @ one, mu, floor, scale)
        impulses.append(one + back)
        compressions.append(np.broadcast_to(one, back.shape))
    return Search(ALL_TRIED, np.concatenate(impulses), np.concatenate(compressions))


def search_phase(
    delassus: np.ndarray,
    aim: np.ndarray,
    friction: np.ndarray,
    floor: np.ndarray | None,
    scale: float,
    *,
    plane: bool,
) -> Search:
    """The solutions of one phase, 0 ≤ P_n − f ⊥ ξ_n ≥ 0; tangents without friction are cleared.

    Args:
        delassus, aim, friction, scale: as in ``search_answers``.
        floor: (n,) f [N s]; None for 0.
        plane: only where all modes can be tried.
    """
    floor = np.zeros_like(friction) if floor is None else floor
    how, impulses = _phase(delassus, aim, friction, floor, scale, plane=plane)
    return Search(how, impulses)


def _phase(
    W: np.ndarray,
    b: np.ndarray,
    mu: np.ndarray,
    floor: np.ndarray,
    scale: float,
    *,
    plane: bool = False,
) -> tuple[str, np.ndarray]:
    """What was tried, and (k, 3n) the impulses found."""
    # Compiled code takes arrays in order that may be written to.
    W, b, mu, floor = (np.array(array, dtype=float, order="C") for array in (W, b, mu, floor))
    found = np.empty((MOST_FOUND, len(b)))
    how, count = search_modes(W, b, mu, floor, float(scale), plane, found)
    return (TOO_MANY, SEARCHED, ALL_TRIED)[how], found[:count].copy()


def _without_idle_tangents(delassus: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """W with the tangents of contacts without friction cleared."""
    cleared = np.array(delassus, dtype=float, order="C")
    for i in np.flatnonzero(mu == 0.0).tolist():
        cleared[3 * i : 3 * i + 2] = 0.0
        cleared[:, 3 * i : 3 * i + 2] = 0.0
    return cleared
