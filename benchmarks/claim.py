"""A claim about time: what was measured, and the bound that it is held to."""

from __future__ import annotations

import statistics
from dataclasses import dataclass

from .timing import Ratio, Times

__all__ = ["Claim"]


@dataclass(frozen=True)
class Claim:
    """One measured claim.

    Attributes:
        label: what was compared.
        bound: what the value is held to.
        value: the ratio of two times, its median over rounds that were timed in turn; or a
            number by itself.
        low, high: its quartiles; of a number by itself, its least and most.
        ours, theirs: median seconds of the two; None for a number by itself.
        unit: of a number by itself, "s" for one.
        at_least: True where the value should be no less than the bound, as of a speed-up.
        note: what else was seen.
    """

    label: str
    bound: float
    value: float
    low: float | None = None
    high: float | None = None
    ours: float | None = None
    theirs: float | None = None
    unit: str = ""
    at_least: bool = False
    note: str = ""

    @classmethod
    def of_ratio(
        cls,
        label: str,
        times: Times,
        bound: float,
        *,
        at_least: bool = False,
        note: str = "",
    ) -> Claim:
        """Ours over theirs held below the bound; or theirs over ours held above it."""
        ours, theirs, our_calls, their_calls = times
        ratio = Ratio.of(ours, theirs, our_calls / their_calls)
        median, low, high = ratio.median, ratio.low, ratio.high
        if at_least:
            median, low, high = 1.0 / median, 1.0 / high, 1.0 / low
        return cls(
            label,
            bound,
            median,
            low,
            high,
            ours.median / our_calls,
            theirs.median / their_calls,
            at_least=at_least,
            note=note,
        )

    @classmethod
    def of_values(
        cls, label: str, values: list[float], bound: float, unit: str = "", at_least: bool = False
    ) -> Claim:
        """A number by itself, measured several times."""
        low, high = min(values), max(values)
        value = statistics.median(values)
        return cls(label, bound, value, low, high, unit=unit, at_least=at_least)

    @property
    def met(self) -> bool:
        """Whether the value keeps the bound."""
        return self.value >= self.bound if self.at_least else self.value <= self.bound

    def line(self) -> str:
        """One line of text."""
        times = ""
        if self.ours is not None and self.theirs is not None:
            times = f"{1e6 * self.ours:10.2f} µs {1e6 * self.theirs:10.2f} µs"
        spread = ""
        if self.low is not None and self.high is not None:
            spread = f"({self.low:.3g} to {self.high:.3g})"
        bound = f"at {'least' if self.at_least else 'most'} {self.bound:g}"
        verdict = bound if self.met else f"NOT {bound}"
        note = f"   {self.note}" if self.note else ""
        value = f"{self.value:.3g}{' ' + self.unit if self.unit else ''}"
        return f"{self.label:66s} {times:27s} {value:>9s} {spread:18s} {verdict}{note}\n"
