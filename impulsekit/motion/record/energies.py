"""Energies and momenta of a motion at its sample times."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...formatting import OneLine
from ...impact.flat.model import flat_model_of
from ...robot.arrays import read_only

if TYPE_CHECKING:
    from .sampled import SampledMotion

__all__ = ["EnergyHistory", "MomentumHistory", "energies_of", "momenta_of"]


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
    rows = _rows_of(motion, states)
    configurations = motion.q if states is None else states[0]
    springs = np.zeros(len(rows))
    if motion.scene.forces:
        springs[:] = [motion.loads.core.spring_energy(q) for q in configurations]
    # What stands on the world has weight, too.
    base = motion.scene.robot.model.inertias[0]
    rows[:, 1] -= base.mass * np.dot(motion.scene.gravity, base.lever)
    return EnergyHistory(*(read_only(x) for x in (rows[:, 0].copy(), rows[:, 1].copy(), springs)))


def momenta_of(motion: SampledMotion, states: States | None = None) -> MomentumHistory:
    """See ``Trajectory.momentum``; of (T, nq) and (T, nv) ``states`` where they are given."""
    rows = _rows_of(motion, states)
    return MomentumHistory(read_only(rows[:, 2:5].copy()), read_only(rows[:, 5:].copy()))


def _rows_of(motion: SampledMotion, states: States | None) -> np.ndarray:
    """(T, 8) kinetic energy, that of weight, and momenta."""
    configurations, velocities = (motion.q, motion.v) if states is None else states
    core, gravity = flat_model_of(motion.scene.robot).core, np.array(motion.scene.gravity)
    found = [core.energies(q, v, gravity) for q, v in zip(configurations, velocities, strict=True)]
    return np.array(found).reshape(-1, 8)
