"""A URDF is read and checked here before Pinocchio sees it.

Pinocchio's reader is C++ and answers a broken file with one sentence for all
faults; this check names the element that is wrong.
"""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..errors import UrdfError

if TYPE_CHECKING:
    from xml.etree import ElementTree

__all__ = ["LinkInertial", "UrdfText", "read_urdf"]

_JOINT_TYPES = frozenset({"revolute", "continuous", "prismatic", "fixed", "floating", "planar"})
_NEED_LIMIT = frozenset({"revolute", "prismatic"})


@dataclass(frozen=True)
class LinkInertial:
    """What a URDF says of a link.

    Attributes:
        mass: [kg]
        com: mass centre in the link's frame [m].
        rpy: the turn of the inertia's axes against the link's [rad], as URDF has it.
        moments: ixx, ixy, ixz, iyy, iyz, izz about the mass centre [kg m²].
    """

    mass: float
    com: tuple[float, float, float]
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    moments: tuple[float, ...] = (0.0,) * 6


@dataclass(frozen=True)
class UrdfText:
    """A URDF that has passed the check.

    Attributes:
        text: the XML.
        path: the file it came from, or None.
        name: the robot's name.
        inertials: mass and mass centre of every link.
    """

    text: str
    path: str | None
    name: str
    inertials: dict[str, LinkInertial]


def read_urdf(path_or_xml: str | os.PathLike[str], *, mimic: bool = False) -> UrdfText:
    """Read a URDF from a file, or take it as XML text if it starts with "<", and check it.

    ``mimic`` tells whether mimic joints will follow their leaders, which must then exist.

    Raises:
        UrdfError: no such file, broken XML, or an element that is wrong; it is named.
    """
    text, path = _text_of(path_or_xml)
    source = path or "URDF text"
    robot = _parse(text, source)
    inertials = _checked_links(robot, source)
    _check_joints(robot, source, set(inertials), mimic)
    return UrdfText(text, path, robot.get("name") or "robot", inertials)


def _text_of(path_or_xml: str | os.PathLike[str]) -> tuple[str, str | None]:
    if isinstance(path_or_xml, str) and path_or_xml.lstrip("\ufeff \t\r\n").startswith("<"):
        return path_or_xml.lstrip("\ufeff \t\r\n"), None
    if not isinstance(path_or_xml, str | os.PathLike):
        raise UrdfError(
            f"a URDF is given as a path or as XML text, not as {type(path_or_xml).__name__}",
            source=repr(path_or_xml),
            element="",
        )
    path = os.fspath(path_or_xml)
    try:
        with open(path, encoding="utf-8-sig") as file:
            return file.read().lstrip(), path
    except (OSError, ValueError) as error:
        reason = {
            FileNotFoundError: "there is no such file",
            IsADirectoryError: "that is a folder, not a file",
            PermissionError: "the file may not be read",
            UnicodeDecodeError: "the file is not UTF-8 text",
        }.get(type(error), str(error))
        raise UrdfError(f"{path}: {reason}", source=path, element="") from None


def _parse(text: str, source: str) -> ElementTree.Element:
    from xml.etree import ElementTree

    # A URDF has no use for a document type; with it go all tricks with entities.
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise UrdfError(
            f"{source}: a document type or entity declaration has no place in a URDF",
            source=source,
            element="<!DOCTYPE>",
        )
    try:
        robot = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise UrdfError(
            f"{source}: not well-formed XML: {error}", source=source, element=""
        ) from None
    if robot.tag != "robot":
        raise UrdfError(
            f"{source}: the outermost element is <{robot.tag}>, a URDF has <robot>",
            source=source,
            element=f"<{robot.tag}>",
        )
    return robot


def _checked_links(robot: ElementTree.Element, source: str) -> dict[str, LinkInertial]:
    elements = list(_named(robot, "link", source))
    if not elements:
        raise UrdfError(f"{source}: the robot has no link", source=source, element="<robot>")
    return {name: _inertial(link, f'link "{name}"', source) for name, link in elements}


def _named(
    robot: ElementTree.Element, tag: str, source: str
) -> Iterator[tuple[str, ElementTree.Element]]:
    elements = robot.findall(tag)
    counts = Counter(element.get("name") for element in elements)
    for element in elements:
        name = element.get("name")
        if not name:
            raise UrdfError(f"{source}: a <{tag}> has no name", source=source, element=f"<{tag}>")
        if counts[name] > 1:
            raise _fault(source, f'{tag} "{name}"', f"the name stands {counts[name]} times")
        yield name, element


