"""How an answer is to be taken."""

from __future__ import annotations

import enum

__all__ = ["Status"]


class Status(enum.Enum):
    """The state of an answer, as a sentence with advice."""

    SOLVED = "The answer holds: its residuals are at rounding level."
    INACCURATE = (
        "The residuals are above rounding level. Masses or lengths in this scene span too many "
        "orders of magnitude for double precision; look at impact.residuals and rescale the model."
    )

    @property
    def valid(self) -> bool:
        """Whether the numbers may be used."""
        return self in _VALID


_VALID = frozenset({Status.SOLVED})
