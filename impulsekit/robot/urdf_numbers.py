"""Numbers and names of a URDF: what may stand in an attribute, and how a fault is told."""

from __future__ import annotations

import math
import re

from ..errors import UrdfError, shown

# Beyond this the squares of lengths and masses would overflow.
LARGEST = 1e100
# How many names one sentence lists.
_LISTED = 3
# float() would also take "1_000", "infinity" and the digits of every script.
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)


def fault(source: str, element: str, sentence: str) -> UrdfError:
    """The error for an element of a URDF."""
    return UrdfError(f"{source}: {element}: {sentence}", source=source, element=element)


def checked_name(name: str, source: str, element: str) -> str:
    """A name without control characters, which a terminal would obey.

    Raises:
        UrdfError: it holds one.
    """
    if not name.isprintable():
        strange = next(c for c in name if not c.isprintable())
        raise fault(
            source,
            element,
            f"its name must be printable text, it holds the character U+{ord(strange):04X}",
        )
    return name


def are_numbers(text: str) -> bool:
    """Return whether a text holds nothing but numbers, with blanks between."""
    words = text.split()
    return bool(words) and all(map(_NUMBER.fullmatch, words))


def numbers(text: str | None, count: int, source: str, element: str, what: str) -> tuple:
    """``count`` finite numbers out of an attribute.

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
    raise fault(source, element, f"its {what} must be {expected}, got {given}")


def number(text: str | None, source: str, element: str, what: str, least: float = -math.inf):
    """One finite number, ``least`` or more.

    Raises:
        UrdfError: something else stands there.
    """
    (value,) = numbers(text, 1, source, element, what)
    if value < least:
        raise fault(source, element, f"its {what} must be {least:g} or more, got {value:g}")
    return value


def listed(names: list[str]) -> str:
    """The first few names, and how many more there are."""
    named = ", ".join(f'"{name}"' for name in names[:_LISTED])
    return named if len(names) <= _LISTED else f"{named} and {len(names) - _LISTED} more"
