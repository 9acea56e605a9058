"""Motions followed by several threads: the core works without the interpreter's lock."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from functools import partial
from typing import Any

from ...motion.interrupts import Interrupts
from ...scene import Scene
from .row import RowResult, followed_row

__all__ = ["follow_rows"]

# How long Ctrl-C may wait for a look at it [s].
LOOK = 0.2


def follow_rows(
    scene: Scene,
    rows: Sequence[tuple[Any, ...]],
    threads: int | None,
    done: Callable[[int, RowResult], object],
) -> bool:
    """Have motions of one scene followed.

    Args:
        rows: of each its inputs, settings and times, as ``followed_row`` takes them.
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
        follow = partial(followed_row, scene, interrupts=interrupts)
        waiting = {pool.submit(follow, *row): i for i, row in enumerate(rows)}
        try:
            while waiting:
                interrupts.heed()
                for future in wait(waiting, LOOK, FIRST_COMPLETED).done:
                    done(waiting.pop(future), future.result())
            interrupts.heed()
            return True
        except BaseException as error:
            interrupts.stop()
            pool.shutdown(cancel_futures=True)
            if not isinstance(error, KeyboardInterrupt):
                raise
            for future, index in waiting.items():
                if not future.cancelled() and future.exception() is None:
                    done(index, future.result())
            return False
