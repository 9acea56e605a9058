"""What each generalized speed is: its joint, its direction and its unit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..robot import Robot
from ..robot.placing import Posture

__all__ = ["TURNS", "Speed", "speeds_of"]

# [rad] of a unit of speed: a joint whose axis turns by less slides; axes are unit vectors or zero.
TURNS = 1e-12


@dataclass(frozen=True)
class Speed:
    """One entry of v.

    Attributes:
        joint: the joint's name.
        component: "" in a joint with one degree of freedom; else the direction in the
            joint's own axes, such as "vx" or "wz".
        unit: "m/s" or "rad/s".
    """

    joint: str
    component: str
    unit: str

    @property
    def title(self) -> str:
        """The joint, with the component where it has several."""
        return f"{self.joint} {self.component}".rstrip()


def speeds_of(robot: Robot, q: np.ndarray) -> tuple[Speed, ...]:
    """The generalized speeds of a robot, in the order of v.

    A speed whose column of the motion subspace at ``q`` turns the child is in rad/s, one
    that only shifts it in m/s.
    """
    model = robot.model
    posture = Posture(robot, q)
    speeds: list[Speed] = []
    for joint_id in range(1, model.njoints):
        joint = model.joints[joint_id]
        for column in posture.motion_subspace(joint_id).T:
            turns = np.abs(column[3:]).max() > TURNS
            axis = "xyz"[int(np.argmax(np.abs(column[3:] if turns else column[:3])))]
            component = "" if joint.nv == 1 else ("w" if turns else "v") + axis
            unit = "rad/s" if turns else "m/s"
            speeds.append(Speed(model.names[joint_id], component, unit))
    return tuple(speeds)
