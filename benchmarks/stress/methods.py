"""Every way of impulsekit to solve a scene, told alike."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from benchmarks.truths.found import Found
from impulsekit.batch.solve import solve_batch
from impulsekit.errors import ImpulsekitError
from impulsekit.impact import Impact, solve
from impulsekit.impact.status import Status
from impulsekit.scene import Collision, Scene

from .sweep import Case

VERDICTS = ("proven", "not proven", "several")


@dataclass(frozen=True)
class Told:
    """An answer.

    Attributes:
        status: name of the status or of the error.
        valid, lawful: whether it is valid, and whether it obeys the law.
        others: verdict on other answers, "" where that was not asked for.
        after: (nv,) v⁺; None for an error.
        seconds: of the call; of a batch, per state.
    """

    status: str
    valid: bool
    lawful: bool
    others: str
    after: np.ndarray | None
    seconds: float = 0.0


def told(call: Callable[[], Impact], *, others: bool = False) -> Told:
    """What an impact, or an error of ours, says; ``others``: look for other answers, too."""
    start = time.perf_counter()
    try:
        impact = call()
        status, after = impact.status, np.array(impact.v_after)
        seconds = time.perf_counter() - start
    except ImpulsekitError as error:
        return Told(type(error).__name__, False, False, "", None, time.perf_counter() - start)
    verdict = impact.uniqueness.verdict if others and status.obeys_law else ""
    return Told(status.name, impact.is_valid(), status.obeys_law, verdict, after, seconds)


def told_by_batch(scene: Scene, q: np.ndarray, v: np.ndarray) -> list[Told]:
    """What ``solve_batch`` says of states q (B, nq), v (B, nv)."""
    start = time.perf_counter()
    outputs = ["dv", "contact_impulses", "uniqueness"]
    batch = solve_batch(scene, q, v, outputs=outputs, threads=1)
    seconds = (time.perf_counter() - start) / len(v)
    others = batch.uniqueness
    found = zip(map(Status, batch.status.tolist()), others, v + batch.dv, strict=True)
    return [
        Told(status.name, status.valid, status.obeys_law, VERDICTS[int(other)], after, seconds)
        for status, other, after in found
    ]


def answers(case: Case) -> Iterator[tuple[str, list[Found]]]:
    """By method, what it answers at each state of a case; ``solve`` comes first."""
    states = list(zip(case.q, case.v, strict=True))
    yield "solve", [_found(partial(solve, case.scene), q, v) for q, v in states]
    if case.batch:
        yield "batch", _by_batch(case)


def _found(call: Callable[[np.ndarray, np.ndarray], Impact], q: np.ndarray, v: np.ndarray) -> Found:
    start = time.perf_counter()
    try:
        with np.errstate(all="ignore"):
            impact = call(q, v)
            seconds = time.perf_counter() - start
            status = impact.status
            # It says which rows were left out: not an answer for the rows as they are.
            valid = impact.is_valid() and impact.status is not Status.NEARLY_DEPENDENT
    except ImpulsekitError as error:
        return Found(None, type(error).__name__, False, time.perf_counter() - start)
    except Exception as error:
        # No error of ours: nobody was told what is wrong.
        return Found(None, f"crash: {type(error).__name__}", True, time.perf_counter() - start)
    rows, contacts, unique = _impulses(impact)
    places = None
    if any(isinstance(entry, Collision) for entry in impact.scene.contacts):
        points = [point for result in impact.contacts for point in result.points]
        contacts = tuple(np.array(point.impulse) for point in points)
        places = tuple(np.array(p.position) for p in points if p.position is not None)
    # Which impulses are shared is told beside the status.
    return Found(np.array(impact.dv), status.name, valid, seconds, rows, contacts, unique, places)


def _impulses(
    impact: Impact,
) -> tuple[np.ndarray | None, tuple[np.ndarray, ...] | None, tuple[bool, ...] | None]:
    scene = impact.scene
    rows: np.ndarray | None = None
    contacts: tuple[np.ndarray, ...] | None = None
    unique: tuple[bool, ...] | None = None
    if scene.constraints:
        rows = np.concatenate([result.impulse for result in impact.constraints])
        determined = [one for result in impact.constraints for one in result.unique_rows]
        if not all(determined):
            unique = (False,)
    if scene.contacts:
        contacts = tuple(np.array(result.impulse) for result in impact.contacts)
        unique = (unique or ()) + tuple(result.unique for result in impact.contacts)
    return rows, contacts, unique


def _by_batch(case: Case) -> list[Found]:
    scene = case.scene
    outputs = ["dv"]
    if scene.constraints:
        outputs.append("constraint_impulses")
    if scene.contacts:
        outputs.append("contact_impulses")
    start = time.perf_counter()
    try:
        with np.errstate(all="ignore"):
            batch = solve_batch(scene, case.q, case.v, outputs=outputs, threads=1)
    except ImpulsekitError as error:
        each = Found(None, type(error).__name__, False, time.perf_counter() - start)
        return [each] * len(case.q)
    except Exception as error:
        each = Found(None, f"crash: {type(error).__name__}", True, time.perf_counter() - start)
        return [each] * len(case.q)
    seconds = (time.perf_counter() - start) / len(case.q)
    founds = []
    for i, code in enumerate(batch.status.tolist()):
        status = Status(code)
        contacts = None
        if scene.contacts:
            contacts = tuple(batch.contact_impulses[i])
        founds.append(
            Found(
                np.array(batch.dv[i]),
                status.name,
                status.valid and status is not Status.NEARLY_DEPENDENT,
                seconds,
                np.array(batch.constraint_impulses[i]) if scene.constraints else None,
                contacts,
            )
        )
    return founds
