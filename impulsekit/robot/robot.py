"""``Robot``: a Pinocchio model with its names, its root and its states; and building on it.

Payloads, locked joints, rotors and a ground each make a new robot.

The model is changed, and so is the URDF that the robot's geometry, its links and the
reference are read from; what was changed is kept, so that a scene file can hold it.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from ..errors import InputError, NotFiniteError, RangeError, ShapeError, a_thing, quoted
from ..errors.calls import public
from .arrays import array_of, floats, not_negative, number, text
from .base import RobotBase
from .reading import RobotReaders
from .robot_xml import element, xml_of
from .source import WHOLE, AddedBody, Changes, Ground, RobotPart
from .urdf_elements import MOMENTS, read_links

if TYPE_CHECKING:
    from typing import Self

    from numpy.typing import ArrayLike

# A principal moment may exceed the sum of the others by so much of it: rounding.
TRIANGLE = 1e-9

Kind = TypeVar("Kind", bound=RobotBase)


def _reduced(model: pin.Model, joints: list[int], q: np.ndarray) -> pin.Model:
    """A model without some joints, whose frames keep their parents.

    ``buildReducedModel`` leaves parents of frames that belong to no frame of the new model.
    """
    reduced = pin.buildReducedModel(model, joints, q) if joints else pin.Model(model)
    new = {_key(frame): i for i, frame in enumerate(reduced.frames)}
    for frame in model.frames:
        parent = new[_key(model.frames[frame.parentFrame])]
        reduced.frames[new[_key(frame)]].parentFrame = parent
    return reduced


def _key(frame: pin.Frame) -> tuple[str, bool]:
    """Name and kind of a frame: a link and the joint above it may share a name."""
    return frame.name, frame.type in (pin.FrameType.BODY, pin.FrameType.OP_FRAME)


def with_masses(robot: Kind, model: pin.Model) -> Kind:
    """Return the robot with the inertias of a model that is its own but for these.

    Its files do not say these masses, so that it cannot be built from them, nor written to one.
    """
    parts = [
        replace(part, urdf=None, geometry=part.urdf or part.geometry, inertials={})
        for part in robot.parts
    ]
    return type(robot)(pin.Model(model), parts, robot.name)


def _changed(
    robot: Kind,
    model: pin.Model,
    part: RobotPart,
    changes: Changes,
    write: Callable[[Element], None] | None,
) -> Kind:
    """The robot with another model, and one part of it rewritten."""
    text, inertials = part.urdf, part.inertials
    if text is not None and write is not None:
        root = ElementTree.fromstring(text)
        write(root)
        changes, text = replace(changes, text=changes.text or text), xml_of(root)
        inertials = read_links(root, part.label)
    new = replace(part, urdf=text, changes=changes, inertials=inertials)
    parts = [new if each is part else each for each in robot.parts]
    return type(robot)(model, parts, robot.name)


def _write_body(root: Element, body: AddedBody) -> None:
    moments = dict(zip(MOMENTS, body.inertia, strict=True))
    inertial = element(
        "inertial",
        element("origin", xyz=body.com, rpy="0 0 0"),
        element("mass", value=body.mass),
        element("inertia", **moments),
    )
    ends = element("parent", link=body.frame), element("child", link=body.name)
    root.append(element("link", inertial, name=body.name))
    root.append(element("joint", *ends, name=f"{body.name}_weld", type="fixed"))


def _write_lock(root: Element, name: str, value: float) -> None:
    joint = next(each for each in root.findall("joint") if each.get("name") == name)

    def numbers(tag: str, key: str = "xyz", usual: str = "0 0 0") -> np.ndarray:
        own = joint.find(tag)
        return np.array((usual if own is None else own.get(key, usual)).split(), dtype=float)

    along, xyz, rpy = numbers("axis", "xyz", "1 0 0"), numbers("origin"), numbers("origin", "rpy")
    along, turn = along / np.linalg.norm(along), pin.rpy.rpyToMatrix(rpy)
    if value and joint.get("type") == "prismatic":
        xyz = xyz + turn @ along * value
    elif value:
        rpy = pin.rpy.matrixToRpy(turn @ pin.exp3(value * along))
    joint.set("type", "fixed")
    for tag in ("axis", "limit", "dynamics", "mimic", "origin"):
        for child in joint.findall(tag):
            joint.remove(child)
    joint.append(element("origin", xyz=xyz, rpy=rpy))


def _part_of(robot: Kind, name: str) -> RobotPart:
    """The part of a combined robot that a name belongs to."""
    return max(
        (part for part in robot.parts if name.startswith(part.prefix)),
        key=lambda part: len(part.prefix),
    )


def _part_of_link(robot: Kind, frame: str, where: str) -> tuple[RobotPart, str]:
    frame_id = robot.frame_id(frame, where)
    if frame_id == 0 or robot.model.frames[frame_id].type != pin.FrameType.BODY:
        links = ", ".join(f'"{link.name}"' for link in robot.links[:6])
        raise InputError(f'{where}: "{frame}" is no link; the links are {links}, ...')
    part = _part_of(robot, frame)
    return part, frame.removeprefix(part.prefix)


def _moments(inertia: Any) -> tuple[float, ...]:
    """ixx, ixy, ixz, iyy, iyz, izz of a (3, 3) tensor, of six or of three principal moments."""
    what = "with_body: inertia"
    if inertia is None:
        return (0.0,) * 6
    array = floats(inertia, what)
    if array.shape == (3,):
        array = np.diag(array)
    elif array.shape == (6,):
        array = array[WHOLE]
    if array.shape != (3, 3):
        raise ShapeError.of(what, (3, 3), array.shape, "or (6,) or (3,)")
    if not np.isfinite(array).all():
        raise NotFiniteError.of(what, "an entry", "not finite")
    if abs(array - array.T).max() > TRIANGLE * abs(array).max():
        raise InputError(f"{what} is not symmetric")
    first, second, third = np.linalg.eigvalsh(0.5 * (array + array.T))
    if first < -TRIANGLE * third or third > (first + second) * (1.0 + TRIANGLE):
        raise InputError(
            f"{what} has principal moments {first:g}, {second:g}, {third:g} kg m²; they "
            "violate the triangle inequality: each must be at least 0 and at most the others' sum"
        )
    return tuple(float(array[i, j]) for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)))


@public
class Robot(RobotReaders):
    """A rigid multibody system: a Pinocchio model with the names of its joints, links and frames.

    Created by ``from_urdf``, ``from_example``, ``from_model`` or ``combine``. q and v
    follow Pinocchio: a free-flyer's velocity is in the body frame, linear before
    angular; quaternions are x, y, z, w; a continuous joint has two entries in q.

    Attributes:
        model: the ``pin.Model``, a copy; do not change it.
        name: the robot's name.
        parts: the sources that the robot was made from.

    Example:
        >>> robot = Robot.from_example("panda")
        >>> robot.nv
        9
        >>> robot.configuration(panda_joint2=-0.5)[1]
        np.float64(-0.5)
    """

    def with_body(
        self,
        frame: str,
        *,
        mass: float,
        com: ArrayLike = (0.0, 0.0, 0.0),
        inertia: ArrayLike | None = None,
        name: str | None = None,
    ) -> Self:
        """Return a robot with a body welded to a link: a payload, a tool, a sensor.

        The same as another link behind a fixed joint in the URDF. It can be named in scenes,
        is checked, reported and written to scene files.

        Args:
            frame: the link that carries it.
            mass: [kg], 0 or more.
            com: (3,) mass centre in ``frame`` [m].
            inertia: about the mass centre, in the axes of ``frame`` [kg m²]: (3, 3), (6,) as
                ixx, ixy, ixz, iyy, iyz, izz, or (3,) principal moments; None for a point mass.
            name: of the new link; by default the frame's name and "_payload".

        Raises:
            UnknownNameError, InputError: no such link, or the name is taken.
            RangeError, ShapeError, NotFiniteError: of the numbers.

        Example:
            >>> from impulsekit import Robot
            >>> arm = Robot.from_example("panda")
            >>> round(arm.with_body("panda_hand", mass=2.0, com=[0, 0, 0.1]).mass - arm.mass, 9)
            2.0
        """
        part, own = _part_of_link(self, frame, "with_body")
        mass = not_negative(mass, "with_body: mass")
        centre = tuple(array_of(com, (3,), "with_body: com").tolist())
        moments = _moments(inertia)
        given = f"{own}_payload" if name is None else name
        whole_name = part.prefix + text(given, "with_body: name")
        if whole_name in self.frame_names:
            raise InputError(
                f'with_body: the robot has a frame "{whole_name}" already; name another'
            )
        body = AddedBody(own, given, mass, centre, moments)
        model = pin.Model(self.model)
        carrier = self.frame_id(frame)
        at = model.frames[carrier]
        added = pin.Inertia(mass, np.array(centre), np.array(moments)[WHOLE])
        weld = pin.Frame(
            f"{whole_name}_weld", at.parentJoint, carrier, at.placement, pin.FrameType.FIXED_JOINT
        )
        weld_id = model.addFrame(weld, False)
        kind = pin.FrameType.BODY
        # Behind the world's own frame no inertia counts.
        new = pin.Frame(whole_name, at.parentJoint, weld_id, at.placement, kind, added)
        model.addFrame(new, at.parentJoint > 0)
        changes = replace(part.changes, bodies=(*part.changes.bodies, body))
        return _changed(self, model, part, changes, lambda root: _write_body(root, body))

    def with_lock(self, joints: str | Iterable[str] | Mapping[str, float]) -> Self:
        """Return a robot in which joints are fixed: fewer degrees of freedom, the same links.

        Args:
            joints: names, locked at zero, or a mapping to the values to lock them at [rad, m].

        Raises:
            UnknownNameError: no such joint.
            InputError: the joint has several degrees of freedom, or none.

        Example:
            >>> from impulsekit import Robot
            >>> Robot.from_example("panda").with_lock({"panda_joint4": -1.8}).nv
            8
        """
        if isinstance(joints, str):
            joints = [joints]
        if not isinstance(joints, Iterable):
            raise InputError(
                f"with_lock takes names of joints, or a mapping to values, not {a_thing(joints)}"
            )
        values = dict(joints) if isinstance(joints, Mapping) else dict.fromkeys(joints, 0.0)
        ids = []
        for name, value in values.items():
            joint_id = self.joint_id(name, "with_lock")
            joint = self.model.joints[joint_id]
            if joint.nv != 1 or joint.shortname() == "JointModelMimic":
                raise InputError(
                    f'with_lock: joint "{name}" has {joint.nv} degrees of freedom of its own; one '
                    "that turns or slides can be locked"
                )
            values[name] = number(value, f'with_lock: joint "{name}"')
            ids.append(joint_id)
        if any(joint.shortname() == "JointModelMimic" for joint in self.model.joints):
            raise InputError(
                "with_lock: lock joints before their followers follow: read the robot with "
                "mimic=False"
            )
        model = _reduced(self.model, ids, self.configuration(values))
        robot = self
        for name, value in values.items():
            part = _part_of(robot, name)
            own = name.removeprefix(part.prefix)
            changes = replace(part.changes, locks=(*part.changes.locks, (own, value)))
            robot = _changed(
                robot, model, part, changes, functools.partial(_write_lock, name=own, value=value)
            )
        return robot

    def with_armature(
        self, armature: Mapping[str, ArrayLike], *, gear: Mapping[str, float] | None = None
    ) -> Self:
        """Return a robot with rotor inertia in its joints, which adds to the diagonal of M.

        In geared arms it decides what an impact does: a rotor of inertia J behind a gear of
        ratio r counts as r² J on the joint's side.

        Args:
            armature: by joint, the inertia on the joint's side [kg m², kg]; or the rotor's own
                where ``gear`` names its ratio. One number, or one for each of its speeds.
            gear: by joint, the gear ratio.

        Raises:
            UnknownNameError: no such joint.
            RangeError, ShapeError, NotFiniteError, InputError: of the numbers.

        Example:
            >>> from impulsekit import Robot
            >>> arm = Robot.from_example("ur5").with_armature(
            ...     {"elbow_joint": 6e-5}, gear={"elbow_joint": 101})
            >>> arm.model.armature[2].round(3)
            np.float64(0.612)
        """
        for what, given in (("armature", armature), ("gear", {} if gear is None else gear)):
            if not isinstance(given, Mapping):
                raise InputError(
                    f"with_armature: {what} must be a mapping from joint names to numbers, got "
                    f"{quoted(given)}"
                )
        gear, robot = gear or {}, self
        for name in gear:
            if name not in armature:
                raise InputError(
                    f'with_armature: gear names joint "{name}", which armature does not'
                )
        model = pin.Model(self.model)
        whole = np.array(model.armature)
        for name, value in armature.items():
            joint = model.joints[self.joint_id(name, "with_armature")]
            ratio = number(gear.get(name, 1.0), f'with_armature: gear of "{name}"')
            what = f'with_armature: "{name}"'
            each = [value] * joint.nv if np.ndim(value) == 0 else value
            values = array_of(each, (joint.nv,), what)
            if (values < 0.0).any():
                raise RangeError.of(what, float(values.min()), "0 or more")
            whole[joint.idx_v : joint.idx_v + joint.nv] = ratio * ratio * values
            part = _part_of(robot, name)
            kept = dict(part.changes.armature)
            kept[name.removeprefix(part.prefix)] = tuple(map(float, ratio * ratio * values))
            changes = replace(part.changes, armature=tuple(kept.items()))
            robot = _changed(robot, model, part, changes, None)
        model.armature = whole
        return type(self)(model, robot.parts, self.name)

    def with_ground(
        self,
        height: float = 0.0,
        *,
        normal: ArrayLike = (0.0, 0.0, 1.0),
        name: str = "ground",
        shared: bool | None = None,
    ) -> Self:
        """Return a robot with a plane in its world, which ``Collision("ball", "ground")`` names.

        Args:
            height: of the plane along the normal, from the world's origin [m].
            normal: (3,) out of the ground, world axes.
            name: of the collision geometry.
            shared: True keeps the name as it is when robots are combined, False puts the robot's
                name before it, "arm/ground"; None for True of a combined world, False of a robot.

        Raises:
            InputError, RangeError, ShapeError, NotFiniteError: of the arguments.

        Example:
            >>> from impulsekit import Robot
            >>> robot = Robot.from_example("solo12", root="freeflyer").with_ground(-0.3)
            >>> robot.collision_model.geometryObjects[0].name
            'ground'
        """
        along = array_of(normal, (3,), "with_ground: normal")
        length = float(np.linalg.norm(along))
        if length == 0.0:
            raise RangeError.of("with_ground: normal", normal, "a direction")
        part = self.parts[0]
        own = text(name, "with_ground: name")
        taken = [each.name_of(one) for each in self.parts for one in each.changes.grounds]
        if own in taken:
            raise InputError(f'with_ground: there is a ground "{name}" already; name another')
        height = number(height, "with_ground: height")
        unit = along / length
        if part.placement is not None:
            # The plane is kept in the coordinates of the part, which moves it along.
            placed = pin.SE3(np.array(part.placement))
            height -= float(unit @ placed.translation)
            unit = placed.rotation.T @ unit
        x, y, z = unit.tolist()
        ground = Ground(
            own, (x, y, z), height, shared=bool(part.prefix) if shared is None else bool(shared)
        )
        changes = replace(part.changes, grounds=(*part.changes.grounds, ground))
        return _changed(self, pin.Model(self.model), part, changes, None)
