"""``flat_model``: a robot's model as the native core takes it."""

from __future__ import annotations

import weakref
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ..._core import Model
from ...errors import InputError

if TYPE_CHECKING:
    from ...robot import Robot

__all__ = ["FlatModel", "body_numbers", "flat_model", "flat_model_of"]

# As ``core/spatial/model.hpp`` numbers joints.
ANGLE, CIRCLE, SLIDE, HELIX, BALL, FREE, PLANAR, TRANSLATION, ELLIPSOID = range(9)
_KINDS = {
    **{f"JointModelR{axis}": ANGLE for axis in "XYZ"},
    "JointModelRevoluteUnaligned": ANGLE,
    **{f"JointModelRUB{axis}": CIRCLE for axis in "XYZ"},
    "JointModelRevoluteUnboundedUnaligned": CIRCLE,
    "JointModelRevoluteUnboundedUnalignedTpl": CIRCLE,
    **{f"JointModelP{axis}": SLIDE for axis in "XYZ"},
    "JointModelPrismaticUnaligned": SLIDE,
    **{f"JointModelH{axis}": HELIX for axis in "XYZ"},
    "JointModelHelicalUnaligned": HELIX,
    "JointModelSpherical": BALL,
    "JointModelFreeFlyer": FREE,
    "JointModelPlanar": PLANAR,
    "JointModelTranslation": TRANSLATION,
    "JointModelEllipsoid": ELLIPSOID,
}
_NOTHING = np.zeros(10)


@dataclass(frozen=True, eq=False)
class FlatModel:
    """A model in the core.

    Attributes:
        core: the model.
        bodies: (njoints,) the core's body behind each joint; the last of those that a joint of
            several is made of.
    """

    core: Model
    bodies: tuple[int, ...]


@dataclass(frozen=True)
class _Part:
    """One of the joints that a joint of Pinocchio is made of."""

    kind: int
    axis: Any
    placement: pin.SE3
    q: int
    v: int
    pitch: float = 0.0
    ratio: float = 1.0
    offset: float = 0.0


def flat_model_of(robot: Robot) -> FlatModel:
    """The model of a robot in the core, made once.

    Raises:
        InputError: a joint of a kind that the core does not know.
    """
    found = _by_robot.get(id(robot))
    if found is None:
        found = _by_robot[id(robot)] = flat_model(robot.model)
        weakref.finalize(robot, _by_robot.pop, id(robot), None)
    return found


_by_robot: dict[int, FlatModel] = {}


def flat_model(model: pin.Model) -> FlatModel:
    """The model in the core.

    Raises:
        InputError: a joint of a kind that the core does not know.
    """
    ints: list[tuple[int, int, int, int]] = []
    numbers: list[np.ndarray] = []
    bodies = [0]
    leaders = dict(zip(model.mimicking_joints, model.mimicked_joints, strict=True))
    for joint_id in range(1, model.njoints):
        joint, name = model.joints[joint_id], model.names[joint_id]
        if joint_id in leaders:
            parts = _following(joint, model.joints[leaders[joint_id]], name)
        else:
            parts = _parts(joint, pin.SE3.Identity(), joint.idx_q, joint.idx_v, name)
        above, place = bodies[model.parents[joint_id]], model.jointPlacements[joint_id]
        for k, part in enumerate(parts):
            last = k == len(parts) - 1
            ints.append((above, part.kind, part.q, part.v))
            inertia = body_numbers(model.inertias[joint_id]) if last else _NOTHING
            here = place * part.placement if k == 0 else part.placement
            numbers.append(
                np.concatenate(
                    [part.axis, here.rotation.ravel(), here.translation, inertia,
                     (part.pitch, part.ratio, part.offset)]
                )
            )  # fmt: skip
            above = len(ints)
        bodies.append(above)
    core = Model(
        np.array(ints, dtype=np.intc).reshape(-1, 4),
        np.array(numbers, dtype=float).reshape(-1, 28),
        np.array(model.armature, dtype=float),
        model.nq,
    )
    return FlatModel(core, tuple(bodies))


def body_numbers(inertia: pin.Inertia) -> np.ndarray:
    """(10,) mass, first moment and inertia about the joint (xx, xy, xz, yy, yz, zz)."""
    about = inertia.matrix()[3:, 3:]
    return np.array([inertia.mass, *(inertia.mass * inertia.lever), *about[np.triu_indices(3)]])


def _parts(joint: Any, placement: pin.SE3, q: int, v: int, name: str) -> list[_Part]:
    """Return the elementary joints of a joint, the first at ``placement``."""
    own = joint.extract() if type(joint) is pin.JointModel else joint
    kind = own.shortname()
    if kind == "JointModelComposite":
        found: list[_Part] = []
        for inner, place in zip(own.joints, own.jointPlacements, strict=True):
            start = placement * place if not found else place
            found += _parts(inner, start, q, v, name)
            q, v = q + inner.nq, v + inner.nv
        return found
    if kind == "JointModelUniversal":
        none = pin.SE3.Identity()
        return [
            _Part(ANGLE, own.axis1, placement, q, v),
            _Part(ANGLE, own.axis2, none, q + 1, v + 1),
        ]
    if kind == "JointModelSphericalZYX":
        places = (placement, pin.SE3.Identity(), pin.SE3.Identity())
        axes = np.eye(3)[::-1]
        return [
            _Part(ANGLE, axis, place, q + i, v + i)
            for i, (axis, place) in enumerate(zip(axes, places, strict=True))
        ]
    if kind not in _KINDS:
        raise InputError(f'joint "{name}": a {kind} is not known here')
    pitch = float(own.pitch) if _KINDS[kind] == HELIX else 0.0
    return [_Part(_KINDS[kind], _axis(own, kind), placement, q, v, pitch)]


def _axis(own: Any, kind: str) -> Any:
    """(3,) the axis of a joint that has one, the radii of an ellipsoid."""
    if kind == "JointModelEllipsoid":
        return np.array([own.radius_x, own.radius_y, own.radius_z])
    if kind[-1] in "XYZ":
        return np.eye(3)["XYZ".index(kind[-1])]
    if hasattr(own, "axis"):
        return own.axis
    if own.nv > 1:
        return np.zeros(3)
    data = own.createData()
    own.calc(data, np.eye(own.nq)[0])
    return np.asarray(data.S).reshape(6)[3:]


def _following(joint: Any, leader: Any, name: str) -> list[_Part]:
    """Return the elementary joints of one that follows another: q = scaling q' + offset."""
    mimic = joint.extract()
    data = joint.createData()
    # Its directions are known once it was placed.
    joint.calc(data, np.zeros(max(leader.idx_q + leader.nq, 1)))
    along = np.asarray(data.S).reshape(-1)
    if leader.nq != 1 or along.shape != (6,) or not mimic.scaling:
        raise InputError(f'joint "{name}": it follows another in a way that is not known here')
    along = along / mimic.scaling
    turn = float(np.linalg.norm(along[3:]))
    if turn < 0.5:
        kind, axis, pitch = SLIDE, along[:3], 0.0
    else:
        axis = along[3:] / turn
        pitch = float(along[:3] @ axis)
        kind = HELIX if pitch else ANGLE
    return [
        _Part(
            kind, axis, pin.SE3.Identity(), leader.idx_q, leader.idx_v, pitch,
            float(mimic.scaling), float(mimic.offset),
        )
    ]  # fmt: skip
