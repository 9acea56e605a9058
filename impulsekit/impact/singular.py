"""Mass matrices that are singular: what rows make up for, pivots that are rounding, and the error.

A pivot of M = U D Uᵀ or of a Cholesky factor is what resists one motion when those eliminated
before it are free; over the diagonal of M it has no unit.
"""

from __future__ import annotations

from collections.abc import Container, Iterable
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..errors import SingularMassError
from ..robot.masses import symmetric

if TYPE_CHECKING:
    from ..robot import Robot

__all__ = [
    "check_pivots",
    "refuse_massless",
    "shares_of_inertia",
    "singular_joints",
    "singular_mass",
]

# Rows of less than this share of the longest do not fill up a singular mass matrix.
UNFILLED_ROW = 1e-12
# A pivot of M this far below its diagonal is rounding, not inertia.
SMALLEST_PIVOT = 1e-13
# Pivots depend on the order of elimination: below this the matrix is looked at as a whole.
FAINT_PIVOT = 1e-6
# A generalized mass below this share of the largest counts as zero.
WEIGHTLESS = 1e-12
# A principal moment that is negative by more than this part of the largest was written so.
NEGATIVE_MOMENT = 1e-9
# Joints with this part in a motion without mass, a unit vector, are named.
MOVES = 0.1
# Most robots that are built stay below; Talos has 1e2.
UNEVEN_MASSES = 2e3


def _has_uneven_masses(model: pin.Model) -> bool:
    """Return True if some bodies are so light beside others that sums over both lose digits."""
    masses = [body.mass for body in list(model.inertias)[1:] if body.mass > 0.0]
    return max(masses, default=1.0) > UNEVEN_MASSES * min(masses, default=1.0)


def check_pivots(model: pin.Model, data: pin.Data) -> None:
    """Check that the Cholesky factor in ``data`` has no pivot at rounding level.

    Raises:
        SingularMassError: it names the joints of the pivots that have vanished.
    """
    pivots, diagonal = data.D, np.diagonal(data.M)
    if (pivots > FAINT_PIVOT * diagonal).all():
        return
    vanished = ~(pivots > SMALLEST_PIVOT * diagonal)
    if not (vanished.any() or _has_uneven_masses(model)):
        vanished = shares_of_inertia(symmetric(data.M)) < SMALLEST_PIVOT
    if vanished.any():
        # Elimination starts at the leaves: behind a pivot of zero, all others are NaN.
        if not np.isnan(pivots[vanished]).all():
            vanished &= ~np.isnan(pivots)
        raise singular_mass(model, _joints_of(model, vanished))


def _joints_of(model: pin.Model, speeds: np.ndarray) -> list[int]:
    """The joints of generalized speeds, chosen by a mask (nv,)."""
    starts = [model.idx_vs[joint_id] for joint_id in range(1, model.njoints)]
    return sorted(set(np.searchsorted(starts, np.flatnonzero(speeds), side="right").tolist()))


def _of_unit_length(diagonal: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(m, nv) rows of unit length in the metric of an inertia, and (m,) what they are divided by.

    ``diagonal``: (nv,) of M. Rows that count as zero are of infinite length.
    """
    sizes = np.sqrt((rows**2 / _weights(diagonal, rows)).sum(axis=1))
    lengths = np.where(sizes > UNFILLED_ROW * sizes.max(initial=0.0), sizes, np.inf)
    return rows / lengths[:, None], lengths


def _weights(diagonal: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """(nv,) the diagonal of M; for a speed that moves nothing, what its rows feel elsewhere.

    A much smaller weight would cost the digits of that speed, a larger one those of others.
    """
    heavy = diagonal > WEIGHTLESS * diagonal.max()
    felt = (rows[:, heavy] ** 2 / diagonal[heavy]).sum(axis=1)
    felt = np.where(felt > 0.0, felt, np.inf)
    weights = np.where(heavy, diagonal, (rows**2 / felt[:, None]).max(axis=0, initial=0.0))
    return np.where(weights > 0.0, weights, diagonal.max() or 1.0)


def shares_of_inertia(mass_matrix: np.ndarray, rows: np.ndarray | None = None) -> np.ndarray:
    """(nv,) what resists each joint with the others free, over what hangs on it.

    1/((M⁻¹)ᵢᵢ Mᵢᵢ), with M filled by the constraints' rows: what these hold is not faint.
    """
    filled = mass_matrix
    if rows is not None:
        unit_rows, _ = _of_unit_length(np.diagonal(mass_matrix), rows)
        filled = mass_matrix + unit_rows.T @ unit_rows
    scale = 1.0 / np.sqrt(np.where((own := np.diagonal(filled)) > 0.0, own, 1.0))
    try:
        inverse = np.linalg.inv(filled * scale * scale[:, None])
    except np.linalg.LinAlgError:
        return np.ones(len(filled))
    return 1.0 / np.maximum(np.diagonal(inverse), 1.0)


def singular_joints(model: pin.Model, masses: np.ndarray, rows: np.ndarray | None) -> list[int]:
    """The joints along which neither inertia nor bilateral rows (m, nv) act.

    ``masses``: (nv, nv) M, its lower triangle.
    """
    matrix = np.tril(masses) + np.tril(masses, -1).T
    if rows is not None and len(rows):
        unit_rows, _ = _of_unit_length(matrix.diagonal(), rows)
        matrix = matrix + unit_rows.T @ unit_rows
    still = np.linalg.eigh(matrix)[1][:, 0]
    return _joints_of(model, np.abs(still) > MOVES)


def refuse_massless(robot: Robot, joints: Container[str]) -> None:
    """Check that no motion of these joints is without mass at every configuration.

    Raises:
        SingularMassError: the first that is, with its link.
    """
    found = [motion for motion in robot.massless_motions if motion.joint in joints]
    if found:
        names = tuple(dict.fromkeys(motion.joint for motion in found))
        more = f" (and {len(names) - 1} more: robot.massless_joints)" if len(names) > 1 else ""
        raise SingularMassError(
            f"the mass matrix is singular at every configuration: {found[0]}{more}", joints=names
        )


def singular_mass(model: pin.Model, joint_ids: Iterable[int]) -> SingularMassError:
    """The error that names the joints which move no inertia."""
    joint_ids = tuple(joint_ids)
    names = tuple(model.names[joint_id] for joint_id in joint_ids)
    for joint_id in joint_ids:
        body = model.inertias[joint_id]
        moments = np.linalg.eigvalsh(body.inertia)
        rounding = np.finfo(float).eps * body.mass * float(body.lever @ body.lever)
        if moments[0] < -max(NEGATIVE_MOMENT * abs(moments).max(), rounding):
            return SingularMassError(
                "the mass matrix is not positive definite here: the links on joint "
                f'"{model.names[joint_id]}" have a principal moment of inertia of '
                f"{moments[0]:.3g} kg m², it must be 0 or more; correct their <inertia>",
                joints=names,
            )
    named = ", ".join(f'"{name}"' for name in names[:4]) + (", …" if len(names) > 4 else "")
    return SingularMassError(
        f"the mass matrix is singular at this configuration: joint {named} moves no mass there; "
        "give its link an <inertial>, or lock the joint",
        joints=names,
    )
