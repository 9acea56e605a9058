"""MJCF: MuJoCo compiles the file, and a Pinocchio model is built from its arrays.

Pinocchio's own reader of MJCF takes the first tree of a file only and reads masses and
defaults of some files otherwise than MuJoCo does; MuJoCo's compiler is what defines MJCF.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator
from typing import Any

import numpy as np
import pinocchio as pin

from ..errors import MissingExtraError, MjcfError, a_thing, shown
from .mjcf_shapes import pairs_of, rotation_of, shapes_of
from .model_checks import root_joint
from .robot_xml import content_of
from .source import Loop


def read_mjcf(source: Any) -> tuple[Any, str | None]:
    """Return the ``mujoco.MjModel`` of a file, of MJCF text or as it is, and the path.

    Raises:
        MjcfError: MuJoCo refuses it; the sentence holds its reason.
        MissingExtraError: the package mujoco is not installed.
    """
    with MissingExtraError.unless("mujoco", "mjcf", "reading MJCF"):
        import mujoco
    if isinstance(source, mujoco.MjModel):
        return source, None
    if isinstance(source, mujoco.MjSpec):
        return _compiled(source.compile, "the MjSpec"), None
    if isinstance(source, str) and source.lstrip().startswith("<"):
        return _compiled(lambda: mujoco.MjModel.from_xml_string(source), "MJCF text"), None
    if not isinstance(source, str | os.PathLike):
        raise MjcfError(
            f"from_mjcf takes a path, MJCF text or a mujoco.MjModel, got {a_thing(source)}",
            source="",
            element="",
        )
    path = os.fspath(source)
    content_of(path, MjcfError)
    return _compiled(lambda: mujoco.MjModel.from_xml_path(path), path), os.path.abspath(path)


def _compiled(compile_it: Any, source: str) -> Any:
    try:
        return compile_it()
    except Exception as error:  # MuJoCo raises ValueError, its FatalError and more
        reason = " ".join(str(error).split())
        raise MjcfError(
            f"{source}: MuJoCo refuses it: {shown(reason, 200)}", source=source, element=""
        ) from None


# Equality constraints of MuJoCo, by number.
_CONNECT, _WELD, _JOINT = 0, 1, 2
_EQUALITIES = ("connect", "weld", "joint", "tendon", "flex", "flexvert", "flexstrain")
_FREE, _BALL, _SLIDE, _HINGE = range(4)
# Speeds of a joint, by MuJoCo's number of its kind.
_SPEEDS = (6, 3, 1, 1)
# Where a weld says how stiff it is against turns.
_TORQUE_SCALE = 10
# A joint's axis counts as a coordinate axis when it is one to this relative rounding error.
_ON_AXIS = 4 * np.finfo(float).eps


class MjcfRobot:
    """A robot built from a ``mujoco.MjModel``.

    Attributes:
        model: the ``pin.Model``. Its q is MuJoCo's qpos with quaternions as x, y, z, w;
            its v is MuJoCo's qvel with the linear velocity of free joints in body axes.
        name: the model's name.
        loops: the equality constraints as plain data.
        shapes: the geoms as plain data.
        pairs: which geoms may touch.
        assumptions: what of the file has no place in the model, by name.
    """

    def __init__(self, mj: Any, root: str | None) -> None:
        self._mj = mj
        self.model = pin.Model()
        self.name = _text(mj, 0) or "robot"
        self.model.name = self.name
        self.model.gravity.linear = np.array(mj.opt.gravity)
        self._joint_of_body = [0] * mj.nbody
        self._in_joint = [pin.SE3.Identity() for _ in range(mj.nbody)]
        self._frame_of_body = ["world"] * mj.nbody
        self._frame_of_site: list[str] = []
        self._root = root
        self.assumptions: list[str] = []
        self._refuse()
        # "world" comes first, whose frame is there already.
        self._body_names = self._free_names("body", [mj.body(i).name for i in range(mj.nbody)])
        self._joint_names = self._free_names("joint", [mj.joint(i).name for i in range(mj.njnt)])
        for body in range(1, mj.nbody):
            self._add_body(body)
        self._add_sites()
        self.loops = tuple(self._loops())
        self.shapes = shapes_of(mj, self._frame_of_body)
        self.pairs = pairs_of(mj, {shape.name for shape in self.shapes})
        self._list_what_is_left_out()

    # -- bodies and joints --------------------------------------------------------

    def _add_body(self, body: int) -> None:
        mj, model = self._mj, self.model
        above = int(mj.body_parentid[body])
        joint_id = self._joint_of_body[above]
        placement = self._in_joint[above] * _placement(mj.body_pos[body], mj.body_quat[body])
        name = self._body_names[body]
        joints = list(range(mj.body_jntadr[body], mj.body_jntadr[body] + mj.body_jntnum[body]))
        if above == 0:
            joints, joint_id, placement = self._at_root(joints, name, joint_id, placement)
        for joint in joints:
            joint_id, placement = self._add_joint(joint, joint_id, placement)
        self._joint_of_body[body], self._in_joint[body] = joint_id, placement
        self._frame_of_body[body] = name
        inertia = pin.Inertia.Zero()
        if mj.body_mass[body] > 0.0 or mj.body_inertia[body].any():
            # Principal moments turned afterwards: turned ones may round below zero, which
            # pin.Inertia refuses.
            own = pin.Inertia(
                float(mj.body_mass[body]), np.zeros(3), np.diag(mj.body_inertia[body])
            )
            inertia = _placement(mj.body_ipos[body], mj.body_iquat[body]).act(own)
        frame = pin.Frame(name, joint_id, placement, pin.FrameType.BODY, inertia)
        model.addFrame(frame, joint_id > 0)

    def _at_root(
        self, joints: list[int], name: str, joint_id: int, placement: pin.SE3
    ) -> tuple[list[int], int, pin.SE3]:
        """The joints of a tree's first body under the root that was asked for."""
        if self._root is None:
            return joints, joint_id, placement
        kinds = [int(self._mj.jnt_type[joint]) for joint in joints]
        if kinds == [_FREE]:
            if self._root == "freeflyer":
                return joints, joint_id, placement
            joints = []
        if self._root == "fixed":
            return joints, joint_id, placement
        kind, _ = root_joint(self._root)
        several = sum(self._mj.body_parentid[1:] == 0) > 1
        own = f"{name}_root_joint" if several else "root_joint"
        if own in self._joint_names:
            taken, own = own, _free_name(f"world_{own}", self._joint_names)
            self.assumptions.append(
                f'the robot has a joint "{taken}", so the root joint is named "{own}"'
            )
        joint_id = self._new_joint(joint_id, kind, placement, own)
        return joints, joint_id, pin.SE3.Identity()

    def _add_joint(self, joint: int, above: int, placement: pin.SE3) -> tuple[int, pin.SE3]:
        """Add one joint; its number and where the body's frame is in the joint's."""
        mj = self._mj
        kind = int(mj.jnt_type[joint])
        name = self._joint_names[joint]
        if kind == _FREE:
            joint_id = self._new_joint(above, pin.JointModelFreeFlyer(), pin.SE3.Identity(), name)
            self._bounds(joint, joint_id)
            return joint_id, pin.SE3.Identity()
        at = pin.SE3(np.eye(3), np.array(mj.jnt_pos[joint]))
        axis = np.array(mj.jnt_axis[joint])
        # qpos0 is the joint's value in the pose that the file draws.
        reference = float(mj.qpos0[mj.jnt_qposadr[joint]])
        back = pin.SE3.Identity()
        if kind == _HINGE:
            back.rotation = pin.exp3(-reference * axis)
        elif kind == _SLIDE:
            back.translation = -reference * axis
        model = pin.JointModelSpherical() if kind == _BALL else _along(kind, axis)
        joint_id = self._new_joint(above, model, placement * at * back, name)
        self._bounds(joint, joint_id)
        return joint_id, at.inverse()

    def _new_joint(self, above: int, kind: Any, placement: pin.SE3, name: str) -> int:
        joint_id = self.model.addJoint(above, kind, placement, name)
        self.model.addJointFrame(joint_id)
        return int(joint_id)

    def _bounds(self, joint: int, joint_id: int) -> None:
        """Limits, armature, damping and friction of a joint."""
        mj, model = self._mj, self.model
        own, kind = model.joints[joint_id], int(mj.jnt_type[joint])
        first = int(mj.jnt_dofadr[joint])
        theirs, ours = slice(first, first + _SPEEDS[kind]), slice(own.idx_v, own.idx_v + own.nv)
        armature = mj.dof_armature[theirs]
        if kind == _FREE and np.ptp(armature[:3]) > 0.0:
            raise self._error(
                f'joint "{model.names[joint_id]}"',
                "its armature differs between world axes, which no body has",
            )
        _set(model, "armature", ours, armature)
        _set(model, "damping", ours, mj.dof_damping[theirs])
        _set(model, "upperDryFrictionLimit", ours, mj.dof_frictionloss[theirs])
        _set(model, "lowerDryFrictionLimit", ours, -mj.dof_frictionloss[theirs])
        if kind in (_SLIDE, _HINGE):
            q = slice(own.idx_q, own.idx_q + 1)
            lower, upper = -np.inf, np.inf
            if mj.jnt_limited[joint]:
                lower, upper = mj.jnt_range[joint]
            _set(model, "lowerPositionLimit", q, lower)
            _set(model, "upperPositionLimit", q, upper)

    def _add_sites(self) -> None:
        mj = self._mj
        for site in range(mj.nsite):
            body = int(mj.site_bodyid[site])
            name = self._name(mj.site(site).name, f"site_{site}")
            placement = self._in_joint[body] * _placement(mj.site_pos[site], mj.site_quat[site])
            if self.model.existFrame(name):
                # A site may be called like a body or joint, which goes by the name alone.
                own, name = name, _free_name(f"{name}_site", [f.name for f in self.model.frames])
                self.assumptions.append(f'site "{own}" is called "{name}"')
            frame = pin.Frame(name, self._joint_of_body[body], placement, pin.FrameType.OP_FRAME)
            self.model.addFrame(frame, False)
            self._frame_of_site.append(name)

    def _name(self, name: str, otherwise: str) -> str:
        if name and not name.isprintable():
            raise self._error(f'"{shown(name)}"', "a name holds a control character")
        if name in ("world", "universe"):
            return f"{name}_body"
        return name or otherwise

    def _free_names(self, kind: str, given: list[str]) -> list[str]:
        """A name of its own for each body or joint; what has none gets one that the file leaves.

        A frame of a name that is there already would be left out, with its inertia.
        """
        taken, names = set(given), []
        for i, name in enumerate(given):
            usual = self._name(name, self._otherwise(kind, i))
            own = usual if usual == name else _free_name(usual, taken)
            if own != usual:
                called = f'"{name}"' if name else f"number {i}, which has no name,"
                self.assumptions.append(f'{kind} {called} is called "{own}"')
            taken.add(own)
            names.append(own)
        return names

    def _otherwise(self, kind: str, i: int) -> str:
        if kind == "body":
            return f"body_{i}"
        body_name = self._mj.body(int(self._mj.jnt_bodyid[i])).name
        return f"{body_name or 'body'}_joint_{i}"

    # -- what else the file holds ----------------------------------------------------

    def _loops(self) -> Iterator[Loop]:
        mj = self._mj
        for i in range(mj.neq):
            kind, name = int(mj.eq_type[i]), mj.equality(i).name or f"equality_{i}"
            ends = int(mj.eq_obj1id[i]), int(mj.eq_obj2id[i])
            by_site = int(mj.eq_objtype[i]) == 6  # mjOBJ_SITE
            if not mj.eq_active0[i]:
                self.assumptions.append(f'equality "{name}" is not active and left out')
            elif kind in (_CONNECT, _WELD):
                yield self._anchor(i, name, "point" if kind == _CONNECT else "frame", ends, by_site)
                if kind == _WELD and mj.eq_data[i][_TORQUE_SCALE] == 0.0:
                    self.assumptions.append(
                        f'equality "{name}": its torquescale of 0 is ignored, it holds turns too'
                    )
            elif kind == _JOINT and not np.any(mj.eq_data[i][2:5]):
                yield self._coupling(i, name, ends)
            else:
                what = f"<{_EQUALITIES[kind]}>" if kind < len(_EQUALITIES) else "of its kind"
                hint = " with a polynomial" if kind == _JOINT else ""
                self.assumptions.append(f'equality "{name}" {what}{hint} is left out')

    def _anchor(self, i: int, name: str, kind: str, ends: tuple[int, int], by_site: bool) -> Loop:
        mj, none = self._mj, (0.0, 0.0, 0.0)
        if by_site:
            frames = [self._frame_of_site[end] for end in ends]
            return Loop(kind, name, frames[0], frames[1], none, none)
        frames = [self._frame_of_body[end] for end in ends]
        first, second = (_triple(mj.eq_data[i][k : k + 3]) for k in (0, 3))
        if kind == "point":
            return Loop(kind, name, frames[0], frames[1], first, second)
        # A weld: the anchor is in the second body, where the first body's frame should be next.
        return Loop(kind, name, frames[1], frames[0], first, None)

    def _coupling(self, i: int, name: str, ends: tuple[int, int]) -> Loop:
        names = [self._joint_names[end] for end in ends if end >= 0]
        if len(names) == 1:
            return Loop("lock", name, names[0])
        return Loop("coupling", name, names[0], names[1], ratio=float(self._mj.eq_data[i][1]))

    def _refuse(self) -> None:
        mj = self._mj
        for tendon in range(mj.ntendon):
            if mj.tendon_armature[tendon] > 0.0:
                raise self._error(
                    f'tendon "{mj.tendon(tendon).name or tendon}"',
                    "its armature couples joints in the mass matrix, which a pin.Model cannot "
                    "hold; take it out",
                )
        if mj.nflex:
            raise self._error(f'flex "{_names(mj, "flex")[0]}"', "it is not a rigid body")

    def _list_what_is_left_out(self) -> None:
        mj = self._mj
        tendons = [mj.tendon(i).name or f"tendon {i}" for i in range(mj.ntendon)]
        mocap = [mj.body(b).name or f"body {b}" for b in range(mj.nbody) if mj.body_mocapid[b] >= 0]
        floating = [mj.body(b).name or f"body {b}" for b in np.flatnonzero(mj.body_gravcomp)]
        springs = [mj.joint(j).name or f"joint {j}" for j in np.flatnonzero(mj.jnt_stiffness)]
        actuators = _names(mj, "actuator")
        for names, what in (
            (tendons, "tendons are left out"),
            (mocap, "mocap bodies are fixed to the world"),
            (floating, "gravity compensation is left out"),
            (springs, "springs in joints are left out"),
            (actuators, "actuators are left out"),
        ):
            if names:
                listed = ", ".join(f'"{name}"' for name in names)
                self.assumptions.append(f"{what} ({listed})")

    def _error(self, element: str, sentence: str) -> MjcfError:
        return MjcfError(f"{self.name}: {element}: {sentence}", source=self.name, element=element)


