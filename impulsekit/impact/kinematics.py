"""Velocities of single points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..robot.arrays import lock
from ..scene.numbers import vector

if TYPE_CHECKING:
    from .answer import Answer

__all__ = ["PointVelocity", "point_velocity"]


@dataclass(frozen=True, eq=False)
class PointVelocity:
    """The velocity of a point before and after an impact, (3,) each, world axes [m/s]."""

    before: np.ndarray
    after: np.ndarray

    @property
    def change(self) -> np.ndarray:
        """(3,) after − before."""
        return self.after - self.before


def point_velocity(impact: Answer, frame: str, at: Any) -> PointVelocity:
    """The velocity of the point ``at`` of ``frame``; see ``Impact.velocity_at``."""
    jacobian = impact.mechanics.point_jacobian(frame, np.array(vector(at, f'point of "{frame}"')))[
        :3
    ]
    before, after = jacobian @ impact.v_before, jacobian @ impact.v_after
    lock(before, after)
    return PointVelocity(before, after)
