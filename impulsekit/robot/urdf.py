"""A URDF is read and checked here before Pinocchio sees it.

Pinocchio's reader is C++: a broken file gets one sentence for all faults there, and some
take the interpreter down. This check names the element that is wrong, and Pinocchio gets
only what has passed it, written anew: two readers of one text may understand it differently.
"""

from __future__ import annotations

import io
import os
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any
from xml.sax.saxutils import quoteattr

import numpy as np

from ..errors import MjcfError, UrdfError, a_thing, shown
from ..files import read_text_file, reason_of
from .urdf_elements import MOMENTS, LinkInertial, UrdfJoint, check_tree, read_joints, read_links
from .urdf_numbers import checked_name, number
from .urdf_repairs import is_expanded, repair_text, repair_tree, uses_xacro

if TYPE_CHECKING:
    from xml.etree import ElementTree
    from xml.etree.ElementTree import Element

# A principal moment may exceed the sum of the others by this share of it: files round to few
# digits.
EXCESS = 1e-2
# Links whose largest moment is below this share of the robot's largest are markers and dummies.
DUMMY = 1e-4
# So many links are named.
NAMED = 3


def impossible_inertias(links: Mapping[str, LinkInertial]) -> list[str]:
    """A sentence on the links with a principal moment below zero or above the sum of the others.

    Args:
        links: the inertia of every link by name.
    """
    names, tensors = [], []
    for name, link in links.items():
        ixx, ixy, ixz, iyy, iyz, izz = link.moments
        if ixx or iyy or izz:
            names.append(name)
            tensors.append(((ixx, ixy, ixz), (ixy, iyy, iyz), (ixz, iyz, izz)))
    if not names:
        return []
    # In units of the largest, whose squares are doubles.
    entries = np.array(tensors)
    unit = np.abs(entries).max()
    moments = np.linalg.eigvalsh(entries / unit)
    first, second, third = moments.T
    wrong = (first < -EXCESS * third) | (third > (1.0 + EXCESS) * (first + second))
    found = np.flatnonzero(wrong & (third > DUMMY * third.max()))
    if not len(found):
        return []
    named = ", ".join(
        f'"{names[k]}" ({", ".join(f"{unit * one:.3g}" for one in moments[k])} kg m²)'
        for k in found[:NAMED]
    )
    more = f" and {len(found) - NAMED} more" if len(found) > NAMED else ""
    return [
        f"no body has such principal moments of inertia, one below zero or above the sum of the "
        f"others, as {named}{more}: they are taken as written"
    ]


_INERTIA = ("rotor_inertia", "rotorinertia", "motor_inertia", "motorinertia")
_RATIO = ("gear_ratio", "gearratio", "mechanicalreduction", "mechanical_reduction")


def read_rotors(robot: Element, joints: Sequence[UrdfJoint], source: str) -> Mapping[str, float]:
    """By joint, what its rotor adds to the diagonal of M: ratio² · inertia [kg m², kg].

    Raises:
        UrdfError: a number that is none, or below zero.
    """
    moving = {joint.name for joint in joints if joint.kind != "fixed"}
    rotors = {}
    for transmission in robot.findall("transmission"):
        joint = transmission.find("joint")
        name = None if joint is None else joint.get("name")
        if name not in moving:
            continue
        element = f'transmission of joint "{name}"'
        inertia = _number_of_rotor(transmission, _INERTIA, source, element)
        if inertia:
            ratio = _number_of_rotor(transmission, _RATIO, source, element)
            rotors[str(name)] = inertia * (1.0 if ratio is None else ratio) ** 2
    return rotors


def _number_of_rotor(
    parent: Element, names: tuple[str, ...], source: str, element: str
) -> float | None:
    for child in parent.iter():
        tag = child.tag.rpartition("}")[2] if isinstance(child.tag, str) else ""
        if tag.lower() in names:
            text = child.get("value", child.text)
            least = 0.0 if names is _INERTIA else -float("inf")
            return number((text or "").strip(), source, element, f"<{tag}>", least)
    return None


def plain_urdf(
    name: str,
    links: Mapping[str, LinkInertial],
    joints: Sequence[UrdfJoint],
    shapes: Mapping[str, Sequence[str]] | None = None,
) -> str:
    """The URDF of links and joints.

    Args:
        name: the robot's name.
        links: inertia by name.
        joints: the joints.
        shapes: by link, checked XML of its <visual> and <collision> elements.
    """
    shapes = shapes or {}
    text = [f"<robot name={quoteattr(name)}>"]
    for link, inertial in links.items():
        text.append(f"<link name={quoteattr(link)}>{_inertial(inertial)}")
        text += shapes.get(link, ())
        text.append("</link>")
    text += map(_joint, joints)
    return "".join([*text, "</robot>"])


