"""Velocities of points before and after an impact, and the velocity jumps of links.

Those of a link are v_klm Δy_l and ω_klm Δy_l (Chang & Huston 1995, eqs. (1), (2)).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..robot.arrays import lock
from ..scene.numbers import vector

if TYPE_CHECKING:
    from .answer import Answer

__all__ = ["LinkJump", "PointVelocity", "link_jumps", "point_velocity"]


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


@dataclass(frozen=True, eq=False)
class LinkJump:
    """The change of a link's velocity in an impact, in world axes.

    Attributes:
        dv_com: (3,) change of the velocity of the link's own mass centre [m/s].
        domega: (3,) change of its angular velocity [rad/s].
    """

    dv_com: np.ndarray
    domega: np.ndarray


def link_jumps(impact: Answer) -> dict[str, LinkJump]:
    """Return the jump of every link by name."""
    jumps = impact.loads.links.reshape(-1, 2, 3)
    lock(jumps)
    return {
        link.name: LinkJump(*own) for link, own in zip(impact.scene.robot.links, jumps, strict=True)
    }
