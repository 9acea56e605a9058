"""Batches by ``solve``, row by row, where kernels would have to be compiled for them first.

On a fresh installation compiling takes as long as some ten thousand rows do. A batch is solved
by kernels as a whole or not at all: which of its rows came first does not show in its digits.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator
from contextvars import ContextVar

import numpy as np

from ..scene import Scene
from .inputs import BatchInputs
from .single import solve_rows

__all__ = ["by_kernels_only", "solved_meanwhile"]

# Processor time that batches take row by row before their kernels are compiled [s]: less than
# compiling does. Without rows, with those of one contact, and with a law handed over.
BUDGETS = (8.0, 10.0, 15.0)
# Share of the budget after which the time of all rows is foretold from that of the quicker of the
# last ones and all: the first wait for what is imported, some for a law that is compiled meanwhile.
TRIAL = 0.05
# Rows between two looks at the clock.
CHUNK = 16

# By kind of kernels, what batches have taken so far [s].
_spent: dict[object, float] = {}
_kernels_only: ContextVar[bool] = ContextVar("kernels_only", default=False)


@contextlib.contextmanager
def by_kernels_only() -> Iterator[None]:
    """Batches wait for their kernels: all rows of several batches are to have the same digits.

    Example:
        >>> from impulsekit import Robot, Scene, AppliedImpulse, solve_batch
        >>> robot = Robot.from_example("panda")
        >>> scene = Scene(robot, [AppliedImpulse("panda_hand", linear=[0, 0, 1])])
        >>> with by_kernels_only():
        ...     batch = solve_batch(scene, robot.neutral())
        >>> batch.single
        array([False])
    """
    before = _kernels_only.set(True)
    try:
        yield
    finally:
        _kernels_only.reset(before)


def solved_meanwhile(
    scene: Scene,
    inputs: BatchInputs,
    kind: tuple[object, int],
    answers: tuple[dict[str, np.ndarray], np.ndarray, np.ndarray],
    tell: Callable[[int], object],
) -> bool:
    """Solve all rows one by one, if that is sooner done than compiling; else nothing counts.

    Args:
        scene: as ``solve_batch`` takes it.
        inputs: of the batch.
        kind: of its kernels, and the place of their budget in ``BUDGETS``.
        answers: arrays, codes and verdicts, written to.
        tell: called with how many rows are done.
    """
    if _kernels_only.get():
        return False
    left = BUDGETS[kind[1]] - _spent.get(kind, 0.0)
    begin = time.thread_time()
    done, used, each = 0, 0.0, 0.0
    while done < inputs.size:
        rest = min(each, used / max(done, 1)) * (inputs.size - done)
        if used > TRIAL * left and used + rest > left:
            break
        end = min(done + CHUNK, inputs.size)
        solve_rows(scene, inputs, range(done, end), *answers)
        before, used = used, time.thread_time() - begin
        each = (used - before) / (end - done)
        done = end
        tell(done)
    _spent[kind] = _spent.get(kind, 0.0) + used
    return done == inputs.size
