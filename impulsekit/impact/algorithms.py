"""The ways from a known impulse to Δv: M Δv = I (Chang & Huston 1995, eq. (32)).

M is never inverted. Each class keeps one workspace and is used by one thread.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from ..robot.masses import crba_of
from .factor import DenseFactor
from .known import KnownImpulses
from .singular import check_pivots, has_uneven_masses

# Bound once: on a small robot the look-up of a name counts.
crba, decompose, cholesky_solve = pin.crba, pin.cholesky.decompose, pin.cholesky.solve

__all__ = ["ByAba", "ByCrba", "ByDenseCholesky", "Rescaled"]

# Most robots that are built stay below; Talos has 2e3.
UNEVEN_MOMENTS = 1e5
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
        impulse = self._known.generalized_impulse(self._data, q)
        upper = np.atleast_2d(self._crba(self._model, self._data, q))
        return DenseFactor(self._model, upper.T).solve(impulse)


class Rescaled:
    """Another way's Δv, of impulses that were brought to a size that doubles bear."""

    def __init__(self, way: ByAba | ByCrba | ByDenseCholesky, unit: float) -> None:
        self._way, self._back = way, 1.0 / unit

    def velocity_jump(self, q: np.ndarray) -> np.ndarray:
        """(nv,) Δv of the reached model at q."""
        return self._back * self._way.velocity_jump(q)
