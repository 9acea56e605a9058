"""One batch on the kernels: arrays laid out, pieces solved, answers in place."""

from __future__ import annotations

import functools
import os
import threading
from collections.abc import Callable
from typing import Any

import numpy as np

from ..laws.apart import failed, raise_failed
from ..laws.status import Status
from .codes import AGAIN
from .inputs import BatchInputs
from .kernels import layout
from .kernels.balls import balls_for
from .kernels.block import solve_blocks
from .kernels.given import Inputs, Outputs, Span
from .kernels.lanes import LANES, LANES32
from .kernels.lawful import law_for
from .program import Program

__all__ = ["BatchRun", "run_all", "run_in_double"]

_KINDS = (
    "dv",
    "v_after",
    "generalized_impulse",
    "contact_impulses",
    "constraint_impulses",
    "energy_change",
    "normal_components",
)
# Blocks per call of the kernel at most, so that progress can be told and no thread waits for
# another that is held up, and at least, so that what a call costs is forgotten.
LARGEST_PIECE = 512
SMALLEST_PIECE = 64
ALIGNMENT = 64

# Kinds of kernels that this process has run.
_compiled: set[object] = set()


class BatchRun:
    """A batch on its way through the kernels.

    Attributes:
        kind: what its kernels differ in from others, and whether they know no rows, those of one
            contact, or a law: 0, 1 or 2.
        rows_done: how many rows are solved.
    """

    def __init__(
        self,
        program: Program,
        inputs: BatchInputs,
        arrays: dict[str, np.ndarray],
        codes: np.ndarray,
        dtype: Any = np.float64,
    ) -> None:
        self.rows_done = 0
        self._dtype = np.dtype(dtype)
        self._program = program
        self._codes, self._arrays = codes, arrays
        self._size = inputs.size
        self._lanes = LANES32 if dtype == np.float32 else LANES
        # The kernels want at least one whole block.
        self._states = max(inputs.size, self._lanes.width)
        self._inputs = self._laid_out(inputs)
        self._outputs = self._room()
        self._contacts = program.contacts
        if inputs.restitution is not None:
            self._contacts = _of_given_restitution(*program.contacts)
        self._lock = threading.Lock()
        self._moving = program.moving()
        self._touch = program.touch(self._contacts)
        number, balls = self._lanes.number, len(program.balls[0]) > 0
        self._meet = None if self._touch is None else balls_for(number, balls)
        law = (number, program.words, len(program.held[0]) > 0) if program.needs_law else None
        self._law = None if law is None else law_for(*law)
        self.kind = (
            (number, law, len(self._contacts[0]) > 0, balls),
            (0 if self._touch is None else 1 if self._law is None else 2),
        )

    @property
    def is_compiled(self) -> bool:
        """Whether nothing would be compiled for it: its kernels are in memory, or on disk."""
        if self.kind in _compiled:
            return True
        for each in (self._meet, self._law):
            if each is not None and not each.is_there:
                return False
        arguments = self._arguments(0, 0, np.empty(0, self._dtype))
        kinds = tuple(map(solve_blocks.typeof_pyval, arguments))
        context = solve_blocks.targetctx
        return kinds in solve_blocks.overloads or solve_blocks._cache.holds(kinds, context)

    def compile(self) -> None:
        """Have what is handed to the kernels, before several threads ask for it."""
        for each in (self._meet, self._law):
            if each is not None:
                each.compile()

    def _laid_out(self, inputs: BatchInputs) -> Inputs:
        program = self._program
        found: list[Any] = []
        q, v = inputs.q, inputs.v
        if inputs.points is not None:
            # The places of points stand behind the robot's own entries, and do not move.
            size = max(len(q), len(inputs.points))
            q = np.hstack([np.broadcast_to(x, (size, x.shape[1])) for x in (q, inputs.points)])
            v = np.hstack([v, np.zeros((len(v), inputs.points.shape[1]))])
        pairs: tuple[tuple[Any, Any], ...] = (
            (q, None),
            (v, None),
            (inputs.given, None),
            (inputs.restitution, program.restitution),
            (inputs.friction, program.friction),
            (inputs.masses, np.ones(len(inputs.links))),
        )
        for array, own in pairs:
            array = np.reshape(own, (1, -1)) if array is None else array
            if len(array) > 1 and self._states > self._size:
                array = np.concatenate([array, np.repeat(array[-1:], self._states - self._size, 0)])
            found.extend((_plain(array), array.shape[1] if len(array) > 1 else 0))
        # A row that only fills a block passes through all kernels but the laws of contact.
        codes = np.full(self._states, int(Status.OUT_OF_RANGE), dtype=np.int8)
        codes[: self._size] = inputs.codes
        return Inputs._make([*found, codes])

    def _room(self) -> Outputs:
        """The arrays that the kernel writes: those asked for, or larger ones of few rows."""
        program = self._program
        rows = len(program.rows.first) - 1
        whole = []
        own = program.tree.v_index < program.sizes.whole_v
        skipped = int(own.sum()) < program.sizes.whole_v
        for name in _KINDS:
            if name not in self._arrays:
                whole.append(np.empty(0, self._dtype))
                continue
            array = self._arrays[name]
            if name == "constraint_impulses":
                array = np.empty((self._states, rows), self._dtype)
            elif self._states > self._size:
                array = np.empty((self._states, *array.shape[1:]), self._dtype)
            if skipped and name in ("dv", "generalized_impulse"):
                array[:] = 0.0
            elif skipped and name == "v_after":
                v, step = self._inputs.v, self._inputs.v_step
                width = array.shape[1]
                array[:] = v.reshape(-1, step)[:, :width] if step else v[:width]
            whole.append(array)
        codes = self._codes if self._states == self._size else np.empty(self._states, np.int8)
        self._whole = (*whole, codes)
        return Outputs(*(array.reshape(-1) for array in self._whole))

    def pieces(self, threads: int) -> list[tuple[int, int]]:
        """First and last block of each call."""
        blocks = -(-self._states // self._lanes.width)
        size = min(LARGEST_PIECE, max(SMALLEST_PIECE, -(-blocks // threads)))
        return [(begin, min(begin + size, blocks)) for begin in range(0, blocks, size)]

    def solve(self, begin: int, end: int) -> None:
        """Solve some blocks; several threads may do so at once."""
        lanes = self._lanes
        spare = ALIGNMENT // self._dtype.itemsize
        work = np.empty(self._moving.at.end * lanes.width + spare, self._dtype)
        shift = -(work.ctypes.data // self._dtype.itemsize) % spare
        solve_blocks(*self._arguments(begin, end, work[shift:]))
        _compiled.add(self.kind)
        if failed:
            raise_failed()
        with self._lock:
            self.rows_done += min(end * lanes.width, self._size)
            self.rows_done -= min(begin * lanes.width, self._size)
            if self.rows_done == self._size:
                self._hand_over()

    def _arguments(self, begin: int, end: int, work: np.ndarray) -> tuple[Any, ...]:
        """What ``solve_blocks`` takes."""
        return (
            Span(begin, end, self._states, np.empty(self._lanes.width, np.int8)),
            self._moving,
            self._touch,
            self._meet,
            self._law,
            1 if self._law is None else None,
            1 if self._law is not None and len(self._contacts[0]) == 0 else None,
            self._inputs,
            self._outputs,
            work,
            self._lanes,
        )

    def _hand_over(self) -> None:
        """Copy what the kernel could not write where it was wanted."""
        for name, array in zip(_KINDS, self._whole, strict=False):
            if name in self._arrays and array is not self._arrays[name]:
                wanted = self._arrays[name]
                rows = array[: self._size].reshape(self._size, -1)
                first = self._program.own_rows if name == "constraint_impulses" else 0
                wanted[...] = rows[:, first : first + wanted[0].size].reshape(wanted.shape)
        if self._whole[-1] is not self._codes:
            self._codes[:] = self._whole[-1][: self._size]


def run_all(run: BatchRun, threads: int, tell: Callable[[int], object]) -> None:
    """All rows by the kernels, pieces of the batch on several threads."""
    run.compile()
    pieces = run.pieces(threads)
    if threads == 1 or len(pieces) == 1:
        for begin, end in pieces:
            run.solve(begin, end)
            tell(run.rows_done)
        return
    from concurrent.futures import as_completed

    pool = _pool(threads, os.getpid())
    for done in as_completed([pool.submit(run.solve, *piece) for piece in pieces]):
        done.result()
        tell(run.rows_done)


def run_in_double(
    program: Program,
    inputs: BatchInputs,
    rows: np.ndarray,
    arrays: dict[str, np.ndarray],
    codes: np.ndarray,
    threads: int,
) -> np.ndarray:
    """Solve the rows that single precision cannot decide; those that are still open."""
    few = {name: np.empty((len(rows), *array.shape[1:])) for name, array in arrays.items()}
    own = np.zeros(len(rows), dtype=np.int8)
    run_all(BatchRun(program, inputs.rows(rows), few, own), threads, lambda _: None)
    for name, array in arrays.items():
        array[rows] = few[name]
    codes[rows] = own
    return rows[own == AGAIN]


@functools.cache
def _pool(threads: int, process: int) -> Any:
    """Threads that stay, for to start them costs as much as some thousand states; a process
    that was forked off has to have its own."""
    from concurrent.futures import ThreadPoolExecutor

    return ThreadPoolExecutor(threads, thread_name_prefix="impulsekit batch")


def _of_given_restitution(ints: np.ndarray, floats: np.ndarray) -> tuple[np.ndarray, ...]:
    """The tables of contacts whose restitutions are given with the batch, not by the speed."""
    ints, floats = ints.copy(), floats.copy()
    ints[4 :: layout.CONTACT_INTS], ints[5 :: layout.CONTACT_INTS] = 0, 0
    count = len(ints) // layout.CONTACT_INTS
    floats[12 : count * layout.CONTACT_FLOATS : layout.CONTACT_FLOATS] = 0.0
    return ints, floats


def _plain(array: np.ndarray) -> np.ndarray:
    """Flat, in order, and not marked as read-only: to numba that would be another type, and
    all kernels would be compiled once more."""
    flat = np.ascontiguousarray(array).reshape(-1)
    return flat if flat.flags.writeable else flat.copy()
