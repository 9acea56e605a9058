"""A robot from a file of any format that is read here, told by its outermost element."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from ..errors import UrdfError, shown
from ..files import path_of, read_text_file, reason_of

if TYPE_CHECKING:
    from .robot import Robot

__all__ = ["SUFFIXES", "outermost", "robot_from_file"]

SUFFIXES = (".urdf", ".xacro", ".xml", ".mjcf", ".sdf")
# The outermost element stands behind comments and the XML declaration.
_ASIDE = re.compile(rb"\s*(<\?.*?\?>|<!--.*?-->|<!DOCTYPE[^>]*>)", re.DOTALL)
_ELEMENT = re.compile(rb"\s*<([A-Za-z_][\w.-]*)")


def robot_from_file(
    path: str | os.PathLike[str], root: str | None = None, *, package_dirs: Iterable[Any] = ()
) -> Robot:
    """See ``Robot.from_file``."""
    from .robot import Robot

    path = path_of(path, "the file of a robot")
    try:
        text = read_text_file(path)
    except (OSError, ValueError) as error:
        reason = reason_of(error) if isinstance(error, OSError) else "the path holds a NUL"
        raise UrdfError(f"{shown(path, 200)}: {reason}", source=path, element="") from None
    element = outermost(text)
    if element == "mujoco":
        return Robot.from_mjcf(path, root)
    if element in ("sdf", "model", "world"):
        return Robot.from_sdf(path, root or "fixed", package_dirs=package_dirs)
    return Robot.from_urdf(path, root or "fixed", package_dirs=package_dirs)


def outermost(text: bytes) -> str:
    """The name of the outermost element of an XML text; "" where there is none."""
    text = text.removeprefix(b"\xef\xbb\xbf")
    while aside := _ASIDE.match(text):
        text = text[aside.end() :]
    found = _ELEMENT.match(text)
    return found.group(1).decode() if found else ""