def _inertial(link: ElementTree.Element, element: str, source: str) -> LinkInertial:
    inertial = link.find("inertial")
    if inertial is None:
        return LinkInertial(0.0, (0.0, 0.0, 0.0))
    mass_element = inertial.find("mass")
    if mass_element is None:
        raise _fault(source, element, "its <inertial> has no <mass>")
    (mass,) = _numbers(mass_element.get("value"), 1, source, f"{element}: <mass value>")
    if mass < 0.0:
        raise _fault(source, element, f"its mass is {mass:g} kg, wanted is 0 or more")
    inertia = inertial.find("inertia")
    if inertia is None:
        raise _fault(source, element, "its <inertial> has no <inertia>")
    moments = []
    for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"):
        (moment,) = _numbers(inertia.get(key), 1, source, f"{element}: <inertia {key}>")
        # CAD exports round a zero to -1e-20: only a moment that is truly negative is a fault.
        if key in ("ixx", "iyy", "izz") and moment < -1e-12:
            raise _fault(source, element, f"its {key} is {moment:g} kg m², wanted is 0 or more")
        moments.append(moment)
    com, rpy = _origin(inertial, element, source)
    return LinkInertial(mass, com, rpy, tuple(moments))


def _origin(
    parent: ElementTree.Element, element: str, source: str
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    origin = parent.find("origin")
    if origin is None:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    r = _numbers(origin.get("rpy", "0 0 0"), 3, source, f"{element}: <origin rpy>")
    x = _numbers(origin.get("xyz", "0 0 0"), 3, source, f"{element}: <origin xyz>")
    return (x[0], x[1], x[2]), (r[0], r[1], r[2])


def _check_joints(
    robot: ElementTree.Element, source: str, links: set[str], with_mimic: bool
) -> None:
    parent_of: dict[str, str] = {}
    names = set()
    mimics: list[tuple[str, str]] = []
    for name, joint in _named(robot, "joint", source):
        names.add(name)
        element = f'joint "{name}"'
        kind = joint.get("type", "")
        if kind not in _JOINT_TYPES:
            raise _fault(
                source,
                element,
                f'its type is "{kind}", known are {", ".join(sorted(_JOINT_TYPES))}',
            )
        _origin(joint, element, source)
        _check_axis_and_limit(joint, kind, element, source)
        ends = {tag: _link_of(joint, tag, element, source, links) for tag in ("parent", "child")}
        child = ends["child"]
        if child in parent_of:
            raise _fault(source, f'link "{child}"', "it has two parents; a URDF is a tree")
        parent_of[child] = ends["parent"]
        mimic = joint.find("mimic")
        if with_mimic and mimic is not None:
            mimics.append((element, mimic.get("joint", "")))
    for element, leader in mimics:
        if leader not in names:
            raise _fault(source, element, f'it mimics "{leader}", and there is no such joint')
    roots = sorted(links - set(parent_of))
    if len(roots) > 1:
        raise UrdfError(
            f"{source}: {len(roots)} links have no parent ({', '.join(roots[:4])}); "
            "a URDF has one root",
            source=source,
            element=f'link "{roots[1]}"',
        )
    _check_no_loop(parent_of, source)


def _check_no_loop(parent_of: dict[str, str], source: str) -> None:
    # One parent each and one root: what is not below the root runs in a circle.
    sound: set[str] = set()
    for start in parent_of:
        path = []
        link = start
        while link in parent_of and link not in sound:
            path.append(link)
            link = parent_of[link]
            if link == start:
                raise _fault(source, f'link "{start}"', "it is its own ancestor; a URDF is a tree")
            if len(path) > len(parent_of):
                raise _fault(source, f'link "{start}"', "its ancestors run in a circle")
        sound.update(path)


def _link_of(
    joint: ElementTree.Element, tag: str, element: str, source: str, links: set[str]
) -> str:
    end = joint.find(tag)
    link = end.get("link", "") if end is not None else ""
    if link not in links:
        raise _fault(source, element, f'its {tag} link "{link}" does not exist')
    return link


def _check_axis_and_limit(joint: ElementTree.Element, kind: str, element: str, source: str) -> None:
    axis = joint.find("axis")
    if axis is not None and kind != "fixed":
        xyz = _numbers(axis.get("xyz", "1 0 0"), 3, source, f"{element}: <axis xyz>")
        if kind not in ("fixed", "floating") and math.hypot(*xyz) < 1e-12:
            raise _fault(source, element, "its axis has no length")
    limit = joint.find("limit")
    if limit is None:
        if kind in _NEED_LIMIT:
            raise _fault(source, element, f"a {kind} joint needs a <limit>")
        return
    for key in ("lower", "upper", "effort", "velocity"):
        text = limit.get(key)
        if text is None:
            if key in ("effort", "velocity"):
                raise _fault(source, element, f'its <limit> has no "{key}"')
            continue
        try:
            bound = float(text)
        except ValueError:
            bound = math.nan
        if math.isnan(bound):
            raise _fault(source, element, f'its <limit {key}> is "{text}", a number is wanted')


def _numbers(text: str | None, count: int, source: str, what: str) -> tuple[float, ...]:
    try:
        numbers = tuple(float(word) for word in (text or "").split())
    except ValueError:
        numbers = ()
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        wanted = "a finite number" if count == 1 else f"{count} finite numbers"
        raise UrdfError(
            f'{source}: {what} is "{text or ""}", wanted is {wanted}', source=source, element=what
        )
    return numbers


def _fault(source: str, element: str, sentence: str) -> UrdfError:
    return UrdfError(f"{source}: {element}: {sentence}", source=source, element=element)
