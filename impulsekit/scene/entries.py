"""Kinds of entries of a scene, and those that a robot's own file gives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, TypeAlias, TypedDict

from ..errors import InputError, RangeError, quoted
from ..robot import Robot
from ..robot.source import Loop
from .constraints import (
    DIRECTIONS,
    DistanceAnchor,
    FrameAnchor,
    JointCoupling,
    JointLock,
    PointAnchor,
)
from .contacts import Collision, Contact, JointStop, Rope
from .driven import Driven
from .forces import JointFriction, JointSpring
from .gap_functions import GapConstraint, GapContact
from .impulses import AppliedImpulse, JointImpulse
from .law import Law

if TYPE_CHECKING:
    from typing import Unpack

    import numpy as np

    from ..robot.mjcf_shapes import TouchingPair
    from .forces import Force
    from .materials import Material, MaterialPair
    from .numbers import Vector

Constraint: TypeAlias = (
    PointAnchor | FrameAnchor | DistanceAnchor | JointLock | JointCoupling | Driven | GapConstraint
)
ContactEntry: TypeAlias = Contact | JointStop | Collision | Rope | GapContact

# The direction that a closing joint leaves free, z along its axis.
_FREE = {"hinge": "rz", "slide": "z"}
_CONTACTS = (False, "world", "all")


class SceneEntries(TypedDict, total=False):
    """Arguments of ``Scene`` besides the robot, for editors."""

    impulses: Sequence[AppliedImpulse | JointImpulse]
    constraints: Sequence[Constraint]
    contacts: Sequence[ContactEntry]
    forces: Sequence[Force]
    law: Law
    gravity: Vector
    gap_bound: float
    controlled: Sequence[str]
    materials: Sequence[Material | MaterialPair]
    collisions: Literal["all"] | None


class FromFile(SceneEntries, total=False):
    """Arguments of ``Scene.of_robot``: the entries of a scene, and which come from the file."""

    file_loops: bool
    file_contacts: bool | str
    joint_damping: bool
    joint_friction: bool
    file_turning: bool
    restitution: float


def entries_of(
    robot: Robot,
    *,
    file_loops: bool = True,
    file_contacts: bool | str = False,
    file_turning: bool = True,
    joint_damping: bool = False,
    joint_friction: bool = False,
    restitution: float = 0.0,
    **entries: Unpack[SceneEntries],
) -> SceneEntries:
    """Return the entries of a scene with the loops, and on request the contacts, of a robot's file.

    Args:
        robot: the robot, such as one of ``Robot.from_mjcf``.
        file_loops: whether the equality constraints of the file become constraints.
        file_contacts: False for none; "world" (or True) for collisions of the moving geoms with
            those that are fixed; "all" for collisions among moving geoms too.
        file_turning: whether those contacts get the file's torsional and rolling friction too
            (condim 4 and 6 of MJCF); False takes sliding friction alone, for laws that do not
            support the others.
        joint_damping: whether the damping of the file's joints (of a URDF, <dynamics damping>)
            becomes forces, of joints with one degree of freedom.
        joint_friction: whether their dry friction does (of a URDF, <dynamics friction>; of MJCF,
            frictionloss).
        restitution: of those collisions. MJCF knows none; friction is the file's.
        **entries: what ``Scene`` takes; ``constraints``, ``contacts`` and ``forces`` come
            after the file's. Gravity is the file's unless it is given.

    Raises:
        RangeError: ``file_contacts`` is something else.
        InputError: friction that differs between the two tangents of MuJoCo's contact frame.

    Example:
        >>> text = '''<mujoco><worldbody><geom name="floor" type="plane" size="1 1 1"/>
        ...   <body name="ball"><freejoint/><geom name="skin" size="0.1"/></body>
        ... </worldbody></mujoco>'''
        >>> entries_of(Robot.from_mjcf(text), file_contacts="world")["contacts"][0].other
        'floor'
    """
    which = "world" if file_contacts is True else file_contacts
    if which not in _CONTACTS:
        raise RangeError.of("file_contacts", quoted(which), 'False, "world" or "all"')
    constraints = [_constraint(loop) for loop in robot.loops] if file_loops else []
    contacts = [
        _collision(pair, restitution, turning=file_turning)
        for pair in (robot.touching_pairs if which else ())
        if pair.fixed or which == "all"
    ]
    dampers = _dampers(robot) if joint_damping else ()
    rubbing = _dry_friction(robot) if joint_friction else ()
    own: SceneEntries = {"gravity": tuple(robot.model.gravity.linear)}
    own.update(entries)
    own["forces"] = (*dampers, *rubbing, *entries.get("forces", ()))
    own["constraints"] = (*constraints, *entries.get("constraints", ()))
    own["contacts"] = (*contacts, *entries.get("contacts", ()))
    return own


def _collision(pair: TouchingPair, restitution: float, *, turning: bool) -> Collision:
    rolling, torsion = (pair.rolling, pair.torsion) if turning else (0.0, 0.0)
    if pair.uneven:
        raise InputError(
            f'the file\'s friction of "{pair.first}" and "{pair.second}" differs between the two '
            "tangents of MuJoCo's contact frame, whose directions are not in the file; leave out "
            "file_contacts and give a Collision with friction=EllipticFriction(...)"
        )
    return Collision(
        pair.first,
        pair.second,
        restitution=restitution,
        friction=pair.friction,
        rolling=rolling,
        torsion=torsion,
    )


def _dampers(robot: Robot) -> list[JointSpring]:
    """The damping of the robot's joints."""
    found = _by_joint(robot, robot.model.damping)
    return [JointSpring(name, damping=damping) for name, damping in found]


def _dry_friction(robot: Robot) -> list[JointFriction]:
    """The dry friction of the robot's joints."""
    found = _by_joint(robot, robot.model.upperDryFrictionLimit)
    return [JointFriction(name, torque) for name, torque in found]


def _by_joint(robot: Robot, values: np.ndarray) -> list[tuple[str, float]]:
    """Joints of one degree of freedom and their entries of (nv,) values, where above 0."""
    joints = ((name, robot.model.joints[robot.joint_id(name)]) for name in robot.joint_names)
    found = [(name, float(values[joint.idx_v])) for name, joint in joints if joint.nv == 1]
    return [(name, value) for name, value in found if value > 0.0]


def _constraint(loop: Loop) -> Constraint:
    if loop.kind == "point":
        return PointAnchor(loop.first, loop.second, loop.at, loop.other_at, name=loop.name)
    if loop.kind == "frame":
        return FrameAnchor(loop.first, loop.second, loop.at, loop.other_at, name=loop.name)
    if loop.kind in _FREE:
        ends = loop.first, loop.second, loop.at, loop.other_at
        held = tuple(each for each in DIRECTIONS if each != _FREE[loop.kind])
        return FrameAnchor(*ends, held, "local", name=loop.name)
    if loop.kind == "lock":
        return JointLock(loop.first, name=loop.name)
    return JointCoupling(loop.first, loop.second, loop.ratio, name=loop.name)
