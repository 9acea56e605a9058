"""The format of a robot's file, by its outermost element."""

from __future__ import annotations

import os
import re

from ..errors import UrdfError, shown
from ..files import read_text_file, reason_of

__all__ = ["SUFFIXES", "format_of", "outermost"]

SUFFIXES = (".urdf", ".xacro", ".xml", ".mjcf", ".sdf")
# The outermost element stands behind comments and the XML declaration.
_ASIDE = re.compile(rb"\s*(<\?.*?\?>|<!--.*?-->|<!DOCTYPE[^>]*>)", re.DOTALL)
_ELEMENT = re.compile(rb"\s*<([A-Za-z_][\w.-]*)")


def format_of(path: str | os.PathLike[str]) -> str:
    """The format of a robot's file: "mjcf", "sdf", or else "urdf".

    Raises:
        UrdfError: it cannot be read.
    """
    try:
        text = read_text_file(path)
    except (OSError, ValueError) as error:
        reason = reason_of(error) if isinstance(error, OSError) else "the path holds a NUL"
        raise UrdfError(f"{shown(path, 200)}: {reason}", source=path, element="") from None
    element = outermost(text)
    if element == "mujoco":
        return "mjcf"
    return "sdf" if element in ("sdf", "model", "world") else "urdf"


def outermost(text: bytes) -> str:
    """The name of the outermost element of an XML text; "" where there is none."""
    text = text.removeprefix(b"\xef\xbb\xbf")
    while aside := _ASIDE.match(text):
        text = text[aside.end() :]
    found = _ELEMENT.match(text)
    return found.group(1).decode() if found else ""
