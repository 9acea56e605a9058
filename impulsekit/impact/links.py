"""Velocity jumps of every link: v_klm Δy_l and ω_klm Δy_l (Chang & Huston 1995, eqs. (1), (2))."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..robot.arrays import lock

if TYPE_CHECKING:
    from .answer import Answer

__all__ = ["LinkJump", "link_jumps"]


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
    """The jump of every link by name; all of them in one forward pass, O(n)."""
    robot = impact.scene.robot
    data = impact.mechanics.scratch()
    # Twists are linear in v at fixed q: those of dv are the jumps.
    pin.forwardKinematics(robot.model, data, impact.q, impact.dv)
    links = robot.links
    twists = np.array([data.v[link.joint_id].vector for link in links]).reshape(-1, 6)
    turns = np.array([data.oMi[link.joint_id].rotation for link in links]).reshape(-1, 3, 3)
    places = np.array([link.com_in_joint for link in links]).reshape(-1, 3)
    at_centres = twists[:, :3] + np.cross(twists[:, 3:], places)
    linear = np.einsum("kij,kj->ki", turns, at_centres)
    angular = np.einsum("kij,kj->ki", turns, twists[:, 3:])
    lock(linear, angular)
    jumps = {link.name: LinkJump(linear[k], angular[k]) for k, link in enumerate(links)}
    return jumps
