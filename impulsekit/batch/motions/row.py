"""Rows of a batch of motions, followed by threads: the core works without Python's lock."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from time import monotonic
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import pinocchio as pin

from ...errors import ImpulsekitError
from ...impact.contact_results import contact_impulses
from ...impact.status import BY_CODE
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


# Rows by their index, and what a function of the scene raised.
Followings: TypeAlias = "list[tuple[int, RowResult | BaseException]]"


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
    interrupts: Interrupts,
    inputs: BatchInputs,
    row: int,
    settings: MotionSettings,
    times: np.ndarray,
) -> RowResult:
    """Follow a row of a batch; one that is refused has the status ``REFUSED``.

    Args:
        interrupts: what ends it before its time.

    Raises:
        ImpulsekitError: a function of the scene is at fault, which is no fault of the row.
        KeyboardInterrupt: it came before the row began.
    """
    interrupts.heed()
    code = int(inputs.codes[row])
    if code:
        return row_without(scene, times, MotionStatus.REFUSED, str(BY_CODE[code].value))
    try:
        own = scene_of_row(scene, inputs, row) if varies(scene, inputs) else scene
        start = checked_start(own, *inputs.state(row), "simulate")
        followed = Followed(own, *start, settings)
        return _kept(followed, followed.follow(interrupts), times)
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


def _kept(followed: Followed, status: MotionStatus, times: np.ndarray) -> RowResult:
    """Return the row of a motion that was followed as far as it goes."""
    robot, core, t = followed.scene.robot, followed.core, followed.core.t
    count = len(times) if t >= times[-1] else int(np.searchsorted(times, t, side="right"))
    end = np.concatenate(followed.state(t))
    found = np.full((len(times) + 1, len(end)), np.nan)
    samples: Any = core.samples(times[:count])
    found[:count] = samples.reshape(count, -1)
    found[:count][times[:count] >= t] = found[-1] = end
    for row in (*found[:count], found[-1]):
        row[: robot.nq] = pin.normalize(robot.model, row[: robot.nq])
    names = followed.scene.entry_names("contacts")
    rests = sorted(followed.rests(t), key=lambda rest: rest[1])
    return RowResult(
        status,
        "" if status is MotionStatus.INTERRUPTED else followed.detail,
        t,
        found[:-1, : robot.nq],
        found[:-1, robot.nq :],
        found[-1, : robot.nq],
        found[-1, robot.nq :],
        _columns(followed),
        tuple((names[entry], start, end) for entry, start, end in rests),
        core.evaluations,
    )


def _columns(followed: Followed) -> dict[str, np.ndarray]:
    """The columns of ``ImpactTable`` for the impacts of one motion."""
    robot, contacts = followed.scene.robot, len(followed.scene.contacts)
    found = followed.core.impact_columns
    count = len(found.times)
    columns = _no_impacts(followed.scene, count)
    columns["time"][:], columns["status"][:] = found.times, found.status
    columns["touching"][:] = found.touching.reshape(count, contacts)
    columns["impulse"][:] = found.impulses.reshape(count, contacts, 3)
    columns["v_before"][:] = found.before.reshape(-1, robot.nv)
    columns["v_after"][:] = found.after.reshape(-1, robot.nv)
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
    # Threads take the next row each; iterators of a range are safe to share.
    indices = iter(range(len(rows)))
    ended: SimpleQueue[Followings] = SimpleQueue()
    with Interrupts() as interrupts, ThreadPoolExecutor(count) as pool:

        def work() -> None:
            found: Followings = []
            last = monotonic()
            try:
                for i in indices:
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
                done(index, result)
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
