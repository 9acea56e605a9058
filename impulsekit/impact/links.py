"""Velocity jumps of every link: v_klm Δy_l and ω_klm Δy_l (Chang & Huston 1995, eqs. (1), (2))."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

if TYPE_CHECKING:
    from .result import Impact

__all__ = ["LinkJump", "link_jumps"]


@dataclass(frozen=True, eq=False)
class LinkJump:
    """How an impact changes the velocity of a link, in world axes.

    Attributes:
        dv_com: (3,) change of the velocity of the link's own mass centre [m/s].
        domega: (3,) change of its angular velocity [rad/s].
    """

    dv_com: np.ndarray
    domega: np.ndarray


def link_jumps(impact: Impact) -> dict[str, LinkJump]:
    """The jump of every link by name; all of them in one forward pass, O(n)."""
    robot = impact.scene.robot
    data = impact.mechanics.scratch()
    # Twists are linear in v at fixed q: those of dv are the jumps.
    pin.forwardKinematics(robot.model, data, impact.q, impact.dv)
    rotations = [placement.rotation for placement in data.oMi]
    jumps = {}
    for link in robot.links:
        twist, rotation = data.v[link.joint_id], rotations[link.joint_id]
        linear = rotation @ (twist.linear + np.cross(twist.angular, link.com_in_joint))
        angular = rotation @ twist.angular
        linear.setflags(write=False)
        angular.setflags(write=False)
        jumps[link.name] = LinkJump(linear, angular)
    return jumps
