"""Joint reaction impulses, in O(n).

With Δv known, the recursion of Newton and Euler over the tree, from the leaves to
the root, gives the wrench through every joint: the impulsive form of Chang & Huston
1995, eqs. (11), (12), where the gyroscopic couple has dropped out.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..robot import Robot
from ..robot.arrays import lock
from .forces import BodyImpulse, body_impulses

if TYPE_CHECKING:
    from ..robot.masses import Link
    from .touched import TouchedAnswer

__all__ = ["joint_reactions", "transmitted"]


def joint_reactions(impact: TouchedAnswer) -> dict[str, np.ndarray]:
    """By joint name, (6,) the wrench impulse the parent gives the child.

    At the joint's origin, in world axes, linear [N s] before angular [N m s]; it holds
    the joint's own impulse (a kick, a lock) as well. Fixed joints of the URDF are
    there too, and "root_joint" is what the ground gives a robot on a fixed base.
    """
    mechanics = impact.mechanics
    model = mechanics.model_without_gravity
    data = mechanics.scratch()
    impulses = list(body_impulses(impact))
    placements = [mechanics.joint_placement(joint_id) for joint_id in range(model.njoints)]
    motion = impact.q, np.zeros(model.nv), impact.dv
    return transmitted(impact.scene.robot, model, data, motion, placements, impulses)


def transmitted(
    robot: Robot,
    model: pin.Model,
    data: pin.Data,
    motion: tuple[np.ndarray, np.ndarray, np.ndarray],
    placements: Sequence[pin.SE3],
    impulses: Sequence[BodyImpulse],
) -> dict[str, np.ndarray]:
    """Return the impulse or force that every joint transmits, as in ``joint_reactions``.

    Args:
        robot: whose links and frames they are.
        model: the robot's, with the gravity that counts.
        data: of it, overwritten.
        motion: q, v and the accelerations; of an impact q, zero and Δv.
        placements: of the joints in the world.
        impulses: all that acts on bodies from outside them.
    """
    external = pin.StdVec_Force()
    for _ in range(model.njoints):
        external.append(pin.Force.Zero())
    for item in impulses:
        external[item.joint_id] = external[item.joint_id] + item.wrench_in_joint
    pin.rnea(model, data, *motion, external)
    reactions = {
        name: _in_world_axes(data.f[joint_id], placements[joint_id].rotation)
        for joint_id, name in enumerate(model.names)
        if joint_id > 0
    }
    reactions.update(_fixed_joint_reactions(robot, data, placements, impulses))
    reactions.update(_base_reactions(robot, data, placements, impulses))
    lock(*reactions.values())
    return reactions


def _in_world_axes(wrench: pin.Force, rotation: np.ndarray) -> np.ndarray:
    return np.concatenate([rotation @ wrench.linear, rotation @ wrench.angular])


def _needed_by(link: Link, data: pin.Data) -> pin.Force:
    """The wrench that moves a link as it moves, in the frame of its joint.

    ``data`` after ``rnea``, which leaves accelerations less gravity there.
    """
    inertia, velocity = link.spatial_inertia(), data.v[link.joint_id]
    return inertia * data.a_gf[link.joint_id] + velocity.cross(inertia * velocity)


def _fixed_joint_reactions(
    robot: Robot,
    data: pin.Data,
    placements: Sequence[pin.SE3],
    impulses: Sequence[BodyImpulse],
) -> dict[str, np.ndarray]:
    """The same for fixed joints, which Pinocchio merges away: link by link behind each."""
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
        add(link.frame_id, _needed_by(link, data))
    for frame in frames:
        if frame.type == pin.FrameType.JOINT and frame.parentJoint > 0:
            through = data.liMi[frame.parentJoint].act(data.f[frame.parentJoint])
            add(frame.parentFrame, through)
    for item in impulses:
        add(item.frame_id, -item.wrench_in_joint)
    return {
        frames[frame_id].name: _in_world_axes(
            pin.SE3(np.eye(3), frames[frame_id].placement.translation).actInv(wrench),
            placements[frames[frame_id].parentJoint].rotation,
        )
        for frame_id, wrench in wrenches.items()
    }


def _base_reactions(
    robot: Robot,
    data: pin.Data,
    placements: Sequence[pin.SE3],
    impulses: Sequence[BodyImpulse],
) -> dict[str, np.ndarray]:
    """Return the wrench of the ground on every fixed base, at its root link's origin."""
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
                total = total + (from_base * placements[joint_id]).act(data.f[joint_id])
        if data.a_gf[0].linear.any() and part.urdf is not None:
            for link in robot.links:
                if link.joint_id == 0 and link.name.startswith(part.prefix):
                    total = total + from_base.act(_needed_by(link, data))
        for item in impulses:
            name = model.frames[item.frame_id].name
            if item.joint_id == 0 and item.frame_id > 0 and name.startswith(part.prefix):
                total = total - from_base.act(item.wrench_in_joint)
        own = part.prefix + "root_joint"
        name = own if own not in taken else part.prefix + "world_root_joint"
        reactions[name] = np.concatenate([total.linear, total.angular])
    return reactions
