"""The ways from a known impulse to Δv: M Δv = I (Chang & Huston 1995, eq. (32)).

M is never inverted. Each class keeps one workspace and is used by one thread.
"""

from __future__ import annotations

import functools
from collections.abc import Container, Iterable
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..errors import SingularMassError
from ..laws.rank_tolerances import FAINT_PIVOT, SMALLEST_PIVOT
from ..robot.mass_matrix import crba_of
from ..tolerances import NONZERO
from .known import KnownImpulses

if TYPE_CHECKING:
    from ..robot import Robot

# Bound once: on a small robot the look-up of a name counts.
crba, decompose, cholesky_solve = pin.crba, pin.cholesky.decompose, pin.cholesky.solve

__all__ = [
    "ByAba",
    "ByCrba",
    "ByDenseCholesky",
    "Rescaled",
    "has_uneven_masses",
    "refuse_massless",
    "shares_of_inertia",
    "symmetric",
]

# A principal moment that is negative by more than this part of the largest was written so.
NEGATIVE_MOMENT = 1e-9
# Most robots that are built stay below; Talos has 1e2 and 2e3.
UNEVEN_MASSES, UNEVEN_MOMENTS = 2e3, 1e5
# Already at a ratio of 364 one pass of ABA left 1.2e-14 of M Δv = I.
UNEVEN_FOR_ABA = 2e2


class ByAba:
    """Δv by the articulated-body algorithm with the blows as external wrenches, in O(n).

    The wrench never meets the conditioning of M, so this is the most accurate way.
    """

    def __init__(self, known: KnownImpulses) -> None:
        model = known.model
        self._known = known
        self._model, self._data = model, model.createData()
        self._at_rest = np.zeros(model.nv)
        self._torque = self._at_rest if known.joint_impulse is None else known.joint_impulse
        self._forces = pin.StdVec_Force()
        for _ in range(model.njoints):
            self._forces.append(pin.Force.Zero())
        self._refines = _is_uneven(model)
        self._needs_placements = any(blow.axes == "world" for blow in known.blows)
        if not self._needs_placements:
            self._set_forces()

    def _set_forces(self) -> None:
        set_already: set[int] = set()
        for joint_id, force in self._known.external_forces(self._data):
            if joint_id in set_already:
                self._forces[joint_id] = self._forces[joint_id] + force
            else:
                self._forces[joint_id] = force
                set_already.add(joint_id)

    def velocity_jump(self, q: np.ndarray) -> np.ndarray:
        """(nv,) Δv of the reached model at q."""
        if self._needs_placements:
            pin.forwardKinematics(self._model, self._data, q)
            self._set_forces()
        jump = pin.aba(self._model, self._data, q, self._at_rest, self._torque, self._forces)
        if not self._refines:
            return jump
        # Once more on what M Δv leaves of the impulses, which RNEA tells in O(n).
        at_rest, model, data = self._at_rest, self._model, self._data
        jump = np.array(jump)
        left = self._torque - pin.rnea(model, data, q, at_rest, jump, self._forces)
        return jump + pin.aba(model, data, q, at_rest, left)


def has_uneven_masses(model: pin.Model, ratio: float = UNEVEN_MASSES) -> bool:
    """Whether some bodies are so light beside others that sums over both lose digits."""
    masses = [body.mass for body in list(model.inertias)[1:] if body.mass > 0.0]
    return max(masses, default=1.0) > ratio * min(masses, default=1.0)


def _is_uneven(model: pin.Model) -> bool:
    """Whether masses or moments of inertia differ so much that articulated inertias cancel."""
    bodies = list(model.inertias)[1:]
    moments = [m for body in bodies if (m := float(np.trace(body.inertia))) > 0.0]
    uneven = max(moments, default=1.0) > UNEVEN_MOMENTS * min(moments, default=1.0)
    return uneven or has_uneven_masses(model, UNEVEN_FOR_ABA)


class ByCrba:
    """Δv by the composite-rigid-body algorithm and Pinocchio's sparse Cholesky M = U D Uᵀ."""

    def __init__(self, known: KnownImpulses, *, always_regular: bool) -> None:
        self._generalized_impulse = known.generalized_impulse
        self._model, self._data = known.model, known.model.createData()
        self._always_regular = always_regular

    def velocity_jump(self, q: np.ndarray) -> np.ndarray:
        """(nv,) Δv of the reached model at q.

        Raises:
            SingularMassError: it names the joints that move no inertia at q.
        """
        model, data = self._model, self._data
        impulse = self._generalized_impulse(data, q)
        crba(model, data, q)
        decompose(model, data)
        if not self._always_regular:
            check_pivots(model, data)
        return cholesky_solve(model, data, impulse)


