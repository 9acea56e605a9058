"""Rows of a batch of motions, followed by threads: the core works without Python's lock."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from queue import Empty, SimpleQueue
from time import monotonic
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import pinocchio as pin

from ...errors import ImpulsekitError
from ...impact.contact_results import contact_impulses
from ...impact.status import BY_CODE
from ...motion.followed import Followed, checked_start, rests_until
from ...motion.interrupts import Interrupts
from ...motion.record.status import MotionStatus
from ...motion.simulate import simulate
from ...scene import Scene
from ...scene.motion import MotionSettings
from ..inputs import BatchInputs
from ..rows import scene_of_row

if TYPE_CHECKING:
    from ..._core import ImpactColumns, MotionColumns
    from ...motion.record.sampled import Hits
    from ...motion.record.trajectory import Trajectory

__all__ = ["RowResult", "follow_rows", "motion_of_row", "row_without"]

# How long Ctrl-C may wait for a look at it, and threads keep what they have followed: each time it
# is handed over Python's lock changes hands [s].
LOOK, HANDS_OVER = 0.2, 0.05


@dataclass(frozen=True, eq=False)
class RowResult:
    """The results that are kept of a motion.

    Attributes:
        status: how it ended. detail: what else there is to say.
        end: up to when it was followed [s]; NaN where it was refused.
        q: (T, nq) at the sample times, NaN after the end. v: (T, nv).
        q_end: (nq,) at the end. v_end: (nv,).
        impacts: by column of ``ImpactTable``, one entry for each impact.
        rests: (contact, start [s], end [s]).
        evaluations: of the accelerations.
    """

    status: MotionStatus
    detail: str
    end: float
    q: np.ndarray
    v: np.ndarray
    q_end: np.ndarray
    v_end: np.ndarray
    impacts: dict[str, np.ndarray]
    rests: tuple[tuple[str, float, float], ...]
    evaluations: int


# Rows by their index, to be brought over from the core, and what a function of the scene raised.
Followings: TypeAlias = "list[tuple[int, Callable[[], RowResult] | BaseException]]"


def motion_of_row(
    scene: Scene,
    inputs: BatchInputs,
    row: int,
    settings: MotionSettings,
    times: np.ndarray,
) -> Trajectory:
    """The motion of a row, as ``simulate`` gives it.

    Raises:
        ImpulsekitError: it is refused.
    """
    own = scene_of_row(scene, inputs, row) if inputs.varies else scene
    return simulate(own, *inputs.state(row), settings=settings, samples=times)


def _followed_row(
    scene: Scene,
    interrupts: Interrupts,
    inputs: BatchInputs,
    row: int,
    settings: MotionSettings,
    times: np.ndarray,
) -> Callable[[], RowResult]:
    """Follow a row of a batch, and return how to bring it over from the core.

    One that is refused has the status ``REFUSED``.

    Args:
        interrupts: what ends it before its time.

    Raises:
        ImpulsekitError: a function of the scene is at fault, which is no fault of the row.
        KeyboardInterrupt: it came before the row began.
    """
    interrupts.heed()
    code = int(inputs.codes[row])
    if code:
        return partial(row_without, scene, times, MotionStatus.REFUSED, str(BY_CODE[code].value))
    try:
        own = scene_of_row(scene, inputs, row) if inputs.varies else scene
        start = checked_start(own, *inputs.state(row), "simulate")
        followed = Followed(own, *start, settings)
        status, core = followed.follow(interrupts), followed.core
        detail = "" if status is MotionStatus.INTERRUPTED else followed.detail
        at = None if core.begun else start
        return partial(
            _kept, own, times, core.columns(times), followed.first, at, status=status, detail=detail
        )
    except ImpulsekitError as error:
        if error.from_function:
            raise
        return partial(row_without, scene, times, MotionStatus.REFUSED, str(error))


def row_without(
    scene: Scene, times: np.ndarray, status: MotionStatus, detail: str = ""
) -> RowResult:
    """A row of which nothing is known."""
    robot, count = scene.robot, len(times)
    return RowResult(
        status,
        detail,
        np.nan,
        np.full((count, robot.nq), np.nan),
        np.full((count, robot.nv), np.nan),
        np.full(robot.nq, np.nan),
        np.full(robot.nv, np.nan),
        _no_impacts(scene, 0),
        (),
        0,
    )


def _kept(
    scene: Scene,
    times: np.ndarray,
    columns: MotionColumns,
    first: Hits,
    start: tuple[np.ndarray, np.ndarray] | None,
    **ended: Any,
) -> RowResult:
    """Return the row of a motion that was followed as far as it goes.

    Args:
        first: the impact at the start, if there was one.
        start: q and v, of one that could not begin.
        **ended: status and detail.
    """
    robot, t, end = scene.robot, columns.t, columns.end
    if start is not None:
        end = np.concatenate(start)
    found = np.full((len(times) + 1, len(end)), np.nan)
    samples = columns.samples.reshape(-1, len(end))
    count = len(samples)
    found[:count] = samples
    found[:count][times[:count] >= t] = found[-1] = end
    for row in (*found[:count], found[-1]):
        row[: robot.nq] = pin.normalize(robot.model, row[: robot.nq])
    names = scene.entry_names("contacts")
    rests = sorted(rests_until(columns.rests, t), key=lambda rest: rest[1])
    return RowResult(
        end=t,
        q=found[:-1, : robot.nq],
        v=found[:-1, robot.nq :],
        q_end=found[-1, : robot.nq],
        v_end=found[-1, robot.nq :],
        impacts=_impacts(scene, columns.impacts, first),
        rests=tuple((names[entry], start, end) for entry, start, end in rests),
        evaluations=columns.evaluations,
        **ended,
    )


def _impacts(scene: Scene, found: ImpactColumns, first: Hits) -> dict[str, np.ndarray]:
    """The columns of ``ImpactTable`` for the impacts of one motion."""
    count, contacts, nv = len(found.times), len(scene.contacts), scene.robot.nv
    columns: dict[str, np.ndarray] = {
        "time": found.times,
        "status": np.array(found.status, dtype=np.int8),
        "touching": found.touching.reshape(count, contacts),
        "impulse": found.impulses.reshape(count, contacts, 3),
        "v_before": found.before.reshape(count, nv),
        "v_after": found.after.reshape(count, nv),
    }
    if not first:
        return columns
    # At the start known impulses strike too.
    own = _no_impacts(scene, 1)
    (own["time"][0], impact), *_ = first
    own["status"][0] = impact.status
    own["v_before"][0], own["v_after"][0] = impact.v_before, impact.v_after
    for k, impulse in contact_impulses(impact).items():
        own["touching"][0, k] = True
        own["impulse"][0, k, : len(impulse)] = impulse
    return {name: np.concatenate([own[name], columns[name]]) for name in columns}


def _no_impacts(scene: Scene, count: int) -> dict[str, np.ndarray]:
    """The columns of ``ImpactTable``, for so many impacts."""
    contacts, nv = len(scene.contacts), scene.robot.nv
    return {
        "time": np.zeros(count),
        "status": np.zeros(count, dtype=np.int8),
        "touching": np.zeros((count, contacts), dtype=bool),
        "impulse": np.zeros((count, contacts, 3)),
        "v_before": np.empty((count, nv)),
        "v_after": np.empty((count, nv)),
    }


def follow_rows(
    scene: Scene,
    rows: Sequence[tuple[Any, ...]],
    threads: int | None,
    done: Callable[[int, RowResult], object],
) -> bool:
    """Have motions of one scene followed.

    Args:
        rows: of each its inputs, settings and times, as ``_followed_row`` takes them.
        threads: how many; None for as many as the process may use cores.
        done: called in this thread with the index of a row and what is kept of it; in whatever
            order they come.

    Returns:
        Whether all were followed; False after Ctrl-C.

    Raises:
        ImpulsekitError: a function of the scene is at fault.
    """
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    count = max(1, min(len(rows), threads or cores or 1))
    # Threads take the next row each; iterators of a range are safe to share.
    indices = iter(range(len(rows)))
    ended: SimpleQueue[Followings] = SimpleQueue()
    with Interrupts() as interrupts, ThreadPoolExecutor(count) as pool:

        def work() -> None:
            found: Followings = []
            last = monotonic()
            try:
                for i in indices:
                    # What Python makes of a row is made in the thread that waits, row after row.
                    found.append((i, _followed_row(scene, interrupts, *rows[i])))
                    if monotonic() - last > HANDS_OVER:
                        ended.put(found)
                        found, last = [], monotonic()
            except BaseException as error:
                found.append((-1, error))
            ended.put(found)

        def keep(found: Followings) -> int:
            for index, result in found:
                if isinstance(result, BaseException):
                    raise result
                done(index, result())
            return len(found)

        for _ in range(count):
            pool.submit(work)
        try:
            left = len(rows)
            while left:
                left -= keep(_next(ended, interrupts))
            interrupts.heed()
            return True
        except BaseException as error:
            interrupts.stop()
            pool.shutdown()
            if not isinstance(error, KeyboardInterrupt):
                raise
            while not ended.empty():
                with suppress(KeyboardInterrupt):
                    keep(ended.get())
            return False


def _next(ended: SimpleQueue[Followings], interrupts: Interrupts) -> Followings:
    """The next results, while Ctrl-C is heeded."""
    while True:
        interrupts.heed()
        with suppress(Empty):
            return ended.get(timeout=LOOK)
