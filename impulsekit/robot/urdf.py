"""A URDF is read and checked here before Pinocchio sees it.

Pinocchio's reader is C++: a broken file gets one sentence for all faults there, and some
take the interpreter down. This check names the element that is wrong, and Pinocchio gets
only what has passed it.
"""

from __future__ import annotations

import os
import stat
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..errors import UrdfError, shown
from .urdf_elements import LinkInertial, UrdfJoint, read_joints, read_links
from .urdf_numbers import checked_name
from .urdf_tree import check_tree

if TYPE_CHECKING:
    from xml.etree import ElementTree

__all__ = ["LinkInertial", "UrdfText", "read_urdf"]

# Elements within elements: a URDF has five levels.
DEEPEST_ELEMENT = 200


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
    """

    text: str
    path: str | None
    name: str
    inertials: dict[str, LinkInertial]
    joints: tuple[UrdfJoint, ...]
    root: ElementTree.Element

    @property
    def plain(self) -> str:
        """What Pinocchio gets to read: links and joints, without geometry."""
        from .urdf_plain import plain_urdf

        return plain_urdf(self.name, self.inertials, self.joints)


def read_urdf(path_or_xml: str | os.PathLike[str], *, mimic: bool = False) -> UrdfText:
    """Read a URDF from a file, or take it as XML text if it starts with "<", and check it.

    ``mimic`` tells whether mimic joints will follow their leaders, which must then exist.

    Raises:
        UrdfError: no such file, broken XML, or an element that is wrong; it is named.
    """
    text, path = _text_of(path_or_xml)
    source = path or "URDF text"
    robot = _parse(text, source)
    name = checked_name(robot.get("name") or "robot", source, "<robot>")
    inertials = read_links(robot, source)
    joints = read_joints(robot, source, inertials, mimic=mimic)
    check_tree(joints, inertials, source)
    return UrdfText(text, path, name, inertials, joints, robot)


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
        # A device such as /dev/zero never ends.
        if stat.S_ISCHR(mode := os.stat(path).st_mode) or stat.S_ISBLK(mode):
            raise UrdfError(f"{path}: that is a device, not a file", source=path, element="")
        with open(path, encoding="utf-8-sig") as file:
            return file.read().lstrip(), path
    except (OSError, ValueError) as error:
        if isinstance(error, UrdfError):
            raise
        raise UrdfError(f"{shown(path, 200)}: {_reason(error)}", source=path, element="") from None


def _reason(error: OSError | ValueError) -> str:
    reasons: dict[type, str] = {
        FileNotFoundError: "there is no such file",
        IsADirectoryError: "that is a folder, not a file",
        NotADirectoryError: "there is no such file",
        PermissionError: "the file may not be read",
        UnicodeDecodeError: "the file is not UTF-8 text",
    }
    if type(error) in reasons:
        return reasons[type(error)]
    return (error.strerror if isinstance(error, OSError) else None) or str(error)


def _parse(text: str, source: str) -> ElementTree.Element:
    # A URDF has no use for a document type; with it go all tricks with entities.
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise UrdfError(
            f"{source}: a document type or entity declaration has no place in a URDF",
            source=source,
            element="<!DOCTYPE>",
        )
    from xml.etree import ElementTree

    try:
        robot = _parsed(text)
    except (ElementTree.ParseError, ValueError) as error:
        reason = str(error).removeprefix("not well-formed (invalid token): ")
        raise UrdfError(
            f"{source}: not well-formed XML: {reason}", source=source, element=""
        ) from None
    if robot.tag != "robot":
        raise UrdfError(
            f"{source}: the outermost element is <{shown(robot.tag)}>, a URDF has <robot>",
            source=source,
            element=f"<{shown(robot.tag)}>",
        )
    return robot


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
