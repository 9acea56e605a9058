"""Sweeps run, case by case, on several processes."""

from __future__ import annotations

import math
import multiprocessing
import os
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace

from benchmarks.truths.found import Exact, Found
from impulsekit.errors import ImpulsekitError, SetupWarning

from .judge import Judgement, judge
from .methods import answers
from .sweep import Case, Point, Sweep


def _all() -> tuple[Sweep, ...]:
    from . import (
        chains,
        collisions,
        flights,
        held,
        in_plane,
        laws,
        rewritten,
        robots,
        sequences,
        touched,
        trees,
    )

    return (
        *trees.SWEEPS,
        *chains.SWEEPS,
        *held.SWEEPS,
        *touched.SWEEPS,
        *laws.SWEEPS,
        *sequences.SWEEPS,
        *collisions.SWEEPS,
        *flights.SWEEPS,
        *in_plane.SWEEPS,
        *rewritten.SWEEPS,
        *robots.SWEEPS,
    )


ALL: tuple[Sweep, ...] = _all()

Job = tuple[str, int, int, int]
"""Name of a sweep, place of the value, repeat, seed."""


def sweep_named(name: str) -> Sweep:
    """The sweep of that name."""
    return next(sweep for sweep in ALL if sweep.name == name)


def jobs_of(sweeps: Sequence[Sweep], seed: int, share: float = 1.0) -> list[Job]:
    """All cases of some sweeps; ``share`` of their repeats, at least one of each value."""
    jobs = []
    for sweep in sweeps:
        for repeat in range(max(1, round(share * sweep.repeats))):
            jobs += [(sweep.name, place, repeat, seed) for place in range(len(sweep.values))]
    return jobs


def solved_case(job: Job) -> list[Point]:
    """The points of one case."""
    with warnings.catch_warnings():
        # Scenes at the edge are likely not meant by anybody else: a page of doubts a second.
        warnings.simplefilter("ignore", SetupWarning)
        return _solved_case(job)


def _solved_case(job: Job) -> list[Point]:
    name, place, repeat, seed = job
    sweep = sweep_named(name)
    value = sweep.values[place]
    try:
        case = sweep.cases(value, sweep.rng(place, repeat, seed))
    except ImpulsekitError as error:
        # Already the scene is refused.
        return [_point(job, value, 0, "scene", Found(None, type(error).__name__, False, 0.0))]
    if not isinstance(case, Case):
        return [replace(point, sweep=name, value=value, repeat=repeat) for point in case]
    states = [case.truth.at(q, v) for q, v in zip(case.q, case.v, strict=True)]
    exacts: list[Exact | None] = [None] * len(states)
    points = []
    for method, founds in answers(case):
        for i, found in enumerate(founds):
            judgement, exacts[i] = judge(states[i], exacts[i], found)
            points.append(_point(job, value, i, method, found, judgement))
    return points


def _point(
    job: Job,
    value: float,
    state: int,
    method: str,
    found: Found,
    judgement: Judgement | None = None,
) -> Point:
    name, _, repeat, _ = job
    told = judgement or Judgement("said so")
    numbers = (told.error, told.condition, told.share, told.each, told.momentum, told.law)
    return Point(
        name, value, repeat, state, method, found.status, told.verdict, *numbers, found.seconds
    )


def run(
    jobs: Sequence[Job], processes: int = 1, tell: Callable[[int], object] | None = None
) -> Iterator[list[Point]]:
    """The points of every case, as they come.

    Args:
        processes: how many; 1 runs here.
        tell: called with the number of cases done.
    """
    if processes <= 1:
        for count, job in enumerate(jobs, 1):
            yield solved_case(job)
            if tell is not None:
                tell(count)
        return
    # One thread each: the processes share the cores already.
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    size = max(1, min(20, math.ceil(len(jobs) / (8 * processes))))
    pieces = [jobs[i : i + size] for i in range(0, len(jobs), size)]
    done = 0
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(processes, mp_context=context) as pool:
        pending = [pool.submit(_piece, piece) for piece in pieces]
        for future in as_completed(pending):
            points = future.result()
            done += len({(p.sweep, p.value, p.repeat) for p in points})
            yield points
            if tell is not None:
                tell(done)


def _piece(jobs: Sequence[Job]) -> list[Point]:
    return [point for job in jobs for point in solved_case(job)]
