"""Motions followed by several threads: the core works without the interpreter's lock."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from queue import Empty, SimpleQueue
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
