"""Links and joints of a URDF as checked plain data, and written as XML again."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from ..errors import UnknownNameError, UrdfError, shown
from .arrays import LARGEST
from .robot_xml import Place, element, xml_of
from .source import LinkInertial, Triple

# [kg m²] A moment of inertia below this is negative, and not a rounded 0.
NEGATIVE = -1e-12
# A direction shorter than this has none.
NO_AXIS = 1e-12

JOINT_TYPES = ("continuous", "fixed", "floating", "planar", "prismatic", "revolute")
MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_WITH_AXIS = ("revolute", "continuous", "prismatic", "planar")
# Pinocchio's name of the world.
_RESERVED = "universe"


@dataclass(frozen=True)
class UrdfJoint:
    """A joint of a URDF.

    Attributes:
        name, kind, parent, child: as they stand there.
        xyz, rpy: of its origin in the parent link [m, rad].
        axis: in the joint's frame; None for a joint that has none.
        limit: lower, upper [rad, m], effort and velocity; None where there is none.
        dynamics: damping and friction; None where there is none.
        mimic: the leader, multiplier and offset; None for a joint that moves on its own.
    """

    name: str
    kind: str
    parent: str
    child: str
    xyz: Triple
    rpy: Triple
    axis: Triple | None
    limit: dict[str, float] | None
    dynamics: dict[str, float] | None
    mimic: tuple[str, float, float] | None


def read_links(robot: Element, source: str) -> dict[str, LinkInertial]:
    """Return the inertia of every link by name.

    Raises:
        UrdfError: it names the link and the fault.
    """
    links = {name: _inertial(link, place) for name, link, place in _named(robot, "link", source)}
    if not links:
        raise Place(source).fault("the robot has no link, a URDF has one or more", "<robot>")
    return links


def read_joints(
    robot: Element, source: str, links: dict[str, LinkInertial], *, mimic: bool
) -> tuple[UrdfJoint, ...]:
    """Return the joints in the order of the file; ``mimic`` says whether <mimic> counts.

    Raises:
        UrdfError: it names the joint and the fault.
    """
    joints = []
    for name, joint, place in _named(robot, "joint", source):
        kind = joint.get("type")
        if kind not in JOINT_TYPES:
            given = "it has no type" if kind is None else f'its type is "{shown(kind)}"'
            raise place.fault(f"{given}, expected one of {', '.join(JOINT_TYPES)}")
        xyz, rpy = _origin(joint, place)
        parent, child = (_link_of(joint, tag, place, links) for tag in ("parent", "child"))
        axis, limit = _axis(joint, kind, place), _limit(joint, place)
        dynamics, follows = _dynamics(joint, place), _mimic(joint, place) if mimic else None
        own = UrdfJoint(name, kind, parent, child, xyz, rpy, axis, limit, dynamics, follows)
        joints.append(own)
    return tuple(joints)


def _named(robot: Element, tag: str, source: str) -> Iterator[tuple[str, Element, Place]]:
    elements = robot.findall(tag)
    counts = Counter(item.get("name") for item in elements)
    for number, item in enumerate(elements, start=1):
        name = item.get("name")
        if not name:
            raise Place(source, f"<{tag}> number {number}").fault('it has no name="..."')
        place = Place(source, f'{tag} "{shown(name)}"')
        place.name(name)
        if name == _RESERVED:
            raise place.fault("this name stands for the world; rename it")
        if counts[name] > 1:
            raise place.fault(f"{counts[name]} {tag}s have this name, each needs one of its own")
        yield name, item, place


def _inertial(link: Element, place: Place) -> LinkInertial:
    inertial = link.find("inertial")
    if inertial is None:
        return LinkInertial(0.0, (0.0, 0.0, 0.0))
    found = {tag: inertial.find(tag) for tag in ("mass", "inertia")}
    for tag, part in found.items():
        if part is None:
            raise place.fault(f"its <inertial> has no <{tag}>")
    values = {tag: part.attrib for tag, part in found.items() if part is not None}
    mass = place.number(values["mass"].get("value"), "<mass value> [kg]", 0.0)
    moments = []
    for key in MOMENTS:
        moment = place.number(values["inertia"].get(key), f"<inertia {key}> [kg m²]")
        # CAD exports round a zero to -1e-20: only a moment that is truly negative is a fault.
        if key in ("ixx", "iyy", "izz") and moment < NEGATIVE:
            raise place.fault(f"its {key} must be 0 or more, got {moment:g} kg m²")
        moments.append(moment)
    return LinkInertial(mass, *_origin(inertial, place), tuple(moments))


def _origin(parent: Element, place: Place) -> tuple[Triple, Triple]:
    origin = parent.find("origin")
    if origin is None:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    xyz = place.numbers(origin.get("xyz", "0 0 0"), 3, "<origin xyz> [m]")
    return xyz, place.numbers(origin.get("rpy", "0 0 0"), 3, "<origin rpy> [rad]")


def _link_of(joint: Element, tag: str, place: Place, links: Collection[str]) -> str:
    end = joint.find(tag)
    link = None if end is None else end.get("link")
    if link is None:
        raise place.fault(f'it has no <{tag} link="...">')
    if link not in links:
        raise place.fault(f"its <{tag}>: {UnknownNameError.among('link', link, links)}")
    return link


def _axis(joint: Element, kind: str, place: Place) -> Triple | None:
    axis = joint.find("axis")
    if axis is None or kind not in _WITH_AXIS:
        return None
    xyz = place.numbers(axis.get("xyz", "1 0 0"), 3, "<axis xyz>")
    if math.hypot(*xyz) < NO_AXIS:
        raise place.fault("its <axis> has no length, expected a direction")
    return xyz


def _limit(joint: Element, place: Place) -> dict[str, float] | None:
    limit, bounds = joint.find("limit"), {}
    if limit is None:
        return None
    for key in ("lower", "upper", "effort", "velocity"):
        text = limit.get(key, "0")
        try:
            # The largest double stands for "no limit".
            unlimited = LARGEST < abs(float(text)) < math.inf
        except ValueError:
            unlimited = False
        bounds[key] = float(text) if unlimited else place.number(text, f"<limit {key}>")
    return bounds


def _dynamics(joint: Element, place: Place) -> dict[str, float] | None:
    own = joint.find("dynamics")
    if own is None:
        return None
    keys = ("damping", "friction")
    return {key: place.number(own.get(key, "0"), f"<dynamics {key}>", 0.0) for key in keys}


def _mimic(joint: Element, place: Place) -> tuple[str, float, float] | None:
    mimic = joint.find("mimic")
    if mimic is None:
        return None
    leader = mimic.get("joint")
    if not leader:
        raise place.fault('its <mimic> has no joint="..."')
    multiplier, offset = (
        place.number(mimic.get(key, default), f"<mimic {key}>")
        for key, default in (("multiplier", "1"), ("offset", "0"))
    )
    return leader, multiplier, offset


def plain_urdf(name: str, links: Mapping[str, LinkInertial], joints: Sequence[UrdfJoint]) -> str:
    """Return the URDF of links and joints, without geometry."""
    robot = element("robot", name=name)
    for link, own in links.items():
        inertial = None
        if own.mass or any(own.moments):
            origin = element("origin", xyz=own.com, rpy=own.rpy)
            moments = element("inertia", **dict(zip(MOMENTS, own.moments, strict=True)))
            inertial = element("inertial", origin, element("mass", value=own.mass), moments)
        robot.append(element("link", inertial, name=link))
    robot.extend(map(_joint_element, joints))
    return xml_of(robot)


def _joint_element(joint: UrdfJoint) -> Element:
    mimic = None
    if joint.mimic is not None:
        leader, multiplier, offset = joint.mimic
        mimic = element("mimic", joint=leader, multiplier=multiplier, offset=offset)
    return element(
        "joint",
        element("parent", link=joint.parent),
        element("child", link=joint.child),
        element("origin", xyz=joint.xyz, rpy=joint.rpy),
        None if joint.axis is None else element("axis", xyz=joint.axis),
        None if joint.limit is None else element("limit", **joint.limit),
        None if joint.dynamics is None else element("dynamics", **joint.dynamics),
        mimic,
        name=joint.name,
        type=joint.kind,
    )


# Pinocchio's reader calls itself once a link: from some 3000 on its stack overflows.
DEEPEST = 1000
# Its time grows with the square of the number of links.
MOST_LINKS = 10_000


def check_tree(joints: Sequence[UrdfJoint], links: Collection[str], source: str) -> None:
    """Check that links and joints form one tree that Pinocchio can build.

    Raises:
        UrdfError: two parents, several roots, a circle, too deep or too large a tree, or
            a mimic joint whose leader cannot lead.
    """
    joint_to: dict[str, UrdfJoint] = {}
    for joint in joints:
        if joint.child in joint_to:
            both = f'"{joint_to[joint.child].name}" and "{joint.name}"'
            place = Place(source, f'link "{joint.child}"')
            raise place.fault(f"joints {both} both lead to it; a URDF is a tree")
        joint_to[joint.child] = joint
    roots = sorted(set(links) - set(joint_to))
    if len(roots) > 1:
        named = ", ".join(f'"{root}"' for root in roots[:4]) + (", ..." if len(roots) > 4 else "")
        raise Place(source).fault(
            f"{len(roots)} links have no parent ({named}); a URDF has one root, and joints to all "
            "other links",
            f'link "{roots[1]}"',
        )
    order = depth_first(joints)
    # One parent each and at most one root: what is not below the root runs in a circle.
    below = {*roots, *(joint.child for joint in order)}
    astray = next((link for link in links if link not in below), None)
    if astray is not None:
        raise _circle(astray, joint_to, source)
    _check_size(order, roots[0], len(links), source)
    _check_mimics(joints, {joint.name: i for i, joint in enumerate(order)}, source)


def depth_first(joints: Sequence[UrdfJoint]) -> list[UrdfJoint]:
    """Return the joints in Pinocchio's order: each with all below it, siblings by name."""
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


