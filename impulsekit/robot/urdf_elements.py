"""The links and joints of a URDF, one by one: attributes become checked plain data."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..errors import UnknownNameError, UrdfError, shown
from .urdf_numbers import LARGEST, checked_name, fault, number, numbers

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

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
    """The inertia of a link in a URDF.

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
    """Range [rad, m], effort and velocity limit of a joint."""

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
    """A joint of a URDF.

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


# Pinocchio's reader calls itself once a link: from some 3000 on its stack overflows.
DEEPEST = 1000
# Its time grows with the square of the number of links.
MOST_LINKS = 10_000


def check_tree(joints: Sequence[UrdfJoint], links: Collection[str], source: str) -> None:
    """Prove that links and joints form one tree that Pinocchio can build.

    Raises:
        UrdfError: two parents, several roots, a circle, too deep or too large a tree, or
            a mimic joint whose leader cannot lead.
    """
    joint_to: dict[str, UrdfJoint] = {}
    for joint in joints:
        if joint.child in joint_to:
            both = f'"{joint_to[joint.child].name}" and "{joint.name}"'
            raise fault(
                source, f'link "{joint.child}"', f"joints {both} both lead to it; a URDF is a tree"
            )
        joint_to[joint.child] = joint
    _check_one_root(links, joint_to, source)
    _check_size(joint_to, links, source)
    if any(joint.mimic for joint in joints):
        _check_mimics(joints, source)


def _check_one_root(links: Collection[str], joint_to: dict[str, UrdfJoint], source: str) -> None:
    roots = sorted(set(links) - set(joint_to))
    if len(roots) > 1:
        named = ", ".join(f'"{root}"' for root in roots[:4]) + (", ..." if len(roots) > 4 else "")
        raise UrdfError(
            f"{source}: {len(roots)} links have no parent ({named}); a URDF has one root, and "
            "joints to all other links",
            source=source,
            element=f'link "{roots[1]}"',
        )
    # One parent each and at most one root: what is not below the root runs in a circle.
    below = _depths(joint_to, roots)
    astray = next((link for link in links if link not in below), None)
    if astray is None:
        return
    circle = [astray]
    while (parent := joint_to[circle[-1]].parent) not in circle:
        circle.append(parent)
    circle = circle[circle.index(parent) :]
    around = " < ".join(f'"{link}"' for link in (*circle[:4], circle[0]))
    if len(circle) > 4:
        around = " < ".join(f'"{link}"' for link in circle[:4]) + " < ..."
    raise fault(
        source, f'link "{circle[0]}"', f"its parents run in a circle ({around}); a URDF is a tree"
    )


def _depths(joint_to: dict[str, UrdfJoint], roots: Sequence[str]) -> dict[str, int]:
    """The number of joints between the root and each link that hangs on it."""
    children: dict[str, list[str]] = {}
    for joint in joint_to.values():
        children.setdefault(joint.parent, []).append(joint.child)
    depths = dict.fromkeys(roots, 0)
    waiting = list(roots)
    while waiting:
        link = waiting.pop()
        for child in children.get(link, ()):
            depths[child] = depths[link] + 1
            waiting.append(child)
    return depths


def _check_size(joint_to: dict[str, UrdfJoint], links: Collection[str], source: str) -> None:
    hint = "impulsekit.long takes larger trees"
    if len(links) > MOST_LINKS:
        raise UrdfError(
            f"{source}: it has {len(links)} links, a Robot has {MOST_LINKS} or fewer; {hint}",
            source=source,
            element="<robot>",
        )
    depth = max(_depths(joint_to, sorted(set(links) - set(joint_to))).values())
    if depth > DEEPEST:
        raise UrdfError(
            f"{source}: {depth} joints follow each other, in a Robot {DEEPEST} or fewer; {hint}",
            source=source,
            element="<robot>",
        )


def _check_mimics(joints: Sequence[UrdfJoint], source: str) -> None:
    by_name = {joint.name: joint for joint in joints}
    place = {joint.name: i for i, joint in enumerate(_as_pinocchio_goes(joints))}
    for joint in joints:
        if joint.mimic is None:
            continue
        element, leader = f'joint "{shown(joint.name)}"', by_name.get(joint.mimic.leader)
        if leader is None:
            unknown = UnknownNameError.among("joint", joint.mimic.leader, by_name)
            raise fault(source, element, f"its <mimic>: {unknown}")
        if leader is joint:
            raise fault(source, element, "it mimics itself; name another joint")
        if leader.mimic is not None:
            raise fault(
                source,
                element,
                f'it mimics "{leader.name}", which itself mimics "{leader.mimic.leader}"; '
                "name a joint that mimics none",
            )
        if (joint.kind == "continuous") != (leader.kind == "continuous") or not {
            joint.kind,
            leader.kind,
        } <= {"continuous", "revolute", "prismatic"}:
            raise fault(
                source,
                element,
                f'a {joint.kind} joint cannot mimic "{leader.name}", a {leader.kind} one; both '
                "are continuous, or each is revolute or prismatic",
            )
        if place[leader.name] > place[joint.name]:
            raise fault(
                source,
                element,
                f'it mimics "{leader.name}", which Pinocchio meets later; a leader is above its '
                "follower, or in a branch whose joint comes before in the alphabet",
            )


def _as_pinocchio_goes(joints: Sequence[UrdfJoint]) -> list[UrdfJoint]:
    """The joints in Pinocchio's order: each with all below it, siblings by name."""
    on: dict[str, list[UrdfJoint]] = {}
    for joint in sorted(joints, key=lambda joint: joint.name.encode(), reverse=True):
        on.setdefault(joint.parent, []).append(joint)
    children = {joint.child for joint in joints}
    waiting = [joint for link, own in on.items() if link not in children for joint in own]
    order = []
    while waiting:
        joint = waiting.pop()
        order.append(joint)
        waiting.extend(on.get(joint.child, ()))
    return order
