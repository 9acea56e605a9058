"""Processes that follow motions, kept for the next batch; one thread here talks to each.

They are started by the interpreter's own command line, not forked (threads of compiled code do
not outlive that) and not by ``multiprocessing`` (which imports the user's script once more).
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from ...motion.interrupts import Interrupts
from .worker import receive, send

__all__ = ["CannotSend", "Lost", "follow_rows", "worker_count"]

# How long processes may take to tell how far they came after Ctrl-C [s].
PATIENCE = 5.0
_START = (
    "import sys, json; sys.path[:] = json.loads(sys.argv[1]); "
    "from impulsekit.batch.motions.worker import main; main()"
)


class CannotSend(Exception):
    """A scene cannot be had in another process. Internal."""


class Lost:
    """What is told of a row whose process ended twice.

    Attributes:
        code: the exit status of the process, negative for a signal.
    """

    def __init__(self, code: int | None) -> None:
        self.code = code


class _Worker:
    def __init__(self) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-c", _START, json.dumps(sys.path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            # Ctrl-C is for the process that waits for them.
            start_new_session=True,
        )
        self.holds = ""

    def ask(self, kind: str, content: Any) -> Any:
        """An answer to a message.

        Raises:
            EOFError: the process has ended.
        """
        try:
            hears, answers = self.process.stdin, self.process.stdout
            if hears is None or answers is None:
                raise EOFError
            send(hears, (kind, content))
            return receive(answers)
        except (OSError, ValueError) as error:
            raise EOFError from error

    def take(self, packed: bytes, key: str) -> None:
        """Have the scene there.

        Raises:
            CannotSend, EOFError.
        """
        if self.holds != key:
            self.holds = ""
            reason = self.ask("scene", packed)
            if reason:
                raise CannotSend(reason)
            self.holds = key

    def end(self) -> int | None:
        """End the process; its exit status."""
        for stream in (self.process.stdin, self.process.stdout):
            with contextlib.suppress(OSError):
                if stream is not None:
                    stream.close()
        with contextlib.suppress(OSError):
            self.process.kill()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(PATIENCE)
        return self.process.returncode


_idle: list[_Worker] = []
_guard = threading.Lock()
_owner = os.getpid()


@atexit.register
def _end_all() -> None:
    if os.getpid() == _owner:
        for worker in _idle:
            worker.end()


@contextlib.contextmanager
def _borrowed(count: int) -> Iterator[list[_Worker]]:
    """So many processes, of those that are there or new; given back alive."""
    global _owner
    with _guard:
        if os.getpid() != _owner:
            # After a fork they are the other process's.
            _idle.clear()
            _owner = os.getpid()
        workers = [_idle.pop() for _ in range(min(count, len(_idle)))]
    workers += [_Worker() for _ in range(count - len(workers))]
    try:
        yield workers
    finally:
        with _guard:
            _idle.extend(worker for worker in workers if worker.process.poll() is None)


def worker_count(rows: int, asked: int | None) -> int:
    """How many processes are of use."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return max(1, min(rows, asked or cores or 1))


def follow_rows(
    packed: bytes,
    key: str,
    rows: Sequence[Any],
    count: int,
    done: Callable[[int, Any], object],
) -> bool:
    """Have rows followed by processes.

    Args:
        packed: the scene, pickled. key: what tells it from others.
        rows: what is sent for each.
        count: of the processes.
        done: called in this thread with the index of a row and its answer, a ``RowResult`` or
            ``Lost``; in whatever order they come.

    Returns:
        Whether all were followed; False after Ctrl-C.

    Raises:
        CannotSend: the scene cannot be had in another process.
        Exception: what a row raised.
    """
    with _borrowed(count) as workers:
        run = _Run(packed, key, rows, workers)
        try:
            return run.follow(done)
        finally:
            run.leave()


class _Run:
    def __init__(
        self, packed: bytes, key: str, rows: Sequence[Any], workers: list[_Worker]
    ) -> None:
        self._packed, self._key, self._rows, self._workers = packed, key, rows, workers
        self._next, self._left, self._stopped = 0, len(workers), False
        self._answers: list[tuple[int, Any]] = []
        self._change = threading.Condition()
        self._threads = [
            threading.Thread(target=self._serve, args=(place,), daemon=True)
            for place in range(len(workers))
        ]

    def follow(self, done: Callable[[int, Any], object]) -> bool:
        for thread in self._threads:
            thread.start()
        try:
            with Interrupts() as interrupts:
                self._collect(done, interrupts)
            return True
        except KeyboardInterrupt:
            self._stop(signal.SIGINT)
            until = time.monotonic() + PATIENCE
            for thread in self._threads:
                thread.join(max(0.0, until - time.monotonic()))
            for index, answer in self._answers:
                if not isinstance(answer, Exception):
                    done(index, answer)
            return False

    def leave(self) -> None:
        """Leave no process at work."""
        self._stopped = True
        for worker, thread in zip(self._workers, self._threads, strict=True):
            if thread.is_alive():
                worker.end()
                thread.join(PATIENCE)

    def _collect(self, done: Callable[[int, Any], object], interrupts: Interrupts) -> None:
        while True:
            interrupts.heed()
            with self._change:
                while not self._answers and self._left:
                    interrupts.heed()
                    self._change.wait(0.2)
                if not self._answers:
                    return
                index, answer = self._answers.pop(0)
            if isinstance(answer, Exception):
                raise answer
            done(index, answer)

    def _stop(self, number: int) -> None:
        self._stopped = True
        for worker, thread in zip(self._workers, self._threads, strict=True):
            if thread.is_alive() and worker.process.poll() is None:
                worker.process.send_signal(number)

    def _serve(self, place: int) -> None:
        try:
            while not self._stopped:
                with self._change:
                    index = self._next
                    self._next += 1
                if index >= len(self._rows):
                    break
                self._tell(index, self._answer(place, index))
        except Exception as error:
            self._tell(-1, error)
        finally:
            with self._change:
                self._left -= 1
                self._change.notify()

    def _answer(self, place: int, index: int) -> Any:
        code = None
        # A process may be killed for what is no fault of the row: it is followed once more.
        for _ in range(2):
            worker = self._workers[place]
            try:
                worker.take(self._packed, self._key)
                kind, answer = worker.ask("row", self._rows[index])
            except EOFError:
                code = worker.end()
                if self._stopped:
                    return None
                self._workers[place] = _Worker()
                continue
            if kind == "error":
                raise answer
            return answer
        return Lost(code)

    def _tell(self, index: int, answer: Any) -> None:
        with self._change:
            self._answers.append((index, answer))
            self._change.notify()
