"""XML of robot files: their text, parsed and bounded, and checked numbers out of it."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from ..errors import MjcfError, UrdfError, a_thing, shown
from ..files import read_text_file, reason_of
from .arrays import LARGEST

Fault = type[UrdfError] | type[MjcfError]

# Elements within elements: a URDF has five levels.
DEEPEST_ELEMENT = 200
# How many names one sentence lists.
_LISTED = 3
# float() would also take "1_000", "infinity" and the digits of every script.
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
# What may stand before the first element of a text.
_BLANKS = "\ufeff \t\r\n"


def element(tag: str, *children: Element | None, **attributes: Any) -> Element:
    """Return an element; numbers among the attributes read back as the same doubles."""
    made = Element(tag, {key: _attribute(value) for key, value in attributes.items()})
    made.extend(child for child in children if child is not None)
    return made


def _attribute(value: Any) -> str:
    return value if isinstance(value, str) else " ".join(map(repr, np.ravel(value).tolist()))


def xml_of(made: Element) -> str:
    """Return an element as text."""
    return ElementTree.tostring(made, encoding="unicode")


def content_of(path: str | os.PathLike[str], kind: Fault = UrdfError) -> bytes:
    """Return the bytes of a robot file.

    Raises:
        UrdfError, or another ``kind``: it cannot be read.
    """
    try:
        return read_text_file(path)
    except (OSError, ValueError) as error:
        raise _unreadable(path, error, kind) from None


def text_of(source: Any, wrong: str, kind: Fault = UrdfError) -> tuple[str, str | None]:
    """Return the text of a robot file and its path; XML text stands for itself.

    Args:
        source: a path, or text that starts with "<".
        wrong: the beginning of the sentence for anything else.
        kind: the error.

    Raises:
        UrdfError, or another ``kind``: it is neither, or cannot be read.
    """
    if isinstance(source, str) and source.lstrip(_BLANKS).startswith("<"):
        return source.lstrip(_BLANKS), None
    if not isinstance(source, str | os.PathLike):
        raise kind(f"{wrong} {a_thing(source)}", source=repr(source), element="")
    path = os.fspath(source)
    try:
        text = content_of(path, kind).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise _unreadable(path, error, kind) from None
    return text.replace("\r\n", "\n").replace("\r", "\n").lstrip(), path


def _unreadable(path: Any, error: OSError | ValueError, kind: Fault) -> UrdfError | MjcfError:
    return kind(f"{shown(path, 200)}: {reason_of(error)}", source=os.fspath(path), element="")


def parsed_xml(text: str, source: str, kind: Fault = UrdfError) -> Element:
    """Return the outermost element of a robot file.

    Raises:
        UrdfError, or another ``kind``: it is no XML, or holds what no robot file needs.
    """
    # A robot has no use for a document type; with it go all tricks with entities.
    what = ""
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        what = "<!DOCTYPE>"
        reason = "a document type or entity declaration has no place in a robot file; take it out"
    elif not text.strip():
        reason = "it is empty"
    elif not text.startswith("<"):
        reason = "it is not an XML file"
    else:
        try:
            return _parsed(text)
        except (ElementTree.ParseError, ValueError) as error:
            reason = f"not well-formed XML: {_in_words(str(error))}"
    raise kind(f"{source}: {reason}", source=source, element=what)


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


def _parsed(text: str) -> Element:
    """The outermost element. Depth is bounded: what frees a tree calls itself once a level."""
    parser: Any = ElementTree.XMLPullParser(("start", "end"))
    depth, top = 0, None
    for begin in range(0, len(text), 1 << 16):
        parser.feed(text[begin : begin + (1 << 16)])
        for event, item in parser.read_events():
            top = item if top is None else top
            depth += 1 if event == "start" else -1
            if depth > DEEPEST_ELEMENT:
                raise ValueError(f"elements stand more than {DEEPEST_ELEMENT} deep in each other")
    parser.close()
    if top is None:
        raise ValueError("no element in it")
    return top


def are_numbers(text: str) -> bool:
    """Return whether a text holds nothing but numbers, with blanks between."""
    words = text.split()
    return bool(words) and all(map(_NUMBER.fullmatch, words))


def listed(names: Sequence[str]) -> str:
    """Return the first few names, and how many more there are."""
    named = ", ".join(f'"{name}"' for name in names[:_LISTED])
    return named if len(names) <= _LISTED else f"{named} and {len(names) - _LISTED} more"


@dataclass(frozen=True)
class Place:
    """A place in a robot file, which begins the sentences on faults there.

    Attributes:
        source: the file.
        element: such as 'link "hand"'.
        kind: of error.
    """

    source: str
    element: str = ""
    kind: Fault = UrdfError

    def at(self, element: str) -> Place:
        """Return the place of an element of the same file."""
        return replace(self, element=element)

    def fault(self, sentence: str, element: str | None = None) -> Any:
        """Return the error; ``element`` is carried in place of the one that the sentence names."""
        named = self.element if element is None else element
        begin = ": ".join(part for part in (self.source, self.element) if part)
        return self.kind(f"{begin}: {sentence}", source=self.source, element=named)

    def name(self, name: str) -> str:
        """Return a name, proved free of control characters, which a terminal would obey.

        Raises:
            UrdfError: it holds one.
        """
        if not name.isprintable():
            strange = next(c for c in name if not c.isprintable())
            raise self.fault(
                f"its name must be printable text, it holds the character U+{ord(strange):04X}"
            )
        return name

    def numbers(self, text: str | None, count: int, what: str) -> tuple:
        """Return ``count`` finite numbers out of a text.

        Raises:
            UrdfError: something else stands there.
        """
        words = (text or "").split()
        found = tuple(float(word) for word in words if _NUMBER.fullmatch(word))
        if len(words) == len(found) == count and all(abs(x) <= LARGEST for x in found):
            return found
        kind = "number"
        if len(words) == len(found) == count:
            kind = f"number from -{LARGEST:g} to {LARGEST:g}"
        elif any(word.lower().lstrip("+-") in ("nan", "inf", "infinity") for word in words):
            kind = "finite number"
        expected = f"a {kind}"
        if count > 1:
            expected = f"{count} {kind.replace('number', 'numbers')} with spaces between"
        given = "nothing" if text is None else f'"{shown(text)}"'
        raise self.fault(f"its {what} must be {expected}, got {given}")

    def number(self, text: str | None, what: str, least: float = -math.inf) -> float:
        """Return one finite number, ``least`` or more.

        Raises:
            UrdfError: something else stands there.
        """
        (value,) = self.numbers(text, 1, what)
        if value < least:
            raise self.fault(f"its {what} must be {least:g} or more, got {value:g}")
        return value
