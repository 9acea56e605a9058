"""``flat_model``: a robot's model as the native core takes it."""

from __future__ import annotations

import weakref
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ..._core import Bodies, Joint, Model
from ..._core import Site as CoreSite
from ...errors import InputError

if TYPE_CHECKING:
    from ...robot import Robot
    from ...rows.entries import Site

__all__ = ["FlatModel", "flat_model", "flat_model_of", "inertia_numbers"]

_KINDS = {
    **{f"JointModelR{axis}": Joint.angle for axis in "XYZ"},
    "JointModelRevoluteUnaligned": Joint.angle,
    **{f"JointModelRUB{axis}": Joint.circle for axis in "XYZ"},
    "JointModelRevoluteUnboundedUnaligned": Joint.circle,
    "JointModelRevoluteUnboundedUnalignedTpl": Joint.circle,
    **{f"JointModelP{axis}": Joint.slide for axis in "XYZ"},
    "JointModelPrismaticUnaligned": Joint.slide,
    **{f"JointModelH{axis}": Joint.angle for axis in "XYZ"},
    "JointModelHelicalUnaligned": Joint.angle,
    "JointModelSpherical": Joint.ball,
    "JointModelFreeFlyer": Joint.free,
    "JointModelPlanar": Joint.planar,
    "JointModelTranslation": Joint.translation,
    "JointModelEllipsoid": Joint.ellipsoid,
}
_NOTHING = {"mass": 0.0, "moment": np.zeros(3), "inertia": np.zeros(6)}
# Of the core's bodies, and their types.
COLUMNS = (
    *((name, np.intc) for name in ("parent", "joint", "q", "v")),
    *((name, float) for name in ("axis", "rotation", "shift", "mass", "moment", "inertia")),
    *((name, float) for name in ("pitch", "ratio", "offset")),
)


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

    def rotations(self, q: np.ndarray) -> np.ndarray:
        """(njoints, 3, 3) the axes of the joints' frames in the world at q."""
        places = self.core.placements(q).reshape(-1, 12)
        return places[list(self.bodies), :9].reshape(-1, 3, 3)

    def site(self, site: Site) -> CoreSite:
        """A point of a frame in the core."""
        frame = site.frame
        body = self.bodies[frame.joint_id]
        return CoreSite.of(body, frame.frame_id, site.point, frame.rotation)


@dataclass(frozen=True)
class _Part:
    """One of the joints that a joint of Pinocchio is made of."""

    kind: Joint
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
    rows: list[dict[str, Any]] = []
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
            here = place * part.placement if k == 0 else part.placement
            rows.append(
                {
                    "parent": above, "joint": part.kind, "q": part.q, "v": part.v,
                    "axis": part.axis, "rotation": here.rotation, "shift": here.translation,
                    **(inertia_numbers(model.inertias[joint_id]) if last else _NOTHING),
                    "pitch": part.pitch, "ratio": part.ratio, "offset": part.offset,
                }
            )  # fmt: skip
            above = len(rows)
        bodies.append(above)
    columns = {name: np.array([row[name] for row in rows], dtype=kind) for name, kind in COLUMNS}
    core = Model(Bodies(**columns), np.array(model.armature, dtype=float), model.nq)
    return FlatModel(core, tuple(bodies))


def inertia_numbers(inertia: pin.Inertia) -> dict[str, Any]:
    """Mass, first moment (3,) and inertia (6,) about the joint (xx, xy, xz, yy, yz, zz)."""
    about = inertia.matrix()[3:, 3:]
    return {
        "mass": float(inertia.mass),
        "moment": inertia.mass * inertia.lever,
        "inertia": about[np.triu_indices(3)],
    }


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
            _Part(Joint.angle, own.axis1, placement, q, v),
            _Part(Joint.angle, own.axis2, none, q + 1, v + 1),
        ]
    if kind == "JointModelSphericalZYX":
        places = (placement, pin.SE3.Identity(), pin.SE3.Identity())
        axes = np.eye(3)[::-1]
        return [
            _Part(Joint.angle, axis, place, q + i, v + i)
            for i, (axis, place) in enumerate(zip(axes, places, strict=True))
        ]
    if kind not in _KINDS:
        raise InputError(f'joint "{name}": a {kind} is not known here')
    pitch = float(getattr(own, "pitch", 0.0))
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
        kind, axis, pitch = Joint.slide, along[:3], 0.0
    else:
        kind, axis = Joint.angle, along[3:] / turn
        pitch = float(along[:3] @ axis)
    return [
        _Part(
            kind, axis, pin.SE3.Identity(), leader.idx_q, leader.idx_v, pitch,
            float(mimic.scaling), float(mimic.offset),
        )
    ]  # fmt: skip
