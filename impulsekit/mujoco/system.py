"""The impact of what touches at a state of MuJoCo, solved in the core."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from .._core import ContactListing, Failure, solve_listed
from ..impact.contact_law import core_law
from ..impact.status import BY_CODE, Status
from ..robot.arrays import read_only
from ..scene.law import Law
from .coefficients import PairCoefficients
from .record import Parts, StepImpact

__all__ = ["ImpactSolver"]

_STATE = int(mujoco.mjtState.mjSTATE_INTEGRATION)


class ImpactSolver:
    """M Δv = Aᵀλ + JᵀP with A Δv = 0 for equalities; limits are contacts without friction.

    Args:
        model: the ``mujoco.MjModel``, which is kept.
    """

    def __init__(self, model: Any, coefficients: PairCoefficients, law: Law) -> None:
        self._model, self._coefficients = model, coefficients
        self._law = core_law(law)
        parent = np.arange(-1, model.nv - 1) if model.tendon_armature.any() else model.dof_parentid
        self._parent = np.ascontiguousarray(parent, dtype=np.int32)
        self._state_size = mujoco.mj_stateSize(model, _STATE)

    def solve(self, data: Any, listing: ContactListing, which: list[int]) -> StepImpact:
        """Return the impact of some entries of a listing at the state of ``data``."""
        model, v, nv = self._model, data.qvel.copy(), self._model.nv
        e = self._coefficients.restitution(listing.pairs(which))
        mass, state = np.empty((nv, nv)), np.empty(self._state_size)
        mujoco.mj_fullM(model, data, mass)
        mujoco.mj_getState(model, data, state, _STATE)
        listed = solve_listed(
            listing, which, data.efc_J, mass, self._parent, v, e, data.contact.friction,
            self._coefficients.friction, self._law,
        )  # fmt: skip
        found = listed.solution
        is_solved = found.failure == Failure.none
        status = BY_CODE[found.contact.status] if is_solved else Status.NO_SOLUTION
        return StepImpact(
            time=data.time,
            qpos=read_only(data.qpos.copy()),
            qvel=read_only(v),
            dv=read_only(found.dv if status.valid else np.zeros(nv)),
            status=status,
            parts=Parts(model, state, mass, data.ne, listing, which, e, listed),
        )