def _inertial(inertial: LinkInertial) -> str:
    if inertial.mass == 0.0 and not any(inertial.moments):
        return ""
    moments = " ".join(
        f'{key}="{moment!r}"' for key, moment in zip(MOMENTS, inertial.moments, strict=True)
    )
    origin = _origin(inertial.com, inertial.rpy)
    return f'<inertial>{origin}<mass value="{inertial.mass!r}"/><inertia {moments}/></inertial>'


def _joint(joint: UrdfJoint) -> str:
    text = [
        f'<joint name={quoteattr(joint.name)} type="{joint.kind}">',
        f"<parent link={quoteattr(joint.parent)}/><child link={quoteattr(joint.child)}/>",
        _origin(joint.xyz, joint.rpy),
    ]
    if joint.axis is not None:
        text.append(f'<axis xyz="{_listed(joint.axis)}"/>')
    if joint.limit is not None:
        text.append(_element("limit", vars(joint.limit)))
    if joint.dynamics is not None:
        damping, friction = joint.dynamics
        text.append(_element("dynamics", {"damping": damping, "friction": friction}))
    if joint.mimic is not None:
        leader, own = quoteattr(joint.mimic.leader), joint.mimic
        text.append(
            f'<mimic joint={leader} multiplier="{own.multiplier!r}" offset="{own.offset!r}"/>'
        )
    return "".join([*text, "</joint>"])


def _element(tag: str, values: Mapping[str, float]) -> str:
    return f"<{tag} " + " ".join(f'{key}="{value!r}"' for key, value in values.items()) + "/>"


def _origin(xyz: Iterable[float], rpy: Iterable[float]) -> str:
    return f'<origin xyz="{_listed(xyz)}" rpy="{_listed(rpy)}"/>'


def _listed(numbers: Iterable[float]) -> str:
    return " ".join(map(repr, numbers))


HINT = "expand it first: xacro FILE > robot.urdf"


def expanded(text: str, path: str | None) -> str:
    """The URDF that a xacro file stands for.

    xacro evaluates the expressions in the file, so expand files from sources you trust only.

    Args:
        text: the file's text.
        path: where it lies; files that it includes are looked for from there.

    Raises:
        UrdfError: xacro is not installed, or refuses the file; the sentence says why.
    """
    source = path or "URDF text"
    try:
        import xacro
    except ImportError:
        raise UrdfError(
            f"{source}: it is a xacro file, whose macros are not expanded; {HINT}, or "
            'pip install ".[xacro]"',
            source=source,
            element="xacro",
        ) from None
    said = io.StringIO()
    try:
        with redirect_stdout(said), redirect_stderr(said):
            if path is not None:
                return xacro.process_file(path).toxml()
            with tempfile.TemporaryDirectory() as folder:
                own = os.path.join(folder, "robot.xacro")
                with open(own, "w", encoding="utf-8") as file:
                    file.write(text)
                return xacro.process_file(own).toxml()
    except (Exception, SystemExit) as error:  # xacro has no error class of its own for all
        lines = [line for line in (str(error) or said.getvalue()).splitlines() if line.strip()]
        reason = shown(lines[0], 200) if lines else type(error).__name__
        raise UrdfError(
            f"{source}: xacro cannot expand it: {reason}; {HINT}",
            source=source,
            element="xacro",
        ) from None


# Elements within elements: a URDF has five levels.
DEEPEST_ELEMENT = 200
# The readers of other formats, by outermost element.
_READERS = {
    "mujoco": "; this is MJCF: Robot.from_mjcf reads it",
    "sdf": "; this is SDF: Robot.from_sdf reads it",
}


@dataclass(frozen=True)
class UrdfText:
    """A URDF that has passed the check.

    Attributes:
        text: the XML.
        path: the file it came from, or None.
        name: the robot's name.
        inertials: mass and mass centre of every link.
        joints: the joints, in the order of the file.
        root: the parsed <robot>.
        assumptions: what was assumed where the file leaves something open, one sentence each.
        rotors: by joint, what the rotor of its <transmission> adds to the diagonal of M.
    """

    text: str
    path: str | None
    name: str
    inertials: dict[str, LinkInertial]
    joints: tuple[UrdfJoint, ...]
    root: ElementTree.Element
    assumptions: tuple[str, ...] = ()
    rotors: Mapping[str, float] = field(default_factory=dict)

    @property
    def plain(self) -> str:
        """The text that Pinocchio reads: links and joints, without geometry."""

        return plain_urdf(self.name, self.inertials, self.joints)


