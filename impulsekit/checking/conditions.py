"""What rounding may do: conditions of the masses and of the constraint rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..laws.rank_tolerances import FAINT_AXIS, RANK_TOLERANCE
from ..reference import Rows
from ..reference.kane import generalized_masses
from ..reference.kinematics import Kinematics
from ..reference.tree import Tree
from .reach import reach_of

__all__ = ["Conditions", "conditions_of"]

# Rounding of a solve, in units of epsilon times the condition.
ROUNDING = 10.0
SMALLEST_TOLERANCE, LARGEST_TOLERANCE = 1e-12, 1e-6


@dataclass(frozen=True, eq=False)
class Conditions:
    """How far an impact amplifies rounding. n speeds, r rows; all in doubles.

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
        """What differences may be; see :func:`impulsekit.check`."""
        amplified = self.of_masses
        if len(self.rows):
            amplified = self.of_masses * self.of_rows**0.5 + self.of_rows
        rounding = ROUNDING * float(np.finfo(float).eps) * (amplified + self.away)
        return min(max(rounding, SMALLEST_TOLERANCE), LARGEST_TOLERANCE)


def conditions_of(tree: Tree, at: Kinematics, demands: Rows) -> Conditions | None:
    """The conditions at a configuration; None where the masses alone are singular."""
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
    """Columns that are independent and span the others."""
    import scipy.linalg

    triangle, order = scipy.linalg.qr(half, mode="r", pivoting=True)
    rank = int((np.abs(np.diagonal(triangle)) > tolerance).sum())
    return tuple(sorted(order[:rank].tolist()))


def _rounding_of_mobility(mobilities: np.ndarray, demands: Rows) -> np.ndarray:
    """(r,) up to where a row moves nothing: of two ends that move alike rounding is left.

    A row is measured by those along the axes of the same velocity, and by all rows for what is
    rounding of the whole.
    """
    whole = np.finfo(float).eps ** 2 * mobilities.max(initial=0.0)
    return np.maximum(whole, RANK_TOLERANCE**2 * _largest(mobilities, demands))


def _largest(mobilities: np.ndarray, demands: Rows) -> np.ndarray:
    """(r,) the largest mobility among the rows along axes of the same velocity."""
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
    """Some of the rows."""
    chosen = list(indices)
    return Rows(
        demands.linear[chosen],
        demands.angular[chosen],
        demands.speeds[chosen],
        demands.target[chosen],
        tuple(demands.names[i] for i in chosen),
    )
