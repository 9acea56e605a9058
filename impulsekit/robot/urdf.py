"""A URDF is read and checked here before Pinocchio sees it.

Pinocchio's reader is C++: a broken file gets one sentence for all faults there, and some
take the interpreter down. This check names the element that is wrong, and Pinocchio gets
only what has passed it.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from ..errors import MjcfError, UrdfError, a_thing, shown
from ..files import read_text_file, reason_of
from .impossible_inertia import told_if_impossible
from .urdf_elements import LinkInertial, UrdfJoint, read_joints, read_links
from .urdf_numbers import checked_name
from .urdf_repairs import is_expanded, repair_text, repair_tree, uses_xacro
from .urdf_rotors import read_rotors
from .urdf_tree import check_tree
from .xacro_files import expanded

if TYPE_CHECKING:
    from xml.etree import ElementTree

__all__ = ["LinkInertial", "UrdfText", "parsed_xml", "read_urdf"]

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
        """What Pinocchio gets to read: links and joints, without geometry."""
        from .urdf_plain import plain_urdf

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
    assumed += told_if_impossible(inertials)
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
    """What the parser says, for somebody who has not written a parser."""
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
