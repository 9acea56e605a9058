"""Joints that mimic others, set free: bodies of their own whose speeds a row ties together.

M Δv = I of the tied robot is that of the free one with the rows v_follower − ratio v_leader
= 0, whose impulses do no work: the articulated bodies of the kernels need no other change.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

__all__ = ["Follower", "freed_model", "pointed_model"]

# Armature of what carries a point that varies: so heavy that no impulse moves it beside any body,
# and a number in single precision.
IMMOVABLE = 1e30


@dataclass(frozen=True)
class Follower:
    """A joint that mimics another: its coordinate is ratio times the leader's plus offset."""

    joint_id: int
    leader_id: int
    ratio: float
    offset: float


def freed_model(model: pin.Model) -> tuple[pin.Model, tuple[Follower, ...]]:
    """The model with joints of their own for those that mimic others, numbered alike.

    Raises:
        KeyError: a joint that mimics another in a way that is not linear.
    """
    ids = list(model.mimicking_joints)
    if not ids:
        return model, ()
    neutral = pin.neutral(model)
    followers = []
    freed = pin.Model()
    for joint_id in range(1, model.njoints):
        joint = model.joints[joint_id]
        if joint_id in ids:
            leader = model.mimicked_joints[ids.index(joint_id)]
            joint, follower = _freed(joint, neutral, joint_id, leader)
            if model.joints[leader].nq != 1:
                raise KeyError("JointModelMimic of a joint without ends")
            followers.append(follower)
        freed.addJoint(
            model.parents[joint_id], joint, model.jointPlacements[joint_id], model.names[joint_id]
        )
        freed.appendBodyToJoint(joint_id, model.inertias[joint_id], pin.SE3.Identity())
        if joint_id not in ids:
            own, given = freed.joints[joint_id], model.joints[joint_id]
            armature = model.armature[given.idx_v : given.idx_v + given.nv]
            freed.armature[own.idx_v : own.idx_v + own.nv] = armature
    return freed, tuple(followers)


def pointed_model(model: pin.Model, frames: Sequence[tuple[int, pin.SE3]]) -> pin.Model:
    """The model with a place of its own for each point that varies, behind all other joints.

    A place slides along the axes of its frame to where its three entries of q say; nothing
    moves it, so that it is as good as fixed to its body at any of these.

    Args:
        frames: by point, the joint that carries the frame, and the frame on it.
    """
    if not frames:
        return model
    model = pin.Model(model)
    for k, (joint_id, placement) in enumerate(frames):
        own = model.addJoint(joint_id, pin.JointModelTranslation(), placement, f"point {k}")
        joint = model.joints[own]
        model.armature[joint.idx_v : joint.idx_v + joint.nv] = IMMOVABLE
    return model


def _freed(
    joint: pin.JointModel, neutral: np.ndarray, joint_id: int, leader: int
) -> tuple[pin.JointModel, Follower]:
    data = joint.createData()
    joint.calc(data, neutral)
    mimic = joint.extract()
    subspace = np.asarray(data.S).reshape(-1)
    if subspace.shape != (6,) or not mimic.scaling:
        raise KeyError("JointModelMimic of another kind than revolute or prismatic")
    axis = subspace / mimic.scaling
    turns = np.abs(axis[3:]).max() > 0.5
    kind = pin.JointModelRevoluteUnaligned if turns else pin.JointModelPrismaticUnaligned
    direction = axis[3:] if turns else axis[:3]
    follower = Follower(joint_id, leader, float(mimic.scaling), float(mimic.offset))
    return kind(direction / np.linalg.norm(direction)), follower
