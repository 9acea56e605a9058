"""Energies and momenta of a motion at its sample times."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ...formatting import OneLine
from ...robot.arrays import read_only
from ...robot.masses import crba_of, symmetric

if TYPE_CHECKING:
    from .sampled import SampledMotion

__all__ = ["EnergyHistory", "MomentumHistory", "energies_of", "momenta_of", "momentum_at"]


@dataclass(frozen=True, eq=False, repr=False)
class EnergyHistory(OneLine):
    """Energies at the times of a trajectory, (T,) each [J].

    Attributes:
        kinetic: ½ vᵀ M v.
        gravity: potential energy of weight, zero where all mass is at the world's origin.
        springs: in ``JointSpring`` and ``Spring``.
    """

    kinetic: np.ndarray
    gravity: np.ndarray
    springs: np.ndarray

    @property
    def total(self) -> np.ndarray:
        """(T,) the sum [J]."""
        return self.kinetic + self.gravity + self.springs


@dataclass(frozen=True, eq=False, repr=False)
class MomentumHistory(OneLine):
    """Momenta of the whole robot at the times of a trajectory, world axes.

    Attributes:
        linear: (T, 3) [kg m/s].
        angular: (T, 3) about the world's origin [kg m²/s].
    """

    linear: np.ndarray
    angular: np.ndarray


States = tuple[np.ndarray, np.ndarray]


def energies_of(motion: SampledMotion, states: States | None = None) -> EnergyHistory:
    """See ``Trajectory.energy``; of (T, nq) and (T, nv) ``states`` where they are given."""
    configurations, velocities = (motion.q, motion.v) if states is None else states
    model = _with_gravity(motion)
    data = model.createData()
    core = motion.loads.core if motion.scene.forces else None
    rows, crba = np.empty((len(configurations), 3)), crba_of(model)
    for row, q, v in zip(rows, configurations, velocities, strict=True):
        # By M itself: Pinocchio's own function takes no mimic joints.
        mass_matrix = np.array(crba(model, data, q)).reshape(model.nv, model.nv)
        row[0] = 0.5 * v.dot(symmetric(mass_matrix)).dot(v)
        pin.forwardKinematics(model, data, q)
        row[1] = -sum(
            inertia.mass * model.gravity.linear.dot(placement.act(inertia.lever))
            for inertia, placement in zip(model.inertias, data.oMi, strict=True)
        )
        row[2] = core.spring_energy(q) if core is not None else 0.0
    kinetic, gravity, springs = (read_only(column.copy()) for column in rows.T)
    return EnergyHistory(kinetic, gravity, springs)


def momenta_of(motion: SampledMotion, states: States | None = None) -> MomentumHistory:
    """See ``Trajectory.momentum``; of (T, nq) and (T, nv) ``states`` where they are given."""
    configurations, velocities = (motion.q, motion.v) if states is None else states
    model = _with_gravity(motion)
    data = model.createData()
    own = [momentum_at(model, data, q, v) for q, v in zip(configurations, velocities, strict=True)]
    linear, angular = np.array(own).reshape(-1, 2, 3).swapaxes(0, 1).copy()
    return MomentumHistory(read_only(linear), read_only(angular))


def momentum_at(model: pin.Model, data: pin.Data, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """(6,) linear, and angular about the world's origin."""
    about_com = pin.computeCentroidalMomentum(model, data, q, v)
    moment = about_com.angular + np.cross(data.com[0], about_com.linear)
    return np.concatenate([about_com.linear, moment])


def _with_gravity(motion: SampledMotion) -> pin.Model:
    model = pin.Model(motion.scene.robot.model)
    model.gravity.linear = np.array(motion.scene.gravity)
    return model
