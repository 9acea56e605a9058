"""A URDF as it is written: names, kinds, and numbers still in their decimal text.

yourdfpy says what links and joints there are and how they hang together. It turns
origins into matrices of doubles, so the numbers are taken from the text of the same
elements: a reader of any precision can then make of them what it needs.
"""

from __future__ import annotations

import io
import os
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from impulsekit.errors import UrdfError

JOINT_KINDS = ("fixed", "revolute", "continuous", "prismatic", "planar", "floating")
_ZERO = ("0", "0", "0")


@dataclass(frozen=True)
class UrdfLink:
    """A link. Numbers as written: mass in kg, mass centre in m, inertia in kg m².

    ``inertia`` holds ixx, ixy, ixz, iyy, iyz, izz about the mass centre, in axes turned
    by ``roll_pitch_yaw`` against the link's frame.
    """

    name: str
    mass: str = "0"
    mass_centre: tuple[str, ...] = _ZERO
    roll_pitch_yaw: tuple[str, ...] = _ZERO
    inertia: tuple[str, ...] = ("0", "0", "0", "0", "0", "0")


@dataclass(frozen=True)
class UrdfJoint:
    """A joint. Numbers as written: the frame of the joint in the frame of the parent link.

    ``mimics`` names the joint that this one follows, "" if none, q = multiplier q' + offset.
    """

    name: str
    kind: str
    parent: str
    child: str
    translation: tuple[str, ...] = _ZERO
    roll_pitch_yaw: tuple[str, ...] = _ZERO
    axis: tuple[str, ...] = ("1", "0", "0")
    mimics: str = ""
    multiplier: str = "1"
    offset: str = "0"


@dataclass(frozen=True)
class UrdfModel:
    """A tree of links: every link but ``root`` is the child of one joint."""

    source: str
    root: str
    links: dict[str, UrdfLink]
    joints: dict[str, UrdfJoint]

    def children(self, link: str) -> list[UrdfJoint]:
        """The joints below a link, in alphabetical order.

        urdfdom keeps joints in a map by name, so this is the order in which programs
        built on it, Pinocchio among them, walk down the tree.
        """
        return self._below.get(link, [])

    @cached_property
    def _below(self) -> dict[str, list[UrdfJoint]]:
        below: dict[str, list[UrdfJoint]] = {}
        for joint in sorted(self.joints.values(), key=lambda joint: joint.name.encode()):
            below.setdefault(joint.parent, []).append(joint)
        return below


def read_urdf(urdf: str | os.PathLike[str]) -> UrdfModel:
    """Read a URDF from a path, or from a string that holds the XML itself.

    Raises:
        UrdfError: no such file, broken XML, an element without what it must have, a joint
            kind that URDF does not know, links that form no single tree.

    Example:
        >>> read_urdf('<robot name="rod"><link name="rod"/></robot>').root
        'rod'
    """
    text, source = _text(urdf)
    try:
        robot = ElementTree.fromstring(text)
    except ElementTree.ParseError as fault:
        raise _error(source, "robot", f"the XML is broken: {fault}") from None
    if robot.tag != "robot":
        raise _error(source, robot.tag, f"the outermost element is <{robot.tag}>, not <robot>")
    robot.attrib.setdefault("name", "robot")
    # Shapes, colours and controllers are none of dynamics' business.
    for child in list(robot):
        if child.tag not in ("link", "joint"):
            robot.remove(child)
    for link in robot.iter("link"):
        for shape in [s for s in link if s.tag != "inertial"]:
            link.remove(shape)
    link_elements = _by_name(robot, "link", source)
    joint_elements = _by_name(robot, "joint", source)
    if not link_elements:
        raise _error(source, "robot", "there is no link in it")
    for name, element in joint_elements.items():
        _check_joint(source, name, element, link_elements)
    links = {name: _link(source, name, e) for name, e in link_elements.items()}
    joints = _joints(source, robot, joint_elements)
    return UrdfModel(source, _root(source, links, joints), links, joints)


def _text(urdf: str | os.PathLike[str]) -> tuple[bytes, str]:
    if isinstance(urdf, str) and urdf.lstrip().startswith("<"):
        return urdf.strip().encode(), "the URDF given as a string"
    path = Path(urdf)
    if path.exists() and not path.is_file():
        raise _error(str(path), "file", "it is no plain file")
    try:
        return path.read_bytes(), str(path)
    except OSError as fault:
        reason = "there is no such file" if not path.exists() else str(fault)
        raise _error(str(path), "file", reason) from None


def _error(source: str, element: str, reason: str) -> UrdfError:
    return UrdfError(f"{source}: {element}: {reason}", source=source, element=element)


def _by_name(robot: ElementTree.Element, tag: str, source: str) -> dict[str, ElementTree.Element]:
    found: dict[str, ElementTree.Element] = {}
    for element in robot.findall(tag):
        name = element.get("name")
        if not name:
            raise _error(source, tag, f"a {tag} has no name")
        if name in found:
            raise _error(source, f'{tag} "{name}"', f"two {tag}s have this name")
        found[name] = element
    return found


