"""Rows of a batch of motions, followed by threads: the core works without Python's lock."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import ImpulsekitError
from ...impact.contact_results import contact_impulses
from ...impact.status import Status
from ...motion.followed import Followed, checked_start
from ...motion.interrupts import Interrupts
from ...motion.record.status import MotionStatus
from ...motion.simulate import simulate
from ...scene import Scene
from ...scene.motion import MotionSettings
from ..inputs import BatchInputs
from ..rows import scene_of_row, varies

if TYPE_CHECKING:
    from ...motion.record.trajectory import Trajectory

__all__ = ["RowResult", "follow_rows", "motion_of_row", "row_without"]

# How long Ctrl-C may wait for a look at it [s].
LOOK = 0.2


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
    own = scene_of_row(scene, inputs, row) if varies(scene, inputs) else scene
    return simulate(own, *inputs.state(row), settings=settings, samples=times)


def _followed_row(
    scene: Scene,
    inputs: BatchInputs,
    row: int,
    settings: MotionSettings,
    times: np.ndarray,
    interrupts: Interrupts,
) -> RowResult:
    """Follow a row of a batch; one that is refused has the status ``REFUSED``.

    Args:
        interrupts: what ends it before its time.

    Raises:
        ImpulsekitError: a function of the scene is at fault, which is no fault of the row.
        KeyboardInterrupt: it came before the row began.
    """
    interrupts.heed()
    code = Status(int(inputs.codes[row]))
    if code is not Status.SOLVED:
        return row_without(scene, times, MotionStatus.REFUSED, str(code.value))
    try:
        own = scene_of_row(scene, inputs, row) if varies(scene, inputs) else scene
        start = checked_start(own, *inputs.state(row), "simulate")
        followed = Followed(own, *start, settings)
        return _kept(followed, followed.to_end(times, None, interrupts), times)
    except ImpulsekitError as error:
        if error.from_function:
            raise
        return row_without(scene, times, MotionStatus.REFUSED, str(error))


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


def _kept(followed: Followed, motion: Trajectory, times: np.ndarray) -> RowResult:
    robot = motion.scene.robot
    q = np.full((len(times), robot.nq), np.nan)
    v = np.full((len(times), robot.nv), np.nan)
    # A motion that was stopped lists the state at its end besides.
    count = int(np.searchsorted(times, motion.t[-1], side="right"))
    q[:count], v[:count] = motion.q[:count], motion.v[:count]
    q_end, v_end = motion.at(motion.duration)
    return RowResult(
        motion.status,
        motion.detail,
        motion.duration,
        q,
        v,
        q_end,
        v_end,
        _columns(followed),
        tuple((rest.contact, rest.start, rest.end) for rest in motion.rests),
        motion.evaluations,
    )


def _columns(followed: Followed) -> dict[str, np.ndarray]:
    """The columns of ``ImpactTable`` for the impacts of one motion."""
    robot, contacts = followed.scene.robot, len(followed.scene.contacts)
    times, codes, before, after, touching, impulses = followed.core.met
    columns = _no_impacts(followed.scene, len(times))
    columns["time"][:], columns["status"][:] = times, codes
    columns["touching"][:] = touching.reshape(len(times), contacts) > 0.0
    columns["impulse"][:] = impulses.reshape(len(times), contacts, 3)
    columns["v_before"][:] = before.reshape(-1, robot.nv)
    columns["v_after"][:] = after.reshape(-1, robot.nv)
    if not followed.first:
        return columns
    # At the start known impulses strike too.
    first = _no_impacts(followed.scene, 1)
    (first["time"][0], impact), *_ = followed.first
    first["status"][0] = impact.status
    first["v_before"][0], first["v_after"][0] = impact.v_before, impact.v_after
    for k, impulse in contact_impulses(impact).items():
        first["touching"][0, k] = True
        first["impulse"][0, k, : len(impulse)] = impulse
    return {name: np.concatenate([first[name], columns[name]]) for name in columns}


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
    with Interrupts() as interrupts, ThreadPoolExecutor(count) as pool:
        follow = partial(_followed_row, scene, interrupts=interrupts)
        ended: SimpleQueue[tuple[int, Future[RowResult]]] = SimpleQueue()

        def tell(index: int, future: Future[RowResult]) -> None:
            ended.put((index, future))

        for i, row in enumerate(rows):
            pool.submit(follow, *row).add_done_callback(partial(tell, i))
        left = len(rows)
        try:
            while left:
                interrupts.heed()
                with suppress(Empty):
                    index, future = ended.get(timeout=LOOK)
                    left -= 1
                    done(index, future.result())
            interrupts.heed()
            return True
        except BaseException as error:
            interrupts.stop()
            pool.shutdown(cancel_futures=True)
            if not isinstance(error, KeyboardInterrupt):
                raise
            while not ended.empty():
                index, future = ended.get()
                if not future.cancelled() and future.exception() is None:
                    done(index, future.result())
            return False
