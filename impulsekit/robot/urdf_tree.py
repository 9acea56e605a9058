"""How the links and joints of a URDF hang together: one root, no circle, leaders that exist."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from ..errors import UnknownNameError, UrdfError, shown
from .urdf_elements import UrdfJoint
from .urdf_numbers import fault

__all__ = ["DEEPEST", "MOST_LINKS", "check_tree"]

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
    """How many joints lie between the root and each link that hangs on it."""
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
