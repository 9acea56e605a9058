"""An impact in which contacts are hit one at a time, told hit by hit.

For a sequence of contacts, and for the contacts that act where slip is followed along the path
of each, one of every group that W couples. Known impulses and imposed constraints act before the
first hit.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..._core import HeldMass
from ...errors import InputError
from ...scene import Law
from ..contact_law import ContactProblem, hits_of
from ..held_mass import Responses
from .linear import Touching
from .modes import EDGE

__all__ = ["UNMOVED", "HitFound", "Hits", "follow_hits"]

# A normal velocity that a hit changes by less, relative, stays as it was.
UNMOVED = 1e-12
# So many are differentiated one by one; longer series are known by their limit.
MOST_HITS = 2000


@dataclass(frozen=True, eq=False)
class HitFound:
    """One contact struck once.

    Attributes:
        point: its index among the touching points.
        start, end: (nv,) the velocity before and after.
        impulse: (3,) P of the contact.
        multipliers: (m,) λ of the bilateral rows in this hit.
        block: (3, 3) its W [1/kg], bilateral rows eliminated.
        response: (nv, 3) how the velocity changes with P, bilateral rows held.
        borne: (m, 3) what these bear of it.
    """

    point: int
    start: np.ndarray
    end: np.ndarray
    impulse: np.ndarray
    multipliers: np.ndarray
    block: np.ndarray
    response: np.ndarray
    borne: np.ndarray

    def at(self, share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """λ (m,) and the velocity (nv,) when P has come to ``share``."""
        return self.borne @ share, self.start + self.response @ share


@dataclass(frozen=True, eq=False)
class Hits:
    """The way of an impact.

    Attributes:
        free: (nv,) the velocity before the first hit.
        free_multipliers: (m,) λ until then.
        found: the hits in order.
        edges: why a small change may bring other hits.
    """

    free: np.ndarray
    free_multipliers: np.ndarray
    found: tuple[HitFound, ...]
    edges: tuple[str, ...]


def follow_hits(
    law: Law,
    held_mass: HeldMass,
    touching: Sequence[Touching],
    names: Sequence[str],
    before: np.ndarray,
    after: np.ndarray,
    multipliers: np.ndarray,
    impulses: Sequence[np.ndarray],
    scale: float,
) -> Hits:
    """The hits that make up an impact.

    Args:
        held_mass: M under the bilateral rows.
        names: of the touching points.
        before, after: (nv,) v⁻ and v⁺.
        multipliers: (m,) λ in all.
        impulses: by touching point, (3,) P in all.
        scale: the size of the velocities [m/s].

    Raises:
        InputError: there are too many hits to follow.
    """
    rows = np.concatenate([point.rows.matrix for point in touching])
    system = Responses.of(held_mass, rows)
    total = np.concatenate(impulses)
    free = after - system.moved @ total
    problem = ContactProblem(
        system.delassus,
        rows @ before,
        rows @ free,
        np.array([point.coefficients.e for point in touching]),
        np.array([point.coefficients.mu for point in touching]),
        np.array([point.coefficients.e_t for point in touching]),
    )
    edges: list[str] = []
    if law.order == "sequential":
        steps = _in_sequence(problem, law, names, scale, edges)
    else:
        steps = _alone(problem, law, impulses, names, scale, edges)
    velocity = free
    found: list[HitFound] = []
    for i, share in steps:
        own = slice(3 * i, 3 * i + 3)
        response, borne = system.moved[:, own], system.borne[:, own]
        following = velocity + response @ share
        block = system.delassus[own, own]
        if len(found) == MOST_HITS:
            raise InputError(
                f"derivatives: the contacts are hit more than {MOST_HITS} times one after the "
                'other, which is not differentiated; use Law(order="simultaneous")'
            )
        found.append(HitFound(i, velocity, following, share, borne @ share, block, response, borne))
        velocity = following
    held = multipliers - sum((hit.multipliers for hit in found), np.zeros(len(multipliers)))
    return Hits(free, held, tuple(found), tuple(edges))


def _in_sequence(
    problem: ContactProblem, law: Law, names: Sequence[str], scale: float, edges: list[str]
) -> Iterator[tuple[int, np.ndarray]]:
    """The hits of a sequence, and where its order hangs on a hair."""
    small = EDGE * scale
    at_rest = np.zeros(len(names), dtype=bool)
    velocity = problem.velocity_free
    weights = problem.delassus.diagonal()[2::3]
    for i, now, share in hits_of(problem, law):
        normals = now[2::3]
        # The order is that of |u_n|/√W_nn; what no impulse moves comes first whatever it is.
        apart = np.abs(normals - normals[i] * np.sqrt(weights / (weights[i] or 1.0)))
        for j in np.flatnonzero(apart <= small).tolist():
            if j != i:
                edges.append(f"{names[i]}: {names[j]} approaches just as fast")
        velocity = now + problem.delassus[:, 3 * i : 3 * i + 3] @ share
        at_rest &= np.abs(velocity[2::3] - normals) <= UNMOVED * scale
        at_rest[i] = problem.restitution[i] == 0.0
        yield i, share
    for j in np.flatnonzero((np.abs(velocity[2::3]) <= small) & ~at_rest).tolist():
        edges.append(f"{names[j]}: it hardly approaches or hardly parts")


def _alone(
    problem: ContactProblem,
    law: Law,
    impulses: Sequence[np.ndarray],
    names: Sequence[str],
    scale: float,
    edges: list[str],
) -> Iterator[tuple[int, np.ndarray]]:
    """The contacts that act, which do not act on each other, and others that nearly do."""
    small = EDGE * scale
    free = problem.velocity_free
    approach = free[2::3].copy()
    if law.restitution == "newton":
        approach += problem.restitution * np.minimum(problem.velocity_before[2::3], 0.0)
    for j in np.flatnonzero(np.abs(approach) <= small).tolist():
        edges.append(f"{names[j]}: it hardly approaches or hardly parts")
    acting = [i for i, impulse in enumerate(impulses) if impulse[2] > 0.0]
    if not acting:
        return
    if _act_on_each_other(problem, acting):
        raise InputError(
            "derivatives: several contacts without friction act on each other beside others whose "
            "slip is followed along the path; put bodies that have nothing to do with each other "
            'into scenes of their own, or use slip="end"'
        )
    after = free + problem.delassus @ np.concatenate(impulses)
    for j in np.flatnonzero(np.abs(after[2::3]) <= small).tolist():
        if j not in acting:
            edges.append(f"{names[j]}: it hardly approaches or hardly parts")
    for i in acting:
        yield i, impulses[i]


def _act_on_each_other(problem: ContactProblem, chosen: list[int]) -> bool:
    """Whether W couples some of the chosen contacts."""
    rows = [[3 * i + k for k in range(0 if problem.friction[i] else 2, 3)] for i in chosen]
    return any(
        problem.delassus[np.ix_(first, other)].any()
        for k, first in enumerate(rows)
        for other in rows[:k]
    )
