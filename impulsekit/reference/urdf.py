"""From a URDF to bodies, numbered depth first.

yourdfpy reads how links and joints form a tree. It makes doubles of the numbers, which are
therefore taken from their decimal text, so that each precision makes of them what it needs.
"""

from __future__ import annotations

import io
import os
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from impulsekit.errors import UrdfError
from impulsekit.reference import rotation
from impulsekit.reference.arithmetic import Arithmetic, Array
from impulsekit.reference.joint import COORDINATES, SPEEDS, WORLD, Bodies, Body, Joint, directions

Element = ElementTree.Element
JOINT_KINDS = ("fixed", "revolute", "continuous", "prismatic", "planar", "floating")
ROOT_JOINT = "root_joint"
"""The name of the joint between the world and the root link, a fixed one among them."""
ROOT_KINDS = {"fixed": "fixed", "planar": "planar", "freeflyer": "floating"}
_ZERO, _X = ("0", "0", "0"), ("1", "0", "0")


def bodies_of_urdf(
    urdf: str | os.PathLike[str],
    root: str,
    mimic: bool,
    arithmetic: Arithmetic,
    exact_decimals: bool,
) -> Bodies:
    """Return the bodies of a URDF; arguments and errors are those of ``Tree.from_urdf``."""
    text, source = _text(urdf)
    found = _Reader(text, source, arithmetic, exact_decimals, mimic).read(ROOT_KINDS[root])
    _refuse_weightless_branches(found.bodies, source)
    return found


def _text(urdf: str | os.PathLike[str]) -> tuple[bytes, str]:
    if isinstance(urdf, str) and urdf.lstrip().startswith("<"):
        return urdf.strip().encode(), "the URDF given as a string"
    path = Path(urdf)
    if path.exists() and not path.is_file():
        raise _error(str(path), "file", "it is no plain file")
    try:
        return path.read_bytes(), str(path)
    except OSError as fault:
        reason = "no such file" if not path.exists() else str(fault)
        raise _error(str(path), "file", reason) from None


def _error(source: str, element: str, reason: str) -> UrdfError:
    return UrdfError(f"{source}: {element}: {reason}", source=source, element=element)


