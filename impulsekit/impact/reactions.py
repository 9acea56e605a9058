"""Joint reaction impulses: what every joint has to bear, in O(n).

With Δv known, the recursion of Newton and Euler over the tree, from the leaves to
the root, gives the wrench through every joint: the impulsive form of Chang & Huston
1995, eqs. (11), (12), where the gyroscopic couple has dropped out.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from .forces import BodyImpulse, body_impulses

if TYPE_CHECKING:
    from .result import Impact

__all__ = ["joint_reactions"]


def joint_reactions(impact: Impact) -> dict[str, np.ndarray]:
    """By joint name, (6,) the wrench impulse the parent gives the child.

    At the joint's origin, in world axes, linear [N s] before angular [N m s]; it holds
    the joint's own impulse (a kick, a lock) as well. Fixed joints of the URDF are
    there too, and "root_joint" is what the ground gives a robot on a fixed base.
    """
    model = impact.mechanics.model_without_gravity
    data = impact.mechanics.scratch()
    impulses = list(body_impulses(impact))
    external = pin.StdVec_Force()
    for _ in range(model.njoints):
        external.append(pin.Force.Zero())
    for item in impulses:
        external[item.joint_id] = external[item.joint_id] + item.wrench_in_joint
    pin.rnea(model, data, impact.q, np.zeros(model.nv), impact.dv, external)
    rotations = impact.mechanics.joint_rotations
    reactions = {
        name: _in_world_axes(data.f[joint_id], rotations[joint_id])
        for joint_id, name in enumerate(model.names)
        if joint_id > 0
    }
    reactions.update(_fixed_joint_reactions(impact, data, impulses))
    reactions.update(_base_reactions(impact, data, impulses))
    for reaction in reactions.values():
        reaction.setflags(write=False)
    return reactions


def _in_world_axes(wrench: pin.Force, rotation: np.ndarray) -> np.ndarray:
    return np.concatenate([rotation @ wrench.linear, rotation @ wrench.angular])


def _fixed_joint_reactions(
    impact: Impact, data: pin.Data, impulses: list[BodyImpulse]
) -> dict[str, np.ndarray]:
    """The same for fixed joints, which Pinocchio merges away: link by link behind each."""
    robot = impact.scene.robot
    frames = robot.model.frames
    fixed = [
        frame_id
        for frame_id, frame in enumerate(frames)
        if frame_id > 0 and frame.type == pin.FrameType.FIXED_JOINT
    ]
    if not fixed or any(part.urdf is None for part in robot.parts):
        return {}
    wrenches = {frame_id: pin.Force.Zero() for frame_id in fixed}

    def add(frame_id: int, wrench: pin.Force) -> None:
        """Give a wrench, in the frame of the joint, to all fixed joints it passes through."""
        joint_id = frames[frame_id].parentJoint
        while frame_id > 0 and frames[frame_id].parentJoint == joint_id:
            if frame_id in wrenches:
                wrenches[frame_id] = wrenches[frame_id] + wrench
            frame_id = frames[frame_id].parentFrame

    for link in robot.links:
        # Without gravity and speeds, rnea leaves Δ of the twist of each joint's body here.
        change = data.a_gf[link.joint_id] if link.joint_id > 0 else pin.Motion.Zero()
        add(link.frame_id, link.spatial_inertia() * change)
    for frame in frames:
        if frame.type == pin.FrameType.JOINT and frame.parentJoint > 0:
            through = data.liMi[frame.parentJoint].act(data.f[frame.parentJoint])
            add(frame.parentFrame, through)
    for item in impulses:
        add(item.frame_id, -item.wrench_in_joint)
    rotations = impact.mechanics.joint_rotations
    return {
        frames[frame_id].name: _in_world_axes(
            pin.SE3(np.eye(3), frames[frame_id].placement.translation).actInv(wrench),
            rotations[frames[frame_id].parentJoint],
        )
        for frame_id, wrench in wrenches.items()
    }


def _base_reactions(
    impact: Impact, data: pin.Data, impulses: list[BodyImpulse]
) -> dict[str, np.ndarray]:
    """What the ground gives every robot on a fixed base, at its root link's origin."""
    robot = impact.scene.robot
    model = robot.model
    taken = {frame.name for frame in model.frames}
    reactions = {}
    for part in robot.parts:
        if part.root != "fixed":
            continue
        base = np.eye(4) if part.placement is None else np.array(part.placement)
        # From the base's own origin, so that a base far away costs no digits.
        from_base = pin.SE3(np.eye(3), base[:3, 3]).inverse()
        total = pin.Force.Zero()
        for joint_id in range(1, model.njoints):
            if model.parents[joint_id] == 0 and model.names[joint_id].startswith(part.prefix):
                placement = impact.mechanics.joint_placement(joint_id)
                total = total + (from_base * placement).act(data.f[joint_id])
        for item in impulses:
            name = model.frames[item.frame_id].name
            if item.joint_id == 0 and item.frame_id > 0 and name.startswith(part.prefix):
                total = total - from_base.act(item.wrench_in_joint)
        own = part.prefix + "root_joint"
        name = own if own not in taken else part.prefix + "world_root_joint"
        reactions[name] = np.concatenate([total.linear, total.angular])
    return reactions
