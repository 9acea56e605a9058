"""Whether an impact has derivatives."""

from __future__ import annotations

import enum

__all__ = ["DerivativeStatus"]


class DerivativeStatus(enum.Enum):
    """The state of derivatives, as a sentence with advice."""

    EXISTS = "The derivatives hold: every contact stays in its mode for small changes."
    BY_DIFFERENCES = (
        "The derivatives hold, but the slope of a restitution that is a function was found by "
        "differences, good to about 1e-9; give the function a method ``derivative`` of its own "
        "where more is wanted."
    )
    MODE_EDGE = (
        "A contact is on the edge between two modes (look at ``edges``), where v⁺ has a corner. "
        "The numbers are those of the mode that was found, and hold on one side only."
    )
    RANK_CHANGES = (
        "Redundant rows contradict each other when the state changes, or the modes of the contacts "
        "leave v⁺ open: it jumps there and has no derivative, and what is not there is NaN. So it "
        "is where Poisson's law gives back a load that may be shared in many ways. Leave out the "
        "rows that repeat others, or lower the friction."
    )

    @property
    def exists(self) -> bool:
        """Whether the numbers are derivatives."""
        return self in (DerivativeStatus.EXISTS, DerivativeStatus.BY_DIFFERENCES)
