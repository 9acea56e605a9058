"""Whether an impact has derivatives."""

from __future__ import annotations

import enum

__all__ = ["DerivativeStatus"]


class DerivativeStatus(enum.Enum):
    """The state of derivatives, as a sentence with advice."""

    EXISTS = "The derivatives hold: every contact stays in its mode for small changes."
    MODE_EDGE = (
        "A contact is on the edge between two modes (look at ``edges``), where v⁺ has a corner. "
        "The numbers are those of the mode that was found, and hold on one side only."
    )
    RANK_CHANGES = (
        "Redundant rows contradict each other when the state changes, or the modes of the contacts "
        "leave v⁺ open: it jumps there and has no derivative, and what is not there is NaN. Leave "
        "out the rows that repeat others, or lower the friction."
    )

    @property
    def exists(self) -> bool:
        """Whether the numbers are derivatives."""
        return self is DerivativeStatus.EXISTS