def _free_name(name: str, taken: Collection[str]) -> str:
    """A name that nothing else has."""
    while name in taken:
        name += "_"
    return name


def _names(mj: Any, kind: str) -> list[str]:
    """Names of all of a kind that not every version of MuJoCo has an accessor for."""
    starts = getattr(mj, f"name_{kind}adr")
    return [_text(mj, int(start)) or f"{kind} {i}" for i, start in enumerate(starts)]


def _text(mj: Any, start: int) -> str:
    return bytes(mj.names[start:]).split(b"\0", 1)[0].decode(errors="replace")


def _triple(values: np.ndarray) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z


def _placement(position: np.ndarray, wxyz: np.ndarray) -> pin.SE3:
    return pin.SE3(rotation_of(wxyz), np.array(position))


# The cheaper joints along coordinate axes, and the one along any other.
_ALONG = {
    _HINGE: (
        (pin.JointModelRX, pin.JointModelRY, pin.JointModelRZ),
        pin.JointModelRevoluteUnaligned,
    ),
    _SLIDE: (
        (pin.JointModelPX, pin.JointModelPY, pin.JointModelPZ),
        pin.JointModelPrismaticUnaligned,
    ),
}


def _along(kind: int, axis: np.ndarray) -> Any:
    """A hinge or slide along an axis."""
    along, other = _ALONG[kind]
    for unit, own in zip(np.eye(3), along, strict=True):
        if abs(axis - unit).max() <= _ON_AXIS:
            return own()
    return other(axis)


def _set(model: pin.Model, field: str, entries: slice, values: Any) -> None:
    array = np.array(getattr(model, field))
    array[entries] = values
    setattr(model, field, array)
