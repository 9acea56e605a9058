"""Warnings: what a file leaves open and was assumed, and what is likely not meant as given."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

from .wording import escaped


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


def warn_of_assumptions(source: str, assumptions: Sequence[str], *, above: int = 2) -> None:
    """Warn by one ``AssumptionWarning`` for a file, if anything was assumed.

    ``above`` is how many frames stand between this call and the user's line.

    Example:
        >>> with warnings.catch_warnings(record=True, action="always") as told:
        ...     warn_of_assumptions("arm.urdf", ["link tool has no mass"])
        >>> told[0].category.__name__
        'AssumptionWarning'
    """
    if assumptions:
        warnings.warn(AssumptionWarning(source, assumptions), stacklevel=1 + above)


# More sentences than this are a page, not a warning.
MOST_DOUBTS = 4


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


def warn_of_setup(doubts: Sequence[str], *, above: int = 2) -> None:
    """Warn by one ``SetupWarning``, if there is any doubt; ``above`` as for the other.

    Example:
        >>> with warnings.catch_warnings(record=True, action="always") as told:
        ...     warn_of_setup([])
        >>> told
        []
    """
    if doubts:
        warnings.warn(SetupWarning(doubts), stacklevel=1 + above)
