"""Repairs of URDF files as exporters write them, where the meaning is clear.

Each repair changes the parsed XML and returns a sentence that says what was assumed.
What is not clear stays as it is, and the strict check that follows names it.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from .urdf_numbers import are_numbers, listed

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

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


_PRODUCTS = ("ixy", "ixz", "iyz")


def with_world_link(robot: Element, links: set[str | None]) -> list[str]:
    """A link "world" that joints name as their parent, and that is the only one missing."""
    from xml.etree.ElementTree import Element as NewElement

    missing = {
        end.get("link")
        for joint in robot.findall("joint")
        for end in (joint.find("parent"), joint.find("child"))
        if end is not None and end.get("link") not in links
    }
    if missing != {"world"} or not links:
        return []
    robot.insert(0, NewElement("link", {"name": "world"}))
    return ['link "world" is missing; it is taken as a link without mass']


def repair_inertias(robot: Element) -> list[str]:
    """<inertial> without <mass> says nothing; without <inertia> it is a point's."""
    from xml.etree.ElementTree import SubElement

    no_mass, points = [], []
    for link in robot.findall("link"):
        inertial = link.find("inertial")
        if inertial is None:
            continue
        if inertial.find("mass") is None:
            # An inertia without a mass is a slip that nobody but the author can mend.
            if inertial.find("inertia") is None:
                link.remove(inertial)
                no_mass.append(link.get("name", ""))
        elif inertial.find("inertia") is None:
            SubElement(inertial, "inertia", ixx="0", iyy="0", izz="0", ixy="0", ixz="0", iyz="0")
            points.append(link.get("name", ""))
    told = []
    if no_mass:
        told.append(f"a link whose <inertial> has no <mass> has none ({listed(no_mass)})")
    if points:
        told.append(
            "a link whose <inertial> has no <inertia> is a point mass at its mass centre "
            f"({listed(points)})"
        )
    return told + _products_of_inertia(robot)


def _products_of_inertia(robot: Element) -> list[str]:
    names = []
    for link in robot.findall("link"):
        inertia = link.find("inertial/inertia")
        if inertia is None or not all(key in inertia.attrib for key in ("ixx", "iyy", "izz")):
            continue
        absent = [key for key in _PRODUCTS if key not in inertia.attrib]
        for key in absent:
            inertia.set(key, "0")
        if absent:
            names.append(link.get("name", ""))
    if not names:
        return []
    return [f"products of inertia that are left out are 0 ({listed(names)})"]


def without_shapeless(robot: Element) -> list[str]:
    """<visual> in which no shape stands: there is nothing to be drawn."""
    names = []
    for link in robot.findall("link"):
        for item in link.findall("visual"):
            geometry = item.find("geometry")
            if geometry is None or not len(geometry):
                link.remove(item)
                names.append(link.get("name", ""))
    return [f"<visual> without a shape is ignored ({listed(names)})"] if names else []


# What xacro writes at the top of what it has expanded.
_BY_XACRO = "This document was autogenerated by xacro"
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
# A comment that ends at its first "-->": with ".*?" many of them take exponential time.
_COMMENTS_FIRST = re.compile(r"^(?:\s*<!--(?:(?!-->).)*-->)+\s*(?=<\?xml)", re.DOTALL)
_PREFIX_OF_NAME = re.compile(r"</?([A-Za-z_][\w.-]*):|\s([A-Za-z_][\w.-]*):[\w.-]+\s*=")
_DECLARED = re.compile(r"xmlns:([A-Za-z_][\w.-]*)\s*=")
# A comma with a blank behind it; without one it could stand for a decimal point.
_LISTING = re.compile(r",(?=\s)")
# A number with one point more behind it.
_DOTTED = re.compile(r"(\d*\.\d+)\.(?=\s|$)")
# What a joint or a link has one of at most.
_ONCE = ("axis", "child", "dynamics", "inertial", "limit", "mimic", "origin", "parent")
_STRINGS_AND_COMMENTS = re.compile(r"<!--.*?-->|\"[^\"]*\"|'[^']*'", re.DOTALL)


def uses_xacro(text: str) -> bool:
    """Return whether the text holds macros or substitutions of xacro.

    A file that only declares the namespace, as expanded ones still do, holds none.
    """
    if "xacro" not in text and "$" not in text:
        return False
    bare = _COMMENT.sub("", text)
    spaces = re.findall(r"xmlns:(\w+)\s*=\s*[\"'][^\"']*xacro[^\"']*[\"']", bare)
    if any(f"<{prefix}:" in bare for prefix in {*spaces, "xacro"}):
        return True
    return "${" in bare or "$(" in bare


