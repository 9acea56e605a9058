"""The impact of what touches at a state of MuJoCo, solved in the core."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from .._core import solve_matrices
from ..impact.contact_law import ContactProblem, Turning, friction_models, law_codes
from ..scene.coefficients import EllipticFriction
from ..scene.law import Law
from .coefficients import PairCoefficients
from .listing import Listing

__all__ = ["System", "solve_impact", "system_of"]


@dataclass(frozen=True, eq=False)
class System:
    """Rows of all that touches, contacts first, then limits.

    Attributes:
        mass: (nv, nv) M, with armature. velocity: (nv,) before.
        equalities: (m, nv) A.
        contacts: (n, 3, nv) velocity of geom 2 relative to geom 1 along t₁, t₂ and the normal.
        turning: (j, 3, nv) relative angular velocity along the same axes; ``turning_of`` (j,).
        limits: (l, nv), opening positive. limit_ids: (l, 2) kind, joint or tendon.
        pairs: (n, 2) geoms. positions: (n, 3). axes: (n, 3, 3), rows t₁, t₂, normal.
        dims: (n,) condim. friction: (n, 5) MuJoCo's.
    """

    mass: np.ndarray
    velocity: np.ndarray
    equalities: np.ndarray
    contacts: np.ndarray
    turning: np.ndarray
    turning_of: np.ndarray
    limits: np.ndarray
    limit_ids: np.ndarray
    pairs: np.ndarray
    positions: np.ndarray
    axes: np.ndarray
    dims: np.ndarray
    friction: np.ndarray


def system_of(model: Any, data: Any, listing: Listing, which: np.ndarray) -> System:
    """Return the rows of some entries of a listing at the state of ``data``."""
    nv, contact = model.nv, data.contact
    n = int(np.count_nonzero(which < len(listing.numbers)))
    own, limits = which[:n], which[n:]
    numbers, address = listing.numbers[own], listing.address[own]
    dims, rows = listing.dims[own], listing.rows
    contacts = np.zeros((n, 3, nv))
    contacts[:, 2] = rows[address]
    sliding = np.flatnonzero(dims > 1)
    for k in range(2):
        contacts[sliding, k] = rows[address[sliding] + 1 + k]
    turns = np.flatnonzero(dims > 3)
    turning = np.zeros((len(turns), 3, nv))
    turning[:, 2] = rows[address[turns] + 3]
    rolls = np.flatnonzero(dims[turns] == 6)
    for k in range(2):
        turning[rolls, k] = rows[address[turns[rolls]] + 4 + k]
    mass = np.empty((nv, nv))
    mujoco.mj_fullM(model, data, mass)
    return System(
        mass, data.qvel.copy(), rows[listing.equalities], contacts, turning, turns,
        rows[listing.address[limits]], listing.pairs[limits] * [-1, 1] - [1, 0],
        listing.pairs[own], listing.positions[own],
        contact.frame[numbers].reshape(n, 3, 3)[:, [1, 2, 0]], dims, contact.friction[numbers],
    )  # fmt: skip


def solve_impact(
    model: Any, system: System, coefficients: PairCoefficients, e_limits: float, law: Law
) -> tuple[Any, np.ndarray]:
    """Return the core's solution, and e (n,) of contacts.

    M Δv = Aᵀλ + JᵀP with A Δv = 0 for equalities; limits are contacts without friction.
    """
    n, k, v = len(system.pairs), len(system.limits), system.velocity
    approach = np.maximum(-(system.contacts[:, 2] @ v), 0.0)
    e = [
        coefficients.restitution(a, b, speed)
        for (a, b), speed in zip(system.pairs.tolist(), approach.tolist(), strict=True)
    ]
    slides = system.friction[:, :2]
    if coefficients.friction is not None:
        slides = np.full((n, 2), coefficients.friction)
    slides = np.where(system.dims[:, None] > 1, slides, 0.0)
    models = []
    if (slides[:, 0] != slides[:, 1]).any():
        given = [EllipticFriction(a, b) if a != b else a for a, b in slides.tolist()]
        models = friction_models([*given, *[0.0] * k], [np.array([1.0, 0.0])] * (n + k))
    j = system.turning_of
    J = np.zeros((n + k + len(j), 3, model.nv))
    J[:n], J[n : n + k, 2], J[n + k :] = system.contacts, system.limits, system.turning
    turning = None
    if len(j):
        rolling = np.where(system.dims[j] == 6, system.friction[j, 3:].mean(axis=1), 0.0)
        turning = Turning(j, rolling, system.friction[j, 2])
    zeros = np.zeros(n + k)
    mu = np.append(slides.max(axis=1, initial=0.0), np.zeros(k))
    problem = ContactProblem(
        zeros, zeros, zeros, np.array(e + [e_limits] * k), mu, zeros, turning=turning
    )
    parent = np.arange(-1, model.nv - 1) if model.tendon_armature.any() else model.dof_parentid
    found = solve_matrices(
        system.mass, np.ascontiguousarray(parent, dtype=np.int32), v,
        system.equalities, system.equalities @ v, J.reshape(-1, model.nv),
        problem.coefficients(), models, *law_codes(law),
    )  # fmt: skip
    return found, np.array(e)