class ByDenseCholesky:
    """Δv by CRBA and LAPACK's Cholesky, for models with mimic joints.

    Pinocchio's ABA and sparse Cholesky do not take those.
    """

    def __init__(self, known: KnownImpulses) -> None:
        self._known = known
        self._model, self._data = known.model, known.model.createData()
        self._crba = crba_of(self._model)

    def velocity_jump(self, q: np.ndarray) -> np.ndarray:
        """(nv,) Δv of the reached model at q.

        Raises:
            SingularMassError: M is singular at q.
        """
        import scipy.linalg

        impulse = self._known.generalized_impulse(self._data, q)
        mass_matrix = symmetric(self._crba(self._model, self._data, q))
        scale = 1.0 / np.sqrt(np.maximum(np.diagonal(mass_matrix), NONZERO))
        try:
            factor = scipy.linalg.cho_factor(mass_matrix * scale * scale[:, None], lower=True)
        except np.linalg.LinAlgError:
            raise singular_mass(self._model, range(1, self._model.njoints)) from None
        if np.diagonal(factor[0]).min() ** 2 < SMALLEST_PIVOT:
            raise singular_mass(self._model, range(1, self._model.njoints))
        return scale * scipy.linalg.cho_solve(factor, scale * impulse)


class Rescaled:
    """Another way's Δv, of impulses that were brought to a size that doubles bear."""

    def __init__(self, way: ByAba | ByCrba | ByDenseCholesky, unit: float) -> None:
        self._way, self._back = way, 1.0 / unit

    def velocity_jump(self, q: np.ndarray) -> np.ndarray:
        """(nv,) Δv of the reached model at q."""
        return self._back * self._way.velocity_jump(q)


def symmetric(upper: np.ndarray) -> np.ndarray:
    """The whole of a symmetric matrix of which Pinocchio filled the upper triangle."""
    return np.where(_below(len(upper)), upper.T, upper)


@functools.cache
def _below(size: int) -> np.ndarray:
    """(size, size) mask of what is below the diagonal."""
    return np.tri(size, k=-1, dtype=bool)


def shares_of_inertia(mass_matrix: np.ndarray, rows: np.ndarray | None = None) -> np.ndarray:
    """(nv,) what resists each joint with the others free, over what hangs on it.

    1/((M⁻¹)ᵢᵢ Mᵢᵢ), with M filled by the constraints' rows: what these hold is not faint.
    """
    filled = mass_matrix
    if rows is not None:
        diagonal = np.diagonal(mass_matrix)
        weights = np.where(diagonal > 0.0, diagonal, diagonal.max() or 1.0)
        sizes = np.sqrt((rows**2 / weights).sum(axis=1, keepdims=True))
        unit_rows = np.divide(rows, sizes, out=np.zeros_like(rows), where=sizes > 0.0)
        filled = mass_matrix + unit_rows.T @ unit_rows
    scale = 1.0 / np.sqrt(np.where((own := np.diagonal(filled)) > 0.0, own, 1.0))
    try:
        inverse = np.linalg.inv(filled * scale * scale[:, None])
    except np.linalg.LinAlgError:
        return np.ones(len(filled))
    return 1.0 / np.maximum(np.diagonal(inverse), 1.0)


def check_pivots(model: pin.Model, data: pin.Data) -> None:
    """Prove that the Cholesky factor in ``data`` has no pivot at rounding level.

    Raises:
        SingularMassError: it names the joints of the pivots that have vanished.
    """
    pivots, diagonal = data.D, np.diagonal(data.M)
    if (pivots > FAINT_PIVOT * diagonal).all():
        return
    vanished = ~(pivots > SMALLEST_PIVOT * diagonal)
    if not (vanished.any() or has_uneven_masses(model)):
        vanished = shares_of_inertia(symmetric(data.M)) < SMALLEST_PIVOT
    if vanished.any():
        # Elimination starts at the leaves: behind a pivot of zero, all others are NaN.
        if not np.isnan(pivots[vanished]).all():
            vanished &= ~np.isnan(pivots)
        starts = [model.idx_vs[joint_id] for joint_id in range(1, model.njoints)]
        joints = np.searchsorted(starts, np.flatnonzero(vanished), side="right")
        raise singular_mass(model, sorted(set(joints.tolist())))


def refuse_massless(robot: Robot, joints: Container[str]) -> None:
    """Prove that no motion of these joints is without mass at every configuration.

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