def is_expanded(text: str) -> bool:
    """Return whether xacro wrote the text itself.

    What it did not know stands in it as it stood in the source, as an element.
    """
    bare = _COMMENT.sub("", text)
    return _BY_XACRO in text and "${" not in bare and "$(" not in bare


def repair_text(text: str, outermost: str = "robot") -> tuple[str, list[str]]:
    """The text as XML that a parser takes, and a sentence for each repair.

    Repairs: NUL characters at the end, comments before the XML declaration, prefixes that
    no xmlns declares. They are declared at the ``outermost`` element.
    """
    told = []
    if text.endswith("\0"):
        text = text.rstrip("\0 \t\r\n")
        told.append(f"NUL characters after </{outermost}> are ignored")
    if found := _COMMENTS_FIRST.match(text):
        text = text[found.end() :]
        told.append("a comment before <?xml is ignored")
    bare = _STRINGS_AND_COMMENTS.sub('""', text)
    used = {a or b for a, b in _PREFIX_OF_NAME.findall(bare)} - {"xml", "xmlns"}
    if unknown := sorted(used - set(_DECLARED.findall(bare))):
        declared = "".join(f' xmlns:{prefix}="urn:undeclared:{prefix}"' for prefix in unknown)
        text = re.sub(rf"<{outermost}\b", f"<{outermost}{declared}", text, count=1)
        told.append(f"the prefix {listed(unknown)} without xmlns is declared")
    return text, told


def repair_tree(robot: Element, *, mimic: bool) -> list[str]:
    """Repair a parsed <robot> in place; a sentence for each kind of repair.

    Args:
        robot: the outermost element.
        mimic: whether <mimic> counts.
    """
    told = _without_namespace(robot)
    told += _unknown_macros(robot)
    told += _in_capitals(robot)
    told += _repeated(robot)
    links = {link.get("name") for link in robot.findall("link")}
    told += with_world_link(robot, links)
    told += repair_inertias(robot)
    told += repair_balls(robot)
    told += _punctuation(robot)
    told += repair_limits(robot)
    told += without_shapeless(robot)
    if mimic:
        told += repair_mimics(robot)
    return told


def _without_namespace(robot: Element) -> list[str]:
    space = robot.tag.partition("}")[0] + "}" if robot.tag.startswith("{") else ""
    if not space:
        return []
    for element in robot.iter():
        if isinstance(element.tag, str) and element.tag.startswith(space):
            element.tag = element.tag[len(space) :]
    return [f'the namespace "{space[1:-1]}" is ignored']


def _unknown_macros(robot: Element) -> list[str]:
    """Calls of macros that xacro did not know and left in what it wrote."""
    names = []
    for parent in list(robot.iter()):
        for child in list(parent):
            if isinstance(child.tag, str) and "xacro}" in child.tag.partition("}")[0] + "}":
                parent.remove(child)
                names.append(child.tag.rpartition("}")[2])
    if not names:
        return []
    return [f"macros that xacro left unexpanded are left out ({listed(sorted(set(names)))})"]


def _in_capitals(robot: Element) -> list[str]:
    """Elements that URDF writes in small letters: readers of URDF pass over them."""
    found: dict[str, list[str]] = {}
    for element in (*robot.findall("joint"), *robot.findall("link")):
        for child in element:
            if isinstance(child.tag, str) and child.tag.lower() in _ONCE and child.tag not in _ONCE:
                found.setdefault(child.tag, []).append(element.get("name", ""))
    return [
        f"<{tag}> is ignored, URDF writes <{tag.lower()}> ({listed(names)})"
        for tag, names in found.items()
    ]


def _repeated(robot: Element) -> list[str]:
    found: dict[str, list[str]] = {}
    for element in (*robot.findall("joint"), *robot.findall("link")):
        for tag in _ONCE:
            if len(element.findall(tag)) > 1:
                found.setdefault(tag, []).append(element.get("name", ""))
    return [
        f"of several <{tag}> the first counts ({listed(names)})" for tag, names in found.items()
    ]


def _punctuation(robot: Element) -> list[str]:
    """Commas between numbers, and a second point behind one, in joints, inertias and shapes."""
    changed: list[str] = []
    for element in (*robot.findall("joint"), *robot.findall("link")):
        before = len(changed)
        for item in element.iter():
            for key, text in item.attrib.items():
                plain = _DOTTED.sub(r"\1", _LISTING.sub(" ", text))
                if plain != text and are_numbers(plain):
                    item.set(key, plain)
                    changed.append(element.get("name", ""))
        del changed[before + 1 :]
    if not changed:
        return []
    return [f"commas between numbers, and a point behind one, are ignored ({listed(changed)})"]
