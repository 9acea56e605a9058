"""A contact that has come to rest: which of its points slide, roll and spin, and which way."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

__all__ = ["RestingContact", "Turn"]


class Turn:
    """How one point rolls and spins.

    Attributes:
        rolls: (2,) the direction of rolling, or None. spins: (1,) that of spin, or None.
        rolling_begins, spin_begins: whether it has just begun.
    """

    def __init__(
        self,
        rolls: np.ndarray | None = None,
        spins: np.ndarray | None = None,
        rolling_begins: bool = False,
        spin_begins: bool = False,
    ) -> None:
        self.rolls, self.spins = rolls, spins
        self.rolling_begins, self.spin_begins = rolling_begins, spin_begins

    def packed(self) -> list[Any]:
        """Ready for JSON."""
        ways = [None if way is None else way.tolist() for way in (self.rolls, self.spins)]
        return [*ways, self.rolling_begins, self.spin_begins]

    @classmethod
    def unpacked(cls, packed: list[Any]) -> Turn:
        """What ``packed`` packed."""
        rolls, spins = (None if way is None else np.array(way, dtype=float) for way in packed[:2])
        return cls(rolls, spins, bool(packed[2]), bool(packed[3]))

    def copied(self) -> Turn:
        """Another one, the same."""
        return Turn(self.rolls, self.spins, self.rolling_begins, self.spin_begins)


@dataclass(eq=False)
class RestingContact:
    """A contact that has come to rest.

    Attributes:
        gap: its index among the gaps.
        entry: its index among the scene's contacts.
        friction: µ.
        since: when it came to rest [s].
        count: how many points it touched at last.
        slides: by point, the direction of slip (2,), or None for a point that sticks.
        begins: by point, whether its slip has just begun: friction opposes its acceleration.
        turns: by point, how it rolls and spins; of contacts that resist that.
    """

    gap: int
    entry: int
    friction: float
    since: float
    count: int = 1
    slides: list[np.ndarray | None] = field(default_factory=list)
    begins: list[bool] = field(default_factory=list)
    turns: list[Turn] = field(default_factory=list)

    def fit(self) -> None:
        """Where points came or went it is not known any more which is which."""
        # Within a step a round body may seem to have lifted, and comes back as it was.
        if self.count and len(self.slides) != self.count:
            self.slides, self.begins = [None] * self.count, [False] * self.count

    def keep(self, points: list[bool]) -> None:
        """Go on with those of its points that are told."""
        self.slides = [s for s, stays in zip(self.slides, points, strict=True) if stays]
        self.begins = [b for b, stays in zip(self.begins, points, strict=True) if stays]
        if self.turns:
            self.turns = [t for t, stays in zip(self.turns, points, strict=True) if stays]
        self.count = sum(points)
