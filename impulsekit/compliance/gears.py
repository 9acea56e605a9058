"""Peak torques of gears in an impact, by their stiffness, against the limits of a catalogue."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ..display import OneLine
from ..errors import InputError, check_kind
from ..impact import Impact
from ..scene.numbers import positive

__all__ = ["GearPeak", "gear_peaks"]


@dataclass(frozen=True, repr=False)
class GearPeak(OneLine):
    """The peak torque of a gear in an impact.

    Attributes:
        joint: its name.
        jump: Δω of the joint in the impact [rad/s].
        torque: the peak torque at the output [N m], 0 or more.
        limit: the catalogue's limit of momentary torque [N m]; None if none was given.

    Example:
        >>> GearPeak("elbow", jump=1.0, torque=60.0, limit=80.0).share
        0.75
    """

    joint: str
    jump: float
    torque: float
    limit: float | None = None

    @property
    def share(self) -> float:
        """The torque over its limit; NaN without one."""
        return math.nan if self.limit is None else self.torque / self.limit


def gear_peaks(
    impact: Impact,
    stiffness: Mapping[str, float],
    *,
    inertia: Mapping[str, float] | None = None,
    limits: Mapping[str, float] | None = None,
) -> tuple[GearPeak, ...]:
    """Return the peak torques of gears, the largest share of its limit first.

    The links jump by Δω at once, and the rotor behind the gear follows through its torsional
    stiffness k. With the rotor's inertia J at the output (gear ratio squared times its own) all of
    its energy of relative motion goes into the gear, ½ J Δω² = τ²/(2k), so that τ = Δω √(kJ). It is
    a bound from above: what the gear holds back slows the links, too.

    Args:
        impact: a solved impact, in which these joints are free and carry no rotor, so that Δω is
            that of the links alone.
        stiffness: k by joint, at the output [N m/rad], of revolute joints.
        inertia: J by joint, at the output [kg m²]; by default the robot's armature.
        limits: torques of the catalogue by joint [N m].

    Raises:
        InputError: a joint without a single angle, or without inertia of a rotor.
        UnknownNameError, RangeError, NotFiniteError.

    Example:
        >>> from impulsekit import AppliedImpulse, Robot, Scene, solve
        >>> arm = Robot.from_example("ur5")
        >>> impact = solve(Scene(arm, [AppliedImpulse("tool0", linear=[0, 0, 5])]),
        ...                arm.neutral(), arm.velocity())
        >>> gear_peaks(impact, {"elbow_joint": 2e4}, inertia={"elbow_joint": 0.92})[0].joint
        'elbow_joint'
    """
    check_kind(impact, Impact, "gear_peaks")
    model, robot = impact.scene.robot.model, impact.scene.robot
    found = []
    for name, given in stiffness.items():
        joint = model.joints[robot.joint_id(name, "gear_peaks")]
        if joint.nv != 1:
            raise InputError(f'gear_peaks: joint "{name}" has no single angle')
        rotor = (inertia or {}).get(name, float(model.armature[joint.idx_v]))
        if not rotor:
            raise InputError(
                f'gear_peaks: no rotor is known behind joint "{name}"; give inertia= or '
                "robot.with_armature"
            )
        stiff = positive(given, f'gear_peaks: stiffness of "{name}"')
        turning = positive(rotor, f'gear_peaks: inertia of "{name}"')
        limit = None if limits is None or name not in limits else limits[name]
        if limit is not None:
            limit = positive(limit, f'gear_peaks: limit of "{name}"')
        jump = float(impact.dv[joint.idx_v])
        found.append(GearPeak(name, jump, abs(jump) * math.sqrt(stiff * turning), limit))
    shares = [-each.torque if each.limit is None else -each.share for each in found]
    return tuple(each for _, each in sorted(zip(shares, found, strict=True), key=lambda x: x[0]))
