"""Several ways of one job timed in turn, and claims about the ratio of their times."""

from __future__ import annotations

import random
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol, runtime_checkable

TRIES = 15
# Timing ends once it took so many times what was planned.
PATIENCE = 100.0


@runtime_checkable
class TimesItself(Protocol):
    """A call that does its work in another process and is timed in there, not from here."""

    def __call__(self) -> object:
        """The answer."""

    def seconds(self, repeats: int) -> float:
        """Seconds one call takes, the mean of so many in a row."""


@dataclass(frozen=True)
class Timing:
    """Seconds a call takes, over the rounds of a run; a slow call may have fewer of them."""

    rounds: tuple[float, ...]

    @property
    def best(self) -> float:
        """The fastest round, the one least disturbed."""
        return min(self.rounds)

    @property
    def median(self) -> float:
        """The middle of the rounds."""
        return statistics.median(self.rounds)

    @property
    def quartiles(self) -> tuple[float, float]:
        """A quarter of the rounds were faster than the first, a quarter slower than the second."""
        return _quartiles(self.rounds)


@dataclass(frozen=True)
class Ratio:
    """Of two times taken in turn: its median over the rounds, and its quartiles."""

    median: float
    low: float
    high: float

    @classmethod
    def of(cls, ours: Timing, theirs: Timing, calls: float = 1.0) -> Ratio:
        """Ours over theirs, round by round; one of ours does the work of ``calls`` of theirs."""
        pairs = zip(ours.rounds, theirs.rounds, strict=False)
        ratios = [a / (b * calls) for a, b in pairs]
        return cls(statistics.median(ratios), *_quartiles(ratios))


def time_in_turn(
    ways: Mapping[str, Callable[[], object]],
    rounds: int = 501,
    seconds: float = 0.0003,
    *,
    longest: float = float("inf"),
    warm: bool = True,
) -> dict[str, Timing]:
    """Time each way in turn, round by round, so that a machine that drifts drifts for all.

    Rounds are shorter than the turns that a scheduler gives, so that most of them are not
    broken into by other load, and the order changes, so that none keeps step with it.

    Args:
        ways: the calls by name.
        rounds: how often each is timed.
        seconds: how long one round of one way takes, about.
        longest: a way that would take more seconds than this in all has fewer rounds, the
            first ones; at least one.
        warm: call each once before; False where that has been done.
    """
    repeats: dict[str, int] = {}
    takes_part: dict[str, int] = {}
    for name, way in ways.items():
        repeats[name], once = _repeats(way, seconds, warm)
        takes_part[name] = max(1, int(min(rounds, longest / (repeats[name] * once))))
    taken: dict[str, list[float]] = {name: [] for name in ways}
    order, shuffle = list(ways), random.Random(0).shuffle
    for turn in range(rounds):
        shuffle(order)
        for name in order:
            if turn < takes_part[name]:
                if repeats[name] > 1:
                    # Not timed: the others have taken the caches.
                    ways[name]()
                taken[name].append(_per_call(ways[name], repeats[name]))
    return {name: Timing(tuple(times)) for name, times in taken.items()}


class Times(NamedTuple):
    """Two ways of one job, timed in turn; how many jobs a call of each does."""

    ours: Timing
    theirs: Timing
    our_calls: int = 1
    their_calls: int = 1


def in_turn(
    ours: Callable[[], object],
    theirs: Callable[[], object],
    our_calls: int = 1,
    their_calls: int = 1,
    rounds: int = 501,
) -> Times:
    """Time two ways of one job in turn."""
    times = time_in_turn({"ours": ours, "theirs": theirs}, rounds)
    return Times(times["ours"], times["theirs"], our_calls, their_calls)


def import_times(statements: Sequence[str], rounds: int = 11) -> dict[str, Timing]:
    """How long each statement takes in fresh interpreters, in turn, their start left out.

    In processor time, which other load does not lengthen.
    """
    code = "import time; t = time.process_time(); {}; print(time.process_time() - t)"
    times: dict[str, list[float]] = {statement: [] for statement in statements}
    for _ in range(rounds):
        for statement, taken in times.items():
            command = [sys.executable, "-c", code.format(statement)]
            done = subprocess.run(command, capture_output=True, check=True)
            taken.append(float(done.stdout))
    return {statement: Timing(tuple(taken)) for statement, taken in times.items()}


def _quartiles(values: Sequence[float]) -> tuple[float, float]:
    if len(values) == 1:
        return values[0], values[0]
    low, _, high = statistics.quantiles(values, n=4, method="inclusive")
    return low, high


def _repeats(way: Callable[[], object], seconds: float, warm: bool) -> tuple[int, float]:
    """How many calls take about so many seconds, and how many one takes."""
    if warm:
        way()
    repeats = 1
    while (once := _undisturbed(way, repeats, seconds)) * repeats < seconds / 4:
        repeats *= 2
    return max(1, int(seconds / once)), once


def _undisturbed(way: Callable[[], object], repeats: int, seconds: float) -> float:
    """Seconds a call takes, the least of many tries: other load breaks into some of them."""
    least, spent = float("inf"), 0.0
    for _ in range(TRIES):
        once = _per_call(way, repeats)
        least, spent = min(least, once), spent + once * repeats
        if spent > PATIENCE * seconds:
            break
    return least


def _per_call(way: Callable[[], object], repeats: int) -> float:
    if isinstance(way, TimesItself):
        return way.seconds(repeats)
    start = time.perf_counter()
    for _ in range(repeats):
        way()
    return (time.perf_counter() - start) / repeats


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
