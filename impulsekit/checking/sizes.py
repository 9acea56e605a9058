"""Bounds of rounding, and the size of each quantity of an impact."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..reference import KaneImpact, Load, Rows
from ..reference.kane import generalized_masses
from ..reference.kinematics import Kinematics
from ..reference.tree import WORLD, Tree

if TYPE_CHECKING:
    from ..impact import Impact


def reach_of(tree: Tree, at: Kinematics) -> float:
    """Return the reach of a body from the root of its tree [m]; never 0."""
    origins, centres = at.origins.astype(float), at.mass_centres.astype(float)
    roots: list[int] = []
    reach = 0.0
    for k, body in enumerate(tree.bodies):
        roots.append(k if body.parent == WORLD else roots[body.parent])
        base = origins[roots[k]]
        gyration = 0.0
        if body.mass > 0:
            gyration = float(np.sqrt(max(float(np.trace(body.inertia)) / float(body.mass), 0.0)))
        distances = np.linalg.norm(origins[k] - base), np.linalg.norm(centres[k] - base)
        reach = max(reach, gyration, *map(float, distances))
    return reach or 1.0


# [rad] A row is dependent if, scaled to unit length, it stands less than this out of the span of
# the others; and zero if its entries are less than this share of the terms they are sums of. Loops
# closed by hand are off by about as much. ``core/contact/tolerances.hpp`` has the core's own.
RANK_TOLERANCE = 1e-7
# [rad] A row that is one axis of a vector is dependent if it stands less than this out of the span
# of the others, in the length of the longest of its axes: what the digits of files leave of a loop
# in a plane. An arm stretched to 1e-5 rad leaves more.
FAINT_AXIS = 1e-8
# Rounding of a solve, in units of epsilon times the condition.
ROUNDING = 10.0
SMALLEST_TOLERANCE, LARGEST_TOLERANCE = 1e-12, 1e-6


@dataclass(frozen=True, eq=False)
class Conditions:
    """The amplification of rounding in an impact. n speeds, r rows; all in doubles.

    Attributes:
        masses: (n, n) a_lp.
        rows: (r, n) the constraint rows on the speeds.
        mobilities: (r,) the diagonal of W = A a⁻¹ Aᵀ, zero where it is rounding.
        independent: indices of rows that are independent and span the others.
        faint: indices of rows left out because they are rounding beside other axes of the same
            velocity; what they are met by is not compared.
        of_masses: condition of a_lp scaled to unit diagonal.
        of_rows: the same of W of the independent rows; 1 without any.
        away: distance from the world's origin over the reach of the robot, where the reference
            computes in doubles: its places round by that.
    """

    masses: np.ndarray
    rows: np.ndarray
    mobilities: np.ndarray
    independent: tuple[int, ...]
    faint: tuple[int, ...]
    of_masses: float
    of_rows: float
    away: float = 0.0

    @property
    def tolerance(self) -> float:
        """The allowed differences; see :func:`impulsekit.check`."""
        amplified = self.of_masses
        if len(self.rows):
            amplified = self.of_masses * self.of_rows**0.5 + self.of_rows
        rounding = ROUNDING * float(np.finfo(float).eps) * (amplified + self.away)
        return min(max(rounding, SMALLEST_TOLERANCE), LARGEST_TOLERANCE)


def conditions_of(tree: Tree, at: Kinematics, demands: Rows) -> Conditions | None:
    """Return the conditions at a configuration; None where the masses alone are singular."""
    import scipy.linalg

    masses = generalized_masses(at).astype(float)
    rows = demands.matrix(tree.arithmetic, at.linear, at.angular) + demands.speeds
    rows = rows.astype(float)
    diagonal = np.diagonal(masses)
    if not (diagonal > 0.0).all():
        return None
    root = np.sqrt(diagonal)
    scaled = masses / root / root[:, None]
    values = np.linalg.eigvalsh(scaled) if tree.n else np.ones(1)
    if not values[0] > len(masses) * np.finfo(float).eps:
        return None
    of_masses = float(values[-1] / values[0])
    away = 0.0
    if tree.arithmetic.name == "double":
        away = float(np.abs(at.origins).max()) / reach_of(tree, at)
    if not len(demands):
        return Conditions(masses, rows, np.zeros(0), (), (), of_masses, 1.0, away)
    lower = np.linalg.cholesky(scaled)
    half = scipy.linalg.solve_triangular(lower, (rows / root).T, lower=True)
    mobilities = np.einsum("ij,ij->j", half, half)
    moving = mobilities > _rounding_of_mobility(mobilities, demands)
    largest = _largest(mobilities, demands)
    mobilities = np.where(moving, mobilities, 0.0)
    half = half * np.where(moving, 1.0 / np.sqrt(np.where(moving, mobilities, 1.0)), 0.0)
    chosen = _independent(half, RANK_TOLERANCE)
    # Measured by the vector it is an axis of, a row counts whatever axes that has.
    shares = np.sqrt(mobilities / np.where(largest > 0.0, largest, 1.0))
    fewer = _independent(half * shares, FAINT_AXIS)
    faint: tuple[int, ...] = ()
    if len(fewer) < len(chosen):
        chosen, faint = fewer, tuple(i for i in range(len(mobilities)) if i not in fewer)
    singular = np.linalg.svd(half[:, chosen], compute_uv=False) if chosen else np.ones(1)
    of_rows = float((singular[0] / singular[-1]) ** 2)
    return Conditions(masses, rows, mobilities, chosen, faint, of_masses, of_rows, away)


def _independent(half: np.ndarray, tolerance: float) -> tuple[int, ...]:
    """Return columns that are independent and span the others."""
    import scipy.linalg

    triangle, order = scipy.linalg.qr(half, mode="r", pivoting=True)
    rank = int((np.abs(np.diagonal(triangle)) > tolerance).sum())
    return tuple(sorted(order[:rank].tolist()))


def _rounding_of_mobility(mobilities: np.ndarray, demands: Rows) -> np.ndarray:
    """Return (r,) up to where a row moves nothing: of two ends that move alike rounding is left.

    A row is measured by those along the axes of the same velocity, and by all rows for what is
    rounding of the whole.
    """
    whole = np.finfo(float).eps ** 2 * mobilities.max(initial=0.0)
    return np.maximum(whole, RANK_TOLERANCE**2 * _largest(mobilities, demands))


def _largest(mobilities: np.ndarray, demands: Rows) -> np.ndarray:
    """Return the (r,) largest mobility among the rows along axes of the same velocity."""
    largest: dict[tuple[str, int], float] = {}
    keys = []
    for i, name in enumerate(demands.names):
        # "point of a against b, row 0"; a row of speeds stands for itself.
        of_bodies = demands.linear[i].any() or demands.angular[i].any()
        keys.append((name.rpartition(", row")[0], -1 if of_bodies else i))
    for key, mobility in zip(keys, mobilities.tolist(), strict=True):
        largest[key] = max(largest.get(key, 0.0), mobility)
    return np.array([largest[key] for key in keys])


def take(demands: Rows, indices: tuple[int, ...]) -> Rows:
    """Return some of the rows."""
    chosen = list(indices)
    return Rows(
        demands.linear[chosen],
        demands.angular[chosen],
        demands.speeds[chosen],
        demands.target[chosen],
        tuple(demands.names[i] for i in chosen),
    )


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
    """Return the sizes of an impact, by the reference's numbers."""
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
    """Return (n,) how large the generalized impulses of loads are if nothing in them cancels.

    |f| (|v_l| + |ω_l| r) + |c| |ω_l|, by the partial velocities of the body with the force f
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
