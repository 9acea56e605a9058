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
        limits: e of limits.
    """

    def __init__(
        self, model: Any, coefficients: PairCoefficients, limits: float | None, law: Law
    ) -> None:
        self._model, self._coefficients, self._limits = model, coefficients, limits or 0.0
        self._law = core_law(law)
        parent = np.arange(-1, model.nv - 1) if model.tendon_armature.any() else model.dof_parentid
        self._parent = np.ascontiguousarray(parent, dtype=np.int32)
        self._state_size = mujoco.mj_stateSize(model, _STATE)

    def solve(self, data: Any, listing: ContactListing, which: list[int]) -> StepImpact:
        """Return the impact of some entries of a listing at the state of ``data``."""
        model, v, contact = self._model, data.qvel.copy(), data.contact
        numbers = listing.numbers(which)
        n, nv, pairs = len(numbers), model.nv, listing.pairs(which)
        approach = -listing.speeds(which)[:, 0]
        e = self._restitution(pairs, approach, n)
        mass = np.empty((nv, nv))
        mujoco.mj_fullM(model, data, mass)
        listed = solve_listed(
            listing, which, data.efc_J, mass, self._parent, v, e, contact.friction,
            self._coefficients.friction, self._law,
        )  # fmt: skip
        found = listed.solution
        is_solved = found.failure == Failure.none
        status = BY_CODE[found.contact.status] if is_solved else Status.NO_SOLUTION
        J = listed.J.reshape(-1, 3, nv)
        dv, own = found.dv, found.contact.impulse
        if not status.valid:
            dv, own = np.zeros(nv), np.zeros(3 * len(J))
        state = np.empty(self._state_size)
        mujoco.mj_getState(model, data, state, _STATE)
        return StepImpact(
            time=data.time,
            approach=read_only(approach[:n]),
            restitution=read_only(e[:n]),
            qpos=read_only(data.qpos.copy()),
            qvel=read_only(v),
            dv=read_only(dv),
            status=status,
            residual=found.contact.residual,
            parts=Parts(
                model, state, mass, data.ne, J, own.reshape(-1, 3), pairs,
                listing.positions(which[:n]), contact.frame[numbers],
                np.array(listed.turning, dtype=np.int32),
            ),
        )  # fmt: skip

    def _restitution(self, pairs: np.ndarray, approach: np.ndarray, n: int) -> np.ndarray:
        e = np.full(len(pairs), self._limits)
        of = self._coefficients.restitution
        e[:n] = [
            of(a, b, max(speed, 0.0))
            for (a, b), speed in zip(pairs[:n].tolist(), approach[:n].tolist(), strict=True)
        ]
        return e
