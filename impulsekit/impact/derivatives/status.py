"""``DerivativeStatus``: whether an impact has derivatives."""

from __future__ import annotations

import enum

__all__ = ["DerivativeStatus"]


class DerivativeStatus(enum.Enum):
    """The state of derivatives, as a sentence with advice."""

    EXISTS = "Valid: every contact keeps its mode under small changes."
    BY_DIFFERENCES = (
        "Valid, but the slope of a restitution function was found by finite differences, accurate "
        "to about 1e-9; give the function a method ``derivative`` for full accuracy."
    )
    MODE_EDGE = (
        "Valid on one side only: a contact is on the boundary between two modes (see ``edges``), "
        "where v⁺ has a corner. The derivatives are those of the mode that was found."
    )
    RANK_CHANGES = (
        "Not valid: v⁺ jumps here and has no derivative, because redundant rows contradict each "
        "other when the state changes, because the modes of the contacts do not determine v⁺, or "
        "because load can be shared in many ways that come to other v⁺ (contacts that slip, "
        "Poisson's law). Entries without a derivative are NaN. Remove the rows that repeat others, "
        "or lower the friction."
    )
    NOT_AVAILABLE = (
        "Not available: friction draws a contact in again along its path, a contact is hit "
        "infinitely often, the point at which bodies meet does not move in closed form, or rows "
        "are functions."
    )
    NO_IMPACT = "Not valid: the impact of this row has no valid solution; see its status."

    @property
    def exists(self) -> bool:
        """True if the derivatives exist."""
        return self in (DerivativeStatus.EXISTS, DerivativeStatus.BY_DIFFERENCES)
