"""The links and joints of a URDF, one by one: attributes become checked plain data."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..errors import UnknownNameError, UrdfError, shown
from .urdf_numbers import LARGEST, checked_name, fault, number, numbers

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

__all__ = ["JointLimit", "LinkInertial", "Mimic", "UrdfJoint", "read_joints", "read_links"]

# [kg m²] A moment of inertia below this is negative, and not a rounded 0.
NEGATIVE = -1e-12
# A direction shorter than this has none.
NO_AXIS = 1e-12

Triple = tuple[float, float, float]

JOINT_TYPES = ("continuous", "fixed", "floating", "planar", "prismatic", "revolute")
MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_WITH_AXIS = ("revolute", "continuous", "prismatic", "planar")
# Pinocchio's name of the world.
_RESERVED = "universe"


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
    com: Triple
    rpy: Triple = (0.0, 0.0, 0.0)
    moments: tuple[float, ...] = (0.0,) * 6


@dataclass(frozen=True)
class JointLimit:
    """How far a joint goes [rad, m], how strong and how fast it is."""

    lower: float
    upper: float
    effort: float
    velocity: float


@dataclass(frozen=True)
class Mimic:
    """The joint that another follows: y = multiplier · y_leader + offset."""

    leader: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class UrdfJoint:
    """What a URDF says of a joint.

    Attributes:
        name, kind, parent, child: as they stand there.
        xyz, rpy: of its origin in the parent link [m, rad].
        axis: in the joint's frame; None for a joint that has none.
        limit: None where there is none.
        dynamics: damping and friction.
        mimic: None for a joint that moves on its own.
    """

    name: str
    kind: str
    parent: str
    child: str
    xyz: Triple = (0.0, 0.0, 0.0)
    rpy: Triple = (0.0, 0.0, 0.0)
    axis: Triple | None = None
    limit: JointLimit | None = None
    dynamics: tuple[float, float] | None = None
    mimic: Mimic | None = None


def read_links(robot: Element, source: str) -> dict[str, LinkInertial]:
    """The inertia of every link by name.

    Raises:
        UrdfError: it names the link and the fault.
    """
    links = {
        name: _inertial(e, f'link "{name}"', source) for name, e in _named(robot, "link", source)
    }
    if not links:
        raise UrdfError(
            f"{source}: the robot has no link, a URDF has one or more",
            source=source,
            element="<robot>",
        )
    return links


def read_joints(
    robot: Element, source: str, links: dict[str, LinkInertial], *, mimic: bool
) -> tuple[UrdfJoint, ...]:
    """The joints in the order of the file; ``mimic`` tells whether <mimic> counts.

    Raises:
        UrdfError: it names the joint and the fault.
    """
    return tuple(
        _joint(element, name, source, links, mimic=mimic)
        for name, element in _named(robot, "joint", source)
    )


def _named(robot: Element, tag: str, source: str) -> Iterator[tuple[str, Element]]:
    elements = robot.findall(tag)
    counts = Counter(element.get("name") for element in elements)
    for place, element in enumerate(elements, start=1):
        name = element.get("name")
        if not name:
            raise fault(source, f"<{tag}> number {place}", 'it has no name="..."')
        called = f'{tag} "{shown(name)}"'
        checked_name(name, source, called)
        if name == _RESERVED:
            raise fault(source, called, "this name stands for the world; rename it")
        if counts[name] > 1:
            raise fault(
                source, called, f"{counts[name]} {tag}s have this name, each needs one of its own"
            )
        yield name, element


def _inertial(link: Element, element: str, source: str) -> LinkInertial:
    inertial = link.find("inertial")
    if inertial is None:
        return LinkInertial(0.0, (0.0, 0.0, 0.0))
    mass_element, inertia = (_part(inertial, tag, element, source) for tag in ("mass", "inertia"))
    mass = number(mass_element.get("value"), source, element, "<mass value> [kg]", 0.0)
    moments = []
    for key in MOMENTS:
        moment = number(inertia.get(key), source, element, f"<inertia {key}> [kg m²]")
        # CAD exports round a zero to -1e-20: only a moment that is truly negative is a fault.
        if key in ("ixx", "iyy", "izz") and moment < NEGATIVE:
            raise fault(source, element, f"its {key} must be 0 or more, got {moment:g} kg m²")
        moments.append(moment)
    return LinkInertial(mass, *_origin(inertial, element, source), tuple(moments))


def _part(inertial: Element, tag: str, element: str, source: str) -> Element:
    part = inertial.find(tag)
    if part is None:
        raise fault(source, element, f"its <inertial> has no <{tag}>")
    return part


def _origin(parent: Element, element: str, source: str) -> tuple[Triple, Triple]:
    origin = parent.find("origin")
    if origin is None:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    xyz = numbers(origin.get("xyz", "0 0 0"), 3, source, element, "<origin xyz> [m]")
    return xyz, numbers(origin.get("rpy", "0 0 0"), 3, source, element, "<origin rpy> [rad]")


def _joint(
    joint: Element, name: str, source: str, links: dict[str, LinkInertial], *, mimic: bool
) -> UrdfJoint:
    element = f'joint "{shown(name)}"'
    kind = joint.get("type")
    if kind not in JOINT_TYPES:
        given = "it has no type" if kind is None else f'its type is "{shown(kind)}"'
        raise fault(source, element, f"{given}, expected one of {', '.join(JOINT_TYPES)}")
    xyz, rpy = _origin(joint, element, source)
    return UrdfJoint(
        name,
        kind,
        _link_of(joint, "parent", element, source, links),
        _link_of(joint, "child", element, source, links),
        xyz,
        rpy,
        _axis(joint, kind, element, source),
        _limit(joint, element, source),
        _dynamics(joint, element, source),
        _mimic(joint, element, source) if mimic else None,
    )


def _link_of(
    joint: Element, tag: str, element: str, source: str, links: dict[str, LinkInertial]
) -> str:
    end = joint.find(tag)
    link = None if end is None else end.get("link")
    if link is None:
        raise fault(source, element, f'it has no <{tag} link="...">')
    if link not in links:
        unknown = UnknownNameError.among("link", link, links)
        raise fault(source, element, f"its <{tag}>: {unknown}")
    return link


def _axis(joint: Element, kind: str, element: str, source: str) -> Triple | None:
    axis = joint.find("axis")
    if axis is None or kind not in _WITH_AXIS:
        return None
    xyz = numbers(axis.get("xyz", "1 0 0"), 3, source, element, "<axis xyz>")
    if math.hypot(*xyz) < NO_AXIS:
        raise fault(source, element, "its <axis> has no length, expected a direction")
    return xyz


def _limit(joint: Element, element: str, source: str) -> JointLimit | None:
    limit = joint.find("limit")
    if limit is None:
        return None
    lower, upper, effort, velocity = (
        _bound(limit, key, element, source) for key in ("lower", "upper", "effort", "velocity")
    )
    return JointLimit(lower, upper, effort, velocity)


def _bound(limit: Element, key: str, element: str, source: str) -> float:
    text = limit.get(key, "0")
    try:
        # The largest double stands for "no limit".
        if LARGEST < abs(float(text)) < math.inf:
            return float(text)
    except ValueError:
        pass
    return number(text, source, element, f"<limit {key}>")


def _dynamics(joint: Element, element: str, source: str) -> tuple[float, float] | None:
    dynamics = joint.find("dynamics")
    if dynamics is None:
        return None
    damping, friction = (
        number(dynamics.get(key, "0"), source, element, f"<dynamics {key}>", 0.0)
        for key in ("damping", "friction")
    )
    return damping, friction


def _mimic(joint: Element, element: str, source: str) -> Mimic | None:
    mimic = joint.find("mimic")
    if mimic is None:
        return None
    leader = mimic.get("joint")
    if not leader:
        raise fault(source, element, 'its <mimic> has no joint="..."')
    multiplier, offset = (
        number(mimic.get(key, default), source, element, f"<mimic {key}>")
        for key, default in (("multiplier", "1"), ("offset", "0"))
    )
    return Mimic(leader, multiplier, offset)