class _Reader:
    """Reads links and joints, and numbers coordinates and speeds on the way down."""

    def __init__(
        self, text: bytes, source: str, arithmetic: Arithmetic, exact_decimals: bool, mimic: bool
    ) -> None:
        self.source, self.arithmetic = source, arithmetic
        self.exact_decimals, self.mimic = exact_decimals, mimic
        self.bodies: list[Body] = []
        self.speed_names: list[str] = []
        self.coordinate_names: list[str] = []
        try:
            robot = ElementTree.fromstring(text)
        except ElementTree.ParseError as fault:
            raise self._error("robot", f"the XML is broken: {fault}") from None
        if robot.tag != "robot":
            raise self._error(robot.tag, f"the outermost element is <{robot.tag}>, not <robot>")
        self.links = self._by_name(robot, "link")
        self.joints = self._by_name(robot, "joint")
        if not self.links:
            raise self._error("robot", "there is no link in it")
        for name, joint in self.joints.items():
            self._check_joint(name, joint)
        self.read_joints = self._read_by_yourdfpy(robot)
        # By parent, in alphabetical order: urdfdom keeps joints in a map by name, so programs built
        # on it, Pinocchio among them, walk down the tree in this order.
        self.below: dict[str, list[str]] = {}
        for name in sorted(self.joints, key=str.encode):
            self.below.setdefault(self.read_joints[name].parent, []).append(name)

    def read(self, root_kind: str) -> Bodies:
        """Return the bodies below a root joint of a kind."""
        first = f"world_{ROOT_JOINT}" if ROOT_JOINT in self.joints else ROOT_JOINT
        root = self._root()
        top = ElementTree.Element("joint", type=root_kind)
        ahead = [(first, top, root, WORLD)]  # a stack, since long chains are deeper than Python's
        while ahead:
            name, element, link, parent = ahead.pop()
            index = len(self.bodies)
            self.bodies.append(self._body(link, parent, self._joint(name, element)))
            for below in reversed(self.below.get(link, [])):
                child = self.read_joints[below].child
                ahead.append((below, self.joints[below], child, index))
        bodies = [replace(body, joint=self._following(body.joint)) for body in self.bodies]
        return Bodies(tuple(bodies), tuple(self.speed_names), tuple(self.coordinate_names))

    def _read_by_yourdfpy(self, robot: Element) -> dict[str, Any]:
        """Return yourdfpy's joints by name: kinds, ends, and the joints that they follow."""
        # Imported here: it brings trimesh along, which takes a second.
        import yourdfpy

        plain = ElementTree.Element("robot", name=robot.get("name", "robot"))
        # Shapes, colours and controllers are none of dynamics' business.
        plain.extend(ElementTree.Element("link", name=name) for name in self.links)
        plain.extend(self.joints.values())
        try:
            read = yourdfpy.URDF.load(
                io.BytesIO(ElementTree.tostring(plain)), build_scene_graph=False, load_meshes=False
            )
        except Exception as fault:  # yourdfpy lets AttributeError and ValueError through
            raise self._error("robot", f"yourdfpy cannot read it: {fault}") from fault
        return {joint.name: joint for joint in read.robot.joints}

    def _by_name(self, robot: Element, tag: str) -> dict[str, Element]:
        found: dict[str, Element] = {}
        for element in robot.findall(tag):
            name = element.get("name")
            if not name:
                raise self._error(tag, f"a {tag} has no name")
            if name in found:
                raise self._error(f'{tag} "{name}"', f"two {tag}s have this name")
            found[name] = element
        return found

    def _check_joint(self, name: str, element: Element) -> None:
        owner = f'joint "{name}"'
        for end in ("parent", "child"):
            link = _end(element, end)
            if not link:
                raise self._error(owner, f"it has no <{end} link>")
            if link not in self.links:
                raise self._error(owner, f'its {end} link "{link}" does not exist')
        kind = element.get("type")
        if kind not in JOINT_KINDS:
            known = ", ".join(JOINT_KINDS)
            raise self._error(owner, f'its type "{kind}" is unknown; URDF knows {known}')

    def _root(self) -> str:
        """Return the one link that is no joint's child, above all others."""
        above: dict[str, str] = {}
        for name, joint in self.read_joints.items():
            if joint.child in above:
                raise self._error(
                    f'link "{joint.child}"',
                    f'a loop: it is the child of two joints, "{above[joint.child]}" and "{name}"; '
                    "leave one out and close it with constraint rows",
                )
            above[joint.child] = name
        roots = [name for name in self.links if name not in above]
        if len(roots) > 1:
            raise self._error(f'link "{roots[1]}"', f'two roots, "{roots[0]}" is the other')
        reached, ahead = set(roots), list(roots)
        while ahead:
            children = [self.read_joints[name].child for name in self.below.get(ahead.pop(), [])]
            reached.update(children)
            ahead += children
        astray = [name for name in self.links if name not in reached]
        if astray:
            raise self._error(f'link "{astray[0]}"', "a loop: it is below itself")
        return roots[0]

    def _numbers(
        self, owner: str, element: Element | None, attribute: str, default: tuple[str, ...]
    ) -> Array:
        """Return the numbers of an attribute, as many as its default has."""
        text = None if element is None else element.get(attribute)
        words = default if element is None or text is None else tuple(text.split())
        try:
            finite = all(abs(float(word)) < float("inf") for word in words)
        except ValueError:
            finite = False
        if element is not None and (not finite or len(words) != len(default)):
            wanted = f"{len(default)} finite number{'s' if len(default) > 1 else ''}"
            raise self._error(owner, f'<{element.tag} {attribute}="{text}">: expected {wanted}')
        found = self.arithmetic.zeros(len(words))
        for i, word in enumerate(words):
            found[i] = self.arithmetic.number(word if self.exact_decimals else float(word))
        return found

    def _pose(self, owner: str, element: Element) -> tuple[Array, Array]:
        """Return rotation and translation of an <origin>."""
        origin = element.find("origin")
        angles = self._numbers(owner, origin, "rpy", _ZERO)
        turned = rotation.of_roll_pitch_yaw(angles, self.arithmetic)
        return turned, self._numbers(owner, origin, "xyz", _ZERO)

    def _body(self, name: str, parent: int, joint: Joint) -> Body:
        inertial, owner, zeros = (
            self.links[name].find("inertial"),
            f'link "{name}"',
            self.arithmetic.zeros,
        )
        if inertial is None:
            return Body(name, parent, joint, zeros(1)[0], zeros(3), zeros(3, 3))
        mass, inertia = inertial.find("mass"), inertial.find("inertia")
        if mass is None or mass.get("value") is None:
            raise self._error(owner, "its <inertial> has no <mass value>")
        if inertia is None:
            raise self._error(owner, "its <inertial> has no <inertia>")
        own = zeros(3, 3)
        for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
            entry = f"i{'xyz'[i]}{'xyz'[j]}"
            if inertia.get(entry) is None:
                raise self._error(owner, f"its <inertia> has no {entry}")
            own[i, j] = own[j, i] = self._numbers(owner, inertia, entry, ("0",))[0]
        value = self._numbers(owner, mass, "value", ("0",))[0]
        if value < 0:
            raise self._error(owner, f"its mass is {mass.get('value')} kg")
        turned, centre = self._pose(owner, inertial)
        return Body(name, parent, joint, value, centre, turned @ own @ turned.T)

    def _joint(self, name: str, element: Element) -> Joint:
        numbers, owner, kind = self.arithmetic, f'joint "{name}"', str(element.get("type"))
        axis = self._numbers(owner, element.find("axis"), "xyz", _X)
        if kind not in ("revolute", "continuous", "prismatic"):
            axis = numbers.eye(3)[2].copy()
        elif not axis.any():
            raise self._error(owner, "its axis has no length")
        axis = axis / numbers.norm(axis)
        mimic = element.find("mimic") if self.mimic else None
        starts = len(self.coordinate_names), len(self.speed_names)
        if mimic is None:
            self.coordinate_names += [name + tail for tail in COORDINATES[kind]]
            self.speed_names += [name + tail for tail in SPEEDS[kind]]
        return Joint(
            name,
            kind,
            self._pose(owner, element),
            *directions(numbers, kind, axis),
            axis,
            *starts,
            self._numbers(owner, mimic, "multiplier", ("1",))[0],
            self._numbers(owner, mimic, "offset", ("0",))[0],
            "" if mimic is None else str(mimic.get("joint", "")),
        )

    def _following(self, joint: Joint) -> Joint:
        """Return the joint, pointed at the coordinate and speed of the joint that it follows."""
        if not joint.mimics:
            return joint
        known = {body.joint.name: body.joint for body in self.bodies}
        multiplier, offset, leader = self.arithmetic.number(1), self.arithmetic.number(0), joint
        owner, seen = f'joint "{joint.name}"', set[str]()
        while leader.mimics:
            # q = m1 (m2 q'' + o2) + o1
            if leader.name in seen:
                raise self._error(owner, "it mimics itself")
            if leader.mimics not in known:
                reason = f'the joint "{leader.mimics}" that it mimics does not exist'
                raise self._error(owner, reason)
            seen.add(leader.name)
            multiplier, offset = multiplier * leader.multiplier, multiplier * leader.offset + offset
            leader = known[leader.mimics]
        if len(joint.linear) != 1 or len(leader.linear) != 1:
            raise self._error(owner, f'it mimics "{leader.name}", and both need a single speed')
        return replace(
            joint,
            coordinate_kind=leader.kind,
            first_coordinate=leader.first_coordinate,
            first_speed=leader.first_speed,
            mimics=leader.name,
            multiplier=multiplier,
            offset=offset,
        )

    def _error(self, element: str, reason: str) -> UrdfError:
        return _error(self.source, element, reason)


def _end(joint: Element, end: str) -> str:
    """Return the name of a joint's parent or child link; "" without one."""
    found = joint.find(end)
    return "" if found is None else found.get("link", "")


def _refuse_weightless_branches(bodies: Sequence[Body], source: str) -> None:
    """Refuse a joint that carries links without mass alone: it cannot move."""
    heavy: list[Any] = [body.mass != 0 or body.inertia.any() for body in bodies]
    # Children come after their parents.
    for index in reversed(range(len(bodies))):
        if heavy[index] and bodies[index].parent != WORLD:
            heavy[bodies[index].parent] = True
    for body, carries in zip(bodies, heavy, strict=True):
        if len(body.joint.linear) and not body.joint.mimics and not carries:
            raise _error(
                source,
                f'joint "{body.joint.name}"',
                f'link "{body.name}" and all below it have neither mass nor inertia, so any blow '
                "would move them infinitely fast",
            )
