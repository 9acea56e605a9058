"""A contact that has come to rest: which of its points slide, roll and spin, and which way."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

__all__ = ["NO_WAYS", "RestingContact"]

# Of no points.
NO_WAYS = np.zeros((0, 3))


@dataclass(eq=False)
class RestingContact:
    """A contact that has come to rest.

    Attributes:
        gap: its index among the gaps.
        entry: its index among the scene's contacts.
        friction: µ.
        since: when it came to rest [s].
        count: how many points it touched at last.
        slips: (k, 3) what its points do, as ``Sliding.ways`` has it.
        rolls, spins: (k, 3) the same, of contacts that resist that.
    """

    gap: int
    entry: int
    friction: float
    since: float
    count: int = 1
    slips: np.ndarray = field(default_factory=lambda: NO_WAYS)
    rolls: np.ndarray = field(default_factory=lambda: NO_WAYS)
    spins: np.ndarray = field(default_factory=lambda: NO_WAYS)

    def fit(self) -> None:
        """Where points came or went it is not known any more which is which."""
        # Within a step a round body may seem to have lifted, and comes back as it was.
        if self.count and len(self.slips) != self.count:
            self.slips = np.zeros((self.count, 3))

    def fit_turning(self) -> None:
        """The same of rolling and spin."""
        if self.count and len(self.rolls) != self.count:
            self.rolls, self.spins = np.zeros((2, self.count, 3))

    def keep(self, points: np.ndarray) -> None:
        """Go on with those of its points that are told (k,)."""
        self.slips = self.slips[points]
        if len(self.rolls):
            self.rolls, self.spins = self.rolls[points], self.spins[points]
        self.count = int(points.sum())
