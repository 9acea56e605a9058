"""Wording of errors: values and names as sentences show them, and the two warnings."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Iterable, Sequence
from typing import Any

# The folder of the package's own code.
_PACKAGE = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "")
# More sentences than this are a page, not a warning.
MOST_DOUBTS = 4


def shown(value: object, most: int = 60) -> str:
    """Return text as it is, anything else as Python writes it: printable, on one short line.

    What is in memory at some address is called by its type.

    Example:
        >>> shown("a\\x1b[31m")
        'a\\\\x1b[31m'
    """
    try:
        value = value.__name__ if isinstance(value, type) else value
        text = value if isinstance(value, str) else repr(value)
    except Exception:  # a whole number of thousands of digits, or a user's own repr
        text = f"a {type(value).__name__}"
    if not isinstance(value, str) and " at 0x" in text:
        text = "a function" if callable(value) else f"a {type(value).__name__}"
    line = escaped(text[: most + 1]).replace("\n", "\\n")
    return line if len(line) <= most else line[: most - 3] + "..."


def quoted(value: object, most: int = 60) -> str:
    """Return the same with quotes around a text.

    Example:
        >>> quoted("a"), quoted(1.5), quoted(print)
        ('"a"', '1.5', '<built-in function print>')
    """
    return f'"{shown(value, most - 2)}"' if isinstance(value, str) else shown(value, most)


def escaped(text: str) -> str:
    """Return text whose control characters, line ends apart, are written out."""
    if text.isprintable():
        return text
    return "".join(
        c if c.isprintable() or c == "\n" else c.encode("unicode_escape").decode() for c in text
    )


def a_thing(value: object) -> str:
    """Return the type of a value with its article.

    Example:
        >>> a_thing([]), a_thing(KeyError())
        ('a list', 'a KeyError')
    """
    if value is None:
        return "None"
    name = type(value).__name__
    return f"{'an' if name[:1] in 'AEIOUaeiou' else 'a'} {name}"


def shape_text(shape: Sequence[Any]) -> str:
    """Return a shape as numpy writes it; an axis without a number by its letter."""
    return "(" + ", ".join(map(str, shape)) + (",)" if len(shape) == 1 else ")")


def one_of(names: Sequence[str]) -> str:
    """Return names in quotes, the last after an "or"."""
    *first, last = (f'"{name}"' for name in names)
    return f"{', '.join(first)} or {last}" if first else last


def nearest_names(name: str, known: Iterable[str], most: int = 3) -> tuple[str, ...]:
    """Return the names in ``known`` that look most like ``name``, best first.

    Example:
        >>> nearest_names("elbwo", ["shoulder", "elbow", "wrist"])
        ('elbow',)
    """
    import difflib

    names = list(known)
    folded: dict[str, str] = {}
    for candidate in names:
        folded.setdefault(candidate.lower(), candidate)
    hits = difflib.get_close_matches(str(name).lower(), list(folded), n=most, cutoff=0.6)
    if not hits:
        hits = [key for key in folded if name and str(name).lower() in key][:most]
    return tuple(folded[hit] for hit in hits)


def warn_user(warning: Warning | str) -> None:
    """Warn at the user's line: the last one outside the package.

    Example:
        >>> with warnings.catch_warnings(record=True, action="always") as caught:
        ...     warn_user("no browser")
        >>> caught[0].filename == __file__
        False
    """
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_PACKAGE):
        level, frame = level + 1, frame.f_back
    warnings.warn(warning, stacklevel=level)


class AssumptionWarning(UserWarning):
    """A file leaves something open; the sentence says what was assumed.

    Attributes: source (the file), assumptions (one sentence each).

    Example:
        >>> print(AssumptionWarning("arm.urdf", ["link tool has no mass"]))
        arm.urdf: assumed: link tool has no mass
    """

    def __init__(self, source: str, assumptions: Sequence[str]) -> None:
        self.source, self.assumptions = source, tuple(assumptions)
        # What another process makes a copy of: the arguments, not the sentence made of them.
        super().__init__(source, self.assumptions)

    def __str__(self) -> str:
        return escaped(f"{self.source}: assumed: " + "; ".join(self.assumptions))


def warn_of_assumptions(source: str, assumptions: Sequence[str]) -> None:
    """Warn by one ``AssumptionWarning`` for a file, if anything was assumed.

    Example:
        >>> with warnings.catch_warnings(record=True, action="always") as caught:
        ...     warn_of_assumptions("arm.urdf", ["link tool has no mass"])
        >>> caught[0].category.__name__
        'AssumptionWarning'
    """
    if assumptions:
        warn_user(AssumptionWarning(source, assumptions))


class SetupWarning(UserWarning):
    """A scene or a state that is solved as given, and likely is not what was meant.

    Attributes: doubts (one sentence each).

    Example:
        >>> print(SetupWarning(["contact floor is 0.2 m open"]))
        contact floor is 0.2 m open
    """

    def __init__(self, doubts: Sequence[str]) -> None:
        self.doubts = tuple(doubts)
        super().__init__(self.doubts)

    def __str__(self) -> str:
        more = len(self.doubts) - MOST_DOUBTS
        tail = [f"and {more} more, see Impact.doubts"] if more > 0 else []
        return escaped("; ".join([*self.doubts[:MOST_DOUBTS], *tail]))


def warn_of_setup(doubts: Sequence[str]) -> None:
    """Warn by one ``SetupWarning``, if there is any doubt.

    Example:
        >>> with warnings.catch_warnings(record=True, action="always") as caught:
        ...     warn_of_setup([])
        >>> caught
        []
    """
    if doubts:
        warn_user(SetupWarning(doubts))