def _circle(astray: str, joint_to: dict[str, UrdfJoint], source: str) -> UrdfError:
    """The error for a link whose parents never reach the root."""
    circle = [astray]
    while (parent := joint_to[circle[-1]].parent) not in circle:
        circle.append(parent)
    circle = circle[circle.index(parent) :]
    around = " < ".join(f'"{link}"' for link in (*circle[:4], circle[0]))
    if len(circle) > 4:
        around = " < ".join(f'"{link}"' for link in circle[:4]) + " < ..."
    place = Place(source, f'link "{circle[0]}"')
    return place.fault(f"its parents run in a circle ({around}); a URDF is a tree")


def _check_size(order: Sequence[UrdfJoint], root: str, count: int, source: str) -> None:
    depths, hint = {root: 0}, "impulsekit.long takes larger trees"
    for joint in order:
        depths[joint.child] = depths[joint.parent] + 1
    if count > MOST_LINKS:
        sentence = f"it has {count} links, a Robot has {MOST_LINKS} or fewer; {hint}"
        raise Place(source).fault(sentence, "<robot>")
    if (depth := max(depths.values())) > DEEPEST:
        sentence = f"{depth} joints follow each other, in a Robot {DEEPEST} or fewer; {hint}"
        raise Place(source).fault(sentence, "<robot>")


