"""A step between its start and end as compiled code sees it: what events ask of it."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from ..rest.contacts import Resting

__all__ = ["Passage"]


class Passage(Protocol):
    """A step as compiled code sees it; ``travel.passage`` has it with bodies that may collide."""

    def touch(self, base: np.ndarray, until: float, speeds: np.ndarray) -> tuple[float, int]:
        """As ``touch_pairs``: when bodies touch first and which; their speeds to ``speeds``."""

    def crossings(self, resting: Resting, times: list[float]) -> np.ndarray | None:
        """As ``crossings_of`` of points that rest; None where compiled code does not know them."""

    @property
    def can_touch(self) -> bool:
        """Whether ``touch`` is compiled."""
