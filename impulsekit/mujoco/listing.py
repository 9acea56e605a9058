"""Contacts and limits close to touching at a state of MuJoCo, as rows with their gaps."""

from __future__ import annotations

import copy
import math
from typing import Any

import mujoco
import numpy as np

from .._core import ContactListing

__all__ = ["DEEPER", "KEPT", "LIMIT_JOINT", "StepModels"]

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

    def look(self, data: Any, reach: float) -> ContactListing:
        """Compute positions and the mass matrix, and list what is within a reach, at least."""
        probe = self._near
        if reach:
            # A power of four: it seldom changes.
            reach, probe = 4.0 ** math.ceil(math.log(reach, 4.0)), self._far
            if reach != self._reach:
                _shift_margins(probe, self.plain, reach)
                self._reach = reach
        mujoco.mj_fwdPosition(probe, data)
        # Excluded are pairs in the gap; those without degrees of freedom have no rows.
        own = data.contact
        listing = ContactListing(
            own.geom, own.exclude, own.efc_address, own.dim, own.pos, own.frame,
            own.dist, own.includemargin, reach, data.ne,
        )  # fmt: skip
        if data.nl:
            listing.add_limits(
                data.ne + data.nf, data.nl, data.efc_type, data.efc_id, data.efc_pos,
                data.efc_margin, reach,
            )  # fmt: skip
        listing.finish(data.efc_J, data.qvel)
        return listing

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
