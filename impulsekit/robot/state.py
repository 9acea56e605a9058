"""Configurations and velocities by joint name, their checks, and the limits of joints."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ..errors import (
    InputError,
    NotFiniteError,
    RangeError,
    ShapeError,
    StateError,
)
from .arrays import array_of, floats, no_numbers, real_numbers

if TYPE_CHECKING:
    from .base import RobotBase

# How far a planar part may be asked out of its plane [m; as a turn, rad]: frames of robots are
# placed to some 1e-12, positions measured by hand to no better than 1e-6.
OUT_OF_PLANE = 1e-6
# A joint this far past its limit is outside [rad, m]: what is typed in or measured is off by less.
OUTSIDE = 1e-6
# Whole multiples of the first up to the second are what people write of angles in degrees.
DEGREES = (15.0, 360.0)


def outside_limits(
    robot: RobotBase, q: np.ndarray, joints: Iterable[str] | None = None
) -> list[str]:
    """Return a sentence for each joint of one coordinate that q (nq,) puts past its limits.

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


def likely_wxyz(robot: RobotBase, q: np.ndarray) -> list[str]:
    """Return a sentence for each free-flyer or ball joint whose quaternion reads like wxyz.

    Example:
        >>> from impulsekit import Robot
        >>> talos = Robot.from_example("talos", root="freeflyer")
        >>> likely_wxyz(talos, np.r_[0, 0, 1, 1, 0, 0, 0, np.zeros(talos.nq - 7)])[0][:45]
        'joint "root_joint": its quaternion is 1, 0, 0'
    """
    return [
        f'joint "{name}": its quaternion is 1, 0, 0, 0, in the order x, y, z, w half a turn about '
        "x; no turn is 0, 0, 0, 1 (impulsekit.pose takes wxyz=)"
        for name, first in robot.quaternions
        if q[first : first + 4].tolist() == [1, 0, 0, 0]
    ]


