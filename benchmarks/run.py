"""Problems by methods: each problem's methods are timed in turn, and each answer is judged."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from .methods.method import Answer, Method
from .problems.problem import Problem
from .rows import Row
from .timing import Ratio, Timing, time_in_turn

__all__ = ["QUICK", "WHOLE", "Effort", "measure", "run"]

# What ratios are against: the first of these that took part.
BASELINES = ("impulsekit, solve", "impulsekit, simulate dop853, 1e-10")


@dataclass(frozen=True)
class Effort:
    """How long is measured.

    Attributes:
        rounds: of each method.
        seconds: of a round, about.
        longest: a method that would take longer on a problem has fewer rounds [s].
    """

    rounds: int
    seconds: float
    longest: float


WHOLE = Effort(rounds=401, seconds=0.0003, longest=1.0)
QUICK = Effort(rounds=51, seconds=0.0003, longest=0.1)


def run(
    problems: Iterable[Problem],
    methods: Sequence[Method],
    *,
    effort: Effort = WHOLE,
    tell: Callable[[str], object] = lambda name: None,
) -> list[Row]:
    """The rows of all problems and methods; ``tell`` hears of each problem as it begins."""
    rows: list[Row] = []
    for problem in problems:
        tell(problem.name)
        rows += measure(problem, [m for m in methods if m.suits(problem)], effort)
        # What Pinocchio keeps for a long chain is large.
        gc.collect()
    return rows


def measure(problem: Problem, methods: Sequence[Method], effort: Effort) -> list[Row]:
    """The rows of one problem."""
    calls: dict[str, Answer] = {}
    errors: dict[str, float] = {}
    notes: dict[str, str] = {}
    for method in methods:
        try:
            call = method.prepare(problem)
            errors[method.label] = problem.error(np.asarray(call()))
            calls[method.label] = call
        except Exception as fault:
            # A method of another program may fail in any way; that is its row.
            notes[method.label] = f"{type(fault).__name__}: {fault}".splitlines()[0][:200]
    times = time_in_turn(calls, effort.rounds, effort.seconds, longest=effort.longest, warm=False)
    baseline = next((name for name in BASELINES if name in times), "")
    return [
        _row(problem, method, times, baseline, errors, notes.get(method.label, ""))
        for method in methods
    ]


def _row(
    problem: Problem,
    method: Method,
    times: dict[str, Timing],
    baseline: str,
    errors: dict[str, float],
    note: str,
) -> Row:
    timing, error = times.get(method.label), errors.get(method.label)
    ratio = None
    if timing and baseline:
        # The baseline answers one state a call.
        ratio = Ratio.of(timing, times[baseline], method.states)
    low, high = timing.quartiles if timing else (None, None)
    return Row(
        problem=problem.name,
        family=problem.family,
        size=problem.size,
        method=method.label,
        name=method.name,
        setting=method.setting,
        peer=method.peer,
        states=method.states,
        seconds=timing.median / method.states if timing else None,
        low=low / method.states if low else None,
        high=high / method.states if high else None,
        rounds=len(timing.rounds) if timing else 0,
        error=error,
        tolerance=problem.tolerance,
        met=error is not None and error <= problem.tolerance,
        baseline=baseline if ratio else "",
        ratio=ratio.median if ratio else None,
        ratio_low=ratio.low if ratio else None,
        ratio_high=ratio.high if ratio else None,
        source=problem.source,
        note=note,
    )
