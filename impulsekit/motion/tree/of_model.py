"""The compiled tree of a model, and room for its states."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from ...geometry.point_table import Kinematics
from ...laws.half import Factor
from ...laws.rank_tolerances import SMALLEST_PIVOT
from .bodies import BALL, CIRCLE, FREE, PLANAR, SLIDE, TRANSLATION, TURN, Room, Tree
from .memory import order_of_speeds

__all__ = ["KINDS", "room_of", "tree_of"]

# By Pinocchio's names of joints.
KINDS = {
    **{f"JointModelR{axis}": TURN for axis in "XYZ"},
    "JointModelRevoluteUnaligned": TURN,
    **{f"JointModelRUB{axis}": CIRCLE for axis in "XYZ"},
    "JointModelRevoluteUnboundedUnalignedTpl": CIRCLE,
    "JointModelRevoluteUnboundedUnaligned": CIRCLE,
    **{f"JointModelP{axis}": SLIDE for axis in "XYZ"},
    "JointModelPrismaticUnaligned": SLIDE,
    "JointModelSpherical": BALL,
    "JointModelFreeFlyer": FREE,
    "JointModelPlanar": PLANAR,
    "JointModelTranslation": TRANSLATION,
}


def tree_of(model: pin.Model) -> Tree | None:
    """The tree of a model; None where some joint is of another kind."""
    kinds = [KINDS.get(joint.shortname()) for joint in list(model.joints)[1:]]
    if None in kinds or not model.nv:
        return None
    joints = np.zeros((model.njoints, 5), dtype=np.int64)
    numbers, columns = np.zeros((model.njoints, 25)), np.zeros((model.nv, 6))
    data = model.createData()
    # A joint's directions are known once it was placed.
    pin.forwardKinematics(model, data, pin.neutral(model))
    for j, kind in enumerate(kinds, 1):
        joint, place, body = model.joints[j], model.jointPlacements[j], model.inertias[j]
        joints[j] = model.parents[j], kind, joint.idx_q, joint.idx_v, joint.nv
        own = np.array(data.joints[j].S).reshape(6, joint.nv)
        columns[joint.idx_v : joint.idx_v + joint.nv] = own.T
        numbers[j, :9], numbers[j, 9:12] = place.rotation.T.ravel(), place.translation
        numbers[j, 12:15] = own[:3, 0] if kind == SLIDE else own[3:, -1]
        arm = np.array(body.lever)
        about = body.inertia + body.mass * (arm.dot(arm) * np.eye(3) - np.outer(arm, arm))
        numbers[j, 15], numbers[j, 16:19] = body.mass, body.mass * arm
        numbers[j, 19:] = about[np.triu_indices(3)]
    return Tree(joints, numbers, columns, np.array(model.armature), np.array(model.gravity.linear))


def room_of(model: pin.Model) -> Room:
    """Room for the states of a model's tree."""
    count, nv = model.njoints, model.nv
    last, before, branch = order_of_speeds(model)
    places = np.zeros((count, 12))
    places[0, [0, 4, 8]] = 1.0
    kinematics = Kinematics(
        places, np.zeros((count, 6)), np.zeros((count, 6)), np.zeros((nv, 6)), last, before
    )
    square = np.zeros((2, nv, nv))
    factor = Factor(square[0], np.zeros(nv), square[1], branch, SMALLEST_PIVOT)
    return Room(
        kinematics, factor, np.zeros((count, 12)), np.zeros((count, 10)), np.zeros((count, 6))
    )
