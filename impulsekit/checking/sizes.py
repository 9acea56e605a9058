"""How large each kind of quantity is in an impact: what differences are relative to."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..reference import KaneImpact, Load
from ..reference.kinematics import Kinematics
from ..reference.tree import WORLD, Tree
from .conditions import Conditions
from .reach import reach_of

if TYPE_CHECKING:
    from ..impact import Impact

__all__ = ["Sizes", "sizes_of"]


@dataclass(frozen=True)
class Sizes:
    """Sizes of the quantities of an impact.

    A quantity may be small because large ones cancel, such as Δv of a robot that is held.
    So each size covers the motions on the way as well: what every entry of the scene would
    do alone, and under constraints and contacts the motion before. Within one entry the parts of
    a moment cancel, too, where a blow goes through an axis: each size covers what a load would do
    to every speed with the robot's reach as its lever.

    Attributes:
        speed: largest √a_ll |y_l| [√J].
        energy_norm: √(2 T) [√J]; bounds |I_l| / √a_ll and |P_l| / √a_ll.
        energy: kinetic energy [J].
        velocity: of mass centres [m/s].
        impulse: that links pass on to each other [N s].
        reach: of a tree from its root [m]; turns velocities into angular ones, and impulses
            into their moments.
    """

    speed: float
    energy_norm: float
    energy: float
    velocity: float
    impulse: float
    reach: float


def sizes_of(
    truth: KaneImpact,
    at: Kinematics,
    conditions: Conditions,
    impact: Impact,
    loads: Iterable[Load],
    reactions: Mapping[str, np.ndarray],
) -> Sizes:
    """The sizes of an impact, by the reference's numbers."""
    masses, root = conditions.masses, np.sqrt(np.diagonal(conditions.masses))
    motions = [truth.dy.astype(float)]
    if impact.impulse_shares:
        motions += list(np.linalg.solve(masses, np.array([*impact.impulse_shares.values()]).T).T)
    if impact.constraints or impact.contacts:
        motions.append(impact.v_before)
    norms = [float(np.sqrt(max(y @ masses @ y, 0.0))) for y in motions]
    reach = reach_of(truth.tree, at)
    velocity = impulse = 0.0
    body_masses = at.masses.astype(float)
    for y in motions:
        linear, angular = (part.astype(float) for part in at.velocities(y))
        speeds = np.linalg.norm(linear, axis=1)
        turning = reach * np.linalg.norm(angular, axis=1)
        velocity = max(velocity, speeds.max(initial=0.0), turning.max(initial=0.0))
        impulse = max(impulse, (body_masses * speeds).max(initial=0.0))
    wrenches = [np.array([*load.linear, *load.angular], dtype=float) for load in loads]
    for wrench in (*wrenches, *reactions.values()):
        parts = np.linalg.norm(wrench[:3]), np.linalg.norm(wrench[3:]) / reach
        impulse = max(impulse, *map(float, parts))
    by_speed = _without_cancelling(loads, truth.tree, at, reach)
    far = by_speed / root
    norms.append(float(far.max(initial=0.0)))
    moved = np.maximum(
        np.linalg.norm(at.linear.astype(float), axis=2),
        reach * np.linalg.norm(at.angular.astype(float), axis=2),
    ).max(axis=0, initial=0.0)
    velocity = max(velocity, float((moved * far / root).max(initial=0.0)))
    energies = (truth.energy_before, truth.energy_after, 0.5 * max(norms) ** 2)
    speeds = [float(np.max(root * np.abs(y), initial=0.0)) for y in motions]
    return Sizes(
        speed=max(*speeds, float(far.max(initial=0.0))),
        energy_norm=max(norms),
        energy=max(map(float, energies)),
        velocity=float(velocity),
        impulse=float(impulse),
        reach=reach,
    )


def _without_cancelling(
    loads: Iterable[Load], tree: Tree, at: Kinematics, reach: float
) -> np.ndarray:
    """(n,) how large the generalized impulses of loads are if nothing in them cancels.

    |f| (|v_l| + |ω_l| r) + |c| |ω_l|, by the partial velocities of the body that bears the force f
    and the couple c; r is the robot's reach and the distance of the point from the link's origin.
    """
    sizes = np.zeros(tree.n)
    for load in loads:
        body = tree.body_of_link(load.link)
        if body == WORLD:
            continue
        linear = np.linalg.norm(at.linear[body].astype(float), axis=1)
        angular = np.linalg.norm(at.angular[body].astype(float), axis=1)
        force, couple, point = (
            float(np.linalg.norm(np.array(part, dtype=float)))
            for part in (load.linear, load.angular, load.at)
        )
        sizes += force * (linear + angular * (reach + point)) + couple * angular
    return sizes
