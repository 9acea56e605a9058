"""Joint loads in the joint's own axes: axial and shear force, bending moment, torque."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..errors import InputError
from ..formatting import Displayed, one_line
from ..robot.arrays import lock
from ..robot.placing import Posture

if TYPE_CHECKING:
    from .answer import Answer

__all__ = ["JointLoad", "joint_loads"]


# What a load is along and across the joint's axis.
PARTS = ("axial", "shear", "bending", "torque")
# Beside the largest, a smaller part is rounding and shown as 0.
FAINT_PART = 1e-12


@dataclass(frozen=True, eq=False, repr=False)
class JointLoad(Displayed):
    """The reaction impulse of a joint in the axes of the joint's frame, that of its child.

    The wrench is the one that the parent gives the child, at the joint's origin. Its parts are
    taken along the joint's axis: of a hinge or slider the one that it turns about or slides
    along, of a planar joint the normal of its plane. A fixed joint, a ball joint and a free one
    have no axis.

    Attributes:
        joint: its name.
        force: (3,) [N s], read-only. moment: (3,) [N m s], read-only.
        axis: (3,) unit vector in the same axes, read-only; None where the joint has none.
    """

    joint: str
    force: np.ndarray
    moment: np.ndarray
    axis: np.ndarray | None

    def __repr__(self) -> str:
        names = ("force", "moment") if self.axis is None else PARTS
        parts = {name: np.asarray(getattr(self, name)) for name in names}
        largest = max(float(np.abs(part).max()) for part in parts.values())
        parts = {n: np.where(np.abs(x) > FAINT_PART * largest, x, 0.0) for n, x in parts.items()}
        return one_line("JointLoad", repr(self.joint), **parts)

    @property
    def axial(self) -> float:
        """The force along the axis [N s]: of a slider, what its motor gives."""
        return float(self._axis @ self.force)

    @property
    def shear(self) -> float:
        """The size of the force across the axis [N s]."""
        return float(np.linalg.norm(self.force - self.axial * self._axis))

    @property
    def torque(self) -> float:
        """The moment about the axis [N m s]: of a hinge, what its motor gives."""
        return float(self._axis @ self.moment)

    @property
    def bending(self) -> float:
        """The size of the moment across the axis [N m s]."""
        return float(np.linalg.norm(self.moment - self.torque * self._axis))

    @property
    def _axis(self) -> np.ndarray:
        if self.axis is None:
            raise InputError(
                f'joint "{self.joint}" has no axis of its own; use force and moment, which are in '
                "the axes of its frame"
            )
        return self.axis


def joint_loads(impact: Answer, reactions: Mapping[str, np.ndarray]) -> dict[str, JointLoad]:
    """By joint name, its reaction in an impact in the joint's own axes."""
    robot = impact.scene.robot
    posture = Posture(robot, impact.q)
    fixed = {f.name: f for f in robot.model.frames if f.type == pin.FrameType.FIXED_JOINT}
    loads = {}
    for name, wrench in reactions.items():
        axis = None
        if name in robot.joint_names:
            joint_id = robot.joint_id(name)
            turn = posture.joint(joint_id).rotation
            axis = _axis_of(posture.motion_subspace(joint_id))
        elif name in fixed:
            frame = fixed[name]
            turn = posture.joint(frame.parentJoint).rotation @ frame.placement.rotation
        else:
            turn = _base_rotation(impact, name)
        parts = [turn.T @ wrench[:3], turn.T @ wrench[3:]]
        lock(*parts, axis)
        loads[name] = JointLoad(name, parts[0], parts[1], axis)
    return loads


def _axis_of(subspace: np.ndarray) -> np.ndarray | None:
    """(3,) the axis of a joint out of its motion subspace (6, n); None where it has none."""
    columns = subspace.T
    if len(columns) == 3:
        # A planar joint slides in two directions and turns about the third.
        turning = [column[3:] for column in columns if column[3:].any()]
        sliding = [column[:3] for column in columns if not column[3:].any()]
        return turning[0].copy() if len(turning) == 1 and len(sliding) == 2 else None
    if len(columns) != 1:
        return None
    way = columns[0, 3:] if columns[0, 3:].any() else columns[0, :3]
    length = float(np.linalg.norm(way))
    return way / length if length else None


def _base_rotation(impact: Answer, name: str) -> np.ndarray:
    """(3, 3) the axes of the base of a part that is fixed in the world."""
    parts = impact.scene.robot.parts
    part = max((p for p in parts if name.startswith(p.prefix)), key=lambda p: len(p.prefix))
    return np.eye(3) if part.placement is None else np.array(part.placement)[:3, :3]