def _numbers(
    source: str,
    owner: str,
    element: ElementTree.Element | None,
    attribute: str,
    default: tuple[str, ...],
) -> tuple[str, ...]:
    text = None if element is None else element.get(attribute)
    if element is None or text is None:
        return default
    words = tuple(text.split())
    try:
        finite = all(abs(float(word)) < float("inf") for word in words)
    except ValueError:
        finite = False
    if not finite or len(words) != len(default):
        wanted = f"{len(default)} finite number{'s' if len(default) > 1 else ''}"
        raise _error(source, owner, f'<{element.tag} {attribute}="{text}">: expected {wanted}')
    return words


def _link(source: str, name: str, element: ElementTree.Element) -> UrdfLink:
    inertial = element.find("inertial")
    if inertial is None:
        return UrdfLink(name)
    owner = f'link "{name}"'
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    if mass is None or mass.get("value") is None:
        raise _error(source, owner, "its <inertial> has no <mass value>")
    if inertia is None:
        raise _error(source, owner, "its <inertial> has no <inertia>")
    entries: list[str] = []
    for entry in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"):
        if inertia.get(entry) is None:
            raise _error(source, owner, f"its <inertia> has no {entry}")
        entries += _numbers(source, owner, inertia, entry, ("0",))
    origin = inertial.find("origin")
    value = _numbers(source, owner, mass, "value", ("0",))[0]
    if float(value) < 0:
        raise _error(source, owner, f"its mass is {value} kg")
    return UrdfLink(
        name,
        value,
        _numbers(source, owner, origin, "xyz", _ZERO),
        _numbers(source, owner, origin, "rpy", _ZERO),
        tuple(entries),
    )


def _check_joint(
    source: str,
    name: str,
    element: ElementTree.Element,
    links: dict[str, ElementTree.Element],
) -> None:
    owner = f'joint "{name}"'
    for end in ("parent", "child"):
        found = element.find(end)
        link = None if found is None else found.get("link")
        if link is None:
            raise _error(source, owner, f"it has no <{end} link>")
        if link not in links:
            raise _error(source, owner, f'its {end} link "{link}" does not exist')
    kind = element.get("type")
    if kind not in JOINT_KINDS:
        known = ", ".join(JOINT_KINDS)
        raise _error(source, owner, f'its type "{kind}" is unknown; URDF knows {known}')


def _joints(
    source: str, robot: ElementTree.Element, elements: dict[str, ElementTree.Element]
) -> dict[str, UrdfJoint]:
    # Imported here: it brings trimesh along, which takes a second.
    import yourdfpy

    try:
        read = yourdfpy.URDF.load(
            io.BytesIO(ElementTree.tostring(robot)), build_scene_graph=False, load_meshes=False
        ).robot
    except Exception as fault:  # yourdfpy lets AttributeError and ValueError through
        raise _error(source, "robot", f"yourdfpy cannot read it: {fault}") from fault
    joints = {}
    for joint in read.joints:
        element, owner = elements[joint.name], f'joint "{joint.name}"'
        origin, mimic = element.find("origin"), element.find("mimic")
        axis = _numbers(source, owner, element.find("axis"), "xyz", ("1", "0", "0"))
        if joint.type in ("revolute", "continuous", "prismatic") and not any(map(float, axis)):
            raise _error(source, owner, "its axis has no length")
        mimics = joint.mimic.joint if joint.mimic is not None else ""
        joints[joint.name] = UrdfJoint(
            joint.name,
            joint.type,
            joint.parent,
            joint.child,
            _numbers(source, owner, origin, "xyz", _ZERO),
            _numbers(source, owner, origin, "rpy", _ZERO),
            axis,
            mimics,
            _numbers(source, owner, mimic, "multiplier", ("1",))[0],
            _numbers(source, owner, mimic, "offset", ("0",))[0],
        )
    return joints


def _root(source: str, links: dict[str, UrdfLink], joints: dict[str, UrdfJoint]) -> str:
    above: dict[str, UrdfJoint] = {}
    for joint in joints.values():
        if joint.child in above:
            raise _error(
                source,
                f'link "{joint.child}"',
                f'a loop: it is the child of two joints, "{above[joint.child].name}" and '
                f'"{joint.name}"; leave one out and close it with constraint rows',
            )
        above[joint.child] = joint
    roots = [name for name in links if name not in above]
    if len(roots) > 1:
        raise _error(source, f'link "{roots[1]}"', f'two roots, "{roots[0]}" is the other')
    below: dict[str, list[str]] = {}
    for joint in joints.values():
        below.setdefault(joint.parent, []).append(joint.child)
    reached, ahead = set(roots), list(roots)
    while ahead:
        children = below.get(ahead.pop(), [])
        reached.update(children)
        ahead += children
    astray = [name for name in links if name not in reached]
    if astray:
        raise _error(source, f'link "{astray[0]}"', "a loop: it is below itself")
    return roots[0]