def _check_mimics(joints: Sequence[UrdfJoint], order: dict[str, int], source: str) -> None:
    by_name = {joint.name: joint for joint in joints}
    for joint in joints:
        if joint.mimic is None:
            continue
        place, leader = Place(source, f'joint "{shown(joint.name)}"'), by_name.get(joint.mimic[0])
        if leader is None:
            unknown = UnknownNameError.among("joint", joint.mimic[0], by_name)
            raise place.fault(f"its <mimic>: {unknown}")
        if leader is joint:
            raise place.fault("it mimics itself; name another joint")
        if leader.mimic is not None:
            raise place.fault(
                f'it mimics "{leader.name}", which itself mimics "{leader.mimic[0]}"; '
                "name a joint that mimics none"
            )
        kinds = {joint.kind, leader.kind}
        if kinds != {"continuous"} and not kinds <= {"revolute", "prismatic"}:
            raise place.fault(
                f'a {joint.kind} joint cannot mimic "{leader.name}", a {leader.kind} one; both '
                "are continuous, or each is revolute or prismatic"
            )
        if order[leader.name] > order[joint.name]:
            raise place.fault(
                f'it mimics "{leader.name}", which Pinocchio meets later; a leader is above its '
                "follower, or in a branch whose joint comes before in the alphabet"
            )
