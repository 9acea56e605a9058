"""Timing several ways of one job against each other."""

from __future__ import annotations

import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

__all__ = ["TimesItself", "Timing", "import_times", "ratio_row", "time_in_turn"]


@runtime_checkable
class TimesItself(Protocol):
    """A call that does its work in another process and is timed in there, not from here."""

    def __call__(self) -> object:
        """The answer."""

    def seconds(self, repeats: int) -> float:
        """Seconds one call takes, the mean of so many in a row."""


@dataclass(frozen=True)
class Timing:
    """Seconds a call takes, over the rounds of a run."""

    rounds: tuple[float, ...]

    @property
    def best(self) -> float:
        """The fastest round, the one least disturbed."""
        return min(self.rounds)

    @property
    def median(self) -> float:
        """The middle of the rounds."""
        return statistics.median(self.rounds)


def time_in_turn(
    ways: Mapping[str, Callable[[], object]], rounds: int = 15, seconds: float = 0.02
) -> dict[str, Timing]:
    """Time each way in turn, round by round, so that a machine that drifts drifts for all.

    Args:
        ways: the calls by name.
        rounds: how often each is timed.
        seconds: how long one round of one way takes, about.
    """
    repeats = {name: _repeats(way, seconds) for name, way in ways.items()}
    taken: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(rounds):
        for name, way in ways.items():
            taken[name].append(_per_call(way, repeats[name]))
    return {name: Timing(tuple(times)) for name, times in taken.items()}


def ratio_row(label: str, ours: Timing, theirs: Timing, bound: float) -> str:
    """One line: both times, the ratio of medians with its spread, and the bound it is held to."""
    ratios = [a / b for a, b in zip(ours.rounds, theirs.rounds, strict=True)]
    ratio = statistics.median(ratios)
    verdict = "within" if ratio <= bound else "ABOVE"
    return (
        f"{label:44s} {1e6 * ours.median:9.2f} µs {1e6 * theirs.median:9.2f} µs   "
        f"ratio {ratio:5.2f} ({min(ratios):.2f} to {max(ratios):.2f})   {verdict} {bound:g}"
    )


def import_times(statements: Sequence[str], rounds: int = 11) -> dict[str, Timing]:
    """How long each statement takes in fresh interpreters, in turn, their start left out."""
    code = "import time; t = time.perf_counter(); {}; print(time.perf_counter() - t)"
    times: dict[str, list[float]] = {statement: [] for statement in statements}
    for _ in range(rounds):
        for statement, taken in times.items():
            command = [sys.executable, "-c", code.format(statement)]
            done = subprocess.run(command, capture_output=True, check=True)
            taken.append(float(done.stdout))
    return {statement: Timing(tuple(taken)) for statement, taken in times.items()}


def _repeats(way: Callable[[], object], seconds: float) -> int:
    way()
    repeats = 1
    while (taken := _per_call(way, repeats) * repeats) < seconds / 4:
        repeats *= 2
    return max(1, int(repeats * seconds / taken))


def _per_call(way: Callable[[], object], repeats: int) -> float:
    if isinstance(way, TimesItself):
        return way.seconds(repeats)
    start = time.perf_counter()
    for _ in range(repeats):
        way()
    return (time.perf_counter() - start) / repeats
