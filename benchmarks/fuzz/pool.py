"""Worker processes that may die: a crash is laid at the door of the file it happened on."""

from __future__ import annotations

import collections
import faulthandler
import multiprocessing
import os
import pathlib
import signal
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from typing import Any

from .target import KINDS, Fault, file_of, forbid_leaving, prepare, try_file

CHUNK = 200
SECONDS_A_FILE = 20.0
MEMORY = 6 << 30


@dataclass(frozen=True)
class Finding:
    """A file that was neither loaded nor refused as it should be."""

    number: int
    kind: str
    words: str


@dataclass
class Tally:
    """What came of the files: how many by kind and outcome, and the findings."""

    outcomes: collections.Counter = field(default_factory=collections.Counter)
    findings: list[Finding] = field(default_factory=list)

    @property
    def files(self) -> int:
        """How many files there were."""
        return sum(self.outcomes.values()) + len(self.findings)


def fuzz(
    files: int,
    *,
    jobs: int = 2,
    seed: int = 0,
    first: int = 0,
    progress: Callable[[int], object] | None = None,
) -> Tally:
    """Try files ``first`` to ``first + files``; ``progress`` gets the number that is done.

    A worker that dies takes one file with it; another goes on after it.
    """
    tally = Tally()
    chunks = iter(
        (begin, min(begin + CHUNK, first + files)) for begin in range(first, first + files, CHUNK)
    )
    with tempfile.TemporaryDirectory(prefix="impulsekit-fuzz-") as name:
        workers = [_Worker(pathlib.Path(name) / str(i), seed) for i in range(jobs)]
        try:
            _run(workers, chunks, tally, progress)
        finally:
            for worker in workers:
                worker.end()
    tally.findings.sort(key=lambda finding: finding.number)
    return tally


def _run(
    workers: list[_Worker],
    chunks: Iterator[tuple[int, int]],
    tally: Tally,
    progress: Callable[[int], object] | None,
) -> None:
    busy: dict[Any, _Worker] = {}
    for worker in workers:
        if (chunk := next(chunks, None)) is not None:
            worker.give(*chunk)
            busy[worker.pipe] = worker
    while busy:
        for pipe in wait(list(busy)):
            worker = busy.pop(pipe)
            free = worker.take(tally)
            if progress is not None:
                progress(tally.files)
            if not free:
                busy[worker.pipe] = worker
            elif (chunk := worker.left or next(chunks, None)) is not None:
                worker.give(*chunk)
                busy[worker.pipe] = worker


class _Worker:
    """One process and what it is at."""

    def __init__(self, folder: pathlib.Path, seed: int) -> None:
        self._folder, self._seed = folder, seed
        folder.mkdir()
        prepare(folder)
        self.left: tuple[int, int] | None = None
        self._start()

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self._at = context.Value("q", -1)
        self._process = context.Process(
            target=_work, args=(theirs, self._at, str(self._folder), self._seed), daemon=True
        )
        self._process.start()
        theirs.close()

    def give(self, begin: int, end: int) -> None:
        """Let it try some files."""
        self._end, self.left = end, None
        self.pipe.send((begin, end))

    def take(self, tally: Tally) -> bool:
        """Take what it tells; True where it is free again: all are done, or it has died."""
        try:
            message = self.pipe.recv()
        except EOFError:
            self._process.join()
            number = int(self._at.value)
            code = self._process.exitcode or 0
            died = signal.Signals(-code).name if code < 0 else f"exit status {code}"
            dump = (self._folder / "stderr").read_text(errors="replace")[:1500]
            tally.findings.append(
                Finding(number, KINDS[number % len(KINDS)], f"the process died: {died}\n{dump}")
            )
            self.pipe.close()
            self._start()
            self.left = (number + 1, self._end) if number + 1 < self._end else None
            return True
        if message is None:
            return True
        outcomes, findings = message
        tally.outcomes.update(outcomes)
        tally.findings += findings
        return False

    def end(self) -> None:
        """Stop the process."""
        self._process.kill()
        self._process.join()
        self.pipe.close()


def _work(pipe: Connection, at: Any, name: str, seed: int) -> None:
    """What a worker does: try files until it is told no more."""
    folder = pathlib.Path(name)
    # What C++ writes goes to a file, as does the stack of a crash.
    stderr = (folder / "stderr").open("w+")
    os.dup2(stderr.fileno(), 2)
    os.dup2(stderr.fileno(), 1)
    faulthandler.enable(stderr)
    _limit_memory()
    forbid_leaving(folder)
    while True:
        try:
            begin, end = pipe.recv()
        except EOFError:
            return
        for number in range(begin, end):
            at.value = number
            kind, content = file_of(seed, number)
            # A worker that hangs ends itself, in whatever language it hangs.
            faulthandler.dump_traceback_later(SECONDS_A_FILE, exit=True, file=stderr)
            outcomes: dict[tuple[str, str], int] = {}
            findings: list[Finding] = []
            try:
                outcomes = {(kind, try_file(folder, kind, content, number)): 1}
            except Fault as fault:
                findings = [Finding(number, kind, str(fault))]
            except (Exception, SystemExit) as error:
                last = "".join(traceback.format_tb(error.__traceback__)[-3:])
                words = f"{type(error).__name__}: {str(error)[:500]}\n{last}"
                findings = [Finding(number, kind, words)]
            faulthandler.cancel_dump_traceback_later()
            pipe.send((outcomes, findings))
            stderr.seek(0)
            stderr.truncate()
        pipe.send(None)


def _limit_memory() -> None:
    if sys.platform == "linux":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
