"""Repairs of the joints of a URDF where the meaning is clear; see ``urdf_repairs``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .urdf_numbers import listed

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

__all__ = ["repair_balls", "repair_limits", "repair_mimics"]

# The number that exporters write for "no limit"; urdfdom takes no infinity.
UNLIMITED = repr(1.7976931348623157e308)
# Joints whose <limit> URDF requires.
_LIMITED = ("revolute", "prismatic")


def repair_balls(robot: Element) -> list[str]:
    """Spherical joints, as Bullet and MuJoCo read them, become three hinges at one point."""
    told = []
    for joint in robot.findall("joint"):
        name, child = joint.get("name"), joint.find("child")
        if joint.get("type") == "spherical" and name and child is not None:
            at = list(robot).index(joint)
            robot[at : at + 1] = _three_hinges(joint, name, child.get("link", ""))
            told.append(
                f'spherical joint "{name}" is three hinges, "{name}_x", "{name}_y" and "{name}"'
            )
    return told


def _three_hinges(joint: Element, name: str, child: str) -> list[Element]:
    """Hinges about x, y and z of a joint's frame, and two links without mass between them."""
    from xml.etree.ElementTree import Element, SubElement

    parts = []
    hinges = ((f"{name}_x", "1 0 0"), (f"{name}_y", "0 1 0"), (name, "0 0 1"))
    above = [each for each in (joint.find("parent"), joint.find("origin")) if each is not None]
    for own, axis in hinges:
        below = child if own == name else f"{own}__frame"
        hinge = Element("joint", {"name": own, "type": "continuous"})
        hinge.extend(above)
        SubElement(hinge, "child", link=below)
        SubElement(hinge, "axis", xyz=axis)
        parts.append(hinge)
        if own != name:
            parts.append(Element("link", {"name": below}))
        above = [Element("parent", {"link": below})]
    return parts


def repair_limits(robot: Element) -> list[str]:
    """Limits that bound nothing: absent, empty, or written as "none"."""
    from xml.etree.ElementTree import SubElement

    endless, unsaid = [], []
    for joint in robot.findall("joint"):
        name, limit = joint.get("name", ""), joint.find("limit")
        if joint.get("type") not in _LIMITED:
            if limit is not None and _without_negatives(limit):
                unsaid.append(name)
            continue
        if limit is None:
            limit = SubElement(joint, "limit", lower="1", upper="0")
        lower, upper = (_number(limit.get(key, "0")) for key in ("lower", "upper"))
        if lower is not None and upper is not None and lower > upper:
            limit.set("lower", "-" + UNLIMITED)
            limit.set("upper", UNLIMITED)
            endless.append(name)
        for key in ("effort", "velocity"):
            limit.attrib.setdefault(key, "-1")
        if _without_negatives(limit):
            unsaid.append(name)
    told = []
    if endless:
        told.append(
            "without <limit>, or with a lower limit above the upper, a joint has no limit "
            f"({listed(endless)})"
        )
    if unsaid:
        told.append(
            f"effort or velocity limits left out or negative are unlimited ({listed(unsaid)})"
        )
    return told


def _without_negatives(limit: Element) -> bool:
    """Take away bounds of effort and velocity below 0; whether there were any."""
    negative = [key for key in ("effort", "velocity") if (_number(limit.get(key)) or 0.0) < 0.0]
    for key in negative:
        limit.set(key, UNLIMITED)
    return bool(negative)


def repair_mimics(robot: Element) -> list[str]:
    """<mimic> on fixed joints goes; chains of followers are multiplied out to their leader."""
    told, fixed, chained = [], [], []
    followers: dict[str | None, Element] = {}
    for joint in robot.findall("joint"):
        mimic = joint.find("mimic")
        if mimic is None:
            continue
        if joint.get("type") == "fixed":
            joint.remove(mimic)
            fixed.append(joint.get("name", ""))
        else:
            followers[joint.get("name")] = mimic
    for name, mimic in followers.items():
        if _is_circle(name, followers):
            continue
        while (leader := mimic.get("joint")) in followers:
            own, above = _line(mimic), _line(followers[leader])
            if own is None or above is None:
                break
            # y = m1 (m2 y'' + o2) + o1
            mimic.set("joint", followers[leader].get("joint", ""))
            mimic.set("multiplier", repr(own[0] * above[0]))
            mimic.set("offset", repr(own[0] * above[1] + own[1]))
            chained.append(str(name))
    if fixed:
        told.append(f"<mimic> on a fixed joint is ignored ({listed(fixed)})")
    if chained:
        names = list(dict.fromkeys(chained))
        told.append(f"a mimic joint that follows another follows its leader ({listed(names)})")
    return told


def _is_circle(name: str | None, followers: dict[str | None, Element]) -> bool:
    seen = set()
    while name in followers and name not in seen:
        seen.add(name)
        name = followers[name].get("joint")
    return name in seen


def _line(mimic: Element) -> tuple[float, float] | None:
    multiplier = _number(mimic.get("multiplier", "1"))
    offset = _number(mimic.get("offset", "0"))
    return None if multiplier is None or offset is None else (multiplier, offset)


def _number(text: str | None) -> float | None:
    """The number that stands there; None for what the strict check will name."""
    try:
        value = float(text or "")
    except ValueError:
        return None
    return value if value == value else None