def likely_degrees(robot: RobotBase, values: Mapping[str, Any]) -> list[str]:
    """Return a sentence for each angle without limits that reads like degrees: 30, 45, 90.

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


# How far a quaternion or a (cos, sin) pair may be off unit length.
QUATERNION_TOLERANCE = 1e-6
# Laws of contact multiply velocities; the squares of larger ones may overflow.
FASTEST = 1e153
# Of the tolerance on the square of a length, for the length: half, less what rounding takes.
OF_LENGTH = 0.4


def configuration(robot: RobotBase, values: Mapping[str, Any]) -> np.ndarray:
    """Return (nq,) the neutral configuration with the named joints set.

    A joint takes as many numbers as it has entries in q. A continuous joint also
    takes its angle [rad], a planar one (x, y, angle); a free-flyer and a planar one a ``pin.SE3``.
    """
    model = robot.model
    q = pin.neutral(model)
    for name, value in values.items():
        joint = model.joints[robot.joint_id(name)]
        q[joint.idx_q : joint.idx_q + joint.nq] = _joint_configuration(joint, name, value)
    return checked_configuration(model, q)


def velocity(robot: RobotBase, values: Mapping[str, Any]) -> np.ndarray:
    """Return (nv,) zero but for the named joints."""
    model = robot.model
    v = np.zeros(model.nv)
    for name, value in values.items():
        joint = model.joints[robot.joint_id(name)]
        entries = _numbers(value, f'velocity of joint "{name}"')
        if entries.size != joint.nv:
            raise ShapeError.of(f'velocity of joint "{name}"', (joint.nv,), entries.shape)
        v[joint.idx_v : joint.idx_v + joint.nv] = entries
    return checked_velocity(model, v)


def checked_configuration(model: pin.Model, q: Any) -> np.ndarray:
    """Return a copy of q as (nq,) floats, proved finite and on its manifold.

    Raises:
        ShapeError, NotFiniteError, StateError: each names the joint.
    """
    q = _vector(q, model.nq, "configuration q")
    _check_finite(model, q, "configuration q", "idx_q", "nq")
    if not pin.isNormalized(model, q, QUATERNION_TOLERANCE):
        raise _off_unit(model, q)
    return q


def checked_velocity(model: pin.Model, v: Any) -> np.ndarray:
    """Return a copy of v as (nv,) floats, proved finite."""
    v = _vector(v, model.nv, "velocity v")
    _check_finite(model, v, "velocity v", "idx_v", "nv")
    return v


def refuse_overflow(v: np.ndarray) -> None:
    """Refuse velocities that no law of contact can multiply.

    Raises:
        RangeError: an entry beyond FASTEST.
    """
    largest = float(np.abs(v).max(initial=0.0))
    if largest > FASTEST:
        allowed = f"{FASTEST:g} at most where contacts or constraints act"
        raise RangeError.of("velocity v: its largest entry", largest, allowed)


def _joint_configuration(joint: pin.JointModel, name: str, value: Any) -> np.ndarray:
    if isinstance(value, pin.SE3):
        return _of_pose(joint, name, value)
    entries = _numbers(value, f'configuration of joint "{name}"')
    if entries.size == joint.nq:
        return entries
    kind = joint.shortname()
    if entries.size == 1 and joint.nq == 2 and joint.nv == 1:
        return np.array([math.cos(entries[0]), math.sin(entries[0])])
    if entries.size == 3 and kind == "JointModelPlanar":
        return np.array([entries[0], entries[1], math.cos(entries[2]), math.sin(entries[2])])
    hint = ""
    if joint.nq == 2 and joint.nv == 1:
        hint = "cosine and sine, or the angle alone"
    elif kind == "JointModelPlanar":
        hint = "x, y, cosine and sine, or x, y and the angle"
    elif kind == "JointModelFreeFlyer":
        hint = "x, y, z and the quaternion x, y, z, w; impulsekit.pose makes it of other forms"
    elif kind == "JointModelSpherical":
        hint = "the quaternion x, y, z, w"
    raise ShapeError.of(f'configuration of joint "{name}"', (joint.nq,), entries.shape, hint)


def _of_pose(joint: pin.JointModel, name: str, pose: pin.SE3) -> np.ndarray:
    """The numbers of a joint that is to have a pose."""
    kind = joint.shortname()
    if kind == "JointModelFreeFlyer":
        return np.array(pin.SE3ToXYZQUAT(pose))
    if kind != "JointModelPlanar":
        raise InputError(
            f'joint "{name}" ({kind}) takes numbers; free-flyers and planar joints take a pose'
        )
    x, y, z = pose.translation
    off = max(abs(z), float(np.abs(pose.rotation[:, 2] - [0.0, 0.0, 1.0]).max()))
    if off > OUT_OF_PLANE:
        what = f'pose of planar joint "{name}": the way or turn out of its plane'
        raise RangeError.of(what, f"{off:.6g}", f"within {OUT_OF_PLANE:g} m, rad")
    cosine, sine = pose.rotation[:2, 0] / np.linalg.norm(pose.rotation[:2, 0])
    return np.array([x, y, cosine, sine])


def _numbers(value: Any, what: str) -> np.ndarray:
    entries = np.atleast_1d(floats(value, what))
    return array_of(entries, (entries.size,), what)


def _vector(value: Any, size: int, what: str) -> np.ndarray:
    try:
        vector = real_numbers(value)
    except (TypeError, ValueError, OverflowError):
        raise no_numbers(value, what, f"{size} ") from None
    if value is None:
        raise no_numbers(value, what, f"{size} ")
    if vector.shape != (size,):
        raise ShapeError.of(what, (size,), vector.shape)
    return vector


def _check_finite(model: pin.Model, vector: np.ndarray, what: str, start: str, count: str) -> None:
    bad = np.flatnonzero(~np.isfinite(vector))
    if bad.size:
        index = int(bad[0])
        name = next(
            name
            for name, joint in zip(model.names, model.joints, strict=True)
            if getattr(joint, start) <= index < getattr(joint, start) + getattr(joint, count)
        )
        raise NotFiniteError.of(what, f'entry {index} (joint "{name}")', vector[index])


def _off_unit(model: pin.Model, q: np.ndarray) -> StateError:
    for name, joint in zip(model.names, model.joints, strict=True):
        entries = q[joint.idx_q : joint.idx_q + joint.nq]
        kind = joint.shortname()
        if kind in ("JointModelFreeFlyer", "JointModelSpherical"):
            unit, what = entries[-4:], "quaternion"
        elif joint.nq == joint.nv + 1 and joint.nq in (2, 4):
            unit, what = entries[-2:], "(cosine, sine) pair"
        else:
            continue
        length = float(np.linalg.norm(unit))
        if abs(length - 1.0) > OF_LENGTH * QUATERNION_TOLERANCE:
            return StateError(
                f'configuration q: the {what} of joint "{name}" has length {length:.9g}, '
                f"expected 1 within {QUATERNION_TOLERANCE:g}",
                joint=name,
                value=length,
            )
    return StateError("configuration q is off its manifold", joint="", value=None)
