"""What is close to touching at a state of MuJoCo: contacts and limits as rows, with their gaps."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

__all__ = ["DEEPER", "Listing", "StepModels"]

# The soft contact begins this much deeper while an instant is sought, so that no stage of an
# integrator feels it before [m].
DEEPER = 1e-6
_CONSTRAINT = mujoco.mjtConstraint
_EQUALITY = int(_CONSTRAINT.mjCNSTR_EQUALITY)
LIMIT_JOINT, LIMIT_TENDON = (
    int(kind) for kind in (_CONSTRAINT.mjCNSTR_LIMIT_JOINT, _CONSTRAINT.mjCNSTR_LIMIT_TENDON)
)


@dataclass(frozen=True, eq=False)
class Listing:
    """Contacts, then limits, within reach at one state.

    Attributes:
        pairs: (k, 2) the geoms of a contact; of a limit −1 − its kind, and its joint or tendon.
        positions: (k, 3) [m], zeros of limits.
        gaps, speeds: (k,) how far each is from touching, and how fast that grows.
        address: (k,) first row of each in ``rows``: the normal, then t₁, t₂, and the angular
            velocity about the normal, t₁ and t₂, as many as ``dims`` says.
        dims: (k,) number of rows.
        rows: (m, nv) all of MuJoCo's constraint rows, equalities among them.
        equalities: (m,) whether a row is one.
        numbers: (contacts,) of MuJoCo's list.
    """

    pairs: np.ndarray
    positions: np.ndarray
    gaps: np.ndarray
    speeds: np.ndarray
    address: np.ndarray
    dims: np.ndarray
    rows: np.ndarray
    equalities: np.ndarray
    numbers: np.ndarray


class StepModels:
    """Copies of a model that differ in time step and margins.

    Attributes:
        plain: as the user gave it.
    """

    def __init__(self, model: Any) -> None:
        self.plain = model
        self._rest, self._flight, self._probe = (copy.copy(model) for _ in range(3))
        _shift_margins(self._flight, model, -DEEPER)
        # Rows of contacts are then those of the normal and the tangents themselves.
        self._probe.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        self._probe.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        self._reach = np.nan

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
        """Compute positions and the mass matrix, and list what is within a reach."""
        if reach != self._reach:
            _shift_margins(self._probe, self.plain, reach)
            self._reach = reach
        mujoco.mj_fwdPosition(self._probe, data)
        nv, count, contact = self.plain.nv, data.nefc, data.contact
        rows = data.efc_J.ravel()[: count * nv].reshape(count, nv)
        kinds = data.efc_type[:count]
        # Excluded are pairs in the gap, and those without degrees of freedom.
        numbers = np.flatnonzero((contact.exclude == 0) & (contact.efc_address >= 0))
        limits = np.flatnonzero((kinds == LIMIT_JOINT) | (kinds == LIMIT_TENDON))
        address = contact.efc_address[numbers]
        pairs, positions = contact.geom[numbers], contact.pos[numbers]
        gaps = contact.dist[numbers] - contact.includemargin[numbers]
        dims = contact.dim[numbers]
        if len(limits):
            own = np.column_stack([-1 - kinds[limits], data.efc_id[limits]])
            pairs = np.concatenate([pairs, own])
            positions = np.concatenate([positions, np.zeros((len(limits), 3))])
            gaps = np.append(gaps, data.efc_pos[limits] - data.efc_margin[limits])
            address = np.append(address, limits)
            dims = np.append(dims, np.ones_like(limits))
        speeds = rows[address] @ data.qvel
        return Listing(
            pairs, positions, gaps + reach, speeds, address, dims, rows, kinds == _EQUALITY, numbers
        )


def _shift_margins(model: Any, plain: Any, by: float) -> None:
    """Shift the margin of every contact and limit; that of a contact is its geoms' sum."""
    for name in ("geom_margin", "body_margin"):
        getattr(model, name)[:] = getattr(plain, name) + 0.5 * by
    for name in ("pair_margin", "jnt_margin", "tendon_margin"):
        getattr(model, name)[:] = getattr(plain, name) + by
    model.opt.o_margin = plain.opt.o_margin + by
