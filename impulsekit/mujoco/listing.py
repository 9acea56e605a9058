"""Contacts and limits close to touching at a state of MuJoCo, as rows with their gaps."""

from __future__ import annotations

import copy
import math
from typing import Any, NamedTuple

import mujoco
import numpy as np

__all__ = ["DEEPER", "KEPT", "LIMIT_JOINT", "Listing", "StepModels"]

# The soft contact begins this much deeper while an instant is sought, so that no stage of an
# integrator feels it before [m].
DEEPER = 1e-6
LIMIT_JOINT = int(mujoco.mjtConstraint.mjCNSTR_LIMIT_JOINT)

_STATE = mujoco.mjtState
# All that a step starts from, without what a user gives anew at any step.
KEPT = int(
    _STATE.mjSTATE_FULLPHYSICS | _STATE.mjSTATE_WARMSTART | _STATE.mjSTATE_EQ_ACTIVE
    | _STATE.mjSTATE_MOCAP_POS | _STATE.mjSTATE_MOCAP_QUAT
)  # fmt: skip


class Listing(NamedTuple):
    """Contacts, then limits, within reach at one state.

    Attributes:
        pairs: (k, 2) the geoms of a contact; of a limit −1 − its kind, and its joint or tendon.
        keys: (k,) the same as one integer each.
        positions: (k, 3) [m], zeros of limits.
        gaps, speeds: (k,) how far each is from touching, and how fast that grows.
        address: (k,) first row of each in ``rows``: the normal, then t₁, t₂, and the angular
            velocity about the normal, t₁ and t₂, as many as ``dims`` says.
        dims: (k,) number of rows.
        rows: (m, nv) all of MuJoCo's constraint rows.
        equalities: how many of them, the first, are of equalities.
        numbers: (contacts,) of MuJoCo's list.
    """

    pairs: np.ndarray
    keys: np.ndarray
    positions: np.ndarray
    gaps: np.ndarray
    speeds: np.ndarray
    address: np.ndarray
    dims: np.ndarray
    rows: np.ndarray
    equalities: int
    numbers: np.ndarray


class StepModels:
    """Copies of a model that differ in time step and margins.

    Attributes:
        plain: as the user gave it.
    """

    def __init__(self, model: Any) -> None:
        self.plain = model
        self._rest, self._flight = copy.copy(model), copy.copy(model)
        _shift_margins(self._flight, model, -DEEPER)
        self._near, self._far = self._new_probe(), self._new_probe()
        self._reach = 0.0

    def restore(self, data: Any, state: np.ndarray) -> None:
        """Set a state of the kinds ``KEPT``."""
        mujoco.mj_setState(self.plain, data, state, KEPT)

    def step(self, data: Any, duration: float) -> None:
        """Advance by a part of a step as MuJoCo does."""
        if duration > 0.0:
            self._rest.opt.timestep = duration
            mujoco.mj_step(self._rest, data)

    def fly(self, data: Any, duration: float) -> None:
        """Advance by a part of a step in which what touches by then exerts no force."""
        if duration > 0.0:
            self._flight.opt.timestep = duration
            mujoco.mj_step(self._flight, data)

    def look(self, data: Any, reach: float) -> Listing:
        """Compute positions and the mass matrix, and list what is within a reach, at least."""
        probe = self._near
        if reach:
            # A power of four: it seldom changes.
            reach, probe = 4.0 ** math.ceil(math.log(reach, 4.0)), self._far
            if reach != self._reach:
                _shift_margins(probe, self.plain, reach)
                self._reach = reach
        mujoco.mj_fwdPosition(probe, data)
        nv, count, contact = self.plain.nv, data.nefc, data.contact
        rows = data.efc_J.reshape(-1)[: count * nv].reshape(count, nv)
        # Excluded are pairs in the gap, and those without degrees of freedom.
        address = contact.efc_address
        numbers = ((contact.exclude == 0) & (address >= 0)).nonzero()[0]
        address, pairs = address[numbers], contact.geom[numbers]
        positions, dims = contact.pos[numbers], contact.dim[numbers]
        gaps = contact.dist[numbers] - contact.includemargin[numbers]
        if data.nl:
            first = data.ne + data.nf
            limits = np.arange(first, first + data.nl, dtype=address.dtype)
            own = np.stack([-1 - data.efc_type[limits], data.efc_id[limits]], axis=1)
            pairs = np.concatenate([pairs, own])
            positions = np.concatenate([positions, np.zeros((len(limits), 3))])
            gaps = np.concatenate([gaps, data.efc_pos[limits] - data.efc_margin[limits]])
            address = np.concatenate([address, limits])
            dims = np.concatenate([dims, np.ones_like(limits)])
        return Listing(
            pairs, pairs.view(np.int64)[:, 0], positions, gaps + reach,
            rows[address] @ data.qvel, address, dims, rows, data.ne, numbers,
        )  # fmt: skip

    def _new_probe(self) -> Any:
        """A model whose rows of contacts are those of the normal and the tangents themselves."""
        probe = copy.copy(self.plain)
        probe.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        probe.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        return probe


def _shift_margins(model: Any, plain: Any, by: float) -> None:
    """Shift the margin of every contact and limit; that of a contact is its geoms' sum."""
    for name in ("geom_margin", "body_margin"):
        getattr(model, name)[:] = getattr(plain, name) + 0.5 * by
    for name in ("pair_margin", "jnt_margin", "tendon_margin"):
        getattr(model, name)[:] = getattr(plain, name) + by
    model.opt.o_margin = plain.opt.o_margin + by