def read_urdf(path_or_xml: str | os.PathLike[str], *, mimic: bool = False) -> UrdfText:
    """Read a URDF from a file, or take it as XML text if it starts with "<", and check it.

    Files as exporters write them are repaired where the meaning is clear; ``assumptions``
    lists the repairs, and ``text`` is then the repaired URDF. xacro files are expanded if
    the package xacro is installed.

    ``mimic`` tells whether mimic joints will follow their leaders, which must then exist.

    Raises:
        UrdfError: no such file, broken XML, or an element that is wrong; it is named.
    """
    text, path = _text_of(path_or_xml)
    source = path or "URDF text"
    assumed: list[str] = []
    if uses_xacro(text) and not is_expanded(text):
        text = expanded(text, path)
        assumed.append("the macros of xacro are expanded")
    text, repairs = repair_text(text)
    robot = parsed_xml(text, source)
    assumed += repairs + repair_tree(robot, mimic=mimic)
    _check_outermost(robot, source)
    name = checked_name(robot.get("name") or "robot", source, "<robot>")
    inertials = read_links(robot, source)
    joints = read_joints(robot, source, inertials, mimic=mimic)
    check_tree(joints, inertials, source)
    if assumed:
        from xml.etree import ElementTree

        text = ElementTree.tostring(robot, encoding="unicode")
    # What stays as it is written.
    assumed += impossible_inertias(inertials)
    rotors = read_rotors(robot, joints, source)
    return UrdfText(text, path, name, inertials, joints, robot, tuple(assumed), rotors)


def _text_of(path_or_xml: str | os.PathLike[str]) -> tuple[str, str | None]:
    if isinstance(path_or_xml, str) and path_or_xml.lstrip("\ufeff \t\r\n").startswith("<"):
        return path_or_xml.lstrip("\ufeff \t\r\n"), None
    if not isinstance(path_or_xml, str | os.PathLike):
        raise UrdfError(
            f"a URDF is given as a path or as XML text, not as {a_thing(path_or_xml)}",
            source=repr(path_or_xml),
            element="",
        )
    path = os.fspath(path_or_xml)
    try:
        return _lines_of(read_text_file(path)).lstrip(), path
    except (OSError, ValueError) as error:
        raise UrdfError(f"{shown(path, 200)}: {_reason(error)}", source=path, element="") from None


def _lines_of(content: bytes) -> str:
    """Text whose lines all end in a line feed."""
    return content.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")


def _reason(error: OSError | ValueError) -> str:
    if isinstance(error, OSError):
        return reason_of(error)
    if isinstance(error, UnicodeDecodeError):
        return "the file is not UTF-8 text"
    return "a path has no NUL character in it"


def parsed_xml(
    text: str, source: str, kind: type[UrdfError | MjcfError] = UrdfError
) -> ElementTree.Element:
    """The outermost element of a robot file.

    Raises:
        UrdfError, or another ``kind``: it is no XML, or holds what no robot file needs.
    """

    def fault(sentence: str, element: str = "") -> UrdfError | MjcfError:
        return kind(f"{source}: {sentence}", source=source, element=element)

    # A robot has no use for a document type; with it go all tricks with entities.
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise fault(
            "a document type or entity declaration has no place in a robot file; take it out",
            "<!DOCTYPE>",
        )
    from xml.etree import ElementTree

    if not text.strip():
        raise fault("it is empty")
    if not text.startswith("<"):
        raise fault("it does not begin with <, so it is no XML")
    try:
        return _parsed(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise fault(f"not well-formed XML: {_in_words(str(error))}") from None


def _check_outermost(robot: ElementTree.Element, source: str) -> None:
    if robot.tag != "robot":
        reader = _READERS.get(robot.tag, "")
        raise UrdfError(
            f"{source}: the outermost element is <{shown(robot.tag)}>, a URDF has <robot>{reader}",
            source=source,
            element=f"<{shown(robot.tag)}>",
        )


def _in_words(reason: str) -> str:
    """The parser's message, for somebody who has not written a parser."""
    what, _, where = reason.rpartition(": ")
    words = {
        "not well-formed (invalid token)": "a character that cannot stand there (a plain & is "
        "written &amp;, a plain < &lt;)",
        "no element found": "it ends before all its elements are closed",
        "mismatched tag": "an element is closed that was not the last to be opened",
        "duplicate attribute": "an attribute stands twice in one element",
        "syntax error": "text outside all elements",
        "junk after document element": "something stands after the end of <robot>",
        "unbound prefix": "a prefix of a name without its xmlns",
        "undefined entity": "an entity that XML does not know",
    }
    return f"{words[what]}: {where}" if what in words else reason


def _parsed(text: str) -> ElementTree.Element:
    """The outermost element. Depth is bounded: what frees a tree calls itself once a level."""
    from xml.etree import ElementTree

    parser: Any = ElementTree.XMLPullParser(("start", "end"))
    depth, top = 0, None
    for begin in range(0, len(text), 1 << 16):
        parser.feed(text[begin : begin + (1 << 16)])
        for event, element in parser.read_events():
            top = element if top is None else top
            depth += 1 if event == "start" else -1
            if depth > DEEPEST_ELEMENT:
                raise ValueError(f"elements stand more than {DEEPEST_ELEMENT} deep in each other")
    parser.close()
    if top is None:
        raise ValueError("no element in it")
    return top
