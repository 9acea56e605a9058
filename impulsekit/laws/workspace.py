"""The memory that the laws of several contacts work in, made once for many problems."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .compiled import compiled

__all__ = ["Sizes", "Workspace", "workspace"]


class Workspace(NamedTuple):
    """One problem of n contacts, ξ = W P + b, and room for its solution.

    Arrays may be longer than the n contacts of a problem take.

    Attributes:
        W: (3n, 3n) Delassus matrix, tangents without friction cleared [1/kg].
        b: (3n,) ξ without contact impulses [m/s].
        mu, floor: (n,) friction, and the least normal impulses [N s].
        P: (3n,) the impulses [N s].
        best, xi: (3n,) the best P so far [N s]; ξ [m/s].
        mode, slip: (n,) and (n, 2) what each contact does, and where it slides to.
        way, aim, matrix: (3n, 3n) room.
        owner: (3n,) the contact of each unknown of a Newton step.
        x, moved, y, z: (3n,) room.
        unit: (n,) impulses that are of one size beside each other [N s].
        velocity, total: (3n,) u after a part of the impact [m/s]; the impulses of all parts [N s].
        normal, friction: (n,) works [J].
        unique: (n,) whether no other contact could carry what this one carries.
    """

    W: np.ndarray
    b: np.ndarray
    mu: np.ndarray
    floor: np.ndarray
    P: np.ndarray
    best: np.ndarray
    xi: np.ndarray
    mode: np.ndarray
    slip: np.ndarray
    way: np.ndarray
    aim: np.ndarray
    matrix: np.ndarray
    owner: np.ndarray
    x: np.ndarray
    moved: np.ndarray
    y: np.ndarray
    z: np.ndarray
    unit: np.ndarray
    velocity: np.ndarray
    total: np.ndarray
    normal: np.ndarray
    friction: np.ndarray
    unique: np.ndarray


class Sizes(NamedTuple):
    """What counts as nothing in a problem.

    Attributes:
        scale: the size of the velocities [m/s].
        largest: the largest entry on the diagonal of W [1/kg].
        least: an entry there that is none [1/kg].
        alike: whether no contact's mass is much larger than another's.
    """

    scale: float
    largest: float
    least: float
    alike: bool


@compiled
def workspace(n: int) -> Workspace:
    """Room for n contacts."""
    size = 3 * n
    # One array each: a slice of a larger one would be counted at every use.
    return Workspace(
        np.zeros((size, size)),
        np.zeros(size),
        np.zeros(n),
        np.zeros(n),
        np.zeros(size),
        np.zeros(size),
        np.zeros(size),
        np.zeros(n, np.int64),
        np.zeros((n, 2)),
        np.zeros((size, size)),
        np.zeros((size, size)),
        np.zeros((size, size)),
        np.zeros(size, np.int64),
        np.zeros(size),
        np.zeros(size),
        np.zeros(size),
        np.zeros(size),
        np.zeros(n),
        np.zeros(size),
        np.zeros(size),
        np.zeros(n),
        np.zeros(n),
        np.ones(n, np.bool_),
    )
