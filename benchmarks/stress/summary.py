"""What a stress test comes to: one line per sweep, and the whole."""

from __future__ import annotations

import math
import statistics
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from tests.truths.numbers import EPS, truth_numbers

from ..about import about
from .judge import BACKWARD, BOUND, ILL_POSED
from .sweep import Point

__all__ = ["Line", "count_scenes", "lines_of", "machine", "whole_of"]


@dataclass(frozen=True)
class Line:
    """A sweep, or all of them.

    Attributes:
        sweep: its name.
        scenes: different scenes and states.
        points: answers: of each scene by each method.
        right, said, wrong: how many points; said: the status or an error reports it as not valid.
        ill_posed: points for which even 10 condition eps is more than a thousandth.
        share: the largest error of a right, well-posed answer over condition times eps.
        error: the largest relative error of those.
        momentum, law: the largest residuals of those that are called valid.
        above: how many of those leave more of their equations than rounding does.
        microseconds: the middle time of ``solve``.
        statuses: how often each status or error came.
    """

    sweep: str
    scenes: int
    points: int
    right: int
    said: int
    wrong: int
    ill_posed: int
    share: float
    error: float
    momentum: float
    law: float
    above: int
    microseconds: float
    statuses: dict[str, int]

    @property
    def complaint(self) -> str:
        """What is wrong with the answers, in one line; empty if nothing is."""
        faults = []
        if self.wrong:
            faults.append(f"{self.wrong} silently wrong")
        if self.above:
            left = max(self.momentum, self.law)
            faults.append(
                f"{self.above} leave up to {left:.0e} of their equations, more than {BACKWARD:g}"
            )
        return f"{self.sweep}: {', '.join(faults)}" if faults else ""

    @property
    def said_share(self) -> float:
        """The part of the points that were reported as not valid."""
        return self.said / self.points if self.points else 0.0


def count_scenes(points: Iterable[Point]) -> int:
    """How many different scenes and states there are."""
    return len({(p.sweep, p.value, p.repeat, p.state) for p in points})


def is_ill_posed(point: Point) -> bool:
    """Whether the data determine the answer to less than a thousandth."""
    return point.condition * EPS * BOUND > ILL_POSED


def line_of(name: str, points: Sequence[Point]) -> Line:
    """The line of some points."""
    verdicts = Counter(p.verdict for p in points)
    valid = [p for p in points if p.verdict != "said so"]
    sound = [p for p in valid if p.verdict == "right" and not is_ill_posed(p)]
    seconds = [p.seconds for p in points if p.method == "solve"]
    return Line(
        name,
        count_scenes(points),
        len(points),
        verdicts["right"],
        verdicts["said so"],
        verdicts["wrong"],
        sum(is_ill_posed(p) for p in points),
        max((p.share for p in sound if math.isfinite(p.share)), default=0.0),
        max((p.error for p in sound if math.isfinite(p.error)), default=0.0),
        max((p.momentum for p in valid if not math.isnan(p.momentum)), default=0.0),
        max((p.law for p in valid if not math.isnan(p.law)), default=0.0),
        sum(p.momentum > BACKWARD or p.law > BACKWARD for p in valid),
        1e6 * statistics.median(seconds) if seconds else math.nan,
        dict(Counter(p.status for p in points).most_common()),
    )


def lines_of(points: Sequence[Point]) -> list[Line]:
    """The line of each sweep, in the order of the points."""
    by_sweep: dict[str, list[Point]] = {}
    for point in points:
        by_sweep.setdefault(point.sweep, []).append(point)
    return [line_of(name, own) for name, own in by_sweep.items()]


def whole_of(points: Sequence[Point]) -> Line:
    """The line of all sweeps."""
    return line_of("all", points)


def machine() -> str:
    """Date, kind of machine and versions, in one line."""
    facts = about()
    packages = ", ".join(
        f"{name} {facts[name]}" for name in ("Python", "impulsekit", "pin", "numpy")
    )
    return f"{facts['date']}, {facts['machine']}, {packages}; truth: {truth_numbers().name}"
