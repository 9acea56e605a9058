"""Configurations outside the limits of joints."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

if TYPE_CHECKING:
    from .base import RobotBase

__all__ = ["likely_degrees", "outside_limits"]

# A joint this far past its limit is outside [rad, m]: what is typed in or measured is off by less.
OUTSIDE = 1e-6
# Whole multiples of the first up to the second are what people write of angles in degrees.
DEGREES = (15.0, 360.0)


def outside_limits(
    robot: RobotBase, q: np.ndarray, joints: Iterable[str] | None = None
) -> list[str]:
    """A sentence for every joint of one coordinate that q (nq,) puts outside its limits.

    Args:
        robot: the robot.
        q: (nq,) configuration.
        joints: those looked at; None for all that are not at their neutral value, which nobody
            chose.

    Example:
        >>> from impulsekit import Robot
        >>> panda = Robot.from_example("panda")
        >>> q = panda.neutral()
        >>> q[1] = 45
        >>> outside_limits(panda, q)
        ['joint "panda_joint2" is at 45 rad, outside -1.7628 to 1.7628 rad; degrees? 45° fits']
    """
    model = robot.model
    lower, upper = model.lowerPositionLimit, model.upperPositionLimit
    outside = np.flatnonzero((q < lower - OUTSIDE) | (q > upper + OUTSIDE)).tolist()
    if not outside:
        return []
    neutral = pin.neutral(model)
    chosen = None if joints is None else set(joints)
    sentences = []
    for joint, name in zip(model.joints, model.names, strict=True):
        # Limits of a free-flyer or of a cosine and sine say nothing of an angle.
        if joint.nq != 1 or joint.nv != 1 or joint.idx_q not in outside:
            continue
        i = joint.idx_q
        if q[i] == neutral[i] if chosen is None else name not in chosen:
            continue
        sentences.append(_sentence(name, float(q[i]), float(lower[i]), float(upper[i]), joint))
    return sentences


def likely_degrees(robot: RobotBase, values: Mapping[str, Any]) -> list[str]:
    """A sentence for every angle without limits that reads like degrees: 30, 45, 90, -180.

    Args:
        robot: the robot.
        values: by joint name, what was given; only single angles of continuous joints, and of
            joints whose limits are too far off to tell, are looked at.

    Example:
        >>> from impulsekit import Robot
        >>> arm = Robot.from_example("kinova")
        >>> likely_degrees(arm, {"j2s6s200_joint_1": 90})
        ['joint "j2s6s200_joint_1" is at 90 rad, which is 14.3 turns; degrees? 90° is 1.5708 rad']
    """
    sentences = []
    for name, value in values.items():
        joint = robot.model.joints[robot.joint_id(name)]
        if joint.nv != 1 or joint.shortname().startswith(("JointModelP", "JointModelH")):
            continue
        if isinstance(value, bool) or not isinstance(value, int | float | np.number):
            continue
        angle = float(value)
        if joint.nq == 1 and robot.model.upperPositionLimit[joint.idx_q] < DEGREES[1]:
            continue
        if DEGREES[0] <= abs(angle) <= DEGREES[1] and angle % DEGREES[0] == 0.0:
            sentences.append(
                f'joint "{name}" is at {angle:g} rad, which is {abs(angle) / math.tau:.1f} turns; '
                f"degrees? {angle:g}° is {math.radians(angle):.6g} rad"
            )
    return sentences


def _sentence(name: str, value: float, lower: float, upper: float, joint: pin.JointModel) -> str:
    slides = joint.shortname().startswith(("JointModelP", "JointModelHelical"))
    unit = "m" if slides else "rad"
    text = f'joint "{name}" is at {value:g} {unit}, outside {lower:g} to {upper:g} {unit}'
    # A number of degrees that is no likely angle in radians, and would be within the limits.
    if not slides and abs(value) > math.pi and lower <= math.radians(value) <= upper:
        text += f"; degrees? {value:g}° fits"
    return text
