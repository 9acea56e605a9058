"""Timing several ways of one job against each other.

Not by pyperf or pytest-benchmark: both time one way to its end before the next begins, each in
processes or rounds of its own, so that on a machine whose speed drifts, as shared ones do, the
ratio of two ways is one of two moments. Here the ways take turns, round by round.
"""

from __future__ import annotations

import random
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol, runtime_checkable

__all__ = ["Ratio", "Times", "TimesItself", "Timing", "import_times", "in_turn", "time_in_turn"]

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
