"""The impact of what touches at a state of MuJoCo, solved in the core."""

from __future__ import annotations

from typing import Any, NamedTuple

import mujoco
import numpy as np

from .._core import Contacts, Failure, solve_matrices
from ..impact.contact_law import core_friction, core_law
from ..impact.status import BY_CODE, Status
from ..robot.arrays import read_only
from ..scene.coefficients import EllipticFriction
from ..scene.law import Law
from .coefficients import PairCoefficients
from .listing import Listing
from .record import Parts, StepImpact

__all__ = ["ImpactSolver"]

# By condim, the rows of t₁, t₂ and the normal after the first, and those of the relative angular
# velocity; a row that a contact lacks is another one's, and set to zero.
_SLIDING = np.array([[0, 0, 0], [0, 0, 0], [0, 0, 0]] + 4 * [[1, 2, 0]], dtype=np.int32)
_TURNING = np.array(6 * [[3, 3, 3]] + [[4, 5, 3]], dtype=np.int32)
_STATE = int(mujoco.mjtState.mjSTATE_INTEGRATION)


class _Friction(NamedTuple):
    """µ (n,), ellipses as the core takes them, and contacts that resist rolling and spin."""

    mu: np.ndarray
    models: list[Any]
    turning: np.ndarray
    rolling: np.ndarray
    torsion: np.ndarray


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

    def solve(self, data: Any, listing: Listing, which: np.ndarray) -> StepImpact:
        """Return the impact of some entries of a listing at the state of ``data``."""
        model, v, dims = self._model, data.qvel.copy(), listing.dims[which]
        contacts = which[: which.searchsorted(len(listing.numbers))]
        n, nv = len(contacts), model.nv
        pairs = listing.pairs[which]
        friction = self._friction(data.contact.friction[listing.numbers[contacts]], dims)
        J = self._rows(listing, which, dims, friction.turning)
        approach = -(J[: len(which), 2] @ v)
        e = self._restitution(pairs, approach, n)
        given: dict[str, Any] = {"restitution": e, "friction": friction.mu}
        if len(friction.turning):
            given |= {
                "turning_of": friction.turning,
                "rolling": friction.rolling,
                "torsion": friction.torsion,
            }
        mass = np.empty((nv, nv))
        mujoco.mj_fullM(model, data, mass)
        equalities = listing.rows[: listing.equalities]
        found = solve_matrices(
            mass, self._parent, v, equalities, equalities @ v, J.reshape(-1, nv),
            Contacts(tangential=np.zeros(len(which)), models=friction.models, **given), self._law,
        )  # fmt: skip
        is_solved = found.failure == Failure.none
        status = BY_CODE[found.contact.status] if is_solved else Status.NO_SOLUTION
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
                model, state, mass, listing.equalities, J, own.reshape(-1, 3), pairs,
                listing.positions[contacts], data.contact.frame[listing.numbers[contacts]],
                friction.turning,
            ),
        )  # fmt: skip

    def _rows(
        self, listing: Listing, which: np.ndarray, dims: np.ndarray, turning: np.ndarray
    ) -> np.ndarray:
        """(n + k + j, 3, nv) J of contacts, limits, and the turning of contacts."""
        address = listing.address[which]
        numbers = address[:, None] + _SLIDING[dims]
        if len(turning):
            numbers = np.concatenate([numbers, address[turning, None] + _TURNING[dims[turning]]])
        J = listing.rows[numbers]
        if (dims == 1).any():
            J[: len(which)][dims == 1, :2] = 0.0
        if len(turning):
            J[len(which) :][dims[turning] == 4, :2] = 0.0
        return J

    def _friction(self, given: np.ndarray, dims: np.ndarray) -> _Friction:
        """Friction of contacts from MuJoCo's five numbers (n, 5), and of limits."""
        n, slides = len(given), np.zeros((len(dims), 2))
        mu = self._coefficients.friction
        slides[:n] = given[:, :2] if mu is None else mu
        slides[dims == 1] = 0.0
        models: list[Any] = []
        if (slides[:, 0] != slides[:, 1]).any():
            models = [
                core_friction(EllipticFriction(a, b) if a != b else a) for a, b in slides.tolist()
            ]
        turning = (dims > 3).nonzero()[0].astype(np.int32)
        own = given[turning]
        rolling = np.where(dims[turning] == 6, 0.5 * (own[:, 3] + own[:, 4]), 0.0)
        return _Friction(slides.max(axis=1), models, turning, rolling, own[:, 2].copy())

    def _restitution(self, pairs: np.ndarray, approach: np.ndarray, n: int) -> np.ndarray:
        e = np.full(len(pairs), self._limits)
        of = self._coefficients.restitution
        e[:n] = [
            of(a, b, max(speed, 0.0))
            for (a, b), speed in zip(pairs[:n].tolist(), approach[:n].tolist(), strict=True)
        ]
        return e
